//! The grammar of what may differ: `ids=0.01%,t=2ulp`, `levels=1,pixels=3`.

use std::fmt;

use kugelblitz::trace::Kernel;
use kugelblitz::words::did_you_mean_at_end;
use kugelblitz::{Error, Result};

use super::{NormalError, TError};

/// How much of a thing may be wrong, or how far it may be off: at most so much, in a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// The number.
    pub most: f64,
    /// The unit of `most`.
    pub unit: Unit,
}

/// The unit of a [`Tolerance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
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
use Unit::{Count, Degrees, Relative, Share, Size, Ulp};

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
            Ulp | Degrees if most.is_infinite() => f.write_str("any"),
            Count | Size => write!(f, "{most}"),
            Share => write!(f, "{}%", most * 100.0),
            Ulp => write!(f, "{most}ulp"),
            Relative => write!(f, "{most:e}"),
            Degrees => f.write_str(&short(most)),
        }
    }
}

/// The values that a key takes.
#[derive(Clone, Copy)]
struct Values {
    /// What may follow the number, with the unit, and how many of these numbers are one of it.
    suffixes: &'static [(&'static str, Unit, f64)],
    /// The number that `any` is, in the first unit.
    any: Option<f64>,
    /// In words.
    expected: &'static str,
}

const SHARE: Values = Values {
    suffixes: &[("%", Share, 100.0), ("", Count, 1.0)],
    any: Some(1.0),
    expected: "a number of pixels, 0.01%, or any",
};
const T: Values = Values {
    suffixes: &[("ulp", Ulp, 1.0), ("%", Relative, 100.0), ("", Relative, 1.0)],
    any: Some(f64::INFINITY),
    expected: "2ulp, 1e-6 (relative), or any",
};
const ANGLE: Values = Values {
    suffixes: &[("deg", Degrees, 1.0), ("°", Degrees, 1.0), ("", Degrees, 1.0)],
    any: Some(f64::INFINITY),
    expected: "degrees, or any",
};
const SIZE: Values = Values { suffixes: &[("", Size, 1.0)], any: None, expected: "0 or more" };

/// Nothing may be wrong.
const NOTHING: Tolerance = Tolerance { most: 0.0, unit: Count };

/// Keys of four limits.
type Keys = [(&'static str, Values); 4];

/// The keys of rays.
const OF_RAYS: Keys = [("ids", SHARE), ("silhouettes", SHARE), ("t", T), ("normal", ANGLE)];

/// The keys of pictures.
const OF_PICTURES: Keys =
    [("levels", SIZE), ("ulp", SIZE), ("difference", SIZE), ("pixels", SHARE)];

impl Values {
    fn read(self, text: &str) -> Option<Tolerance> {
        if text == "any" {
            return self.any.map(|most| Tolerance { most, unit: self.suffixes[0].1 });
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

/// What may differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowed {
    keys: [&'static str; 4],
    limits: [Tolerance; 4],
}

impl Allowed {
    /// What may differ of rays, as `ids=0.01%,silhouettes=5%,t=2ulp,normal=0.1` says, each of them or not. What `ids` allows
    /// holds at silhouettes as well, where nothing else is said of them. Without a word it is what the kernel `certified`
    /// promises of itself: no wrong id, `t` the exact one rounded to f32, normals as near as their rounded components.
    ///
    /// # Errors
    /// [`Error::Usage`] for other words.
    pub fn of_rays(text: &str) -> Result<Allowed> {
        let promised = Kernel::Certified.about().promise.exact;
        let (t_ulp, distance) = promised.map_or((0.0, 0.0), |p| (p.t_ulp, p.normal_distance));
        // The angle at which the ends of two unit vectors are so far apart.
        let degrees = (2.0 * (distance / 2.0).asin()).to_degrees();
        let (t, normal) =
            (Tolerance { most: t_ulp, unit: Ulp }, Tolerance { most: degrees, unit: Degrees });
        let mut allowed = Allowed::read(text, OF_RAYS, [NOTHING, NOTHING, t, normal])?;
        if !text.contains("silhouettes") {
            allowed.limits[1] = allowed.limits[0];
        }
        Ok(allowed)
    }

    /// What may differ of the numbers of a pixel, and how many pixels may differ more, as
    /// `levels=2,ulp=4,difference=1e-6,pixels=0.1%` says, each of them or not: levels of whole numbers that are colours, steps of
    /// floats, and the difference of floats that are more steps apart. Without a word nothing may differ.
    ///
    /// # Errors
    /// [`Error::Usage`] for other words.
    pub fn of_pictures(text: &str) -> Result<Allowed> {
        Allowed::read(text, OF_PICTURES, [NOTHING; 4])
    }

    fn read(text: &str, of: Keys, mut limits: [Tolerance; 4]) -> Result<Allowed> {
        let keys = of.map(|(key, _)| key);
        for part in text.split(',').filter(|_| !text.trim().is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let (key, value) = (key.trim(), value.trim());
            let Some(at) = keys.iter().position(|known| *known == key) else {
                return wrong_usage(format!(
                    "nothing that can be allowed is called “{key}”; give {}{}",
                    keys.join(", "),
                    did_you_mean_at_end(keys, key)
                ));
            };
            let values = of[at].1;
            limits[at] = values.read(value).ok_or_else(|| {
                Error::Usage(
                    format!("“{value}” is no limit for {key}; give {}", values.expected).into(),
                )
            })?;
        }
        Ok(Allowed { keys, limits })
    }

    /// What is allowed of this key; nothing of an unknown one.
    pub fn limit(&self, key: &str) -> Tolerance {
        let at = self.keys.iter().position(|known| *known == key);
        at.map_or(NOTHING, |at| self.limits[at])
    }

    /// Whether `t` may be so far off.
    pub fn allows_t(&self, error: &TError) -> bool {
        match self.limit("t") {
            Tolerance { most, unit: Ulp } => error.ulp <= most + REFERENCE_ULP,
            limit => limit.allows(error.relative),
        }
    }

    /// Whether a normal may have this error: its angle is within the limit, and the difference of each component is at
    /// most [`Allowed::normal_component`].
    pub fn allows_normal(&self, error: &NormalError) -> bool {
        self.limit("normal").allows(error.degrees) && error.component <= self.normal_component()
    }

    /// Returns the largest allowed difference of a component of a normal: the chord of the allowed angle on the unit
    /// sphere. The ends of two unit vectors within the angle are at most a chord apart, so the component limit only rejects
    /// normals of another length.
    pub fn normal_component(&self) -> f64 {
        match self.limit("normal").most {
            most if most.is_infinite() => f64::INFINITY,
            most => 2.0 * (most.min(180.0).to_radians() / 2.0).sin(),
        }
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let parts = self.keys.iter().zip(self.limits).map(|(key, limit)| format!("{key}={limit}"));
        f.write_str(&parts.collect::<Vec<_>>().join(","))
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
        let allowed = Allowed::of_rays("").unwrap();
        let t = |ulp| TError { ulp, relative: 0.0, is_nearest: false };
        assert!(allowed.allows_t(&t(0.5)) && !allowed.allows_t(&t(0.5001)));
        let allowed = Allowed::of_rays("normal=60").unwrap();
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
        assert!(Allowed::of_rays("normal=any").unwrap().allows_normal(&normal(180.0, 1e9)));
    }
}
