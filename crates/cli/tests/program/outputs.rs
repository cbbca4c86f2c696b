//! Output files of a program that is killed: in their places last of all, whole or not at all. What else is told of them
//! stands in `tests/answers/outputs.txt`.

use std::env;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use kugelblitz::scene::read_scene;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

use crate::program::{self, ends, names, scene_file};

fn program(folder: &TempDir, arguments: &[&str]) -> Command {
    let mut command = program::program(arguments);
    command.current_dir(folder);
    command
}

/// Waits until the program has a file open in the folder for writing.
fn wait_for_writing(child: &mut Child, folder: &Path) {
    let folder = fs::canonicalize(folder).unwrap();
    let fds = PathBuf::from(format!("/proc/{}/fd", child.id()));
    let start = Instant::now();
    loop {
        assert!(start.elapsed() < Duration::from_secs(60), "no file is written");
        assert!(child.try_wait().unwrap().is_none(), "ended on its own");
        let begun = fs::read_dir(&fds).into_iter().flatten().flatten().any(|entry| {
            let is_here = fs::read_link(entry.path()).is_ok_and(|file| file.starts_with(&folder));
            is_here && fs::metadata(entry.path()).is_ok_and(|file| file.size() > 0)
        });
        if begun {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn is_hidden(name: &str) -> bool {
    name.starts_with(".kugelblitz-") && name.ends_with(".tmp")
}

#[test]
fn a_killed_run_leaves_the_old_output() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("out.ppm"), "old").unwrap();
    let before = names(folder.path());
    let render = ["render", &scene_file("figure1"), "-o", "out.ppm", "--size", "20000x20000"];
    let mut command = program(&folder, &[&render[..], &["--device", "cpu"]].concat());
    let mut child = command.spawn().unwrap();
    wait_for_writing(&mut child, folder.path());
    child.kill().unwrap();
    child.wait().unwrap();
    let left: Vec<_> = names(folder.path()).into_iter().filter(|name| !is_hidden(name)).collect();
    assert_eq!(left, before);
    assert_eq!(fs::read(folder.path().join("out.ppm")).unwrap(), b"old");
}

/// The count that the scene in this folder tells, and that of the spheres it has.
#[track_caller]
fn counts_of(folder: &Path, after: &str) -> (String, String) {
    let path = folder.join("s.toml");
    let text = fs::read_to_string(&path).unwrap();
    let told = text.split_once("--count ").unwrap().1.split(' ').next().unwrap();
    let scene = read_scene(&path).unwrap_or_else(|error| panic!("{after}: {error}"));
    (told.into(), scene.spheres.len().to_string())
}

/// `KUGELBLITZ_KILLS` asks for more of them.
#[test]
fn killed_amid_two_files_each_is_whole_and_a_new_scene_has_its_own_cloud() {
    let n_kills = env::var("KUGELBLITZ_KILLS").map_or(30, |n| n.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let generate = |count: &str| {
        let made = ["generate", "--count", count, "-o", "c.npy", "--scene", "s.toml"];
        program(&folder, &made)
    };
    ends(generate("300"), 0);
    let start = Instant::now();
    ends(generate("300"), 0);
    let whole = start.elapsed();
    let mut rng = ChaCha8Rng::seed_from_u64(24);
    let (mut n_amid, mut n_old, mut n_mixed) = (0, 0, 0);
    for kill in 0..n_kills {
        let (old, has) = counts_of(folder.path(), "before");
        if old != has {
            ends(generate(&old), 0);
        }
        let new = if old == "300" { "400" } else { "300" };
        let names_before = names(folder.path());
        let mut child = generate(new).spawn().unwrap();
        // Some wherever it is, most where it puts files in their places.
        let mut delay = whole.mul_f64(rng.random());
        if kill % 4 > 0 {
            let start = Instant::now();
            while names(folder.path()) == names_before && child.try_wait().unwrap().is_none() {
                assert!(start.elapsed() < Duration::from_secs(60), "nothing is written");
            }
            delay /= 4;
        }
        // Sleep takes longer than some of what is done meanwhile.
        let start = Instant::now();
        while start.elapsed() < delay {
            std::hint::spin_loop();
        }
        child.kill().unwrap();
        n_amid += usize::from(!child.wait().unwrap().success());
        let (told, has) = counts_of(folder.path(), &format!("kill {kill}"));
        assert!(told == old || told == new && has == new, "kill {kill}: {told} of {has}");
        assert!(has == old || has == new, "kill {kill}: {has}");
        n_old += usize::from(told == old);
        n_mixed += usize::from(told != has);
    }
    println!(
        "{n_kills} kills: {n_amid} amid the work; {n_old} left the old scene, {n_mixed} of them with new data"
    );
    ends(generate("300"), 0);
    let left: Vec<_> = names(folder.path()).into_iter().filter(|name| !is_hidden(name)).collect();
    assert_eq!(left, ["c.npy", "s.toml"]);
    assert_eq!(counts_of(folder.path(), "at the end"), ("300".into(), "300".into()));
}
