//! Which spheres of a scene go into a hierarchy, and their numbers there.

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;

use super::Frame;
use crate::bvh::{self, Bvh};
use crate::error::{Error, Result};
use crate::kernel::certified::{SphereCertified, SphereFar};
use crate::scene::{Scene, Sphere};
use crate::trace::Rays;

/// Spheres that are found through a hierarchy.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The boxes, relative to [`super::Prepared::reference`].
    pub bvh: Bvh,
    /// Object id of each place of [`Bvh::order`].
    pub ids: Vec<u32>,
    /// For pixels: the numbers of each place, all of them spheres far from the eye.
    pub far: Vec<SphereFar>,
    /// The spheres outside the hierarchy, with their ids: those close to the eye or out of range.
    pub rest: Vec<(u32, SphereCertified)>,
    /// Time that it took to build.
    pub build_time: Duration,
}

impl Hierarchy {
    /// Puts those spheres of a scene into a hierarchy that suit one.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more spheres than a hierarchy holds.
    pub(super) fn new(frame: &Frame, rays: &Rays, scene: &Scene) -> Result<Hierarchy> {
        let start = Instant::now();
        let spheres = &scene.spheres;
        if spheres.len() > bvh::MOST_SPHERES {
            return Err(Error::TooLarge(format!(
                "{} spheres; a hierarchy holds at most {}: split the scene",
                spheres.len(),
                bvh::MOST_SPHERES
            )));
        }
        let longest = match rays {
            Rays::Pixels(pixels) => Some(pixels.longest_direction()),
            Rays::List(_) => None,
        };
        let suits = |sphere: &Sphere| match longest {
            Some(longest) => frame.is_far(sphere, longest),
            None => frame.has_box(sphere),
        };
        // A radius of 0 can't be hit.
        let ids = (0..spheres.len() as u32).into_par_iter();
        let (inside, outside): (Vec<u32>, Vec<u32>) = ids
            .filter(|&i| spheres[i as usize].radius != 0.0)
            .partition(|&i| suits(&spheres[i as usize]));
        let boxed: Vec<(DVec3, f64)> = inside
            .par_iter()
            .map(|&i| {
                let sphere = &spheres[i as usize];
                (sphere.center - frame.reference, sphere.radius.abs())
            })
            .collect();
        let bvh = Bvh::new(&boxed);
        drop(boxed);
        let ids: Vec<u32> = bvh.order.par_iter().map(|&i| inside[i as usize] + 1).collect();
        let sphere = |&id: &u32| frame.far_sphere(&spheres[id as usize - 1], id);
        let far = match longest {
            Some(_) => ids.par_iter().map(sphere).collect(),
            None => Vec::new(),
        };
        let rest = outside.iter().map(|&i| (i + 1, frame.sphere(&spheres[i as usize]))).collect();
        Ok(Hierarchy { bvh, ids, far, rest, build_time: start.elapsed() })
    }
}
