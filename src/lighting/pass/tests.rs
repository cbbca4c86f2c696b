//! Bounds of colours in f32 against those in f64, and both against exact arithmetic.

use std::sync::Arc;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::lit::{Certified, LightWork, Lit};
use super::super::mean::ExactMean;
use super::super::{Encoding, Lighting, Style};
use super::shadows::{BoundingBall, Extent};
use super::*;
use crate::kernel::Kernel;
use crate::prepare::Prepared;
use crate::query::{Hits, Outputs};
use crate::rays::{Pixels, Rays, View};
use crate::scene::{
    Camera, Color, Light, Plane, Projection, Samples, Scene, Source, Sphere, parse_scene,
};
use crate::shape::Surface;
use crate::support::control::Control;
use crate::tracer::Tracer;

const WIDTH: u32 = 37;
const HEIGHT: u32 = 11;

/// `n` spheres over a floor in the light of a lamp, a sun and one at the eye, from far and from near, large and
/// small.
fn scene(rng: &mut ChaCha8Rng, n: u32) -> Arc<Scene> {
    let size = 2f64.powi(rng.random_range(-8..16));
    let mut number = |least: f64, most: f64| rng.random_range(least..most);
    let mut vector = |reach: f64| {
        DVec3::new(number(-reach, reach), number(-reach, reach), number(-reach, reach))
    };
    let target = vector(1.0) * size;
    let away = vector(1.0).normalize();
    let color = Color([0.9, 0.5, 0.1]);
    let spheres = (0..n).map(|k| {
        let center = target + vector(2.0) * size;
        let radius = size * 0.3 * f64::from(1 + k % 4) * (4.0 / f64::from(n)).cbrt();
        (Sphere { center, radius }, color)
    });
    let spheres = spheres.collect();
    let normal = away + vector(0.5);
    let point = target - away * (1.5 * size);
    let plane = Plane { name: None, point, normal, color: Color([0.5; 3]) };
    let light =
        |source, shadows| Light { source, color: Color([1.0, 0.9, 0.7]), intensity: 0.6, shadows };
    let lights = vec![
        light(Source::Point(target + away * (6.0 * size) + vector(4.0) * size), true),
        light(Source::Sun(vector(1.0) - away), true),
        light(Source::Eye, false),
    ];
    let distance = size * [4.0, 30.0][usize::from(vector(1.0).x > 0.0)];
    let projection = match vector(1.0).x > 0.0 {
        true => Projection::Perspective { fov_degrees: 180.0 * size / distance },
        false => Projection::Orthographic { height: 4.0 * size },
    };
    let camera = Camera { projection, ..Camera::new(target + away * distance, target) };
    let ambient = Some(Color([0.02; 3]));
    let planes = vec![plane];
    Arc::new(Scene { camera: Some(camera), spheres, planes, lights, ambient, ..Scene::default() })
}

/// What there is to light in a picture of a scene.
struct Lights<'a> {
    job: Job<'a>,
    occluders: &'a Occluders<'a>,
}

fn with_lights(scene: &Arc<Scene>, n_samples: u32, run: &mut dyn FnMut(&Lights)) {
    let view = View::new(scene.camera.as_ref().unwrap());
    let pixels = Pixels::whole(view, WIDTH, HEIGHT).samples(n_samples);
    let rays = Rays::Pixels(pixels);
    let prepared = Prepared::new(Arc::clone(scene), Kernel::Certified, &rays).unwrap();
    let prepared = Arc::new(prepared);
    let mut hits = Hits::default();
    let mut tracer = Tracer::on_cpu(Arc::clone(&prepared), Outputs::default());
    tracer.trace(&rays, &Control::default(), &mut hits).unwrap();
    let lighting = Lighting::new(scene, &pixels.view).unwrap();
    let style = Style { n_samples: Samples::nearest(n_samples), ..Style::new(Encoding::Srgb8) };
    let lit = Lit::new(Arc::clone(scene), lighting, style);
    let occluders = Occluders::new(&prepared, &rays, &lit.lighting);
    let job = Job { lit: &lit, samples: &pixels, ids: &hits.id };
    run(&Lights { job, occluders: &occluders });
}

/// A number that no bounds tell, so that all colours are left open.
#[derive(Clone, Copy, Default)]
struct Untold;

impl PartialEq for Untold {
    fn eq(&self, _: &Untold) -> bool {
        false
    }
}

impl QuantizedPixels for Untold {
    fn of(_: f64) -> Untold {
        Untold
    }

    fn of_exact(_: &ExactMean, _: usize, _: f64) -> Untold {
        Untold
    }
}

