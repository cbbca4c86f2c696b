//! Nothing in a file makes its reader panic: files of every format, damaged in the ways in which files come out wrong.
//!
//! `KUGELBLITZ_SEED=n` draws other damage of data. `KUGELBLITZ_CASE=12-units.csv-1-7` repeats one case: of a file, a seed and a
//! number.

use std::sync::mpsc;
use std::time::{Duration, Instant};

use kugelblitz::Control;
use kugelblitz::error::Error;
use kugelblitz::picture::{Format, read_bytes, read_rays};
use kugelblitz::scene::{Color, Scene, Sphere, compose_scene, read_scene};
use kugelblitz_tests::folder::Folder;
use kugelblitz_tests::{npy, npy_file, npy_of_rays, text_of};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::picture::small_file;
use crate::programs::files_with_keys;

/// What stands in for a value, or is put between two bytes.
const WORDS: &str = "nan -inf 1e999 -1e308 1e-400 0 -1 99999999999999999999 0x7f true \" ''' \"#12345\" [] [1,2] \
                     [[1],2,3] {a=1} 1979-05-27T07:32:00Z , ; : # ( [a. \\u \n \0 ключ";

fn one_of<T: Copy>(rng: &mut impl Rng, all: &[T]) -> Option<T> {
    (!all.is_empty()).then(|| all[rng.random_range(0..all.len())])
}

/// Damages a file once.
fn damage(rng: &mut impl Rng, bytes: &mut Vec<u8>) {
    let at = rng.random_range(0..=bytes.len());
    let words: Vec<&str> = WORDS.split(' ').collect();
    let word = one_of(rng, &words).unwrap_or_default();
    let breaks = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
    let ends: Vec<usize> = breaks.map(|(at, _)| at + 1).collect();
    let [one, other] = [(); 2].map(|()| {
        let start = one_of(rng, &ends).unwrap_or(0);
        start..ends.iter().copied().find(|end| *end > start).unwrap_or(bytes.len())
    });
    match rng.random_range(0..12) {
        0 => bytes.truncate(at),
        1 => bytes.extend((0..rng.random_range(1..200)).map(|_| rng.random::<u8>())),
        2..6 => (0..rng.random_range(1..8)).for_each(|_| {
            let at = rng.random_range(0..bytes.len().max(1));
            bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = rng.random());
        }),
        6 => drop(bytes.splice(at..at, word.bytes())),
        // A number or a name.
        7 => {
            let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || b".-+_".contains(byte);
            let start = bytes[at..].iter().position(is_part).map_or(bytes.len(), |skip| at + skip);
            let n = bytes[start..].iter().take_while(|byte| is_part(byte)).count();
            bytes.splice(start..start + n, word.bytes());
        }
        // Lines.
        8 => {
            let copy = bytes[other].to_vec();
            bytes.splice(one.end..one.end, copy);
        }
        9 => drop(bytes.splice(one, [])),
        10 => drop(bytes.splice(at..at, word.repeat(rng.random_range(1..2000)).bytes())),
        _ => *bytes = (0..rng.random_range(0..400)).map(|_| rng.random()).collect(),
    }
}

/// Reads a file, asserts what holds for whatever is read, and gives how much that is.
type Reader = fn(&Folder, &str, &[u8]) -> kugelblitz::Result<usize>;

fn n_objects(scene: &Scene) -> usize {
    let sphere = |s: &Sphere| s.radius > 0.0 && s.radius.is_finite() && s.center.is_finite();
    let color = |c: Color| c.0.iter().all(|part| (0.0..=1.0).contains(part));
    assert!(scene.spheres.iter().all(sphere) && scene.spheres.colors().all(color), "{scene:?}");
    assert!(scene.planes.iter().all(|plane| plane.normal.length() > 0.0), "{scene:?}");
    scene.n_objects()
}

fn scene(folder: &Folder, _: &str, bytes: &[u8]) -> kugelblitz::Result<usize> {
    folder.write("scene.toml", bytes);
    read_scene(&folder.path("scene.toml")).map(|scene| n_objects(&scene))
}

fn cloud(folder: &Folder, name: &str, bytes: &[u8]) -> kugelblitz::Result<usize> {
    folder.cloud(name, bytes, "").map(|scene| n_objects(&scene))
}

fn colored(folder: &Folder, name: &str, bytes: &[u8]) -> kugelblitz::Result<usize> {
    folder.cloud(name, bytes, "color_by = \"q\"").map(|scene| n_objects(&scene))
}

