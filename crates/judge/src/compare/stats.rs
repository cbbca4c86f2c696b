//! How errors are spread.

use kugelblitz::rays::Rays;
use serde::Serialize;

use super::{RayDifferences, RayError};

/// The errors of some rays.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ErrorStats {
    /// How many rays these are.
    pub rays: u64,
    /// Those with a wrong id.
    pub wrong_ids: u64,
    /// Those that hit an object where there is none.
    pub false_hits: u64,
    /// Those that hit nothing where there is an object.
    pub false_misses: u64,
    /// Those that hit another object than the visible one.
    pub wrong_object: u64,
    /// Errors of `t` in f32 steps, where the object is right.
    pub t_ulp: Option<ErrorSpread>,
    /// Errors of `t` relative to the exact one.
    pub t_relative: Option<ErrorSpread>,
    /// Angles between the normals and the exact ones, degrees.
    pub normal_degrees: Option<ErrorSpread>,
}

impl ErrorStats {
    /// Of those of the rays that are in a class.
    pub fn new(rays: &Rays, errors: &[RayError], is_in: impl Fn(usize) -> bool) -> ErrorStats {
        let mut counts = RayDifferences::default();
        let mut spreads = [const { Vec::new() }; 3];
        for (i, error) in errors.iter().enumerate().filter(|(i, _)| is_in(*i)) {
            counts.see(i, error);
            if let RayError::Right { t, normal, .. } = error {
                let sizes = [t.map(|t| t.ulp), t.map(|t| t.relative), normal.map(|n| n.degrees)];
                spreads.iter_mut().zip(sizes).for_each(|(all, size)| all.extend(size.zip(Some(i))));
            }
        }
        let [t_ulp, t_relative, normal_degrees] =
            spreads.map(|errors| ErrorSpread::new(errors, rays));
        let RayDifferences { rays, false_hits, false_misses, wrong_object, .. } = counts;
        let wrong_ids = counts.wrong_ids();
        ErrorStats {
            rays,
            wrong_ids,
            false_hits,
            false_misses,
            wrong_object,
            t_ulp,
            t_relative,
            normal_degrees,
        }
    }
}

/// Errors of many rays in a few numbers. Infinite ones are those of results that are not finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorSpread {
    /// How many there are.
    pub n: u64,
    /// Half of them are not larger.
    pub median: f64,
    /// 99 of 100 are not larger.
    pub p99: f64,
    /// The largest.
    pub worst: f64,
    /// The first ray that has it.
    pub worst_ray: usize,
    /// Its column and row, where the rays are those of pixels.
    pub worst_pixel: Option<[u32; 2]>,
}

impl ErrorSpread {
    /// Of errors with the rays that have them; `None` of none.
    fn new(mut errors: Vec<(f64, usize)>, rays: &Rays) -> Option<ErrorSpread> {
        let n = errors.len();
        let &(worst, worst_ray) =
            errors.iter().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?;
        // The smallest one that is not less than so many of them.
        let mut rank = |share_percent: usize| {
            let place = (n * share_percent).div_ceil(100).max(1) - 1;
            errors.select_nth_unstable_by(place, |a, b| a.0.total_cmp(&b.0)).1.0
        };
        let (median, p99, worst_pixel) = (rank(50), rank(99), rays.pixel(worst_ray));
        Some(ErrorSpread { n: n as u64, median, p99, worst, worst_ray, worst_pixel })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_the_sorted_errors() {
        let of = |errors: &[f64]| {
            ErrorSpread::new(errors.iter().copied().zip(10..).collect(), &Rays::List(Vec::new()))
                .map(|s| (s.median, s.p99, s.worst_ray))
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[3.0]), Some((3.0, 3.0, 10)));
        assert_eq!(of(&[4.0, 1.0, 3.0, 2.0]), Some((2.0, 4.0, 10)));
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(of(&hundred), Some((50.0, 99.0, 10)));
        assert_eq!(
            of(&[1.0, f64::INFINITY, f64::INFINITY]),
            Some((f64::INFINITY, f64::INFINITY, 11))
        );
    }
}
