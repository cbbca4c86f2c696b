//! Twin of `shaders/lecture.wgsl`.

use super::{PlaneLecture, SphereLecture};
use crate::kernel::twin::{Packet, Twin, WithTwin};
use crate::kernel::{Hit, Lists, RayOf};
use crate::vec3::{Real, Vec3, dot3, facing};

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
pub fn quadratic<R: Real>(o: Vec3<R>, d: Vec3<R>, c: Vec3<R>, r: R) -> Quadratic<R> {
    let a = dot3(d, d);
    let b = R::TWO * dot3(d, o - c);
    let k = dot3(o - c, o - c) - r * r;
    Quadratic { a, b, k, discriminant: b * b - R::FOUR * a * k }
}

/// Near and far root of an equation whose discriminant is not negative.
#[inline(always)]
pub fn quadratic_roots<R: Real>(q: Quadratic<R>) -> [R; 2] {
    let root = q.discriminant.sqrt();
    [(-q.b - root) / (R::TWO * q.a), (-q.b + root) / (R::TWO * q.a)]
}

/// Lecture, section 6. The smallest positive root, or 0 for none.
#[inline(always)]
pub fn sphere_lecture<R: Real>(o: Vec3<R>, d: Vec3<R>, c: Vec3<R>, r: R) -> R {
    let q = quadratic(o, d, c, r);
    if q.discriminant >= R::ZERO {
        let [near, far] = quadratic_roots(q);
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

/// Lecture, section 5.2: `t = ((a − o)·n) / (d·n)`. The positive `t`, or 0 for none.
#[inline(always)]
pub fn plane_lecture<R: Real>(o: Vec3<R>, d: Vec3<R>, a: Vec3<R>, n: Vec3<R>) -> R {
    let t = dot3(a - o, n) / dot3(d, n);
    if t > R::ZERO { t } else { R::ZERO }
}

/// The nearer of a hit and a sphere.
#[inline(always)]
pub fn closer_sphere(ray: &RayOf<f32>, hit: Hit<f32>, sphere: &SphereLecture, id: u32) -> Hit<f32> {
    hit.closer(sphere_lecture(ray.origin, ray.direction, Vec3(sphere.center), sphere.radius), id)
}

/// The nearer of a hit and a plane.
#[inline(always)]
pub fn closer_plane(ray: &RayOf<f32>, hit: Hit<f32>, plane: &PlaneLecture, id: u32) -> Hit<f32> {
    hit.closer(plane_lecture(ray.origin, ray.direction, Vec3(plane.point), Vec3(plane.normal)), id)
}

/// The closest hit of a ray.
#[inline(always)]
pub fn closest(ray: &RayOf<f32>, spheres: &[SphereLecture], planes: &[PlaneLecture]) -> Hit<f32> {
    let mut hit = Hit::MISS;
    for (i, sphere) in spheres.iter().enumerate() {
        hit = closer_sphere(ray, hit, sphere, i as u32 + 1);
    }
    for (i, plane) in planes.iter().enumerate() {
        hit = closer_plane(ray, hit, plane, (spheres.len() + i) as u32 + 1);
    }
    hit
}

/// The unit normal at a hit, from the hit point as the lecture has it.
#[inline(always)]
pub fn normal_at(
    ray: &RayOf<f32>,
    hit: Hit<f32>,
    spheres: &[SphereLecture],
    planes: &[PlaneLecture],
) -> Vec3<f32> {
    let p = ray.origin + ray.direction * hit.t;
    let index = hit.id as usize - 1;
    match spheres.get(index) {
        Some(sphere) => facing(p - Vec3(sphere.center), ray.direction),
        None => facing(Vec3(planes[index - spheres.len()].normal), ray.direction),
    }
}

struct Lecture<'a>(&'a Lists<SphereLecture, PlaneLecture>);

impl Twin for Lecture<'_> {
    type Float = f32;
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        closest(ray, &self.0.spheres, &self.0.planes)
    }
    #[inline(always)]
    fn closest_of(&self, rays: &mut Packet<f32>) {
        let Lists { spheres, planes } = self.0;
        for (sphere, id) in spheres.iter().zip(1..) {
            rays.closer(|ray, hit| closer_sphere(ray, hit, sphere, id));
        }
        for (plane, id) in planes.iter().zip(spheres.len() as u32 + 1..) {
            rays.closer(|ray, hit| closer_plane(ray, hit, plane, id));
        }
    }
    fn closest_from_anywhere(&self, ray: &RayOf<f32>) -> Hit<f32> {
        self.closest(ray)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32> {
        normal_at(ray, hit, &self.0.spheres, &self.0.planes)
    }
}

/// Does `work` with these objects.
pub fn with_twin<W: WithTwin>(lists: &Lists<SphereLecture, PlaneLecture>, work: W) -> W::Output {
    work.with(&Lecture(lists))
}
