//! How much the times of a report spread, and a warning where that is too much.

use serde::Serialize;

use super::figures::percent;
use super::{Metric, Of, Row, Spread};

/// A range that is wider than this share of its median is noise: of some nine runs, medians are then off
/// by 4 % (see [`super::figures`]) and two of them differ by 5 % by chance alone, which is what kernels
/// differ by.
const NOISY: f64 = 0.25;

/// The spread of the times of all scenes, kernels and devices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Noise {
    /// Times that were measured repeatedly.
    pub times: usize,
    /// Times whose least and largest values are more than a quarter of the median apart.
    pub wide: usize,
    /// How far they are apart in the middle one of all times, as a share of the median.
    pub typical_range: f64,
}

impl Noise {
    /// The noise of the times of ids in each scene.
    pub fn of(rows: &[Row]) -> Noise {
        let scenes = rows.iter().filter(|row| matches!(row.key.of, Of::Scene { .. }));
        let times = scenes.filter_map(|row| row.number(Metric::TraceNsPerRay)?.relative_range());
        let ranges: Vec<f64> = times.filter(|range| range.is_finite()).collect();
        let (times, wide) = (ranges.len(), ranges.iter().filter(|range| **range > NOISY).count());
        let typical_range = Spread::of(ranges).map_or(0.0, |spread| spread.median);
        Noise { times, wide, typical_range }
    }

    /// What to make of the times, and what to do, where the machine was noisy.
    pub fn warning(&self) -> Option<String> {
        let share = |x: f64| percent((1000.0 * x).round() as u64, 1000);
        (self.typical_range > NOISY).then(|| {
            format!(
                "The machine was noisy: the runs of a kernel in a scene are typically {} of their \
                 median apart, and more than {} in {} of {} cases. Small differences of times mean \
                 nothing; measure again with nothing else at work, and with more --rounds.",
                share(self.typical_range),
                share(NOISY),
                self.wide,
                self.times
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_is_quiet_and_more_is_not() {
        let of = |typical_range| Noise { times: 9, wide: 3, typical_range }.warning();
        assert_eq!(of(0.25), None);
        let warning = of(0.4).expect("a warning");
        assert!(warning.contains("typically 40 %") && warning.contains("in 3 of 9"), "{warning}");
        assert_eq!(Noise::default().warning(), None);
    }
}
