//! Hits → colours where a scene has light or a pixel several samples: every number that of exact
//! arithmetic. f64 with bounds decides nearly all pixels, each by the interval of its mean; the rest are
//! decided exactly.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::beam::{Beam, InTheWay};
use super::lamp::{Lamp, Lighting, Origin};
use super::mean::ExactMean;
use super::{Colors, PIXELS_AT_ONCE, plain};
use crate::certify::{PointF64, Stage};
use crate::control::Control;
use crate::error::Result;
use crate::exact::{ExactBeam, ExactPoint, Real, Shape, integer, is_outside, real};
use crate::guard::UNIT_F64;
use crate::host;
use crate::kernel::Kernel;
use crate::prepare::{Prepared, exponent_of, scale_by_power_of_two};
use crate::rays::Pixels;
use crate::scene::{Color, Edges, Object, Scene, Sphere};
use crate::trace::{Rays, StageCounts};
use crate::tree::Segment;
use crate::vec3::Vec3;

/// Shades the pictures of one scene and one camera.
#[derive(Debug)]
pub struct Lit {
    scene: Arc<Scene>,
    pub(super) lighting: Option<Lighting>,
    /// Samples across and down a pixel.
    pub(super) n_samples: u32,
    /// How far shadow rays of kernels without a proof start from a surface, world units.
    epsilon: f64,
}

/// Bounds of a number.
#[derive(Clone, Copy, Debug, Default)]
struct Interval {
    low: f64,
    high: f64,
}

/// What f64 knows of a lamp at a point.
enum Seen {
    /// It gives light.
    Lit,
    /// Something is in its way.
    Hidden,
    /// One of these may be in its way.
    Open(Vec<u32>),
}

/// Where objects are looked for.
struct Finder<'a> {
    stage: Stage<'a>,
    prepared: &'a Prepared,
    scene: &'a Scene,
    /// Ids of the objects that are not in the tree.
    listed: Vec<u32>,
    /// From the reference point to that of the tree.
    to_tree: DVec3,
}

impl Lit {
    /// A shader for a scene with light, or for pixels of `n_samples` × `n_samples` samples.
    /// `epsilon` is for kernels without a proof: how far from a surface their shadow rays start, world
    /// units.
    pub fn new(scene: Arc<Scene>, lighting: Option<Lighting>, n_samples: u32, epsilon: f64) -> Lit {
        Lit { scene, lighting, n_samples, epsilon }
    }

    /// Samples across and down a pixel.
    pub fn n_samples(&self) -> u32 {
        self.n_samples
    }

    /// Replaces `colors` by those of pixels. `samples` are the rays of their samples, a rectangle of
    /// whole pixels of a picture that is [`Lit`]'s number of samples times as large, `ids` what they
    /// see, and `prepared` is of that picture.
    ///
    /// Returns how many ways to lamps each stage decided.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn shade(
        &self,
        prepared: &Prepared,
        samples: &Pixels,
        ids: &[u32],
        control: &Control,
        colors: &mut Colors,
    ) -> Result<StageCounts> {
        let n_pixels = ids.len() / (self.n_samples * self.n_samples) as usize;
        let job = Job { lit: self, ids, row: samples.width as usize };
        if prepared.kernel != Kernel::Certified {
            return plain::with_means(&job, prepared, samples, self.epsilon, |mean| {
                let code = |edges: &Edges, at| mean(at).map(|x| edges.number(x));
                let (srgb8, srgb16) = (Edges::srgb8(), Edges::srgb16());
                match colors {
                    Colors::Srgb8(out) => job.run(n_pixels, control, out, |at, _| {
                        code(srgb8, at).map(|code| code as u8)
                    }),
                    Colors::Srgb16(out) => {
                        job.run(n_pixels, control, out, |at, _| code(srgb16, at))
                    }
                    Colors::Linear(out) => {
                        job.run(n_pixels, control, out, |at, _| mean(at).map(|x| x as f32))
                    }
                }?;
                Ok(plain::counts(&job, n_pixels, prepared.kernel == Kernel::Double))
            });
        }
        let rays = Rays::Pixels(*samples);
        let finder = Finder::new(prepared, &rays);
        let job = Certified { job, finder: &finder };
        match colors {
            Colors::Srgb8(out) => job.job.run(n_pixels, control, out, |at, n| job.srgb8(at, n)),
            Colors::Srgb16(out) => job.job.run(n_pixels, control, out, |at, n| job.srgb16(at, n)),
            Colors::Linear(out) => job.job.run(n_pixels, control, out, |at, n| job.linear(at, n)),
        }
    }
}

/// The pixels of one call.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub lit: &'a Lit,
    pub ids: &'a [u32],
    /// Samples of a row.
    row: usize,
}

