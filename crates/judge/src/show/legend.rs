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
        match (show, range) {
            (Show::Depth, Some(range)) => {
                let ends = tint::swatches(show).iter().zip(range);
                let named =
                    |(&(color, end), t)| Entry { color, meaning: format!("{end}: t = {t}") };
                ends.map(named).collect()
            }
            _ => tint::swatches(show).iter().map(entry).collect(),
        }
    }
}

/// The pixels of each entry of a legend.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// How many there are of each.
    pub counts: Vec<u64>,
    /// Picture column and row of each, from the top; without those after [`Tally::MOST_PLACES`].
    pub places: Vec<Vec<[u32; 2]>>,
}

impl Tally {
    /// Places that are kept of an entry.
    pub const MOST_PLACES: usize = 64;

    /// Counts the pixels of a band, from left to right and from the top.
    pub fn add(&mut self, pixels: &Pixels, tints: &[Tint]) {
        for (index, entry) in tints.iter().map(|tint| usize::from(tint.entry)).enumerate() {
            if entry == usize::from(Tint::NO_ENTRY) {
                continue;
            }
            if entry >= self.counts.len() {
                self.counts.resize(entry + 1, 0);
                self.places.resize(entry + 1, Vec::new());
            }
            self.counts[entry] += 1;
            if self.places[entry].len() < Tally::MOST_PLACES {
                let (x, y) = pixels.xy(index);
                self.places[entry].push([x, y]);
            }
        }
    }

    /// How many pixels an entry has; `None` where pixels aren't counted.
    pub fn count(&self, entry: usize) -> Option<u64> {
        (!self.counts.is_empty()).then(|| self.counts.get(entry).copied().unwrap_or(0))
    }

    /// All pixels of an entry that has so few that nobody would find them.
    pub fn few(&self, entry: usize) -> &[[u32; 2]] {
        match (self.count(entry), self.places.get(entry)) {
            (Some(count), Some(places)) if count == places.len() as u64 => places,
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
        let mut tints = vec![tint(0); 40 * 10];
        tints[43] = tint(2);
        tints[9] = tint(Tint::NO_ENTRY);
        let mut tally = Tally::default();
        tally.add(&whole.rows(0, 10), &tints);
        tally.add(&whole.rows(10, 10), &tints);
        assert_eq!(tally.counts, [796, 0, 2]);
        assert_eq!(tally.few(2), [[3, 1], [3, 11]]);
        assert_eq!((tally.few(0).len(), tally.few(1).len(), tally.few(9).len()), (0, 0, 0));
        assert_eq!((tally.count(1), tally.count(7)), (Some(0), Some(0)));
        assert_eq!(Tally::default().count(0), None);
    }
}
