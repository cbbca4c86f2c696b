//! What is still right.

use std::fmt;
use std::str::FromStr;

use super::{Judgement, Part};
pub use crate::compare::Share;
use crate::error::{Error, Result};
use crate::trace::Kernel;
use crate::verify::{RayError, TError};

/// What the truth's own rounding adds to an error: `t` is rounded to f64, the components of a direction and
/// its length take a few more roundings, together less than 2⁻⁵⁰ of a distance, and that is less than
/// 2⁻²⁶ of an f32 step.
const REFERENCE_ULP: f64 = 1.0 / (1u64 << 26) as f64;

/// How far `t` may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AllowedT {
    /// So many f32 steps.
    Ulp(f64),
    /// So much of the exact `t`.
    Relative(f64),
}

impl fmt::Display for AllowedT {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            AllowedT::Ulp(most) if most.is_infinite() => f.write_str("any"),
            AllowedT::Ulp(most) => write!(f, "{most}ulp"),
            AllowedT::Relative(most) => write!(f, "{most:e}"),
        }
    }
}

/// What is still right. By default it is what the kernel `certified` promises of itself: no wrong id, `t`
/// the exact one rounded to f32, normals as near as their rounded components are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowed {
    /// Wrong ids away from silhouettes.
    pub ids: Share,
    /// Wrong ids at them.
    pub silhouettes: Share,
    /// The largest error of `t`.
    pub t: AllowedT,
    /// The largest angle of a normal to the exact one, degrees.
    pub normal_degrees: f64,
}

impl Default for Allowed {
    fn default() -> Allowed {
        let promised = Kernel::Certified.about().promise.exact;
        let (t_ulp, distance) = promised.map_or((0.0, 0.0), |p| (p.t_ulp, p.normal_distance));
        // The angle at which the ends of two unit vectors are so far apart.
        let normal_degrees = (2.0 * (distance / 2.0).asin()).to_degrees();
        let none = Share::Count(0);
        Allowed { ids: none, silhouettes: none, t: AllowedT::Ulp(t_ulp), normal_degrees }
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Allowed { ids, silhouettes, t, normal_degrees } = self;
        write!(f, "ids={ids},silhouettes={silhouettes},t={t},normal=")?;
        match normal_degrees.is_infinite() {
            true => f.write_str("any"),
            false => f.write_str(&short(*normal_degrees)),
        }
    }
}

impl FromStr for Allowed {
    type Err = Error;

    /// Reads `ids=0.01%,silhouettes=5%,t=2ulp,normal=0.1`, each of them or not. What `ids` allows holds at
    /// silhouettes as well, where nothing else is said of them.
    fn from_str(text: &str) -> Result<Allowed> {
        const KEYS: [&str; 4] = ["ids", "silhouettes", "t", "normal"];
        let mut allowed = Allowed::default();
        let mut silhouettes = None;
        for part in text.split(',') {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let (key, value) = (key.trim(), value.trim());
            match key {
                "ids" => allowed.ids = value.parse()?,
                "silhouettes" => silhouettes = Some(value.parse()?),
                "t" => allowed.t = t_of(value)?,
                "normal" => {
                    let degrees = value.strip_suffix("deg").or(value.strip_suffix('°'));
                    allowed.normal_degrees =
                        size_of(degrees.unwrap_or(value)).ok_or_else(|| {
                            Error::Usage(format!("“{value}” is no angle; give degrees, or any"))
                        })?;
                }
                other => {
                    let near = KEYS.into_iter().find(|key| strsim::osa_distance(other, key) == 1);
                    let near = near.map_or(String::new(), |near| format!("; did you mean {near}?"));
                    return Err(Error::Usage(format!(
                        "nothing that can be allowed is called “{other}”; give ids, silhouettes, t and \
                         normal, as in ids=0.01%,t=2ulp,normal=0.1{near}"
                    )));
                }
            }
        }
        allowed.silhouettes = silhouettes.unwrap_or(allowed.ids);
        Ok(allowed)
    }
}

fn size_of(text: &str) -> Option<f64> {
    if text == "any" {
        return Some(f64::INFINITY);
    }
    text.trim().parse().ok().filter(|size: &f64| *size >= 0.0)
}

