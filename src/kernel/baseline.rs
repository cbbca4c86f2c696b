//! The kernels without a proof: their rays, and how they go through a scene's objects. One text serves rays side by side, one
//! ray whose numbers are shown, and the arithmetic of tests.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use super::FloatType;
use super::coordinates::{Coordinates, split};
use crate::num::{Bits, Float, LaneBits, Lanes, Ray, Real, V3};
use crate::rays;
use crate::rays::{Frame, Lens, Pixels, Rays};

/// Rays that go side by side: in f32 and in f64, where two registers a number hide how long each operation takes.
pub const LANES: usize = 16;

/// A ray as a kernel without a proof sees it. Twin of `Ray` in `shaders/ray.wgsl`.
#[derive(Clone, Copy, Debug)]
pub struct BaselineRay<R> {
    /// The ray, in world units for `lecture`, else relative to the reference point.
    pub ray: Ray<R>,
    /// The rest that the origin's rounding left; none where all rays start at the reference point.
    pub origin_low: Option<V3<R>>,
}

/// The closest hit so far. Twin of `Hit` in `shaders/ray.wgsl`.
#[derive(Clone, Copy, Debug)]
pub struct Hit<R: Real> {
    /// Ray parameter, +∞ for none.
    pub t: R,
    /// Object id, 0 for none.
    pub id: R::Id,
}

impl<R: Real> Hit<R> {
    /// Nothing was hit.
    #[inline(always)]
    pub fn miss() -> Self {
        Hit { t: R::lit(f64::INFINITY), id: R::splat_id(0) }
    }

    /// The nearer of the hit so far and a candidate, whose `t` is 0 where there is none. Equal `t`: the lower id, which
    /// comes first, stays.
    #[inline(always)]
    pub fn closer(self, t: R, id: u32) -> Self {
        let is_closer = R::lit(0.0).lt(t) & t.lt(self.t);
        Hit {
            t: R::select(is_closer, t, self.t),
            id: R::select_id(is_closer, R::splat_id(id), self.id),
        }
    }
}

/// The first of two roots that is above 0, or 0.
#[inline(always)]
pub(super) fn first_positive<R: Real>([near, far]: [R; 2]) -> R {
    let zero = R::lit(0.0);
    R::select(zero.lt(near), near, R::select(zero.lt(far), far, zero))
}

/// `v / ‖v‖`, turned so that it faces against `direction`. Twin of `facing` in `shaders/vec.wgsl`.
#[inline(always)]
pub fn facing<R: Real>(v: V3<R>, direction: V3<R>) -> V3<R> {
    let unit = v * (R::lit(1.0) / v.dot(v).sqrt());
    V3::select(R::lit(0.0).lt(unit.dot(direction)), -unit, unit)
}

/// An object in the numbers of a kernel without a proof.
pub trait Baseline: Sync {
    /// The kernel's arithmetic.
    type Float: Float;
    /// The smallest positive `t` at which a ray meets it, or 0 for none.
    fn t<R: Real<One = Self::Float>>(&self, ray: &BaselineRay<R>) -> R;
    /// A vector along its normal where a ray meets it at `t`.
    fn normal<R: Real<One = Self::Float>>(&self, ray: &BaselineRay<R>, t: R) -> V3<R>;
}

/// Spheres and planes, each in id order.
#[derive(Clone, Debug)]
pub struct Lists<S, P> {
    /// Spheres.
    pub spheres: Vec<S>,
    /// Planes.
    pub planes: Vec<P>,
}

impl<S: bytemuck::NoUninit, P: bytemuck::NoUninit> Lists<S, P> {
    /// The bytes of the spheres and those of the planes.
    pub fn bytes(&self) -> (&[u8], &[u8]) {
        (bytemuck::cast_slice(&self.spheres), bytemuck::cast_slice(&self.planes))
    }
}

