//! The grammar of what may differ: `ids=0.01%,t=2ulp,levels=1,pixels=3`.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use kugelblitz::query::Kernel;
use kugelblitz::words::did_you_mean_at_end;
use kugelblitz::{Error, Result};

use super::{NormalError, TError};

/// How much of a thing may be wrong, or how far it may be off: at most so much, in a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// The number.
    pub most: f64,
    /// The unit of `most`.
    pub unit: LimitUnit,
}

/// The unit of a [`Tolerance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitUnit {
    /// Rays or pixels.
    Count,
    /// All of them.
    Share,
    /// f32 steps of `t`.
    Ulp,
    /// The exact `t`.
    Relative,
    /// Degrees of an angle.
    Degrees,
    /// The thing's own.
    Size,
}
use LimitUnit::{Count, Degrees, Relative, Share, Size, Ulp};

use crate::wrong_usage;

impl Tolerance {
    /// Whether an error may be so large.
    pub fn allows(self, size: f64) -> bool {
        match self.unit {
            Count | Share => size == 0.0,
            Ulp | Relative | Degrees | Size => size <= self.most,
        }
    }

    /// Whether so many of all may be wrong.
    pub fn allows_part(self, wrong: u64, all: u64) -> bool {
        match self.unit {
            Count => wrong as f64 <= self.most,
            Share => wrong as f64 <= self.most * all as f64,
            Ulp | Relative | Degrees | Size => wrong == 0,
        }
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Tolerance { most, unit } = *self;
        match unit {
            Share if most == 1.0 => f.write_str("any"),
            Ulp | Degrees | Size if most.is_infinite() => f.write_str("any"),
            Count | Size => write!(f, "{most}"),
            Share => write!(f, "{}%", most * 100.0),
            Ulp => write!(f, "{most}ulp"),
            Relative => write!(f, "{most:e}"),
            Degrees => f.write_str(&short(most)),
        }
    }
}

/// A key of [`Allowed`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AllowedKey {
    /// Wrong ids, away from silhouettes; at silhouettes as well, if [`AllowedKey::Silhouettes`] is not given.
    Ids,
    /// Wrong ids at silhouettes.
    Silhouettes,
    /// Error of `t`.
    T,
    /// Angle of a normal.
    Normal,
    /// Difference of whole numbers that are colours.
    Levels,
    /// Difference of floats, in steps of their type.
    Ulp,
    /// Difference of floats that are more steps apart.
    Difference,
    /// Pixels whose colours or other numbers may differ by more.
    Pixels,
}

/// The values that a key takes.
#[derive(Clone, Copy)]
struct Values {
    /// What may follow the number, with the unit, and how many of these numbers are one of it.
    suffixes: &'static [(&'static str, LimitUnit, f64)],
    /// The number that `any` is, in the first unit.
    any: f64,
    /// In words.
    expected: &'static str,
}

const SHARE: Values = Values {
    suffixes: &[("%", Share, 100.0), ("", Count, 1.0)],
    any: 1.0,
    expected: "a number of pixels, 0.01%, or any",
};
const T: Values = Values {
    suffixes: &[("ulp", Ulp, 1.0), ("%", Relative, 100.0), ("", Relative, 1.0)],
    any: f64::INFINITY,
    expected: "2ulp, 1e-6 (relative), or any",
};
const ANGLE: Values = Values {
    suffixes: &[("deg", Degrees, 1.0), ("°", Degrees, 1.0), ("", Degrees, 1.0)],
    any: f64::INFINITY,
    expected: "degrees, or any",
};
const SIZE: Values =
    Values { suffixes: &[("", Size, 1.0)], any: f64::INFINITY, expected: "0 or more, or any" };

/// Nothing may be wrong.
const NOTHING: Tolerance = Tolerance { most: 0.0, unit: Count };

/// Number of keys.
const N_KEYS: usize = 8;

