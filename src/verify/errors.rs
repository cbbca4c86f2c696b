//! How far results are from the exact ones.

use glam::DVec3;

use super::Truth;
use crate::compare::Precision;
use crate::trace::Hits;

/// Where and how far a result is from the exact one.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct AgainstExact {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit an object where there is none.
    pub false_hits: u64,
    /// Rays that miss an object that is there.
    pub false_misses: u64,
    /// Rays that hit another object than the visible one.
    pub wrong_object: u64,
    /// Largest error of `t` where the object is right, in f32 steps at the exact `t`.
    pub t_ulp_max: f64,
    /// Largest distance of a normal from the exact one where the object is right.
    pub normal_distance_max: f64,
    /// Normals with a component that is not the f32 nearest to that of the exact one, where the object is right.
    pub normals_not_nearest: u64,
    /// Index of the first ray with a wrong id.
    pub first_wrong_id: Option<usize>,
}

impl AgainstExact {
    /// Rays with a wrong id.
    pub fn wrong_ids(&self) -> u64 {
        self.false_hits + self.false_misses + self.wrong_object
    }

    /// Adds another part of the same picture, whose rays begin at `first_ray`.
    pub fn add(&mut self, other: &AgainstExact, first_ray: usize) {
        self.rays += other.rays;
        self.false_hits += other.false_hits;
        self.false_misses += other.false_misses;
        self.wrong_object += other.wrong_object;
        self.t_ulp_max = self.t_ulp_max.max(other.t_ulp_max);
        self.normal_distance_max = self.normal_distance_max.max(other.normal_distance_max);
        self.normals_not_nearest += other.normals_not_nearest;
        let first = other.first_wrong_id.map(|index| first_ray + index);
        self.first_wrong_id = self.first_wrong_id.or(first);
    }
}

/// The error of one ray's result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayError {
    /// An object where there is none.
    FalseHit,
    /// No object where there is one; also a ray that the result lacks.
    FalseMiss,
    /// Another object than the visible one.
    WrongObject,
    /// The right object, or the background where it should be; `t` and the normal where the result
    /// has them.
    Right {
        /// The object.
        id: u32,
        /// How far `t` is off.
        t: Option<TError>,
        /// How far the normal is off.
        normal: Option<NormalError>,
    },
}

/// How far a `t` is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TError {
    /// In f32 steps at the exact `t`: `2^(e−23)` for an exact `t` in `2^e..2^(e+1)`, and not less
    /// than the smallest subnormal. +∞ where `t` is not finite. The smallest f32 in place of a `t`
    /// that would round to 0 is at most half a step off: a `t` is never 0.
    pub ulp: f64,
    /// Relative to the exact `t`. +∞ where `t` is not finite.
    pub relative: f64,
}

impl TError {
    pub(crate) fn new(t: f32, exact: f64) -> TError {
        TError::of(f64::from(t), exact)
    }

    /// Of a number that may have more digits than an f32.
    pub(crate) fn of(t: f64, exact: f64) -> TError {
        if t == exact {
            return TError { ulp: 0.0, relative: 0.0 };
        }
        let error = (t - exact).abs();
        if error.is_nan() {
            return TError { ulp: f64::INFINITY, relative: f64::INFINITY };
        }
        let least = f64::from(f32::from_bits(1));
        let most = match t == least && exact > 0.0 && exact < t {
            true => 0.5,
            false => f64::INFINITY,
        };
        let ulp = (error / Precision::Single.ulp(exact)).min(most);
        TError { ulp, relative: error / exact.abs() }
    }
}

/// How far a normal is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalError {
    /// Length of the difference from the exact unit normal. +∞ where the normal is not finite.
    pub distance: f64,
    /// Angle to the exact normal, degrees; 180 where the normal is not finite.
    pub degrees: f64,
}

impl NormalError {
    fn new(normal: [f32; 3], exact: [f64; 3]) -> NormalError {
        NormalError::of(DVec3::from(normal.map(f64::from)), DVec3::from(exact))
    }

    pub(crate) fn of(normal: DVec3, exact: DVec3) -> NormalError {
        let distance = (normal - exact).length();
        if !distance.is_finite() {
            return NormalError { distance: f64::INFINITY, degrees: 180.0 };
        }
        // Not the arc cosine, which loses half of its digits at small angles.
        let radians = normal.cross(exact).length().atan2(normal.dot(exact));
        NormalError { distance, degrees: radians.to_degrees() }
    }
}

/// Compares `hits` with the truth about some of its rays, in the order of the truth.
pub fn ray_errors<'a>(hits: &'a Hits, truth: &'a Truth) -> impl Iterator<Item = RayError> + 'a {
    truth.index.iter().enumerate().map(|(k, &index)| {
        match (hits.id.get(index).copied(), truth.id[k]) {
            (Some(id), expected) if id == expected => RayError::Right {
                id,
                t: hits.t.get(index).map(|&t| TError::new(t, truth.t[k])),
                normal: hits.normal.get(index).map(|&n| NormalError::new(n, truth.normal[k])),
            },
            (Some(0) | None, _) => RayError::FalseMiss,
            (Some(_), 0) => RayError::FalseHit,
            _ => RayError::WrongObject,
        }
    })
}

/// Compares `hits` with the truth about some of its rays. `t` and normals are looked at where
/// `hits` has them and the id is right. A ray that `hits` lacks counts as a wrong id.
pub fn compare_to_exact(hits: &Hits, truth: &Truth) -> AgainstExact {
    let mut result = AgainstExact { rays: truth.index.len() as u64, ..AgainstExact::default() };
    let rays = truth.index.iter().zip(&truth.normal_f32);
    for ((&index, nearest), error) in rays.zip(ray_errors(hits, truth)) {
        let wrong = match error {
            RayError::FalseHit => &mut result.false_hits,
            RayError::FalseMiss => &mut result.false_misses,
            RayError::WrongObject => &mut result.wrong_object,
            RayError::Right { t, normal, .. } => {
                result.t_ulp_max = result.t_ulp_max.max(t.map_or(0.0, |t| t.ulp));
                result.normal_distance_max =
                    result.normal_distance_max.max(normal.map_or(0.0, |normal| normal.distance));
                let is_nearest = hits.normal.get(index).is_none_or(|normal| normal == nearest);
                result.normals_not_nearest += u64::from(!is_nearest);
                continue;
            }
        };
        *wrong += 1;
        result.first_wrong_id.get_or_insert(index);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulps_are_those_of_the_exact_value() {
        assert_eq!(TError::new(1.0, 1.0).ulp, 0.0);
        assert_eq!(TError::new(1.0 + 2.0 * f32::EPSILON, 1.0).ulp, 2.0);
        assert_eq!(TError::new(1.0 - f32::EPSILON / 2.0, 1.0).ulp, 0.5);
        assert_eq!(TError::new(f32::from_bits(1), 0.0).ulp, 1.0);
        assert_eq!(TError::new(f32::INFINITY, f64::INFINITY).ulp, 0.0);
        assert_eq!(TError::new(f32::INFINITY, 1.0).ulp, f64::INFINITY);
        assert_eq!(TError::new(1.0, f64::INFINITY).ulp, f64::INFINITY);
    }
}
