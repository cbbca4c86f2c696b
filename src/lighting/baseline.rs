//! Light as everyone computes it, for the kernels without a proof: shadow rays start on the surface as
//! the kernel's arithmetic has it, or an epsilon away from it. Twin of `shaders/baseline_light.wgsl`.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use pulp::{Simd, WithSimd};

use super::ColorCounts;
use super::lit::{Job, Lit};
use crate::error::Result;
use crate::kernel::baseline::{Baseline, BaselineRay, BaselineRays, Hit, LANES};
use crate::kernel::coordinates::Coordinates;
use crate::kernel::{Lists, ObjectRecords};
use crate::num::{Bits, Float, LaneBits, Lanes, Mask, Ray, Real, V3, dispatch};
use crate::prepare::{Lighting, Prepared, PreparedLight};
use crate::query::{Rays, Stage, StageCounts};
use crate::scene::Source;
use crate::support::control::Control;
use crate::support::parallel;
use crate::tracer::{Backend, Tracer};

/// Samples whose light comes from a device at a time; bounds the memory for it.
const SAMPLES_AT_ONCE: u32 = 1 << 18;

/// Fills `colors` with those of all pixels, by the device of `tracer` where that lights them. Returns where they are from; all ways
/// to lamps are looked at in the kernel's own arithmetic. `encode` encodes the linear mean of a pixel's samples.
pub(super) fn light_pixels<C: Send>(
    job: &Job,
    prepared: &Prepared,
    tracer: &mut Tracer,
    control: &Control,
    colors: &mut [C],
    encode: impl Fn([f64; 3]) -> C + Sync,
) -> Result<(ColorCounts, StageCounts)> {
    let n_pixels = colors.len() as u64;
    let n_hits = job.ids.iter().filter(|&&id| id != 0).count();
    let n_rays = (n_hits * job.lit.lighting.lamps.len()) as u64;
    let counts = StageCounts::of(n_rays, Stage::of(prepared.kernel));
    if let Some(backend) = tracer.backend()
        && light_with(backend, job, control, colors, &encode)?
    {
        return Ok((ColorCounts { device: n_pixels, ..ColorCounts::default() }, counts));
    }
    let of_row = |scratch: &mut BaselineScratch, (row, colors): (usize, &mut [C])| {
        let BaselineScratch { hits, lights } = scratch;
        hits.resize(job.row(), (0, 0));
        lights.clear();
        lights.resize(samples_of_row(job), [0.0; 3]);
        match &prepared.objects {
            ObjectRecords::Lecture(lists) => {
                dispatch(BaselineLightPass { lists, prepared, job, row, control, hits, lights })
            }
            ObjectRecords::Stable(lists) => {
                dispatch(BaselineLightPass { lists, prepared, job, row, control, hits, lights })
            }
            ObjectRecords::Double(lists) => {
                dispatch(BaselineLightPass { lists, prepared, job, row, control, hits, lights })
            }
            ObjectRecords::Certified { .. } => Ok(()),
        }?;
        mix(job, row, lights, control, colors, &encode);
        Ok(())
    };
    let rows = colors.chunks_mut(job.n_columns().max(1)).enumerate();
    parallel::try_map_in(rows, of_row)?;
    Ok((ColorCounts { cpu: n_pixels, ..ColorCounts::default() }, counts))
}

/// Scratch buffers of a thread, for a row of pixels.
#[derive(Default)]
struct BaselineScratch {
    /// Columns and ids of the samples in a row that hit an object; the buffer is as long as the row.
    hits: Vec<(usize, u32)>,
    /// Light on each sample.
    lights: Vec<[f64; 3]>,
}

/// Fills `colors` as [`light_pixels`] does, by the light of a device, some rows at a time. Returns `false` if the CPU has to do it.
fn light_with<C: Send>(
    backend: &mut dyn Backend,
    job: &Job,
    control: &Control,
    colors: &mut [C],
    encode: &(impl Fn([f64; 3]) -> C + Sync),
) -> Result<bool> {
    let Job { lit: Lit { lighting, style, .. }, samples, .. } = job;
    let n_samples = job.n_samples() as u32;
    let columns = job.n_columns().max(1);
    let n_rows = (SAMPLES_AT_ONCE / (samples.width * n_samples).max(1)).max(1) as usize;
    let mut lights = Vec::new();
    for (part, colors) in colors.chunks_mut(n_rows * columns).enumerate() {
        let (first_row, n_rows) = (part * n_rows, colors.len() / columns);
        let rows = samples.rows(first_row as u32 * n_samples, n_rows as u32 * n_samples);
        if !backend.light_plainly(lighting, style.epsilon, &rows, control, &mut lights)? {
            return Ok(false);
        }
        let rows = colors.chunks_mut(columns).zip(lights.chunks(samples_of_row(job)));
        control.check()?;
        parallel::map(rows.enumerate(), |(row, (colors, lights))| {
            mix(job, first_row + row, lights, control, colors, encode);
        });
    }
    Ok(true)
}

