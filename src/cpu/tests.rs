//! Samples of pixels: what fills a pixel, and what is looked at one by one.

use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::rays::View;
use crate::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use crate::support::random::SplitMix;
use crate::tracer::Tracer;
use crate::visibility::SearchScratch;

/// Fewer spheres of all sizes than this before a camera, of which some hide parts of others or hold the eye,
/// and planes through them.
fn few(seed: u64) -> (Arc<Scene>, Pixels) {
    case(seed, seed % 12, -1.0)
}

/// A scene as `few` makes it, but with so many spheres, small ones as well, that they have a hierarchy.
fn many(seed: u64) -> (Arc<Scene>, Pixels) {
    case(seed, 20 + seed * 7 % 400, -3.0)
}

/// `n` spheres of typically `2^size`.
fn case(seed: u64, n: u64, size: f64) -> (Arc<Scene>, Pixels) {
    let mut rng = SplitMix::new(seed);
    let mut number = || 2.0 * rng.unit() - 1.0;
    let mut vector = || DVec3::new(number(), number(), number());
    let (forward, up) = (vector().normalize(), vector());
    let position = vector() * 10.0;
    let spheres = (0..n).map(|k| {
        let away = forward * 8.0 + vector() * 6.0;
        let radius = match k {
            0 if seed.is_multiple_of(5) => away.length() * (1.0 + 0.1 * vector().x.abs()),
            _ => 2f64.powf(3.0 * vector().x + size),
        };
        (Sphere { center: position + away, radius }, Color([0.1 * (k % 12) as f64, 0.5, 1.0]))
    });
    let spheres = spheres.collect();
    let plane = |_| Plane {
        name: None,
        point: position + forward * 8.0 + vector(),
        normal: vector(),
        color: Color([0.7; 3]),
    };
    let planes = (0..seed % 4).map(plane).collect();
    let projection = match seed % 3 {
        0 => Projection::Orthographic { height: 9.0 },
        1 => Projection::Perspective { fov_degrees: 50.0 },
        _ => Projection::Perspective { fov_degrees: 130.0 },
    };
    let camera = Camera { position, look_at: position + forward, up, projection };
    let pixels = Pixels::whole(View::new(&camera), 640, 480);
    let pixels = Pixels { x: 7 * (seed % 80) as u32, y: 211, width: 48, height: 32, ..pixels };
    (Arc::new(Scene { spheres, planes, ..Scene::default() }), pixels)
}

fn tracer(scene: &Arc<Scene>, pixels: &Pixels, n: u32) -> Tracer {
    let rays = Rays::Pixels(pixels.samples(n));
    let prepared = Prepared::new(Arc::clone(scene), Kernel::Certified, &rays).unwrap();
    Tracer::on_cpu(Arc::new(prepared), Outputs::default())
}

/// Samples of pixels that are said to show one object by bounds for this part of their reach, and that don't
/// see it; and how many pixels are said to.
fn wrong(case: fn(u64) -> (Arc<Scene>, Pixels), n: u32, part: f64) -> (usize, usize) {
    let (mut n_wrong, mut n_whole) = (0, 0);
    for seed in 0..120 {
        let (scene, pixels) = case(seed);
        let mut tracer = tracer(&scene, &pixels, n);
        let mut whole = vec![UNDECIDED; pixels.len()];
        let search = Search::with_reach(tracer.prepared(), &pixels, n, part);
        search.look(&pixels, &mut whole, &mut SearchScratch::default());
        let mut hits = Hits::default();
        tracer.trace(&Rays::Pixels(pixels.samples(n)), &Control::default(), &mut hits).unwrap();
        let (row, n) = ((pixels.width * n) as usize, n as usize);
        for (at, &id) in hits.id.iter().enumerate() {
            let said = whole[at / row / n * pixels.width as usize + at % row / n];
            n_wrong += usize::from(said != UNDECIDED && said != id);
        }
        n_whole += whole.iter().filter(|&&id| id != UNDECIDED).count();
    }
    (n_wrong, n_whole)
}

#[test]
fn what_fills_a_square_is_seen_by_all_of_its_samples() {
    for (case, n) in [(few as fn(_) -> _, 2), (few, 5), (many, 16)] {
        let (n_wrong, n_whole) = wrong(case, n, 1.0);
        assert_eq!(n_wrong, 0, "{n} samples");
        assert!(n_whole > 60_000, "{n_whole} with {n} samples");
    }
}

#[test]
fn sabotage_half_the_reach_is_noticed() {
    for (case, n) in [(few as fn(_) -> _, 2), (few, 8), (many, 16)] {
        let (n_wrong, _) = wrong(case, n, 0.5);
        assert!(n_wrong > 20, "{n_wrong} with {n} samples");
    }
}

#[test]
fn pixels_are_those_that_are_looked_at_one_by_one() {
    let mut n_wrong = [0, 0];
    for seed in 0..120 {
        let (scene, pixels) = few(seed);
        let tracer = tracer(&scene, &pixels, 1);
        for (n_wrong, part) in n_wrong.iter_mut().zip([1.0, 0.5]) {
            let mut ids = vec![UNDECIDED; pixels.len()];
            let search = Search::with_reach(tracer.prepared(), &pixels, 1, part);
            search.look(&pixels, &mut ids, &mut SearchScratch::default());
            for (at, id) in ids.into_iter().enumerate() {
                let (x, y) = pixels.xy(at);
                let one = Pixels { x, y, width: 1, height: 1, ..pixels };
                let mut alone = [UNDECIDED];
                let search = Search::new(tracer.prepared(), &one, 1);
                search.look(&one, &mut alone, &mut SearchScratch::default());
                let is_known = id != UNDECIDED && alone[0] != UNDECIDED;
                *n_wrong += usize::from(is_known && id != alone[0]);
            }
        }
    }
    assert_eq!(n_wrong[0], 0);
    assert!(n_wrong[1] > 20, "{n_wrong:?}");
}

#[test]
fn samples_are_those_that_are_traced_one_by_one() {
    let (mut n_mixed, mut n_whole) = (0, 0);
    let cases = [few as fn(_) -> _, many];
    for (seed, case) in (0..60).flat_map(|seed| cases.map(|case| (seed, case))) {
        let (scene, pixels) = case(seed);
        let n = 2 + (seed % 4) as u32;
        let pixels = Pixels { width: 33 + seed as u32 % 16, height: 19, ..pixels };
        let mut tracer = tracer(&scene, &pixels, n);
        let (control, mut hits) = (Control::default(), Hits::default());
        let [mut found, mut all] = [SampleIds::default(), SampleIds::default()];
        tracer.trace_samples(&pixels, n, &control, &mut hits, &mut found).unwrap();
        tracer.trace(&Rays::Pixels(pixels.samples(n)), &control, &mut hits).unwrap();
        all.gather(&hits, pixels.width as usize, n as usize);
        let ids = |samples: &SampleIds| {
            let mut ids: Vec<Vec<u32>> =
                samples.whole.iter().map(|&id| vec![id; samples.n_each]).collect();
            let mixed = samples.ids.chunks(samples.n_each);
            for (&pixel, mixed) in samples.mixed.iter().zip(mixed) {
                ids[pixel as usize] = mixed.to_vec();
            }
            ids
        };
        assert_eq!(ids(&found), ids(&all), "seed {seed}");
        assert_eq!(found.counts.total(), all.counts.total());
        assert_eq!(found.coverage(), all.coverage());
        n_mixed += found.mixed.len();
        n_whole += pixels.len() - found.mixed.len();
    }
    assert!(n_mixed > 1000 && n_whole > 30_000, "{n_mixed}, {n_whole}");
}
