//! The program as its users meet it: the real binary, its files, its streams, its exit codes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use kugelblitz::scene::{Color, Edges, Sphere};
use kugelblitz::trace::Kernel;
use kugelblitz_tests::{gpu, runs};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{finish, program, run, scene_file as scene};

/// A driver that isn't there.
fn without_driver(args: &[&str]) -> Command {
    let mut command = program(args);
    command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
    command
}

fn file(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

fn names(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

/// All keys of an object, nested ones as `outer.inner`; those of lists as `list[]`.
fn keys(value: &Value, prefix: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let dot = if prefix.is_empty() { "" } else { "." };
                let key = format!("{prefix}{dot}{key}");
                keys(value, &key, found);
                found.insert(key);
            }
        }
        Value::Array(list) => {
            for value in list {
                keys(value, &format!("{prefix}[]"), found);
            }
        }
        _ => {}
    }
}

#[track_caller]
fn assert_keys(value: &Value, expected: &str) {
    let mut found = BTreeSet::new();
    keys(value, "", &mut found);
    let expected: BTreeSet<String> = expected.split_whitespace().map(str::to_owned).collect();
    assert_eq!(found, expected);
}

const RENDER_KEYS: &str = "schema version command adapter device kernel size \
    objects objects.spheres objects.planes rays rays.total rays.f32 rays.f64 rays.exact hits \
    bytes_device ms ms.read ms.prepare ms.build ms.upload ms.compile ms.trace ms.refine \
    ms.decide ms.readback ms.shade ms.write ms.total";
const ADAPTER_KEYS: &str = "adapter.name adapter.type adapter.driver";

#[test]
fn the_default_device_renders_and_says_what_it_did() {
    let facts = gpu().facts.clone();
    let folder = tempfile::tempdir().unwrap();
    let out = file(&folder, "figure1.png");
    let ran = run(&["render", &scene("figure1"), "-o", &out], 0);
    assert_eq!(ran.stdout, b"");
    let line = ran.stderr.strip_suffix('\n').unwrap();
    assert!(!line.contains('\n'), "{line}");
    // Of so small a picture, the CPU is quicker than a device in software.
    let device = if facts.is_software() { "the CPU" } else { &facts.name };
    let start = format!("{out}: 1280×720, 6 spheres, 2 planes, certified on {device}");
    assert!(line.starts_with(&format!("{start}, in ")) && line.ends_with("ms"), "{line}");
    let ran = run(&["render", &scene("figure1"), "-o", &out, "--device", "gpu"], 0);
    assert!(ran.stderr.contains(&facts.name), "{}", ran.stderr);
    assert_eq!(ran.stderr.contains("(software)"), facts.is_software(), "{}", ran.stderr);

    let picture = image::open(&out).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (1280, 720));
    assert_eq!(picture.get_pixel(5, 5).0, [0xb8, 0xa6, 0x8f], "the back wall");
    assert_eq!(picture.get_pixel(5, 700).0, [0x8c, 0x8c, 0x8c], "the floor");
    assert_eq!(picture.get_pixel(400, 300).0, [0xd6, 0x27, 0x28], "the red sphere");
}

#[test]
fn quiet_is_quiet_and_verbose_names_the_driver() {
    let facts = gpu().facts.clone();
    let folder = tempfile::tempdir().unwrap();
    let out = file(&folder, "a.png");
    let ran = run(&["render", &scene("figure1"), "-o", &out, "--size", "16x9", "-q"], 0);
    assert_eq!((ran.stdout.len(), ran.stderr.as_str()), (0, ""));
    // Verbose shows the driver's own lines, so not by `run`, which forbids them.
    let verbose = |device| {
        let args =
            ["render", &scene("figure1"), "-o", &out, "--size", "16x9", "-v", "--device", device];
        String::from_utf8(program(&args).output().unwrap().stderr).unwrap()
    };
    let why = "for `certified` the CPU is quicker than a device in software";
    assert_eq!(verbose("auto").contains(why), facts.is_software());
    let stderr = verbose("gpu");
    let would = format!(
        "note: `--device auto` would trace on the CPU: there is no GPU in hardware here, and {why}"
    );
    assert_eq!(stderr.contains(&would), facts.is_software(), "{stderr}");
    assert!(stderr.contains(&format!("note: opened {}", facts.name)), "{stderr}");
    assert!(stderr.contains(&facts.driver) && stderr.contains(facts.kind), "{stderr}");
}

#[test]
fn both_devices_and_all_kernels_write_the_same_picture() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    // Elsewhere plain kernels may differ.
    let has_equal =
        |kernel: &Kernel| *kernel == Kernel::Certified || gpu().is_ieee(*kernel).unwrap();
    for kernel in Kernel::ALL.into_iter().filter(has_equal).map(Kernel::name) {
        let pictures = ["cpu", "gpu"].map(|device| {
            let out = file(&folder, "a.npy");
            let args = ["--device", device, "--kernel", kernel, "--size", "120x80", "-q"];
            run(&[&["render", &scene("figure3"), "-o", &out][..], &args].concat(), 0);
            fs::read(out).unwrap()
        });
        assert!(pictures[0] == pictures[1], "{kernel}");
    }
}

