//! Ids as colours and back.

use std::io::Cursor;

use crate::scene::Color;

/// The most objects whose ids have colours: 24 bits, less black and the background.
pub const MAX_OBJECTS: usize = (1 << 24) - 2;

/// In place of an id where the colour is that of no object. No scene has that many objects.
pub const NO_OBJECT: u32 = u32::MAX;

/// The multiplier of [`code`]: 2²⁴ divided by the golden ratio, odd, so that it has an inverse.
const STEP: u32 = 0x9e_3779;

const MASK: u32 = (1 << 24) - 1;

/// `STEP·STEP_INVERSE = 1` modulo 2²⁴. Newton's iteration doubles the bits that are right; an odd
/// number is its own inverse modulo 8.
const STEP_INVERSE: u32 = {
    let (mut inverse, mut n_bits) = (STEP, 3);
    while n_bits < 24 {
        inverse = inverse.wrapping_mul(2u32.wrapping_sub(STEP.wrapping_mul(inverse)));
        n_bits *= 2;
    }
    inverse & MASK
};

/// A permutation of the numbers of 24 bits that leaves 0 in its place and scatters small ones: a
/// mixture of two codes is then no third one, which multiples alone would be.
fn code(number: u32) -> u32 {
    let once = fold(fold(number).wrapping_mul(STEP) & MASK);
    fold(once.wrapping_mul(STEP) & MASK)
}

/// The inverse of [`code`].
fn number(code: u32) -> u32 {
    let once = fold(fold(code).wrapping_mul(STEP_INVERSE) & MASK);
    fold(once.wrapping_mul(STEP_INVERSE) & MASK)
}

/// The upper 12 of 24 bits over the lower: its own inverse.
fn fold(number: u32) -> u32 {
    number ^ (number >> 12)
}

/// The colour of an id. Black, what is not lit or not drawn, is no object's.
pub fn color(id: u32) -> Color {
    let [_, r, g, b] = code(id.wrapping_add(1) & MASK).to_be_bytes();
    Color::from_srgb8([r, g, b])
}

fn id([r, g, b]: [u8; 3], n_objects: usize) -> u32 {
    let id = number(u32::from_be_bytes([0, r, g, b])).wrapping_sub(1);
    if id as usize <= n_objects { id } else { NO_OBJECT }
}

/// The ids of a PNG of `size` pixels, row by row.
///
/// # Errors
/// What is wrong with the picture.
pub fn ids(png: &[u8], size: [u32; 2], n_objects: usize) -> Result<Vec<u32>, String> {
    let mut decoder = png::Decoder::new(Cursor::new(png));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let found = [reader.info().width, reader.info().height];
    if found != size {
        let ([w, h], [width, height]) = (found, size);
        return Err(format!("it has {w}x{h} pixels, not {width}x{height}"));
    }
    let n_bytes = reader.output_buffer_size().ok_or("it is too large")?;
    let mut bytes = vec![0; n_bytes];
    let frame = reader.next_frame(&mut bytes).map_err(|error| error.to_string())?;
    let n_samples = frame.color_type.samples();
    if !matches!(frame.color_type, png::ColorType::Rgb | png::ColorType::Rgba) {
        return Err(format!("its pixels are {:?}, not RGB", frame.color_type));
    }
    let pixels = bytes[..frame.buffer_size()].chunks_exact(n_samples);
    Ok(pixels.map(|pixel| id([pixel[0], pixel[1], pixel[2]], n_objects)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rgb(id: u32) -> [u8; 3] {
        color(id).to_srgb8()
    }

    /// A PNG of one row.
    fn row(pixels: &[[u8; 3]]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, pixels.len() as u32, 1);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(pixels.as_flattened()).unwrap();
        writer.finish().unwrap();
        bytes
    }

    #[test]
    fn every_id_comes_back() {
        let last = MAX_OBJECTS as u32;
        for low in (0..=last).step_by(4099).chain([last - 1, last]) {
            assert_eq!(id(rgb(low), MAX_OBJECTS), low);
        }
        let pixels: Vec<_> = [0, 3, 1, 2].map(rgb).into();
        assert_eq!(ids(&row(&pixels), [4, 1], 3), Ok(vec![0, 3, 1, 2]));
    }

    #[test]
    fn sabotage_is_noticed() {
        // The colour of an object that the scene does not have, of none, and one bit off.
        let [r, g, b] = rgb(2);
        for wrong in [rgb(4), [0; 3], [255; 3], [r ^ 1, g, b], [r, g ^ 1, b], [r, g, b ^ 1]] {
            assert_eq!(ids(&row(&[wrong, rgb(1)]), [2, 1], 3), Ok(vec![NO_OBJECT, 1]), "{wrong:?}");
        }
        assert_eq!(id([0; 3], MAX_OBJECTS), NO_OBJECT, "black");
    }

    /// As anti-aliasing mixes them, in equal parts.
    #[test]
    fn a_mixture_of_two_colours_is_none() {
        let n_objects = 100;
        let mut n_taken = 0;
        for a in 0..=n_objects {
            for b in 0..a {
                let (rgb_a, rgb_b) = (rgb(a), rgb(b));
                let mixed = std::array::from_fn(|i| rgb_a[i].midpoint(rgb_b[i]));
                n_taken += u32::from(id(mixed, n_objects as usize) != NO_OBJECT);
            }
        }
        assert_eq!(n_taken, 0);
    }

    #[test]
    fn what_is_no_picture_is_told() {
        let error = |bytes: &[u8], size| ids(bytes, size, 3).unwrap_err();
        let picture = row(&[rgb(0), rgb(1)]);
        assert_eq!(error(&picture, [1, 2]), "it has 2x1 pixels, not 1x2");
        assert!(!error(&picture[..picture.len() / 2], [2, 1]).is_empty());
        assert!(!error(b"P6\n2 1\n255\n", [2, 1]).is_empty());
        let mut gray = Vec::new();
        let encoder = png::Encoder::new(&mut gray, 1, 1);
        encoder.write_header().unwrap().write_image_data(&[7]).unwrap();
        assert_eq!(error(&gray, [1, 1]), "its pixels are Grayscale, not RGB");
    }
}
