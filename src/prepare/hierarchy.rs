//! Which spheres of a scene go into a hierarchy, and their numbers there.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;

use super::Frame;
use crate::bvh;
use crate::bvh::boxes::Boxes;
use crate::bvh::footprint::{Footprint, Projection};
use crate::bvh::footprints::Footprints;
use crate::camera::Pixels;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::kernel::certified::SphereFar;
use crate::memory::Available;
use crate::random::SplitMix;
use crate::scene::{Scene, Sphere};
use crate::trace::Rays;

/// Many spheres: those that are found through a hierarchy, and the rest. Left out are those that can't
/// be hit, and of a picture those that no pixel sees.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The spheres that have a place in it.
    pub search: Search,
    /// Ids of those that each ray looks at: out of range, or for a picture too close to the eye. In a
    /// very wide view, above some 160 degrees, all are too close; of an orthographic camera, those
    /// whose surface comes close to its position.
    pub rest: Vec<u32>,
    /// Time that it took to build.
    pub build_time: Duration,
}

/// How a hierarchy is searched.
#[derive(Clone, Debug)]
pub enum Search {
    /// By pixel, for the spheres that the picture may show; all of them far from a perspective
    /// camera's eye.
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
    /// [`Error::TooLarge`] for more spheres than a hierarchy holds or than there is memory to build
    /// one over; [`Error::Interrupted`].
    pub(super) fn new(
        frame: &Frame,
        rays: &Rays,
        scene: &Scene,
        control: &Control,
    ) -> Result<Hierarchy> {
        let start = Instant::now();
        let spheres = &scene.spheres;
        check_size(spheres.len(), Available::now())?;
        let (search, outside) = match rays {
            Rays::Pixels(pixels) => by_pixels(frame, pixels, spheres, control)?,
            Rays::List(_) => by_rays(frame, spheres, control)?,
        };
        let rest = outside.iter().map(|&i| i + 1).collect();
        Ok(Hierarchy { search, rest, build_time: start.elapsed() })
    }

    /// Whether it is searched by pixel.
    pub fn is_by_pixel(&self) -> bool {
        matches!(self.search, Search::Pixels { .. })
    }

    /// Bytes of the nodes and of the spheres' numbers in them.
    pub fn bytes(&self) -> u64 {
        let bytes = match &self.search {
            Search::Pixels { footprints, far } => {
                size_of_val(&footprints.nodes[..]) + size_of_val(&far[..])
            }
            Search::Rays { boxes, ids } => boxes.bytes() + size_of_val(&ids[..]),
        };
        bytes as u64
    }
}

/// Most bytes a sphere while a hierarchy is built: 20 for its index and footprint, 32 for its box; in
/// the builder 32 for its place along a curve, two nodes of 48 that are being joined, two that stay,
/// and 4 for its place. Measured: 280.
const BUILD_BYTES: u64 = 20 + 32 + 32 + 2 * 48 + 2 * 48 + 4;

fn check_size(n_spheres: usize, available: Available) -> Result<()> {
    if n_spheres > bvh::MOST_SPHERES {
        return Err(Error::TooLarge(format!(
            "{n_spheres} spheres; a hierarchy holds at most {}: split the scene",
            bvh::MOST_SPHERES
        )));
    }
    let needed = n_spheres as u64 * BUILD_BYTES;
    let most = available.bytes / BUILD_BYTES;
    let advice = format!("that is enough for {most} spheres; free some, or split the scene");
    available.require(format!("building the hierarchy over {n_spheres} spheres"), needed, &advice)
}

/// Indices of the spheres that can be seen: not those with a radius of 0, nor those that equal an
/// earlier one, against which they never win.
fn indices(spheres: &[Sphere]) -> impl ParallelIterator<Item = u32> {
    let repeats = repeats(spheres);
    (0..spheres.len() as u32).into_par_iter().filter(move |i| {
        spheres[*i as usize].radius != 0.0
            && (repeats.is_empty() || repeats.binary_search(i).is_err())
    })
}

