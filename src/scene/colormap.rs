//! Colour maps: 256 colours along a range of numbers.

use std::sync::Arc;

use super::Color;

/// A colour map, forwards or backwards: 256 colours of 8-bit sRGB, the same on every machine; viridis by default.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ColorMap {
    /// The place of the map in [`MAPS`].
    place: usize,
    is_reversed: bool,
    /// The colours of a map that is not in [`MAPS`].
    custom: Option<Arc<[[u8; 3]; ColorMap::LEN]>>,
}

/// Where the colours come from.
enum Base {
    Gradient(colorous::Gradient),
    /// Moreland's diverging map, blue to red.
    CoolWarm,
    /// Black to white in even steps of sRGB.
    Grey,
}

const MAPS: [(&str, Base); 18] = [
    ("viridis", Base::Gradient(colorous::VIRIDIS)),
    ("magma", Base::Gradient(colorous::MAGMA)),
    ("inferno", Base::Gradient(colorous::INFERNO)),
    ("plasma", Base::Gradient(colorous::PLASMA)),
    ("cividis", Base::Gradient(colorous::CIVIDIS)),
    ("turbo", Base::Gradient(colorous::TURBO)),
    ("blues", Base::Gradient(colorous::BLUES)),
    ("greens", Base::Gradient(colorous::GREENS)),
    ("oranges", Base::Gradient(colorous::ORANGES)),
    ("reds", Base::Gradient(colorous::REDS)),
    ("ylgnbu", Base::Gradient(colorous::YELLOW_GREEN_BLUE)),
    ("ylorrd", Base::Gradient(colorous::YELLOW_ORANGE_RED)),
    ("rdbu", Base::Gradient(colorous::RED_BLUE)),
    ("rdylbu", Base::Gradient(colorous::RED_YELLOW_BLUE)),
    ("puor", Base::Gradient(colorous::PURPLE_ORANGE)),
    ("spectral", Base::Gradient(colorous::SPECTRAL)),
    ("coolwarm", Base::CoolWarm),
    ("grey", Base::Grey),
];

impl ColorMap {
    /// Number of colours.
    pub const LEN: usize = 256;

    /// The names of all maps.
    pub fn names() -> impl Iterator<Item = &'static str> {
        MAPS.iter().map(|(name, _)| *name)
    }

    /// The map of a name in either case; `_r` at its end turns the map around.
    pub fn from_name(name: &str) -> Option<ColorMap> {
        let name = name.to_ascii_lowercase();
        let forwards = name.strip_suffix("_r");
        let base = forwards.unwrap_or(&name);
        let base = if base == "gray" { "grey" } else { base };
        let place = ColorMap::names().position(|known| known == base)?;
        Some(ColorMap { place, is_reversed: forwards.is_some(), custom: None })
    }

    /// Creates a map of these colours, 8-bit sRGB, from the low end to the high one. It has no name in a scene file.
    pub fn from_srgb8(colors: [[u8; 3]; ColorMap::LEN]) -> ColorMap {
        ColorMap { custom: Some(Arc::new(colors)), ..ColorMap::default() }
    }

    /// Returns the name, from which [`ColorMap::from_name`] gives the map again; `None` for
    /// [`ColorMap::from_srgb8`].
    pub fn known_name(&self) -> Option<String> {
        let known =
            || format!("{}{}", MAPS[self.place].0, if self.is_reversed { "_r" } else { "" });
        self.custom.is_none().then(known)
    }

    /// Returns the name, or "custom".
    pub fn name(&self) -> String {
        self.known_name().unwrap_or("custom".into())
    }

    /// The colours from the low end to the high one, 8-bit sRGB.
    pub fn srgb8(&self) -> [[u8; 3]; ColorMap::LEN] {
        if let Some(colors) = &self.custom {
            return **colors;
        }
        let color = |i| match MAPS[self.place].1 {
            Base::Gradient(gradient) => gradient.eval_rational(i, ColorMap::LEN).as_array(),
            Base::CoolWarm => cool_warm(i as f64 / (ColorMap::LEN - 1) as f64),
            Base::Grey => [i as u8; 3],
        };
        let mut colors = std::array::from_fn(color);
        if self.is_reversed {
            colors.reverse();
        }
        colors
    }

    /// The colours from the low end to the high one.
    pub(super) fn colors(&self) -> [Color; ColorMap::LEN] {
        self.srgb8().map(Color::from_srgb8)
    }
}

