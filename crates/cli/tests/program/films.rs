//! Films: one tree for all frames, and whole frames where they end early. What becomes of data and options stands in
//! `tests/answers/data.txt`.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::frames::turntable;
use kugelblitz::query::{Kernel, Outputs, Rays};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{SceneOverrides, compose_scene};
use tempfile::TempDir;

use crate::program::{file, program, run};

fn frames(folder: &TempDir, stem: &str) -> BTreeSet<PathBuf> {
    let files = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.file_name().unwrap().to_str().unwrap().starts_with(stem)).collect()
}

/// The tree over many spheres is that of the first frame in all others.
#[test]
fn a_film_has_one_tree() {
    let folder = tempfile::tempdir().unwrap();
    let data = file(&folder, "many.npy");
    run(&["generate", "--count", "20000", "-q", "-o", &data], 0);
    let overrides = SceneOverrides { n_turns: 3, ..SceneOverrides::default() };
    let scene = compose_scene(data.as_ref(), &overrides, &Control::default()).unwrap().scene;
    let cameras = turntable(scene.camera.as_ref().unwrap(), 3);
    let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
    let trees = cameras.iter().map(|camera| {
        let rays = Rays::Pixels(Pixels::whole(View::new(camera), 96, 64));
        session.make_ready(&rays, Outputs::default(), &Control::default()).unwrap();
        Arc::clone(&session.prepared().unwrap().hierarchy.as_ref().unwrap().bvh)
    });
    let trees: Vec<_> = trees.collect();
    assert!(trees.iter().all(|tree| Arc::ptr_eq(tree, &trees[0])));
}

#[cfg(unix)]
#[test]
fn an_interrupted_film_leaves_whole_frames_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let (data, out) = (file(&folder, "grains.npy"), file(&folder, "film.ppm"));
    run(&["generate", "--count", "300", "-q", "-o", &data], 0);
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
