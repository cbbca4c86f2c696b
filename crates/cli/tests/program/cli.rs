//! The program on the device of the tests: what it says of it, how it is chosen, and how it is verified. What it answers on the
//! CPU stands in `tests/answers`.

use std::fs;
use std::process::Command;

use kugelblitz::query::Kernel;
use kugelblitz_tests::{gpu, runs};
use serde_json::{Value, json};

use crate::program::{ends, file, program, run, scene_file as scene};

#[test]
fn the_device_is_told() {
    let facts = gpu().facts.clone();
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (scene("figure1"), file(&folder, "a.png"));
    let render = |more: &[&str]| {
        let small = ["render", &scene, "-o", &out, "--size", "160x90"];
        // Verbose shows the driver's own lines, so not by `run`, which forbids them.
        let output = program(&[&small[..], more].concat()).output().unwrap();
        assert!(output.status.success());
        (output.stdout, String::from_utf8(output.stderr).unwrap())
    };
    // Of so small a picture, the CPU is quicker than a device in software.
    let device = if facts.is_software() { "the CPU" } else { &facts.name };
    let (_, said) = render(&[]);
    assert!(said.contains(&format!("6 spheres, 2 planes, certified on {device}")), "{said}");
    let (_, said) = render(&["--device", "gpu"]);
    assert!(said.contains(&facts.name), "{said}");
    assert_eq!(said.contains("(software)"), facts.is_software(), "{said}");
    let why = "for `certified` the CPU is quicker than a device in software";
    assert_eq!(render(&["-v"]).1.contains(why), facts.is_software());
    let (_, said) = render(&["-v", "--device", "gpu"]);
    let would = format!(
        "note: `--device auto` would trace on the CPU: there is no GPU in hardware here, and {why}"
    );
    assert_eq!(said.contains(&would), facts.is_software(), "{said}");
    assert!(said.contains(&format!("note: opened {}", facts.name)), "{said}");
    assert!(said.contains(&facts.driver) && said.contains(facts.kind), "{said}");

    let (json, said) = render(&["-q", "--device", "gpu", "--json"]);
    let json: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((said.as_str(), &json["device"]), ("", &"gpu".into()));
    assert_eq!(json["adapter"]["name"], facts.name.as_str());
    assert_eq!(
        (&json["adapter"]["type"], &json["rays"]["total"]),
        (&facts.kind.into(), &(160 * 90).into())
    );
    assert!(json["ms"]["trace"].as_f64().is_some_and(|ms| ms > 0.0));

    let json = run(&["probe", "--json"], 0).json();
    let first = &json["adapters"][0];
    assert_eq!(first["name"], facts.name.as_str());
    assert_eq!(
        (&first["type"], &first["passthrough"]),
        (&facts.kind.into(), &facts.passthrough.into())
    );
    let arithmetic = gpu().arithmetic().unwrap();
    assert_eq!(first["arithmetic"]["f32"], serde_json::to_value(arithmetic).unwrap());
    assert_eq!(
        (&first["f64"], first["arithmetic"]["f64"].is_object()),
        (&facts.f64.into(), facts.f64)
    );
    assert_eq!(first["arithmetic"]["certified_on_device"], arithmetic.suits_filter());
    let ran = run(&["probe"], 0);
    assert!(ran.text().contains(&facts.name) && ran.text().contains("NoContraction"));
    assert_eq!(ran.text().contains("software"), facts.is_software());
}

#[test]
fn an_adapter_is_chosen_by_name() {
    let adapter = gpu().facts.name.clone();
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (scene("figure5"), file(&folder, "a.png"));
    let part = adapter.split_whitespace().next().unwrap().to_uppercase();
    let of = |device: &str, environment: &str, code: i32| {
        let args = ["render", &scene, "-o", &out, "--size", "16x9", "--json", "-q", "--device"];
        let mut command = program(&[&args[..], &[device]].concat());
        if !environment.is_empty() {
            command.env("WGPU_ADAPTER_NAME", environment);
        }
        ends(command, code)
    };
    let other = "no such adapter";
    assert_eq!(of(&part, "", 0).json()["adapter"]["name"], adapter.as_str());
    assert_eq!(of("gpu", &part, 0).json()["adapter"]["name"], adapter.as_str());
    assert!(of(other, "", 4).stderr.contains(&adapter));
    of("gpu", other, 4);
    assert_eq!(of("auto", other, 0).json()["device"], "cpu");
    of(&part, other, 0);
}

