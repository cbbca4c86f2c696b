//! What a sphere may cover of a picture, against exact arithmetic; and the hierarchy over it,
//! against a look at every footprint.

use std::collections::HashSet;
use std::ops::{Range, RangeInclusive};
use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::exact::{ExactPixels, Root, Shape, real, signum_of_discriminant, visible_root};
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::scene::{self, Camera, Sphere};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz::tree::footprint::{Footprint, Projection};
use kugelblitz::tree::footprints::{Footprints, Node};
use kugelblitz::tree::{IS_LEAF, Tree};
use kugelblitz::verify::{Truth, compare_to_exact};
use kugelblitz_tests::cases::{any_vector, integer_vector, nudged};
use kugelblitz_tests::{cases, in_cube, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// A picture of one sphere.
#[derive(Clone, Copy, Debug)]
struct Setup {
    pixels: Pixels,
    center: DVec3,
    radius: f64,
}

impl Setup {
    fn l(&self) -> DVec3 {
        self.center - self.pixels.view.position
    }

    fn footprint(&self) -> Option<Footprint> {
        Projection::new(&self.pixels).footprint(self.l(), self.radius)
    }

    fn cell_shift(&self) -> u32 {
        Projection::new(&self.pixels).cell_shift()
    }

    fn shape(&self) -> Shape {
        cases::sphere(self.center, self.radius)
    }

    fn paste(&self, [x, y]: [u32; 2]) -> String {
        let Setup { pixels, center, radius } = self;
        format!("pixel ({x}, {y}) of {pixels:?}, {center:?}, {radius:e}")
    }
}

/// The cells of a pixel.
fn cell([x, y]: [u32; 2], shift: u32) -> [u16; 2] {
    [x, y].map(|pixel| u16::try_from(pixel >> shift).unwrap())
}

fn holds(footprint: &Footprint, [column, row]: [u16; 2]) -> bool {
    let Footprint { columns, rows, .. } = footprint;
    (columns[0]..=columns[1]).contains(&column) && (rows[0]..=rows[1]).contains(&row)
}

/// What a footprint says wrongly of a pixel in `cell` whose exact ray hits the sphere at `t`.
fn contradiction(footprint: Option<&Footprint>, cell: [u16; 2], t: &Root) -> Option<&'static str> {
    let Some(footprint) = footprint else { return Some("no footprint") };
    if !holds(footprint, cell) {
        return Some("cell outside");
    }
    t.cmp_real(&real(footprint.t.into()).unwrap()).is_lt().then_some("t too large")
}

/// A number whose binary logarithm is uniform.
fn log2_uniform(rng: &mut ChaCha8Rng, exponents: Range<f64>) -> f64 {
    rng.random_range(exponents).exp2()
}

fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
    any_vector(rng, 1.0).normalize()
}

/// A frame along the axes.
fn axes(rng: &mut ChaCha8Rng) -> [DVec3; 3] {
    let first = rng.random_range(0..3);
    let order = match rng.random() {
        true => [first, (first + 1) % 3, (first + 2) % 3],
        false => [first, (first + 2) % 3, (first + 1) % 3],
    };
    order.map(|axis| DVec3::AXES[axis] * if rng.random() { 1.0 } else { -1.0 })
}

fn any_frame(rng: &mut ChaCha8Rng) -> [DVec3; 3] {
    let camera = Camera {
        position: DVec3::ZERO,
        look_at: unit(rng),
        up: unit(rng),
        projection: scene::Projection::Perspective { fov_degrees: 45.0 },
    };
    let View { forward, right, true_up, .. } = View::new(&camera);
    [forward, right, true_up]
}

fn picture(eye: DVec3, frame: [DVec3; 3], h: f64, [width, height]: [u32; 2]) -> Pixels {
    let [forward, right, true_up] = frame;
    Pixels::whole(
        View { position: eye, forward, right, true_up, h, lens: Lens::Perspective },
        width,
        height,
    )
}

/// Any picture of this size in the range of the proof.
fn any_picture(rng: &mut ChaCha8Rng, size: [u32; 2]) -> Pixels {
    loop {
        let mut frame = if rng.random_bool(0.2) { axes(rng) } else { any_frame(rng) };
        if rng.random_bool(0.4) {
            let off = log2_uniform(rng, -52.0..-11.0);
            frame = frame.map(|v| v + any_vector(rng, off));
        }
        let eye = match rng.random_range(0..5) {
            0 => integer_vector(rng, 100),
            1 => any_vector(rng, 1e7),
            2 => any_vector(rng, 1e15),
            _ => DVec3::ZERO,
        };
        let h = match rng.random_range(0..6) {
            0 => log2_uniform(rng, -60.0..-8.0),
            1 => log2_uniform(rng, 3.0..30.0),
            2 => log2_uniform(rng, -1070.0..-60.0),
            _ => log2_uniform(rng, -8.0..3.0),
        };
        let pixels = picture(eye, frame, h, size);
        if pixels.is_in_range() {
            return pixels;
        }
    }
}

/// Where on the sphere the pixel's ray meets it, if it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Aim {
    /// At the left or right edge.
    Columns,
    /// At the upper or lower edge.
    Rows,
    /// Somewhere along the silhouette.
    Silhouette,
    /// Where `t` is least.
    Front,
    /// The sphere is anywhere, with no regard to the ray.
    Anywhere,
    /// The sphere lies beside the eye, across the plane `t = 0`.
    Beside,
}

