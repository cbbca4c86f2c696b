//! Rays of a list, as the certified kernel's f32 takes them.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use glam::DVec3;

use crate::num;
use crate::num::{Lanes, Real, ScaledInteger, V3, length_bound};

/// Rays of a list, relative to a point that all numbers are relative to.
#[derive(Clone, Copy)]
pub struct List<'a> {
    /// As they are.
    pub rays: &'a [super::WorldRay],
    origins: Origins,
}

/// The region of the origins of a list's rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origins {
    /// The point that all numbers are relative to.
    pub reference: DVec3,
    /// Largest distance from there of an origin whose ray f32 may decide. The few rays from farther away would increase the errors of
    /// all rays.
    pub spread: f64,
}

impl Origins {
    /// Returns whether f32 leaves a ray with this origin undecided.
    #[inline(always)]
    pub fn is_far(&self, origin: DVec3) -> bool {
        let distance = length_bound(origin - self.reference);
        // NaN is far.
        !(distance <= self.spread)
    }
}

impl<'a> List<'a> {
    /// These rays.
    pub fn new(rays: &'a [super::WorldRay], origins: Origins) -> List<'a> {
        List { rays, origins }
    }

    /// Origin, and direction with a largest component in `1..2`. A ray that f32 leaves undecided, because it has no direction or starts
    /// far away, is replaced by another one.
    #[inline(always)]
    pub fn ray(&self, index: usize) -> (DVec3, DVec3) {
        let super::WorldRay { origin, direction } = self.rays[index.min(self.rays.len() - 1)];
        if direction == DVec3::ZERO || self.origins.is_far(origin) {
            return (DVec3::ZERO, DVec3::X);
        }
        (origin - self.origins.reference, ScaledInteger::new(direction).rounded())
    }

    /// Some of them side by side; the last one stands for lanes that don't count.
    #[inline(always)]
    pub fn load<const N: usize>(&self, first: usize) -> num::Ray<Lanes<f32, N>> {
        let (mut origin, mut direction) = (V3([Lanes::lit(0.0); 3]), V3([Lanes::lit(0.0); 3]));
        for lane in 0..N {
            let (from, way) = self.ray(first + lane);
            for axis in 0..3 {
                origin.0[axis].0[lane] = from[axis] as f32;
                direction.0[axis].0[lane] = way[axis] as f32;
            }
        }
        num::Ray::new(origin, direction)
    }
}
