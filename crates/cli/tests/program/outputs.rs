//! Output files: in their places last of all, whole or not at all, and never over an input.

use std::env;
use std::fs::{self, File};
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use kugelblitz::scene::read_scene;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::program;

fn program(folder: &TempDir, arguments: &[&str]) -> Command {
    let mut command = program::program(arguments);
    command.current_dir(folder);
    command
}

#[track_caller]
fn ends(command: Command, code: i32) -> String {
    program::ends(command, code).stderr
}

fn names(folder: &TempDir) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| name(entry).into_string().unwrap()).collect();
    names.sort();
    names
}

const BALL: &str = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n[image]\nwidth = 64\n\
                    height = 36\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\ncolor = \"#d62728\"\n";

/// A folder with a scene, a scene of a cloud, the cloud, and a ray.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("ball.toml"), BALL).unwrap();
    let made = ["generate", "cloud", "--count", "9", "-o", "cloud.npy", "--scene", "cloud.toml"];
    ends(program(&folder, &made), 0);
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 6), }";
    let mut rays = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    rays.extend(format!("{header:<117}\n").as_bytes());
    rays.extend([0.0, 0.0, 5.0, 0.0, 0.0, -1.0].into_iter().flat_map(f64::to_le_bytes));
    fs::write(at("rays.npy"), rays).unwrap();
    folder
}

const REPORT: [&str; 10] = [
    "report",
    "ball.toml",
    "--device",
    "cpu",
    "--kernel",
    "stable",
    "--size",
    "16x9",
    "--rounds",
    "1",
];

#[test]
fn a_summary_that_cannot_be_printed_leaves_the_old_output() {
    let folder = folder();
    let report = [&REPORT[..], &["-o", "out.html"]].concat();
    for (size, name) in [("64x36", "a.npy"), ("64x36", "b.npy")] {
        let kernel = if name == "a.npy" { "certified" } else { "lecture" };
        let render = ["render", "ball.toml", "-o", name, "--size", size, "--kernel", kernel];
        ends(program(&folder, &[&render[..], &["--device", "cpu", "-q"]].concat()), 0);
    }
    let judge = ["judge", "ball.toml", "--against", "b.npy", "--device", "cpu", "-o", "out.png"];
    let compare = ["compare", "a.npy", "b.npy", "-o", "out.png"];
    let cases: [(&[&str], &str); 10] = [
        (&judge, "out.png"),
        (&[&judge[..], &["--json"]].concat(), "out.png"),
        (&compare, "out.png"),
        (&[&compare[..], &["--json"]].concat(), "out.png"),
        (&["render", "ball.toml", "-o", "out.png", "--device", "cpu", "--json"], "out.png"),
        (
            &[
                "trace",
                "ball.toml",
                "--rays",
                "rays.npy",
                "-o",
                "out.npy",
                "--device",
                "cpu",
                "--json",
            ],
            "out.npy",
        ),
        (&["generate", "cloud", "--count", "9", "-o", "out.npy", "--json"], "out.npy"),
        (&["export", "pov", "ball.toml", "-o", "out.pov", "--json"], "out.pov"),
        (&report, "out.html"),
        (
            &["generate", "cloud", "--count", "9", "-o", "c.npy", "--scene", "out.toml", "--json"],
            "out.toml",
        ),
    ];
    for (arguments, out) in cases {
        let out = folder.path().join(out);
        fs::write(&out, "old").unwrap();
        let mut command = program(&folder, arguments);
        command.stdout(File::create("/dev/full").unwrap());
        ends(command, 1);
        assert_eq!(fs::read(&out).unwrap(), b"old", "{arguments:?}");
    }
    assert!(!folder.path().join("c.npy").exists());
    // Printed, the same commands do replace it.
    for arguments in [&judge[..], &compare] {
        fs::write(folder.path().join("out.png"), "old").unwrap();
        program::finish(program(&folder, arguments));
        assert_ne!(fs::read(folder.path().join("out.png")).unwrap(), b"old", "{arguments:?}");
    }
}

#[test]
fn of_several_outputs_none_is_changed_where_one_fails() {
    let folder = folder();
    symlink("/dev/full", folder.path().join("full.md")).unwrap();
    symlink("/dev/full", folder.path().join("full.toml")).unwrap();
    let before = names(&folder);
    let cloud = ["generate", "cloud", "--count", "9", "-o", "new.npy", "--scene"];
    let stderr = ends(program(&folder, &[&cloud[..], &["nodir/s.toml"]].concat()), 1);
    assert!(stderr.contains("nodir"), "{stderr}");
    let stderr = ends(program(&folder, &[&cloud[..], &["full.toml"]].concat()), 1);
    assert!(stderr.contains("full.toml"), "{stderr}");
    let report = [&REPORT[..], &["-o", "new.html", "-o", "full.md"]].concat();
    let stderr = ends(program(&folder, &report), 1);
    assert!(stderr.contains("full.md"), "{stderr}");
    assert_eq!(names(&folder), before);
}

#[test]
fn an_interrupt_amid_repeated_tracing_leaves_the_old_picture() {
    let folder = folder();
    let out = folder.path().join("out.png");
    fs::write(&out, "old").unwrap();
    let render = ["render", "ball.toml", "-o", "out.png", "--device", "cpu", "--json"];
    let child = program(&folder, &[&render[..], &["--repeat", "100000000"]].concat()).spawn();
    let mut child = child.unwrap();
    std::thread::sleep(Duration::from_millis(700));
    assert!(child.try_wait().unwrap().is_none(), "ended on its own");
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("no output file was changed"), "{stderr}");
    assert_eq!(fs::read(&out).unwrap(), b"old");
}

