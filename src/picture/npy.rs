//! NPY: a structured array of shape (H, W), so that `numpy.load` is all that a script needs.

use std::io;

use super::{Band, Encoder, PictureOptions, linear};
use crate::npy::Record;
use crate::rays::Pixels;

fn record(options: PictureOptions) -> Record {
    Record { rgb: true, alpha: options.transparent, level: options.certificates }
}

pub(super) fn pixel_bytes(options: PictureOptions) -> u128 {
    record(options).bytes() as u128
}

pub(super) fn begin(
    options: PictureOptions,
    pixels: &Pixels,
    out: &mut Vec<u8>,
) -> io::Result<Box<dyn Encoder>> {
    let record = record(options);
    record.write_header(&[pixels.height.into(), pixels.width.into()], out);
    Ok(Box::new(record))
}

impl Encoder for Record {
    fn rows(&mut self, band: &Band, out: &mut Vec<u8>) -> io::Result<()> {
        let &Band { hits, colors, coverage } = band;
        self.append(hits, 0..hits.id.len(), linear(colors), coverage, out);
        Ok(())
    }
}