const AIMS: [Aim; 6] =
    [Aim::Columns, Aim::Rows, Aim::Silhouette, Aim::Front, Aim::Anywhere, Aim::Beside];

/// Distances and radii that a footprint is made for.
const LARGEST: f64 = (1u64 << 60) as f64;
const SMALLEST_RADIUS: f64 = 1.0 / (1u64 << 40) as f64;

/// A sphere for the ray of a pixel.
fn aimed(rng: &mut ChaCha8Rng, pixels: &Pixels, [x, y]: [u32; 2], aim: Aim) -> Setup {
    let View { position, forward, right, true_up, h, .. } = pixels.view;
    let step = h / f64::from(pixels.image_height);
    let (i, j) = pixels.offset2(x, y);
    let d = pixels.direction(x, y);
    let [sign, sign_of_error] = [(); 2].map(|()| if rng.random() { 1.0 } else { -1.0 });
    // Perpendicular to all rays of the column, of the row.
    let across = (forward + right * (step * i as f64)).cross(true_up);
    let upward = (forward + true_up * (step * j as f64)).cross(right);
    loop {
        let distance = log2_uniform(rng, -38.0..58.0);
        let at = d.normalize() * distance;
        let radius = distance * log2_uniform(rng, -24.0..12.0);
        let l = match aim {
            Aim::Columns => at + across.normalize() * (sign * radius),
            Aim::Rows => at + upward.normalize() * (sign * radius),
            Aim::Silhouette => at + d.cross(unit(rng)).normalize() * radius,
            Aim::Front => at + right.cross(true_up).normalize() * (sign * radius),
            Aim::Anywhere => unit(rng) * distance,
            Aim::Beside => {
                let beside = unit(rng).cross(forward).normalize();
                beside * distance + forward * (rng.random_range(-2.0..2.0) * radius.min(distance))
            }
        };
        let radius = match rng.random_range(0..4) {
            0 => nudged(rng, radius),
            _ => radius * (1.0 + sign_of_error * log2_uniform(rng, -53.0..0.0) * 0.9),
        };
        if l.length() < LARGEST && (SMALLEST_RADIUS..LARGEST).contains(&radius) {
            return Setup { pixels: *pixels, center: position + l, radius };
        }
    }
}

/// A pixel and those around it, and some others.
fn pixels_to_look_at(rng: &mut ChaCha8Rng, pixels: &Pixels, [x, y]: [u32; 2]) -> Vec<[u32; 2]> {
    let size = [pixels.image_width, pixels.image_height];
    let near = |rng: &mut ChaCha8Rng, at: u32, n: u32| {
        (at + rng.random_range(0..3)).saturating_sub(1).min(n - 1)
    };
    let mut chosen = vec![[x, y]];
    for _ in 0..4 {
        chosen.push([near(rng, x, size[0]), near(rng, y, size[1])]);
    }
    chosen.push(size.map(|n| rng.random_range(0..n)));
    chosen
}

/// What a search through random cases found.
#[derive(Clone, Debug, Default)]
struct Found {
    /// Pixels that hit the sphere they look for.
    hits: u64,
    /// Those of them in the first or last column or row of the footprint.
    at_an_edge: u64,
    /// Those of them whose `t` is hardly above the bound.
    at_the_front: u64,
    wrong: Vec<String>,
}

impl Found {
    fn and(mut self, other: Found) -> Found {
        self.hits += other.hits;
        self.at_an_edge += other.at_an_edge;
        self.at_the_front += other.at_the_front;
        self.wrong.extend(other.wrong);
        self
    }
}

/// Looks at some pixels of one picture of a sphere, with its footprint changed.
fn look(setup: &Setup, chosen: &[[u32; 2]], change: impl Fn(Footprint) -> Footprint) -> Found {
    let (footprint, shift) = (setup.footprint().map(change), setup.cell_shift());
    let exact = ExactPixels::new(&setup.pixels);
    let mut found = Found::default();
    for &[x, y] in chosen {
        let Some((t, _)) = visible_root(&exact.ray(x, y), &setup.shape()) else { continue };
        let cell = cell([x, y], shift);
        found.hits += 1;
        if let Some(Footprint { columns, rows, t: low }) = footprint {
            let [column, row] = cell;
            found.at_an_edge += u64::from(columns.contains(&column) || rows.contains(&row));
            let near = f64::from(low) * (1.0 + 2f64.powi(-20));
            found.at_the_front += u64::from(t.cmp_real(&real(near).unwrap()).is_lt());
        }
        if let Some(what) = contradiction(footprint.as_ref(), cell, &t) {
            let case = setup.paste([x, y]);
            found.wrong.push(format!("{what} {cell:?}, t = {}: {footprint:?}, {case}", t.to_f64()));
        }
    }
    found
}

/// Searches `n` random spheres in pictures of these sizes.
fn search(
    seed: u64,
    n: u64,
    size: impl Fn(&mut ChaCha8Rng) -> [u32; 2] + Sync,
    change: impl Fn(Footprint) -> Footprint + Sync,
) -> Found {
    let one = |index: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index);
        let size = size(&mut rng);
        let pixels = any_picture(&mut rng, size);
        let pixel = size.map(|n| rng.random_range(0..n));
        let setup = aimed(&mut rng, &pixels, pixel, AIMS[index as usize % AIMS.len()]);
        let chosen = pixels_to_look_at(&mut rng, &pixels, pixel);
        look(&setup, &chosen, &change)
    };
    (0..n).into_par_iter().map(one).reduce(Found::default, Found::and)
}