/// Moreland's map "smooth cool warm" at `t` from 0 to 1: K. Moreland, "Diverging color maps for
/// scientific visualization", ISVC 2009. Both ends have one magnitude and saturation in the polar form
/// Msh of CIE L*a*b*, and meet in a colour without saturation, whose hue is turned so that the way
/// there is as straight as can be.
fn cool_warm(t: f64) -> [u8; 3] {
    /// Magnitude, saturation and hue of the blue and the red end, (59, 76, 192) and (180, 4, 38).
    const ENDS: [[f64; 3]; 2] = [[80.0, 1.08, -1.1], [80.0, 1.08, 0.5]];
    /// Magnitude in the middle.
    const MIDDLE: f64 = 88.0;
    let [magnitude, saturation, hue] = ENDS[usize::from(t > 0.5)];
    // From 0 in the middle to 1 at the end.
    let out = (2.0 * t - 1.0).abs();
    let spin = {
        let growth = libm::sqrt(MIDDLE * MIDDLE - magnitude * magnitude);
        saturation * growth / (magnitude * libm::sin(saturation)) * hue.signum()
    };
    let m = MIDDLE + out * (magnitude - MIDDLE);
    let s = out * saturation;
    let h = hue + (1.0 - out) * spin;
    let lab = [m * libm::cos(s), m * libm::sin(s) * libm::cos(h), m * libm::sin(s) * libm::sin(h)];
    Color(linear_from_lab(lab)).to_srgb8()
}

/// Linear sRGB of a colour in CIE L*a*b* under the white D65.
fn linear_from_lab([l, a, b]: [f64; 3]) -> [f64; 3] {
    const WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];
    let y = (l + 16.0) / 116.0;
    let cube = |f: f64| if f > 6.0 / 29.0 { f * f * f } else { (f - 16.0 / 116.0) / 7.787 };
    let [x, y, z] = [y + a / 500.0, y, y - b / 200.0].map(cube);
    let [x, y, z] = [x * WHITE[0], y * WHITE[1], z * WHITE[2]];
    // The matrix of IEC 61966-2-1.
    [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ]
}

#[cfg(test)]
mod tests {
    use sha2::{Digest, Sha256};

    use super::*;

    fn of(name: &str) -> [[u8; 3]; ColorMap::LEN] {
        ColorMap::from_name(name).unwrap().srgb8()
    }

    #[test]
    fn names_lead_to_maps_and_back() {
        for name in ColorMap::names() {
            let map = ColorMap::from_name(name).unwrap();
            assert_eq!(map.name(), name);
            let reversed = ColorMap::from_name(&format!("{}_R", name.to_uppercase())).unwrap();
            assert_eq!(reversed.name(), format!("{name}_r"));
            let mut colors = reversed.srgb8();
            colors.reverse();
            assert_eq!(colors, map.srgb8());
        }
        assert_eq!(ColorMap::from_name("gray"), ColorMap::from_name("grey"));
        assert_eq!(ColorMap::from_name("viridis"), Some(ColorMap::default()));
        for wrong in ["", "_r", "viridis_r_r", "jet", "custom"] {
            assert_eq!(ColorMap::from_name(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn colours_of_a_user_are_a_map_without_a_known_name() {
        let colors = std::array::from_fn(|i| [i as u8, 255 - i as u8, 40]);
        let map = ColorMap::from_srgb8(colors);
        assert_eq!(map.srgb8(), colors);
        assert_eq!((map.known_name(), &*map.name()), (None, "custom"));
        assert_eq!(map, ColorMap::from_srgb8(colors));
        assert_ne!(map, ColorMap::default());
    }

    /// Values that the maps' authors publish: the ends of viridis and magma, all that makes up
    /// Moreland's map at eighths.
    #[test]
    fn maps_are_those_that_are_known_by_their_names() {
        let near = |found: [u8; 3], known: [u8; 3]| {
            let fine = found.iter().zip(known).all(|(found, known)| found.abs_diff(known) <= 2);
            assert!(fine, "{found:?} for {known:?}");
        };
        near(of("viridis")[0], [0x44, 0x01, 0x54]);
        near(of("viridis")[255], [0xfd, 0xe7, 0x25]);
        near(of("magma")[0], [0x00, 0x00, 0x04]);
        near(of("magma")[255], [0xfc, 0xfd, 0xbf]);
        assert_eq!([of("grey")[0], of("grey")[128], of("grey")[255]], [[0; 3], [128; 3], [255; 3]]);
        let known = [
            (0, [59, 76, 192]),
            (32, [98, 130, 234]),
            (64, [141, 176, 254]),
            (96, [184, 208, 249]),
            (128, [221, 221, 221]),
            (160, [245, 196, 173]),
            (192, [244, 154, 123]),
            (224, [222, 96, 77]),
            (255, [180, 4, 38]),
        ];
        for (place, color) in known {
            near(of("coolwarm")[place], color);
        }
    }

    /// Pictures are made of these bytes: a change of one of them changes pictures.
    #[test]
    fn maps_keep_their_bytes() {
        let mut all = Sha256::new();
        for name in ColorMap::names() {
            all.update(of(name).as_flattened());
        }
        let digest =
            all.finalize().iter().fold(String::new(), |hex, byte| format!("{hex}{byte:02x}"));
        assert_eq!(digest, "fd0d206009e17d8e71af5aa78ced7d55d5cddd845c0572a8f0a18cc6d83537ef");
    }
}
