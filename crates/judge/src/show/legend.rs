//! What the colours mean, and how many pixels have each meaning.

use std::fmt;

use kugelblitz::rays::Pixels;
use kugelblitz::scene::hex;
use kugelblitz::words::{count, joined};
use serde::{Serialize, Serializer};

use super::{Rgb, Show, Tint, tint};

/// A colour with its meaning, and the pixels that have it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// sRGB colour, `#rrggbb` in JSON. Unstable in JSON.
    #[serde(serialize_with = "as_hex")]
    pub color: Rgb,
    /// Meaning in words. Unstable in JSON.
    pub meaning: String,
    /// Number of pixels with this meaning; absent if they are not counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixels: Option<u64>,
    /// Column and row of each of these pixels; absent unless they are few.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    pub at: Vec<[u32; 2]>,
}

fn as_hex<S: Serializer>(color: &Rgb, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&hex(*color))
}

/// Most pixels of an entry that have their places kept.
const MOST_PLACES: u64 = 64;

/// Most pixels of a meaning that are told one by one.
const MOST_TOLD: usize = 4;

impl Entry {
    /// The legend of `show`, without pixels yet; empty where the names of the objects say it. `range` is that of `t`, where
    /// it is known.
    pub fn all(show: Show, range: Option<[f32; 2]>) -> Vec<Entry> {
        // Colours of these lie between those of the legend.
        let pixels = (!matches!(show, Show::Depth | Show::Normal)).then_some(0);
        let entry = |&(color, meaning): &tint::Swatch| {
            let (meaning, at) = (meaning.into(), Vec::new());
            Entry { color, meaning, pixels, at }
        };
        let mut entries: Vec<Entry> = tint::swatches(show).iter().map(entry).collect();
        if let (Show::Depth, Some(range)) = (show, range) {
            for (end, t) in entries.iter_mut().zip(range) {
                end.meaning += &format!(": t = {t}");
            }
        }
        entries
    }

    /// Counts the pixels of a band, from left to right and from the top, in a legend.
    pub(super) fn count(legend: &mut [Entry], pixels: &Pixels, tints: &[Tint]) {
        for (index, tint) in tints.iter().enumerate() {
            let Some(entry) = tint.entry else { continue };
            let Entry { pixels: n, at, .. } = &mut legend[usize::from(entry)];
            let n = n.get_or_insert_default();
            *n += 1;
            if *n <= MOST_PLACES {
                at.push(pixels.xy(index).into());
            } else {
                at.clear();
            }
        }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Entry { color, meaning, pixels, at } = self;
        write!(f, "  {}  {meaning}", hex(*color))?;
        if let Some(n) = pixels {
            write!(f, ": {}", count(*n as usize, "pixel"))?;
        }
        if !(1..=MOST_TOLD).contains(&at.len()) {
            return Ok(());
        }
        let places = joined(at.iter().map(|[x, y]| format!("{x},{y}")), " and ");
        write!(f, ", at {places}")
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
        let mut legend = Entry::all(Show::Stage, None);
        Entry::count(&mut legend, &whole.rows(0, 10), &tints);
        Entry::count(&mut legend, &whole.rows(10, 10), &tints);
        let counted = |show| Entry::all(show, None).into_iter().map(|entry| entry.pixels);
        assert!(legend.iter().map(|entry| entry.pixels).eq([796, 0, 2].map(Some)));
        assert_eq!(legend[2].at, [[3, 1], [3, 11]]);
        assert_eq!((legend[0].at.len(), legend[1].at.len()), (0, 0));
        assert!(counted(Show::Stage).eq([Some(0); 3]) && counted(Show::Depth).eq([None; 2]));
    }
}