fn small_size(rng: &mut ChaCha8Rng) -> [u32; 2] {
    match rng.random_range(0..4) {
        0 => [rng.random_range(1..9), rng.random_range(1..9)],
        1 => [rng.random_range(1..5000), rng.random_range(1..3000)],
        _ => [rng.random_range(1..90), rng.random_range(1..90)],
    }
}

/// Columns or rows of a picture up to which each pixel is a cell.
const MOST_CELLS: u32 = (1 << 15) - 1;

/// Cells of several pixels, up to the largest picture.
fn huge_size(rng: &mut ChaCha8Rng) -> [u32; 2] {
    let side = |rng: &mut ChaCha8Rng| log2_uniform(rng, 15.0..23.0).ceil() as u32 + 1;
    match rng.random_range(0..6) {
        0 => [1 << 23, 1 << 23],
        1 => [1 << 23, rng.random_range(1..2000)],
        2 => [rng.random_range(1..2000), side(rng)],
        3 => [MOST_CELLS + rng.random_range(0..3), MOST_CELLS],
        _ => [side(rng), side(rng)],
    }
}

fn unchanged(footprint: Footprint) -> Footprint {
    footprint
}

fn assert_nothing_wrong(found: &Found, n: u64) {
    println!(
        "{n} spheres: {} hits, {} at an edge, {} at the front",
        found.hits, found.at_an_edge, found.at_the_front
    );
    assert!(found.wrong.is_empty(), "{} wrong, one of them: {}", found.wrong.len(), found.wrong[0]);
    assert!(found.hits > n / 2 && found.at_an_edge > n / 8 && found.at_the_front > n / 50);
}

#[test]
fn a_footprint_holds_every_pixel_that_hits() {
    let n = 120_000;
    assert_nothing_wrong(&search(701, n, small_size, unchanged), n);
}

#[test]
fn cells_of_huge_pictures_hold_every_pixel_that_hits() {
    let n = 30_000;
    assert_nothing_wrong(&search(702, n, huge_size, unchanged), n);
    let shift = |width| {
        let frame = [DVec3::NEG_Z, DVec3::X, DVec3::Y];
        Projection::new(&picture(DVec3::ZERO, frame, 0.5, [width, 100])).cell_shift()
    };
    let widths = [100, MOST_CELLS, MOST_CELLS + 1, 2 * MOST_CELLS, 1 << 22, 1 << 23];
    assert_eq!(widths.map(shift), [0, 0, 1, 1, 8, 9]);
}

#[test]
fn sabotage_a_smaller_footprint_is_noticed() {
    let changes: [fn(Footprint) -> Footprint; 5] = [
        |f| Footprint { columns: [f.columns[0] + 1, f.columns[1]], ..f },
        |f| Footprint { columns: [f.columns[0], f.columns[1].saturating_sub(1)], ..f },
        |f| Footprint { rows: [f.rows[0] + 1, f.rows[1]], ..f },
        |f| Footprint { rows: [f.rows[0], f.rows[1].saturating_sub(1)], ..f },
        |f| Footprint { t: f.t * (1.0 + 2f32.powi(-20)), ..f },
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let found = search(703, 2000, small_size, change);
        assert!(found.wrong.len() > 10, "change {index}: {} of {}", found.wrong.len(), found.hits);
    }
}

/// A Pythagorean triple `a² + b² = c²`.
fn pythagorean(rng: &mut ChaCha8Rng) -> [u32; 3] {
    let n = rng.random_range(1..12);
    let m = rng.random_range(n + 1..=12);
    let (a, b, c) = (m * m - n * n, 2 * m * n, m * m + n * n);
    if rng.random() { [a, b, c] } else { [b, a, c] }
}

