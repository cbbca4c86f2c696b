//! What fits and what does not: the real program within limits of its memory.

#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use kugelblitz_tests::{gpu, npy};
use tempfile::TempDir;

use crate::program::{ends, finish, in_folder, run, scene_file};

/// How the program ends with the words of a line in a folder, and what it says, within a limit of `ulimit` in KiB: `-v` of
/// its address space, `-d` of its data. Nothing here takes minutes: one that hangs ends with 124.
#[track_caller]
fn within(limit: &str, kib: u64, folder: &Path, line: &str) -> (i32, String) {
    let mut command = Command::new("sh");
    let script = format!("ulimit -c 0; ulimit {limit} {kib}; exec timeout 300 \"$0\" \"$@\"");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_kugelblitz")]).args(line.split(' '));
    command.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null());
    let ran = finish(command);
    for bad in ["memory allocation of", "backtrace"] {
        assert!(!ran.stderr.contains(bad), "{line}\n{}", ran.stderr);
    }
    (ran.code, ran.stderr)
}

/// A folder with the scene `s.toml` of a cloud of these rows (x, y, z, radius).
fn cloud(rows: &[Vec<f64>]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("c.npy"), npy(rows, "<f8", false)).unwrap();
    let scene = "[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nfov = 20\n\
                 [[spheres]]\nfile = \"c.npy\"\ncolor = \"#ffffff\"\n";
    fs::write(folder.path().join("s.toml"), scene).unwrap();
    folder
}

/// The ids in an `.npy` picture.
fn ids(path: &Path) -> Vec<u32> {
    let bytes = fs::read(path).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    // id, t, normal, rgb
    let records = bytes[start..].chunks_exact(32);
    records.map(|record| u32::from_le_bytes(record[..4].try_into().unwrap())).collect()
}

/// The first of equal spheres is seen, from outside and from inside; of those that differ in their last bits, which only exact
/// arithmetic tells apart, the nearest.
#[test]
fn of_many_spheres_in_one_place_one_is_seen_in_little_memory() {
    gpu();
    let n = 16_000;
    let equal = |n, radius| (vec![vec![0.0, 0.0, 0.0, radius]; n], 1);
    let shift = |i: usize| (i * 7919 % n) as f64 * f64::EPSILON / 4.0;
    // The nearest one has the largest z; among equal ones the first counts.
    let nearest = (0..n).max_by(|&i, &j| shift(i).total_cmp(&shift(j)).then(j.cmp(&i))).unwrap();
    let shifted = ((0..n).map(|i| vec![0.0, 0.0, shift(i), 1.0]).collect(), nearest as u32 + 1);
    for (what, size, (rows, id)) in [
        ("few", "255x255", equal(4_000, 1.0)),
        ("equal", "255x255", equal(n, 1.0)),
        ("around the eye", "255x255", equal(n, 50.0)),
        ("nearly equal", "9x5", shifted),
    ] {
        let folder = cloud(&rows);
        for (device, kib) in [("cpu", 400_000), ("gpu", 1_300_000)] {
            let line = format!("render s.toml -o a.npy --size {size} --device {device}");
            let what = format!("{what} on {device}");
            let (code, said) = within("-v", kib, folder.path(), &line);
            assert_eq!(code, 0, "{what}\n{said}");
            let ids = ids(&folder.path().join("a.npy"));
            assert_eq!(ids[ids.len() / 2], id, "{what}");
            let is_right = |&found: &u32| found == id || size == "9x5" && found != 0;
            assert!(ids.iter().all(is_right), "{what}");
        }
    }
}

/// A folder with a million spheres, made once.
fn million() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        ends(in_folder(&folder, "generate --count 1000000 -o c.npy --scene s.toml -q"), 0);
        let path = |name: &str| folder.path().join(name);
        let scene = fs::read_to_string(path("s.toml")).unwrap();
        fs::write(path("lit.toml"), scene + "[sky]\nintensity = 0.8\ndirections = 4\n").unwrap();
        folder
    });
    folder.path()
}