#[test]
fn render_json_has_the_keys_of_the_contract() {
    let facts = gpu().facts.clone();
    let folder = tempfile::tempdir().unwrap();
    let out = file(&folder, "a.png");
    let scene = scene("figure2");
    let start = ["render", &scene, "-o", &out, "--size", "160x90", "--json", "-q", "--device"];

    let json = run(&[&start[..], &["gpu"]].concat(), 0).json();
    assert_keys(&json, &format!("{RENDER_KEYS} {ADAPTER_KEYS}"));
    assert_eq!(json["schema"], 1);
    assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(json["command"], "render");
    assert_eq!(json["adapter"]["name"], facts.name.as_str());
    assert_eq!(json["adapter"]["type"], facts.kind);
    assert_eq!(json["device"], "gpu");
    assert_eq!(json["kernel"], "certified");
    assert_eq!(json["size"], serde_json::json!([160, 90]));
    assert_eq!(json["objects"], serde_json::json!({"spheres": 4, "planes": 0}));
    assert_eq!(json["rays"]["total"], 160 * 90);
    assert!(json["hits"].as_u64().is_some_and(|hits| hits > 1000 && hits < 160 * 90));
    assert!(json["ms"]["trace"].as_f64().is_some_and(|ms| ms > 0.0));

    let json = run(&[&start[..], &["cpu", "--repeat", "3"]].concat(), 0).json();
    let runs = "ms_runs ms_runs[].trace ms_runs[].refine ms_runs[].decide ms_runs[].readback";
    assert_keys(&json, &format!("{RENDER_KEYS} {runs}"));
    assert_eq!(json["adapter"], Value::Null);
    assert_eq!(json["device"], "cpu");
    assert_eq!(json["ms_runs"].as_array().unwrap().len(), 3);
}

#[test]
fn every_format_is_written_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene("figure1");
    let render = |name: &str, more: &[&str]| {
        let out = file(&folder, name);
        let args = ["render", &scene, "-o", &out, "--size", "64x36", "--device", "cpu"];
        run(&[&args[..], more].concat(), 0);
        out
    };
    let png = image::open(render("a.png", &[])).unwrap();
    let ppm = image::open(render("a.ppm", &[])).unwrap();
    assert_eq!(png.as_rgb8().unwrap().as_raw(), ppm.as_rgb8().unwrap().as_raw());
    let deep = image::open(render("b.png", &["--bits", "16"])).unwrap();
    let deep = deep.as_rgb16().unwrap();
    assert_eq!(deep.get_pixel(1, 1).0, [0xb8 * 257, 0xa6 * 257, 0x8f * 257]);

    let npy = fs::read(render("a.npy", &[])).unwrap();
    let header_bytes = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert_eq!(npy.len() - header_bytes, 64 * 36 * 32);
    assert_eq!(npy[header_bytes..header_bytes + 4], 8u32.to_ne_bytes(), "the back wall's id");

    let exr = render("a.exr", &["--crop", "10,20,30,8", "--certificates"]);
    let meta = exr::meta::MetaData::read_from_file(&exr, true).unwrap();
    let header = &meta.headers[0];
    let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names, ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "id", "level"]);
    assert_eq!(header.own_attributes.layer_position, exr::math::Vec2(10, 20));
    assert_eq!(header.layer_size, exr::math::Vec2(30, 8));
    assert_eq!(header.shared_attributes.display_window.size, exr::math::Vec2(64, 36));
}

#[test]
fn a_crop_is_the_same_part_of_the_whole() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    let (whole, part) = (file(&folder, "whole.png"), file(&folder, "part.png"));
    for device in ["cpu", "gpu"] {
        let render = |out: &str, more: &[&str]| {
            let args = ["--size", "301x173", "--device", device];
            let start = ["render", &scene("figure1"), "-o", out];
            run(&[&start[..], &args, more].concat(), 0);
            image::open(out).unwrap().into_rgb8()
        };
        let whole = render(&whole, &[]);
        let part = render(&part, &["--crop", "80,40,150,99"]);
        assert_eq!(part, image::imageops::crop_imm(&whole, 80, 40, 150, 99).to_image());
    }
}

