//! Ctrl-C and SIGTERM end every command amid every long phase, with 130 and no file changed.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Error;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, WorldRay};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::{camera, gpu, in_cube, npy_of_rays, sphere};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::program::{self, file, names, scene_file as scene};

/// A second is promised; the rest is for machines that run many tests at once.
const BOUND: Duration = Duration::from_secs(5);

/// With one thread, so that what takes long does so on every machine.
fn program() -> Command {
    let mut command = program::program(&[]);
    command.env("RAYON_NUM_THREADS", "1");
    command
}

/// A folder with what takes long: a million spheres, and two million rays.
struct Large {
    folder: TempDir,
    scene: String,
    rays: String,
}

fn large() -> &'static Large {
    static LARGE: OnceLock<Large> = OnceLock::new();
    LARGE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let [cloud, scene, rays] =
            ["cloud.npy", "scene.toml", "rays.npy"].map(|name| file(&folder, name));
        program::run(&["generate", "--count", "1000000", "-o", &cloud, "--scene", &scene], 0);
        let turned = (0..2_000_000).map(|i| f64::from(i) / 2e6);
        let all: Vec<_> = turned.map(|x| [x, 0.1, 5.0, 0.3 - x, 0.02, -1.0]).collect();
        fs::write(&rays, npy_of_rays(&all)).unwrap();
        Large { folder, scene, rays }
    })
}

/// Sends one signal after `delay` and looks at the program's end.
///
/// # Returns
/// False where the program was no more at work.
#[track_caller]
#[must_use]
fn ends(mut child: Child, what: &str, delay: Duration, signal: Signal) -> bool {
    std::thread::sleep(delay);
    if let Some(status) = child.try_wait().unwrap() {
        println!("{what}: ended on its own within {delay:?}");
        assert!(status.success(), "{what}: {status}");
        return false;
    }
    kill_process(Pid::from_child(&child), signal).unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > BOUND {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{what}: still at work {BOUND:?} after the signal");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let took = start.elapsed();
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    println!("{what}: ended after {took:?}");
    assert_eq!(output.status.code(), Some(130), "{what}: {} {stderr}", output.status);
    // Work that did not end by itself says nothing there.
    if what.contains("--json") && !output.stdout.is_empty() {
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((&json["code"], &json["error"]), (&130.into(), &"interrupted".into()), "{what}");
    }
    // Of output files speaks who has some.
    let has_outputs =
        !["info", "verify", "probe"].iter().any(|name| what.contains(&format!("\"{name}\"")));
    let speaks = stderr.contains("no output file was changed");
    assert_eq!(speaks, has_outputs, "{what}: {stderr}");
    assert_eq!(stderr.matches("interrupted").count(), 1, "{what}: {stderr}");
    true
}

/// Interrupts a command that has `out` as its output, in a folder of its own.
#[track_caller]
#[must_use]
fn is_interrupted(arguments: &[&str], out: &str, delay: Duration) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(out);
    fs::write(&path, "old").unwrap();
    let child = program().args(arguments).current_dir(&folder).spawn().unwrap();
    let what = format!("{arguments:?} at {delay:?}");
    if !ends(child, &what, delay, Signal::INT) {
        return false;
    }
    assert_eq!(fs::read(&path).unwrap(), b"old", "{what}");
    assert_eq!(names(folder.path()), [out], "{what}");
    true
}

