//! [`crate::trace::Hits`] → colours: the only place that knows what colour a hit has.

mod decide;
mod exactly;
mod lamp;
mod lit;
mod mean;
mod occluders;
mod painter;
mod pass;
mod plain;
mod unlit;
mod written;

use crate::error::{Error, Result};
pub(crate) use exactly::{LitPoint, add_sample, mean_divisor};
pub use lamp::{Lamp, Lighting, Origin};
pub use lit::certified_lighting;
pub(crate) use mean::ExactMean;
pub use painter::{Background, ColorCounts, Painted, Painter, Style};
pub(crate) use plain::{PlainPoint, PlainWay, plainly};
pub use unlit::Shader;

/// The numbers that a picture's colours are written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// sRGB, 8 bits a channel.
    Srgb8,
    /// sRGB, 16 bits a channel.
    Srgb16,
    /// Linear f32.
    Linear,
}

/// Colours of consecutive pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum Colors {
    /// In [`Encoding::Srgb8`].
    Srgb8(Vec<[u8; 3]>),
    /// In [`Encoding::Srgb16`].
    Srgb16(Vec<[u16; 3]>),
    /// In [`Encoding::Linear`].
    Linear(Vec<[f32; 3]>),
}

/// A pixel's colour in the numbers of one [`Encoding`]: `[u8; 3]`, `[u16; 3]` or `[f32; 3]`.
pub trait Pixel: written::Written {
    /// How it is written.
    const ENCODING: Encoding;

    /// The pixels of colours that are written so.
    ///
    /// # Errors
    /// [`Error::Usage`] where they are written otherwise.
    fn all(colors: Colors) -> Result<Vec<Self>>;
}

macro_rules! pixels {
    ($($number:ty => $encoding:ident),+) => {
        $(impl Pixel for [$number; 3] {
            const ENCODING: Encoding = Encoding::$encoding;

            fn all(colors: Colors) -> Result<Vec<Self>> {
                match colors {
                    Colors::$encoding(pixels) => Ok(pixels),
                    other => Err(Error::Usage(format!(
                        "the colours are {:?}, not {:?}",
                        other.encoding(),
                        Self::ENCODING
                    ))),
                }
            }
        })+
    };
}

pixels!(u8 => Srgb8, u16 => Srgb16, f32 => Linear);

impl Colors {
    /// No colours yet.
    pub fn new(encoding: Encoding) -> Colors {
        match encoding {
            Encoding::Srgb8 => Colors::Srgb8(Vec::new()),
            Encoding::Srgb16 => Colors::Srgb16(Vec::new()),
            Encoding::Linear => Colors::Linear(Vec::new()),
        }
    }

    /// How they are written.
    pub fn encoding(&self) -> Encoding {
        match self {
            Colors::Srgb8(_) => Encoding::Srgb8,
            Colors::Srgb16(_) => Encoding::Srgb16,
            Colors::Linear(_) => Encoding::Linear,
        }
    }

    /// Adds the colours of further pixels, in the same encoding.
    pub(crate) fn append(&mut self, more: &Colors) {
        match (self, more) {
            (Colors::Srgb8(all), Colors::Srgb8(more)) => all.extend_from_slice(more),
            (Colors::Srgb16(all), Colors::Srgb16(more)) => all.extend_from_slice(more),
            (Colors::Linear(all), Colors::Linear(more)) => all.extend_from_slice(more),
            (other, more) => *other = more.clone(),
        }
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        match self {
            Colors::Srgb8(pixels) => pixels.len(),
            Colors::Srgb16(pixels) => pixels.len(),
            Colors::Linear(pixels) => pixels.len(),
        }
    }

    /// True where there is no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Encoding {
    /// Bytes of a pixel.
    pub fn pixel_bytes(self) -> usize {
        match self {
            Encoding::Srgb8 => size_of::<[u8; 3]>(),
            Encoding::Srgb16 => size_of::<[u16; 3]>(),
            Encoding::Linear => size_of::<[f32; 3]>(),
        }
    }
}

/// Pixels that one thread takes at least.
const PIXELS_AT_ONCE: usize = 1 << 14;