#[test]
fn standard_output_takes_a_picture() {
    let start = ["render", &scene("figure5"), "-o", "-", "--size", "31x17", "--device", "cpu"];
    let ran = run(&[&start[..], &["--format", "ppm"]].concat(), 0);
    assert!(ran.stderr.starts_with("standard output: 31×17, "), "{}", ran.stderr);
    let picture = image::load_from_memory(&ran.stdout).unwrap();
    assert_eq!((picture.width(), picture.height()), (31, 17));
    let ran = run(&[&start[..], &["--format", "exr"]].concat(), 0);
    let meta = exr::meta::MetaData::read_from_buffered(ran.stdout.as_slice(), true).unwrap();
    assert_eq!(meta.headers[0].layer_size, exr::math::Vec2(31, 17));
}

#[test]
fn a_wrong_scene_exits_3_with_its_place_and_touches_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (wrong, out) = (file(&folder, "wrong.toml"), file(&folder, "out.png"));
    fs::write(&out, "old").unwrap();
    fs::write(&wrong, "[camera]\nposition = [0, 0, 0]\nlookat = [0, 0, -1]\n").unwrap();
    let ran = run(&["render", &wrong, "-o", &out], 3);
    for expected in [":3:1", "lookat = [0, 0, -1]", "did you mean `look_at`?"] {
        assert!(ran.stderr.contains(expected), "{expected}: {}", ran.stderr);
    }
    assert!(!ran.stderr.contains('\x1b'), "colour in a pipe: {}", ran.stderr);

    // What steers a terminal does not reach it.
    fs::write(&wrong, "background = \"\x1b[31m\"\n").unwrap();
    assert!(!run(&["check", &wrong], 3).stderr.contains('\x1b'));

    fs::write(&wrong, "background = \"#123456\"\n").unwrap();
    let ran = run(&["render", &wrong, "-o", &out], 3);
    assert!(ran.stderr.contains("no [camera]"), "{}", ran.stderr);
    let missing = file(&folder, "missing.toml");
    let ran = run(&["render", &missing, "-o", &out], 3);
    assert!(ran.stderr.contains("missing.toml: cannot read the scene"), "{}", ran.stderr);
    assert_eq!(fs::read(&out).unwrap(), b"old");
    assert_eq!(names(folder.path()).len(), 2);
}

/// One malformation of a scene's text.
fn mutate(text: &str, rng: &mut impl Rng) -> Vec<u8> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let line = rng.random_range(0..lines.len());
    let values =
        ["nan", "inf", "-1", "1e308", "-1e-320", "\"x\"", "true", "[]", "[1, 2]", "{}", "", "0"];
    match rng.random_range(0..6) {
        0 => drop(lines.remove(line)),
        1 => {
            let other = rng.random_range(0..lines.len());
            lines.swap(line, other);
        }
        2 | 3 => {
            if let Some((key, _)) = lines[line].clone().split_once('=') {
                lines[line] = format!("{key}= {}", values[rng.random_range(0..values.len())]);
            }
        }
        4 => {
            let copy = lines[line].clone();
            lines.insert(line, copy);
        }
        _ => {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..bytes.len());
                bytes[at] = rng.random();
            }
            let end = rng.random_range(0..=bytes.len());
            bytes.truncate(if rng.random_bool(0.3) { end } else { bytes.len() });
            return bytes;
        }
    }
    (lines.join("\n") + "\n").into_bytes()
}

