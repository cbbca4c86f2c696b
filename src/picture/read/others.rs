//! What the crate `image` reads: PNG and PNM.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::super::metadata::window_of;
use super::{Channel, ChannelValues, Image, require, wrong};
use crate::error::{Error, Result};

/// What can be read, for messages.
const READABLE: &str = "PNG, OpenEXR, NPY and PPM can be read";

pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Image> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(Error::io(path))?;
    let format = match reader.format() {
        Some(ImageFormat::Png) => "PNG",
        Some(ImageFormat::Pnm) => "PNM",
        _ => return Err(wrong(path, format!("not a picture of a known format; {READABLE}"))),
    };
    // The memory is looked at here.
    reader.limits(Limits::no_limits());
    let unreadable = |error: ImageError| {
        wrong(path, format!("not a readable {format} file: {error}; {READABLE}"))
    };
    let decoder = reader.into_decoder().map_err(unreadable)?;
    require(path, decoder.total_bytes().saturating_mul(2))?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(unreadable)?;
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let channels = channels(&pixels)
        .ok_or_else(|| wrong(path, format!("its kind of pixels is not known; {READABLE}")))?;
    let texts = if format == "PNG" { texts_of_png(bytes) } else { Vec::new() };
    let (whole, first) = match window_of(&texts) {
        Some((whole, [x, y, w, h])) if [w, h] == [width as i64, height as i64] => (whole, [x, y]),
        _ => ([width, height], [0, 0]),
    };
    Ok(Image { format, width, height, whole, first, channels, texts, ..Image::default() })
}

/// The samples of each channel; grey ones are `Y`.
fn channels(pixels: &DynamicImage) -> Option<Vec<Channel>> {
    let names: &[&str] = match pixels.color().channel_count() {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let bytes = pixels.as_bytes();
    let channel = |(i, name): (usize, &&str)| {
        let samples = match usize::from(pixels.color().bytes_per_pixel()) / names.len() {
            1 => ChannelValues::U8(bytes.iter().skip(i).step_by(names.len()).copied().collect()),
            2 => {
                let numbers = bytes.as_chunks().0.iter().skip(i).step_by(names.len());
                ChannelValues::U16(numbers.map(|number| u16::from_ne_bytes(*number)).collect())
            }
            _ => return None,
        };
        Some(Channel { name: name.to_string(), samples })
    };
    names.iter().enumerate().map(channel).collect()
}

/// The texts of a PNG file; those that can't be read are left out.
fn texts_of_png(bytes: &[u8]) -> Vec<(String, String)> {
    let Ok(reader) = png::Decoder::new(Cursor::new(bytes)).read_info() else { return Vec::new() };
    let info = reader.info();
    let plain = info.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone()));
    let compressed = info.compressed_latin1_text.iter();
    let compressed = compressed.filter_map(|t| Some((t.keyword.clone(), t.get_text().ok()?)));
    let utf8 = info.utf8_text.iter();
    let utf8 = utf8.filter_map(|t| Some((t.keyword.clone(), t.get_text().ok()?)));
    plain.chain(compressed).chain(utf8).collect()
}
