//! The formulas of the kernels `stable` (f32) and `double` (f64): relative to the ray's origin, and
//! free of cancellation. Twin of `shaders/relative.wgsl`.
//!
//! The discriminant is `r² − ‖P‖²`, the roots come without cancellation, and the normal comes from
//! half the chord. How a kernel knows `l = c − o` is its own affair.

use super::about::{Part, part};
use super::arithmetic::Arithmetic;
use super::twin::{Packet, Twin, WithTwin};
use super::{Hit, Lists, RayOf};
use crate::rays::Bundle;
use crate::vec3::{Real, Vec3, dot3, facing};

/// The part of both shaders.
pub(super) const RELATIVE: Part = part!("relative.wgsl", "src/kernel/relative.rs");

/// A sphere as the kernel's arithmetic has it. With `IS_POINT` all rays start at the reference point.
pub trait RelativeSphere {
    /// The kernel's arithmetic.
    type Float: Real;
    /// `l = c − o`
    fn sphere_offset<const IS_POINT: bool>(&self, ray: &RayOf<Self::Float>) -> Vec3<Self::Float>;
    /// `r`
    fn radius(&self) -> Self::Float;
    /// `k = l·l − r²`
    fn sphere_k<const IS_POINT: bool>(&self, l: Vec3<Self::Float>) -> Self::Float;
}

/// A plane as the kernel's arithmetic has it. With `IS_POINT` all rays start at the reference point.
pub trait RelativePlane {
    /// The kernel's arithmetic.
    type Float: Real;
    /// `(a − o)·n`
    fn plane_n_offset<const IS_POINT: bool>(&self, ray: &RayOf<Self::Float>) -> Self::Float;
    /// `n`
    fn normal(&self) -> Vec3<Self::Float>;
}

/// The ray's closest approach to a centre at `l = c − o`, and half the chord.
#[derive(Clone, Copy, Debug)]
pub struct Approach<R> {
    /// Offset from the closest point of the line to the centre.
    pub p: Vec3<R>,
    /// `d·l`
    pub b: R,
    /// `r² − p·p`
    pub delta: R,
    /// `√(a·(r² − p·p))`; negative for a miss.
    pub h: R,
}

/// Discriminant as `r² − ‖P‖²` (Hearn & Baker; Ray Tracing Gems, ch. 7, eq. 5).
#[inline(always)]
pub fn approach<R: Real>(ray: &RayOf<R>, l: Vec3<R>, r: R) -> Approach<R> {
    let b = dot3(ray.direction, l);
    let p = l - ray.direction * (b * ray.inv_a);
    let delta = r * r - dot3(p, p);
    let h = if delta >= R::ZERO { (ray.a * delta).sqrt() } else { -R::ONE };
    Approach { p, b, delta, h }
}

/// Near and far root without cancellation: `q` and `k/q` (Press et al., Numerical Recipes, 5.6),
/// with `k = l·l − r²` and `h ≥ 0`.
#[inline(always)]
pub fn roots_stable<R: Real>(ray: &RayOf<R>, b: R, h: R, k: R) -> [R; 2] {
    if b > R::ZERO {
        let q = b + h;
        [k / q, q * ray.inv_a]
    } else {
        let q = b - h;
        [q * ray.inv_a, k / q]
    }
}

/// The smallest positive root, or 0 for none.
#[inline(always)]
pub fn sphere_stable<R: Real>(ray: &RayOf<R>, l: Vec3<R>, r: R, k: R) -> R {
    let Approach { b, h, .. } = approach(ray, l, r);
    if h >= R::ZERO {
        let [near, far] = roots_stable(ray, b, h, k);
        if near > R::ZERO {
            near
        } else if far > R::ZERO {
            far
        } else {
            R::ZERO
        }
    } else {
        R::ZERO
    }
}

/// `t = ((a − o)·n) / (d·n)`. The positive `t`, or 0 for none.
#[inline(always)]
pub fn plane_stable<R: Real>(d: Vec3<R>, n_offset: R, n: Vec3<R>) -> R {
    let t = n_offset / dot3(d, n);
    if t > R::ZERO { t } else { R::ZERO }
}

/// The nearer of a hit and a sphere.
#[inline(always)]
pub fn closer_sphere<const IS_POINT: bool, S: RelativeSphere>(
    ray: &RayOf<S::Float>,
    hit: Hit<S::Float>,
    sphere: &S,
    id: u32,
) -> Hit<S::Float> {
    let l = sphere.sphere_offset::<IS_POINT>(ray);
    hit.closer(sphere_stable(ray, l, sphere.radius(), sphere.sphere_k::<IS_POINT>(l)), id)
}

