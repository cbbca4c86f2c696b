//! What a device that shades is asked for.

/// The first word of a pixel whose colour a device leaves open.
pub const OPEN_COLOR: u32 = u32::MAX;

/// How a device gives colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorWords {
    /// Bytes in one word: red in the lowest one, then green and blue.
    Bytes,
    /// Numbers of 16 bits, each in a word.
    Shorts,
    /// The words of f32.
    Floats,
}

impl ColorWords {
    /// Words of a pixel.
    pub fn per_pixel(self) -> usize {
        match self {
            ColorWords::Bytes => 1,
            ColorWords::Shorts | ColorWords::Floats => 3,
        }
    }
}

/// What tells the numbers of one scene and one camera apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightKey {
    /// How colours are given.
    pub words: ColorWords,
    /// Samples across and down a pixel.
    pub n_samples: u32,
    /// Whether samples that hit nothing have the scene's background, or else are black.
    pub shows_background: bool,
    /// Whether they are left out of the mean.
    pub leaves_out: bool,
}