/// A sphere that touches the ray of a pixel at its left (0), right (1), lower (2) or upper (3) edge,
/// without any rounding.
///
/// A column's rays lie in a plane with the normal `(1, 0, x)` in the frame `R, T, −f`. With
/// `x = a/b` and `a² + b² = c²` that is `(b, 0, a)/c`, so that a step along it to the centre and the
/// radius are integers. `H` is a multiple of `b`, `h` dyadic, so that a pixel has that `x`.
fn tangent(rng: &mut ChaCha8Rng, edge: usize) -> (Setup, [u32; 2]) {
    loop {
        let [a, b, c] = pythagorean(rng);
        let odd = 2 * rng.random_range(0..4) + 1;
        let exponent = rng.random_range(0..4);
        let s = rng.random_range(1..5);
        let h = f64::from(odd) / f64::from(1 << exponent);
        let height = b * odd * s;
        // i·h/H or j·h/H is a/b.
        let offset = (a * s) << exponent;
        let is_column = edge < 2;
        let width = match is_column {
            true => offset + 1 + 2 * rng.random_range(0..40),
            false => rng.random_range(1..200),
        };
        if !is_column && (offset >= height || (height - 1 - offset) % 2 != 0) {
            continue;
        }
        let sign = if rng.random() { 1.0 } else { -1.0 };
        let other = |rng: &mut ChaCha8Rng, n: u32| {
            f64::from(2 * rng.random_range(0..n)) + 1.0 - f64::from(n)
        };
        let [i, j] = match is_column {
            true => [sign * f64::from(offset), other(rng, height)],
            false => [other(rng, width), sign * f64::from(offset)],
        };
        let to_sphere = if edge.is_multiple_of(2) { 1.0 } else { -1.0 };
        let (b, slope) = (f64::from(b) * to_sphere, sign * f64::from(a) * to_sphere);
        let normal = if is_column { dvec3(b, 0.0, slope) } else { dvec3(0.0, b, slope) };
        let along = f64::from(rng.random_range(1..1000)) * 2f64.powi(rng.random_range(-12..2));
        let aside = f64::from(rng.random_range(1..1000)) * 2f64.powi(rng.random_range(-8..6));
        let radius = f64::from(c) * aside;
        // Too near the eye, a sphere has no tangents.
        if radius > 16.0 * along * f64::from(height) {
            continue;
        }
        let point = dvec3(i * h, j * h, f64::from(height)) * along;
        let [forward, right, true_up] = axes(rng);
        let eye = integer_vector(rng, 1000);
        let to_world = |v: DVec3| right * v.x + true_up * v.y + forward * v.z;
        // The normal's third component points against f.
        let normal = to_world(dvec3(normal.x, normal.y, -normal.z));
        let center = eye + to_world(point) + normal * aside;
        // Longer and shorter vectors of the frame: the same rays.
        let length = 1.0 + f64::from(rng.random_range(-3..=3)) * 2f64.powi(-13);
        let frame = [forward, right, true_up].map(|v| v * length);
        let pixels = picture(eye, frame, h, [width, height]);
        assert!(pixels.is_in_range());
        let x = (i + f64::from(width) - 1.0) / 2.0;
        let y = (f64::from(height) - 1.0 - j) / 2.0;
        let setup = Setup { pixels, center, radius };
        return (setup, [x as u32, y as u32]);
    }
}

/// Where a sphere touches a ray, its footprint ends with that pixel.
#[test]
fn tangent_rays_are_in_the_footprint() {
    let mut rng = ChaCha8Rng::seed_from_u64(704);
    for index in 0..20_000 {
        let edge = index % 4;
        let (setup, pixel) = tangent(&mut rng, edge);
        let [x, y] = pixel;
        let ray = ExactPixels::new(&setup.pixels).ray(x, y);
        assert_eq!(signum_of_discriminant(&ray, setup.center, setup.radius), Some(0));
        let found = look(&setup, &[pixel], unchanged);
        assert_eq!((found.hits, &found.wrong), (1, &vec![]), "case {index}");
        let Footprint { columns, rows, .. } = setup.footprint().unwrap();
        let ends = [columns[0], columns[1], rows[1], rows[0]][edge];
        let touches = if edge < 2 { x } else { y };
        assert_eq!(u32::from(ends), touches, "edge {edge} of {}", setup.paste(pixel));
    }
}

/// An ordinary picture: an exact frame up to rounding, `h` from 2 to the power of these exponents.
fn ordinary_picture(rng: &mut ChaCha8Rng, h: Range<f64>, size: [u32; 2]) -> Pixels {
    let frame = if rng.random_bool(0.2) { axes(rng) } else { any_frame(rng) };
    let eye = any_vector(rng, 10.0);
    picture(eye, frame, log2_uniform(rng, h), size)
}

/// The least columns and rows that hold all pixels that hit, by a look at each.
fn columns_and_rows_hit(setup: &Setup) -> Option<[[u32; 2]; 2]> {
    let Setup { pixels, .. } = setup;
    let exact = ExactPixels::new(pixels);
    let hit = (0..pixels.len()).map(|index| pixels.xy(index));
    let hit = hit.filter(|&(x, y)| visible_root(&exact.ray(x, y), &setup.shape()).is_some());
    hit.fold(None, |hull, (x, y)| {
        let [columns, rows] = hull.unwrap_or([[x; 2], [y; 2]]);
        Some([[columns[0].min(x), columns[1].max(x)], [rows[0].min(y), rows[1].max(y)]])
    })
}

/// How much wider than the pixels that hit a footprint is on each side, px.
fn wider_by(footprint: &Footprint, [columns, rows]: [[u32; 2]; 2]) -> [i64; 4] {
    let sides = |[first, last]: [u16; 2], hit: [u32; 2]| {
        [i64::from(hit[0]) - i64::from(first), i64::from(last) - i64::from(hit[1])]
    };
    let [left, right] = sides(footprint.columns, columns);
    let [upper, lower] = sides(footprint.rows, rows);
    [left, right, upper, lower]
}

const TIGHT: RangeInclusive<i64> = 0..=1;

