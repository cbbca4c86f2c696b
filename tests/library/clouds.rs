//! Clouds of spheres: every format as it is written. What is said of wrong ones stands in `tests/answers/wrong_clouds.txt`.

use std::fs;

use glam::DVec3;
use kugelblitz::Error;
use kugelblitz::control::Control;
use kugelblitz::scene::{Color, MAX_OBJECTS, Scene, Sphere, Spheres, read_scene, read_scene_with};
use kugelblitz_tests::folder::Folder;
use kugelblitz_tests::{npy, root};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RADIUS: &str = "radius = 0.25";
const COLOR: &str = "color = [0.25, 0.5, 1.0]";

fn both() -> String {
    format!("{RADIUS}\n{COLOR}")
}

/// A sphere and its colour.
type Colored = (Sphere, Color);

fn sphere(x: f64, y: f64, z: f64, radius: f64, color: impl Into<Color>) -> Colored {
    (Sphere { center: DVec3::new(x, y, z), radius }, color.into())
}

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

/// The first `n_columns` of x, y, z, r, red, green, blue.
fn columns((sphere, color): &Colored, n_columns: usize) -> Vec<f64> {
    let all = [&sphere.center.to_array()[..], &[sphere.radius], &color.0].concat();
    all[..n_columns].to_vec()
}

#[test]
fn npy_of_every_type_order_and_shape_is_read_as_it_is_written() {
    let folder = Folder::default();
    for n_columns in [3, 4, 7] {
        let mut spheres = some_spheres(1000, n_columns as u64);
        let rows: Vec<_> = spheres.iter().map(|sphere| columns(sphere, n_columns)).collect();
        let mut keys = String::new();
        if n_columns < 4 {
            keys += RADIUS;
            spheres.iter_mut().for_each(|(sphere, _)| sphere.radius = 0.25);
        }
        if n_columns < 7 {
            keys = format!("{keys}\n{COLOR}");
            spheres.iter_mut().for_each(|(_, color)| *color = Color([0.25, 0.5, 1.0]));
        }
        let spheres = Spheres::from_iter(spheres);
        let sphere_bytes = if n_columns < 7 { 32 } else { 56 };
        assert_eq!(spheres.bytes(), 1000 * sphere_bytes);
        for value in ["<f4", ">f4", "<f8", ">f8"] {
            for fortran in [false, true] {
                let bytes = npy(&rows, value, fortran);
                let scene = folder.cloud("a.npy", bytes, &keys).unwrap();
                assert!(scene.spheres == spheres, "{n_columns} {value} {fortran}");
                assert_eq!(scene.spheres.capacity(), spheres.len());
                assert_eq!(scene.bytes(), spheres.bytes());
            }
        }
    }
    // A file longer than what is decoded at once, and one without rows.
    let spheres = some_spheres(70_001, 5);
    for fortran in [false, true] {
        let rows: Vec<_> = spheres.iter().map(|sphere| columns(sphere, 7)).collect();
        let scene = folder.cloud("a.npy", npy(&rows, "<f8", fortran), "").unwrap();
        assert!(scene.spheres == Spheres::from_iter(spheres.clone()));
    }
    let scene = folder.cloud("a.npy", npy(&[], "<f8", false), &both()).unwrap();
    assert_eq!(scene.n_objects(), 0);
}

#[test]
fn csv_is_read_by_its_header() {
    let folder = Folder::default();
    let spheres = some_spheres(3000, 3);
    let mut text = "x,y,z,r,red,green,blue\n".to_string();
    for sphere in &spheres {
        let values: Vec<_> = columns(sphere, 7).iter().map(|x| format!("{x:?}")).collect();
        text += &(values.join(",") + "\n");
    }
    let scene = folder.cloud("a.csv", &text, "").unwrap();
    assert!(scene.spheres == Spheres::from_iter(spheres));

    // Any order, other columns, spaces, quotes, Windows' line ends, a byte order mark, no last line
    // break, empty lines.
    let text = "\u{feff}\"Z\",mass, r ,X,y\r\n3,9,\"0.5\",1e0, 2 \r\n\r\n-3.5,heavy,1,.5,+2";
    let scene = folder.cloud("a.csv", text, COLOR).unwrap();
    let color = [0.25, 0.5, 1.0];
    let expected = [sphere(1.0, 2.0, 3.0, 0.5, color), sphere(0.5, 2.0, -3.5, 1.0, color)];
    assert_eq!(scene.spheres, Spheres::from_iter(expected));

    let scene = folder.cloud("A.CSV", "x,y,z,red,green,blue\n1,2,3,0.5,0,1\n", RADIUS).unwrap();
    assert_eq!(scene.spheres, Spheres::from_iter([sphere(1.0, 2.0, 3.0, 0.25, [0.5, 0.0, 1.0])]));
    let scene = folder.cloud("a.csv", "x,y,z\n", &both()).unwrap();
    assert_eq!(scene.n_objects(), 0);
    // The nearest f64, as everywhere in a scene.
    let middle = "1.00000000000000011102230246251565404236316680908203126";
    let scene = folder.cloud("a.csv", format!("x,y,z\n{middle},0,0\n"), &both()).unwrap();
    assert_eq!(scene.spheres[0].center.x, 1.0 + f64::EPSILON);
}

