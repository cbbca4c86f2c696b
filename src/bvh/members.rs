//! Which spheres of a scene have a place in its tree.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use crate::bounds;
use crate::error::{Error, Result};
use crate::num::Float;
use crate::num::typical::{largest_of_most, nth, sample};
use crate::scene::Sphere;
use crate::support::memory::Available;
use crate::support::parallel;
use crate::support::random::SplitMix;

/// Most spheres of a tree: the places of leaves and the numbers of nodes have 31 bits.
pub const MOST_SPHERES: usize = 1 << 29;

/// Most bytes a sphere while a tree is built: its index as a member, its box, its middle with its place among the boxes, its
/// share of nodes that are half full and of those above, its index in their order, and itself with its id.
const BUILD_BYTES: u64 = 4 + 24 + 16 + 72 + 4 + 32 + 4;

/// Refuses what a tree can't hold or there is no memory for.
pub(super) fn check_size(n_spheres: usize) -> Result<()> {
    check_size_in(n_spheres, Available::now())
}

fn check_size_in(n_spheres: usize, available: Available) -> Result<()> {
    if n_spheres > MOST_SPHERES {
        return Err(Error::TooLarge(
            format!(
                "{n_spheres} spheres; a hierarchy holds at most {MOST_SPHERES}: split the scene"
            )
            .into(),
        ));
    }
    let needed = n_spheres as u64 * BUILD_BYTES;
    let most = available.bytes / BUILD_BYTES;
    let advice = format!("that is enough for {most} spheres; free some, or split the scene");
    available.require(format!("building the hierarchy over {n_spheres} spheres"), needed, &advice)
}

/// A point amid the spheres: f32 has most digits near it, and few spheres far away don't move it.
pub(super) fn reference(spheres: &[Sphere]) -> DVec3 {
    let median = |axis: usize| {
        let at: Vec<f64> = sample(spheres).map(|sphere| sphere.center[axis]).collect();
        nth(at.len() / 2, at)
    };
    DVec3::from_array(std::array::from_fn(median))
}

/// Returns the extent of most spheres, their largest distance from the reference point, with room for those that are not much
/// larger or farther away.
fn ordinary_extent(spheres: &[Sphere], reference: DVec3) -> f64 {
    /// Factor of the extent of all others. Not a bound.
    const MUCH: f64 = 64.0;
    let extent = |sphere: &Sphere| (sphere.center - reference).length() + sphere.radius.abs();
    MUCH * largest_of_most(sample(spheres).map(extent).collect())
}

/// Most spheres with a larger extent outside of the tree. Not a bound: it weighs their cost for each ray.
const MOST_OUTLIERS: usize = 16;

/// Indices of the spheres that can be seen: those that are in the tree, and the others. Spheres with a radius of 0 and those that
/// equal an earlier one, against which they never win, are neither.
///
/// The few spheres that are much farther away or much larger than most are not in the tree. Each ray tests them, with records that
/// are more precise for a large sphere than a leaf is.
pub(super) fn members(spheres: &[Sphere], reference: DVec3) -> (Vec<u32>, Vec<u32>) {
    let repeats = repeats(spheres);
    let can_be_seen = |i: u32| {
        spheres[i as usize].radius != 0.0
            && (repeats.is_empty() || repeats.binary_search(&i).is_err())
    };
    let with_box = |is_in: bool, most: f64| {
        let has_box = |sphere: &Sphere| {
            let (distance, r) =
                (bounds::length_bound(sphere.center - reference), sphere.radius.abs());
            r <= f32::FARTHEST && distance <= f32::FARTHEST && distance + r <= most
        };
        parallel::filter_map(spheres.len(), |i| {
            (has_box(&spheres[i]) == is_in && can_be_seen(i as u32)).then_some(i as u32)
        })
    };
    let extent = ordinary_extent(spheres, reference);
    let outside = with_box(false, extent);
    match outside.len() <= MOST_OUTLIERS {
        true => (with_box(true, extent), outside),
        false => [true, false].map(|is_in| with_box(is_in, f64::INFINITY)).into(),
    }
}

/// Indices of the spheres that equal an earlier one, ascending. They need not be all: it saves work.
fn repeats(spheres: &[Sphere]) -> Vec<u32> {
    let key = |i: u32| spheres[i as usize].bits();
    let hash = |i: u32| {
        let mix = |mixed: u64, word: &u64| {
            (mixed.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        };
        SplitMix::new(key(i).iter().fold(0, mix)).bits()
    };
    // Only what shares its place in a table with others can equal one of them.
    let n_bits = (16 * spheres.len()).next_power_of_two().max(64);
    let place = |hash: u64| {
        let bit = hash as usize & (n_bits - 1);
        (bit / 64, 1 << (bit % 64))
    };
    let taken: Vec<AtomicU64> = (0..n_bits / 64).map(|_| AtomicU64::new(0)).collect();
    let places_taken = parallel::filter_map(spheres.len(), |i| {
        let (word, bit) = place(hash(i as u32));
        (taken[word].fetch_or(bit, Ordering::Relaxed) & bit != 0).then_some((word, bit))
    });
    let mut shared = vec![0; n_bits / 64];
    places_taken.into_iter().for_each(|(word, bit)| shared[word] |= bit);
    let mut sharing: Vec<(u64, u32)> = parallel::filter_map(spheres.len(), |i| {
        let hash = hash(i as u32);
        let (word, bit) = place(hash);
        (shared[word] & bit != 0).then_some((hash, i as u32))
    });
    sharing.sort_unstable();
    // Where different spheres have one hash, which hardly ever is, a repeat may stay.
    let repeat = |two: &[(u64, u32)]| (key(two[0].1) == key(two[1].1)).then_some(two[1].1);
    let mut repeats: Vec<u32> = sharing.windows(2).filter_map(repeat).collect();
    repeats.sort_unstable();
    repeats
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::memory::Limit;

    /// Against a plain search, over spheres of few values, so that some are equal.
    #[test]
    fn repeats_are_all_but_the_first_of_equal_spheres() {
        let mut random = SplitMix::new(1110);
        for n in [0, 1, 2, 3, 40, 3000] {
            let mut number = || match random.bits() % 6 {
                0 if random.bits().is_multiple_of(2) => -0.0,
                number => number as f64,
            };
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
        let check_size = |n, bytes| check_size_in(n, Available { bytes, limit: Limit::Machine });
        assert!(check_size(1_000_000, BUILD_BYTES * 1_000_000).is_ok());
        let too_little = check_size(1_000_000, BUILD_BYTES * 1_000_000 - 1).unwrap_err();
        assert_eq!(too_little.exit_code(), 7);
        let hint = too_little.hint().to_string();
        assert!(hint.contains("999999 spheres"), "{hint}");
        let too_many = check_size(MOST_SPHERES + 1, u64::MAX).unwrap_err();
        assert_eq!(too_many.exit_code(), 7);
        assert!(too_many.to_string().contains("at most 536870912"), "{too_many}");
    }
}