impl<S: Baseline, P: Baseline<Float = S::Float>> Lists<S, P> {
    /// The closest hit of a ray. Twin of `closest` in the shaders.
    #[inline(always)]
    pub fn closest<R: Real<One = S::Float>>(&self, ray: &BaselineRay<R>) -> Hit<R> {
        let mut hit = Hit::miss();
        for (sphere, id) in self.spheres.iter().zip(1..) {
            hit = hit.closer(sphere.t(ray), id);
        }
        for (plane, id) in self.planes.iter().zip(self.spheres.len() as u32 + 1..) {
            hit = hit.closer(plane.t(ray), id);
        }
        hit
    }

    /// `t` and the unit normals where rays meet these objects, which they see first; +∞ for none of the scene, as 0, whatever a device says.
    /// Twin of `normal_at` in the shaders.
    #[inline(always)]
    pub fn surfaces<const N: usize>(
        &self,
        ray: &BaselineRay<Lanes<S::Float, N>>,
        ids: &LaneBits<S::Float, N>,
    ) -> (Lanes<S::Float, N>, V3<Lanes<S::Float, N>>) {
        let mut ts = Lanes::lit(f64::INFINITY);
        let (mut normals, mut is_known) = (V3([Lanes::lit(0.0); 3]), [false; N]);
        for lane in 0..N {
            let id = ids.0[lane];
            if id.to_id() == 0 || is_known[lane] {
                continue;
            }
            let index = id.to_id() as usize - 1;
            let (t, along) = match self.spheres.get(index) {
                Some(sphere) => met(sphere, ray),
                None => match self.planes.get(index - self.spheres.len()) {
                    Some(plane) => met(plane, ray),
                    None => continue,
                },
            };
            let mut is_this = *ids;
            for other in 0..N {
                is_known[other] |= ids.0[other] == id;
                is_this.0[other] = Bits::from_bool(ids.0[other] == id);
            }
            ts = Lanes::select(is_this, t, ts);
            normals = V3::select(is_this, facing(along, ray.ray.direction), normals);
        }
        (ts, normals)
    }
}

/// `t` of an object, and a vector along its normal there.
#[inline(always)]
fn met<P: Baseline, R: Real<One = P::Float>>(object: &P, ray: &BaselineRay<R>) -> (R, V3<R>) {
    let t = object.t(ray);
    (t, object.normal(ray, t))
}

/// The rays of a call, in the coordinates and the arithmetic of a kernel without a proof.
pub enum BaselineRays<'a, F: Float> {
    /// Pixels: twice their offsets from the picture's centre are multiplied with `step` before the camera has them.
    Pixels {
        /// They.
        pixels: &'a Pixels,
        /// Their camera.
        camera: Frame<F>,
        /// 1 in f32, whose camera has the pixel's size already.
        step: F,
        /// Where the camera stands.
        origin: V3<F>,
    },
    /// Any rays.
    List {
        /// They.
        rays: &'a [rays::WorldRay],
        /// The kernel's.
        coordinates: Coordinates,
    },
}