/// Alvarez's radii and the CPK colours of some common elements.
#[test]
fn xyz_has_radius_and_colour_by_element() {
    let folder = Folder::default();
    let text = "5\nany text, also none\nH 0 0 0\n  c  1 2.5 -3e0  0.17 # charge\nO\t1 1 1\r\n\
                CL 0 0 9\nfe 0 0 -9\n\n";
    let scene = folder.cloud("a.xyz", text, "").unwrap();
    let srgb = Color::from_srgb8;
    let expected = [
        sphere(0.0, 0.0, 0.0, 1.20, srgb([255, 255, 255])),
        sphere(1.0, 2.5, -3.0, 1.77, srgb([0x90, 0x90, 0x90])),
        sphere(1.0, 1.0, 1.0, 1.50, srgb([0xff, 0x0d, 0x0d])),
        sphere(0.0, 0.0, 9.0, 1.82, srgb([0x1f, 0xf0, 0x1f])),
        sphere(0.0, 0.0, -9.0, 2.44, srgb([0xe0, 0x66, 0x33])),
    ];
    assert_eq!(scene.spheres, Spheres::from_iter(expected));
    assert_eq!(folder.cloud("a.xyz", "0\n\n", "").unwrap().n_objects(), 0);
}

/// The periodic table in its order, as another source than the program's.
const SYMBOLS: &str = "H He Li Be B C N O F Ne Na Mg Al Si P S Cl Ar K Ca Sc Ti V Cr Mn Fe Co Ni Cu \
    Zn Ga Ge As Se Br Kr Rb Sr Y Zr Nb Mo Tc Ru Rh Pd Ag Cd In Sn Sb Te I Xe Cs Ba La Ce Pr Nd Pm \
    Sm Eu Gd Tb Dy Ho Er Tm Yb Lu Hf Ta W Re Os Ir Pt Au Hg Tl Pb Bi Po At Rn Fr Ra Ac Th Pa U Np \
    Pu Am Cm Bk Cf Es Fm Md No Lr";

