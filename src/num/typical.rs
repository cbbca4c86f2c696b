//! Typical numbers of many things: few outliers do not move them.

/// Some of many things, from all of their order.
pub(crate) fn sample<T>(all: &[T]) -> impl Iterator<Item = &T> + Clone {
    /// Most things of a sample.
    const MOST: usize = 1023;
    all.iter().step_by(all.len().div_ceil(MOST).max(1))
}

/// The number at a place in ascending order; 0 of none.
pub(crate) fn nth(place: usize, mut all: Vec<f64>) -> f64 {
    match all.is_empty() {
        true => 0.0,
        false => *all.select_nth_unstable_by(place, f64::total_cmp).1,
    }
}

/// The largest number, except for one in 64: that many outliers do not move it. 0 of none.
pub(crate) fn largest_of_most(all: Vec<f64>) -> f64 {
    nth(all.len().saturating_sub(all.len() / 64 + 1), all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_outliers_do_not_move_typical_numbers() {
        let of = |n: usize| (0..n).map(|k| if k % 64 == 5 { 1e300 } else { k as f64 });
        assert_eq!(largest_of_most(of(64).collect()), 63.0);
        assert_eq!(nth(32, of(64).collect()), 33.0);
        assert_eq!(
            [largest_of_most(vec![]), nth(0, vec![]), largest_of_most(vec![7.0])],
            [0.0, 0.0, 7.0]
        );
        let all: Vec<usize> = (0..100_000).collect();
        let some: Vec<usize> = sample(&all).copied().collect();
        assert!((900..=1023).contains(&some.len()) && *some.last().unwrap() > 99_000);
        assert_eq!(sample(&all[..3]).count(), 3);
    }
}
