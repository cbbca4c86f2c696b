//! Light as everyone computes it, for the kernels without a proof: shadow rays start on the surface as
//! the kernel's arithmetic has it, or an epsilon away from it. Twin of `shaders/plain_light.wgsl`.

use rayon::prelude::*;

use super::lamp::{Lamp, Lighting, Origin};
use super::lit::Job;
use super::written::Written;
use crate::control::Control;
use crate::error::Result;
use crate::kernel::arithmetic::Arithmetic;
use crate::kernel::coordinates::Coordinates;
use crate::kernel::twin::{Twin, WithTwin};
use crate::kernel::{Hit, RayOf};
use crate::prepare::{PlainLamp, PlainLighting, Prepared, lamp_kind};
use crate::rays::Pixels;
use crate::trace::{Rays, StageCounts};
use crate::tracer::Tracer;
use crate::vec3::{Real, Vec3, dot3};

/// Samples whose light comes from a device at a time; bounds the memory for it.
const SAMPLES_AT_ONCE: u32 = 1 << 18;

/// Fills `colors` with those of all pixels, whose samples are the rays `samples`. True where `device` lit them.
pub(super) fn shade<T: Written>(
    job: &Job,
    (prepared, samples): (&Prepared, &Pixels),
    device: Option<&mut (dyn Tracer + '_)>,
    control: &Control,
    colors: &mut [T],
) -> Result<bool> {
    if let Some(device) = device
        && shade_with(device, job, (prepared, samples), control, colors)?
    {
        return Ok(true);
    }
    let mut work =
        |light: Light| job.run(control, colors, |pixel| T::of_plain(mean(job, pixel, light)));
    let with_light = WithLight { job, prepared, samples, work: &mut work };
    prepared.objects.with_twin(prepared.bundle(), with_light).transpose()?;
    Ok(false)
}

/// The same with a device's light, some rows at a time. False where the device leaves it to the CPU.
fn shade_with<T: Written>(
    device: &mut (dyn Tracer + '_),
    job: &Job,
    (prepared, samples): (&Prepared, &Pixels),
    control: &Control,
    colors: &mut [T],
) -> Result<bool> {
    let lighting = lighting_of(job, prepared);
    let n_samples = job.lit.style.n_samples.across();
    let columns = (samples.width / n_samples).max(1) as usize;
    let n_rows = (SAMPLES_AT_ONCE / (samples.width * n_samples).max(1)).max(1) as usize;
    let mut lights = Vec::new();
    for (number, colors) in colors.chunks_mut(n_rows * columns).enumerate() {
        let first_row = number * n_rows;
        let height = colors.len() / columns;
        let rows = samples.rows(first_row as u32 * n_samples, height as u32 * n_samples);
        if !device.light_plainly(&lighting, &rows, control, &mut lights)? {
            return Ok(false);
        }
        let (first_pixel, first_sample) =
            (first_row * columns, first_row * n_samples as usize * job.row);
        let light = |sample: usize| lights[sample - first_sample];
        job.run(control, colors, |at| T::of_plain(mean(job, first_pixel + at, light)))?;
    }
    Ok(true)
}

/// The lamps in the coordinates of the kernel.
fn lighting_of(job: &Job, prepared: &Prepared) -> PlainLighting {
    let Lighting { lamps, ambient, .. } = &job.lit.lighting;
    let coordinates = prepared.coordinates();
    let lamp = |lamp: &Lamp| {
        let (at, kind) = match lamp.origin {
            Origin::Eye => ([0.0; 3], lamp_kind::EYE),
            Origin::Point(position) => (coordinates.of(position).to_array(), lamp_kind::POINT),
            Origin::Sun(direction) => ((-direction).to_array(), lamp_kind::SUN),
        };
        PlainLamp { at, kind, weight: lamp.weight, shadows: lamp.shadows }
    };
    PlainLighting {
        ambient: *ambient,
        epsilon: job.lit.style.epsilon,
        lamps: lamps.iter().map(lamp).collect(),
    }
}

/// The mean colour of a pixel, from the light on what its samples see.
fn mean(job: &Job, pixel: usize, light: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for sample in job.samples(pixel) {
        let id = job.ids[sample];
        let light = if id == 0 { [1.0; 3] } else { light(sample) };
        let color = job.color(id);
        for channel in 0..3 {
            sum[channel] += color[channel] * light[channel];
        }
    }
    let n = job.n_counted(pixel) as f64;
    sum.map(|part| part / n)
}

/// The light on what a sample sees.
type Light<'a> = &'a (dyn Fn(usize) -> [f64; 3] + Sync);

/// The work with the kernel, which is not compiled once for each way to write colours.
struct WithLight<'a> {
    job: &'a Job<'a>,
    prepared: &'a Prepared,
    samples: &'a Pixels,
    work: &'a mut dyn FnMut(Light) -> Result<()>,
}

impl WithTwin for WithLight<'_> {
    type Output = Result<()>;

    fn with<T: Twin>(self, twin: &T) -> Result<()> {
        let WithLight { job, prepared, samples, work } = self;
        let coordinates = prepared.coordinates();
        let camera = T::Float::camera(&coordinates, samples);
        let (lighting, epsilon) = (&job.lit.lighting, job.lit.style.epsilon);
        let plain = Plain { twin, coordinates, lighting, epsilon };
        work(&|sample| {
            let (x, y) = samples.xy(sample);
            let (i, j) = samples.offset2(x, y);
            plain.light(&T::Float::pixel_ray(&camera, i, j))
        })
    }
}