/// The keys of hits, then those of colours and other numbers of pictures.
const KEYS: [(&str, AllowedKey, Values); N_KEYS] = [
    ("ids", AllowedKey::Ids, SHARE),
    ("silhouettes", AllowedKey::Silhouettes, SHARE),
    ("t", AllowedKey::T, T),
    ("normal", AllowedKey::Normal, ANGLE),
    ("levels", AllowedKey::Levels, SIZE),
    ("ulp", AllowedKey::Ulp, SIZE),
    ("difference", AllowedKey::Difference, SIZE),
    ("pixels", AllowedKey::Pixels, SHARE),
];

/// Number of keys of hits.
const N_OF_HITS: usize = 4;

impl Values {
    fn read(self, text: &str) -> Option<Tolerance> {
        if text == "any" {
            return Some(Tolerance { most: self.any, unit: self.suffixes[0].1 });
        }
        let mut suffixes = self.suffixes.iter();
        let (number, unit, n) =
            suffixes.find_map(|&(suffix, unit, n)| Some((text.strip_suffix(suffix)?, unit, n)))?;
        let most = number.trim().parse::<f64>().ok()? / n;
        let can_be = match unit {
            Count => most.fract() == 0.0,
            Share => most <= 1.0,
            Ulp | Relative | Degrees | Size => true,
        };
        (most >= 0.0 && can_be).then_some(Tolerance { most, unit })
    }
}

/// What a distance's or an exact `t`'s own rounding adds to an error: `t` is rounded to f64, the components of a
/// direction and its length take a few more roundings, together less than 2⁻⁵⁰ of a distance, and that is less than
/// 2⁻²⁶ of an f32 step.
const REFERENCE_ULP: f64 = 1.0 / (1u64 << 26) as f64;

/// What may differ: `ids=0.1%,t=1e-4,levels=1`.
///
/// The default of hits is what the kernel `certified` promises of itself: no wrong id, `t` the exact one rounded to f32, normals as
/// near as their rounded components. The default of colours and other numbers is no difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowed {
    limits: [Tolerance; N_KEYS],
    /// Whether each key was given.
    is_given: [bool; N_KEYS],
}

impl Default for Allowed {
    fn default() -> Allowed {
        let promised = Kernel::Certified.about().promise.exact;
        let (t_ulp, distance) = promised.map_or((0.0, 0.0), |p| (p.t_ulp, p.normal_distance));
        // The angle at which the ends of two unit vectors are so far apart.
        let degrees = (2.0 * (distance / 2.0).asin()).to_degrees();
        let mut limits = [NOTHING; N_KEYS];
        limits[AllowedKey::T as usize] = Tolerance { most: t_ulp, unit: Ulp };
        limits[AllowedKey::Normal as usize] = Tolerance { most: degrees, unit: Degrees };
        Allowed { limits, is_given: [false; N_KEYS] }
    }
}

impl FromStr for Allowed {
    type Err = Error;

    fn from_str(text: &str) -> Result<Allowed> {
        let mut allowed = Allowed::default();
        for part in text.split(',').filter(|_| !text.trim().is_empty()) {
            let (name, value) = part.split_once('=').unwrap_or((part, ""));
            let (name, value) = (name.trim(), value.trim());
            let Some(at) = KEYS.iter().position(|(known, ..)| *known == name) else {
                let names = KEYS.map(|(known, ..)| known);
                return wrong_usage(format!(
                    "nothing that can be allowed is called “{name}”; give {}{}",
                    names.join(", "),
                    did_you_mean_at_end(names, name)
                ));
            };
            let (_, _, values) = KEYS[at];
            let limit = values.read(value).ok_or_else(|| {
                Error::Usage(
                    format!("“{value}” is no limit for {name}; give {}", values.expected).into(),
                )
            })?;
            (allowed.limits[at], allowed.is_given[at]) = (limit, true);
        }
        if !allowed.is_given[AllowedKey::Silhouettes as usize] {
            allowed.limits[AllowedKey::Silhouettes as usize] = allowed.limit(AllowedKey::Ids);
        }
        Ok(allowed)
    }
}

impl Allowed {
    /// Returns the limit of a key.
    pub fn limit(&self, key: AllowedKey) -> Tolerance {
        self.limits[key as usize]
    }

    pub(super) fn set(&mut self, key: AllowedKey, limit: Tolerance) {
        self.limits[key as usize] = limit;
    }

