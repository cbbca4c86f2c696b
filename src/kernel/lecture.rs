//! The lecture's formulas, corrected, on world coordinates. Twin of `shaders/lecture.wgsl`.
//!
//! This is what everyone copies, kept for teaching and measuring: `b² − 4ac` cancels near the
//! silhouette, `−b ± √D` near the surface, and world coordinates lose what lies far from the
//! origin.

use bytemuck::{Pod, Zeroable};

use super::baseline::{Baseline, BaselineRay, first_positive};
use super::info::{FloatType, KernelInfo, Promise, Space, part};
use crate::num::{Mask, Real, V3};
use crate::scene::{Plane, Sphere};

/// The facts of the kernel.
pub(super) const INFO: KernelInfo = KernelInfo {
    name: "lecture",
    float: FloatType::F32,
    space: Space::World,
    promise: Promise::PARITY,
    record_bytes: [size_of::<SphereLecture>(), size_of::<PlaneLecture>()],
    record_names: "Lecture",
    shader_parts: &[part!("ray.wgsl"), part!("lecture.wgsl")],
};

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereLecture {
    /// Centre, world units.
    pub center: [f32; 3],
    /// Radius, world units.
    pub radius: f32,
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneLecture {
    /// A point of the plane, world units.
    pub point: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Normal of any length.
    pub normal: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
}

impl SphereLecture {
    /// A sphere of a scene, rounded.
    pub fn new(sphere: &Sphere) -> SphereLecture {
        SphereLecture { center: sphere.center.as_vec3().to_array(), radius: sphere.radius as f32 }
    }
}

impl PlaneLecture {
    /// A plane of a scene, rounded.
    pub fn new(plane: &Plane) -> PlaneLecture {
        PlaneLecture {
            point: plane.point.as_vec3().to_array(),
            pad0: 0.0,
            normal: plane.normal.as_vec3().to_array(),
            pad1: 0.0,
        }
    }
}

/// The numbers of the quadratic equation `a·t² + b·t + k = 0`.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic<R> {
    /// `d·d`
    pub a: R,
    /// `2·d·(o − c)`
    pub b: R,
    /// `(o − c)·(o − c) − r²`
    pub k: R,
    /// `b² − 4ak`
    pub discriminant: R,
}

/// Lecture, section 6: the sphere's equation with the ray put in.
#[inline(always)]
pub fn quadratic<R: Real>(o: V3<R>, d: V3<R>, c: V3<R>, r: R) -> Quadratic<R> {
    let a = d.dot(d);
    let b = R::lit(2.0) * d.dot(o - c);
    let k = (o - c).dot(o - c) - r * r;
    Quadratic { a, b, k, discriminant: b * b - R::lit(4.0) * a * k }
}

/// Near and far root; they mean something where the discriminant is not negative.
#[inline(always)]
pub fn quadratic_roots<R: Real>(q: Quadratic<R>) -> [R; 2] {
    let (root, two_a) = (q.discriminant.sqrt(), R::lit(2.0) * q.a);
    [(-q.b - root) / two_a, (-q.b + root) / two_a]
}

/// Lecture, section 6. The smallest positive root, or 0 for none.
#[inline(always)]
pub fn sphere_lecture<R: Real>(o: V3<R>, d: V3<R>, c: V3<R>, r: R) -> R {
    let (q, zero) = (quadratic(o, d, c, r), R::lit(0.0));
    let is_hit = zero.le(q.discriminant);
    if !is_hit.any() {
        return zero;
    }
    R::select(is_hit, first_positive(quadratic_roots(q)), zero)
}

/// Lecture, section 5.2: `(a − o)·n` and `d·n`, whose quotient is `t`.
#[inline(always)]
pub fn plane_quotient<R: Real>(o: V3<R>, d: V3<R>, a: V3<R>, n: V3<R>) -> [R; 2] {
    [(a - o).dot(n), d.dot(n)]
}

/// The positive `t` of a plane, or 0 for none.
#[inline(always)]
pub fn plane_lecture<R: Real>(o: V3<R>, d: V3<R>, a: V3<R>, n: V3<R>) -> R {
    let ([numerator, denominator], zero) = (plane_quotient(o, d, a, n), R::lit(0.0));
    let t = numerator / denominator;
    R::select(zero.lt(t), t, zero)
}

impl Baseline for SphereLecture {
    type Float = f32;

    #[inline(always)]
    fn t<R: Real<One = f32>>(&self, BaselineRay { ray, .. }: &BaselineRay<R>) -> R {
        let (center, radius) = (V3::splat(V3(self.center)), R::splat(self.radius));
        sphere_lecture(ray.origin, ray.direction, center, radius)
    }

    /// From the hit point, as the lecture has it.
    #[inline(always)]
    fn normal<R: Real<One = f32>>(&self, BaselineRay { ray, .. }: &BaselineRay<R>, t: R) -> V3<R> {
        (ray.origin + ray.direction * t) - V3::splat(V3(self.center))
    }
}

impl Baseline for PlaneLecture {
    type Float = f32;

    #[inline(always)]
    fn t<R: Real<One = f32>>(&self, BaselineRay { ray, .. }: &BaselineRay<R>) -> R {
        let (point, normal) = (V3::splat(V3(self.point)), V3::splat(V3(self.normal)));
        plane_lecture(ray.origin, ray.direction, point, normal)
    }

    #[inline(always)]
    fn normal<R: Real<One = f32>>(&self, _: &BaselineRay<R>, _: R) -> V3<R> {
        V3::splat(V3(self.normal))
    }
}
