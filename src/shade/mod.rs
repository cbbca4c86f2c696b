//! [`Hits`] → colours: the only place that knows what colour a hit has.

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

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::scene::{Color, Scene};
use crate::trace::Hits;
pub(crate) use exactly::{LitPoint, add_sample, mean_divisor};
pub use lamp::{Lamp, Lighting, Origin};
pub(crate) use mean::ExactMean;
pub use painter::{Background, ColorCounts, Painted, Painter, SamplePainter, Style};
pub(crate) use plain::{PlainPoint, PlainWay, plainly};

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

/// Gives hits the flat colours of their objects. Colours are encoded once an object, not once a
/// pixel.
///
/// ```
/// # use kugelblitz::{scene::{Color, Scene}, shade::{Colors, Encoding, Shader}, trace::Hits};
/// let scene = Scene { background: Color([0.0, 1.0, 0.0]), ..Scene::default() };
/// let mut colors = Colors::new(Encoding::Srgb8);
/// let hits = Hits { id: vec![0], ..Hits::default() };
/// Shader::new(&scene, Encoding::Srgb8).shade(&hits, &mut colors)?;
/// assert_eq!(colors, Colors::Srgb8(vec![[0, 255, 0]]));
/// # Ok::<(), kugelblitz::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Shader {
    /// By id; the background's first.
    palette: Colors,
}

impl Shader {
    /// A shader for the objects of `scene`.
    pub fn new(scene: &Scene, encoding: Encoding) -> Shader {
        let colors = scene.colors();
        Shader {
            palette: match encoding {
                Encoding::Srgb8 => Colors::Srgb8(colors.map(Color::to_srgb8).collect()),
                Encoding::Srgb16 => Colors::Srgb16(colors.map(Color::to_srgb16).collect()),
                Encoding::Linear => Colors::Linear(colors.map(Color::to_f32).collect()),
            },
        }
    }

    /// The numbers that it writes colours as.
    pub fn encoding(&self) -> Encoding {
        self.palette.encoding()
    }

    /// Bytes of memory for the colours of `n_objects` objects and for those of `n_pixels` pixels.
    pub fn bytes(encoding: Encoding, n_objects: usize, n_pixels: u64) -> u64 {
        let n_colors = n_pixels.saturating_add(n_objects as u64 + 1);
        n_colors.saturating_mul(encoding.pixel_bytes() as u64)
    }

    /// Replaces `colors` by those of the hits, one a hit, in this shader's encoding.
    ///
    /// # Errors
    /// [`Error::Device`] for an id that no object has.
    pub fn shade(&self, hits: &Hits, colors: &mut Colors) -> Result<()> {
        let largest_id = hits.id.iter().copied().max().unwrap_or(0);
        let n_colors = self.palette.len();
        if largest_id as usize >= n_colors {
            return Err(Error::Device(format!(
                "a pixel has the id {largest_id}, but the ids of this scene end at {}; the device \
                 gave a wrong answer: try --device cpu, and `kugelblitz probe` to look at it",
                n_colors - 1
            )));
        }
        let ids = &hits.id;
        match (&self.palette, colors) {
            (Colors::Srgb8(palette), Colors::Srgb8(out)) => look_up(palette, ids, out),
            (Colors::Srgb16(palette), Colors::Srgb16(out)) => look_up(palette, ids, out),
            (Colors::Linear(palette), Colors::Linear(out)) => look_up(palette, ids, out),
            (palette, other) => {
                *other = Colors::new(palette.encoding());
                return self.shade(hits, other);
            }
        }
        Ok(())
    }
}

fn look_up<T: Copy + Send + Sync>(palette: &[T], ids: &[u32], out: &mut Vec<T>) {
    ids.par_iter()
        .with_min_len(PIXELS_AT_ONCE)
        .map(|&id| palette[id as usize])
        .collect_into_vec(out);
}