#[test]
fn three_hundred_malformed_scenes_never_panic_nor_touch_the_output() {
    let folder = tempfile::tempdir().unwrap();
    let (path, out) = (file(&folder, "scene.toml"), file(&folder, "out.ppm"));
    let texts = ["figure1", "figure2", "figure5", "inside"].map(scene);
    let texts = texts.map(|path| fs::read_to_string(path).unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(300);
    let mut n_refused = 0;
    for i in 0..300 {
        let mut bytes = mutate(&texts[i % texts.len()], &mut rng);
        if rng.random_bool(0.3) {
            bytes = mutate(&String::from_utf8_lossy(&bytes).replace('\0', "?"), &mut rng);
        }
        fs::write(&path, &bytes).unwrap();
        fs::write(&out, "old").unwrap();
        let args = ["render", &path, "-o", &out, "--device", "cpu", "--size", "16x9"];
        let ran = finish(program(&args));
        let text = String::from_utf8_lossy(&bytes);
        let written = fs::read(&out).unwrap();
        match ran.code {
            0 => assert!(written.starts_with(b"P6\n16 9\n"), "mutant {i}:\n{text}"),
            3 => {
                n_refused += 1;
                assert_eq!(written, b"old", "mutant {i}:\n{text}");
            }
            code => panic!("mutant {i}: exit {code}: {}\n{text}", ran.stderr),
        }
    }
    assert!((100..300).contains(&n_refused), "{n_refused} of 300 refused");
    assert_eq!(names(folder.path()).len(), 2);
}

#[test]
fn no_adapter_exits_4_unless_the_device_is_auto() {
    let adapter = gpu().facts.name.clone();
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (scene("figure5"), file(&folder, "a.png"));
    let start = ["render", &scene, "-o", &out, "--size", "16x9", "--device"];
    let with = |device: &'static str| [&start[..], &[device]].concat();

    let ran = finish(without_driver(&with("gpu")));
    assert_eq!(ran.code, 4, "{}", ran.stderr);
    assert!(ran.stderr.contains("mesa-vulkan-drivers"), "{}", ran.stderr);
    let ran = run(&with("no such adapter"), 4);
    assert!(ran.stderr.contains(&adapter), "{}", ran.stderr);
    let ran = finish(without_driver(&["probe"]));
    assert_eq!((ran.code, ran.stdout.len()), (4, 0), "{}", ran.stderr);
    assert!(!Path::new(&out).exists());

    // A picture for which a device in software would be quicker, with --quiet as well: what traced is
    // not what was hoped for.
    let size = ["--size", "8192x4096", "--kernel", "stable"];
    let auto = [&["render", &scene, "-o", &out, "--device", "auto", "-q"][..], &size].concat();
    let ran = finish(without_driver(&auto));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
    assert!(ran.stderr.contains("on the CPU") && ran.stderr.contains("mesa-vulkan-drivers"));
    assert!(Path::new(&out).exists());
    // The CPU asks for no driver at all.
    let cpu = [&with("cpu")[..], &["-q"]].concat();
    let ran = finish(without_driver(&cpu));
    assert_eq!((ran.code, ran.stderr.as_str()), (0, ""));
}

#[test]
fn an_adapter_is_chosen_by_name() {
    let adapter = gpu().facts.name.clone();
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (scene("figure5"), file(&folder, "a.png"));
    let part = adapter.split_whitespace().next().unwrap().to_uppercase();
    let start = ["render", &scene, "-o", &out, "--size", "16x9", "--json", "-q", "--device"];
    let json = run(&[&start[..], &[&part]].concat(), 0).json();
    assert_eq!(json["adapter"]["name"], adapter.as_str());

    let in_environment = |device: &str, name: &str| {
        let mut command = program(&[&start[..], &[device]].concat());
        command.env("WGPU_ADAPTER_NAME", name);
        finish(command)
    };
    assert_eq!(in_environment("gpu", &part).json()["adapter"]["name"], adapter.as_str());
    assert_eq!(in_environment("gpu", "no such adapter").code, 4);
    assert_eq!(in_environment("auto", "no such adapter").json()["device"], "cpu");
    assert_eq!(in_environment(&part, "no such adapter").code, 0);
}

#[test]
fn what_cannot_be_written_exits_1_and_what_cannot_fit_exits_7() {
    let folder = tempfile::tempdir().unwrap();
    let out = file(&folder, "missing/a.png");
    let ran = run(&["render", &scene("figure5"), "-o", &out, "--device", "cpu"], 1);
    assert!(ran.stderr.contains("there is no folder"), "{}", ran.stderr);
    let full = ["-o", "/dev/full", "--format", "ppm", "--device", "cpu"];
    let ran = run(&[&["render", &scene("figure5")][..], &full].concat(), 1);
    assert!(ran.stderr.starts_with("error: /dev/full: "), "{}", ran.stderr);

    let out = file(&folder, "a.exr");
    let ran = run(&["render", &scene("figure5"), "-o", &out, "--size", "70000x70000"], 7);
    assert!(ran.stderr.contains("70000x70000") && ran.stderr.contains("32768"), "{}", ran.stderr);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn verify_compares_both_devices_with_each_other_and_with_exact_arithmetic() {
    let facts = gpu().facts.clone();
    let is_ieee = gpu().is_ieee(Kernel::Stable).unwrap();
    let scene = scene("figure5");
    let start = ["verify", &scene, "--size", "160x90", "--all-kernels"];
    let json = run(&[&start[..], &["--json"]].concat(), 0).json();
    let parity = "rays hit_or_miss other_object t_differs t_ulp_max normal_differs \
                  normal_distance_max first";
    let exact = "rays false_hits false_misses wrong_object t_ulp_max normal_distance_max normals_not_nearest \
                 first_wrong_id";
    let mut expected = format!(
        "schema version command adapter {ADAPTER_KEYS} device size objects objects.spheres \
         objects.planes rays samples seed kernels kernels[].kernel kernels[].promise \
         kernels[].gpu_against_cpu kernels[].against_exact kernels[].against_exact.gpu \
         kernels[].against_exact.cpu kernels[].broken"
    );
    for key in parity.split_whitespace() {
        expected += &format!(" kernels[].gpu_against_cpu.{key}");
    }
    for key in exact.split_whitespace() {
        expected += &format!(" kernels[].against_exact.gpu.{key}");
        expected += &format!(" kernels[].against_exact.cpu.{key}");
    }
    assert_keys(&json, &expected);
    assert_eq!(json["samples"], 160 * 90);
    let kernels = json["kernels"].as_array().unwrap();
    assert_eq!(kernels.len(), 4);
    for kernel in kernels {
        let name = kernel["kernel"].as_str().unwrap();
        assert_eq!(kernel["against_exact"]["cpu"]["rays"], 160 * 90);
        if facts.f64 || name != "double" {
            assert_eq!(kernel["gpu_against_cpu"]["rays"], 160 * 90);
        }
        if is_ieee || name == "certified" {
            assert_eq!(kernel["gpu_against_cpu"]["first"], Value::Null);
        }
        // f32 kernels are not exact: a comparison that finds them so compares nothing.
        if ["lecture", "stable"].contains(&name) {
            assert!(kernel["against_exact"]["cpu"]["t_ulp_max"].as_f64().unwrap() > 0.5);
        }
    }
    let text = run(&start, 0);
    for expected in
        ["all pixels against exact", "lecture", "stable", "double", "GPU", "CPU", "kept"]
    {
        assert!(text.text().contains(expected), "{expected}: {}", text.text());
    }
}

#[test]
fn verify_on_the_cpu_takes_a_seeded_share() {
    let scene = scene("figure1");
    let start = ["verify", &scene, "--device", "cpu", "--samples", "500", "--json", "--seed"];
    let of_seed = |seed| run(&[&start[..], &[seed]].concat(), 0).json();
    let json = of_seed("4");
    assert_eq!(json["samples"], 500);
    assert_eq!(json["seed"], 4);
    assert_eq!(json["kernels"][0]["gpu_against_cpu"], Value::Null);
    assert_eq!(json["kernels"][0]["against_exact"]["gpu"], Value::Null);
    assert_eq!(json["kernels"][0]["against_exact"]["cpu"]["rays"], 500);
    assert_eq!(json, of_seed("4"));
    assert_ne!(json["kernels"], of_seed("5")["kernels"]);
    let text = run(&["verify", &scene, "--device", "cpu", "--samples", "10"], 0);
    assert!(text.text().contains("10 of 921600 pixels (seed 0)"), "{}", text.text());
}

/// A lit scene of two samples a side: bytes and floats of both devices.
fn lit_scene(folder: &TempDir) -> String {
    let path = file(folder, "lit.toml");
    let text = r##"
        ambient = 0.1
        image = { width = 40, height = 24, samples = 2 }
        camera = { position = [0, 1.5, 5], look_at = [0, 0.5, 0] }
        light = [{ position = [4, 6, 3], intensity = 0.9 }]
        sky = { intensity = 0.25, directions = 3 }
        sphere = [{ center = [0, 1, 0], radius = 1, color = "#d62728" }]
        plane = [{ point = [0, 0, 0], normal = [0, 1, 0], color = "#bbbbbb" }]
    "##;
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn verify_compares_the_colours_of_lit_pictures() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    let scene = lit_scene(&folder);
    let json = run(&["verify", &scene, "--all-kernels", "--json"], 0).json();
    let pixels = 40 * 24;
    assert_eq!(json["samples"], pixels);
    for kernel in json["kernels"].as_array().unwrap() {
        let colors = &kernel["colors"];
        let exact = &colors["against_exact"];
        let is_on_gpu = kernel["kernel"] != "double" || runs(Kernel::Double);
        let all = match is_on_gpu {
            true => vec![&colors["gpu_against_cpu"], &exact["gpu"], &exact["cpu"]],
            false => vec![&exact["cpu"], &exact["cpu"]],
        };
        assert!(all.iter().all(|found| found["pixels"] == pixels), "{colors}");
        let equal = serde_json::json!(
            {"pixels": pixels, "srgb8": 0, "srgb16": 0, "linear": 0, "first": null}
        );
        let is_certified = kernel["kernel"] == "certified";
        // Kernels without a proof have other floats: a comparison that finds none compares nothing.
        assert_eq!(all[1..].iter().all(|found| **found == equal), is_certified, "{colors}");
        let promise = kernel["promise"].as_str().unwrap();
        assert_eq!(promise.contains("every byte"), is_certified, "{promise}");
    }
    let some = run(&["verify", &scene, "--device", "cpu", "--samples", "50", "--json"], 0).json();
    let colors = &some["kernels"][0]["colors"];
    assert_eq!(colors["gpu_against_cpu"], Value::Null);
    assert_eq!(colors["against_exact"]["cpu"]["pixels"], 50);
    let text = run(&["verify", &scene, "--size", "20x12"], 0);
    for expected in ["colours, GPU against CPU", "colours against exact", "every float"] {
        assert!(text.text().contains(expected), "{expected}: {}", text.text());
    }
}

#[test]
fn check_says_what_a_scene_costs() {
    let json = run(&["check", &scene("figure1"), "--size", "1920x1080", "--json"], 0).json();
    for key in ["schema", "version", "command", "objects", "bytes_device", "picture"] {
        assert!(json.get(key).is_some(), "{key}");
    }
    assert_eq!(json["objects"], serde_json::json!({"spheres": 6, "planes": 2}));
    assert_eq!(json["picture"]["rays"], 1920 * 1080);
    assert!(json["bytes_device"]["stable"].as_u64().unwrap() > 100);
    assert!(json["bytes_device"]["double"].as_u64() > json["bytes_device"]["stable"].as_u64());
    assert!(json["picture"]["bytes_memory"]["exr"].as_u64().unwrap() > 1920 * 1080 * 36);
    let text = run(&["check", &scene("figure1")], 0);
    assert!(text.text().contains("6 spheres, 2 planes"), "{}", text.text());
    assert_eq!(text.stderr, "");
    assert_eq!(json["clouds"], serde_json::json!([]));
    assert_eq!((&json["light"], &json["samples"]), (&Value::Null, &1.into()));
    assert!(!text.text().contains("lit by") && !text.text().contains("samples"));

    let json = run(&["check", &scene("lit/figure1"), "--json"], 0).json();
    let light = serde_json::json!({"lights": 2, "sky_directions": 0, "ambient": true});
    assert_eq!((&json["light"], &json["samples"]), (&light, &3.into()));
    let text = run(&["check", &scene("lit/figure1")], 0).text().to_string();
    assert!(text.contains("lit by 2 lights, ambient light\nsamples: 3 × 3 a pixel\n"), "{text}");
    let text = run(&["check", &scene("lit/caffeine")], 0).text().to_string();
    assert!(text.contains("lit by 1 light, a sky of 64 directions\n"), "{text}");
}

/// A ball's outline in a small picture: as many colours as there are shares of samples in it.
#[test]
fn samples_are_those_of_the_command_line_else_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "ball.toml");
    let ball = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n[[sphere]]\n\
                center = [0.1, 0, 0]\nradius = 1\ncolor = \"#ffffff\"\n[image]\n";
    let out = file(&folder, "out.npy");
    let reds = |samples: &str, options: &[&str]| -> BTreeSet<u32> {
        fs::write(&path, format!("{ball}{samples}")).unwrap();
        let start = ["render", &path, "-o", &out, "--size", "32x18", "--device", "cpu", "-q"];
        run(&[&start[..], options].concat(), 0);
        let bytes = fs::read(&out).unwrap();
        let records = bytes[bytes.len() - 32 * 18 * 32..].chunks_exact(32);
        records.map(|record| u32::from_le_bytes(record[20..24].try_into().unwrap())).collect()
    };
    let hard = BTreeSet::from([0.0_f32.to_bits(), 1.0_f32.to_bits()]);
    assert_eq!(reds("", &[]), hard);
    let soft = reds("samples = 2", &[]);
    let quarters = [0.0_f32, 0.25, 0.5, 0.75, 1.0].map(f32::to_bits);
    assert!(soft.len() > 3 && soft.is_subset(&BTreeSet::from(quarters)), "{soft:x?}");
    assert_eq!(reds("", &["--samples", "2"]), soft);
    assert_eq!(reds("samples = 2", &["--samples", "1"]), hard);
    assert!(reds("samples = 2", &["--samples", "16"]).len() > 8);
    for wrong in ["0", "17", "2.5", "many"] {
        let ran = run(&["render", &path, "-o", &out, "--samples", wrong], 2);
        assert!(ran.stderr.contains("--samples"), "{}", ran.stderr);
    }
}

