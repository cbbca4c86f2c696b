//! Linear colour and its sRGB encoding: the only home of the transfer function.

use super::QuantizationTable;

/// Linear RGB, each component in `0..=1`; black by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Color(pub [f64; 3]);

impl From<[f64; 3]> for Color {
    fn from(linear: [f64; 3]) -> Color {
        Color(linear)
    }
}

impl From<[f32; 3]> for Color {
    fn from(linear: [f32; 3]) -> Color {
        Color(linear.map(f64::from))
    }
}

/// The names of CSS Color Module Level 4 in lower case, in their order, each with its colour.
const NAMES: &str = include_str!("css_colors.txt");

fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
    NAMES.lines().filter_map(|line| line.split_once(' '))
}

impl Color {
    /// Black: the default background.
    pub const BLACK: Color = Color([0.0; 3]);

    /// The linear colour of 8-bit sRGB; [`Color::to_srgb8`] gives the same bytes back.
    pub fn from_srgb8(srgb: [u8; 3]) -> Color {
        Color(srgb.map(|byte| linear_from_srgb(f64::from(byte) / 255.0)))
    }

    /// Reads a colour as scene files and the command line name it: `#rrggbb` (sRGB, either case), its short form `#rgb`,
    /// in which each digit stands for two, or a name of CSS in either case; `None` for any other text.
    ///
    /// ```
    /// use kugelblitz::scene::Color;
    ///
    /// assert_eq!(Color::parse("#f80"), Color::parse("#ff8800"));
    /// assert_eq!(Color::parse("SteelBlue"), Some(Color::from_srgb8([70, 130, 180])));
    /// assert_eq!(Color::parse("stelblue"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Color> {
        let Some(digits) = text.strip_prefix('#') else {
            let (_, hex) = names().find(|(name, _)| name.eq_ignore_ascii_case(text))?;
            return Color::parse(hex);
        };
        if digits.chars().count() == 3 {
            let twice: String = digits.chars().flat_map(|digit| [digit, digit]).collect();
            return Color::parse(&format!("#{twice}"));
        }
        if digits.len() != 6 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return None;
        }
        let [_, red, green, blue] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
        Some(Color::from_srgb8([red, green, blue]))
    }

    /// The names of CSS, in lower case.
    pub(super) fn css_names() -> impl Iterator<Item = &'static str> {
        names().map(|(name, _)| name)
    }

    /// 8-bit sRGB: the bytes whose ranges hold the components, by their [`QuantizationTable`].
    pub fn to_srgb8(self) -> [u8; 3] {
        self.0.map(|linear| QuantizationTable::srgb8().number(linear) as u8)
    }

    /// 16-bit sRGB: the numbers whose ranges hold the components, by their [`QuantizationTable`].
    pub fn to_srgb16(self) -> [u16; 3] {
        self.0.map(|linear| QuantizationTable::srgb16().number(linear))
    }
}

/// `#rrggbb`, as [`Color::parse`] reads it.
pub fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The sRGB transfer function (IEC 61966-2-1): linear light to encoded value, both in `0..=1`. The
/// same f64 on every machine.
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// The inverse of [`srgb_from_linear`].
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// The linear parts of all bytes in sRGB.
pub fn linear_of_bytes() -> [f64; 256] {
    std::array::from_fn(|byte| linear_from_srgb(byte as f64 / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_bytes_come_back() {
        for byte in 0..=255u8 {
            let color = Color::from_srgb8([byte, 255 - byte, byte]);
            assert_eq!(color.to_srgb8(), [byte, 255 - byte, byte]);
            // 257 = 65535 / 255, so the 16-bit code of a byte is a whole number.
            let wide = u16::from(byte) * 257;
            assert_eq!(color.to_srgb16(), [wide, 65535 - wide, wide]);
        }
    }

    #[test]
    fn known_values_of_the_standard() {
        // Values of the transfer function that stand outside this code: IEC 61966-2-1's ends and
        // break, and the well-known middle grey (#808080 is 21.6 % linear light).
        assert_eq!(Color::from_srgb8([0, 255, 0]), Color([0.0, 1.0, 0.0]));
        assert!((linear_from_srgb(128.0 / 255.0) - 0.215_860_5).abs() < 1e-7);
        assert!((linear_from_srgb(10.0 / 255.0) - 10.0 / 255.0 / 12.92).abs() < 1e-15);
        assert!((srgb_from_linear(0.5) - 0.735_356_98).abs() < 1e-8);
    }

    #[test]
    fn out_of_range_is_clamped() {
        let color = Color([-0.5, 1.5, f64::NAN]);
        assert_eq!(color.to_srgb8(), [0, 255, 0]);
        assert_eq!(color.to_srgb16(), [0, 65535, 0]);
    }

    #[test]
    fn hex() {
        assert_eq!(Color::parse("#d62728"), Some(Color::from_srgb8([0xd6, 0x27, 0x28])));
        assert_eq!(Color::parse("#D62728"), Color::parse("#d62728"));
        for wrong in ["", "#", "d62728", "#d6272", "#d627288", "#g62728", "#+62728", "#é2728"] {
            assert_eq!(Color::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn names_and_short_forms() {
        let of = |bytes| Some(Color::from_srgb8(bytes));
        for (text, bytes) in [
            ("red", [255, 0, 0]),
            ("RebeccaPurple", [102, 51, 153]),
            ("grey", [128, 128, 128]),
            ("lightgoldenrodyellow", [250, 250, 210]),
            ("#fa0", [255, 170, 0]),
            ("#FA0", [255, 170, 0]),
            ("#d62728", [0xd6, 0x27, 0x28]),
        ] {
            assert_eq!(Color::parse(text), of(bytes), "{text}");
        }
        for wrong in [
            "",
            "#",
            "#ff",
            "#ffff",
            "#é1",
            "#é12",
            "#+12",
            "transparent",
            "rgb(1,2,3)",
            "ff0000",
            "rad",
        ] {
            assert_eq!(Color::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn each_name_of_css_is_there_once() {
        assert_eq!((NAMES.lines().count(), names().count()), (148, 148));
        assert!(names().map(|(name, _)| name).is_sorted_by(|one, next| one < next));
        for (name, hex) in names() {
            assert!(name.bytes().all(|byte| byte.is_ascii_lowercase()), "{name}");
            assert_eq!(Color::parse(name), Some(Color::parse(hex).unwrap()), "{name}");
        }
    }

    #[test]
    fn misspelt_names() {
        let near = |text| crate::words::did_you_mean(Color::css_names(), text);
        assert_eq!(near("stealblue"), Some("steelblue"));
        assert_eq!(near("Gren"), Some("green"));
        assert_eq!(near("magneta"), Some("magenta"));
        assert_eq!(near("dim"), Some("dimgray"));
        for far in ["", "q", "#ff", &"x".repeat(1000)] {
            assert_eq!(near(far), None, "{far}");
        }
    }
}
