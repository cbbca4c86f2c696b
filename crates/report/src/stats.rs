//! Times with their range, and errors of rays.

use kugelblitz::query::Hits;
use kugelblitz_judge::compare::{RayDifferences, RayError};
use kugelblitz_judge::verify::{Truth, ray_errors};
use serde::Serialize;

/// Median of repeated times, with their range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeSpread {
    /// Median.
    pub median: f64,
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// Number of times.
    pub n: usize,
}

impl TimeSpread {
    /// Returns the spread of some times; all zero for none.
    pub(crate) fn new(mut times: Vec<f64>) -> TimeSpread {
        times.sort_unstable_by(f64::total_cmp);
        let n = times.len();
        let [Some(min), Some(max)] = [times.first(), times.last()].map(|time| time.copied()) else {
            return TimeSpread { median: 0.0, min: 0.0, max: 0.0, n };
        };
        TimeSpread { median: (times[(n - 1) / 2] + times[n / 2]) / 2.0, min, max, n }
    }

    /// Returns the geometric means of medians, minima and maxima.
    pub(crate) fn geometric_mean(spreads: &[TimeSpread]) -> TimeSpread {
        let mean = |part: fn(&TimeSpread) -> f64| {
            let logarithms: f64 = spreads.iter().map(|spread| part(spread).ln()).sum();
            (logarithms / spreads.len() as f64).exp()
        };
        TimeSpread {
            median: mean(|spread| spread.median),
            min: mean(|spread| spread.min),
            max: mean(|spread| spread.max),
            n: spreads.iter().map(|spread| spread.n).sum(),
        }
    }
}

/// Quantiles of errors. A result that is not finite has an infinite error, which is `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorQuantiles {
    /// Median.
    pub median: f64,
    /// Error that 99.9 % of the rays do not exceed.
    pub p999: f64,
    /// Maximum.
    pub max: f64,
}

impl ErrorQuantiles {
    fn new(mut errors: Vec<f64>) -> Option<ErrorQuantiles> {
        errors.sort_unstable_by(f64::total_cmp);
        let n = errors.len();
        // Nearest rank: the smallest value that at least this share does not exceed.
        let p999 = errors.get((0.999 * n as f64).ceil() as usize - usize::from(n > 0))?;
        let median = (errors[(n - 1) / 2] + errors[n / 2]) / 2.0;
        Some(ErrorQuantiles { median, p999: *p999, max: errors[n - 1] })
    }

    /// Returns the larger of each quantile.
    fn larger(self, other: ErrorQuantiles) -> ErrorQuantiles {
        ErrorQuantiles {
            median: self.median.max(other.median),
            p999: self.p999.max(other.p999),
            max: self.max.max(other.max),
        }
    }
}

/// Errors of rays against exact arithmetic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RayErrors {
    /// Number of compared rays.
    pub compared: u64,
    /// Rays that hit an object instead of the background.
    pub false_hits: u64,
    /// Rays that hit the background instead of an object.
    pub false_misses: u64,
    /// Rays that hit another object than the visible one.
    pub wrong_object: u64,
    /// Error of `t` in f32 steps at the exact `t`, where the object is right; `null` if it never is.
    pub t_ulp: Option<ErrorQuantiles>,
    /// Angle to the exact normal, degrees, where the object is right; `null` if it never is.
    pub normal_degrees: Option<ErrorQuantiles>,
}

impl RayErrors {
    /// Compares hits with the truth about some of their rays.
    pub(crate) fn new(hits: &Hits, truth: &Truth) -> RayErrors {
        let mut found = RayDifferences::default();
        let [mut t_ulp, mut normal_degrees] = [Vec::new(), Vec::new()];
        for (ray, error) in ray_errors(hits, truth).enumerate() {
            found.see(ray, &error);
            if let RayError::Right { id: 1.., t, normal } = error {
                t_ulp.extend(t.map(|t| t.ulp));
                normal_degrees.extend(normal.map(|normal| normal.degrees));
            }
        }
        RayErrors {
            compared: found.rays,
            false_hits: found.false_hits,
            false_misses: found.false_misses,
            wrong_object: found.wrong_object,
            t_ulp: ErrorQuantiles::new(t_ulp),
            normal_degrees: ErrorQuantiles::new(normal_degrees),
        }
    }

    /// Adds the counts of another scene, and keeps the larger quantiles.
    pub(crate) fn add(&mut self, other: &RayErrors) {
        let larger = |a: Option<ErrorQuantiles>, b: Option<ErrorQuantiles>| match a.zip(b) {
            Some((a, b)) => Some(a.larger(b)),
            None => a.or(b),
        };
        *self = RayErrors {
            compared: self.compared + other.compared,
            false_hits: self.false_hits + other.false_hits,
            false_misses: self.false_misses + other.false_misses,
            wrong_object: self.wrong_object + other.wrong_object,
            t_ulp: larger(self.t_ulp, other.t_ulp),
            normal_degrees: larger(self.normal_degrees, other.normal_degrees),
        };
    }

    /// Returns the number of rays that do not hit the visible object.
    pub fn wrong(&self) -> u64 {
        self.false_hits + self.false_misses + self.wrong_object
    }

    /// Returns the share of rays that do not hit the visible object, percent.
    pub(crate) fn wrong_percent(&self) -> f64 {
        100.0 * self.wrong() as f64 / self.compared.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_quantiles_are_of_the_sorted_values() {
        let spread = TimeSpread::new(vec![3.0, 1.0, 2.0, 10.0]);
        assert_eq!(spread, TimeSpread { median: 2.5, min: 1.0, max: 10.0, n: 4 });
        assert_eq!(TimeSpread::new(Vec::new()).n, 0);
        let mean =
            TimeSpread::geometric_mean(&[1.0, 100.0].map(|time| TimeSpread::new(vec![time])));
        assert!((mean.median - 10.0).abs() < 1e-12 && mean.n == 2, "{mean:?}");

        let errors = (1..=2000).rev().map(f64::from).collect();
        let expected = ErrorQuantiles { median: 1000.5, p999: 1998.0, max: 2000.0 };
        assert_eq!(ErrorQuantiles::new(errors), Some(expected));
        let one = ErrorQuantiles { median: 7.0, p999: 7.0, max: 7.0 };
        assert_eq!(ErrorQuantiles::new(vec![7.0]), Some(one));
        assert_eq!(ErrorQuantiles::new(Vec::new()), None);
    }

    #[test]
    fn counts_add_up_and_the_larger_error_stays() {
        let errors = |n: u64, t: Option<f64>| RayErrors {
            compared: 10 * n,
            false_hits: n,
            false_misses: 2 * n,
            wrong_object: 3 * n,
            t_ulp: t.and_then(|t| ErrorQuantiles::new(vec![t])),
            normal_degrees: None,
        };
        let mut sum = RayErrors::default();
        [errors(1, Some(0.5)), errors(2, Some(0.25)), errors(0, None)]
            .iter()
            .for_each(|e| sum.add(e));
        assert_eq!(sum, errors(3, Some(0.5)));
        assert_eq!((sum.wrong(), sum.wrong_percent()), (18, 60.0));
    }
}