/// The nearer of a hit and a plane.
#[inline(always)]
pub fn closer_plane<const IS_POINT: bool, P: RelativePlane>(
    ray: &RayOf<P::Float>,
    hit: Hit<P::Float>,
    plane: &P,
    id: u32,
) -> Hit<P::Float> {
    let n_offset = plane.plane_n_offset::<IS_POINT>(ray);
    hit.closer(plane_stable(ray.direction, n_offset, plane.normal()), id)
}

/// The closest hit of a ray. With `IS_POINT` all rays start at the reference point.
#[inline(always)]
pub fn closest<const IS_POINT: bool, S, P>(
    ray: &RayOf<S::Float>,
    spheres: &[S],
    planes: &[P],
) -> Hit<S::Float>
where
    S: RelativeSphere,
    P: RelativePlane<Float = S::Float>,
{
    let mut hit = Hit::MISS;
    for (i, sphere) in spheres.iter().enumerate() {
        hit = closer_sphere::<IS_POINT, S>(ray, hit, sphere, i as u32 + 1);
    }
    for (i, plane) in planes.iter().enumerate() {
        hit = closer_plane::<IS_POINT, P>(ray, hit, plane, (spheres.len() + i) as u32 + 1);
    }
    hit
}

/// The unit normal at a hit, from half the chord: `o + t·d − c` cancels far away.
#[inline(always)]
pub fn normal_at<const IS_POINT: bool, S, P>(
    ray: &RayOf<S::Float>,
    hit: Hit<S::Float>,
    spheres: &[S],
    planes: &[P],
) -> Vec3<S::Float>
where
    S: RelativeSphere,
    P: RelativePlane<Float = S::Float>,
{
    let index = hit.id as usize - 1;
    match spheres.get(index) {
        Some(sphere) => {
            let l = sphere.sphere_offset::<IS_POINT>(ray);
            let closest_approach = approach(ray, l, sphere.radius());
            let half_chord = ray.direction * (closest_approach.h * ray.inv_a);
            let outside = sphere.sphere_k::<IS_POINT>(l) > S::Float::ZERO;
            let from_foot = if outside { -half_chord } else { half_chord };
            facing(from_foot - closest_approach.p, ray.direction)
        }
        None => facing(planes[index - spheres.len()].normal(), ray.direction),
    }
}

struct Relative<'a, S, P, const IS_POINT: bool>(&'a Lists<S, P>);

impl<S, P, const IS_POINT: bool> Twin for Relative<'_, S, P, IS_POINT>
where
    S: RelativeSphere<Float: Arithmetic> + Sync,
    P: RelativePlane<Float = S::Float> + Sync,
{
    type Float = S::Float;
    #[inline(always)]
    fn closest(&self, ray: &RayOf<S::Float>) -> Hit<S::Float> {
        closest::<IS_POINT, S, P>(ray, &self.0.spheres, &self.0.planes)
    }
    #[inline(always)]
    fn closest_of(&self, rays: &mut Packet<S::Float>) {
        let Lists { spheres, planes } = self.0;
        for (sphere, id) in spheres.iter().zip(1..) {
            rays.closer(|ray, hit| closer_sphere::<IS_POINT, S>(ray, hit, sphere, id));
        }
        for (plane, id) in planes.iter().zip(spheres.len() as u32 + 1..) {
            rays.closer(|ray, hit| closer_plane::<IS_POINT, P>(ray, hit, plane, id));
        }
    }
    fn closest_from_anywhere(&self, ray: &RayOf<S::Float>) -> Hit<S::Float> {
        closest::<false, S, P>(ray, &self.0.spheres, &self.0.planes)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<S::Float>, hit: Hit<S::Float>) -> Vec3<S::Float> {
        normal_at::<IS_POINT, S, P>(ray, hit, &self.0.spheres, &self.0.planes)
    }
}

/// Does `work` with these objects.
pub(super) fn with_twin<S, P, W: WithTwin>(
    lists: &Lists<S, P>,
    bundle: Bundle,
    work: W,
) -> W::Output
where
    S: RelativeSphere<Float: Arithmetic> + Sync,
    P: RelativePlane<Float = S::Float> + Sync,
{
    match bundle {
        Bundle::Point => work.with(&Relative::<S, P, true>(lists)),
        Bundle::Parallel | Bundle::Free => work.with(&Relative::<S, P, false>(lists)),
    }
}