/// Samples of a row of pixels.
fn samples_of_row(job: &Job) -> usize {
    job.n_samples() * job.row()
}

/// The mean colours of a row's pixels, from the light on what its samples see.
fn mix<C>(
    job: &Job,
    row: usize,
    lights: &[[f64; 3]],
    control: &Control,
    colors: &mut [C],
    encode: &impl Fn([f64; 3]) -> C,
) {
    job.advance(control, colors.len());
    for (pixel, color) in (row * job.n_columns()..).zip(colors) {
        let mut sum = [0.0; 3];
        for sample in job.samples_of(pixel) {
            let id = job.ids[sample];
            let light = if id == 0 { [1.0; 3] } else { lights[sample - row * samples_of_row(job)] };
            let color = job.color(id);
            for channel in 0..3 {
                sum[channel] += color[channel] * light[channel];
            }
        }
        let n = job.n_counted(pixel) as f64;
        *color = encode(sum.map(|part| part / n));
    }
}

/// The light that a row of pixels' samples find on what they see, compiled for each instruction set that the processor may have.
struct BaselineLightPass<'a, S: Baseline, P> {
    lists: &'a Lists<S, P>,
    prepared: &'a Prepared,
    job: &'a Job<'a>,
    row: usize,
    control: &'a Control,
    hits: &'a mut [(usize, u32)],
    lights: &'a mut [[f64; 3]],
}

impl<S: Baseline, P: Baseline<Float = S::Float>> WithSimd for BaselineLightPass<'_, S, P> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Result<()> {
        let BaselineLightPass { lists, prepared, job, row, control, hits, lights } = self;
        let coordinates = prepared.coordinates();
        let Lit { lighting, style, .. } = job.lit;
        let scene = BaselineScene { lists, coordinates, lighting, epsilon: style.epsilon };
        let rays = BaselineRays::of_pixels(coordinates, job.samples);
        let first = row * samples_of_row(job);
        for (first, lights) in (first..).step_by(job.row()).zip(lights.chunks_mut(job.row())) {
            let ids = &job.ids[first..][..lights.len()];
            let mut n_hits = 0;
            for (column, &id) in ids.iter().enumerate() {
                hits[n_hits] = (column, id);
                n_hits += usize::from(id != 0);
            }
            for hits in hits[..n_hits].chunks(LANES) {
                // A ray may have millions of spheres to look at.
                control.check()?;
                let (mut steps, mut seen) = ([0; LANES], LaneBits([Bits::from_id(0); LANES]));
                for ((step, seen), &(column, id)) in steps.iter_mut().zip(&mut seen.0).zip(hits) {
                    (*step, *seen) = (column, Bits::from_id(id));
                }
                let found = scene.light(&rays.gather(first, &steps), &seen);
                for (lane, &(column, _)) in (0..LANES).zip(hits) {
                    let light = &mut lights[column];
                    for channel in 0..3 {
                        light[channel] = found.0[channel].0[lane].to_f64();
                    }
                }
            }
        }
        Ok(())
    }
}

/// A kernel's objects, with what lights them.
struct BaselineScene<'a, S, P> {
    lists: &'a Lists<S, P>,
    /// The kernel's.
    coordinates: Coordinates,
    lighting: &'a Lighting,
    /// How far from a surface shadow rays start, world units.
    epsilon: f64,
}

impl<F: Float, S: Baseline<Float = F>, P: Baseline<Float = F>> BaselineScene<'_, S, P> {
    /// The light on what rays see; where that is nothing, what is from nowhere.
    #[inline(always)]
    fn light<const N: usize>(
        &self,
        ray: &BaselineRay<Lanes<F, N>>,
        ids: &LaneBits<F, N>,
    ) -> V3<Lanes<F, N>> {
        let zero = Lanes::lit(0.0);
        let (t, normal) = self.lists.surfaces(ray, ids);
        // A device's arithmetic may see what that of this machine does not.
        let is_hit = zero.lt(t) & t.lt(Lanes::lit(f64::INFINITY));
        let mut sum = V3(self.lighting.ambient.map(Lanes::lit));
        for lamp in &self.lighting.lamps {
            let BaselineShadowRay { cosine, is_blocked, .. } = self.way_to(ray, t, normal, lamp);
            let is_lit = is_hit & zero.lt(cosine) & !is_blocked;
            let given = V3(lamp.weight.map(|weight| Lanes::lit(weight) * cosine));
            sum = V3::select(is_lit, sum + given, sum);
        }
        sum
    }

    /// The ways from hits to a lamp; what is in them is looked for where the lamp shines on the surface.
    #[inline(always)]
    fn way_to<const N: usize>(
        &self,
        BaselineRay { ray, .. }: &BaselineRay<Lanes<F, N>>,
        t: Lanes<F, N>,
        normal: V3<Lanes<F, N>>,
        lamp: &PreparedLight,
    ) -> BaselineShadowRay<Lanes<F, N>> {
        let (zero, one) = (Lanes::lit(0.0), Lanes::lit(1.0));
        let point = ray.origin + ray.direction * t;
        let way = match lamp.origin {
            Source::Eye => -(ray.direction * t),
            Source::Point(position) => V3::lit(self.coordinates.of(position)) - point,
            Source::Sun(direction) => V3::lit(-direction),
        };
        let length = way.dot(way).sqrt();
        let cosine = normal.dot(way) * (one / length);
        let (mut first, mut is_blocked) = (Hit::miss(), zero.lt(zero));
        let is_asked = zero.lt(cosine);
        if lamp.shadows && is_asked.any() {
            // The shadow ray starts `epsilon` nearer to the lamp, which is at 1.
            let step = Lanes::lit(self.epsilon) / length;
            let origin_low = Some(V3([zero; 3]));
            first = self
                .lists
                .closest(&BaselineRay { ray: Ray::new(point + way * step, way), origin_low });
            let end = match lamp.origin {
                Source::Sun(_) => Lanes::lit(f64::INFINITY),
                _ => one - step,
            };
            is_blocked = is_asked & first.t.lt(end);
        }
        BaselineShadowRay { way, cosine, first, is_blocked }
    }
}