impl Job<'_> {
    fn run<T: Send + Default + Copy>(
        &self,
        n_pixels: usize,
        control: &Control,
        out: &mut Vec<[T; 3]>,
        pixel: impl Fn(usize, &mut StageCounts) -> [T; 3] + Sync,
    ) -> Result<StageCounts> {
        out.clear();
        out.resize(n_pixels, [T::default(); 3]);
        // Ctrl-C is looked at between parts that take a moment.
        let n_lamps = self.lit.lighting.as_ref().map_or(0, |lighting| lighting.lamps.len());
        let n_questions = (self.lit.n_samples * self.lit.n_samples) as usize * (n_lamps + 1);
        let part = (PIXELS_AT_ONCE / n_questions).clamp(16, PIXELS_AT_ONCE / 8);
        out.par_chunks_mut(part)
            .enumerate()
            .map(|(number, out)| {
                control.check()?;
                host::check()?;
                let mut counts = StageCounts::default();
                for (at, out) in (number * part..).zip(out) {
                    *out = pixel(at, &mut counts);
                }
                Ok(counts)
            })
            .try_reduce(StageCounts::default, |mut sum, other| {
                sum.add(other);
                Ok(sum)
            })
    }

    /// Indices of a pixel's samples.
    pub fn samples(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let (n, row) = (self.lit.n_samples as usize, self.row);
        let n_columns = row / n;
        let first = pixel / n_columns * n * row + pixel % n_columns * n;
        (0..n * n).map(move |sample| first + sample / n * row + sample % n)
    }

    pub fn color(&self, id: u32) -> [f64; 3] {
        let scene = &self.lit.scene;
        let color = match (id as usize).checked_sub(1) {
            None => Some(scene.background),
            Some(index) => scene
                .spheres
                .color(index)
                .or_else(|| scene.planes.get(index - scene.spheres.len()).map(|plane| plane.color)),
        };
        color.unwrap_or(Color::BLACK).0
    }
}

/// The pixels of the kernel `certified`.
#[derive(Clone, Copy)]
struct Certified<'a> {
    job: Job<'a>,
    finder: &'a Finder<'a>,
}

