//! PPM: the binary variant P6, 8 or 16 bits.

use std::io;

use super::{Band, ChannelBits, Encoder, be_bytes};
use crate::rays::Pixels;

struct Ppm;

pub(super) fn begin(
    bits: ChannelBits,
    pixels: &Pixels,
    out: &mut Vec<u8>,
) -> io::Result<Box<dyn Encoder>> {
    let largest_value = match bits {
        ChannelBits::Eight => u8::MAX.into(),
        ChannelBits::Sixteen => u16::MAX,
    };
    let header = format!("P6\n{} {}\n{largest_value}\n", pixels.width, pixels.height);
    out.extend_from_slice(header.as_bytes());
    Ok(Box::new(Ppm))
}

impl Encoder for Ppm {
    fn rows(&mut self, band: &Band, out: &mut Vec<u8>) -> io::Result<()> {
        out.extend_from_slice(&be_bytes(band.colors));
        Ok(())
    }
}
