//! Units of length in the names of columns.

/// Factor of a unit of length, and whether it is divided by the Hubble parameter h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    /// Metres, or parsecs for astronomical units, as a mantissa and a power of ten.
    mantissa: f64,
    exponent: i32,
    per_h: bool,
}

/// Units of length: name, mantissa and power of ten, in metres. 1 au = 149 597 870 700 m and 1 pc = 648 000/π au (IAU 2012
/// resolution B2 and IAU 2015 resolution B2).
const UNITS: [(&str, f64, i32); 22] = [
    ("fm", 1.0, -15),
    ("pm", 1.0, -12),
    ("a", 1.0, -10),
    ("å", 1.0, -10),
    ("ang", 1.0, -10),
    ("angstrom", 1.0, -10),
    ("nm", 1.0, -9),
    ("um", 1.0, -6),
    ("µm", 1.0, -6),
    ("μm", 1.0, -6),
    ("micron", 1.0, -6),
    ("mm", 1.0, -3),
    ("cm", 1.0, -2),
    ("m", 1.0, 0),
    ("km", 1.0, 3),
    ("au", 1.495_978_707, 11),
    ("pc", PARSEC, 16),
    ("kpc", PARSEC, 19),
    ("mpc", PARSEC, 22),
    ("gpc", PARSEC, 25),
    ("in", 2.54, -2),
    ("ft", 3.048, -1),
];

/// Metres in a parsec, divided by 10¹⁶.
const PARSEC: f64 = 3.085_677_581_491_367_3;

impl Unit {
    /// Reads a unit of length such as `mm`, `Å` or `kpc/h`, in either case; `None` for any other text. `Mm` is a megametre.
    pub fn parse(text: &str) -> Option<Unit> {
        if text.trim() == "Mm" {
            return Some(Unit { mantissa: 1.0, exponent: 6, per_h: false });
        }
        let lower = text.trim().to_lowercase();
        let (name, per_h) = match lower.rsplit_once('/') {
            Some((name, h)) if h.trim() == "h" => (name.trim_end(), true),
            Some(_) => return None,
            None => match lower.strip_suffix("h^-1").or_else(|| lower.strip_prefix("h^-1")) {
                Some(name) => (name.trim(), true),
                None => (lower.as_str(), false),
            },
        };
        let known = |name: &str| UNITS.iter().find(|(known, ..)| *known == name);
        let found = known(name).or_else(|| known(name.strip_suffix('s')?));
        found.map(|&(_, mantissa, exponent)| Unit { mantissa, exponent, per_h })
    }

    /// Returns what numbers in this unit are multiplied by to be in `other`; `None` if only one of them is divided by h.
    pub fn factor_to(self, other: Unit) -> Option<Factor> {
        (self.per_h == other.per_h).then(|| Factor {
            mantissa: self.mantissa / other.mantissa,
            exponent: self.exponent - other.exponent,
        })
    }
}

/// A factor between two units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factor {
    mantissa: f64,
    exponent: i32,
}

impl Factor {
    /// No change.
    pub const ONE: Factor = Factor { mantissa: 1.0, exponent: 0 };

    /// Returns the number in the other unit. Between units that differ by a power of ten up to 10²², it is the f64 nearest to
    /// the exact product: such a power is an f64, and one rounding is left.
    #[inline]
    pub fn apply(self, number: f64) -> f64 {
        if self == Factor::ONE { number } else { self.convert(number) }
    }

    fn convert(self, number: f64) -> f64 {
        let number = if self.mantissa == 1.0 { number } else { number * self.mantissa };
        let power = libm::exp10(f64::from(self.exponent.abs()));
        match self.exponent {
            0 => number,
            1.. => number * power,
            _ => number / power,
        }
    }
}

/// Splits the name of a column into the name in lower case and its unit: `X [mm]`, `x(mm)` and `x / mm` are `x` in `mm`.
pub(super) fn name_and_unit(name: &str) -> (String, Option<&str>) {
    let name = name.trim();
    let of_bracket = |open: char, close: char| {
        let at = name.find(open).filter(|at| *at > 0)?;
        let inner = &name[at + 1..];
        Some((at, inner.split(close).next().unwrap_or_default()))
    };
    let of_slash = || {
        let at = name.find(" / ").filter(|at| *at > 0)?;
        Some((at, &name[at + 3..]))
    };
    let found = [of_bracket('[', ']'), of_bracket('(', ')'), of_slash()];
    match found.into_iter().flatten().min_by_key(|(at, _)| *at) {
        Some((at, unit)) => {
            let unit = Some(unit.trim()).filter(|unit| !unit.is_empty());
            (name[..at].trim_end().to_lowercase(), unit)
        }
        None => (name.to_lowercase(), None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_split_from_units() {
        for name in ["x [m]", "x(m)", "X / m", "x [m] (raw)", " x [ m ]"] {
            assert_eq!(name_and_unit(name), ("x".into(), Some("m")), "{name}");
        }
        for (name, plain) in
            [(" X ", "x"), ("(x)", "(x)"), ("x_m", "x_m"), ("a/b", "a/b"), ("Größe", "größe")]
        {
            assert_eq!(name_and_unit(name), (plain.into(), None));
        }
        assert_eq!(name_and_unit("x / Mpc/h").1, Some("Mpc/h"));
    }

    /// Compares with factors that are known from elsewhere.
    #[test]
    fn lengths_are_converted() {
        let convert = |number: f64, from: &str, to: &str| {
            let factor = Unit::parse(from).unwrap().factor_to(Unit::parse(to).unwrap());
            factor.map(|factor| factor.apply(number))
        };
        assert_eq!(convert(400.0, "mm", "m"), Some(0.4));
        assert_eq!(convert(0.3, "m", "mm"), Some(300.0));
        assert_eq!(convert(3.0, "Å", "nm"), Some(0.3));
        assert_eq!(convert(3.0, "Mm", "km"), Some(3000.0));
        assert_eq!(convert(3.0, "MM", "m"), Some(0.003));
        assert_eq!(convert(3.0, "µm", "micron"), Some(3.0));
        assert_eq!(convert(3.0, "μm", "microns"), Some(3.0));
        assert_eq!(convert(0.1, "Mpc/h", "kpc/h"), Some(100.0));
        assert_eq!(convert(1.0, "Mpc/h", "kpc"), None);
        assert_eq!(convert(1.0, "kpc h^-1", "kpc/h"), Some(1.0));
        let au = convert(1.0, "pc", "au").unwrap();
        assert!((au / (648_000.0 / std::f64::consts::PI) - 1.0).abs() < 1e-15, "{au}");
        for unknown in ["", "px", "m/s", "h", "lattice", "s"] {
            assert_eq!(Unit::parse(unknown), None, "{unknown}");
        }
    }
}
