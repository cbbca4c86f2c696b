//! Pictures that this program or another one wrote, as channels of numbers.

mod exr;
mod npy;
mod others;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::input;
use crate::lighting::Colors;
use crate::plain::Shown;
use crate::query::{Hits, StageCounts};
use crate::rays::Pixels;
use crate::support::memory;

pub use npy::channel_name;

/// A picture, or a list of results, as it was read from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// The name of the format.
    pub format: &'static str,
    /// Columns; of a list, its length.
    pub width: usize,
    /// Rows; of a list, 1.
    pub height: usize,
    /// True for an array with one axis: results of rays, not of pixels.
    pub is_list: bool,
    /// Columns and rows of the whole picture that this is a part of.
    pub whole: [usize; 2],
    /// Column and row of the first pixel in the whole picture.
    pub first: [i64; 2],
    /// The channels, in the order of the file. The fields of an array that this program wrote have the
    /// names of the channels of its OpenEXR files: `Z` for `t`, `N.X` … for `normal`, `R` … for `rgb`.
    pub channels: Vec<Channel>,
    /// What the file says of itself, in its own words.
    pub texts: Vec<(String, String)>,
}

/// One number of each pixel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The channel's name.
    pub name: String,
    /// The channel's numbers.
    pub samples: ChannelValues,
}

/// The numbers of a channel, in the type of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues {
    /// Whole numbers of 8 bits: of colours, 255 is full.
    U8(Vec<u8>),
    /// Whole numbers of 16 bits: of colours, 65535 is full.
    U16(Vec<u16>),
    /// Whole numbers of 32 bits.
    U32(Vec<u32>),
    /// Signed whole numbers of any length, and unsigned ones of 64 bits, of which those from 2^63 on
    /// are less than 0.
    I64(Vec<i64>),
    /// Floats of 16 bits.
    F16(Vec<f32>),
    /// Floats of 32 bits.
    F32(Vec<f32>),
    /// Floats of 64 bits.
    F64(Vec<f64>),
}

/// What an expression is of the numbers of a channel, of whatever type they are.
macro_rules! of_numbers {
    ($samples:expr, $all:ident => $of:expr) => {
        match $samples {
            ChannelValues::U8($all) => $of,
            ChannelValues::U16($all) => $of,
            ChannelValues::U32($all) => $of,
            ChannelValues::I64($all) => $of,
            ChannelValues::F16($all) | ChannelValues::F32($all) => $of,
            ChannelValues::F64($all) => $of,
        }
    };
}

impl ChannelValues {
    /// How many there are.
    pub fn len(&self) -> usize {
        of_numbers!(self, all => all.len())
    }

    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The type's name: `u8`, `f32`.
    pub fn kind(&self) -> &'static str {
        match self {
            ChannelValues::U8(_) => "u8",
            ChannelValues::U16(_) => "u16",
            ChannelValues::U32(_) => "u32",
            ChannelValues::I64(_) => "i64",
            ChannelValues::F16(_) => "f16",
            ChannelValues::F32(_) => "f32",
            ChannelValues::F64(_) => "f64",
        }
    }

    /// The number of the `i`-th pixel; all but those of 64 bits are exact.
    #[expect(clippy::unnecessary_cast, reason = "of all types but one")]
    pub fn number(&self, i: usize) -> f64 {
        of_numbers!(self, all => all[i] as f64)
    }

    /// The number of the `i`-th pixel where it is a whole one.
    pub fn whole(&self, i: usize) -> Option<i64> {
        match self {
            ChannelValues::I64(all) => Some(all[i]),
            _ => {
                let number = self.number(i);
                (number.fract() == 0.0 && number.abs() < 2f64.powi(62)).then_some(number as i64)
            }
        }
    }

    /// The largest number of a type of whole numbers that colours and depths fill.
    pub fn full(&self) -> Option<f64> {
        match self {
            ChannelValues::U8(_) => Some(u8::MAX.into()),
            ChannelValues::U16(_) => Some(u16::MAX.into()),
            ChannelValues::U32(_) => Some(u32::MAX.into()),
            _ => None,
        }
    }
}

/// Format, size, channels and metadata of a picture or of hits.
#[derive(Clone, Debug, Serialize)]
pub struct ImageFacts {
    /// Path of the file.
    pub file: String,
    /// Format of the file.
    pub format: &'static str,
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Left column, top row, width and height of a part; `null` for a whole picture.
    pub window: Option<[i64; 4]>,
    /// Width and height of the whole picture, pixels.
    pub whole: [usize; 2],
    /// Whether the file is an array with one axis, such as the hits of `trace`.
    pub is_list: bool,
    /// Channels, in the order of the file.
    pub channels: Vec<ChannelFacts>,
    /// Texts of the file that describe how it was made, by name.
    pub metadata: BTreeMap<String, String>,
    /// Number of pixels that each stage decided; `null` for a file without the channel `level`.
    pub levels: Option<StageCounts>,
}

/// Name and type of a channel.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelFacts {
    /// Name of the channel.
    pub name: String,
    /// Type of its numbers: `u8`, `f32` and the like.
    #[serde(rename = "type")]
    pub kind: &'static str,
}

