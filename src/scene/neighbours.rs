//! The distance of neighbours in a cloud, for spheres whose radius nobody gave.

use glam::DVec3;
use rayon::prelude::*;

use super::Sphere;
use crate::support::parallel;

/// Spheres whose nearest neighbour is looked for.
const N_ASKED: usize = 1001;

/// The radius of spheres that have none: half the median distance between a centre and the nearest
/// other one, so that half of them touch or overlap a neighbour. Of many spheres, about a thousand are
/// asked, evenly by their places in the file. 1 where there are no two places.
pub(super) fn usual_radius(spheres: &[Sphere]) -> f64 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for sphere in spheres {
        (low, high) = (low.min(sphere.center), high.max(sphere.center));
    }
    let spread = high - low;
    let axis = (0..3).max_by(|&a, &b| spread[a].total_cmp(&spread[b])).unwrap_or(0);
    let mut sorted: Vec<&Sphere> = spheres.iter().collect();
    sorted.par_sort_unstable_by(|a, b| a.center[axis].total_cmp(&b.center[axis]));

    let every = spheres.len().div_ceil(N_ASKED).max(1);
    let asked = spheres.iter().step_by(every);
    let distances = parallel::map(asked, |sphere| nearest(&sorted, axis, sphere));
    let mut distances: Vec<f64> = distances.into_iter().flatten().collect();
    distances.sort_unstable_by(f64::total_cmp);
    match distances.get(distances.len() / 2) {
        Some(distance) if *distance > 0.0 && distance.is_finite() => 0.5 * distance,
        _ => 1.0,
    }
}

/// The distance to the nearest other centre. `sorted` is so along the axis: those that are farther along
/// it than the nearest so far need no look.
fn nearest(sorted: &[&Sphere], axis: usize, sphere: &Sphere) -> Option<f64> {
    let place = sphere.center[axis];
    let middle = sorted.partition_point(|other| other.center[axis] < place);
    let (before, behind) = sorted.split_at(middle);
    let mut least = f64::INFINITY;
    let mut look = |other: &Sphere| {
        let along = (other.center[axis] - place).abs();
        if along > least {
            return false;
        }
        let distance = other.center.distance(sphere.center);
        if distance > 0.0 && distance < least {
            least = distance;
        }
        true
    };
    // Not one side after the other: the nearer ones keep the search short.
    let (mut left, mut right) = (before.iter().rev(), behind.iter());
    let (mut goes_left, mut goes_right) = (true, true);
    while goes_left || goes_right {
        goes_left = goes_left && left.next().is_some_and(|other| look(other));
        goes_right = goes_right && right.next().is_some_and(|other| look(other));
    }
    least.is_finite().then_some(least)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::support::random::SplitMix;

    fn at(center: DVec3) -> Sphere {
        Sphere { center, radius: 1.0 }
    }

    #[test]
    fn it_is_half_the_median_distance_of_all_pairs() {
        let mut random = SplitMix::new(5);
        for stretch in [DVec3::ONE, DVec3::new(9.0, 1.0, 0.0), DVec3::Z] {
            let place = |_| stretch * DVec3::from_array(std::array::from_fn(|_| random.unit()));
            let spheres: Vec<Sphere> = (0..501).map(place).map(at).collect();
            let of_one = |(index, sphere): (usize, &Sphere)| {
                let others = spheres.iter().enumerate().filter(|(other, _)| *other != index);
                let distances = others.map(|(_, other)| other.center.distance(sphere.center));
                distances.fold(f64::INFINITY, f64::min)
            };
            let mut distances: Vec<f64> = spheres.iter().enumerate().map(of_one).collect();
            distances.sort_by(f64::total_cmp);
            assert_eq!(usual_radius(&spheres), 0.5 * distances[250], "{stretch}");
        }
    }

    #[test]
    fn a_lattice_touches() {
        let place = |i: usize| DVec3::new((i % 20) as f64, (i / 20 % 20) as f64, (i / 400) as f64);
        let spheres: Vec<Sphere> = (0..8000).map(place).map(|center| at(0.25 * center)).collect();
        assert_eq!(usual_radius(&spheres), 0.125);
    }

    #[test]
    fn alone_or_in_one_place_it_is_one() {
        assert_eq!(usual_radius(&[]), 1.0);
        assert_eq!(usual_radius(&[at(DVec3::X)]), 1.0);
        assert_eq!(usual_radius(&[at(DVec3::X); 5000]), 1.0);
        // Equal places don't count: their neighbour is the next place.
        let pairs = [at(DVec3::ZERO), at(DVec3::ZERO), at(DVec3::X * 4.0)];
        assert_eq!(usual_radius(&pairs), 2.0);
    }
}