/// Both devices against each other and against exact arithmetic, unlit and lit with samples.
#[test]
fn verify_compares_devices_and_what_is_exact() {
    let facts = gpu().facts.clone();
    let is_ieee = gpu().is_ieee(Kernel::Stable).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let lit = file(&folder, "lit.toml");
    let text = r##"
        ambient = 0.1
        image = { width = 40, height = 24, samples = 2 }
        camera = { position = [0, 1.5, 5], look_at = [0, 0.5, 0] }
        light = [{ position = [4, 6, 3], intensity = 0.9 }]
        sky = { intensity = 0.25, directions = 3 }
        sphere = [{ center = [0, 1, 0], radius = 1, color = "#d62728" }]
        plane = [{ point = [0, 0, 0], normal = [0, 1, 0], color = "#bbbbbb" }]
    "##;
    fs::write(&lit, text).unwrap();
    for (scene, pixels) in [(&scene("figure5"), 160 * 90), (&lit, 40 * 24)] {
        let size = if pixels == 160 * 90 { "160x90" } else { "40x24" };
        let json = run(&["verify", scene, "--size", size, "--all-kernels", "--json"], 0).json();
        assert_eq!(json["samples"], pixels);
        let kernels = json["kernels"].as_array().unwrap();
        assert_eq!(kernels.len(), 4);
        for kernel in kernels {
            let name = kernel["kernel"].as_str().unwrap();
            let is_certified = name == "certified";
            let is_on_gpu = name != "double" || runs(Kernel::Double);
            assert_eq!(kernel["against_exact"]["cpu"]["rays"], pixels);
            assert_eq!(kernel["gpu_against_cpu"]["rays"] == pixels, facts.f64 || name != "double");
            if is_ieee || is_certified {
                assert_eq!(kernel["gpu_against_cpu"]["first"], Value::Null);
            }
            // f32 kernels are not exact: a comparison that finds them so compares nothing.
            if ["lecture", "stable"].contains(&name) {
                assert!(kernel["against_exact"]["cpu"]["t_ulp_max"].as_f64().unwrap() > 0.5);
            }
            let Some(colors) = kernel.get("colors") else { continue };
            let exact = &colors["against_exact"];
            let n_of = |found: &Value| (found["pixels"].clone(), found["linear"].as_u64());
            let (cpu, gpu) = (n_of(&exact["cpu"]), n_of(&exact["gpu"]));
            assert_eq!((&cpu.0, cpu.1 == Some(0)), (&pixels.into(), is_certified), "{colors}");
            assert_eq!(gpu.0 == pixels && colors["gpu_against_cpu"]["pixels"] == pixels, is_on_gpu);
            let equal =
                json!({"pixels": pixels, "srgb8": 0, "srgb16": 0, "linear": 0, "first": null});
            let is_exact = [&exact["cpu"], &exact["gpu"]].iter().all(|found| **found == equal);
            assert_eq!(is_exact, is_certified, "{colors}");
            let promise = kernel["promise"].as_str().unwrap();
            assert_eq!(promise.contains("every byte"), is_certified, "{promise}");
        }
        assert_eq!(kernels[0].get("colors").is_some(), *scene == lit);
        let text = run(&["verify", scene, "--size", size], 0);
        assert!(text.text().contains("GPU") && text.text().contains("kept"), "{}", text.text());
    }
}

/// `compare` prints commands that explain its rays with its own options of the camera and of data, however they were written.
#[test]
fn printed_commands_explain_what_was_compared() {
    let folder = tempfile::tempdir().unwrap();
    let table = "a,b,c,my size,it's\n0,0,0,1,1\n1,2,3,0.5,2\n-2,1,0,0.75,3\n";
    fs::write(folder.path().join("-three.csv"), table).unwrap();
    let in_folder = |args: &[&str]| {
        let mut command = program(args);
        command.current_dir(&folder);
        command
    };
    let data = ["--columns", "x=a,y=b", "--columns=z=c,radius=my size", "--color-by", "it's"];
    let render = ["render", "./-three.csv", "--size", "32x18", "-o", "a.exr", "-q", "--device=cpu"];
    ends(in_folder(&[&render[..], &data].concat()), 0);
    for look in [
        &["--view", "-x", "--up=-z", "--margin=0.2", "--fov", "25"][..],
        &["--position=-9,1,2", "--look-at", "-2,1,0", "--height", "3"],
    ] {
        let options = [&data[..], look, &["--device=cpu"]].concat();
        let compare = ["compare", "./-three.csv", "a.exr", "-q"];
        let compared = ends(in_folder(&[&compare[..], &options].concat()), 6);
        let lines = compared.text().lines();
        let commands: Vec<&str> = lines
            .filter_map(|line| line.find("kugelblitz explain").map(|at| &line[at..]))
            .collect();
        assert!(commands.len() > 1, "{}", compared.text());
        for line in commands {
            let mut shell = Command::new("bash");
            let script = "kugelblitz() { \"$0\" \"$@\" --device cpu --json; }; eval \"$1\"";
            shell.args(["-c", script, env!("CARGO_BIN_EXE_kugelblitz"), line]).current_dir(&folder);
            let printed = ends(shell, 0).json();
            let pixel = line.split(" --pixel ").nth(1).unwrap().split(' ').next().unwrap();
            let explain = ["explain", "./-three.csv", "--json", "--size=32x18", "--pixel", pixel];
            let wanted = ends(in_folder(&[&explain[..], &options].concat()), 0).json();
            assert_eq!(printed["explanation"], wanted["explanation"], "{line}");
            let elsewhere = [&explain[..], &data, &["--view", "z", "--device=cpu"]].concat();
            let elsewhere = ends(in_folder(&elsewhere), 0).json();
            assert_ne!(printed["explanation"], elsewhere["explanation"], "{line}");
        }
    }
}