/// Commands that are at work for long, each with its output and moments amid its phases, in milliseconds; without, at parts
/// of the time that it takes here.
#[test]
fn commands_end_amid_each_phase() {
    gpu();
    let Large { scene: million, rays, .. } = large();
    let figure = &scene("figure1");
    let cases = [
        (format!("render {million} -o a.png --device cpu --kernel lecture"), "a.png", &[2500][..]),
        (format!("render {million} -o a.png --device cpu --kernel double"), "a.png", &[2500]),
        (format!("render {million} -o a.png --device gpu --kernel lecture"), "a.png", &[3000]),
        (format!("render {million} -o a.png --device gpu --kernel double"), "a.png", &[3000]),
        (format!("render {figure} -o a.ppm --size 20000x20000 --device cpu"), "a.ppm", &[1500]),
        (format!("render {figure} -o a.ppm --size 20000x20000 --device gpu"), "a.ppm", &[1500]),
        // Repeated tracing.
        (
            format!("render {figure} -o a.png --size 64x36 --device cpu --json --repeat 100000000"),
            "a.png",
            &[700],
        ),
        // Reading, then the building of a hierarchy, then tracing: whichever it is at the time.
        (
            format!("render {million} -o a.npy --size 16000x16000 --device cpu"),
            "a.npy",
            &[150, 500, 1000, 1500],
        ),
        (
            format!("verify {figure} --size 16000x16000 --samples 100000000 --device cpu --json"),
            "other",
            &[1000],
        ),
        ("generate --count 100000000 -o cloud.npy".into(), "cloud.npy", &[500]),
        (format!("info {million}"), "other", &[]),
        (format!("trace {million} --rays {rays} -o hits.npy --device cpu"), "hits.npy", &[]),
    ];
    for (command, out, moments) in &cases {
        let arguments: Vec<&str> = command.split(' ').collect();
        for &moment in *moments {
            let is_interrupted = is_interrupted(&arguments, out, Duration::from_millis(moment));
            assert!(is_interrupted, "{command} ended on its own");
        }
        if !moments.is_empty() {
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let start = Instant::now();
        assert!(program().args(&arguments).current_dir(&folder).status().unwrap().success());
        let whole = start.elapsed();
        for part in [0.1, 0.3, 0.5, 0.7] {
            // Another run may be quicker.
            let mut delay = whole.mul_f64(part);
            while !is_interrupted(&arguments, out, delay) {
                delay /= 2;
                assert!(!delay.is_zero(), "{command} always ends on its own");
            }
        }
    }
}

#[test]
fn pipes_that_nobody_opens() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.npy");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let of_cloud = folder.path().join("scene.toml");
    fs::write(&of_cloud, "[[spheres]]\nfile = \"pipe.npy\"\nradius = 1\ncolor = \"#ffffff\"\n")
        .unwrap();
    let (figure, of_cloud) = (scene("figure1"), of_cloud.to_str().unwrap().to_owned());
    let pipe = pipe.to_str().unwrap();
    let cases: [&[&str]; 7] = [
        &["render", &figure, "-o", pipe, "--device", "cpu"],
        &["render", pipe, "-o", "a.png"],
        &["info", pipe],
        &["info", &of_cloud],
        &["trace", &figure, "--rays", pipe, "-o", "hits.npy"],
        &["generate", "--count", "10", "-o", pipe],
        &["export", "pov", &figure, "-o", pipe],
    ];
    for arguments in cases {
        let delay = Duration::from_millis(300);
        assert!(is_interrupted(arguments, "other", delay), "{arguments:?} ended on its own");
    }
}

/// Standard error goes elsewhere while a driver opens; these last words don't. The loader waits for
/// somebody to write the list of drivers.
#[test]
fn a_driver_that_never_opens() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("drivers.json");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let figure = scene("figure1");
    let commands: [&[&str]; 3] =
        [&["render", &figure, "-o", "a.png", "--device", "gpu"], &["probe"], &["report"]];
    for arguments in commands {
        let child = program()
            .args(arguments)
            .env("VK_DRIVER_FILES", &pipe)
            .env("VK_ICD_FILENAMES", &pipe)
            .current_dir(&folder)
            .spawn()
            .unwrap();
        let delay = Duration::from_millis(500);
        assert!(ends(child, &format!("{arguments:?}"), delay, Signal::INT));
        assert_eq!(names(folder.path()), ["drivers.json"]);
    }
}

