//! Coordinates relative to a box: LAMMPS' dumps, against LAMMPS' formulas in exact rational arithmetic.

use std::fs;

use kugelblitz_tests::folder::Folder;
use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Keys, folder, read};

/// Dumps of LAMMPS 22 Jul 2025: all columns of three atoms, or scaled coordinates alone.
pub const DUMPS: [&str; 8] = [
    "lammps_box.dump",
    "lammps_tilted.dump",
    "lammps_restricted.dump",
    "lammps_general.dump",
    "lammps_general_origin.dump",
    "lammps_tilted_atom.dump",
    "lammps_general_atom.dump",
    "tilt_0.dump",
];

/// Returns the centres in a dump, with all columns renamed that are not in this list.
fn centers(text: &str, columns: &[&str]) -> Vec<[f64; 3]> {
    let line = text.lines().find(|line| line.starts_with("ITEM: ATOMS")).expect("a header");
    let names = line.split(' ').skip(2);
    let names: Vec<String> = names
        .map(|name| if columns.contains(&name) { name.into() } else { format!("hidden_{name}") })
        .collect();
    let folder = Folder::default();
    folder.write("a.dump", text.replace(line, &format!("ITEM: ATOMS {}", names.join(" "))));
    let read = read(&folder.path("a.dump"), &Keys::new("radius = 0.5")).expect("a dump");
    read.scene.spheres.iter().map(|sphere| sphere.center.to_array()).collect()
}

fn largest_difference(one: &[[f64; 3]], other: &[[f64; 3]]) -> f64 {
    assert_eq!(one.len(), other.len());
    let pairs = one.as_flattened().iter().zip(other.as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Agrees to the ten digits that LAMMPS was made to write; to the six of a plain box.
#[test]
fn columns_of_real_dumps_are_the_same_places() {
    for (file, bound) in [
        ("lammps_tilted.dump", 1e-8),
        ("lammps_restricted.dump", 1e-8),
        ("lammps_general.dump", 1e-8),
        ("lammps_general_origin.dump", 1e-8),
        ("lammps_box.dump", 1e-5),
    ] {
        let text = fs::read_to_string(folder().join(file)).expect("a dump");
        let places = centers(&text, &["x", "y", "z"]);
        let scaled = centers(&text, &["xs", "ys", "zs"]);
        assert!(largest_difference(&places, &scaled) < bound, "{file}: {places:?} {scaled:?}");
        if !text.contains("xsu") {
            continue;
        }
        let unwrapped = centers(&text, &["xu", "yu", "zu"]);
        let scaled = centers(&text, &["xsu", "ysu", "zsu"]);
        assert!(
            largest_difference(&unwrapped, &scaled) < bound,
            "{file}: {unwrapped:?} {scaled:?}"
        );
        // The first atom is in another image of the box.
        assert!(largest_difference(&places, &unwrapped) > 1.0, "{file}");
        if !file.contains("general") {
            let mixed = centers(&text, &["x", "ys", "z"]);
            assert!(largest_difference(&places, &mixed) < bound, "{file}: {mixed:?}");
        }
    }
    for (file, other) in [
        ("lammps_tilted_atom.dump", "lammps_tilted.dump"),
        ("lammps_general_atom.dump", "lammps_general.dump"),
    ] {
        let [scaled, places] =
            [file, other].map(|file| fs::read_to_string(folder().join(file)).expect("a dump"));
        let scaled = centers(&scaled, &["xs", "ys", "zs"]);
        let places = centers(&places, &["x", "y", "z"]);
        assert!(largest_difference(&places, &scaled) < 2e-5, "{file}: {places:?} {scaled:?}");
    }
}

fn exact(number: f64) -> BigRational {
    BigRational::from_float(number).expect("a finite number")
}

/// A box as LAMMPS describes it, and the three lines of a dump.
struct DumpBox {
    origin: [BigRational; 3],
    edges: [[BigRational; 3]; 3],
    kind: &'static str,
    rows: Vec<Vec<f64>>,
}

fn least<'n>(numbers: impl IntoIterator<Item = &'n BigRational>) -> BigRational {
    numbers.into_iter().min().expect("a number").clone()
}

fn most<'n>(numbers: impl IntoIterator<Item = &'n BigRational>) -> BigRational {
    numbers.into_iter().max().expect("a number").clone()
}