/// A kernel, with what lights its hits.
struct Plain<'a, T> {
    twin: &'a T,
    coordinates: Coordinates,
    lighting: &'a Lighting,
    epsilon: f64,
}

impl<T: Twin> Plain<'_, T> {
    /// The light that a ray's hit gets.
    fn light(&self, ray: &RayOf<T::Float>) -> [f64; 3] {
        let Lighting { lamps, ambient, .. } = self.lighting;
        let hit = self.twin.closest(ray);
        if hit.id == 0 {
            return *ambient;
        }
        let normal = self.twin.normal_at(ray, hit);
        let mut sum = ambient.map(T::Float::from_f64);
        for lamp in lamps {
            let Way { cosine, in_the_way, .. } = self.way_to(ray, hit, normal, lamp);
            if cosine > T::Float::ZERO && in_the_way.is_none() {
                for (sum, weight) in sum.iter_mut().zip(lamp.weight) {
                    *sum = *sum + T::Float::from_f64(weight) * cosine;
                }
            }
        }
        sum.map(T::Float::to_f64)
    }

    /// The way from a hit to a lamp; what is in it is looked for where the lamp shines on the surface.
    fn way_to(
        &self,
        ray: &RayOf<T::Float>,
        hit: Hit<T::Float>,
        normal: Vec3<T::Float>,
        lamp: &Lamp,
    ) -> Way<T::Float> {
        let point = ray.origin + ray.direction * hit.t;
        let way = match lamp.origin {
            Origin::Eye => -(ray.direction * hit.t),
            Origin::Point(position) => self.vector(self.coordinates.of(position)) - point,
            Origin::Sun(direction) => -self.vector(direction),
        };
        let length = dot3(way, way).sqrt();
        let cosine = dot3(normal, way) * (T::Float::ONE / length);
        let is_endless = matches!(lamp.origin, Origin::Sun(_));
        let is_asked = cosine > T::Float::ZERO && lamp.shadows;
        let in_the_way =
            is_asked.then(|| self.in_the_way(point, way, length, is_endless)).flatten();
        Way { way, cosine, in_the_way }
    }

    fn vector(&self, v: glam::DVec3) -> Vec3<T::Float> {
        Vec3(v.to_array().map(T::Float::from_f64))
    }

    /// What the shadow ray, which starts `epsilon` nearer to the lamp, meets before it.
    fn in_the_way(
        &self,
        point: Vec3<T::Float>,
        way: Vec3<T::Float>,
        length: T::Float,
        is_endless: bool,
    ) -> Option<Hit<T::Float>> {
        let step = T::Float::from_f64(self.epsilon) / length;
        let ray = RayOf::new(point + way * step, Vec3::ZERO, way);
        let hit = self.twin.closest_from_anywhere(&ray);
        (hit.id != 0 && (is_endless || hit.t < T::Float::ONE - step)).then_some(hit)
    }
}

