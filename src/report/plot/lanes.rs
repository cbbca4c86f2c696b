//! The lanes of what was never wrong: names beside bars, with room for each.

use maud::Markup;

use super::marks::{text, text_width};
use super::scale::{Scale, typeset};

/// Between a bar and its name, px.
const GAP: f64 = 12.0;

/// How much farther than the largest time the axis may reach to make room for names.
const REACHES: [f64; 8] = [1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0];

/// A kernel and device, or another renderer, without a wrong id.
pub struct Lane {
    /// Its name.
    pub label: String,
    /// Rays of which none was wrong.
    pub rays: u64,
    /// Least and largest time of its bars.
    pub times: (f64, f64),
}

impl Lane {
    fn words(&self) -> String {
        format!("{}: none of {}", self.label, typeset(&self.rays.to_string()))
    }

    /// Where the words stand, and their anchor: to the right of the bars if there is room, or to
    /// the left.
    fn spot(&self, x: &Scale) -> Option<(f64, &'static str)> {
        let width = text_width(&self.words());
        let (left, right) = x.ends();
        let (before, behind) = (x.px(self.times.0) - GAP, x.px(self.times.1) + GAP);
        match (behind + width <= right, before - width >= left) {
            (true, _) => Some((behind, "start")),
            (_, true) => Some((before, "end")),
            _ => None,
        }
    }

    /// The words beside the bars.
    pub fn draw(&self, x: &Scale, y: f64) -> Markup {
        let spot = self.spot(x).unwrap_or((x.ends().1, "end"));
        text(spot.0, y + 4.5, spot.1, "ink halo on-band", &self.words())
    }
}

/// An axis of times that leaves room for the words of each lane.
pub fn scale_with_room(times: &[f64], lanes: &[Lane], px: (f64, f64)) -> Scale {
    let largest = times.iter().copied().filter(|time| time.is_finite()).fold(0.0, f64::max);
    let scale = |reach: &f64| Scale::log(times.iter().copied().chain([reach * largest]), px);
    let scales = REACHES.iter().map(scale);
    let has_room = |scale: &Scale| lanes.iter().all(|lane| lane.spot(scale).is_some());
    scales.into_iter().find(has_room).unwrap_or_else(|| scale(&REACHES[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_grows_until_there_is_room() {
        let px = (0.0, 800.0);
        let lane = |times| Lane { label: "certified, CPU".into(), rays: 100_000, times };
        let times = [10.0, 100.0];
        // A short bar has room; one over the whole axis has none.
        let short = scale_with_room(&times, &[lane((10.0, 12.0))], px);
        let long = scale_with_room(&times, &[lane((10.0, 100.0))], px);
        assert!(long.px(100.0) < short.px(100.0) - 100.0);
        assert!(lane((10.0, 100.0)).spot(&short).is_none());
        assert_eq!(lane((10.0, 100.0)).spot(&long), Some((long.px(100.0) + GAP, "start")));
    }
}