fn rays(folder: &Folder, name: &str, bytes: &[u8]) -> kugelblitz::Result<usize> {
    folder.write(name, bytes);
    let rays = read_rays(&folder.path(name), &Control::default())?;
    assert!(rays.iter().all(|ray| ray.direction.is_finite() && ray.origin.is_finite()));
    Ok(rays.len())
}

fn picture(_: &Folder, name: &str, bytes: &[u8]) -> kugelblitz::Result<usize> {
    let picture = read_bytes(bytes, name.as_ref())?;
    let n = picture.width * picture.height;
    assert!(picture.channels.iter().all(|channel| channel.samples.len() == n), "{name}");
    Ok(n)
}

/// Asserts that an error has a place, a message and advice.
fn assert_has_advice(error: &Error, case: &str) {
    match error {
        Error::Scene(error) => {
            // What is no text has no place.
            let is_placed = error.text.get(error.span.clone()).is_some()
                && (1..=error.text.matches('\n').count() + 1).contains(&error.line)
                && error.column > 0;
            let is_placed = is_placed || error.text.is_empty() && error.line == 0;
            let is_complete = !error.message.is_empty() && !error.hint.is_empty();
            assert!(is_placed && is_complete, "{error:?}\n{case}");
        }
        error => assert!([1, 7].contains(&error.exit_code()), "{error}\n{case}"),
    }
}

#[test]
fn no_damaged_file_panics() {
    let folder = Folder::default();
    // Most of an array is numbers.
    let rows = vec![vec![0.5; 7]; 40];
    let fields = "[('pos', '<f4', (3,)), ('r', '<f4'), ('q', '>i2')]";
    let properties = "Lattice=\"1 0\" Properties=species:S:1:pos:R:3:q:R:1";
    let dump = "ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp\n0 1\n0 1\n0 1\nITEM: ATOMS xs ys zs radius q\n0 0 0 1 2\n";
    let mut files: Vec<(Reader, &str, Vec<u8>)> = vec![
        (cloud, "a.npy", npy(&rows, "<f8", false)),
        (cloud, "a.csv", b"x,y,z,r,red,green,blue\n1,2,3,4,0.5,0,1\n5,6,7,8,1,1,1\n".into()),
        (cloud, "a.xyz", b"3\nwater\nO 0 0 0\nH 1 0 0\nH 0 1 0\n".into()),
        (colored, "a.npy", npy_file(fields, false, "(40,)", &[63; 720])),
        (colored, "a.csv", b"# x;y;z;radius;q\n1;2;3;1,5;\n1;2;3;4;5\n".into()),
        (colored, "a.txt", b"x [m] y z r q\n1 2 3 4 5\n".into()),
        (colored, "a.xyz", format!("1\n{properties}\nC 1 2 3 4\n").into()),
        (colored, "a.dump", dump.into()),
        (rays, "a.npy", npy_of_rays(&[[0.5; 6]; 40])),
    ];
    for name in ["figure1", "figure5", "inside", "orthographic", "lit/figure1", "lit/figure2"] {
        files.push((scene, name, text_of(&format!("scenes/{name}.toml")).into()));
    }
    files.extend(Format::ALL.map(|format| (picture as Reader, "picture", small_file(format))));
    let mut rng = ChaCha8Rng::seed_from_u64(20_240_611);
    for (read, name, whole) in files {
        assert!(read(&folder, name, &whole).is_ok_and(|n| n > 0), "{name}");
        let (mut n_read, mut n_refused) = (0, 0);
        for case in 0..300 {
            let mut bytes = whole.clone();
            (0..rng.random_range(1..=2)).for_each(|_| damage(&mut rng, &mut bytes));
            let shown = String::from_utf8_lossy(&bytes);
            let found = std::panic::catch_unwind(|| read(&folder, name, &bytes))
                .unwrap_or_else(|_| panic!("case {case}: panic on {name}\n{shown}"));
            match found {
                Ok(n) => n_read += usize::from(n > 0),
                Err(error) => {
                    n_refused += 1;
                    assert_has_advice(&error, &format!("case {case} from {name}\n{shown}"));
                }
            }
        }
        // Some damage is harmless, most is not.
        println!("{name}: {n_read} read, {n_refused} refused");
        assert!(n_read > 4 && n_refused > 60, "{name}: {n_read} read, {n_refused} refused");
    }
}

