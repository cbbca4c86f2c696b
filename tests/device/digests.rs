//! The digests of all scenes are those of `tests/digests.txt`, on the CPU and on the device, whatever
//! its driver.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::Kernel;
use kugelblitz::scene::read_scene;
use kugelblitz_tests::{DIGEST_SIZE, digests, gpu, root};

fn scenes() -> PathBuf {
    root().join("scenes")
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
    let pixels = session.pixels(DIGEST_SIZE[0], DIGEST_SIZE[1]).unwrap();
    session.digest(&pixels, n_samples, &Control::default()).unwrap()
}

fn assert_written(device: &Device) {
    let found: BTreeMap<String, String> = names_below(&scenes())
        .into_iter()
        .map(|name| (name.clone(), digest(&name, device.clone())))
        .collect();
    assert!(found.len() >= 35, "{}", found.len());
    assert_eq!(found, digests(), "on {}", device.label());
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
            assert_eq!(found, digests()[name], "{name}, {n_threads} threads");
        }
    }
}
