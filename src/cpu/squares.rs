//! Samples of few objects: squares of pixels in which one object fills everything are proven to be such
//! (see "Squares of pixels" in [`crate::guard`]), large ones first. Only pixels that are left are
//! sampled.

use std::time::Instant;

use rayon::prelude::*;

use crate::certify;
use crate::control::Control;
use crate::error::Result;
use crate::guard;
use crate::host;
use crate::kernel::certified::{
    Frame, Places, PlaneCertified, SeenObjects, SphereCertified, UNDECIDED, Widening,
};
use crate::kernel::{Kernel, Lists};
use crate::prepare::{Objects, Prepared};
use crate::rays::{CameraF32, Pixels, Rays};
use crate::scene::Scene;
use crate::trace::{Level, Mixed, Samples, StageCounts, Timing, resize};

/// Columns and rows of the largest squares, px.
const LARGEST: u32 = 16;

/// The objects as squares of some size see them.
struct Size {
    /// Columns and rows, px.
    side: u32,
    lists: Lists<SphereCertified, PlaneCertified>,
    widening: Widening<f32>,
}

impl Size {
    /// `None` where squares are too large for the bounds.
    fn new(pixels: &Pixels, scene: &Scene, side: u32) -> Option<Size> {
        let frame = Frame::of_squares(pixels, scene, side)?;
        let lists = frame.objects(scene, scene.spheres.iter());
        Some(Size { side, lists, widening: frame.widening() })
    }
}

/// Pixels that are looked at in squares.
pub(super) struct Squares<'a> {
    /// Of the picture of the samples.
    prepared: &'a Prepared,
    pixels: &'a Pixels,
    /// Samples across and down a pixel.
    n: u32,
    /// From large squares to single pixels.
    sizes: Vec<Size>,
}

/// Room for the squares of some rows.
#[derive(Default)]
struct Room {
    open: Vec<[u32; 2]>,
    next: Vec<[u32; 2]>,
    places: Places,
    ids: Vec<u32>,
}

