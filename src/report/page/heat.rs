//! Pictures as PNG in `data:` addresses; the colours of errors.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

use crate::report::{ErrorPicture, Fault, LightFault, LightPicture};

/// Errors of `t` up to the first are drawn in the first colour, from the second on in the last.
pub const ULP_RANGE: (f64, f64) = (0.5, 1e6);

/// Colours of the wrong ids. False hits lie on the page's own colour, and theirs is seen on light and dark.
pub use crate::judge::{FALSE_HIT, FALSE_MISS, WRONG_OBJECT};

/// A light that is left out: acne.
pub const FALSE_SHADOW: [u8; 3] = FALSE_HIT;
/// A light that is let in.
pub const LEAK: [u8; 3] = WRONG_OBJECT;

/// Bytes that are off by the first are drawn in the first colour, from the second on in the last.
pub const LEVEL_RANGE: (u8, u8) = (1, 64);

/// Small to large errors of `t`, evenly apart, as red, green, blue and opacity: a small error is
/// faint on a light and on a dark page.
pub const RAMP: [[u8; 4]; 3] =
    [[0x6a, 0xa6, 0xdd, 0x48], [0x41, 0x86, 0xcf, 0xa4], [0x1d, 0x5f, 0xb8, 0xff]];

/// Steps of the ramp in a picture, few enough for a small file.
const STEPS: f64 = 48.0;

/// The picture as a kernel shows it.
pub fn picture_data(picture: &ErrorPicture) -> Option<String> {
    encode([picture.width, picture.height], ColorType::Rgb, picture.srgb.as_flattened())
}

/// Its errors; the right background is transparent.
pub fn fault_data(picture: &ErrorPicture) -> Option<String> {
    let colors: Vec<[u8; 4]> = picture.faults.iter().map(fault_color).collect();
    encode([picture.width, picture.height], ColorType::Rgba, colors.as_flattened())
}

/// The picture as a kernel lights it.
pub fn light_data(picture: &LightPicture) -> Option<String> {
    encode([picture.width, picture.height], ColorType::Rgb, picture.srgb.as_flattened())
}

/// Its errors; what is right is transparent.
pub fn light_fault_data(picture: &LightPicture) -> Option<String> {
    let colors: Vec<[u8; 4]> = picture.faults.iter().map(light_fault_color).collect();
    encode([picture.width, picture.height], ColorType::Rgba, colors.as_flattened())
}

fn encode([width, height]: [u32; 2], color: ColorType, bytes: &[u8]) -> Option<String> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(bytes).ok()?;
    writer.finish().ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(file)))
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 0xff]
}

fn light_fault_color(fault: &LightFault) -> [u8; 4] {
    match *fault {
        LightFault::Right => [0; 4],
        LightFault::FalseShadow => opaque(FALSE_SHADOW),
        LightFault::Leak => opaque(LEAK),
        LightFault::Bytes { levels } => {
            let [low, high] = [LEVEL_RANGE.0, LEVEL_RANGE.1].map(|level| f64::from(level).log2());
            ramp(((f64::from(levels).log2() - low) / (high - low)).clamp(0.0, 1.0))
        }
    }
}

fn fault_color(fault: &Fault) -> [u8; 4] {
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
    fn each_fault_of_light_has_its_own_color() {
        let of = |levels| light_fault_color(&LightFault::Bytes { levels });
        assert_eq!(light_fault_color(&LightFault::Right)[3], 0, "transparent");
        assert_eq!((of(1), of(64), of(255)), (RAMP[0], RAMP[2], RAMP[2]));
        assert!(of(1)[3] < of(4)[3] && of(4)[3] < of(32)[3]);
        let [r, g, b] = FALSE_SHADOW;
        assert_eq!(light_fault_color(&LightFault::FalseShadow), [r, g, b, 0xff]);
        let [r, g, b] = LEAK;
        assert_eq!(light_fault_color(&LightFault::Leak), [r, g, b, 0xff]);
        assert_ne!(LEAK, FALSE_SHADOW);
    }

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
