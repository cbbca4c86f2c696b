//! How errors are spread.

/// Errors of many rays in a few numbers. Infinite ones are those of results that are not finite.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Spread {
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
}

impl Spread {
    /// Of errors with the rays that have them; `None` of none.
    pub(super) fn new(mut errors: Vec<(f64, usize)>) -> Option<Spread> {
        let n = errors.len();
        let &(worst, worst_ray) =
            errors.iter().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?;
        // The smallest one that is not less than so many of them.
        let mut rank = |share_percent: usize| {
            let place = (n * share_percent).div_ceil(100).max(1) - 1;
            errors.select_nth_unstable_by(place, |a, b| a.0.total_cmp(&b.0)).1.0
        };
        Some(Spread { n: n as u64, median: rank(50), p99: rank(99), worst, worst_ray })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_the_sorted_errors() {
        let of = |errors: &[f64]| {
            Spread::new(errors.iter().copied().zip(10..).collect())
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