/// Bounds of the colours of some pixels of a row.
fn bounds<F: Linear, const N: usize>(
    pass: &LightPass<F>,
    pixels: &[usize],
    scratch: &mut LightScratch<F, N>,
) -> Vec<Open> {
    let (mut open, first) = (Vec::new(), pixels[0]);
    let mut out = vec![[Untold; 3]; pixels[pixels.len() - 1] + 1 - first];
    let part = PixelBlock { pixels, known: &[], first, out: &mut out, open: &mut open };
    pass.find(part, &Control::default(), scratch).unwrap();
    open
}

/// Colours that f32 knows well: how many, and those of which this share of the bounds leaves out all that f64 says.
fn look(share: f64) -> (usize, Vec<String>) {
    let mut rng = ChaCha8Rng::seed_from_u64(1431);
    let (mut n_known, mut wrong) = (0, Vec::new());
    for number in 0..300 {
        let scene = scene(&mut rng, 4);
        with_lights(&scene, 1 + number % 2, &mut |&Lights { job, occluders }| {
            let in_f32 = LightPass::in_f32(job, occluders).unwrap();
            let in_f64 = LightPass::in_f64(job, occluders);
            let n = job.n_columns();
            for row in 0..job.samples.height as usize / job.n_samples() {
                let pixels: Vec<usize> = (row * n..(row + 1) * n).collect();
                let narrow = bounds::<f32, 16>(&in_f32, &pixels, &mut LightScratch::default());
                let wide = bounds::<f64, 8>(&in_f64, &pixels, &mut LightScratch::default());
                assert_eq!(narrow.len(), wide.len());
                for (narrow, wide) in narrow.iter().zip(&wide) {
                    assert_eq!(narrow.pixel, wide.pixel);
                    for (narrow, wide) in narrow.bounds.iter().zip(&wide.bounds) {
                        let middle = (narrow.low + narrow.high) / 2.0;
                        let half = (narrow.high - narrow.low) / 2.0;
                        if half > 1e-3 * middle {
                            continue;
                        }
                        n_known += 1;
                        let reach = share * half;
                        if middle + reach < wide.low || wide.high < middle - reach {
                            wrong.push(format!("{scene:?}: {narrow:?} {wide:?}"));
                        }
                    }
                }
            }
        });
    }
    (n_known, wrong)
}

#[test]
fn colours_are_within_their_bounds() {
    let (n_known, wrong) = look(1.0);
    assert!(wrong.is_empty(), "{} of {n_known}: {}", wrong.len(), wrong[0]);
    assert!(n_known > 200_000, "{n_known}");
}

/// The largest errors of all steps don't meet in one colour.
#[test]
fn sabotage_smaller_bounds_of_colours_are_noticed() {
    assert!(!look(1.0 / 12.0).1.is_empty());
}

/// f32 decides nearly all bytes, and those that it does are the ones of f64 or exact arithmetic; of few objects, and of a tree.
#[test]
fn bytes_are_those_that_f64_finds() {
    let mut rng = ChaCha8Rng::seed_from_u64(1432);
    let (mut n_f32, mut n_f64) = (0, 0);
    for number in 0..60 {
        let scene = scene(&mut rng, [4, 400][number as usize % 2]);
        with_lights(&scene, 1 + number % 3, &mut |&Lights { job, occluders }| {
            assert_eq!(occluders.tree.is_some(), scene.spheres.len() == 400);
            let n = job.n_columns();
            for row in 0..job.samples.height as usize / job.n_samples() {
                let [narrow, wide] = [true, false].map(|is_f32_enough| {
                    let certified = Certified::new(job, occluders, is_f32_enough);
                    let (mut out, mut work) = (vec![[0u8; 3]; n], LightWork::default());
                    work.pixels.extend(row * n..(row + 1) * n);
                    certified.find((row * n, &mut out), &Control::default(), &mut work).unwrap();
                    (out, work.counts)
                });
                assert_eq!(narrow.0, wide.0, "{scene:?}");
                assert_eq!(wide.1.f32, 0);
                n_f32 += narrow.1.f32;
                n_f64 += wide.1.f64;
            }
        });
    }
    assert!(n_f32 > n_f64 / 2 && n_f64 > 10_000, "{n_f32} of {n_f64}");
}

