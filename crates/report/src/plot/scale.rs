//! Logarithmic axes: where a number is drawn, and which numbers are written beside it.

/// A range of numbers along a range of pixels.
pub struct Scale {
    /// Bounds of the numbers' decimal logarithms.
    low: f64,
    high: f64,
    from_px: f64,
    to_px: f64,
}

/// Left free beyond the outermost numbers, in decades.
const MARGIN: f64 = 0.06;

impl Scale {
    /// An axis for all `values` that are positive and finite.
    pub fn new(values: impl IntoIterator<Item = f64>, px: (f64, f64)) -> Scale {
        let logs = values.into_iter().filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
        let logs: Vec<f64> = logs.collect();
        let low = logs.iter().copied().reduce(f64::min).unwrap_or(0.0);
        let high = logs.iter().copied().reduce(f64::max).unwrap_or(1.0);
        let (low, high) = (step_down(low - MARGIN), step_up(high + MARGIN));
        Scale { low, high, from_px: px.0, to_px: px.1 }
    }

    /// The place of a positive `x`.
    pub fn px(&self, x: f64) -> f64 {
        let share = ((x.log10() - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        self.from_px + share * (self.to_px - self.from_px)
    }

    /// The numbers to be written, `most` at most: 1, 2 and 5 of each decade, else every decade, else every
    /// second one and so on.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        let mut ticks = self.ticks_at(&[1, 2, 5], 1);
        let mut every = 1;
        while ticks.len() > most.max(1) {
            ticks = self.ticks_at(&[1], every);
            every += 1;
        }
        ticks
    }

    /// These factors of every so many decades.
    fn ticks_at(&self, factors: &[u32], every: i32) -> Vec<f64> {
        let exponents = self.low.floor() as i32..=self.high.ceil() as i32;
        let exponents = exponents.filter(|exponent| exponent.rem_euclid(every) == 0);
        // Parsed, a tick is the nearest number to what is written.
        let tick = |exponent, factor| format!("{factor}e{exponent}").parse::<f64>().ok();
        exponents
            .flat_map(|exponent| factors.iter().filter_map(move |factor| tick(exponent, factor)))
            .filter(|tick| (self.low - 1e-9..=self.high + 1e-9).contains(&tick.log10()))
            .collect()
    }
}

/// The logarithm of the next 1, 2 or 5 times a power of ten that is not above `log`.
fn step_down(log: f64) -> f64 {
    let decade = log.floor();
    let steps = [5f64.log10(), 2f64.log10(), 0.0];
    decade + steps.into_iter().find(|step| decade + step <= log).unwrap_or(0.0)
}

/// The logarithm of the next 1, 2 or 5 times a power of ten that is not below `log`. The inverses of 1, 2 and 5 are such
/// numbers, too.
fn step_up(log: f64) -> f64 {
    -step_down(-log)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        let ticks = |values: [f64; 2]| Scale::new(values, (0.0, 1.0)).ticks(9);
        assert_eq!(ticks([7.0, 80.0]), [5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(ticks([2e-5, 0.4]), [1e-5, 1e-4, 1e-3, 1e-2, 1e-1]);
        assert_eq!(ticks([3e-6, 5e-6]), [2e-6, 5e-6, 1e-5]);
        let few = |most| Scale::new([2e-5, 0.4], (0.0, 1.0)).ticks(most);
        assert_eq!(few(4), [1e-4, 1e-2]);
        assert_eq!(few(1).len(), 1);
    }

    #[test]
    fn numbers_are_where_they_belong() {
        let scale = Scale::new([1.0, 100.0], (0.0, 300.0));
        let (a, b, c) = (scale.px(1.0), scale.px(10.0), scale.px(100.0));
        assert!(0.0 < a && a < b && b < c && c < 300.0 && (a + c - 2.0 * b).abs() < 1e-9);
    }

    #[test]
    fn an_axis_of_one_number_or_none() {
        for values in [&[][..], &[3.0], &[0.0], &[f64::INFINITY, f64::NAN], &[1e300, 1e-300]] {
            let scale = Scale::new(values.iter().copied(), (5.0, 95.0));
            let ticks: Vec<f64> = scale.ticks(9).into_iter().map(|tick| scale.px(tick)).collect();
            assert!(!ticks.is_empty() && ticks.len() < 30, "{values:?}");
            assert!(ticks.is_sorted_by(|a, b| a < b), "{values:?}: {ticks:?}");
            for x in values.iter().filter(|x| **x > 0.0 && x.is_finite()) {
                let px = scale.px(*x);
                assert!(5.0 < px && px < 95.0, "{x} of {values:?} at {px}");
            }
        }
    }
}