impl<'a> Squares<'a> {
    /// `None` where samples are better traced without.
    pub fn new(prepared: &'a Prepared, pixels: &'a Pixels, n: u32) -> Option<Squares<'a>> {
        let is_proven = prepared.kernel == Kernel::Certified && !prepared.starts_in_f64();
        if n == 1 || pixels.is_empty() || !is_proven || prepared.hierarchy.is_some() {
            return None;
        }
        let sides = [LARGEST, LARGEST / 4, LARGEST / 16].into_iter();
        let sizes: Vec<Size> =
            sides.filter_map(|side| Size::new(pixels, &prepared.scene, side)).collect();
        let has_pixels = sizes.last().is_some_and(|size| size.side == 1);
        has_pixels.then_some(Squares { prepared, pixels, n, sizes })
    }

    /// [`crate::tracer::Tracer::trace_samples`].
    ///
    /// # Errors
    /// Those of [`Prepared::check`]; [`crate::Error::Interrupted`].
    pub fn trace(&self, control: &Control, samples: &mut Samples) -> Result<Timing> {
        let start = Instant::now();
        let all = Rays::Pixels(self.pixels.samples(self.n));
        self.prepared.check(&all)?;
        let width = self.pixels.width as usize;
        resize(&mut samples.whole, self.pixels.len());
        let strips = samples.whole.par_chunks_mut(LARGEST as usize * width).enumerate();
        let mixed = strips
            .map_init(Room::default, |room, (strip, whole)| {
                control.check()?;
                host::check()?;
                let first_row = strip as u32 * LARGEST;
                self.find_whole(first_row, whole, room);
                control.advance((whole.len() as u64) * u64::from(self.n).pow(2));
                Ok(self.sample(first_row, whole, room))
            })
            .collect::<Result<Vec<Mixed>>>()?;
        samples.set_mixed(mixed, self.n as usize);
        let trace = start.elapsed();
        let start = Instant::now();
        samples.counts = self.decide(&all, control, samples)?;
        Ok(Timing { trace, refine: start.elapsed(), ..Timing::default() })
    }

    /// Finds the pixels of some rows that show one object alone, and leaves the others [`UNDECIDED`].
    fn find_whole(&self, first_row: u32, whole: &mut [u32], room: &mut Room) {
        let Pixels { width, image_width, image_height, .. } = *self.pixels;
        let n_rows = whole.len() as u32 / width;
        let camera = CameraF32::new(self.pixels);
        let Room { open, next, places, ids } = room;
        open.clear();
        let largest = self.sizes[0].side;
        for y in (0..n_rows).step_by(largest as usize) {
            open.extend((0..width).step_by(largest as usize).map(|x| [x, y]));
        }
        for (size, smaller) in self.sizes.iter().zip(self.sizes[1..].iter().map(Some).chain([None]))
        {
            let side = size.side;
            // What the rows cut off is no square of the picture.
            let is_inside = |[x, y]: [u32; 2]| x + side <= width && y + side <= n_rows;
            places.clear();
            next.clear();
            let mut split = |[x, y]: [u32; 2]| {
                let step = smaller.map_or(side, |size| size.side) as usize;
                for y in (y..(y + side).min(n_rows)).step_by(step) {
                    next.extend((x..(x + side).min(width)).step_by(step).map(|x| [x, y]));
                }
            };
            open.retain(|&square| {
                if !is_inside(square) {
                    split(square);
                }
                is_inside(square)
            });
            for [x, y] in &*open {
                let (x, y) = (self.pixels.x + x, self.pixels.y + first_row + y);
                // Of its middle, as `Pixels::offset2` has it of a pixel's.
                let i = i64::from(2 * x + side) - i64::from(image_width);
                let j = i64::from(image_height) - i64::from(2 * y + side);
                places.push((i, j));
            }
            let (lists, widening) = (&size.lists, size.widening);
            SeenObjects { lists, widening, camera: &camera, near: true }.decide(places, ids);
            for (&[x, y], &id) in open.iter().zip(&*ids) {
                if id == UNDECIDED && smaller.is_some() {
                    split([x, y]);
                    continue;
                }
                for row in y..y + side {
                    let first = (row * width + x) as usize;
                    whole[first..first + side as usize].fill(id);
                }
            }
            std::mem::swap(open, next);
        }
    }

    /// What f32 sees of the samples of those pixels of some rows that are left.
    fn sample(&self, first_row: u32, whole: &[u32], room: &mut Room) -> Mixed {
        let Objects::Certified(lists) = &self.prepared.objects else { return Mixed::default() };
        let samples = self.pixels.samples(self.n);
        let camera = CameraF32::new(&samples);
        let Room { places, ids, .. } = room;
        places.clear();
        let first = (first_row * self.pixels.width) as usize;
        let mixed: Vec<u32> = (0..whole.len())
            .filter(|&at| whole[at] == UNDECIDED)
            .map(|at| (first + at) as u32)
            .collect();
        for &pixel in &mixed {
            let (x, y) = self.pixels.xy(pixel as usize);
            for y in y * self.n..(y + 1) * self.n {
                for x in x * self.n..(x + 1) * self.n {
                    places.push(samples.offset2(x, y));
                }
            }
        }
        let (widening, near) = (guard::widening_f32(), self.prepared.near);
        SeenObjects { lists, widening, camera: &camera, near }.decide(places, ids);
        (mixed, ids.clone())
    }

    /// Decides the samples that f32 left open, and says how many each stage decided.
    fn decide(&self, all: &Rays, control: &Control, samples: &mut Samples) -> Result<StageCounts> {
        let (n, n_each) = (self.n as usize, samples.n_each);
        let row = self.pixels.width as usize * n;
        let mut places: Vec<(u32, usize)> = Vec::new();
        for (at, _) in samples.ids.iter().enumerate().filter(|&(_, &id)| id == UNDECIDED) {
            let (pixel, sample) = (samples.mixed[at / n_each] as usize, at % n_each);
            let (x, y) = (pixel % self.pixels.width as usize, pixel / self.pixels.width as usize);
            let ray = (y * n + sample / n) * row + x * n + sample % n;
            places.push((ray as u32, at));
        }
        places.sort_unstable();
        let open: Vec<u32> = places.iter().map(|&(ray, _)| ray).collect();
        let n_rays = self.pixels.len() as u64 * n_each as u64;
        let mut counts = StageCounts { f32: n_rays - open.len() as u64, ..StageCounts::default() };
        for decided in certify::decide(self.prepared, all, &open, control)? {
            if let Ok(place) = open.binary_search(&decided.ray) {
                samples.ids[places[place].1] = decided.id;
            }
            match decided.level {
                Level::Exact => counts.exact += 1,
                _ => counts.f64 += 1,
            }
        }
        Ok(counts)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::cpu::CpuTracer;
    use crate::random::SplitMix;
    use crate::rays::View;
    use crate::scene::{Camera, Color, Plane, Projection, Sphere};
    use crate::trace::{Hits, Wants};
    use crate::tracer::{Tracer, trace_all_samples};

    /// Spheres of all sizes before a camera, of which some hide parts of others or hold the eye, and planes
    /// through them.
    fn case(seed: u64) -> (Arc<Scene>, Pixels) {
        let mut rng = SplitMix::new(seed);
        let mut number = || 2.0 * rng.unit() - 1.0;
        let mut vector = || DVec3::new(number(), number(), number());
        let (forward, up) = (vector().normalize(), vector());
        let position = vector() * 10.0;
        let spheres = (0..seed % 12).map(|k| {
            let away = forward * 8.0 + vector() * 6.0;
            let radius = match k {
                0 if seed.is_multiple_of(5) => away.length() * (1.0 + 0.1 * vector().x.abs()),
                _ => 2f64.powf(3.0 * vector().x - 1.0),
            };
            (Sphere { center: position + away, radius }, Color([0.1 * k as f64, 0.5, 1.0]))
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

    fn tracer(scene: &Arc<Scene>, pixels: &Pixels, n: u32) -> CpuTracer {
        let rays = Rays::Pixels(pixels.samples(n));
        let prepared = Prepared::new(Arc::clone(scene), Kernel::Certified, &rays).unwrap();
        CpuTracer::new(Arc::new(prepared), Wants::default())
    }

    /// Pixels of squares of this side, said to show one object by bounds for squares of `reach`, that do not;
    /// and how many are said to.
    fn wrong(side: u32, reach: u32) -> (usize, usize) {
        let (mut n_wrong, mut n_whole, n) = (0, 0, 16 / side);
        for seed in 0..120 {
            let (scene, pixels) = case(seed);
            let Some(size) = Size::new(&pixels, &scene, reach) else { continue };
            let mut tracer = tracer(&scene, &pixels, n);
            let sizes = vec![Size { side, ..size }];
            let squares = Squares { prepared: &tracer.prepared, pixels: &pixels, n, sizes };
            let mut whole = vec![UNDECIDED; pixels.len()];
            squares.find_whole(0, &mut whole, &mut Room::default());
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
        for side in [1, 4] {
            let (n_wrong, n_whole) = wrong(side, side);
            assert_eq!(n_wrong, 0, "squares of {side}");
            assert!(n_whole > 60_000, "{n_whole} with squares of {side}");
        }
    }

    #[test]
    fn sabotage_half_the_reach_is_noticed() {
        for side in [2, 8] {
            assert!(wrong(side, side / 2).0 > 20);
        }
    }

    #[test]
    fn samples_are_those_that_are_traced_one_by_one() {
        let (mut n_mixed, mut n_whole) = (0, 0);
        for seed in 0..60 {
            let (scene, pixels) = case(seed);
            let n = 2 + (seed % 4) as u32;
            let pixels = Pixels { width: 33 + seed as u32 % 16, height: 19, ..pixels };
            let mut tracer = tracer(&scene, &pixels, n);
            let (control, mut hits) = (Control::default(), Hits::default());
            let [mut found, mut all] = [Samples::default(), Samples::default()];
            tracer.trace_samples(&pixels, n, &control, &mut hits, &mut found).unwrap();
            trace_all_samples(&mut tracer, &pixels, n, &control, &mut hits, &mut all).unwrap();
            let ids = |samples: &Samples| {
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
        assert!(n_mixed > 1000 && n_whole > 10_000, "{n_mixed}, {n_whole}");
    }
}