/// Whatever is between the pixels that are asked for, and what an earlier part left in the scratch.
#[test]
fn pixels_are_the_same_alone_and_among_others() {
    let mut rng = ChaCha8Rng::seed_from_u64(1433);
    let mut n_apart = 0;
    for number in 0..40 {
        let scene = scene(&mut rng, [4, 400][number as usize % 2]);
        with_lights(&scene, 1 + number % 3, &mut |&Lights { job, occluders }| {
            let certified = Certified::new(job, occluders, number % 4 < 2);
            let (n, mut used) = (job.n_columns(), LightWork::default());
            for row in 0..job.samples.height as usize / job.n_samples() {
                let first = row * n;
                let mut whole = vec![[0u8; 3]; n];
                let mut work = LightWork::default();
                work.pixels.extend(first..first + n);
                certified.find((first, &mut whole), &Control::default(), &mut work).unwrap();
                let share = [0.1, 0.5, 0.9][row % 3];
                let some: Vec<usize> =
                    (first..first + n).filter(|_| rng.random_bool(share)).collect();
                let mut fresh = LightWork::default();
                let before = used.counts.total();
                for work in [&mut used, &mut fresh] {
                    let mut out = vec![[0u8; 3]; n];
                    work.pixels.extend(&some);
                    certified.find((first, &mut out), &Control::default(), work).unwrap();
                    for &pixel in &some {
                        let at = pixel - first;
                        n_apart += usize::from(at > 0 && !some.contains(&(pixel - 1)));
                        assert_eq!(out[at], whole[at], "{some:?} {scene:?}");
                    }
                }
                assert_eq!(used.counts.total() - before, fresh.counts.total());
            }
        });
    }
    assert!(n_apart > 500, "{n_apart}");
}

/// A floor whose every byte is on an edge, in a sun's light: each kind of pixel is decided exactly once.
#[test]
fn equal_questions_are_asked_once() {
    let text = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/lit/hard/byte_edge.toml"),
    );
    let scene = Arc::new(parse_scene(&text.unwrap(), "byte_edge.toml".as_ref()).unwrap());
    for n_samples in [1, 3] {
        with_lights(&scene, n_samples, &mut |&Lights { job, occluders }| {
            let certified = Certified::new(job, occluders, true);
            let (n, mut work) = (job.n_columns(), LightWork::default());
            for row in 0..job.samples.height as usize / job.n_samples() {
                let mut out = vec![[0u8; 3]; n];
                work.pixels.extend(row * n..(row + 1) * n);
                certified.find((row * n, &mut out), &Control::default(), &mut work).unwrap();
                assert_eq!(out, vec![[5; 3]; n]);
            }
            assert_eq!(work.colors.len(), 1, "{n_samples} samples");
            // Also within a block: one pixel may ask thousands of exact questions.
            let control = Control::default();
            control.cancel();
            work.pixels.push(0);
            assert!(certified.find((0, &mut [[0u8; 3]]), &control, &mut work).is_err());
        });
    }
}

/// In blocks of several rows, those of the next cell begin above the last row of the one before.
#[test]
fn pixels_of_several_rows_are_no_stretch() {
    assert!(is_stretch::<4>(&[7, 8, 9, 10]));
    for apart in [&[7, 8, 9][..], &[15, 35, 55, 18], &[17, 16, 15, 14], &[7, 8, 10, 11]] {
        assert!(!is_stretch::<4>(apart), "{apart:?}");
    }
}

/// By the worst sum, whose every rounding goes down by a whole unit.
#[test]
fn as_many_roundings_as_a_colour_takes_are_granted() {
    let unit = 0.5 * f32::UNIT;
    for n in [1.0, 2.0, 10.0, 300.0, 4096.0, 1e5, 1e6, 4e6] {
        let granted = of_roundings(n, unit).unwrap();
        let worst = (-n * (-unit).ln_1p()).exp_m1();
        assert!(granted >= worst && granted <= 2.0 * worst, "{n}: {granted} {worst}");
        assert!(n * unit < worst, "{n}: the first order alone would do");
    }
    assert_eq!(of_roundings(0.25 / unit, unit), None);
}

/// How far points are from the middle of their ball at most, as a part of its radius.
fn worst(point: impl Fn(&mut ChaCha8Rng) -> [f64; 3]) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(1423);
    let mut worst: f64 = 0.0;
    for _ in 0..20_000 {
        let mut surface =
            Surface::<Lanes<f64, 8>> { point_error: Lanes::lit(0.0), ..Surface::default() };
        for lane in 0..8 {
            let at = point(&mut rng);
            for axis in 0..3 {
                surface.point.0[axis].0[lane] = at[axis];
            }
        }
        let is_in = rng.random_range(1..8);
        let mut mask = LaneBits([0; 8]);
        for lane in 0..is_in {
            mask.0[lane] = u64::MAX;
        }
        let mut some = Extent::none();
        some.add(mask, &surface);
        let BoundingBall { middle, reach, .. } = some.ball();
        for lane in 0..is_in {
            // The points are so near each other that this is exact, or so far apart that it need not be.
            let away = surface.lane(lane).point - middle;
            worst = worst.max(away.dot(away).sqrt() / reach);
        }
    }
    worst
}

/// Neither half of what a box reaches nor half of what its middle is rounded by would do.
#[test]
fn points_are_in_their_ball() {
    let apart = worst(|rng| std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
    let close =
        worst(|rng| std::array::from_fn(|_| if rng.random() { 1.0 } else { 1.0 + f64::EPSILON }));
    for worst in [apart, close] {
        assert!(worst <= 1.0 && worst > 0.5, "{apart} {close}");
    }
}
