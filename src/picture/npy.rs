//! NPY: a structured array of shape (H, W), so that `numpy.load` is all that a script needs.

use std::io;

use super::Frame;
use crate::npy::Record;
use crate::trace::Hits;

pub(super) struct Npy {
    record: Record,
}

fn record(certificates: bool) -> Record {
    Record { rgb: true, level: certificates }
}

pub(super) fn pixel_bytes(certificates: bool) -> u128 {
    record(certificates).bytes() as u128
}

impl Npy {
    pub(super) fn begin(certificates: bool, frame: Frame, out: &mut Vec<u8>) -> io::Result<Npy> {
        let record = record(certificates);
        record.write_header(&[frame.height.into(), frame.width.into()], out)?;
        Ok(Npy { record })
    }

    pub(super) fn rows(&self, hits: &Hits, rgb: &[[f32; 3]], out: &mut Vec<u8>) {
        self.record.append(hits, 0..hits.id.len(), rgb, out);
    }
}
