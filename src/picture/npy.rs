//! NPY: a structured array of shape (H, W), so that `numpy.load` is all that a script needs.

use std::io;

use super::hit_record::HitRecord;
use super::{Encoder, Metadata, NBytes, PictureOptions, linear};
use crate::error::Result;
use crate::lighting::Framebuffer;
use crate::rays::Pixels;

fn record(options: PictureOptions) -> HitRecord {
    HitRecord { rgb: true, alpha: options.transparent, level: options.certificates }
}

pub(super) fn n_bytes(
    options: PictureOptions,
    pixels: &Pixels,
    n_band_rows: u32,
) -> Result<NBytes> {
    let pixel = record(options).bytes() as u128;
    Ok(NBytes { pixel, band: u128::from(pixels.width) * u128::from(n_band_rows) * pixel })
}

pub(super) fn begin(
    options: PictureOptions,
    pixels: &Pixels,
    _: &Metadata,
    out: &mut Vec<u8>,
) -> io::Result<Box<dyn Encoder>> {
    let record = record(options);
    out.extend(record.header(&[pixels.height.into(), pixels.width.into()]));
    Ok(Box::new(record))
}

impl Encoder for HitRecord {
    fn rows(&mut self, rows: &Framebuffer, out: &mut Vec<u8>) -> io::Result<()> {
        let Framebuffer { hits, colors, coverage } = rows;
        self.append(hits, 0..hits.id.len(), linear(colors), coverage.as_ref(), out);
        Ok(())
    }
}