impl Certified<'_> {
    fn srgb8(&self, pixel: usize, counts: &mut StageCounts) -> [u8; 3] {
        self.code(pixel, Edges::srgb8(), 255, counts).map(|code| code as u8)
    }

    fn srgb16(&self, pixel: usize, counts: &mut StageCounts) -> [u16; 3] {
        self.code(pixel, Edges::srgb16(), u16::MAX, counts)
    }

    fn code(&self, pixel: usize, edges: &Edges, most: u16, counts: &mut StageCounts) -> [u16; 3] {
        let bounds = self.bounds(pixel, counts);
        let low = bounds.map(|b| edges.number(b.low));
        if low == bounds.map(|b| edges.number(b.high)) {
            return low;
        }
        self.exact(pixel, counts, |mean, channel| {
            mean.code(channel, low[channel], most, |code| edges.range(code).0)
        })
    }

    fn linear(&self, pixel: usize, counts: &mut StageCounts) -> [f32; 3] {
        let bounds = self.bounds(pixel, counts);
        let low = bounds.map(|b| b.low as f32);
        if low == bounds.map(|b| b.high as f32) {
            return low;
        }
        self.exact(pixel, counts, |mean, channel| mean.nearest_f32(channel, low[channel]))
    }

    /// Bounds of a pixel's mean. Each sum of `n` terms, products of three numbers, is off by `n + 4`
    /// roundings at most.
    fn bounds(&self, pixel: usize, counts: &mut StageCounts) -> [Interval; 3] {
        let mut sums = [Interval::default(); 3];
        let mut n_terms = 8;
        for sample in self.job.samples(pixel) {
            let id = self.job.ids[sample];
            let color = self.job.color(id);
            n_terms += 1;
            let light = match &self.job.lit.lighting {
                Some(lighting) if id != 0 => {
                    n_terms += lighting.lamps.len() + 1;
                    self.light(lighting, sample, id, counts)
                }
                _ => [Interval { low: 1.0, high: 1.0 }; 3],
            };
            for channel in 0..3 {
                sums[channel].low += color[channel] * light[channel].low;
                sums[channel].high += color[channel] * light[channel].high;
            }
        }
        let n = f64::from(self.job.lit.n_samples * self.job.lit.n_samples);
        // A flat colour of one sample is what it is.
        let error = match (&self.job.lit.lighting, self.job.lit.n_samples) {
            (None, 1) => 0.0,
            _ => n_terms as f64 * UNIT_F64,
        };
        sums.map(|Interval { low, high }| Interval {
            low: low / n * (1.0 - error),
            high: high / n * (1.0 + error),
        })
    }

    /// Bounds of the light that a hit gets.
    fn light(
        &self,
        lighting: &Lighting,
        sample: usize,
        id: u32,
        counts: &mut StageCounts,
    ) -> [Interval; 3] {
        let mut sums = lighting.ambient.map(|part| Interval { low: part, high: part });
        let point = self.finder.stage.point_f64(sample, id);
        for lamp in &lighting.lamps {
            let lit = match &point {
                Some(point) => self.finder.lamp(lamp, point, id, counts),
                None => Interval { low: 0.0, high: 1.0 },
            };
            for (sum, weight) in sums.iter_mut().zip(lamp.weight) {
                sum.low += weight * lit.low;
                sum.high += weight * lit.high;
            }
        }
        sums
    }

    /// Decides a pixel's channels exactly.
    fn exact<T>(
        &self,
        pixel: usize,
        counts: &mut StageCounts,
        decide: impl Fn(&ExactMean, usize) -> T,
    ) -> [T; 3] {
        let lighting = self.job.lit.lighting.as_ref();
        let n_shares = lighting.map_or(1, |lighting| lighting.n_shares);
        let n_samples = u64::from(self.job.lit.n_samples).pow(2);
        let samples: Vec<(usize, u32, Option<(ExactPoint, Shape)>)> = self
            .job
            .samples(pixel)
            .map(|at| (at, self.job.ids[at]))
            .map(|(at, id)| {
                let point = lighting.and_then(|_| self.finder.stage.exact_point(at, id));
                (at, id, point)
            })
            .collect();
        let mut mean = ExactMean::new(n_samples * u64::from(n_shares));
        let shares = integer(n_shares.into());
        for (at, id, point) in &samples {
            let color = self.job.color(*id).map(exact);
            match (lighting, point) {
                (Some(lighting), Some((point, shape))) => {
                    for channel in 0..3 {
                        let ambient = exact(lighting.ambient[channel]) * &shares;
                        mean.add(channel, &(ambient * &color[channel]));
                    }
                    for lamp in &lighting.lamps {
                        if let Some(beam) = self.finder.exact_beam(lamp, point)
                            && let Some(cosine) = beam.cosine(shape)
                            && self.finder.is_seen(lamp, &beam, *at, *id, counts)
                        {
                            let weight = &lamp.exact_weight;
                            let weights = std::array::from_fn(|k| &weight[k] * &color[k]);
                            mean.add_light(cosine, weights);
                        }
                    }
                }
                _ => {
                    for channel in 0..3 {
                        mean.add(channel, &(&color[channel] * &shares));
                    }
                }
            }
        }
        std::array::from_fn(|channel| decide(&mean, channel))
    }
}

/// The numbers of scenes are finite.
fn exact(x: f64) -> Real {
    real(x).unwrap_or_else(Real::zero)
}