#[test]
fn links_stay_also_where_they_lead_nowhere_yet() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("deep")).unwrap();
    symlink("deep/second", at("first.png")).unwrap();
    symlink("third.png", at("deep/second")).unwrap();
    for _ in 0..2 {
        ends(program(&folder, &["render", "ball.toml", "-o", "first.png", "--device", "cpu"]), 0);
        assert_eq!(fs::read_link(at("first.png")).unwrap(), Path::new("deep/second"));
        assert_eq!(fs::read_link(at("deep/second")).unwrap(), Path::new("third.png"));
        assert!(fs::symlink_metadata(at("deep/third.png")).unwrap().is_file());
    }
    symlink("nowhere/x.png", at("lost.png")).unwrap();
    let lost = ["render", "ball.toml", "-o", "lost.png", "--device", "cpu"];
    let stderr = ends(program(&folder, &lost), 1);
    assert!(stderr.contains("there is no folder") && stderr.contains("nowhere"), "{stderr}");
}

#[test]
fn permissions_stay_and_new_files_have_those_of_the_umask() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let render = ["render", "ball.toml", "-o", "out.png", "--device", "cpu"];
    let mode = || fs::metadata(at("out.png")).unwrap().permissions().mode() & 0o7777;
    ends(program(&folder, &render), 0);
    fs::write(at("other"), "").unwrap();
    assert_eq!(mode(), fs::metadata(at("other")).unwrap().permissions().mode() & 0o7777);
    for kept in [0o600, 0o640, 0o666, 0o755] {
        fs::set_permissions(at("out.png"), fs::Permissions::from_mode(kept)).unwrap();
        ends(program(&folder, &render), 0);
        assert_eq!(mode(), kept);
    }
}

#[test]
fn an_output_over_an_input_or_another_output_is_refused() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    symlink("ball.toml", at("ball.png")).unwrap();
    symlink("cloud.toml", at("scene.npy")).unwrap();
    fs::create_dir(at("sub")).unwrap();
    symlink("..", at("sub/up")).unwrap();
    let contents = || -> Vec<(String, Vec<u8>)> {
        let files = names(&folder).into_iter().filter(|name| at(name).is_file());
        files.map(|name| (name.clone(), fs::read(at(&name)).unwrap())).collect()
    };
    let before = contents();
    let generate =
        |out, scene| vec!["generate", "cloud", "--count", "9", "-o", out, "--scene", scene];
    let trace =
        |out| vec!["trace", "cloud.toml", "--rays", "rays.npy", "-o", out, "--device", "cpu"];
    let report = |more: &[&'static str]| [&REPORT[..], more].concat();
    let cases = [
        vec!["render", "ball.toml", "-o", "ball.png", "--device", "cpu"],
        vec!["render", "ball.toml", "-o", "ball.toml", "--format", "png", "--device", "cpu"],
        vec!["render", "cloud.toml", "-o", "cloud.npy", "--device", "cpu"],
        trace("rays.npy"),
        trace("cloud.npy"),
        trace("scene.npy"),
        trace("sub/../rays.npy"),
        generate("new.npy", "new.npy"),
        generate("new.npy", "sub/up/new.npy"),
        generate("cloud.npy", "./cloud.npy"),
        vec!["export", "pov", "ball.toml", "-o", "ball.toml"],
        vec!["export", "pov", "cloud.toml", "-o", "cloud.npy"],
        report(&["-o", "new.md", "-o", "./new.md"]),
    ];
    for arguments in cases {
        let stderr = ends(program(&folder, &arguments), 2);
        assert!(stderr.contains("another file"), "{arguments:?}: {stderr}");
        assert_eq!(contents(), before, "{arguments:?}");
    }
    // What keeps nothing may be named twice.
    symlink("/dev/null", at("a.md")).unwrap();
    symlink("/dev/null", at("b.md")).unwrap();
    ends(program(&folder, &report(&["-o", "a.md", "-o", "b.md"])), 0);
}

#[test]
fn an_unusable_tmpdir_is_named() {
    let folder = folder();
    // EXR goes back in its file, which a pipe can't.
    let mut command = program(&folder, &["render", "ball.toml", "-o", "-", "--format", "exr"]);
    command.args(["--device", "cpu"]).env("TMPDIR", "/no/such/place");
    let stderr = ends(command, 1);
    assert!(stderr.contains("/no/such/place") && stderr.contains("TMPDIR"), "{stderr}");
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
    let folder = folder();
    fs::write(folder.path().join("out.ppm"), "old").unwrap();
    let before = names(&folder);
    let render = ["render", "ball.toml", "-o", "out.ppm", "--size", "20000x20000"];
    let mut command = program(&folder, &[&render[..], &["--device", "cpu"]].concat());
    let mut child = command.spawn().unwrap();
    wait_for_writing(&mut child, folder.path());
    child.kill().unwrap();
    child.wait().unwrap();
    let left: Vec<_> = names(&folder).into_iter().filter(|name| !is_hidden(name)).collect();
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
        let made = ["generate", "cloud", "--count", count, "-o", "c.npy", "--scene", "s.toml"];
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
        let names_before = names(&folder);
        let mut child = generate(new).spawn().unwrap();
        // Some wherever it is, most where it puts files in their places.
        let mut delay = whole.mul_f64(rng.random());
        if kill % 4 > 0 {
            let start = Instant::now();
            while names(&folder) == names_before && child.try_wait().unwrap().is_none() {
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
    let left: Vec<_> = names(&folder).into_iter().filter(|name| !is_hidden(name)).collect();
    assert_eq!(left, ["c.npy", "s.toml"]);
    assert_eq!(counts_of(folder.path(), "at the end"), ("300".into(), "300".into()));
}