/// Within the picture a footprint is at most one pixel a side wider than the pixels that hit.
///
/// A silhouette there is an ellipse with `A ≤ 3·B` in these views. One pixel from its leftmost point,
/// and from the three others, its chord along the column or row is at least `2B/√A ≥ 1.4` pixels long
/// for `B ≥ 1.5` pixels, so that a pixel's centre lies on it.
#[test]
fn an_ordinary_footprint_is_tight() {
    let one = |index: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(705);
        rng.set_stream(index);
        let size = [rng.random_range(8..70), rng.random_range(24..50)];
        let pixels = ordinary_picture(&mut rng, -5.0..-0.3, size);
        let [x, y] = size.map(|n| rng.random_range(0..n));
        let depth = log2_uniform(&mut rng, -10.0..10.0);
        let pixel = 2.0 * pixels.view.h / f64::from(size[1]);
        let radius = depth * pixel * rng.random_range(1.5..12.0);
        let center = pixels.view.position + pixels.direction(x, y) * depth;
        let setup = Setup { pixels, center, radius };
        let footprint = setup.footprint()?;
        let Footprint { columns, rows, .. } = footprint;
        let sides = [(columns, size[0]), (rows, size[1])];
        if radius > depth / 4.0 || sides.iter().any(|(c, n)| c[0] < 2 || u32::from(c[1]) > n - 3) {
            return None;
        }
        let hit = columns_and_rows_hit(&setup).expect("a sphere larger than a pixel");
        let wider = wider_by(&footprint, hit);
        assert!(
            wider.iter().all(|by| TIGHT.contains(by)),
            "{wider:?} wider: {footprint:?} for {hit:?}, {}",
            setup.paste([x, y])
        );
        let [changed_columns, changed_rows] = [columns, rows].map(|[first, last]| {
            [[first - 2, last], [first, last + 2], [first + 2, last], [first, last - 2]]
        });
        let lazy = changed_columns.map(|columns| Footprint { columns, ..footprint });
        let lazy = lazy.into_iter().chain(changed_rows.map(|rows| Footprint { rows, ..footprint }));
        for lazy in lazy {
            assert!(!wider_by(&lazy, hit).iter().all(|by| TIGHT.contains(by)), "{lazy:?}");
        }
        Some(wider.iter().sum::<i64>())
    };
    let wider: Vec<i64> = (0..3000).into_par_iter().filter_map(one).collect();
    let mean = wider.iter().sum::<i64>() as f64 / (4.0 * wider.len() as f64);
    println!("{} footprints, {mean:.3} pixels wider a side", wider.len());
    assert!(wider.len() > 500);
}

/// Whether each side of a footprint is where the sphere ends, however little of it the picture shows.
///
/// A column shows the part of a plane through the eye. The first and the last column of cells are
/// right if the sphere reaches their plane, up to `2⁻⁹` pixel and `2⁻³³` of its distance.
fn is_sharp(setup: &Setup, footprint: &Footprint, shift: u32) -> bool {
    let View { forward, right, true_up, h, .. } = setup.pixels.view;
    let (l, r) = (setup.l(), setup.radius);
    let reach = r + 2f64.powi(-33) * (l.length() + r);
    let step = h / f64::from(setup.pixels.image_height);
    let size = [setup.pixels.image_width, setup.pixels.image_height];
    // How far beyond the plane of a column, or of a row from below, the centre is.
    let beyond = |axis: DVec3, at: f64| {
        let normal = axis - forward * (at * step);
        l.dot(normal) / normal.length()
    };
    let tolerance = 2f64.powi(-8);
    let sides = |axis: DVec3, [low, high]: [f64; 2]| {
        beyond(axis, low + tolerance) <= reach && beyond(axis, high - tolerance) >= -reach
    };
    let last_of = |cell: u16, n: u32| (((u32::from(cell) + 1) << shift) - 1).min(n - 1);
    let [width, height] = size.map(f64::from);
    let column = |x: u32| 2.0 * f64::from(x) + 1.0 - width;
    let row = |y: u32| height - 2.0 * f64::from(y) - 1.0;
    let Footprint { columns, rows, t } = *footprint;
    let columns = [column(last_of(columns[0], size[0])), column(u32::from(columns[1]) << shift)];
    let rows = [row(u32::from(rows[1]) << shift), row(last_of(rows[0], size[1]))];
    let least = l.dot(forward) - r;
    sides(right, columns)
        && sides(true_up, rows)
        && f64::from(t) >= least - 2f64.powi(-22) * (l.length() + r)
}

/// No footprint of a sphere in front of the eye is wider than need be: in wide views, of spheres that
/// lie in part beyond the picture, of those that cover no pixel's centre, in cells of huge pictures.
#[test]
fn no_footprint_is_lazy() {
    let (mut n, mut none, mut changed) = (0, 0, [0; 5]);
    let mut rng = ChaCha8Rng::seed_from_u64(706);
    for index in 0..100_000 {
        let size = match index % 4 {
            0 => huge_size(&mut rng),
            _ => [rng.random_range(1..500), rng.random_range(1..300)],
        };
        let pixels = ordinary_picture(&mut rng, -6.0..4.0, size);
        let pixel = size.map(|n| rng.random_range(0..n));
        let setup = aimed(&mut rng, &pixels, pixel, AIMS[index % AIMS.len()]);
        if setup.l().dot(pixels.view.forward) < setup.radius * 1.01 {
            continue;
        }
        let Some(footprint) = setup.footprint() else {
            none += 1;
            continue;
        };
        n += 1;
        let shift = setup.cell_shift();
        let sharp = |footprint: &Footprint| is_sharp(&setup, footprint, shift);
        assert!(sharp(&footprint), "{footprint:?}, {}", setup.paste(pixel));
        let Footprint { columns, rows, t } = footprint;
        let [last_column, last_row] = cell(size.map(|n| n - 1), shift);
        let lazy = [
            Footprint { columns: [columns[0].saturating_sub(1), columns[1]], ..footprint },
            Footprint { columns: [columns[0], last_column.min(columns[1] + 1)], ..footprint },
            Footprint { rows: [rows[0].saturating_sub(1), rows[1]], ..footprint },
            Footprint { rows: [rows[0], last_row.min(rows[1] + 1)], ..footprint },
            Footprint { t: t * 0.99, ..footprint },
        ];
        for (changed, lazy) in changed.iter_mut().zip(&lazy) {
            *changed += usize::from(!sharp(lazy));
        }
    }
    println!("{n} in the picture, {none} not; laziness is noticed in {changed:?}");
    assert!(n > 30_000 && none > 1000);
    assert!(changed.iter().all(|&changed| changed > n / 20), "{changed:?} of {n}");
}