/// What `check` says of the memory that is held for a lit picture with samples is most of what it takes.
#[cfg(target_os = "linux")]
#[test]
fn what_a_picture_holds_is_counted() {
    let scene = fs::read_to_string(million().join("lit.toml")).unwrap();
    let path = million().join("sampled.toml");
    fs::write(&path, scene + "[image]\nwidth = 320\nheight = 180\nsamples = 2\n").unwrap();
    let said = run(&["info", path.to_str().unwrap(), "--json"], 0).json();
    let held = said["picture"]["bytes_held"].as_u64().unwrap() / 1024;
    // Of its data: what the program asks for, without the ranges that are only set aside.
    let line = "render sampled.toml -o g.ppm --device cpu";
    let within_data = |kib: u64| within("-d", kib, million(), line).0;
    assert_eq!(within_data(held), 7, "{held} KiB");
    assert_eq!(within_data(held + held / 4 + 250_000), 0, "{held} KiB");
}

/// What each lamp gives each sample of a few pixels is more than there is, for a sky of very many directions.
#[test]
fn a_sky_of_many_directions_is_refused_with_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let sky = |directions: u32| {
        let scene = format!(
            "camera = {{ position = [0, 1, 6], look_at = [0, 0, 0] }}\n\
             sky = {{ intensity = 0.8, directions = {directions} }}\n\
             sphere = [{{ center = [0, 0, 0], radius = 1, color = \"#fff\" }}]\n\
             plane = [{{ point = [0, -1, 0], normal = [0, 1, 0], color = \"#fff\" }}]\n"
        );
        fs::write(folder.path().join("s.toml"), scene).unwrap();
        let line = "render s.toml -o a.png --size 8x8 --samples 16 --device cpu";
        within("-v", 3_000_000, folder.path(), line)
    };
    let (code, said) = sky(65_536);
    assert_eq!(code, 7, "{said}");
    assert!(said.contains("65536 lamps on 256 samples") && said.contains("fewer"), "{said}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "no file is left");
    assert_eq!(sky(64).0, 0);
}

/// What is too much is refused with what it needs, what there is, and what sets the limit.
#[test]
fn a_million_spheres_fit_or_are_refused_with_numbers() {
    gpu();
    let (mut n_done, mut n_refused) = (0, 0);
    for (command, limits) in [
        ("render s.toml -o a.png --size 320x180 --device cpu", [100, 250, 350, 450, 1200]),
        ("render s.toml -o b.png --size 320x180 --device gpu", [200, 450, 750, 1000, 2500]),
        ("render s.toml -o c.png --size 320x180 --device auto", [300, 600, 700, 1100, 2500]),
        (
            "render s.toml -o d.png --size 16x9 --kernel double --device cpu",
            [150, 220, 300, 400, 900],
        ),
        ("render lit.toml -o e.png --size 320x180 --device cpu", [150, 400, 450, 500, 600]),
        (
            "render lit.toml -o f.png --size 320x180 --samples 2 --device cpu",
            [150, 450, 500, 550, 700],
        ),
        ("info s.toml", [150, 300, 400, 500, 1200]),
        ("explain s.toml --pixel 9,9 --size 320x180 --device cpu", [150, 300, 400, 500, 1200]),
        ("verify s.toml --size 32x18 --samples 4 --device cpu", [150, 300, 400, 500, 1200]),
    ] {
        for mib in limits {
            let what = format!("{command}, {mib} MiB");
            let (code, said) = within("-v", mib << 10, million(), command);
            match code {
                0 => n_done += 1,
                7 => {
                    n_refused += 1;
                    for word in ["iB", "available within the limit of the address space", "need"] {
                        assert!(said.contains(word), "{what}\n{said}");
                    }
                }
                _ => panic!("{what}: {code}\n{said}"),
            }
            // The least and the most are beyond doubt.
            assert!(mib > limits[0] || code == 7, "{what}\n{said}");
            assert!(mib < limits[4] || code == 0, "{what}\n{said}");
        }
    }
    assert!(n_done >= 7 && n_refused >= 7, "{n_done}, {n_refused}");
}

#[test]
fn a_report_of_large_pictures_is_refused_with_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let line = format!("report {} --size 8192x8192 --device cpu", scene_file("figure1"));
    let (code, said) = within("-v", 800_000, folder.path(), &line);
    assert_eq!(code, 7, "{said}");
    assert!(said.contains("hits of 67108864 rays needs 1280 MiB"), "{said}");
}
