//! Pictures straight from data, scenes without a camera, options beside a scene, and films.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::frames::turntable;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{SceneOverrides, compose_scene, read_scene};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz_tests::npy;
use tempfile::TempDir;

use crate::program;
use crate::program::{file, program, run};

/// A folder with grains: `radius.npy` of 7 columns, `points.npy` of 3, `grains.csv`, `water.xyz`.
fn data() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let count = ["generate", "cloud", "--count", "300", "--distribution", "packing", "-q"];
    run(&[&count[..], &["-o", &file(&folder, "radius.npy")]].concat(), 0);
    let grid = (0..27).map(|i: i32| [i % 3, i / 3 % 3, i / 9].map(|k| 0.5 * f64::from(k)).to_vec());
    let points: Vec<Vec<f64>> = grid.collect();
    fs::write(file(&folder, "points.npy"), npy(&points, "<f8", false)).unwrap();
    fs::write(file(&folder, "grains.csv"), "x,y,z,r\n0,0,0,1\n2,0,0,1\n0,3,1,0.5\n").unwrap();
    fs::write(file(&folder, "water.xyz"), "3\nwater\nO 0 0 0\nH 0.76 0.59 0\nH -0.76 0.59 0\n")
        .unwrap();
    folder
}

const DATA: [&str; 4] = ["radius.npy", "points.npy", "grains.csv", "water.xyz"];

fn render(args: &[&str], code: i32) -> program::Ran {
    let small = ["--size", "96x64", "--device", "cpu"];
    run(&[&["render"][..], args, &small].concat(), code)
}

#[test]
fn all_that_is_there_is_in_the_picture() {
    let folder = data();
    for name in DATA {
        for view in ["quarter", "iso", "x", "-x", "y", "-y", "z", "-z"] {
            for lens in [["--fov", "30"], ["--height", "auto"]] {
                let scene = file(&folder, "framed.toml");
                let print = format!("--print-scene={scene}");
                let args = [&file(&folder, name), "--view", view, "--margin", "0.05", &print];
                render(&[&args[..], &lens].concat(), 0);
                let scene = read_scene(scene.as_ref()).unwrap();
                let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
                let rays = Rays::Pixels(session.pixels(96, 64).unwrap());
                let (mut hits, control) = (Hits::default(), Control::default());
                session.trace(&rays, Wants::default(), &control, &mut hits).unwrap();
                let ids = hits.id;
                let seen = |x: usize, y: usize| ids[y * 96 + x] > 0;
                // 0.05 of 64 rows are 3.2 pixels.
                let is_edge = |x, y| x < 3 || y < 3 || x >= 93 || y >= 61;
                let is_near = |x, y| x < 5 || y < 5 || x >= 91 || y >= 59;
                let all = || (0..64).flat_map(|y| (0..96).map(move |x| (x, y)));
                let case = format!("{name} {view} {lens:?}");
                assert!(!all().any(|(x, y)| is_edge(x, y) && seen(x, y)), "{case}: cut off");
                assert!(all().any(|(x, y)| is_near(x, y) && seen(x, y)), "{case}: too small");
            }
        }
    }
}

fn frames(folder: &TempDir, stem: &str) -> BTreeSet<PathBuf> {
    let files = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.file_name().unwrap().to_str().unwrap().starts_with(stem)).collect()
}

/// The tree over many spheres is that of the first frame in all others.
#[test]
fn a_film_has_one_tree() {
    let folder = tempfile::tempdir().unwrap();
    let data = file(&folder, "many.npy");
    run(&["generate", "cloud", "--count", "20000", "-q", "-o", &data], 0);
    let overrides = SceneOverrides { n_turns: 3, ..SceneOverrides::default() };
    let scene = compose_scene(data.as_ref(), &overrides, &Control::default()).unwrap().scene;
    let cameras = turntable(scene.camera.as_ref().unwrap(), 3);
    let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
    let trees = cameras.iter().map(|camera| {
        let rays = Rays::Pixels(Pixels::whole(View::new(camera), 96, 64));
        session.make_ready(&rays, Wants::default(), &Control::default()).unwrap();
        Arc::clone(&session.prepared().unwrap().hierarchy.as_ref().unwrap().bvh)
    });
    let trees: Vec<_> = trees.collect();
    assert!(trees.iter().all(|tree| Arc::ptr_eq(tree, &trees[0])));
}

#[cfg(unix)]
#[test]
fn an_interrupted_film_leaves_whole_frames_and_goes_on() {
    let folder = data();
    let (data, out) = (file(&folder, "radius.npy"), file(&folder, "film.ppm"));
    let film =
        ["render", &data, "-o", &out, "--turntable", "400", "--device", "cpu", "--size", "200x120"];
    let mut child = program(&film).spawn().unwrap();
    let start = Instant::now();
    while frames(&folder, "film-").len() < 3 {
        assert!(start.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(id, rustix::process::Signal::INT).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130));
    let whole = frames(&folder, "film-");
    assert!(whole.len() < 400);
    for file in &whole {
        assert_eq!(fs::metadata(file).unwrap().len(), 15 + 3 * 200 * 120, "{}", file.display());
    }
    assert!(frames(&folder, ".kugelblitz").is_empty());
    let before = fs::metadata(file(&folder, "film-0001.ppm")).unwrap().modified().unwrap();
    let last = (whole.len() + 2).to_string();
    let frames_asked = format!("1-{last}");
    run(&[&film[..], &["--resume", "--frames", &frames_asked]].concat(), 0);
    assert_eq!(frames(&folder, "film-").len(), whole.len() + 2);
    let after = fs::metadata(file(&folder, "film-0001.ppm")).unwrap().modified().unwrap();
    assert_eq!(before, after);
}
