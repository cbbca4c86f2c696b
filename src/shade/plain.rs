//! Light as everyone computes it, for the kernels without a proof: shadow rays start on the surface as
//! the kernel's arithmetic has it, or an epsilon away from it.

use super::lamp::{Lamp, Origin};
use super::lit::Job;
use crate::kernel::arithmetic::Arithmetic;
use crate::kernel::coordinates::Coordinates;
use crate::kernel::twin::{Twin, WithTwin};
use crate::kernel::{Hit, RayOf};
use crate::prepare::Prepared;
use crate::rays::{Bundle, Pixels};
use crate::trace::StageCounts;
use crate::vec3::{Real, Vec3, dot3};

/// The mean colour of each pixel that it is asked for.
pub(super) type Means<'a> = &'a (dyn Fn(usize) -> [f64; 3] + Sync);

/// Does `work` with the mean colours of pixels.
pub(super) fn with_means<R>(
    job: &Job,
    prepared: &Prepared,
    samples: &Pixels,
    epsilon: f64,
    work: impl FnOnce(Means) -> R,
) -> R {
    let primary = Primary { job, prepared, samples, epsilon, work };
    prepared.objects.with_twin(prepared.bundle(), prepared.near, primary)
}

/// The work with the kernel for the camera's rays.
struct Primary<'a, W> {
    job: &'a Job<'a>,
    prepared: &'a Prepared,
    samples: &'a Pixels,
    epsilon: f64,
    work: W,
}

impl<R, W: FnOnce(Means) -> R> WithTwin for Primary<'_, W> {
    type Output = R;

    fn with<T: Twin>(self, twin: &T) -> R {
        let objects = &self.prepared.objects;
        objects.with_twin(Bundle::Free, true, Shadows { primary: self, twin })
    }
}

/// The same with the kernel for rays from anywhere as well.
struct Shadows<'a, W, T> {
    primary: Primary<'a, W>,
    twin: &'a T,
}

impl<R, W: FnOnce(Means) -> R, T: Twin> WithTwin for Shadows<'_, W, T> {
    type Output = R;

    fn with<S: Twin>(self, shadows: &S) -> R {
        let Shadows { primary: Primary { job, prepared, samples, epsilon, work }, twin } = self;
        let coordinates = prepared.coordinates();
        let camera = T::Float::camera(&coordinates, samples);
        let plain = Plain { twin, shadows, coordinates, epsilon };
        work(&|pixel| {
            let mut sum = [0.0; 3];
            for sample in job.samples(pixel) {
                let (x, y) = samples.xy(sample);
                let (i, j) = samples.offset2(x, y);
                let light = match &job.lit.lighting {
                    Some(lighting) if job.ids[sample] != 0 => {
                        let ray = T::Float::pixel_ray(&camera, i, j);
                        plain.light(&ray, &lighting.lamps, lighting.ambient)
                    }
                    _ => [1.0; 3],
                };
                let color = job.color(job.ids[sample]);
                for channel in 0..3 {
                    sum[channel] += color[channel] * light[channel];
                }
            }
            let n = job.n_counted(pixel) as f64;
            sum.map(|part| part / n)
        })
    }
}

/// A kernel for both kinds of rays.
struct Plain<'a, T, S> {
    twin: &'a T,
    shadows: &'a S,
    coordinates: Coordinates,
    epsilon: f64,
}

impl<T: Twin, S: Twin> Plain<'_, T, S> {
    /// The light that a ray's hit gets.
    fn light(&self, ray: &RayOf<T::Float>, lamps: &[Lamp], ambient: [f64; 3]) -> [f64; 3] {
        let hit = self.twin.closest(ray);
        if hit.id == 0 {
            return ambient;
        }
        let normal = self.twin.normal_at(ray, hit);
        let point = ray.origin + ray.direction * hit.t;
        let mut light = ambient.map(T::Float::from_f64);
        for lamp in lamps {
            let way = match lamp.origin {
                Origin::Eye => -(ray.direction * hit.t),
                Origin::Point(position) => self.vector::<T>(self.coordinates.of(position)) - point,
                Origin::Sun(direction) => -self.vector::<T>(direction),
            };
            let length = dot3(way, way).sqrt();
            let cosine = dot3(normal, way) * (T::Float::ONE / length);
            let is_endless = matches!(lamp.origin, Origin::Sun(_));
            if cosine > T::Float::ZERO
                && !(lamp.shadows && self.is_hidden(point, way, length, is_endless))
            {
                for (sum, weight) in light.iter_mut().zip(lamp.weight) {
                    *sum = *sum + T::Float::from_f64(weight) * cosine;
                }
            }
        }
        light.map(T::Float::to_f64)
    }

    fn vector<F: Twin>(&self, v: glam::DVec3) -> Vec3<F::Float> {
        Vec3(v.to_array().map(F::Float::from_f64))
    }

    /// Whether the shadow ray, which starts `epsilon` nearer to the lamp, meets anything before it.
    fn is_hidden(
        &self,
        point: Vec3<T::Float>,
        way: Vec3<T::Float>,
        length: T::Float,
        is_endless: bool,
    ) -> bool {
        let to_s = |v: Vec3<T::Float>| Vec3(v.0.map(|x| S::Float::from_f64(x.to_f64())));
        let (way, length) = (to_s(way), S::Float::from_f64(length.to_f64()));
        let step = S::Float::from_f64(self.epsilon) / length;
        let origin = to_s(point) + way * step;
        let Hit { t, id } = self.shadows.closest(&RayOf::new(origin, Vec3::ZERO, way));
        id != 0 && (is_endless || t < S::Float::ONE - step)
    }
}

/// All ways to lamps are looked at in the kernel's own arithmetic.
pub(super) fn counts(job: &Job, n_pixels: usize, is_f64: bool) -> StageCounts {
    let n_lamps = job.lit.lighting.as_ref().map_or(0, |lighting| lighting.lamps.len());
    let n_hits = |pixel| job.samples(pixel).filter(|&at| job.ids[at] != 0).count();
    let n = ((0..n_pixels).map(n_hits).sum::<usize>() * n_lamps) as u64;
    match is_f64 {
        true => StageCounts { f64: n, ..StageCounts::default() },
        false => StageCounts { f32: n, ..StageCounts::default() },
    }
}
