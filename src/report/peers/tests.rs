//! Peers that a test can rely on: small shell scripts, which take prepared pictures for theirs.

use std::time::Instant;

use glam::DVec3;

use super::*;
use crate::scene::{Camera, Color, Projection, Sphere};

const SIZE: [u32; 2] = [3, 2];

/// A sphere in the middle of six pixels.
fn scene() -> Scene {
    let sphere = Sphere {
        name: None,
        center: DVec3::ZERO,
        radius: 0.5,
        color: Color::from_srgb8([1, 2, 3]),
    };
    Scene { spheres: vec![sphere], ..Scene::default() }
}

fn view() -> View {
    View::new(&Camera {
        position: DVec3::Z * 5.0,
        look_at: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_degrees: 45.0 },
    })
}

/// A picture in which each id has its colour.
fn picture(ids: &[u32], [width, height]: [u32; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<_> = ids.iter().flat_map(|&id| codes::color(id).to_srgb8()).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    bytes
}

/// Writes an executable file, by another process: a file that this one had open for writing could
/// still be so in the child that a test beside it has just forked, and can't be executed then.
fn write_program(path: &Path, text: &str) {
    let mut shell = Command::new("sh")
        .args(["-c", "cat > \"$0\" && chmod +x \"$0\""])
        .arg(path)
        .stdin(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    shell.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    assert!(shell.wait().unwrap().success());
}

/// A folder with a script, a right picture of the plain scene and one of [`scene`].
struct Fake {
    folder: tempfile::TempDir,
}

const IDS: [u32; 6] = [0, 1, 0, 0, 1, 0];

impl Fake {
    /// `script` runs in the folder of the run, with `$pictures` for this one and `$kind` for the
    /// scene: plain or other.
    fn new(script: &str) -> Fake {
        let fake = Fake { folder: tempfile::tempdir().unwrap() };
        fake.put("plain.png", &picture(&plain::tests::right(), plain::SIZE));
        fake.put("other.png", &picture(&IDS, SIZE));
        let pictures = fake.folder.path().display();
        // Only the plain scene has planes.
        let text = format!(
            "#!/bin/sh\npictures='{pictures}'\n\
             if grep -qi '^plane' scene; then kind=plain; else kind=other; fi\n{script}\n"
        );
        write_program(&fake.path("peer"), &text);
        fake
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn open(&self, peer: Peer, effort: &Effort) -> Result<Program, Missing> {
        Program::open_at(peer, self.path("peer"), effort, &Control::default())
    }

    /// Opens it and draws [`scene`].
    fn run(&self, peer: Peer, n_runs: usize) -> Result<PeerRun, Missing> {
        let effort = Effort { n_runs, ..Effort::default() };
        let program = self.open(peer, &effort)?;
        program.run(&scene(), &view(), SIZE, &effort, &Control::default())
    }

    /// What is missing about it.
    fn reason(&self) -> String {
        reason(self.run(Peer::PovRay, 1))
    }
}

fn reason<T>(result: Result<T, Missing>) -> String {
    match result {
        Err(Missing::Because(reason)) => reason,
        Err(Missing::Stopped(error)) => panic!("stopped: {error}"),
        Ok(_) => panic!("it ran"),
    }
}

const DRAW: &str = "cp \"$pictures/$kind.png\" picture.png";

#[test]
fn a_peer_runs_as_often_as_asked_and_its_picture_is_read() {
    let talk = "echo 'Fake Ray Tracer Version 1.2.3 (beta)'; echo 'Trace Time: (0.250 seconds)'; \
                echo '  Ray Tracing Time:     0.2500 seconds' >&2; echo run >> \"$pictures/log\"";
    for peer in Peer::ALL {
        let fake = Fake::new(&format!("{talk}\n{DRAW}"));
        let run = fake.run(peer, 3).unwrap();
        assert_eq!(run.ids, IDS);
        assert_eq!(run.peer, peer.name());
        assert_eq!(run.version.as_deref(), Some("1.2.3"));
        let trace_ms = run.trace_ms.as_ref().unwrap();
        assert_eq!((trace_ms.median, trace_ms.n), (250.0, 3));
        assert_eq!(run.wall_ms.n, 3);
        assert!(run.wall_ms.min > 0.0 && run.wall_ms.max >= run.wall_ms.median);
        // One for the plain scene.
        assert_eq!(fs::read_to_string(fake.path("log")).unwrap().lines().count(), 4);
    }
}

/// What it is given: the scene in its language, in the colours of the ids, and its size.
#[test]
fn a_peer_gets_the_scene_and_the_size() {
    for peer in Peer::ALL {
        let fake = Fake::new(&format!(
            "cp scene \"$pictures/$kind.scene\"; echo \"$@\" > \"$pictures/arguments\"\n{DRAW}"
        ));
        fake.run(peer, 1).unwrap();
        let mut expected = Vec::new();
        let language = peer.language();
        export::write(language, &scene(), &view(), SIZE, codes::color, &mut expected).unwrap();
        assert_eq!(fs::read(fake.path("other.scene")).unwrap(), expected);
        let arguments = fs::read_to_string(fake.path("arguments")).unwrap();
        let with_size = match peer {
            Peer::PovRay => arguments.contains(" Width=3 Height=2 "),
            Peer::Tachyon => String::from_utf8(expected).unwrap().contains("RESOLUTION 3 2\n"),
        };
        assert!(with_size, "{arguments}");
    }
}

#[test]
fn a_time_that_one_run_does_not_tell_is_none() {
    let once = "[ -e \"$pictures/seen$kind\" ] || echo 'Trace Time: (0.250 seconds)'; \
                touch \"$pictures/seen$kind\"";
    let run = Fake::new(&format!("{once}\n{DRAW}")).run(Peer::PovRay, 2).unwrap();
    assert_eq!((run.trace_ms, run.version), (None, None));
}

#[test]
fn what_is_not_installed_is_named_with_its_package() {
    let (effort, control) = (Effort::default(), Control::default());
    for (peer, package) in [(Peer::PovRay, "povray"), (Peer::Tachyon, "tachyon")] {
        let folder = tempfile::tempdir().unwrap();
        let nowhere = folder.path().join("peer");
        let reason = reason(Program::open_at(peer, nowhere, &effort, &control));
        assert_eq!(reason, format!("not installed: install the package {package}"));
    }
}

#[test]
fn what_a_peer_does_wrong_is_told() {
    let reason = |script: &str| Fake::new(script).reason();
    let failed = reason("echo 'File: scene  Line: 3'; echo 'Parse Error: no' >&2; exit 7");
    assert!(failed.contains("exit status: 7: Parse Error: no"), "{failed}");
    let nothing = reason("true");
    assert!(nothing.starts_with("its picture can't be used: "), "{nothing}");
    let other_size = reason("cp \"$pictures/other.png\" picture.png");
    assert!(other_size.ends_with("it has 3x2 pixels, not 64x48"), "{other_size}");
    // The second run must not be taken for the first one.
    let stale = format!("[ -e \"$pictures/$kind\" ] || {DRAW}; touch \"$pictures/$kind\"");
    assert_eq!(Fake::new(&stale).run(Peer::PovRay, 1).unwrap().ids, IDS);
    let stale = reason_of_two_runs(&Fake::new(&stale));
    assert!(stale.starts_with("its picture can't be used: "), "{stale}");
}

fn reason_of_two_runs(fake: &Fake) -> String {
    reason(fake.run(Peer::PovRay, 2))
}

#[test]
fn a_peer_that_looks_beside_the_pixels_is_not_compared() {
    let fake = Fake::new(&format!("echo 'Some Ray Tracer Version 9'\n{DRAW}"));
    let shifted = plain::tests::half_a_pixel_off(1.0, 1.0);
    fake.put("plain.png", &picture(&shifted, plain::SIZE));
    let reason = fake.reason();
    assert!(reason.contains("of 3072 pixels of a plain scene are wrong"), "{reason}");
    assert!(reason.contains("its version (9)"), "{reason}");
}

/// Whether the process that the script noted still runs.
fn runs(fake: &Fake) -> bool {
    let pid = fs::read_to_string(fake.path("pid")).expect("the script began");
    let state = fs::read_to_string(format!("/proc/{}/stat", pid.trim()));
    // An orphan that nobody has waited for yet is a zombie: it runs no longer.
    state.is_ok_and(|stat| !stat.contains(") Z "))
}

fn assert_ends(fake: &Fake) {
    let start = Instant::now();
    while runs(fake) {
        assert!(start.elapsed() < Duration::from_secs(10), "it still runs");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Longer than any test waits, in a process that the script starts.
const HANG: &str =
    "sleep 600 & echo $! > \"$pictures/new\"; mv \"$pictures/new\" \"$pictures/pid\"; wait";

#[test]
fn a_peer_that_hangs_is_ended_with_what_it_started() {
    let fake = Fake::new(HANG);
    let effort = Effort { limit: Duration::from_secs(1), ..Effort::default() };
    let reason = reason(fake.open(Peer::Tachyon, &effort));
    assert!(reason.ends_with("was ended after 1 s without a picture"), "{reason}");
    assert_ends(&fake);
}

#[test]
fn ctrl_c_ends_a_peer() {
    let fake = Fake::new(HANG);
    let control = Control::default();
    let result = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !fake.path("pid").exists() {
                std::thread::sleep(Duration::from_millis(5));
            }
            control.cancel();
        });
        Program::open_at(Peer::PovRay, fake.path("peer"), &Effort::default(), &control)
    });
    assert!(matches!(result, Err(Missing::Stopped(Error::Interrupted))));
    assert_ends(&fake);
}

#[test]
fn median_and_spread() {
    let of = |runs: &[f64]| Spread::of(runs.to_vec()).map(|r| (r.min, r.median, r.max));
    assert_eq!(of(&[]), None);
    assert_eq!(of(&[3.0]), Some((3.0, 3.0, 3.0)));
    assert_eq!(of(&[9.0, 1.0, 2.0]), Some((1.0, 2.0, 9.0)));
    assert_eq!(of(&[9.0, 1.0, 2.0, 4.0]), Some((1.0, 3.0, 9.0)));
}