/// The way to a lamp in a kernel's arithmetic.
struct Way<T> {
    way: Vec3<T>,
    cosine: T,
    in_the_way: Option<Hit<T>>,
}

/// What a kernel without a proof makes of the light on the point that one ray sees, without epsilon.
#[derive(Clone, Debug)]
pub(crate) struct PlainPoint {
    /// The object.
    pub id: u32,
    /// Ray parameter, of the direction as the kernel scales it.
    pub t: f64,
    /// The point, in the kernel's coordinates.
    pub at: [f64; 3],
    /// The unit normal that faces the ray.
    pub normal: [f64; 3],
    /// The lamps, in their order.
    pub ways: Vec<PlainWay>,
    /// All that they give, and the ambient light.
    pub light: [f64; 3],
}

/// The way to a lamp.
#[derive(Clone, Debug)]
pub(crate) struct PlainWay {
    /// `w`
    pub way: [f64; 3],
    /// `n·ω`
    pub cosine: f64,
    /// The first object in the way, and its `s`.
    pub in_the_way: Option<(u32, f64)>,
}

/// The numbers of a kernel for one ray; `None` where it sees the background.
pub(crate) fn plainly(prepared: &Prepared, rays: &Rays, lighting: &Lighting) -> Option<PlainPoint> {
    prepared.objects.with_twin(prepared.bundle(), One { prepared, rays, lighting }).flatten()
}

struct One<'a> {
    prepared: &'a Prepared,
    rays: &'a Rays,
    lighting: &'a Lighting,
}

impl WithTwin for One<'_> {
    type Output = Option<PlainPoint>;

    fn with<T: Twin>(self, twin: &T) -> Option<PlainPoint> {
        let One { prepared, rays, lighting } = self;
        let coordinates = prepared.coordinates();
        let ray = match rays {
            Rays::Pixels(pixels) => {
                let (i, j) = pixels.offset2(pixels.x, pixels.y);
                T::Float::pixel_ray(&T::Float::camera(&coordinates, pixels), i, j)
            }
            Rays::List(rays) => T::Float::list_ray(&coordinates, rays.first()?).0,
        };
        let hit = twin.closest(&ray);
        if hit.id == 0 {
            return None;
        }
        let plain = Plain { twin, coordinates, lighting, epsilon: 0.0 };
        let normal = twin.normal_at(&ray, hit);
        let to_f64 = |v: Vec3<T::Float>| v.0.map(T::Float::to_f64);
        let way = |lamp| {
            let Way { way, cosine, in_the_way } = plain.way_to(&ray, hit, normal, lamp);
            let in_the_way = in_the_way.map(|hit| (hit.id, hit.t.to_f64()));
            PlainWay { way: to_f64(way), cosine: cosine.to_f64(), in_the_way }
        };
        Some(PlainPoint {
            id: hit.id,
            t: hit.t.to_f64(),
            at: to_f64(ray.origin + ray.direction * hit.t),
            normal: to_f64(normal),
            ways: lighting.lamps.par_iter().map(way).collect(),
            light: plain.light(&ray),
        })
    }
}

/// All ways to lamps are looked at in the kernel's own arithmetic.
pub(super) fn counts(job: &Job, n_pixels: usize, is_f64: bool) -> StageCounts {
    let n_lamps = job.lit.lighting.lamps.len();
    let n_hits = |pixel| job.samples(pixel).filter(|&at| job.ids[at] != 0).count();
    let n = ((0..n_pixels).map(n_hits).sum::<usize>() * n_lamps) as u64;
    match is_f64 {
        true => StageCounts { f64: n, ..StageCounts::default() },
        false => StageCounts { f32: n, ..StageCounts::default() },
    }
}