impl<'a, F: Float> BaselineRays<'a, F> {
    /// These rays.
    pub fn new(coordinates: Coordinates, rays: &'a Rays) -> BaselineRays<'a, F> {
        match rays {
            Rays::Pixels(pixels) => BaselineRays::of_pixels(coordinates, pixels),
            Rays::List(rays) => BaselineRays::List { rays, coordinates },
        }
    }

    /// The rays of these pixels.
    pub fn of_pixels(coordinates: Coordinates, pixels: &'a Pixels) -> BaselineRays<'a, F> {
        let (in_camera, step) = match coordinates.kernel.about().float {
            FloatType::F32 => (pixels.step(), 1.0),
            FloatType::F64 => (1.0, pixels.step()),
        };
        BaselineRays::Pixels {
            pixels,
            camera: Frame::new(&pixels.view, in_camera),
            step: F::near(step),
            origin: V3::lit(coordinates.of(pixels.view.position)),
        }
    }

    /// One of the rays.
    pub fn one(&self, index: usize) -> BaselineRay<F> {
        let BaselineRay { ray, origin_low } = self.pack::<1>(index);
        let alone = |x: Lanes<F, 1>| x.0[0];
        BaselineRay { ray: ray.map(alone), origin_low: origin_low.map(|low| low.map(alone)) }
    }

    /// Some rays, from the one with this index on; of a picture in its row and beyond its end, of a list the last one again.
    #[inline(always)]
    pub fn pack<const N: usize>(&self, first: usize) -> BaselineRay<Lanes<F, N>> {
        let mut steps = [0; N];
        for lane in 0..N {
            steps[lane] = lane;
        }
        self.gather(first, &steps)
    }

    /// Returns the rays with the indices `first` + `steps`. In a picture, they are in the row of `first`. In a list, the last ray
    /// replaces those beyond the end.
    #[inline(always)]
    pub fn gather<const N: usize>(
        &self,
        first: usize,
        steps: &[usize; N],
    ) -> BaselineRay<Lanes<F, N>> {
        let zero = V3([Lanes::lit(0.0); 3]);
        match self {
            BaselineRays::Pixels { pixels, camera, step, origin } => {
                let (x, y) = pixels.xy(first);
                let (i, j) = pixels.offset2(x, y);
                let mut across = Lanes::lit(0.0);
                for lane in 0..N {
                    across.0[lane] = *step * F::near((i + 2 * steps[lane] as i64) as f64);
                }
                let up = Lanes::splat(*step * F::near(j as f64));
                let (ray, origin) = (camera.ray(across, up), V3::splat(*origin));
                let (origin, origin_low) = match camera.lens {
                    Lens::Perspective => (origin, None),
                    Lens::Orthographic => (origin + ray.origin, Some(zero)),
                };
                BaselineRay { ray: Ray { origin, ..ray }, origin_low }
            }
            BaselineRays::List { rays, coordinates } => {
                let (mut origin, mut origin_low, mut direction) = (zero, zero, zero);
                for lane in 0..N {
                    let ray = &rays[(first + steps[lane]).min(rays.len() - 1)];
                    let (at, way, _) = coordinates.ray(ray);
                    let [high, low] = split::<F>(at);
                    for axis in 0..3 {
                        origin.0[axis].0[lane] = high[axis];
                        origin_low.0[axis].0[lane] = low[axis];
                        direction.0[axis].0[lane] = F::near(way[axis]);
                    }
                }
                BaselineRay { ray: Ray::new(origin, direction), origin_low: Some(origin_low) }
            }
        }
    }

    /// What the `t` of the rays of a pack is multiplied with.
    #[inline(always)]
    pub fn scales<const N: usize>(&self, first: usize) -> [f64; N] {
        let mut scales = [1.0; N];
        if let BaselineRays::List { rays, coordinates } = self {
            for lane in 0..N {
                let (_, _, exponent) = coordinates.ray(&rays[(first + lane).min(rays.len() - 1)]);
                scales[lane] = 2f64.powi(-exponent);
            }
        }
        scales
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::lecture::{PlaneLecture, SphereLecture};

    /// A driver may say anything.
    #[test]
    fn an_id_of_no_object_has_no_surface() {
        let sphere = SphereLecture { center: [0.0, 0.0, -4.0], radius: 1.0 };
        let lists = Lists::<_, PlaneLecture> { spheres: vec![sphere], planes: Vec::new() };
        let [x, y, z] = [0.0, 0.0, -1.0].map(Lanes::lit);
        let ray = Ray::new(V3([x, y, x]), V3([x, y, z]));
        let ids = LaneBits([1, 0, 2, u32::MAX]);
        let (t, normal) = lists.surfaces::<4>(&BaselineRay { ray, origin_low: None }, &ids);
        assert_eq!(t.0, [3.0, f32::INFINITY, f32::INFINITY, f32::INFINITY]);
        assert_eq!(normal.0[2].0, [1.0, 0.0, 0.0, 0.0]);
    }
}