/// A picture without columns shows nothing.
#[test]
fn a_picture_without_pixels_has_no_footprints() {
    let frame = [DVec3::NEG_Z, DVec3::X, DVec3::Y];
    let pixels = picture(DVec3::ZERO, frame, 0.5, [0, 5]);
    assert!(pixels.is_in_range());
    assert_eq!(Projection::new(&pixels).footprint(DVec3::NEG_Z * 3.0, 1.0), None);
}

/// A projection to a picture of this size.
fn projection(size: [u32; 2]) -> Projection {
    Projection::new(&picture(DVec3::ZERO, [DVec3::NEG_Z, DVec3::X, DVec3::Y], 0.5, size))
}

/// The least and the most of two numbers below `n`, near to each other or not.
fn any_range(rng: &mut ChaCha8Rng, n: u32) -> [u32; 2] {
    let first = rng.random_range(0..n);
    let size = log2_uniform(rng, 0.0..f64::from(n).log2() + 0.1) as u32;
    [first, (first + size - 1).min(n - 1)]
}

fn any_footprints(rng: &mut ChaCha8Rng, size: [u32; 2], n: usize) -> Vec<Footprint> {
    let shift = projection(size).cell_shift();
    let cells = size.map(|side| ((side - 1) >> shift) + 1);
    let one = |_| {
        if rng.random_bool(0.1) {
            return Footprint::NONE;
        }
        let [columns, rows] =
            cells.map(|n| any_range(rng, n).map(|cell| u16::try_from(cell).unwrap()));
        let t = if rng.random_bool(0.1) { 0.0 } else { log2_uniform(rng, -30.0..40.0) as f32 };
        Footprint { columns, rows, t }
    };
    (0..n).map(one).collect()
}

/// What is wrong with a hierarchy over these footprints; if nothing, how many nodes lie one in the
/// other.
fn check_nodes(hierarchy: &Footprints, given: &[Footprint]) -> Result<usize, String> {
    let Footprints { nodes, .. } = hierarchy;
    if nodes.len() != (2 * given.len()).saturating_sub(1) {
        return Err(format!("{} nodes for {}", nodes.len(), given.len()));
    }
    let end = |at: usize| -> Option<usize> {
        let [.., link]: [u32; 4] = bytemuck::cast(*nodes.get(at)?);
        Some(if link & IS_LEAF == 0 { link as usize } else { at + 1 })
    };
    if !nodes.is_empty() && end(0) != Some(nodes.len()) {
        return Err("the root's link".into());
    }
    let mut places = HashSet::new();
    let mut depths = vec![0; nodes.len()];
    // What is below a node stands behind it.
    for (at, node) in nodes.iter().enumerate().rev() {
        if let Some(found) = node.place() {
            let footprint = given.get(found as usize);
            if !places.insert(found) || footprint != Some(&node.footprint()) {
                return Err(format!("the leaf {at}"));
            }
            depths[at] = 1;
            continue;
        }
        let children = end(at + 1).map(|second| [at + 1, second]);
        let Some([first, second]) = children.filter(|&[_, second]| end(second) == end(at)) else {
            return Err(format!("the link of {at}"));
        };
        if node.footprint() != nodes[first].footprint().union(&nodes[second].footprint()) {
            return Err(format!("the footprint of {at}"));
        }
        if nodes[first].t() > nodes[second].t() {
            return Err(format!("the farther child of {at} is the first"));
        }
        depths[at] = 1 + depths[first].max(depths[second]);
    }
    Ok(depths.first().copied().unwrap_or(0))
}

/// Which footprints the hierarchy shows for a rectangle of pixels, sorted.
fn shown(hierarchy: &Footprints, first: [u32; 2], last: [u32; 2]) -> Vec<u32> {
    let mut shown = Vec::new();
    hierarchy.visit(hierarchy.cells(first, last), f32::INFINITY, |_, place| {
        shown.push(place as u32);
        f32::INFINITY
    });
    shown.sort_unstable();
    shown
}

/// Which footprints share a cell with a rectangle of pixels.
fn sharing(given: &[Footprint], shift: u32, first: [u32; 2], last: [u32; 2]) -> Vec<u32> {
    let (first, last) = (cell(first, shift), cell(last, shift));
    let shares = |f: &Footprint| {
        [f.columns, f.rows].iter().zip(first.iter().zip(&last)).all(
            |([low, high], (first, last))| (*low.max(first)..=*high.min(last)).next().is_some(),
        )
    };
    (0..given.len() as u32).filter(|&place| shares(&given[place as usize])).collect()
}

