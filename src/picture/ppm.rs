//! PPM: the binary variant P6, 8 or 16 bits.

use std::io;

use super::{ChannelBits, Encoder, Metadata, NBytes, PictureOptions, be_bytes, png};
use crate::error::Result;
use crate::lighting::Framebuffer;
use crate::rays::Pixels;

struct Ppm;

pub(super) fn n_bytes(
    options: PictureOptions,
    pixels: &Pixels,
    n_band_rows: u32,
) -> Result<NBytes> {
    let pixel = png::pixel_bytes(options);
    // For 16 bits, once more with the bytes swapped.
    Ok(NBytes { pixel, band: 2 * u128::from(pixels.width) * u128::from(n_band_rows) * pixel })
}

pub(super) fn begin(
    options: PictureOptions,
    pixels: &Pixels,
    _: &Metadata,
    out: &mut Vec<u8>,
) -> io::Result<Box<dyn Encoder>> {
    let largest_value = match options.bits {
        ChannelBits::Eight => u8::MAX.into(),
        ChannelBits::Sixteen => u16::MAX,
    };
    let header = format!("P6\n{} {}\n{largest_value}\n", pixels.width, pixels.height);
    out.extend_from_slice(header.as_bytes());
    Ok(Box::new(Ppm))
}

impl Encoder for Ppm {
    fn rows(&mut self, rows: &Framebuffer, out: &mut Vec<u8>) -> io::Result<()> {
        out.extend_from_slice(&be_bytes(rows));
        Ok(())
    }
}
