//! PPM: the binary variant P6, 8 or 16 bits.

use super::{Bits, Frame, be_bytes};
use crate::shade::Colors;

pub(super) fn begin(bits: Bits, frame: Frame, out: &mut Vec<u8>) {
    let largest_value = match bits {
        Bits::Eight => u8::MAX.into(),
        Bits::Sixteen => u16::MAX,
    };
    let header = format!("P6\n{} {}\n{largest_value}\n", frame.width, frame.height);
    out.extend_from_slice(header.as_bytes());
}

pub(super) fn rows(colors: &Colors, out: &mut Vec<u8>) {
    out.extend_from_slice(&be_bytes(colors));
}
