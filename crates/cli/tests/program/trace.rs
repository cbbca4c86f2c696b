//! `kugelblitz trace`: rays in, hits out.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

use kugelblitz::trace::Kernel;
use kugelblitz_tests::{gpu, runs};
use tempfile::TempDir;

use crate::program::{ends as finish, program, run, scene_file as scene};

fn file(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

fn write_rays(path: &str, rays: &[[f64; 6]]) {
    let header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, 6), }}", rays.len());
    let header = format!("{header:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(rays.iter().flatten().flat_map(|value| value.to_le_bytes()));
    fs::write(path, bytes).unwrap();
}

/// Not each GPU has f64.
fn can(device: &str, kernel: &str) -> bool {
    device != "gpu" || kernel != "double" || runs(Kernel::Double)
}

#[test]
fn trace_gives_the_hits_of_any_rays() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    let (scene, rays) = (file(&folder, "no-camera.toml"), file(&folder, "rays.npy"));
    let ball = "[[sphere]]\ncenter = [0, 0, -5]\nradius = 1\ncolor = \"#ffffff\"\n";
    let floor = "[[plane]]\npoint = [0, -2, 0]\nnormal = [0, 3, 0]\ncolor = \"#888888\"\n";
    fs::write(&scene, format!("{ball}{floor}")).unwrap();
    write_rays(
        &rays,
        &[
            [0.0, 0.0, 0.0, 0.0, 0.0, -2.0],
            [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, -0.5, 0.0],
            [0.0, 0.0, -5.0, 0.0, 0.0, -0.25],
        ],
    );
    let up = [0.0_f32, 1.0, 0.0];
    let expected = [
        (1, 2.0_f32, [0.0, 0.0, 1.0]),
        (0, f32::INFINITY, [0.0; 3]),
        (2, 4.0, up),
        (1, 4.0, [0.0, 0.0, 1.0]),
    ];
    let all = [("cpu", "certified"), ("gpu", "certified"), ("cpu", "double"), ("gpu", "double")];
    for (device, kernel) in all.into_iter().filter(|(device, kernel)| can(device, kernel)) {
        let out = file(&folder, "hits.npy");
        let start = ["trace", &scene, "--rays", &rays, "--device", device, "--kernel", kernel];
        let ran = run(&[&start[..], &["-o", &out, "--json"]].concat(), 0);
        let json = ran.json();
        assert_eq!((&json["command"], &json["kernel"]), (&"trace".into(), &kernel.into()));
        assert_eq!((&json["rays"]["total"], &json["hits"]), (&4.into(), &3.into()));
        assert!(ran.stderr.contains("4 rays, 3 hits"), "{}", ran.stderr);

        let bytes = fs::read(&out).unwrap();
        let data = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let header = String::from_utf8_lossy(&bytes[..data]).into_owned();
        for part in ["'id'", "'<u4'", "'t'", "'normal'", "'<f4', (3,)", "'shape': (4,"] {
            assert!(header.contains(part), "{part}: {header}");
        }
        let (records, rest) = bytes[data..].as_chunks::<20>();
        assert_eq!((records.len(), rest.len()), (4, 0));
        for (record, (id, t, normal)) in records.iter().zip(expected) {
            let word = |i: usize| <[u8; 4]>::try_from(&record[4 * i..4 * i + 4]).unwrap();
            assert_eq!(u32::from_ne_bytes(word(0)), id, "{device}");
            assert_eq!(f32::from_ne_bytes(word(1)), t, "{device}");
            let found = [2, 3, 4].map(|i| f32::from_ne_bytes(word(i)));
            assert_eq!(found.map(|c| c + 0.0), normal, "{device}");
        }
        assert_eq!(run(&[&start[..], &["-o", "-"]].concat(), 0).stdout, bytes);
    }
}

#[test]
fn trace_refuses_what_is_not_rays() {
    let folder = tempfile::tempdir().unwrap();
    let (rays, out) = (file(&folder, "rays.npy"), file(&folder, "hits.npy"));
    let scene = scene("figure1");
    let args = ["trace", &scene, "--rays", &rays, "-o", &out, "--device", "cpu"];
    run(&args, 1);
    fs::write(&rays, "x,y,z\n").unwrap();
    assert!(run(&args, 1).stderr.contains("(N, 6)"));
    write_rays(&rays, &[[0.0; 6]]);
    assert!(run(&args, 1).stderr.contains("row 0"));
    assert!(!Path::new(&out).exists());
}

/// The shape that a file of hits tells.
fn shape_of(hits: &[u8]) -> String {
    let header = String::from_utf8_lossy(&hits[..hits.len().min(200)]).into_owned();
    let shape = header.split("'shape': ").nth(1).expect("a header with a shape");
    shape[..=shape.find(')').unwrap()].replace(' ', "")
}

