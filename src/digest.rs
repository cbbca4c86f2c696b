//! One hash of a picture's exact content, in place of a reference picture and its tolerances.
//!
//! With the kernel `certified`, ids, `t` and colours are those that exact arithmetic gives, and normals have
//! the same bits everywhere, so that the hash is the same on every device, with every driver and number of
//! threads.
//!
//! # Version 1
//! SHA-256 of these bytes, each number little-endian:
//! 1. the text `kugelblitz digest 1` and a line feed;
//! 2. seven `u32`: width and height of the whole picture; left column, top row, width and height of the
//!    part that was traced; samples across a pixel;
//! 3. for each pixel of the part, row by row from the top: the id (`u32`), `t` (`f32`, +∞ on the background),
//!    the normal (three `f32`, zeros on the background, and 0 for −0), and red, green and blue (`u8`, sRGB).
//!
//! It is written as `kb1:` and 64 hexadecimal digits.

use std::fmt::Write;

use sha2::{Digest as _, Sha256};

use crate::rays::Pixels;
use crate::trace::Hits;

/// The text before the digits: it tells the version.
pub const PREFIX: &str = "kb1:";

const HEAD: &[u8] = b"kugelblitz digest 1\n";

/// Bytes of a pixel.
const PIXEL_BYTES: usize = 4 + 4 + 12 + 3;

/// A digest that is being made.
#[derive(Clone, Debug)]
pub struct Digest(Sha256);

impl Digest {
    /// The digest of a picture that has no rows yet.
    pub fn new(pixels: &Pixels, n_samples: u32) -> Digest {
        let &Pixels { image_width, image_height, x, y, width, height, .. } = pixels;
        let mut hash = Sha256::new_with_prefix(HEAD);
        for number in [image_width, image_height, x, y, width, height, n_samples] {
            hash.update(number.to_le_bytes());
        }
        Digest(hash)
    }

    /// Adds the next pixels, in order. `hits` must have surfaces.
    pub fn rows(&mut self, hits: &Hits, srgb8: &[[u8; 3]]) {
        let mut bytes = Vec::with_capacity(srgb8.len() * PIXEL_BYTES);
        let surfaces = hits.t.iter().zip(&hits.normal);
        for ((id, (t, normal)), color) in hits.id.iter().zip(surfaces).zip(srgb8) {
            bytes.extend(id.to_le_bytes());
            bytes.extend(t.to_le_bytes());
            normal.iter().for_each(|component| bytes.extend((component + 0.0).to_le_bytes()));
            bytes.extend(color);
        }
        self.0.update(&bytes);
    }

    /// The digest in words.
    pub fn finish(self) -> String {
        let mut text = PREFIX.to_string();
        for byte in self.0.finalize() {
            // A String takes all that is written to it.
            let _ = write!(text, "{byte:02x}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::rays::View;
    use crate::scene::Camera;

    fn pixels() -> Pixels {
        Pixels::whole(View::new(&Camera::new(DVec3::Z, DVec3::ZERO)), 2, 1)
    }

    fn hits() -> Hits {
        Hits {
            id: vec![7, 0],
            t: vec![1.5, f32::INFINITY],
            normal: vec![[0.0, -1.0, 0.5], [0.0; 3]],
            ..Hits::default()
        }
    }

    const COLORS: [[u8; 3]; 2] = [[1, 2, 3], [0, 0, 0]];

    fn digest(pixels: &Pixels, n_samples: u32, hits: &Hits, colors: &[[u8; 3]]) -> String {
        let mut digest = Digest::new(pixels, n_samples);
        digest.rows(hits, colors);
        digest.finish()
    }

    #[test]
    fn the_bytes_are_those_of_version_1() {
        let mut bytes = b"kugelblitz digest 1\n".to_vec();
        [2u32, 1, 0, 0, 2, 1, 1].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        bytes.extend([7, 0, 0, 0, 0, 0, 0xc0, 0x3f]);
        bytes.extend([0, 0, 0, 0, 0, 0, 0x80, 0xbf, 0, 0, 0, 0x3f, 1, 2, 3]);
        bytes.extend([0, 0, 0, 0, 0, 0, 0x80, 0x7f]);
        bytes.extend([0; 15]);
        let expected: String =
            Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(digest(&pixels(), 1, &hits(), &COLORS), format!("kb1:{expected}"));
    }

    #[test]
    fn rows_can_come_in_any_number_of_bands() {
        let mut digest_in_two = Digest::new(&pixels(), 1);
        let (all, one) = (hits(), |i: usize| Hits {
            id: vec![hits().id[i]],
            t: vec![hits().t[i]],
            normal: vec![hits().normal[i]],
            ..Hits::default()
        });
        digest_in_two.rows(&one(0), &COLORS[..1]);
        digest_in_two.rows(&one(1), &COLORS[1..]);
        assert_eq!(digest_in_two.finish(), digest(&pixels(), 1, &all, &COLORS));
    }

    /// Whatever differs is seen, but for the sign of 0 and the level that decided.
    #[test]
    fn each_difference_is_another_digest() {
        let honest = digest(&pixels(), 1, &hits(), &COLORS);
        type Sabotage = (&'static str, fn(&mut Hits));
        let sabotages: [Sabotage; 4] = [
            ("id", |hits| hits.id[1] = 1),
            ("t", |hits| hits.t[0] = hits.t[0].next_up()),
            ("normal", |hits| hits.normal[0][2] = hits.normal[0][2].next_up()),
            ("background", |hits| hits.t[1] = 0.0),
        ];
        for (what, spoil) in sabotages {
            let mut spoiled = hits();
            spoil(&mut spoiled);
            assert_ne!(digest(&pixels(), 1, &spoiled, &COLORS), honest, "{what}");
        }
        assert_ne!(digest(&pixels(), 1, &hits(), &[[1, 2, 4], [0; 3]]), honest, "a byte");
        assert_ne!(digest(&pixels(), 2, &hits(), &COLORS), honest, "samples");
        let part = Pixels { image_width: 3, ..pixels() };
        assert_ne!(digest(&part, 1, &hits(), &COLORS), honest, "a part of another picture");
        let mut same = hits();
        same.normal[0][0] = -0.0;
        same.level = vec![1, 2];
        assert_eq!(digest(&pixels(), 1, &same, &COLORS), honest);
    }
}