/// A rectangle of pixels: one of them, a block at an edge or a corner, any.
fn any_pixels(rng: &mut ChaCha8Rng, size: [u32; 2]) -> [[u32; 2]; 2] {
    let [columns, rows] = size.map(|n| match rng.random_range(0..6) {
        0 => [0, 0],
        1 => [n - 1, n - 1],
        2 => [n.saturating_sub(8), n - 1],
        3 => any_range(rng, n),
        _ => [rng.random_range(0..n); 2],
    });
    [[columns[0], rows[0]], [columns[1], rows[1]]]
}

/// In cells of one pixel, up to the most there are, and of several.
const SIZES: [[u32; 2]; 5] =
    [[1, 1], [64, 48], [MOST_CELLS, MOST_CELLS], [40_000, 300], [1 << 23, 1 << 23]];

/// A tree over spheres anywhere, which at its places have these footprints.
fn hierarchy_over(projection: &Projection, given: &[Footprint]) -> Footprints {
    let mut rng = ChaCha8Rng::seed_from_u64(given.len() as u64);
    let spheres: Vec<Sphere> = given.iter().map(|_| sphere(in_cube(&mut rng), 0.1)).collect();
    let tree = Tree::new(&spheres, &Control::default()).unwrap();
    Footprints::new(&tree, given, projection.cell_shift())
}

#[test]
fn a_hierarchy_shows_what_shares_a_cell() {
    let mut rng = ChaCha8Rng::seed_from_u64(707);
    let mut most = 0;
    for size in SIZES {
        for n in [0, 1, 2, 3, 17, 600] {
            let given = any_footprints(&mut rng, size, n);
            let hierarchy = hierarchy_over(&projection(size), &given);
            check_nodes(&hierarchy, &given).unwrap();
            let shift = projection(size).cell_shift();
            assert_eq!(hierarchy.cell_shift, shift);
            let whole = [[0, 0], size.map(|side| side - 1)];
            let seen = |&place: &u32| given[place as usize] != Footprint::NONE;
            let all: Vec<u32> = (0..n as u32).filter(seen).collect();
            assert_eq!(shown(&hierarchy, whole[0], whole[1]), all);
            for _ in 0..300 {
                let [first, last] = any_pixels(&mut rng, size);
                let right = sharing(&given, shift, first, last);
                let what = || format!("{first:?} to {last:?} of {size:?}, {given:?}");
                assert_eq!(shown(&hierarchy, first, last), right, "{}", what());
                most = most.max(if right.len() < n { right.len() } else { 0 });
            }
        }
    }
    assert!(most > 100, "at most {most} at a time");
}

/// A farther sphere is left out only where it is farther than asked for at that time.
#[test]
fn a_walk_with_a_shrinking_t_max_leaves_out_nothing_nearer() {
    let mut rng = ChaCha8Rng::seed_from_u64(708);
    let (mut n_left_out, mut n_nearest) = (0, 0);
    for index in 0..600 {
        let size = SIZES[index % SIZES.len()];
        let given = any_footprints(&mut rng, size, 300);
        let hierarchy = hierarchy_over(&projection(size), &given);
        let [first, last] = any_pixels(&mut rng, size);
        let mut t_max = f32::INFINITY;
        let mut visited = HashSet::new();
        hierarchy.visit(hierarchy.cells(first, last), f32::INFINITY, |node, place| {
            assert!(node.t() <= t_max, "{} is beyond {t_max}", node.t());
            visited.insert(place as u32);
            match rng.random_range(0..3) {
                0 => {}
                // Equal is not farther.
                1 => t_max = t_max.min(node.t()),
                _ => t_max = t_max.min(node.t() * log2_uniform(&mut rng, 0.0..20.0) as f32),
            }
            t_max
        });
        for sphere in sharing(&given, hierarchy.cell_shift, first, last) {
            let t = given[sphere as usize].t;
            let seen = visited.contains(&sphere);
            assert!(seen || t > t_max, "{sphere} at {t} up to {t_max}, {given:?}");
            n_left_out += u32::from(!seen);
            n_nearest += u32::from(t == t_max);
        }
    }
    println!("{n_left_out} left out, {n_nearest} exactly at the last t_max");
    assert!(n_left_out > 1000 && n_nearest > 100);
}

