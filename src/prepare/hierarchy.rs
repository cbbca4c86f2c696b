//! Which spheres of a scene go into a hierarchy, and their numbers there.

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;

use super::Frame;
use crate::bvh;
use crate::bvh::boxes::Boxes;
use crate::bvh::footprint::{Footprint, Projection};
use crate::bvh::footprints::Footprints;
use crate::camera::Pixels;
use crate::error::{Error, Result};
use crate::kernel::certified::{SphereCertified, SphereFar};
use crate::scene::{Scene, Sphere};
use crate::trace::Rays;

/// Spheres that are found through a hierarchy.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The spheres that have a place in it.
    pub search: Search,
    /// The others, with their ids: those close to the eye or out of range.
    pub rest: Vec<(u32, SphereCertified)>,
    /// Time that it took to build.
    pub build_time: Duration,
}

/// How a hierarchy is searched.
#[derive(Clone, Debug)]
pub enum Search {
    /// By pixel, for the spheres that the picture may show, all of them far from the eye.
    Pixels {
        /// The hierarchy.
        footprints: Footprints,
        /// The numbers of the sphere at each place of [`Footprints::order`].
        far: Vec<SphereFar>,
    },
    /// By rays relative to [`super::Prepared::reference`].
    Rays {
        /// The hierarchy.
        boxes: Boxes,
        /// Object id of each place of [`Boxes::order`].
        ids: Vec<u32>,
    },
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
        let (search, outside) = match rays {
            Rays::Pixels(pixels) => by_pixels(frame, pixels, spheres),
            Rays::List(_) => by_rays(frame, spheres),
        };
        let rest = outside.iter().map(|&i| (i + 1, frame.sphere(&spheres[i as usize]))).collect();
        Ok(Hierarchy { search, rest, build_time: start.elapsed() })
    }
}

/// Indices of the spheres that can be hit: a radius of 0 can't.
fn indices(spheres: &[Sphere]) -> impl ParallelIterator<Item = u32> {
    (0..spheres.len() as u32).into_par_iter().filter(|&i| spheres[i as usize].radius != 0.0)
}

fn by_pixels(frame: &Frame, pixels: &Pixels, spheres: &[Sphere]) -> (Search, Vec<u32>) {
    let longest = pixels.longest_direction();
    let (inside, outside): (Vec<u32>, Vec<u32>) =
        indices(spheres).partition(|&i| frame.is_far(&spheres[i as usize], longest));
    let projection = Projection::new(pixels);
    let footprint = |&i: &u32| {
        let sphere = &spheres[i as usize];
        let l = sphere.center - frame.reference;
        projection.footprint(l, sphere.radius.abs()).map(|footprint| (i, footprint))
    };
    let (seen, seen_as): (Vec<u32>, Vec<Footprint>) =
        inside.par_iter().filter_map(footprint).unzip();
    drop(inside);
    let footprints = Footprints::new(&projection, &seen_as);
    drop(seen_as);
    let sphere = |&at: &u32| {
        let i = seen[at as usize];
        frame.far_sphere(&spheres[i as usize], i + 1)
    };
    let far = footprints.order.par_iter().map(sphere).collect();
    (Search::Pixels { footprints, far }, outside)
}

fn by_rays(frame: &Frame, spheres: &[Sphere]) -> (Search, Vec<u32>) {
    let (inside, outside): (Vec<u32>, Vec<u32>) =
        indices(spheres).partition(|&i| frame.has_box(&spheres[i as usize]));
    let offset = |&i: &u32| {
        let sphere = &spheres[i as usize];
        (sphere.center - frame.reference, sphere.radius.abs())
    };
    let offsets: Vec<(DVec3, f64)> = inside.par_iter().map(offset).collect();
    let boxes = Boxes::new(&offsets);
    let ids = boxes.order.par_iter().map(|&at| inside[at as usize] + 1).collect();
    (Search::Rays { boxes, ids }, outside)
}