/// Of a transparent picture with samples, lit or not: PNG, EXR and NPY tell the same, and where all
/// samples hit, the same as a picture with a background.
#[test]
fn a_transparent_picture_leaves_the_background_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "ball.toml");
    let [png, npy, opaque] = ["a.png", "a.npy", "b.npy"].map(|name| file(&folder, name));
    let ball = "background = \"#00ff00\"\n[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n\
                [[sphere]]\ncenter = [0.1, 0, 0]\nradius = 1\ncolor = [1, 0.5, 0.25]\n";
    let (width, height) = (64, 36);
    let floats = |path: &str, record_bytes: usize| -> Vec<Vec<f32>> {
        let bytes = fs::read(path).unwrap();
        let records = bytes[bytes.len() - width * height * record_bytes..].chunks(record_bytes);
        let words = |record: &[u8]| {
            record[20..].as_chunks().0.iter().copied().map(f32::from_le_bytes).collect()
        };
        records.map(words).collect()
    };
    for light in ["", "[[light]]\nposition = \"eye\"\nintensity = 0.75\n"] {
        fs::write(&path, format!("{ball}{light}")).unwrap();
        for (samples, n_shares) in [("1", 2), ("2", 5), ("3", 8)] {
            let render = |out: &str, options: &[&str]| {
                let start = ["render", &path, "-o", out, "--size", "64x36", "--device", "cpu"];
                run(&[&start[..], &["-q", "--samples", samples], options].concat(), 0);
            };
            render(&png, &["--transparent", "--bits", "16"]);
            render(&npy, &["--transparent"]);
            render(&opaque, &[]);
            let straight = image::open(&png).unwrap().into_rgba16();
            let (premultiplied, opaque) = (floats(&npy, 36), floats(&opaque, 32));
            let mut alphas = BTreeSet::new();
            for (i, straight) in straight.pixels().enumerate() {
                let [red, green, blue, alpha] = premultiplied[i][..] else { panic!("a record") };
                alphas.insert(alpha.to_bits());
                assert_eq!(straight.0[3], (alpha * 65535.0).round() as u16);
                if alpha == 1.0 {
                    assert_eq!([red, green, blue], opaque[i][..]);
                } else {
                    // The rest of the samples is green.
                    let sum = [red, green + (1.0 - alpha), blue];
                    assert!(sum.iter().zip(&opaque[i]).all(|(a, b)| (a - b).abs() < 1e-6));
                }
                for (channel, part) in [red, green, blue].into_iter().enumerate() {
                    let linear = if alpha == 0.0 { 0.0 } else { f64::from(part / alpha) };
                    let code = i32::from(Edges::srgb16().number(linear));
                    assert!((code - i32::from(straight.0[channel])).abs() <= 1, "{i} {channel}");
                }
            }
            assert!(alphas.len() >= n_shares, "{} of {samples} × {samples}", alphas.len());
        }
    }
    let ppm = file(&folder, "a.ppm");
    let ran = run(&["render", &path, "-o", &ppm, "--transparent"], 2);
    assert!(ran.stderr.contains(".png, .exr or .npy"), "{}", ran.stderr);
}