/// Neither what is all but the same nor a tree that is as deep as can be is too much.
#[test]
fn equal_spheres_and_deep_trees() {
    let size = [1 << 14, 1 << 14];
    let view = projection(size);
    let check = |what: &str, spheres: Vec<Sphere>| {
        let tree = Tree::new(&spheres, &Control::default()).unwrap();
        let footprint = |&index: &u32| {
            let Sphere { center, radius } = spheres[index as usize];
            view.footprint(center, radius).unwrap_or(Footprint::NONE)
        };
        let given: Vec<Footprint> = tree.order.iter().map(footprint).collect();
        let seen = Footprints::new(&tree, &given, view.cell_shift());
        let depth = check_nodes(&seen, &given).unwrap_or_else(|why| panic!("{what}: {why}"));
        let right = sharing(&given, 0, [0, 0], size.map(|side| side - 1));
        assert_eq!(shown(&seen, [0, 0], size.map(|side| side - 1)), right, "{what}");
        assert!(right.len() > spheres.len() / 2, "{what}: {} are seen", right.len());
        println!("{what}: {depth} deep");
        depth
    };
    let nearly_equal = |k: u32| sphere(dvec3(0.1 + 1e-14 * f64::from(k), 0.2, -3.0), 0.5);
    check("nearly equal", (0..40).map(nearly_equal).collect());
    assert!(check("nearly equal", (0..30_000).map(nearly_equal).collect()) < 100);
    // Of equal spheres there is one.
    let equal = vec![nearly_equal(0); 3000];
    assert_eq!(Tree::new(&equal, &Control::default()).unwrap().order, [0]);

    // Each one is as far from the one before as it is large.
    let chain = (0..4000).map(|k| {
        let r = (f64::from(k) / 40.0 - 40.0).exp2();
        sphere(dvec3(0.0, 0.0, -3.0 * r), r)
    });
    check("a chain", chain.collect());
    // From a few pixels to half of the picture.
    let beside = (0..2000).map(|k| {
        let r = (f64::from(k) / 160.0 + 43.0).exp2();
        sphere(dvec3(-2.0 * r, r, -(2f64.powi(60) - r) / 10.0), r)
    });
    check("a chain beside", beside.collect());
    let nested = (0..2000).map(|k| sphere(dvec3(0.0, 0.0, -3e3), 1.0 + f64::from(k)));
    check("one in the other", nested.collect());
}

#[test]
fn sabotage_a_changed_hierarchy_is_noticed() {
    let mut rng = ChaCha8Rng::seed_from_u64(709);
    let size = [64, 48];
    let given = any_footprints(&mut rng, size, 50);
    let hierarchy = hierarchy_over(&projection(size), &given);
    for at in 0..hierarchy.nodes.len() {
        // A column, a row, t, the link.
        for (word, by) in [(0, 1), (1, 1 << 16), (2, 1), (3, 1)] {
            let mut changed = hierarchy.clone();
            let mut words: [u32; 4] = bytemuck::cast(changed.nodes[at]);
            words[word] += by;
            changed.nodes[at] = bytemuck::cast::<_, Node>(words);
            assert!(check_nodes(&changed, &given).is_err(), "word {word} of {at}");
        }
    }
    let mut noticed = 0;
    for index in 0..given.len() {
        if given[index] == Footprint::NONE {
            continue;
        }
        let mut other = given.clone();
        other[index].columns[0] += 1;
        let differs = (0..2000).any(|_| {
            let [first, last] = any_pixels(&mut rng, size);
            shown(&hierarchy, first, last) != sharing(&other, 0, first, last)
        });
        noticed += usize::from(differs);
    }
    assert!(noticed > given.len() / 2, "{noticed} of {}", given.len());
}

/// Parts of a picture, at its edges and in cells of several pixels, show what is exactly there.
#[test]
fn parts_of_a_picture_show_what_is_there() {
    let wants = Wants { surface: true, level: true };
    let mut rng = ChaCha8Rng::seed_from_u64(710);
    for size in [[61, 43], [5, 300], [(1 << 15) + 3, 20_001], [1 << 23, 1 << 23]] {
        let whole = ordinary_picture(&mut rng, -2.0..-0.5, size);
        let pixel = 2.0 * whole.view.h / f64::from(size[1]);
        let parts: Vec<Pixels> = (0..9)
            .map(|index| {
                let [width, height] = [21, 13].map(|n: u32| rng.random_range(1..=n));
                let [width, height] = [width.min(size[0]), height.min(size[1])];
                let [x, y] = [size[0] - width, size[1] - height];
                let place = [[0, 0], [x, 0], [0, y], [x, y], [x / 2, y / 2]];
                let [x, y] = match place.get(index) {
                    Some(place) => *place,
                    None => [rng.random_range(0..=x), rng.random_range(0..=y)],
                };
                Pixels { x, y, width, height, ..whole }
            })
            .collect();
        let mut spheres: Vec<Sphere> = Vec::new();
        for (index, part) in parts.iter().enumerate() {
            // Far apart, or so near to each other that the walk often finds a farther one first.
            let depths = if index % 2 == 0 { -2.0..6.0 } else { 0.0..0.5 };
            for _ in 0..60 {
                let (x, y) = part.xy(rng.random_range(0..part.len()));
                let depth = log2_uniform(&mut rng, depths.clone());
                let radius = depth * pixel * rng.random_range(0.3..5.0);
                let aside = in_cube(&mut rng) * radius;
                let center = whole.view.position + whole.direction(x, y) * depth + aside;
                spheres.push(sphere(center, radius));
            }
        }
        let scene = Arc::new(scene(spheres, vec![]));
        let rays = Rays::Pixels(whole);
        let prepared =
            Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap());
        assert!(prepared.hierarchy.as_ref().is_some_and(|hierarchy| hierarchy.rest.is_empty()));
        let mut tracer = CpuTracer::new(prepared, wants);
        let control = Control::default();
        for part in parts {
            let mut hits = Hits::default();
            tracer.trace(&Rays::Pixels(part), &control, &mut hits).unwrap();
            let all = (0..part.len()).collect();
            let truth = Truth::of_pixels(&scene, &part, all, &control).unwrap();
            let against = compare_to_exact(&hits, &truth);
            let what = || format!("{part:?}: {against:?}");
            assert_eq!((against.wrong_ids(), against.t_ulp_max <= 0.501), (0, true), "{}", what());
            assert!(hits.n_hits() > 0, "{}", what());
        }
    }
}