/// No rays are no error, as no spheres are none: a script's last part may well be empty.
#[test]
fn zero_rays_give_zero_hits() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    let (rays, out) = (file(&folder, "rays.npy"), file(&folder, "hits.npy"));
    write_rays(&rays, &[]);
    let cloud = file(&folder, "cloud.toml");
    let npy = file(&folder, "cloud.npy");
    run_generate(&npy, &cloud);
    for scene in [scene("figure1"), scene("clouds/caffeine"), cloud] {
        for device in ["cpu", "gpu", "auto"] {
            for kernel in ["lecture", "stable", "double", "certified"] {
                if !can(device, kernel) {
                    continue;
                }
                let start = ["trace", &scene, "--rays", &rays, "-o", &out, "--device", device];
                let ran = run(&[&start[..], &["--kernel", kernel, "--json"]].concat(), 0);
                let json = ran.json();
                assert_eq!((&json["rays"]["total"], &json["hits"]), (&0.into(), &0.into()));
                let hits = fs::read(&out).unwrap();
                assert_eq!(shape_of(&hits), "(0,)", "{scene} {device} {kernel}");
                assert_eq!(hits.len() % 64, 0, "something follows the header");
            }
        }
    }
}

/// More spheres than a list of rays is tested against one after the other.
fn run_generate(npy: &str, scene: &str) {
    run(&["generate", "cloud", "--count", "300", "-o", npy, "--scene", scene, "-q"], 0);
}

#[test]
fn rays_come_from_standard_input_too() {
    let folder = tempfile::tempdir().unwrap();
    let (rays, out) = (file(&folder, "rays.npy"), file(&folder, "hits.npy"));
    let some: Vec<[f64; 6]> =
        (0..5000).map(|i| [0.0, 1.0, 6.0, f64::from(i) * 1e-4 - 0.25, -0.1, -1.0]).collect();
    write_rays(&rays, &some);
    let scene = scene("figure1");
    run(&["trace", &scene, "--rays", &rays, "-o", &out, "--device", "cpu", "-q"], 0);
    let expected = fs::read(&out).unwrap();

    let filter = ["trace", &scene, "--rays", "-", "-o", "-", "--device", "cpu", "-q"];
    let from = |input: Stdio, code: i32| {
        let mut command = program(&filter);
        command.stdin(input);
        finish(command, code)
    };
    // A file, and a pipe, which has no length.
    assert_eq!(from(File::open(&rays).unwrap().into(), 0).stdout, expected);
    let mut cat = Command::new("cat").arg(&rays).stdout(Stdio::piped()).spawn().unwrap();
    assert_eq!(from(cat.stdout.take().unwrap().into(), 0).stdout, expected);
    assert!(cat.wait().unwrap().success());

    let ran = from(Stdio::null(), 1);
    assert!(ran.stderr.contains("standard input: not a readable .npy file"), "{}", ran.stderr);
    let cut = file(&folder, "cut.npy");
    fs::write(&cut, &fs::read(&rays).unwrap()[..1000]).unwrap();
    let ran = from(File::open(&cut).unwrap().into(), 1);
    assert!(ran.stderr.contains("standard input: the file ends before row"), "{}", ran.stderr);
    // A header that promises more than there can be is not believed.
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (100000000000000, 6), }";
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{header:<117}\n").bytes());
    fs::write(&cut, bytes).unwrap();
    let ran = from(File::open(&cut).unwrap().into(), 7);
    assert!(ran.stderr.contains("100000000000000 rows"), "{}", ran.stderr);
}

#[test]
fn hits_go_into_npy_alone() {
    let folder = tempfile::tempdir().unwrap();
    let rays = file(&folder, "rays.npy");
    write_rays(&rays, &[[0.0, 1.0, 6.0, 0.0, 0.0, -1.0]]);
    let scene = scene("figure1");
    for name in ["hits.csv", "hits", "hits.npz", "npy", ".npy"] {
        let out = file(&folder, name);
        let ran = run(&["trace", &scene, "--rays", &rays, "-o", &out, "--device", "cpu"], 2);
        assert!(ran.stderr.contains(&out) && ran.stderr.contains(".npy"), "{}", ran.stderr);
        assert!(!Path::new(&out).exists(), "{name}");
    }
    for name in ["hits.npy", "hits.NPY"] {
        let out = file(&folder, name);
        run(&["trace", &scene, "--rays", &rays, "-o", &out, "--device", "cpu"], 0);
        assert!(fs::read(&out).unwrap().starts_with(b"\x93NUMPY"));
    }
}
