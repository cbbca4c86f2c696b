//! A kernel on the CPU.

use super::arithmetic::Arithmetic;
use super::{Hit, RayOf};
use crate::vec3::{Real, Vec3};

/// Rays that go side by side, and what they hit.
pub const PACKET: usize = 16;

/// Rays side by side: each number of all of them in a row, so that a step for one after the other is one for
/// registers of them.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Packet<R> {
    origin: [[R; PACKET]; 3],
    origin_low: [[R; PACKET]; 3],
    direction: [[R; PACKET]; 3],
    a: [R; PACKET],
    inv_a: [R; PACKET],
    /// Of the nearest hits so far.
    t: [R; PACKET],
    id: [u32; PACKET],
}

impl<R: Real> Packet<R> {
    /// Rays that have hit nothing yet.
    #[inline(always)]
    pub fn new(ray: impl Fn(usize) -> RayOf<R>) -> Packet<R> {
        let (zero, numbers) = ([R::ZERO; PACKET], [[R::ZERO; PACKET]; 3]);
        let (origin, origin_low, direction) = (numbers, numbers, numbers);
        let (t, id) = ([R::INFINITY; PACKET], [0; PACKET]);
        let mut all = Packet { origin, origin_low, direction, a: zero, inv_a: zero, t, id };
        for lane in 0..PACKET {
            let ray = ray(lane);
            for axis in 0..3 {
                all.origin[axis][lane] = ray.origin.0[axis];
                all.origin_low[axis][lane] = ray.origin_low.0[axis];
                all.direction[axis][lane] = ray.direction.0[axis];
            }
            (all.a[lane], all.inv_a[lane]) = (ray.a, ray.inv_a);
        }
        all
    }

    /// One of the rays.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> RayOf<R> {
        let vector = |v: &[[R; PACKET]; 3]| Vec3([v[0][lane], v[1][lane], v[2][lane]]);
        RayOf {
            origin: vector(&self.origin),
            origin_low: vector(&self.origin_low),
            direction: vector(&self.direction),
            a: self.a[lane],
            inv_a: self.inv_a[lane],
        }
    }

    /// What one of the rays hits.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Hit<R> {
        Hit { t: self.t[lane], id: self.id[lane] }
    }

    /// Takes one more object into account.
    #[inline(always)]
    pub fn closer(&mut self, closer: impl Fn(&RayOf<R>, Hit<R>) -> Hit<R>) {
        for lane in 0..PACKET {
            let hit = closer(&self.ray(lane), self.hit(lane));
            (self.t[lane], self.id[lane]) = (hit.t, hit.id);
        }
    }
}

/// A kernel with its objects, for one bundle of rays.
pub trait Twin: Sync {
    /// Its arithmetic.
    type Float: Arithmetic;
    /// The object of a ray.
    fn closest(&self, ray: &RayOf<Self::Float>) -> Hit<Self::Float>;
    /// The same of rays side by side.
    #[inline(always)]
    fn closest_of(&self, rays: &mut Packet<Self::Float>) {
        rays.closer(|ray, _| self.closest(ray));
    }
    /// The same of a ray that starts anywhere, as shadow rays do.
    fn closest_from_anywhere(&self, ray: &RayOf<Self::Float>) -> Hit<Self::Float>;
    /// The normal at a hit.
    fn normal_at(&self, ray: &RayOf<Self::Float>, hit: Hit<Self::Float>) -> Vec3<Self::Float>;
}

/// Work for any kernel, compiled once for each.
pub trait WithTwin {
    /// Its result.
    type Output;
    /// Does it.
    fn with<T: Twin>(self, twin: &T) -> Self::Output;
}
