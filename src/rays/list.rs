//! Rays of a list, as the certified kernel's f32 takes them.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use glam::DVec3;

use crate::num;
use crate::num::{Lanes, Real, Scaled, V3};

/// Rays of a list, relative to a point that all numbers are relative to.
#[derive(Clone, Copy)]
pub struct List<'a> {
    /// As they are.
    pub rays: &'a [super::WorldRay],
    reference: DVec3,
}

impl<'a> List<'a> {
    /// These rays.
    pub fn new(rays: &'a [super::WorldRay], reference: DVec3) -> List<'a> {
        List { rays, reference }
    }

    /// Origin, and direction with a largest component in `1..2`. A ray without a direction gets one: it is decided elsewhere.
    #[inline(always)]
    pub fn ray(&self, index: usize) -> (DVec3, DVec3) {
        let super::WorldRay { origin, direction } = self.rays[index.min(self.rays.len() - 1)];
        let direction = if direction == DVec3::ZERO { DVec3::X } else { direction };
        (origin - self.reference, Scaled::new(direction).rounded())
    }

    /// One of them.
    #[inline(always)]
    pub fn one(&self, index: usize) -> num::Ray<f32> {
        let (from, way) = self.ray(index);
        num::Ray::new(V3::lit(from), V3::lit(way))
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