/// The way to a lamp in a kernel's arithmetic.
struct BaselineShadowRay<R: Real> {
    way: V3<R>,
    cosine: R,
    /// What the shadow ray meets first,
    first: Hit<R>,
    /// and whether that is before the lamp.
    is_blocked: R::Mask,
}

/// What a kernel without a proof makes of the light on the point that one ray sees, without epsilon.
#[derive(Clone, Debug)]
pub struct BaselinePoint {
    /// The object.
    pub id: u32,
    /// Ray parameter, of the direction as the kernel scales it.
    pub t: f64,
    /// The point, in the kernel's coordinates.
    pub at: [f64; 3],
    /// The unit normal that faces the ray.
    pub normal: [f64; 3],
    /// The lamps, in their order.
    pub ways: Vec<BaselineWay>,
    /// All that they give, and the ambient light.
    pub light: [f64; 3],
}

/// The way to a lamp.
#[derive(Clone, Debug)]
pub struct BaselineWay {
    /// `w`
    pub way: [f64; 3],
    /// `n·ω`
    pub cosine: f64,
    /// The first object in the way, and its `s`.
    pub in_the_way: Option<(u32, f64)>,
    /// What the lamp gives.
    pub given: [f64; 3],
}

impl BaselinePoint {
    /// The numbers of a kernel for one ray; `None` where it sees the background.
    pub fn new(prepared: &Prepared, rays: &Rays, lighting: &Lighting) -> Option<BaselinePoint> {
        let coordinates = prepared.coordinates();
        match &prepared.objects {
            ObjectRecords::Lecture(lists) => point(lists, coordinates, rays, lighting),
            ObjectRecords::Stable(lists) => point(lists, coordinates, rays, lighting),
            ObjectRecords::Double(lists) => point(lists, coordinates, rays, lighting),
            ObjectRecords::Certified { .. } => None,
        }
    }
}

fn point<F: Float, S: Baseline<Float = F>, P: Baseline<Float = F>>(
    lists: &Lists<S, P>,
    coordinates: Coordinates,
    rays: &Rays,
    lighting: &Lighting,
) -> Option<BaselinePoint> {
    let scene = BaselineScene { lists, coordinates, lighting, epsilon: 0.0 };
    let ray = BaselineRays::new(coordinates, rays).pack::<1>(0);
    let ids = lists.closest(&ray).id;
    let id = ids.0[0].to_id();
    if id == 0 {
        return None;
    }
    let (t, normal) = lists.surfaces(&ray, &ids);
    let to_f64 = |v: V3<Lanes<F, 1>>| v.0.map(|x| x.0[0].to_f64());
    let zero = Lanes::lit(0.0);
    let way = |lamp: &PreparedLight| {
        let BaselineShadowRay { way, cosine, first, is_blocked } =
            scene.way_to(&ray, t, normal, lamp);
        let first = (first.id.0[0].to_id(), first.t.0[0].to_f64());
        let in_the_way = is_blocked.any().then_some(first);
        let given = V3(lamp.weight.map(|weight| Lanes::lit(weight) * cosine));
        let given = to_f64(V3::select(zero.lt(cosine) & !is_blocked, given, V3([zero; 3])));
        BaselineWay { way: to_f64(way), cosine: cosine.0[0].to_f64(), in_the_way, given }
    };
    Some(BaselinePoint {
        id,
        t: t.0[0].to_f64(),
        at: to_f64(ray.ray.origin + ray.ray.direction * t),
        normal: to_f64(normal),
        ways: parallel::map(&lighting.lamps, way),
        light: to_f64(scene.light(&ray, &ids)),
    })
}