#[test]
fn the_table_of_elements_is_sane() {
    let folder = Folder::default();
    let (mut unknown, mut radii, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    for symbol in SYMBOLS.split_whitespace() {
        match folder.cloud("a.xyz", format!("1\n\n{symbol} 0 0 0\n"), "") {
            Ok(scene) => {
                let radius = scene.spheres[0].radius;
                // The smallest is hydrogen's, the largest caesium's.
                assert!((1.20..=3.48).contains(&radius), "{symbol}: {radius}");
                assert_eq!((radius * 100.0).round() / 100.0, radius, "{symbol}");
                radii.push((symbol, radius));
                colors.push(scene.spheres.color(0).unwrap().to_srgb8());
            }
            Err(_) => unknown.push(symbol),
        }
    }
    assert_eq!(unknown.join(" "), "Pm Po At Rn Fr Ra Fm Md No Lr");
    let radius = |wanted: &str| radii.iter().find(|(symbol, _)| *symbol == wanted).unwrap().1;
    // Atoms grow down a group and shrink along a period's main groups.
    for column in [["Li", "Na", "K", "Rb", "Cs"], ["F", "Cl", "Br", "I", ""]] {
        for pair in column.windows(2).filter(|pair| !pair[1].is_empty()) {
            assert!(radius(pair[0]) < radius(pair[1]), "{pair:?}");
        }
    }
    for pair in ["C", "N", "O", "F"].windows(2) {
        assert!(radius(pair[0]) > radius(pair[1]), "{pair:?}");
    }
    let n_colors = colors.len();
    colors.sort();
    colors.dedup();
    assert_eq!(colors.len(), n_colors, "two elements of one colour");
}

#[test]
fn single_spheres_come_first_then_clouds_then_planes() {
    let folder = Folder::default();
    fs::create_dir(folder.path("more")).unwrap();
    folder.write("more/a.npy", npy(&[vec![1.0, 0.0, 0.0], vec![2.0, 0.0, 0.0]], "<f8", false));
    folder.write("b.csv", "x,y,z,r\n3,0,0,1\n");
    folder.write("c.xyz", "1\n\nC 4 0 0\n");
    let plane = "[[plane]]\npoint = [9, 0, 0]\nnormal = [1, 0, 0]\ncolor = \"#000000\"\n";
    let ball = |x| format!("[[sphere]]\ncenter = [{x}, 0, 0]\nradius = 1\ncolor = \"#ffffff\"\n");
    let scene = folder
        .read(&format!(
            "{plane}[[spheres]]\nfile = \"more/a.npy\"\n{}\n{}[[spheres]]\nfile = \"b.csv\"\n\
             {COLOR}\n[[spheres]]\nfile = \"c.xyz\"\n{}[[spheres]]\nfile = \"b.csv\"\n{COLOR}\n",
            both(),
            ball(-2),
            ball(-1),
        ))
        .unwrap();
    let xs: Vec<f64> = scene.spheres.iter().map(|sphere| sphere.center.x).collect();
    assert_eq!(xs, [-2.0, -1.0, 1.0, 2.0, 3.0, 4.0, 3.0]);
    assert_eq!((scene.n_objects(), scene.planes.len()), (8, 1));
    let clouds: Vec<_> = scene
        .clouds
        .iter()
        .map(|cloud| (cloud.path.clone(), cloud.n_spheres, cloud.first_id))
        .collect();
    let expected = [("more/a.npy", 2, 3), ("b.csv", 1, 5), ("c.xyz", 1, 6), ("b.csv", 1, 7)];
    let expected = expected.map(|(name, n, first)| (folder.path(name), n, first));
    assert_eq!(clouds, expected);
    for (id, x) in (1..).zip(&xs) {
        let Some(kugelblitz::scene::Object::Sphere(sphere)) = scene.object(id) else {
            panic!("{id}")
        };
        assert_eq!(sphere.center.x, *x);
    }
    assert!(matches!(scene.object(8), Some(kugelblitz::scene::Object::Plane(_))));
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
    folder.read(&format!("[[spheres]]\nfile = \"a.npy\"\n{}\n", both()))
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
    let rows: Vec<_> = spheres.iter().map(|sphere| columns(sphere, 7)).collect();
    let files = [
        ("a.npy", npy(&rows, "<f8", false), 1),
        ("a.csv", b"x,y,z,r,red,green,blue\n1,2,3,4,0,0,0".to_vec(), 2),
        ("a.xyz", b"1\n\nC 0 0 0\n".to_vec(), 1),
    ];
    for (name, bytes, n_passes) in files {
        folder.cloud(name, &bytes, "").unwrap();
        let control = Control::default();
        read_scene_with(&folder.path("scene.toml"), &control).unwrap();
        let n_bytes = n_passes * bytes.len() as u64;
        assert_eq!(control.bytes(), (n_bytes, n_bytes), "{name}");
        control.cancel();
        let stopped = read_scene_with(&folder.path("scene.toml"), &control);
        assert!(matches!(stopped, Err(Error::Interrupted)), "{name}: {stopped:?}");
    }
}

/// Pipes have no length and can't be gone through twice.
#[cfg(unix)]
#[test]
fn clouds_come_through_pipes() {
    let folder = Folder::default();
    let spheres = some_spheres(5000, 8);
    let rows: Vec<_> = spheres.iter().map(|sphere| columns(sphere, 7)).collect();
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
        let scene = folder.read(&format!("[[spheres]]\nfile = \"{name}\"\n")).unwrap();
        writer.join().unwrap();
        assert!(scene.spheres == Spheres::from_iter(spheres.clone()), "{name}");
    }
}

#[test]
fn caffeine_is_caffeine() {
    let path = root().join("scenes/clouds/caffeine.toml");
    let scene = read_scene(&path).unwrap();
    // C₈H₁₀N₄O₂, counted by radius.
    let n_of = |radius: f64| scene.spheres.iter().filter(|s| s.radius == radius).count();
    assert_eq!([1.77, 1.20, 1.66, 1.50].map(n_of), [8, 10, 4, 2]);
    // Each atom has a neighbour at the length of a bond, and none is nearer.
    for (i, atom) in scene.spheres.iter().enumerate() {
        let others = scene.spheres.iter().enumerate().filter(|(j, _)| *j != i);
        let nearest = others.map(|(_, s)| s.center.distance(atom.center)).fold(9.0, f64::min);
        assert!((1.0..1.4).contains(&nearest), "atom {}: {nearest} Å", i + 1);
    }
}