/// Damages data as editors, spreadsheets and broken transfers do. `other` is another file.
fn damage_data(rng: &mut impl Rng, bytes: &mut Vec<u8>, other: &[u8]) {
    let mut at = |bytes: &[u8]| rng.random_range(0..=bytes.len());
    let (start, start_of_other) = (at(bytes), at(other));
    let marks = b",;\t |.";
    match rng.random_range(0..8) {
        // The start of one file and the end of another.
        0 => drop(bytes.splice(start.., other[start_of_other..].iter().copied())),
        1 => drop(bytes.splice(start..start, other[start_of_other..].iter().copied())),
        // Another separator or decimal mark, everywhere or in some places.
        2..5 => {
            let [old, new] = [(); 2].map(|()| one_of(rng, marks).unwrap_or_default());
            let share = one_of(rng, &[0.1, 0.5, 1.0]).unwrap_or_default();
            for byte in bytes.iter_mut().filter(|byte| **byte == old) {
                *byte = if rng.random_bool(share) { new } else { old };
            }
        }
        5 => {
            let end = one_of(rng, &["\r\n", "\r", "\n\n", "", "\0", ",\n"]).unwrap_or_default();
            let lines: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
            *bytes = lines.join(end.as_bytes());
        }
        _ => damage(rng, bytes),
    }
}

/// Longest time that reading a damaged file of a kilobyte may take: it takes milliseconds, unless it never ends.
const LONGEST: Duration = Duration::from_secs(60);

/// Mutants of each file.
const N_MUTANTS: u64 = 130;

/// Reads tables, dumps, XYZ, NPY and gzip files of programs, each damaged in many ways, as bare data.
#[test]
fn damaged_data_give_spheres_or_advice() {
    let files = files_with_keys();
    let setting = |name| std::env::var(name).ok();
    let seed = setting("KUGELBLITZ_SEED").map_or(1, |seed| seed.parse().expect("a seed"));
    let cases: Vec<(usize, u64, u64)> = match setting("KUGELBLITZ_CASE") {
        None => {
            (0..files.len()).flat_map(|file| (0..N_MUTANTS).map(move |n| (file, seed, n))).collect()
        }
        Some(name) => {
            let mut parts = name.rsplitn(3, '-');
            let mut number = || parts.next().and_then(|part| part.parse().ok()).expect("a number");
            let (n, seed) = (number(), number());
            let file = parts.next().and_then(|file| file.split('-').next()?.parse().ok());
            vec![(file.expect("a file"), seed, n)]
        }
    };
    let begun = Instant::now();
    let n_cases = cases.len();
    let (sender, receiver) = mpsc::channel();
    let worker = std::thread::spawn(move || {
        let folder = Folder::default();
        let (mut n_read, mut n_refused) = (0, 0);
        for (file, seed, n) in cases {
            let (name, overrides, whole) = &files[file];
            let case = format!("KUGELBLITZ_CASE={file}-{name}-{seed}-{n}");
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream((file as u64) << 32 | n);
            let mut bytes = whole.clone();
            let other = &files[rng.random_range(0..files.len())].2;
            (0..rng.random_range(1..=3)).for_each(|_| damage_data(&mut rng, &mut bytes, other));
            let shown = String::from_utf8_lossy(&bytes);
            sender.send(case.clone()).expect("a receiver");
            let path = folder.path(name);
            folder.write(name, &bytes);
            let found =
                std::panic::catch_unwind(|| compose_scene(&path, overrides, &Control::default()));
            match found {
                Err(_) => panic!("panic: {case}\n{shown}"),
                Ok(Ok(composed)) => {
                    n_read += 1;
                    let checked = std::panic::catch_unwind(|| n_objects(&composed.scene));
                    assert!(checked.is_ok_and(|n| n > 0), "wrong spheres: {case}\n{shown}");
                }
                // Keys of data for a file that has become a scene.
                Ok(Err(Error::Usage(message))) => {
                    n_refused += 1;
                    assert!(!message.text.is_empty(), "{case}\n{shown}");
                }
                Ok(Err(error)) => {
                    n_refused += 1;
                    assert_has_advice(&error, &format!("{case}\n{shown}"));
                }
            }
        }
        (n_read, n_refused)
    });
    let mut last = String::new();
    loop {
        match receiver.recv_timeout(LONGEST) {
            Ok(case) => last = case,
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("no end after {LONGEST:?}: {last}"),
        }
    }
    let (n_read, n_refused) = worker.join().unwrap_or_else(|_| panic!("failed: {last}"));
    println!("{n_read} read, {n_refused} refused in {:.1} s", begun.elapsed().as_secs_f64());
    let is_one = n_cases == 1;
    assert!(is_one || n_cases >= 20_000 && n_read > 2000 && n_refused > 10_000);
}
