//! The digests of all scenes are those of `tests/digests.toml`, on the CPU and on the device, whatever
//! its driver.

mod common;
#[path = "common/program.rs"]
mod program;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use common::gpu;
use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::digest::PREFIX;
use kugelblitz::scene::read_scene;
use kugelblitz::trace::Kernel;
use program::{run, scene_file};

/// Columns and rows of the pictures.
const SIZE: [u32; 2] = [96, 54];

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// The names of all scenes below a folder of `scenes/`: `figure1`, `lit/hard/shells`.
fn names_below(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            names.extend(names_below(&path));
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            let name = path.strip_prefix(scenes()).unwrap().with_extension("");
            names.push(name.to_str().unwrap().to_string());
        }
    }
    names
}

fn digest(name: &str, device: Device) -> String {
    let scene = read_scene(&scenes().join(format!("{name}.toml"))).unwrap();
    let n_samples = scene.samples.unwrap_or_default();
    let mut session = Session::new(scene, device, Kernel::Certified);
    let pixels = session.pixels(SIZE[0], SIZE[1]).unwrap();
    session.digest(&pixels, n_samples, &Control::default()).unwrap()
}

fn written() -> BTreeMap<String, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/digests.toml");
    toml::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn table(digests: &BTreeMap<String, String>) -> String {
    digests.iter().map(|(name, digest)| format!("\"{name}\" = \"{digest}\"\n")).collect()
}

fn assert_written(device: &Device) {
    let found: BTreeMap<String, String> = names_below(&scenes())
        .into_iter()
        .map(|name| (name.clone(), digest(&name, device.clone())))
        .collect();
    assert!(found.len() >= 35, "{}", found.len());
    assert!(found == written(), "on {} the table has become\n{}", device.label(), table(&found));
}

#[test]
fn digests_on_the_device_are_the_written_ones() {
    assert_written(&Device::Gpu(gpu()));
}

#[test]
fn digests_on_the_cpu_are_the_written_ones() {
    assert_written(&Device::Cpu);
}

#[test]
fn digests_are_the_same_for_any_number_of_threads() {
    for n_threads in [1, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        for name in ["figure2", "lit/figure1", "clouds/caffeine"] {
            let found = pool.install(|| digest(name, Device::Cpu));
            assert_eq!(found, written()[name], "{name}, {n_threads} threads");
        }
    }
}

#[test]
fn the_program_prints_the_digest_alone() {
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let (scene, expected) = (scene_file("lit/figure1"), &written()["lit/figure1"]);
    assert!(expected.starts_with(PREFIX));
    for device in ["cpu", "gpu", "auto"] {
        let ran = run(&["digest", &scene, "--size", &size, "--device", device, "-q"], 0);
        assert_eq!(ran.text(), format!("{expected}\n"), "{device}");
    }
    let json = run(&["digest", &scene, "--size", &size, "--json"], 0).json();
    assert_eq!((&json["command"], &json["digest"]), (&"digest".into(), &expected.as_str().into()));
    assert_eq!(json["size"], serde_json::json!(SIZE));
    let other = |more: &[&str]| {
        let args = [&["digest", &scene, "--size", &size][..], more].concat();
        run(&args, 0).text().trim().to_string()
    };
    for more in [["--samples", "2"], ["--crop", "0,0,9,9"]] {
        assert_ne!(&other(&more), expected, "{more:?}");
    }
}