    /// Returns the limits of hits as text, as they can be given.
    pub fn of_hits(&self) -> String {
        self.text(0..N_OF_HITS)
    }

    /// Returns the limits of colours and other numbers as text, as they can be given.
    pub fn of_pictures(&self) -> String {
        self.text(N_OF_HITS..N_KEYS)
    }

    fn text(&self, keys: Range<usize>) -> String {
        let part = |at: usize| format!("{}={}", KEYS[at].0, self.limits[at]);
        keys.map(part).collect::<Vec<_>>().join(",")
    }

    /// Refuses limits of what is not compared.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] for a limit of hits or of pictures that was given where these are not compared.
    pub fn check_used(&self, has_hits: bool, has_pictures: bool) -> Result<()> {
        for (at, (name, ..)) in KEYS.iter().enumerate() {
            let (is_used, what) = match at < N_OF_HITS {
                true => (has_hits, "hits are compared with those of a scene"),
                false => (has_pictures, "colours are compared"),
            };
            if self.is_given[at] && !is_used {
                return wrong_usage(format!("“{name}” can be allowed where {what}; leave it out"));
            }
        }
        Ok(())
    }

    /// Whether `t` may be so far off.
    pub fn allows_t(&self, error: &TError) -> bool {
        match self.limit(AllowedKey::T) {
            Tolerance { most, unit: Ulp } => error.ulp <= most + REFERENCE_ULP,
            limit => limit.allows(error.relative),
        }
    }

    /// Whether a normal may have this error: its angle is within the limit, and the difference of each component is at
    /// most [`Allowed::normal_component`].
    pub fn allows_normal(&self, error: &NormalError) -> bool {
        self.limit(AllowedKey::Normal).allows(error.degrees)
            && error.component <= self.normal_component()
    }

    /// Returns the largest allowed difference of a component of a normal: the chord of the allowed angle on the unit
    /// sphere. The ends of two unit vectors within the angle are at most a chord apart, so the component limit only rejects
    /// normals of another length.
    pub fn normal_component(&self) -> f64 {
        match self.limit(AllowedKey::Normal).most {
            most if most.is_infinite() => f64::INFINITY,
            most => 2.0 * (most.min(180.0).to_radians() / 2.0).sin(),
        }
    }
}

/// Three digits.
pub(crate) fn short(x: f64) -> String {
    match x {
        0.0 => "0".into(),
        x if !x.is_finite() => "∞".into(),
        x if (1e-3..1e6).contains(&x.abs()) => {
            let digits = (2 - x.abs().log10().floor() as i32).max(0) as usize;
            format!("{x:.digits$}")
        }
        x => format!("{x:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_tight() {
        let of = |most, unit| Tolerance { most, unit };
        for (limit, most) in [(of(3.0, Count), 3), (of(0.01, Share), 10), (of(9.0, Ulp), 0)] {
            assert!(limit.allows_part(most, 1000) && !limit.allows_part(most + 1, 1000));
        }
        for limit in [Ulp, Relative, Degrees, Size].map(|unit| of(2.0, unit)) {
            let over = 2f64.next_up();
            assert!(limit.allows(2.0) && !limit.allows(over) && !limit.allows(f64::NAN));
        }
        let allowed = Allowed::default();
        let t = |ulp| TError { ulp, relative: 0.0, is_nearest: false };
        assert!(allowed.allows_t(&t(0.5)) && !allowed.allows_t(&t(0.5001)));
        let allowed = "normal=60".parse::<Allowed>().unwrap();
        let normal = |degrees, component| NormalError {
            distance: component,
            degrees,
            component,
            length: 1.0,
            is_nearest: false,
        };
        assert!(allowed.allows_normal(&normal(60.0, 1.0 - 1e-9)));
        assert!(!allowed.allows_normal(&normal(60.1, 0.0)));
        assert!(!allowed.allows_normal(&normal(0.0, 1.0 + 1e-9)));
        assert!("normal=any".parse::<Allowed>().unwrap().allows_normal(&normal(180.0, 1e9)));
    }
}
