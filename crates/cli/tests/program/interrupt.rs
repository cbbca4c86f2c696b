//! Ctrl-C and SIGTERM end every command amid every long phase, with 130 and no file changed.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use glam::DVec3;
use kugelblitz::Error;
use kugelblitz::control::Control;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::{camera, gpu, in_cube, sphere};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::program;
use crate::program::scene_file as scene;

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
        let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let (cloud, scene, rays) = (at("cloud.npy"), at("scene.toml"), at("rays.npy"));
        let made = program()
            .args(["generate", "cloud", "--count", "1000000", "-o", &cloud, "--scene", &scene])
            .status();
        assert!(made.unwrap().success());
        write_rays(Path::new(&rays), 2_000_000);
        Large { folder, scene, rays }
    })
}

fn write_rays(path: &Path, n: usize) {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({n}, 6), }}");
    let header = format!("{header:<117}\n");
    let mut file = std::io::BufWriter::new(fs::File::create(path).unwrap());
    file.write_all(b"\x93NUMPY\x01\x00").unwrap();
    file.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
    file.write_all(header.as_bytes()).unwrap();
    for i in 0..n {
        let turned = i as f64 / n as f64;
        for value in [turned, 0.1, 5.0, 0.3 - turned, 0.02, -1.0] {
            file.write_all(&value.to_le_bytes()).unwrap();
        }
    }
    file.flush().unwrap();
}

fn names(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    names
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
    // Of output files speaks who has some.
    let has_outputs =
        !["check", "verify", "probe"].iter().any(|name| what.contains(&format!("\"{name}\"")));
    let speaks = stderr.contains("no output file was changed");
    assert_eq!(speaks, has_outputs, "{what}: {stderr}");
    assert_eq!(stderr.matches("interrupted").count(), 1, "{what}: {stderr}");
    true
}

/// Interrupts a command that has `out` as its output, in a folder of its own.
#[track_caller]
fn interrupted(arguments: &[&str], out: &str, delay_ms: u64) {
    let delay = Duration::from_millis(delay_ms);
    assert!(is_interrupted(arguments, out, delay), "{arguments:?} ended on its own");
}

/// Interrupts a command at several moments amid its work, however long that takes here.
#[track_caller]
fn interrupted_anywhere(arguments: &[&str], out: &str) {
    let folder = tempfile::tempdir().unwrap();
    let start = Instant::now();
    assert!(program().args(arguments).current_dir(&folder).status().unwrap().success());
    let whole = start.elapsed();
    for part in [0.1, 0.3, 0.5, 0.7] {
        // Another run may be quicker.
        let mut delay = whole.mul_f64(part);
        while !is_interrupted(arguments, out, delay) {
            delay /= 2;
            assert!(!delay.is_zero(), "{arguments:?} always ends on its own");
        }
    }
}

#[track_caller]
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
    assert_eq!(names(folder.path()), [path], "{what}");
    true
}

#[test]
fn f32_and_f64_over_a_million_spheres_on_the_cpu() {
    for kernel in ["lecture", "double"] {
        let scene = &large().scene;
        let arguments = ["render", scene, "-o", "a.png", "--device", "cpu", "--kernel", kernel];
        interrupted(&arguments, "a.png", 2500);
    }
}

#[test]
fn f32_and_f64_over_a_million_spheres_on_the_gpu() {
    gpu();
    for kernel in ["lecture", "double"] {
        let scene = &large().scene;
        let arguments = ["render", scene, "-o", "a.png", "--device", "gpu", "--kernel", kernel];
        interrupted(&arguments, "a.png", 3000);
    }
}

#[test]
fn large_pictures_on_the_cpu_and_on_the_gpu() {
    gpu();
    for device in ["cpu", "gpu"] {
        let scene = scene("figure1");
        let arguments = ["render", &scene, "-o", "a.ppm", "--size", "20000x20000", "--device"];
        interrupted(&[&arguments[..], &[device]].concat(), "a.ppm", 1500);
    }
}

/// Reading, then the building of a hierarchy, then tracing: whichever it is at the time.
#[test]
fn the_certified_kernel_over_a_million_spheres() {
    for delay_ms in [150, 500, 1000, 1500] {
        let arguments = ["render", &large().scene, "-o", "a.npy", "--size", "16000x16000"];
        interrupted(&[&arguments[..], &["--device", "cpu"]].concat(), "a.npy", delay_ms);
    }
}

#[test]
fn check_of_a_million_spheres() {
    interrupted_anywhere(&["check", &large().scene], "other");
}

#[test]
fn rays_read_traced_and_written() {
    let Large { scene, rays, .. } = large();
    let arguments = ["trace", scene, "--rays", rays, "-o", "hits.npy", "--device", "cpu"];
    interrupted_anywhere(&arguments, "hits.npy");
}

#[test]
fn verify_draws_many_samples() {
    let scene = scene("figure1");
    let arguments = ["verify", &scene, "--size", "16000x16000", "--samples", "100000000"];
    interrupted(&[&arguments[..], &["--device", "cpu"]].concat(), "other", 1000);
}

#[test]
fn a_cloud_is_generated() {
    let count = ["generate", "cloud", "--count", "100000000", "-o", "cloud.npy"];
    interrupted(&count, "cloud.npy", 500);
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
        &["check", pipe],
        &["check", &of_cloud],
        &["trace", &figure, "--rays", pipe, "-o", "hits.npy"],
        &["generate", "cloud", "--count", "10", "-o", pipe],
        &["export", "pov", &figure, "-o", pipe],
    ];
    for arguments in cases {
        interrupted(arguments, "other", 300);
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
        assert_eq!(names(folder.path()), [pipe.as_path()]);
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
    let ray = Ray { origin: DVec3::Z, direction: DVec3::NEG_Z };
    for rays in [Rays::Pixels(row), Rays::List(vec![ray; 30_000])] {
        for kernel in [Kernel::Lecture, Kernel::Double] {
            let control = Arc::new(Control::default());
            let prepared = Prepared::new_with(Arc::clone(&scene), kernel, &rays, &control).unwrap();
            let mut tracer = Tracer::on_cpu(Arc::new(prepared), Wants::default());
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
            let prepared = Prepared::new_with(Arc::clone(&scene), kernel, &rays, &control);
            assert!(matches!(prepared, Err(Error::Interrupted)));
        }
    }
}

/// On a terminal, which `script` makes; with one thread and so many spheres that it takes several
/// times the half second that passes without a word, on a fast machine too.
#[test]
fn building_a_hierarchy_is_seen_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let made = program()
        .args(["generate", "cloud", "--count", "5000000", "-o", &at("cloud.npy")])
        .args(["--scene", &at("scene.toml")])
        .status();
    assert!(made.unwrap().success());
    let command = format!(
        "{} render {} -o {} --device cpu -v",
        env!("CARGO_BIN_EXE_kugelblitz"),
        at("scene.toml"),
        at("a.png")
    );
    let output = Command::new("script")
        .args(["--quiet", "--return", "--command", &command, "/dev/null"])
        .env("RAYON_NUM_THREADS", "1")
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let talk = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{talk}");
    assert!(talk.contains("building the hierarchy over 5000000 spheres"), "{talk}");
    let lines: Vec<&str> = talk.lines().collect();
    assert!(lines.iter().any(|line| line.contains("note: ") && line.contains(" built ")), "{talk}");
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