/// A sphere on a floor in f32, whose surfaces shadow themselves without an epsilon.
#[test]
fn an_epsilon_is_for_kernels_without_a_proof() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.ppm", "b.ppm"].map(|name| file(&folder, name));
    let lit = scene("lit/hard/contacts");
    let render = |out: &str, options: &[&str]| {
        let start = ["render", &lit, "-o", out, "--size", "96x54", "--device", "cpu"];
        run(&[&start[..], options].concat(), 0);
        fs::read(out).unwrap()
    };
    let plain = render(&a, &["--kernel", "stable"]);
    assert_eq!(plain, render(&b, &["--kernel", "stable", "--epsilon", "0"]));
    let moved = render(&b, &["--kernel", "stable", "--epsilon", "1e-4"]);
    let certified = render(&a, &[]);
    let n_wrong = |bytes: &[u8]| bytes.iter().zip(&certified).filter(|(a, b)| a != b).count();
    assert!(n_wrong(&moved) < n_wrong(&plain) / 4, "{} {}", n_wrong(&moved), n_wrong(&plain));

    let refused = |options: &[&str]| {
        let start = ["render", &lit, "-o", &a, "--device", "cpu"];
        run(&[&start[..], options].concat(), 2).stderr
    };
    let why = refused(&["--epsilon", "1e-4"]);
    assert!(why.contains("decides exactly") && why.contains("--kernel"), "{why}");
    for wrong in ["-1", "nan", "inf", "small"] {
        let why = refused(&["--kernel", "stable", "--epsilon", wrong]);
        assert!(why.contains("--epsilon"), "{why}");
    }
    let unlit = ["render", &scene("figure1"), "-o", &b, "--size", "9x9", "--device", "cpu"];
    let ran = run(&[&unlit[..], &["--kernel", "stable", "--epsilon", "1"]].concat(), 0);
    assert!(ran.stderr.contains("the scene has no light"), "{}", ran.stderr);
}

