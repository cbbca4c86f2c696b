//! PPM: the binary variant P6, 8 or 16 bits.

use super::{Bits, ByteColors, Frame};
use crate::scene::Color;
use crate::trace::Hits;

pub(super) struct Ppm {
    colors: ByteColors,
}

impl Ppm {
    pub(super) fn begin(bits: Bits, frame: Frame, palette: &[Color], out: &mut Vec<u8>) -> Ppm {
        let largest_value = match bits {
            Bits::Eight => u8::MAX.into(),
            Bits::Sixteen => u16::MAX,
        };
        let header = format!("P6\n{} {}\n{largest_value}\n", frame.width, frame.height);
        out.extend_from_slice(header.as_bytes());
        Ppm { colors: ByteColors::new(bits, palette) }
    }

    pub(super) fn rows(&mut self, hits: &Hits, out: &mut Vec<u8>) {
        self.colors.append(&hits.id, out);
    }
}