/// Indices of the spheres that equal an earlier one, ascending. They need not be all: it saves work.
fn repeats(spheres: &[Sphere]) -> Vec<u32> {
    let key = |i: u32| {
        let Sphere { center, radius, .. } = &spheres[i as usize];
        [center.x, center.y, center.z, *radius].map(f64::to_bits)
    };
    let hash = |i: u32| {
        let mix = |mixed: u64, word: &u64| {
            (mixed.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        };
        SplitMix::new(key(i).iter().fold(0, mix)).next()
    };
    // Only what shares its place in a table with others can equal one of them.
    let n_bits = (16 * spheres.len()).next_power_of_two().max(64);
    let table = || (0..n_bits / 64).map(|_| AtomicU64::new(0)).collect::<Vec<_>>();
    let (taken, shared) = (table(), table());
    let place = |hash: u64| {
        let bit = hash as usize & (n_bits - 1);
        (bit / 64, 1 << (bit % 64))
    };
    let all = || (0..spheres.len() as u32).into_par_iter();
    all().for_each(|i| {
        let (word, bit) = place(hash(i));
        if taken[word].fetch_or(bit, Ordering::Relaxed) & bit != 0 {
            shared[word].fetch_or(bit, Ordering::Relaxed);
        }
    });
    let shares = |i: u32| {
        let hash = hash(i);
        let (word, bit) = place(hash);
        (shared[word].load(Ordering::Relaxed) & bit != 0).then_some((hash, i))
    };
    let mut sharing: Vec<(u64, u32)> = all().filter_map(shares).collect();
    sharing.par_sort_unstable();
    // Where different spheres have one hash, which hardly ever is, a repeat may stay.
    let repeat = |two: &[(u64, u32)]| (key(two[0].1) == key(two[1].1)).then_some(two[1].1);
    let mut repeats: Vec<u32> = sharing.windows(2).filter_map(repeat).collect();
    repeats.par_sort_unstable();
    repeats
}

fn by_pixels(
    frame: &Frame,
    pixels: &Pixels,
    spheres: &[Sphere],
    control: &Control,
) -> Result<(Search, Vec<u32>)> {
    let longest = pixels.longest_direction();
    let (inside, outside): (Vec<u32>, Vec<u32>) =
        indices(spheres).partition(|&i| frame.suits_leaf(&spheres[i as usize], longest));
    control.check()?;
    let projection = Projection::new(pixels);
    let footprint = |&i: &u32| {
        let sphere = &spheres[i as usize];
        let l = sphere.center - frame.reference;
        projection.footprint(l, sphere.radius.abs()).map(|footprint| (i, footprint))
    };
    let (seen, seen_as): (Vec<u32>, Vec<Footprint>) =
        inside.par_iter().filter_map(footprint).unzip();
    drop(inside);
    let footprints = Footprints::new(&projection, &seen_as, control)?;
    drop(seen_as);
    let sphere = |&at: &u32| {
        let i = seen[at as usize];
        frame.far_sphere(&spheres[i as usize], i + 1)
    };
    let far = footprints.order.par_iter().map(sphere).collect();
    Ok((Search::Pixels { footprints, far }, outside))
}

fn by_rays(frame: &Frame, spheres: &[Sphere], control: &Control) -> Result<(Search, Vec<u32>)> {
    let (inside, outside): (Vec<u32>, Vec<u32>) =
        indices(spheres).partition(|&i| frame.has_box(&spheres[i as usize]));
    let offset = |&i: &u32| {
        let sphere = &spheres[i as usize];
        (sphere.center - frame.reference, sphere.radius.abs())
    };
    let offsets: Vec<(DVec3, f64)> = inside.par_iter().map(offset).collect();
    let boxes = Boxes::new(&offsets, control)?;
    let ids = boxes.order.par_iter().map(|&at| inside[at as usize] + 1).collect();
    Ok((Search::Rays { boxes, ids }, outside))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::Limit;

    /// Against a plain search, over spheres of few values, so that some are equal.
    #[test]
    fn repeats_are_all_but_the_first_of_equal_spheres() {
        let mut random = SplitMix::new(1110);
        for n in [0, 1, 2, 3, 40, 3000] {
            let mut number = || (random.next() % 6) as f64;
            let spheres: Vec<Sphere> = (0..n)
                .map(|_| Sphere {
                    center: DVec3::new(number(), number(), number()),
                    radius: number(),
                })
                .collect();
            let same = |a: &Sphere, b: &Sphere| (a.center, a.radius) == (b.center, b.radius);
            let is_repeat = |i: &usize| spheres[..*i].iter().any(|s| same(s, &spheres[*i]));
            let expected: Vec<u32> = (0..n).filter(is_repeat).map(|i| i as u32).collect();
            assert_eq!(repeats(&spheres), expected, "{n} spheres");
            assert!(n < 3000 || expected.len() > 1000);
        }
    }

    #[test]
    fn too_many_spheres_are_refused_with_numbers() {
        let check_size = |n, bytes| check_size(n, Available { bytes, limit: Limit::Machine });
        assert!(check_size(1_000_000, BUILD_BYTES * 1_000_000).is_ok());
        let too_little = check_size(1_000_000, BUILD_BYTES * 1_000_000 - 1).unwrap_err();
        assert_eq!(too_little.exit_code(), 7);
        assert!(too_little.to_string().contains("enough for 999999 spheres"), "{too_little}");
        let too_many = check_size(bvh::MOST_SPHERES + 1, u64::MAX).unwrap_err();
        assert_eq!(too_many.exit_code(), 7);
        assert!(too_many.to_string().contains("at most 536870912"), "{too_many}");
    }
}