#[test]
fn clouds_are_rendered_checked_and_refused_with_both_places() {
    let folder = tempfile::tempdir().unwrap();
    let caffeine = scene("clouds/caffeine");
    let json = run(&["check", &caffeine, "--json"], 0).json();
    let file = caffeine.replace("toml", "xyz");
    let expected = serde_json::json!([{"file": file, "spheres": 24, "first_id": 1}]);
    assert_eq!(json["clouds"], expected);
    let sphere_bytes = size_of::<Sphere>() + size_of::<Color>();
    assert_eq!(json["bytes_scene"], 24 * sphere_bytes);
    let text = run(&["check", &caffeine], 0);
    assert!(text.text().contains(&format!("{file}: 24 spheres, from id 1")), "{}", text.text());

    let out = self::file(&folder, "a.png");
    run(&["render", &caffeine, "-o", &out, "--size", "96x54", "--device", "cpu"], 0);
    let picture = image::open(&out).unwrap().into_rgb8();
    for color in [[0xff, 0xff, 0xff], [0x90, 0x90, 0x90], [0x30, 0x50, 0xf8], [0xff, 0x0d, 0x0d]] {
        assert!(picture.pixels().any(|pixel| pixel.0 == color), "{color:x?}");
    }

    let wrong = self::file(&folder, "wrong.toml");
    fs::write(&wrong, "[[spheres]]\nfile = \"wrong.xyz\"\n").unwrap();
    fs::write(self::file(&folder, "wrong.xyz"), "1\n\nCa 0 0 zero\n").unwrap();
    fs::write(&out, "old").unwrap();
    let ran = run(&["render", &wrong, "-o", &out], 3);
    for expected in ["wrong.toml:2:8: ", "wrong.xyz: line 3: \"zero\"", "help: "] {
        assert!(ran.stderr.contains(expected), "{expected}: {}", ran.stderr);
    }
    assert_eq!(fs::read(&out).unwrap(), b"old");
}