impl Image {
    /// Creates the picture of these pixels from their colours, and from their hits if they are given.
    pub fn of_pixels(
        format: &'static str,
        pixels: &Pixels,
        colors: &Colors,
        hits: Option<&Hits>,
    ) -> Image {
        let mut channels = Vec::new();
        let mut add = |name: &str, samples: ChannelValues| {
            channels.push(Channel { name: name.into(), samples });
        };
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            let samples = match colors {
                Colors::Srgb8(all) => ChannelValues::U8(all.iter().map(|color| color[c]).collect()),
                Colors::Srgb16(all) => {
                    ChannelValues::U16(all.iter().map(|color| color[c]).collect())
                }
                Colors::Linear(all) => {
                    ChannelValues::F32(all.iter().map(|color| color[c]).collect())
                }
            };
            add(name, samples);
        }
        if let Some(hits) = hits {
            add("id", ChannelValues::U32(hits.id.clone()));
            add("Z", ChannelValues::F32(hits.t.clone()));
            for (axis, name) in ["N.X", "N.Y", "N.Z"].into_iter().enumerate() {
                let components = hits.normal.iter().map(|normal| normal[axis]);
                add(name, ChannelValues::F32(components.collect()));
            }
        }
        Image {
            format,
            width: pixels.width as usize,
            height: pixels.height as usize,
            whole: [pixels.image_width as usize, pixels.image_height as usize],
            first: [pixels.x.into(), pixels.y.into()],
            channels,
            ..Image::default()
        }
    }

    /// What the file at `path`, from which it was read, says of itself.
    pub fn facts(&self, path: &Path) -> ImageFacts {
        let ([width, height], [x, y]) = ([self.width, self.height], self.first);
        let is_part = self.whole != [width, height] || self.first != [0, 0];
        let of_channel =
            |c: &Channel| ChannelFacts { name: c.name.clone(), kind: c.samples.kind() };
        ImageFacts {
            file: path.display().to_string(),
            format: self.format,
            size: [width, height],
            window: is_part.then_some([x, y, width as i64, height as i64]),
            whole: self.whole,
            is_list: self.is_list,
            channels: self.channels.iter().map(of_channel).collect(),
            metadata: self.texts.iter().cloned().collect(),
            levels: self.stage_counts(),
        }
    }

    /// The channel of this name.
    pub fn channel(&self, name: &str) -> Option<&ChannelValues> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| &channel.samples)
    }

    /// Column and row of the `i`-th pixel.
    pub fn pixel(&self, i: usize) -> [usize; 2] {
        [i % self.width.max(1), i / self.width.max(1)]
    }

    /// How many pixels each stage decided, where the file has their levels.
    pub fn stage_counts(&self) -> Option<StageCounts> {
        let levels = self.channel("level")?;
        let mut counts = StageCounts::default();
        for i in 0..levels.len() {
            match levels.whole(i) {
                Some(0) => counts.f32 += 1,
                Some(1) => counts.f64 += 1,
                _ => counts.exact += 1,
            }
        }
        Some(counts)
    }

    /// Pixels, or results of a list.
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What the file says of itself under this name.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.texts.iter().find(|(of, _)| of == name).map(|(_, text)| text.as_str())
    }

    /// Reverses the order of the rows.
    pub fn flip_rows(&mut self) {
        for channel in &mut self.channels {
            of_numbers!(&mut channel.samples, all => {
                *all = all.chunks(self.width.max(1)).rev().flatten().copied().collect();
            });
        }
    }

    /// Reverses the order of the columns.
    pub fn flip_columns(&mut self) {
        for channel in &mut self.channels {
            of_numbers!(&mut channel.samples, all => {
                all.chunks_mut(self.width.max(1)).for_each(<[_]>::reverse);
            });
        }
    }
}

/// Reads a picture: PNG, PPM, OpenEXR and NPY, by this program or another one. The content tells the
/// format, not the name.
///
/// # Errors
/// Those of [`input::read_bytes`], [`Error::Input`] when it is no picture that can be read.
pub fn read_image(path: &Path) -> Result<Image> {
    let advice = "save it as a file, or give a smaller part of it";
    read_bytes(&input::read_bytes(path, "a picture that tells no length", advice)?, path)
}

/// Reads a picture from the bytes of its file, which errors call `path`.
///
/// # Errors
/// As [`read_image`].
pub fn read_bytes(bytes: &[u8], path: &Path) -> Result<Image> {
    let image = match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => exr::read(bytes, path),
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy::read(bytes, path),
        _ => others::read(bytes, path),
    }?;
    if image.is_empty() || image.channels.is_empty() {
        Err(wrong(path, "it holds no pixels"))
    } else {
        Ok(image)
    }
}

/// A file that is not what it should be.
fn wrong(path: &Path, message: impl Into<String>) -> Error {
    Error::Input { path: path.to_owned(), message: message.into() }
}

fn require(path: &Path, n_bytes: u64) -> Result<()> {
    memory::require(format!("{}: reading it", path.shown()), n_bytes, "give a smaller part of it")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_turned_over() {
        for (width, rows, expected) in [
            (2, vec![1, 2, 3, 4, 5, 6], vec![5, 6, 3, 4, 1, 2]),
            (3, vec![1, 2, 3, 4, 5, 6], vec![4, 5, 6, 1, 2, 3]),
            (1, vec![7], vec![7]),
            (0, vec![], vec![]),
        ] {
            let channel = Channel { name: "id".into(), samples: ChannelValues::U32(rows) };
            let mut image = Image { width, channels: vec![channel], ..Image::default() };
            image.flip_rows();
            assert_eq!(image.channel("id"), Some(&ChannelValues::U32(expected)));
        }
    }

    #[test]
    fn whole_numbers_are_told_from_others() {
        let floats = ChannelValues::F32(vec![3.0, 3.5, f32::NAN, f32::INFINITY, -1.0]);
        let whole: Vec<_> = (0..5).map(|i| floats.whole(i)).collect();
        assert_eq!(whole, [Some(3), None, None, None, Some(-1)]);
    }
}
