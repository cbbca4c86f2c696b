//! Large clouds, pipes, progress, and what does not fit. What files of each format become stands in `tests/answers/clouds.txt`.

use std::fs;

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Error;
use kugelblitz::scene::{
    Color, MAX_OBJECTS, Scene, SceneOverrides, Sphere, Spheres, compose_scene,
};
use kugelblitz_tests::folder::Folder;
use kugelblitz_tests::npy;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A sphere and its colour.
type Colored = (Sphere, Color);

/// Numbers that f32 holds, so that all formats can have the same spheres.
fn some_spheres(n: usize, seed: u64) -> Vec<Colored> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut number = |low: f32, high: f32| f64::from(rng.random_range(low..high));
    (0..n)
        .map(|_| {
            let center = DVec3::from_array(std::array::from_fn(|_| number(-1e3, 1e3)));
            let color = std::array::from_fn(|_| number(0.0, 1.0));
            (Sphere { center, radius: number(1e-3, 10.0) }, Color(color))
        })
        .collect()
}

/// x, y, z, r, red, green, blue.
fn columns((sphere, color): &Colored) -> Vec<f64> {
    [&sphere.center.to_array()[..], &[sphere.radius], &color.0].concat()
}

/// Longer than what is decoded at once.
#[test]
fn a_long_array_is_read_as_it_is_written() {
    let folder = Folder::default();
    let spheres = some_spheres(70_001, 5);
    let rows: Vec<_> = spheres.iter().map(columns).collect();
    let spheres = Spheres::from_iter(spheres);
    for fortran in [false, true] {
        let bytes = npy(&rows, "<f8", fortran);
        let scene = folder.cloud("a.npy", bytes, "color_space = \"linear\"").unwrap();
        assert!(scene.spheres == spheres);
        assert_eq!(scene.bytes(), 70_001 * 56);
    }
}

fn replaced(mut bytes: Vec<u8>, old: &str, new: &str) -> Vec<u8> {
    let at = bytes.windows(old.len()).position(|part| part == old.as_bytes()).expect(old);
    bytes.splice(at..at + old.len(), new.bytes());
    bytes
}

/// A header alone, and as many bytes as it promises, none of which is written.
fn sparse(folder: &Folder, n_rows: u64) -> kugelblitz::Result<Scene> {
    let mut bytes = npy(&[vec![0.0; 3]], "<f4", false);
    bytes.truncate(bytes.len() - 12);
    let shape = format!("({n_rows}, 3), }}");
    let padded = format!("{:1$}", "(1, 3), }", shape.len());
    let bytes = replaced(bytes, &padded, &shape);
    folder.write("a.npy", &bytes);
    let file = fs::OpenOptions::new().write(true).open(folder.path("a.npy")).unwrap();
    file.set_len(bytes.len() as u64 + 12 * n_rows).unwrap();
    folder.read("[[spheres]]\nfile = \"a.npy\"\nradius = 0.25\ncolor = \"#ffffff\"\n")
}

#[test]
fn more_spheres_than_fit_are_refused_before_they_are_read() {
    let folder = Folder::default();
    let n_rows = 3_000_000_000;
    let error = sparse(&folder, n_rows).unwrap_err();
    let text = error.to_string();
    assert_eq!(error.exit_code(), 7, "{text}");
    let numbers: Vec<u64> = text
        .rsplit("a.npy")
        .next()
        .unwrap()
        .split(|c: char| !c.is_ascii_digit())
        .filter_map(|number| number.parse().ok())
        .collect();
    let &[spheres, needed_mib, available_mib, largest] = &numbers[..] else { panic!("{text}") };
    let sphere_bytes = size_of::<Sphere>() as u64;
    assert_eq!((spheres, needed_mib), (n_rows, (n_rows * sphere_bytes).div_ceil(1 << 20)));
    assert!((largest * sphere_bytes) >> 20 == available_mib && largest < n_rows, "{text}");

    let error = sparse(&folder, MAX_OBJECTS as u64 + 1).unwrap_err();
    assert_eq!(error.exit_code(), 7);
    assert!(error.to_string().contains("at most 4294967293 have an id"), "{error}");
}

#[test]
fn reading_counts_its_bytes_and_can_be_stopped() {
    let folder = Folder::default();
    let spheres = some_spheres(100, 1);
    let rows: Vec<_> = spheres.iter().map(columns).collect();
    let files = [
        ("a.npy", npy(&rows, "<f8", false)),
        ("a.csv", b"x,y,z,r,red,green,blue\n1,2,3,4,0,0,0".to_vec()),
        ("a.xyz", b"1\n\nC 0 0 0\n".to_vec()),
    ];
    for (name, bytes) in files {
        folder.cloud(name, &bytes, "").unwrap();
        let control = Control::default();
        let read =
            || compose_scene(&folder.path("scene.toml"), &SceneOverrides::default(), &control);
        read().unwrap();
        let n_bytes = bytes.len() as u64;
        assert_eq!(control.bytes(), (n_bytes, n_bytes), "{name}");
        control.cancel();
        let stopped = read();
        assert!(matches!(stopped, Err(Error::Interrupted)), "{name}: {stopped:?}");
    }
}

/// Pipes have no length and can't be gone through twice.
#[cfg(unix)]
#[test]
fn clouds_come_through_pipes() {
    let folder = Folder::default();
    let spheres = some_spheres(5000, 8);
    let rows: Vec<_> = spheres.iter().map(columns).collect();
    let mut csv = "x,y,z,r,red,green,blue\n".to_string();
    for row in &rows {
        let values: Vec<_> = row.iter().map(|x| format!("{x:?}")).collect();
        csv += &(values.join(",") + "\n");
    }
    for (name, bytes) in [("a.npy", npy(&rows, "<f8", false)), ("a.csv", csv.into_bytes())] {
        let pipe = folder.path(name);
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let writer = std::thread::spawn(move || fs::write(pipe, bytes).unwrap());
        let keys = "color_space = \"linear\"";
        let scene = folder.read(&format!("[[spheres]]\nfile = \"{name}\"\n{keys}\n")).unwrap();
        writer.join().unwrap();
        assert!(scene.spheres == Spheres::from_iter(spheres.clone()), "{name}");
    }
}
