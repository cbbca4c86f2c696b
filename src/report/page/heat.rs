//! Pictures as PNG in `data:` addresses; the colours of errors.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

use crate::report::{ErrorPicture, Fault};

/// Errors of `t` up to the first are drawn in the first colour, from the second on in the last.
pub const ULP_RANGE: (f64, f64) = (0.5, 1e6);

/// Colours of the wrong ids: far from each other and from the errors of `t` with each colour
/// blindness. False hits lie on the page's own colour, so theirs is seen on light and dark.
pub const FALSE_HIT: [u8; 3] = [0xc2, 0x2b, 0x00];
/// No object where there is one.
pub const FALSE_MISS: [u8; 3] = [0xff, 0x93, 0x30];
/// Another object.
pub const WRONG_OBJECT: [u8; 3] = [0xff, 0xe0, 0x4a];

/// Small to large errors of `t`, evenly apart, as red, green, blue and opacity: a small error is
/// faint on a light and on a dark page.
pub const RAMP: [[u8; 4]; 3] =
    [[0x6a, 0xa6, 0xdd, 0x48], [0x41, 0x86, 0xcf, 0xa4], [0x1d, 0x5f, 0xb8, 0xff]];

/// Steps of the ramp in a picture, few enough for a small file.
const STEPS: f64 = 48.0;

/// The picture as a kernel shows it.
pub fn picture_data(picture: &ErrorPicture) -> Option<String> {
    encode(picture, ColorType::Rgb, picture.srgb.as_flattened())
}

/// Its errors; the right background is transparent.
pub fn fault_data(picture: &ErrorPicture) -> Option<String> {
    let colors: Vec<[u8; 4]> = picture.faults.iter().map(fault_color).collect();
    encode(picture, ColorType::Rgba, colors.as_flattened())
}

fn encode(picture: &ErrorPicture, color: ColorType, bytes: &[u8]) -> Option<String> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, picture.width, picture.height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(bytes).ok()?;
    writer.finish().ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(file)))
}

fn fault_color(fault: &Fault) -> [u8; 4] {
    let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 0xff];
    match fault {
        Fault::Background => [0; 4],
        Fault::FalseHit => opaque(FALSE_HIT),
        Fault::FalseMiss => opaque(FALSE_MISS),
        Fault::WrongObject => opaque(WRONG_OBJECT),
        Fault::Right { t_ulp } => {
            let (low, high) = (ULP_RANGE.0.log10(), ULP_RANGE.1.log10());
            let share = ((t_ulp.log10() - low) / (high - low)).clamp(0.0, 1.0);
            ramp((share * STEPS).round() / STEPS)
        }
    }
}

/// The ramp's colour at 0 to 1.
fn ramp(share: f64) -> [u8; 4] {
    let place = share * (RAMP.len() - 1) as f64;
    let i = (place as usize).min(RAMP.len() - 2);
    let mix =
        |a: u8, b: u8| (f64::from(a) + (place - i as f64) * (f64::from(b) - f64::from(a))) as u8;
    std::array::from_fn(|channel| mix(RAMP[i][channel], RAMP[i + 1][channel]))
}

/// A colour for CSS, with its opacity if it has one.
pub fn css(color: &[u8]) -> String {
    let digits: String = color.iter().map(|channel| format!("{channel:02x}")).collect();
    format!("#{digits}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_has_its_own_color() {
        let right = |t_ulp| fault_color(&Fault::Right { t_ulp });
        let opacity = |t_ulp| right(t_ulp)[3];
        assert_eq!(fault_color(&Fault::Background)[3], 0, "transparent");
        assert_eq!([0.0, 0.3, 0.5].map(right), [RAMP[0]; 3]);
        assert!(opacity(0.5) < opacity(10.0) && opacity(10.0) < opacity(1e4));
        assert_eq!([1e6, 1e300, f64::INFINITY].map(right), [RAMP[2]; 3]);
        let wrong = [Fault::FalseHit, Fault::FalseMiss, Fault::WrongObject];
        for (fault, [r, g, b]) in wrong.iter().zip([FALSE_HIT, FALSE_MISS, WRONG_OBJECT]) {
            assert_eq!(fault_color(fault), [r, g, b, 0xff]);
        }
    }
}
