//! The best plain-f32 kernel, camera-relative. Twin of `shaders/stable.wgsl`.
//!
//! Offsets from the ray's origin are formed in f64 on the host (or from high and low parts for
//! lists of rays), the discriminant is `r² − ‖P‖²`, the roots come without cancellation, and the
//! normal comes from half the chord. Still plain f32: nothing is promised near a silhouette.

use bytemuck::{Pod, Zeroable};

use super::{Hit, RayOf};
use crate::vec3::{Real, Vec3, dot3, facing};

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereStable {
    /// Centre relative to the reference point, high part.
    pub center: [f32; 3],
    /// Radius.
    pub radius: f32,
    /// Centre relative to the reference point, low part.
    pub center_low: [f32; 3],
    /// `l·l − r²` for the reference point, rounded from f64.
    pub k: f32,
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneStable {
    /// Point of the plane relative to the reference point, high part.
    pub offset: [f32; 3],
    /// `(a − o)·n` for the reference point, rounded from f64.
    pub n_offset: f32,
    /// Point of the plane relative to the reference point, low part.
    pub offset_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Normal, scaled by a power of two to a largest component in `1..2`.
    pub normal: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
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

/// `l = c − o` for a ray: the stored offset where all rays start at the reference point.
#[inline(always)]
pub fn offset<const PIXELS: bool>(ray: &RayOf<f32>, high: [f32; 3], low: [f32; 3]) -> Vec3<f32> {
    if PIXELS { Vec3(high) } else { (Vec3(high) - ray.origin) + (Vec3(low) - ray.origin_low) }
}

/// `l·l − r²`, from the host's f64 where all rays share their origin.
#[inline(always)]
pub fn sphere_k<const PIXELS: bool>(l: Vec3<f32>, sphere: &SphereStable) -> f32 {
    if PIXELS { sphere.k } else { dot3(l, l) - sphere.radius * sphere.radius }
}

/// `(a − o)·n`, from the host's f64 where all rays share their origin.
#[inline(always)]
pub fn plane_n_offset<const PIXELS: bool>(ray: &RayOf<f32>, plane: &PlaneStable) -> f32 {
    if PIXELS {
        plane.n_offset
    } else {
        dot3(offset::<PIXELS>(ray, plane.offset, plane.offset_low), Vec3(plane.normal))
    }
}

/// The closest hit of a ray. With `PIXELS` all rays start at the reference point.
#[inline(always)]
pub fn closest<const PIXELS: bool>(
    ray: &RayOf<f32>,
    spheres: &[SphereStable],
    planes: &[PlaneStable],
) -> Hit<f32> {
    let mut hit = Hit::MISS;
    for (i, sphere) in spheres.iter().enumerate() {
        let l = offset::<PIXELS>(ray, sphere.center, sphere.center_low);
        let t = sphere_stable(ray, l, sphere.radius, sphere_k::<PIXELS>(l, sphere));
        hit = hit.closer(t, i as u32 + 1);
    }
    for (i, plane) in planes.iter().enumerate() {
        let n_offset = plane_n_offset::<PIXELS>(ray, plane);
        let t = plane_stable(ray.direction, n_offset, Vec3(plane.normal));
        hit = hit.closer(t, (spheres.len() + i) as u32 + 1);
    }
    hit
}

/// The unit normal at a hit, from half the chord: `o + t·d − c` cancels far away.
#[inline(always)]
pub fn normal_at<const PIXELS: bool>(
    ray: &RayOf<f32>,
    hit: Hit<f32>,
    spheres: &[SphereStable],
    planes: &[PlaneStable],
) -> Vec3<f32> {
    let index = hit.id as usize - 1;
    match spheres.get(index) {
        Some(sphere) => {
            let l = offset::<PIXELS>(ray, sphere.center, sphere.center_low);
            let closest_approach = approach(ray, l, sphere.radius);
            let half_chord = ray.direction * (closest_approach.h * ray.inv_a);
            let outside = sphere_k::<PIXELS>(l, sphere) > 0.0;
            let from_foot = if outside { -half_chord } else { half_chord };
            facing(from_foot - closest_approach.p, ray.direction)
        }
        None => facing(Vec3(planes[index - spheres.len()].normal), ray.direction),
    }
}
