//! Nothing in a file makes its reader panic: files of every format, damaged in the ways in which files come out wrong.

use kugelblitz::control::Control;
use kugelblitz::error::Error;
use kugelblitz::picture::{Format, read_bytes, read_rays};
use kugelblitz::scene::{Color, Scene, Sphere, read_scene};
use kugelblitz_tests::folder::Folder;
use kugelblitz_tests::{npy, npy_file, npy_of_rays, text_of};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::picture::small_file;

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
                Err(Error::Scene(error)) => {
                    n_refused += 1;
                    // What is no text has no place.
                    let is_placed = error.text.get(error.span.clone()).is_some()
                        && (1..=error.text.matches('\n').count() + 1).contains(&error.line)
                        && error.column > 0;
                    let is_placed = is_placed || error.text.is_empty() && error.line == 0;
                    let says = !error.message.is_empty() && !error.hint.is_empty();
                    assert!(is_placed && says, "case {case}: {error:?}\nfrom {name}\n{shown}");
                }
                Err(error) => {
                    n_refused += 1;
                    assert!([1, 7].contains(&error.exit_code()), "case {case}: {error}\n{shown}");
                }
            }
        }
        // Some damage is harmless, most is not.
        println!("{name}: {n_read} read, {n_refused} refused");
        assert!(n_read > 4 && n_refused > 60, "{name}: {n_read} read, {n_refused} refused");
    }
}