impl<'a> Finder<'a> {
    fn new(prepared: &'a Prepared, rays: &'a Rays) -> Finder<'a> {
        let scene = &*prepared.scene;
        let n_spheres = scene.spheres.len() as u32;
        let planes = n_spheres + 1..=scene.n_objects() as u32;
        let (listed, to_tree) = match &prepared.hierarchy {
            Some(hierarchy) => {
                let tree = &hierarchy.tree;
                let outside = tree.outside.iter().map(|index| index + 1);
                (outside.chain(planes).collect(), prepared.reference - tree.reference)
            }
            None => ((1..=scene.n_objects() as u32).collect(), DVec3::ZERO),
        };
        Finder { stage: Stage::new(prepared, rays), prepared, scene, listed, to_tree }
    }

    /// A point of the world relative to the reference point.
    fn relative(&self, point: DVec3) -> Vec3<f64> {
        (point - self.prepared.reference).into()
    }

    fn beam(&self, lamp: &Lamp, point: &PointF64) -> Option<Beam> {
        match lamp.origin {
            // Against the ray, whose direction is better known than the point.
            Origin::Eye => Some(Beam::to_eye(point.at, point.direction, point.direction_error)),
            Origin::Point(position) => {
                Beam::to_point(point.at, point.error, self.relative(position))
            }
            Origin::Sun(direction) => {
                let direction = scale_by_power_of_two(direction, -exponent_of(direction));
                Some(Beam::to_sun(point.at, point.error, direction.into()))
            }
        }
    }

    /// Bounds of what a lamp gives a point, as a part of its weight.
    fn lamp(&self, lamp: &Lamp, point: &PointF64, id: u32, counts: &mut StageCounts) -> Interval {
        let beam = self.beam(lamp, point);
        let (low, high) =
            beam.map_or((0.0, 1.0), |beam| beam.cosine(point.normal, point.normal_error));
        if high == 0.0 || !lamp.shadows || lamp.origin == Origin::Eye {
            return Interval { low, high };
        }
        counts.f64 += 1;
        let Some(beam) = beam else { return Interval { low: 0.0, high } };
        match self.look(lamp, &beam, point.is_inside, id) {
            Seen::Lit => Interval { low, high },
            Seen::Hidden => Interval::default(),
            Seen::Open(_) => Interval { low: 0.0, high },
        }
    }

    /// What is in a beam's way, for a point of an object that the light falls on. From outside, a sphere
    /// is not in its own light; from inside it is where the lamp is outside.
    fn look(&self, lamp: &Lamp, beam: &Beam, is_inside: bool, own: u32) -> Seen {
        let own_sphere = match self.scene.object(own) {
            Some(Object::Sphere(sphere)) => Some(sphere),
            _ => None,
        };
        if let (true, Some(sphere)) = (is_inside, own_sphere) {
            match lamp.origin {
                Origin::Point(position) => {
                    let outside = is_outside(position, sphere.center, sphere.radius);
                    if outside != Some(false) {
                        return Seen::Hidden;
                    }
                }
                Origin::Sun(_) => return Seen::Hidden,
                Origin::Eye => {}
            }
        }
        let mut open = Vec::new();
        let mut look_at = |id: u32| {
            let seen = match self.scene.object(id) {
                Some(Object::Sphere(sphere)) => match is_same(own_sphere, sphere) {
                    true => InTheWay::No,
                    false => beam.meets_sphere(self.relative(sphere.center), sphere.radius),
                },
                Some(Object::Plane(plane)) if id != own => {
                    let normal = self.stage.plane(id).normal;
                    beam.meets_plane(self.relative(plane.point), normal)
                }
                _ => InTheWay::No,
            };
            if seen == InTheWay::Open {
                open.push(id);
            }
            seen != InTheWay::Yes
        };
        if !self.listed.iter().all(|&id| look_at(id)) {
            return Seen::Hidden;
        }
        let mut is_hidden = false;
        if let Some(hierarchy) = &self.prepared.hierarchy {
            let tree = &hierarchy.tree;
            let from = DVec3::from_array(beam.from.0);
            let origin = from + self.to_tree;
            let rounding = 4.0 * UNIT_F64 * (from.length() + self.to_tree.length());
            let segment = Segment {
                origin,
                way: DVec3::from_array(beam.way.0),
                is_endless: beam.is_endless,
                slack: beam.error + rounding,
            };
            match origin.is_finite() {
                true => tree.visit_segment(&segment, |place| {
                    is_hidden = !look_at(tree.order[place] + 1);
                    !is_hidden
                }),
                // So far away that f64 can't say where.
                false => is_hidden = !tree.order.iter().all(|&index| look_at(index + 1)),
            }
        }
        match (is_hidden, open.is_empty()) {
            (true, _) => Seen::Hidden,
            (false, true) => Seen::Lit,
            (false, false) => Seen::Open(open),
        }
    }

    fn exact_beam<'p>(&self, lamp: &Lamp, point: &'p ExactPoint) -> Option<ExactBeam<'p>> {
        match lamp.origin {
            Origin::Eye => ExactBeam::to_position(point, self.prepared.reference),
            Origin::Point(position) => ExactBeam::to_position(point, position),
            Origin::Sun(direction) => ExactBeam::against(point, direction),
        }
    }

    /// Whether a lamp's light reaches a point exactly.
    fn is_seen(
        &self,
        lamp: &Lamp,
        exact: &ExactBeam,
        sample: usize,
        id: u32,
        counts: &mut StageCounts,
    ) -> bool {
        if !lamp.shadows || lamp.origin == Origin::Eye {
            return true;
        }
        let is_in_the_way = |id: u32| {
            self.scene.object(id).is_some_and(|object| exact.is_blocked_by(&object.into()))
        };
        let point = self.stage.point_f64(sample, id);
        let beam = point.and_then(|point| Some((self.beam(lamp, &point)?, point.is_inside)));
        let candidates = match beam.map(|(beam, inside)| self.look(lamp, &beam, inside, id)) {
            Some(Seen::Lit) => return true,
            Some(Seen::Hidden) => return false,
            Some(Seen::Open(candidates)) => candidates,
            None => (1..=self.scene.n_objects() as u32).collect(),
        };
        counts.exact += 1;
        counts.f64 = counts.f64.saturating_sub(1);
        !candidates.into_iter().any(is_in_the_way)
    }
}

fn is_same(own: Option<&Sphere>, other: &Sphere) -> bool {
    own.is_some_and(|own| (own.center, own.radius) == (other.center, other.radius))
}
