//! NPY: a structured array of shape (H, W), so that `numpy.load` is all that a script needs.

use std::io;

use super::{Encoder, linear};
use crate::npy::Record;
use crate::rays::Pixels;
use crate::shade::Colors;
use crate::trace::Hits;

fn record(certificates: bool) -> Record {
    Record { rgb: true, level: certificates }
}

pub(super) fn pixel_bytes(certificates: bool) -> u128 {
    record(certificates).bytes() as u128
}

pub(super) fn begin(
    certificates: bool,
    pixels: &Pixels,
    out: &mut Vec<u8>,
) -> io::Result<Box<dyn Encoder>> {
    let record = record(certificates);
    record.write_header(&[pixels.height.into(), pixels.width.into()], out)?;
    Ok(Box::new(record))
}

impl Encoder for Record {
    fn rows(&mut self, hits: &Hits, colors: &Colors, out: &mut Vec<u8>) -> io::Result<()> {
        self.append(hits, 0..hits.id.len(), linear(colors), out);
        Ok(())
    }
}