#[test]
fn probe_lists_the_adapters() {
    let facts = gpu().facts.clone();
    let json = run(&["probe", "--json"], 0).json();
    assert_eq!(json["command"], "probe");
    let first = &json["adapters"][0];
    assert_eq!(first["name"], facts.name.as_str());
    assert_eq!(first["type"], facts.kind);
    assert_eq!(first["passthrough"], facts.passthrough);
    assert_eq!(first["f64"], facts.f64);
    let arithmetic = gpu().arithmetic().unwrap();
    assert_eq!(first["arithmetic"]["f32"], serde_json::to_value(arithmetic).unwrap());
    assert_eq!(first["arithmetic"]["f64"].is_object(), facts.f64);
    assert_eq!(first["arithmetic"]["certified_on_device"], arithmetic.suits_filter());
    let ran = run(&["probe"], 0);
    assert!(ran.text().contains(&facts.name) && ran.text().contains("NoContraction"));
    assert_eq!(ran.text().contains("software"), facts.is_software());
    assert_eq!(ran.stderr, "");
}

#[test]
fn help_completions_and_manual_are_there() {
    for command in [
        "render",
        "verify",
        "check",
        "trace",
        "explain",
        "generate",
        "digest",
        "probe",
        "completions",
        "man",
    ] {
        let help = run(&[command, "--help"], 0);
        assert!(help.text().contains("Usage: kugelblitz"), "{command}");
        let page = run(&["man", command], 0);
        assert!(page.text().contains(&format!("kugelblitz\\-{command}")), "{}", page.text());
    }
    assert!(run(&["--version"], 0).text().contains(env!("CARGO_PKG_VERSION")));
    assert!(run(&["--help"], 0).text().contains("130  interrupted"));
    let page = run(&["man"], 0);
    assert!(page.text().contains(".TH kugelblitz") && page.text().contains("verify"));
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        assert!(run(&["completions", shell], 0).text().contains("all-kernels"), "{shell}");
    }
}

#[test]
fn report_measures_what_it_is_given_and_writes_every_form() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name| file(&folder, name);
    let scene = &*scene("figure2");
    let (html, svg, md, json) = (at("r.html"), at("r.svg"), at("r.md"), at("r.json"));
    let arguments = [
        "report",
        scene,
        "--device",
        "cpu",
        "--kernel",
        "stable",
        "--kernel",
        "certified",
        "--size",
        "48x27",
        "--rounds",
        "1",
        "--json",
        "-o",
        &html,
        "-o",
        &svg,
        "-o",
        &md,
        "-o",
        &json,
    ];
    let printed = run(&arguments, 0).json();
    let written: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
    assert_eq!(printed, written);
    assert_eq!((&printed["schema"], &printed["command"]), (&2.into(), &"report".into()));
    let rows = printed["rows"].as_array().unwrap();
    let rows: Vec<_> = rows.iter().filter(|row| row["of"] == "scene").collect();
    let kernels: Vec<_> = rows.iter().map(|row| row["kernel"].as_str().unwrap()).collect();
    assert_eq!(kernels, ["stable", "certified"]);
    assert_eq!(rows[1]["counts"]["rays"], 48 * 27);
    assert!(fs::read_to_string(&html).unwrap().starts_with("<!DOCTYPE html>"));
    assert!(fs::read_to_string(&svg).unwrap().starts_with("<svg"));
    assert!(fs::read_to_string(&md).unwrap().contains("| certified | CPU |"));
}

#[test]
fn report_refuses_what_it_cannot_write_before_it_measures() {
    let scene = &*scene("figure2");
    for (arguments, code, says) in [
        (vec!["report", scene, "-o", "report.pdf"], 2, ".html"),
        (vec!["report", scene, "-o", "no/such/folder/report.html"], 1, "no/such/folder"),
        (vec!["report", "no-such-scene.toml"], 3, "no-such-scene.toml: cannot read the scene"),
        (vec!["report", scene, "--rounds", "0"], 2, "--rounds"),
        (vec!["report", scene, "--samples", "0"], 2, "--samples"),
    ] {
        let ran = run(&arguments, code);
        assert!(ran.stderr.contains(says), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stdout.is_empty());
    }
}