/// Draws a box: without angles, tilted (`xy xz yz`) or general (`abc origin`).
///
/// Lengths and tilts are multiples of 2⁻¹⁰, so that the bounds of a tilted box are numbers of f64.
fn random_box(rng: &mut ChaCha8Rng, kind: usize) -> DumpBox {
    let mut number = |low: f64, high: f64| (rng.random_range(low..high) * 1024.0).round() / 1024.0;
    let low = [(); 3].map(|()| number(-50.0, 50.0));
    let size = [(); 3].map(|()| number(0.5, 40.0));
    let zero = BigRational::zero;
    if kind == 2 {
        let edges = [(); 3].map(|()| [(); 3].map(|()| number(-20.0, 20.0)));
        return DumpBox {
            origin: low.map(exact),
            edges: edges.map(|edge| edge.map(exact)),
            kind: "abc origin",
            rows: (0..3).map(|row| [&edges[row][..], &[low[row]]].concat()).collect(),
        };
    }
    // Tilts of either sign, beyond half a side, and zero.
    let mut tilt = |side: f64| {
        if kind == 1 && rng.random_bool(0.85) { rng.random_range(-1.2..1.2) * side } else { 0.0 }
    };
    let tilts =
        [tilt(size[0]), tilt(size[0]), tilt(size[1])].map(|tilt| (tilt * 1024.0).round() / 1024.0);
    let [xy, xz, yz] = tilts.map(exact);
    let [lx, ly, lz] = size.map(exact);
    let origin = low.map(exact);
    let high: Vec<BigRational> =
        origin.iter().zip([&lx, &ly, &lz]).map(|(low, size)| low + size).collect();
    // The formulas of LAMMPS' manual, "Howto triclinic".
    let sum = &xy + &xz;
    let x = [zero(), xy.clone(), xz.clone(), sum];
    let y = [zero(), yz.clone()];
    let bounds = [
        [&origin[0] + least(&x), &high[0] + most(&x)],
        [&origin[1] + least(&y), &high[1] + most(&y)],
        [origin[2].clone(), high[2].clone()],
    ];
    let rounded = |number: &BigRational| number.to_f64().expect("a number");
    let rows = bounds.iter().zip(tilts).map(|(bounds, tilt)| {
        let mut row: Vec<f64> = bounds.iter().map(rounded).collect();
        row.extend((kind == 1).then_some(tilt));
        row
    });
    let kind = if kind == 1 { "xy xz yz pp pp pp" } else { "pp pp pp" };
    let rows = rows.collect();
    let edges = [[lx, zero(), zero()], [xy, ly, zero()], [xz, yz, lz]];
    DumpBox { origin, edges, kind, rows }
}

/// Writes a dump of these atoms, with all digits.
fn dump(DumpBox { kind, rows, .. }: &DumpBox, columns: &str, atoms: &[[f64; 3]]) -> String {
    let line = |row: &[f64]| row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ") + "\n";
    let rows: String = rows.iter().map(|row| line(row)).collect();
    let atoms_lines: String = atoms.iter().map(|atom| line(atom)).collect();
    format!(
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS {kind}\n{rows}ITEM: ATOMS {columns}\n{atoms_lines}",
        atoms.len()
    )
}

/// Compares the same atoms as `x y z` and as `xs ys zs`, in all kinds of boxes: they agree to 1e-12 of the box.
#[test]
fn scaled_coordinates_agree_with_exact_ones() {
    let seed = std::env::var("KUGELBLITZ_SEED").map_or(1, |seed| seed.parse().expect("a seed"));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut largest: f64 = 0.0;
    for case in 0..300 {
        let box_of_dump = random_box(&mut rng, case % 3);
        let scaled: Vec<[f64; 3]> =
            (0..5).map(|_| [(); 3].map(|()| rng.random_range(-0.25..1.25))).collect();
        // (xlo, ylo, zlo) + xs a + ys b + zs c.
        let places: Vec<[f64; 3]> = scaled
            .iter()
            .map(|scaled| {
                let place = |axis: usize| {
                    let along = box_of_dump.edges.iter().zip(scaled);
                    let parts = along.map(|(edge, scale)| &edge[axis] * exact(*scale));
                    let place =
                        parts.fold(box_of_dump.origin[axis].clone(), |sum, part| sum + part);
                    place.to_f64().expect("a number")
                };
                [0, 1, 2].map(place)
            })
            .collect();
        let scaled_text = dump(&box_of_dump, "xs ys zs", &scaled);
        let found = centers(&scaled_text, &["xs", "ys", "zs"]);
        let direct = centers(&dump(&box_of_dump, "x y z", &places), &["x", "y", "z"]);
        assert_eq!(direct, places);
        let difference = largest_difference(&found, &direct) / 100.0;
        largest = largest.max(difference);
        assert!(
            difference <= 1e-12,
            "case {case}, KUGELBLITZ_SEED={seed}: {difference}\n{scaled_text}"
        );
        if case % 3 < 2 {
            // One coordinate of the three is relative to the box.
            let mixed: Vec<[f64; 3]> = places
                .iter()
                .zip(&scaled)
                .map(|(place, scaled)| [place[0], scaled[1], place[2]])
                .collect();
            let text = dump(&box_of_dump, "x ysu z", &mixed);
            let difference =
                largest_difference(&centers(&text, &["x", "ysu", "z"]), &places) / 100.0;
            assert!(
                difference <= 1e-12,
                "case {case}, KUGELBLITZ_SEED={seed}: {difference}\n{text}"
            );
        }
    }
    println!("largest difference: {largest:e} of the box");
}
