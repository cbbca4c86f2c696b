//! The records of hits in `.npy` files: of pictures, and of lists of rays.

use std::ops::Range;

use bytemuck::bytes_of;

use crate::npy;
use crate::query::{Coverage, Hits};

/// Layout of one record of a structured array of hits: `id` (u4), `t` (f4), `normal` (3f4), then the optional fields. Fields follow
/// each other without padding, in this machine's byte order, which is in the header.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitRecord {
    /// `rgb` (3f4): linear colour.
    pub rgb: bool,
    /// `a` (f4): alpha.
    pub alpha: bool,
    /// `level` (u1).
    pub level: bool,
}

impl HitRecord {
    /// Returns each field's name, type, number of components, and bytes.
    pub fn fields(self) -> impl Iterator<Item = (&'static str, &'static str, usize, usize)> {
        let fields = [
            (true, ("id", "u4", 1, 4)),
            (true, ("t", "f4", 1, 4)),
            (true, ("normal", "f4", 3, 12)),
            (self.rgb, ("rgb", "f4", 3, 12)),
            (self.alpha, ("a", "f4", 1, 4)),
            (self.level, ("level", "u1", 1, 1)),
        ];
        fields.into_iter().filter_map(|(is_there, field)| is_there.then_some(field))
    }

    /// Returns the bytes of a record.
    pub fn bytes(self) -> usize {
        self.fields().map(|(.., n_bytes)| n_bytes).sum()
    }

    /// Returns the header of an array of this `shape`.
    pub fn header(self, shape: &[u64]) -> Vec<u8> {
        let field = |(name, kind, n, n_bytes)| {
            let order = match n_bytes {
                1 => '|',
                _ if cfg!(target_endian = "big") => '>',
                _ => '<',
            };
            let shape = if n > 1 { format!(", ({n},)") } else { String::new() };
            format!("('{name}', '{order}{kind}'{shape}), ")
        };
        npy::header(&format!("[{}]", self.fields().map(field).collect::<String>()), shape)
    }

    /// Appends the records of the hits in `range`, which have every field of this layout. `rgb` are their linear colours, unused
    /// by a layout without `rgb`. Alpha is 1 without a coverage.
    pub fn append(
        self,
        hits: &Hits,
        range: Range<usize>,
        rgb: &[[f32; 3]],
        coverage: Option<&Coverage>,
        out: &mut Vec<u8>,
    ) {
        out.reserve(range.len() * self.bytes());
        for i in range {
            // Few copies: one of each number is several times slower.
            let [x, y, z] = hits.normal[i].map(f32::to_bits);
            out.extend_from_slice(bytes_of(&[hits.id[i], hits.t[i].to_bits(), x, y, z]));
            if self.rgb {
                out.extend_from_slice(bytes_of(&rgb[i]));
            }
            if self.alpha {
                let alpha = coverage.map_or(1.0, |coverage| coverage.alpha(i));
                out.extend_from_slice(bytes_of(&alpha));
            }
            if self.level {
                out.push(hits.level[i]);
            }
        }
    }
}
