//! What the colours mean, and how many pixels have each meaning.

use kugelblitz::rays::Pixels;

use super::{Rgb, Show, Tint, tint};

/// A colour with its meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// sRGB.
    pub color: Rgb,
    /// In words.
    pub meaning: String,
}

impl Entry {
    /// The legend of `show`; empty where the names of the objects say it. `range` is that of `t`, where it
    /// is known.
    pub fn all(show: Show, range: Option<[f32; 2]>) -> Vec<Entry> {
        let entry = |&(color, meaning): &tint::Swatch| Entry { color, meaning: meaning.into() };
        let mut entries: Vec<Entry> = tint::swatches(show).iter().map(entry).collect();
        if let (Show::Depth, Some(range)) = (show, range) {
            for (end, t) in entries.iter_mut().zip(range) {
                end.meaning += &format!(": t = {t}");
            }
        }
        entries
    }
}

/// The pixels of each entry of a legend.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// How many there are of each, and picture column and row of each pixel, from the top; without those after
    /// [`MOST_PLACES`].
    entries: Vec<(u64, Vec<[u32; 2]>)>,
}

/// Places that are kept of an entry.
const MOST_PLACES: usize = 64;

impl Tally {
    /// Counts the pixels of a band, from left to right and from the top.
    pub fn add(&mut self, pixels: &Pixels, tints: &[Tint]) {
        for (index, tint) in tints.iter().enumerate() {
            let Some(entry) = tint.entry.map(usize::from) else { continue };
            if entry >= self.entries.len() {
                self.entries.resize_with(entry + 1, Default::default);
            }
            let (count, places) = &mut self.entries[entry];
            *count += 1;
            if places.len() < MOST_PLACES {
                places.push(pixels.xy(index).into());
            }
        }
    }

    /// How many pixels an entry has; `None` where pixels aren't counted.
    pub fn count(&self, entry: usize) -> Option<u64> {
        let count = || self.entries.get(entry).map_or(0, |(count, _)| *count);
        (!self.entries.is_empty()).then(count)
    }

    /// All pixels of an entry that has so few that nobody would find them.
    pub fn few(&self, entry: usize) -> &[[u32; 2]] {
        match self.entries.get(entry) {
            Some((count, places)) if *count == places.len() as u64 => places,
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use kugelblitz::rays::View;
    use kugelblitz::scene::Camera;

    use super::*;

    #[test]
    fn pixels_are_counted_and_few_are_found() {
        let view = View::new(&Camera::new(DVec3::Z, DVec3::ZERO));
        let whole = Pixels::whole(view, 40, 20);
        let tint = |entry| Tint { color: [0; 3], entry };
        let mut tints = vec![tint(Some(0)); 40 * 10];
        tints[43] = tint(Some(2));
        tints[9] = tint(None);
        let mut tally = Tally::default();
        tally.add(&whole.rows(0, 10), &tints);
        tally.add(&whole.rows(10, 10), &tints);
        assert_eq!([0, 1, 2].map(|entry| tally.count(entry)), [796, 0, 2].map(Some));
        assert_eq!(tally.few(2), [[3, 1], [3, 11]]);
        assert_eq!((tally.few(0).len(), tally.few(1).len(), tally.few(9).len()), (0, 0, 0));
        assert_eq!((tally.count(1), tally.count(7)), (Some(0), Some(0)));
        assert_eq!(Tally::default().count(0), None);
    }
}