/// The program ends what doesn't end by itself; the library must do that: one row of pixels, and a list
/// of rays, that would each take minutes.
#[test]
fn the_library_stops_amid_a_row_and_between_the_steps_of_preparing() {
    let mut rng = ChaCha8Rng::seed_from_u64(1313);
    let spheres: Vec<_> = (0..1_000_000).map(|_| sphere(in_cube(&mut rng), 1e-3)).collect();
    let scene = Arc::new(kugelblitz_tests::scene(spheres, Vec::new()));
    let view = View::new(&camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO));
    let row = Pixels { height: 1, ..Pixels::whole(view, 30_000, 30_000) };
    let ray = WorldRay { origin: DVec3::Z, direction: DVec3::NEG_Z };
    for rays in [Rays::Pixels(row), Rays::List(vec![ray; 30_000])] {
        for kernel in [Kernel::Lecture, Kernel::Double] {
            let control = Arc::new(Control::default());
            let prepared =
                Prepared::renewed(None, Arc::clone(&scene), kernel, &rays, &control).unwrap();
            let mut tracer = Tracer::on_cpu(Arc::new(prepared), Outputs::default());
            let later = Arc::clone(&control);
            let cancel = std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(200));
                later.cancel();
            });
            let start = Instant::now();
            let traced = tracer.trace(&rays, &control, &mut Hits::default());
            assert!(matches!(traced, Err(Error::Interrupted)), "{kernel:?}");
            assert!(start.elapsed() < BOUND, "{kernel:?}: {:?}", start.elapsed());
            cancel.join().unwrap();
            let prepared = Prepared::renewed(None, Arc::clone(&scene), kernel, &rays, &control);
            assert!(matches!(prepared, Err(Error::Interrupted)));
        }
    }
}

/// On a terminal, which `script` makes; with one thread and so many spheres that it takes several
/// times the half second that passes without a word, on a fast machine too.
#[test]
fn building_a_hierarchy_is_seen_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let [cloud, scene, out] = ["cloud.npy", "scene.toml", "a.png"].map(|name| file(&folder, name));
    program::run(&["generate", "--count", "5000000", "-o", &cloud, "--scene", &scene], 0);
    let command =
        format!("{} render {scene} -o {out} --device cpu -v", env!("CARGO_BIN_EXE_kugelblitz"));
    let output = Command::new("script")
        .args(["--quiet", "--return", "--command", &command, "/dev/null"])
        .env("RAYON_NUM_THREADS", "1")
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let talk = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{talk}");
    assert!(talk.contains("building the hierarchy over 5000000 spheres"), "{talk}");
    let times =
        talk.lines().find_map(|line| line.split_once("note: read ")?.1.split_once(" build "));
    assert!(times.is_some_and(|(_, build)| !build.starts_with("0.0 ms")), "{talk}");
}

/// Who reads its help reads on: the program has not even looked at its arguments then. It must hear a signal
/// from its first moment on.
#[test]
fn handlers_come_before_all_else() {
    let (_reader, mut writer) = std::io::pipe().unwrap();
    // As much as a pipe takes, so that the next word waits.
    let flags = rustix::fs::fcntl_getfl(&writer).unwrap();
    rustix::fs::fcntl_setfl(&writer, flags | rustix::fs::OFlags::NONBLOCK).unwrap();
    while writer.write(&[b' '; 512]).is_ok() {}
    rustix::fs::fcntl_setfl(&writer, flags).unwrap();
    let mut child = program().arg("--help").stdout(writer).spawn().unwrap();
    let status = PathBuf::from(format!("/proc/{}/status", child.id()));
    let is_heard = || {
        let status = fs::read_to_string(&status).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        let caught = u64::from_str_radix(caught.trim(), 16).unwrap();
        caught & (1 << (Signal::TERM.as_raw() - 1)) != 0
    };
    let start = Instant::now();
    while !is_heard() && start.elapsed() < BOUND {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(child.try_wait().unwrap().is_none(), "it ended on its own");
    kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{} {stderr}", output.status);
    assert_eq!(stderr, "error: interrupted\n");
}

#[test]
fn sigterm_is_as_good() {
    let child = program()
        .args(["render", &scene("figure1"), "-o", "a.ppm", "--size", "20000x20000"])
        .args(["--device", "cpu"])
        .current_dir(large().folder.path())
        .spawn()
        .unwrap();
    assert!(ends(child, "SIGTERM", Duration::from_millis(500), Signal::TERM));
}
