//! [`crate::query::Hits`] → colours: the only place that knows what colour a hit has.

mod baseline;
mod decide;
mod lit;
mod mean;
mod occluders;
mod pass;
mod quantized;
mod shading;
mod unlit;

use bytemuck::Zeroable;

use crate::error::{Error, Result};
pub use crate::prepare::{Lighting, PreparedLight};
use crate::query::resize;
use crate::support::parallel;
pub use baseline::{BaselinePoint, BaselineWay};
pub use lit::certified_lighting;
pub use mean::ExactMean;
use quantized::QuantizedPixels;
pub use shading::{Background, ColorCounts, Framebuffer, RenderStats, Shading, Style};
pub use unlit::Palette;

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
pub trait Pixel: Sized {
    /// How it is written.
    const ENCODING: Encoding;

    /// The pixels of colours that are written so.
    ///
    /// # Errors
    /// [`Error::Usage`] where they are written otherwise.
    fn all(colors: Colors) -> Result<Vec<Self>>;
}

/// Evaluates an expression with the pixels of some colours, however they are written.
macro_rules! of_any {
    ($colors:expr, $pixels:ident => $value:expr) => {
        match $colors {
            $crate::lighting::Colors::Srgb8($pixels) => $value,
            $crate::lighting::Colors::Srgb16($pixels) => $value,
            $crate::lighting::Colors::Linear($pixels) => $value,
        }
    };
}
use of_any;

macro_rules! encodings {
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
                    ).into())),
                }
            }
        })+

        impl Encoding {
            /// Bytes of a pixel.
            pub fn pixel_bytes(self) -> usize {
                match self {
                    $(Encoding::$encoding => size_of::<[$number; 3]>()),+
                }
            }
        }

        impl Colors {
            /// No colours yet.
            pub fn new(encoding: Encoding) -> Colors {
                match encoding {
                    $(Encoding::$encoding => Colors::$encoding(Vec::new())),+
                }
            }

            /// How they are written.
            pub fn encoding(&self) -> Encoding {
                match self {
                    $(Colors::$encoding(_) => Encoding::$encoding),+
                }
            }

            /// Adds the colours of further pixels, in the same encoding.
            pub(crate) fn append(&mut self, more: &Colors) {
                match (self, more) {
                    $((Colors::$encoding(all), Colors::$encoding(more)) => all.extend_from_slice(more),)+
                    (other, more) => *other = more.clone(),
                }
            }

            /// Replaces these by the colours that a palette has of ids; other ids have the first one.
            pub(crate) fn look_up(&mut self, palette: &Colors, ids: &[u32]) {
                match (self, palette) {
                    $((Colors::$encoding(out), Colors::$encoding(palette)) => {
                        look_up(out, palette, ids);
                    })+
                    (other, palette) => {
                        *other = Colors::new(palette.encoding());
                        other.look_up(palette, ids);
                    }
                }
            }
        }
    };
}

encodings!(u8 => Srgb8, u16 => Srgb16, f32 => Linear);

/// Pixels that mostly show one object.
const RUN: usize = 16;

/// Makes `out` the colours that a palette has of ids; other ids have the first one.
fn look_up<C: QuantizedPixels + Zeroable>(out: &mut Vec<[C; 3]>, palette: &[[C; 3]], ids: &[u32]) {
    let color = |id: u32| *palette.get(id as usize).unwrap_or(&palette[0]);
    let fill = |out: &mut [[C; 3]], ids: &[u32]| {
        out.iter_mut().zip(ids).for_each(|(out, &id)| *out = color(id));
    };
    resize(out, ids.len());
    let parts = out.chunks_mut(PIXELS_AT_ONCE).zip(ids.chunks(PIXELS_AT_ONCE));
    parallel::map(parts, |(out, ids)| {
        let (runs, rest) = out.as_chunks_mut::<RUN>();
        let (ids_of_runs, ids_of_rest) = ids.as_chunks::<RUN>();
        let (mut shown, mut run) = (0, [palette[0]; RUN]);
        for (out, ids) in runs.iter_mut().zip(ids_of_runs) {
            if ids.iter().fold(0, |differ, &id| differ | (id ^ ids[0])) != 0 {
                fill(out, ids);
                continue;
            }
            if ids[0] != shown {
                (shown, run) = (ids[0], [color(ids[0]); RUN]);
            }
            *out = run;
        }
        fill(rest, ids_of_rest);
    });
}

impl Colors {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        of_any!(self, pixels => pixels.len())
    }

    /// True where there is no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Pixels that one thread takes at least.
const PIXELS_AT_ONCE: usize = 1 << 14;