fn t_of(text: &str) -> Result<AllowedT> {
    let t = match (text.strip_suffix("ulp"), text.strip_suffix('%')) {
        _ if text == "any" => Some(AllowedT::Ulp(f64::INFINITY)),
        (Some(ulp), _) => size_of(ulp).map(AllowedT::Ulp),
        (None, Some(percent)) => {
            size_of(percent).map(|percent| AllowedT::Relative(percent / 100.0))
        }
        (None, None) => size_of(text).map(AllowedT::Relative),
    };
    t.ok_or_else(|| {
        Error::Usage(format!("“{text}” is no error of t; give 2ulp, 1e-6 (relative), or any"))
    })
}

impl Allowed {
    /// Whether `t` may be so far off.
    pub fn allows_t(&self, error: &TError) -> bool {
        match self.t {
            AllowedT::Ulp(most) => error.ulp <= most + REFERENCE_ULP,
            AllowedT::Relative(most) => error.relative <= most,
        }
    }

    /// Whether nothing of a ray's result is more wrong than it may be.
    pub fn is_right(&self, error: &RayError) -> bool {
        match error {
            RayError::Right { t, normal, .. } => {
                t.is_none_or(|t| self.allows_t(&t))
                    && normal.is_none_or(|normal| normal.degrees <= self.normal_degrees)
            }
            RayError::FalseHit | RayError::FalseMiss | RayError::WrongObject => false,
        }
    }

    /// What is not right, one sentence each.
    pub fn broken(&self, judgement: &Judgement) -> Vec<String> {
        let Judgement { away, silhouettes, .. } = judgement;
        let mut broken = Vec::new();
        for (part, share, place) in [
            (away, self.ids, if silhouettes.rays > 0 { " away from silhouettes" } else { "" }),
            (silhouettes, self.silhouettes, " at silhouettes"),
        ] {
            let (wrong, rays) = (part.wrong_ids(), part.rays);
            if share.is_exceeded(wrong, rays) {
                broken.push(format!("{wrong} of {rays} ids{place} are wrong, allowed: {share}"));
            }
        }
        let worst = |of: fn(&Part) -> Option<f64>| {
            [away, silhouettes].into_iter().filter_map(of).reduce(f64::max)
        };
        let t_ulp = worst(|part| part.t_ulp.map(|spread| spread.worst));
        let t_relative = worst(|part| part.t_relative.map(|spread| spread.worst));
        match (self.t, t_ulp, t_relative) {
            (AllowedT::Ulp(most), Some(ulp), _) if ulp > most + REFERENCE_ULP => {
                broken.push(format!("t is off by {} ulp, allowed: {most}", short(ulp)));
            }
            (AllowedT::Relative(most), _, Some(relative)) if relative > most => {
                let off = short(relative);
                broken.push(format!("t is off by a relative {off}, allowed: {most:e}"));
            }
            _ => {}
        }
        let degrees = worst(|part| part.normal_degrees.map(|spread| spread.worst));
        if let Some(degrees) = degrees.filter(|&degrees| degrees > self.normal_degrees) {
            let most = short(self.normal_degrees);
            broken.push(format!("a normal is off by {}°, allowed: {most}°", short(degrees)));
        }
        broken
    }
}

/// Three digits.
pub(super) fn short(x: f64) -> String {
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
    fn what_is_allowed_is_read_and_written() {
        let of = |text: &str| text.parse::<Allowed>().unwrap();
        let all = of("ids=0.01%, silhouettes=5%, t=2ulp, normal=0.1deg");
        assert_eq!(all.to_string(), "ids=0.01%,silhouettes=5%,t=2ulp,normal=0.100");
        assert_eq!(of("ids=3").silhouettes, Share::Count(3));
        assert_eq!(of("t=1e-6").t, AllowedT::Relative(1e-6));
        assert_eq!(of("normal=any,t=any").to_string(), "ids=0,silhouettes=0,t=any,normal=any");
        assert_eq!(of("t=1ulp").ids, Allowed::default().ids);
        for wrong in ["", "idz=1", "ids", "ids=-1", "ids=101%", "t=2ulps", "normal=-1", "t=NaN"] {
            let refused = wrong.parse::<Allowed>().unwrap_err();
            assert_eq!(refused.exit_code(), 2, "{wrong}");
        }
        assert!("idz=1".parse::<Allowed>().unwrap_err().to_string().contains("did you mean ids?"));
    }

    #[test]
    fn the_default_is_the_promise_of_certified() {
        let Allowed { t, normal_degrees, .. } = Allowed::default();
        assert_eq!(t, AllowedT::Ulp(0.5));
        assert!((2.95e-6..2.96e-6).contains(&normal_degrees), "{normal_degrees}");
    }
}
