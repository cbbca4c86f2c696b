//! How results of rays differ, ray by ray.

use glam::DVec3;
use kugelblitz::query::Hits;
use kugelblitz::rays::Rays;
use serde::Serialize;

use super::Precision;

/// What a result says of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayResult {
    /// The visible object, 0 for the background.
    pub id: u32,
    /// The ray parameter, where the result has it.
    pub t: Option<f64>,
    /// The normal, where the result has it.
    pub normal: Option<DVec3>,
}

impl RayResult {
    /// What `hits` say of the `i`-th ray; `None` where they lack it.
    pub fn of(hits: &Hits, i: usize) -> Option<RayResult> {
        let normal = hits.normal.get(i);
        Some(RayResult {
            id: *hits.id.get(i)?,
            t: hits.t.get(i).map(|&t| t.into()),
            normal: normal.map(|normal| DVec3::from(normal.map(f64::from))),
        })
    }

    /// With no number in place of what only the other has.
    fn filled(self, other: &RayResult) -> RayResult {
        let nan = |_| f64::NAN;
        RayResult {
            t: self.t.or(other.t.map(nan)),
            normal: self.normal.or(other.normal.map(|_| DVec3::NAN)),
            ..self
        }
    }
}

/// How the result of a ray differs from the right one.
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

impl RayError {
    /// The error of a result against the right one; `is_nearest` says whether a normal is the right one, rounded.
    pub fn of(
        said: Option<RayResult>,
        right: &RayResult,
        is_nearest: impl Fn([f32; 3]) -> bool,
    ) -> RayError {
        match said {
            Some(said) if said.id == right.id => RayError::Right {
                id: said.id,
                t: said.t.zip(right.t).map(|(t, right)| TError::of(t, right)),
                normal: said.normal.zip(right.normal).map(|(normal, right)| {
                    NormalError::of(normal, right, is_nearest(normal.as_vec3().into()))
                }),
            },
            None | Some(RayResult { id: 0, .. }) => RayError::FalseMiss,
            _ if right.id == 0 => RayError::FalseHit,
            _ => RayError::WrongObject,
        }
    }
}

/// How far a `t` is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TError {
    /// In f32 steps at the right `t`: `2^(e−23)` for one in `2^e..2^(e+1)`, and not less
    /// than the smallest subnormal. +∞ where `t` is not finite. The smallest f32 in place of a `t`
    /// that would round to 0 is at most half a step off: a `t` is never 0.
    pub ulp: f64,
    /// Relative to the right `t`. +∞ where `t` is not finite.
    pub relative: f64,
    /// Whether it is the f32 nearest to the right `t`, bit by bit.
    pub is_nearest: bool,
}

impl TError {
    /// The error of a `t`, which may have more digits than an f32.
    pub fn of(t: f64, exact: f64) -> TError {
        let is_nearest = (t as f32).to_bits() == (exact as f32).to_bits();
        let of = |ulp, relative| TError { ulp, relative, is_nearest };
        if t == exact || t.to_bits() == exact.to_bits() {
            return of(0.0, 0.0);
        }
        let error = (t - exact).abs();
        if error.is_nan() {
            return of(f64::INFINITY, f64::INFINITY);
        }
        let least = f64::from(f32::from_bits(1));
        let is_least = t == least && exact > 0.0 && exact < t;
        let most = if is_least { 0.5 } else { f64::INFINITY };
        of((error / Precision::Single.ulp(exact)).min(most), error / exact.abs())
    }
}

/// How far a normal is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalError {
    /// Length of the difference from the right unit normal. +∞ where the normal is not finite.
    pub distance: f64,
    /// Angle to the right normal, degrees; 180 where the normal is not finite, or zero.
    pub degrees: f64,
    /// Largest difference of a component from the right one. +∞ if a component is not finite.
    pub component: f64,
    /// Length of the normal; NaN if a component is NaN.
    pub length: f64,
    /// Whether each component is the f32 nearest to the right one; bit by bit, where the right one is another result.
    pub is_nearest: bool,
}

impl NormalError {
    fn of(normal: DVec3, right: DVec3, is_nearest: bool) -> NormalError {
        let (component, length) = ((normal - right).abs().max_element(), normal.length());
        let of = |distance, degrees| {
            let component = if distance == f64::INFINITY { distance } else { component };
            NormalError { distance, degrees, component, length, is_nearest }
        };
        let bits = |normal: DVec3| normal.to_array().map(f64::to_bits);
        let distance = (normal - right).length();
        if bits(normal) == bits(right) {
            return of(0.0, 0.0);
        }
        if !distance.is_finite() {
            return of(f64::INFINITY, 180.0);
        }
        // Without a direction there is no angle.
        if normal == DVec3::ZERO && right != DVec3::ZERO {
            return of(distance, 180.0);
        }
        // Not the arc cosine, which loses half of its digits at small angles.
        of(distance, normal.cross(right).length().atan2(normal.dot(right)).to_degrees())
    }
}

/// Number of rays that differ, and the largest differences.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RayDifferences {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit an object instead of the background.
    pub false_hits: u64,
    /// Rays that hit the background instead of an object.
    pub false_misses: u64,
    /// Rays that hit another object than the visible one.
    pub wrong_object: u64,
    /// Rays on the right object whose `t` is not the f32 nearest to the exact one.
    pub t_differs: u64,
    /// Largest error of `t` on the right object, in f32 steps; `null` in JSON if it is infinite.
    pub t_ulp_max: f64,
    /// Rays on the right object with a component of the normal that is not the f32 nearest to the exact one.
    #[serde(rename = "normals_not_nearest")]
    pub normal_differs: u64,
    /// Largest distance between a normal and the exact one, on the right object.
    pub normal_distance_max: f64,
    /// Index of the first ray with a wrong id.
    pub first_wrong_id: Option<usize>,
    /// Index of the first ray that differs in anything.
    pub first: Option<usize>,
}

impl RayDifferences {
    /// True where everything is equal bit by bit.
    pub fn is_equal(&self) -> bool {
        self.first.is_none()
    }

    /// Rays with a wrong id.
    pub fn wrong_ids(&self) -> u64 {
        self.false_hits + self.false_misses + self.wrong_object
    }

    /// Counts one more ray.
    pub fn see(&mut self, ray: usize, error: &RayError) {
        self.rays += 1;
        let wrong = match error {
            RayError::FalseHit => &mut self.false_hits,
            RayError::FalseMiss => &mut self.false_misses,
            RayError::WrongObject => &mut self.wrong_object,
            RayError::Right { t, normal, .. } => {
                let n_before = self.t_differs + self.normal_differs;
                if let Some(t) = t {
                    self.t_differs += u64::from(!t.is_nearest);
                    self.t_ulp_max = self.t_ulp_max.max(t.ulp);
                }
                if let Some(normal) = normal {
                    self.normal_differs += u64::from(!normal.is_nearest);
                    self.normal_distance_max = self.normal_distance_max.max(normal.distance);
                }
                if self.t_differs + self.normal_differs > n_before {
                    self.first.get_or_insert(ray);
                }
                return;
            }
        };
        *wrong += 1;
        self.first.get_or_insert(ray);
        self.first_wrong_id.get_or_insert(ray);
    }

    /// Counts the differences of `a` from `b`, results of the same rays, of which the first has the index `first_ray`.
    /// What one of them lacks is as far off as can be.
    pub fn see_all(&mut self, a: &Hits, b: &Hits, first_ray: usize) {
        for i in 0..a.id.len().max(b.id.len()) {
            let error = match (RayResult::of(a, i), RayResult::of(b, i)) {
                (Some(a), Some(b)) => {
                    let right = b.filled(&a);
                    let bits = |normal: [f32; 3]| Some(normal.map(f32::to_bits));
                    let nearest = right.normal.and_then(|normal| bits(normal.as_vec3().into()));
                    RayError::of(Some(a.filled(&b)), &right, |normal| bits(normal) == nearest)
                }
                (_, None) => RayError::FalseHit,
                (None, _) => RayError::FalseMiss,
            };
            self.see(first_ray + i, &error);
        }
    }
}

/// Compares two results of the same rays, bit by bit: ids, and on the same object `t` and normals.
pub fn compare(a: &Hits, b: &Hits) -> RayDifferences {
    let mut found = RayDifferences::default();
    found.see_all(a, b, 0);
    found
}

/// Errors of a class of rays.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ErrorStats {
    /// Number of rays.
    pub rays: u64,
    /// Rays with a wrong id.
    pub wrong_ids: u64,
    /// Rays that hit an object instead of the background.
    pub false_hits: u64,
    /// Rays that hit the background instead of an object.
    pub false_misses: u64,
    /// Rays that hit another object than the visible one.
    pub wrong_object: u64,
    /// Errors of `t` in f32 steps, where the object is right; `null` if no ray has one.
    pub t_ulp: Option<ErrorSpread>,
    /// Errors of `t` relative to the exact `t`, where the object is right; `null` if no ray has one.
    pub t_relative: Option<ErrorSpread>,
    /// Angles between the normals and the exact ones, degrees; `null` if no ray has one.
    pub normal_degrees: Option<ErrorSpread>,
    /// Largest difference of a component of each normal from the exact one, without normalizing the normal; `null` if no ray
    /// has one.
    pub normal_component: Option<ErrorSpread>,
    /// Least and greatest length of the normals on the right objects, without NaN; `null` if no ray has one.
    pub normal_length: Option<[f64; 2]>,
}

impl ErrorStats {
    /// Sums up the errors of those of the rays that are in a class.
    pub fn new(rays: &Rays, errors: &[RayError], is_in: impl Fn(usize) -> bool) -> ErrorStats {
        let mut counts = RayDifferences::default();
        let mut spreads = [const { Vec::new() }; 4];
        let mut normal_length = None;
        for (i, error) in errors.iter().enumerate().filter(|(i, _)| is_in(*i)) {
            counts.see(i, error);
            if let RayError::Right { t, normal, .. } = error {
                let [of_t, of_normal] = [
                    t.map_or([None; 2], |t| [Some(t.ulp), Some(t.relative)]),
                    normal.map_or([None; 2], |n| [Some(n.degrees), Some(n.component)]),
                ];
                let sizes = [of_t, of_normal].into_iter().flatten();
                spreads.iter_mut().zip(sizes).for_each(|(all, size)| all.extend(size.zip(Some(i))));
                if let Some(NormalError { length, .. }) = normal {
                    let [least, most] = normal_length.unwrap_or([f64::NAN; 2]);
                    normal_length = Some([length.min(least), length.max(most)]);
                }
            }
        }
        let [t_ulp, t_relative, normal_degrees, normal_component] =
            spreads.map(|errors| ErrorSpread::new(errors, rays));
        let RayDifferences { rays, false_hits, false_misses, wrong_object, .. } = counts;
        let wrong_ids = counts.wrong_ids();
        ErrorStats {
            rays,
            wrong_ids,
            false_hits,
            false_misses,
            wrong_object,
            t_ulp,
            t_relative,
            normal_degrees,
            normal_component,
            normal_length,
        }
    }

    /// Returns the spreads of `t` in f32 steps, of `t` relative to the exact one, of angles, and of normals' components.
    pub fn spreads(&self) -> [Option<ErrorSpread>; 4] {
        [self.t_ulp, self.t_relative, self.normal_degrees, self.normal_component]
    }
}

/// Distribution of errors. A result that is not finite has an infinite error, which is `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorSpread {
    /// Number of errors.
    pub n: u64,
    /// Median: half of the errors do not exceed it.
    pub median: f64,
    /// Error that 99 % of the rays do not exceed.
    pub p99: f64,
    /// Maximum.
    pub worst: f64,
    /// Index of the first ray with the largest error.
    pub worst_ray: usize,
    /// Column and row of that ray; `null` for a list of rays.
    pub worst_pixel: Option<[u32; 2]>,
}

impl ErrorSpread {
    /// Sums up errors with the rays that have them; `None` of none.
    fn new(mut errors: Vec<(f64, usize)>, rays: &Rays) -> Option<ErrorSpread> {
        let n = errors.len();
        let &(worst, worst_ray) =
            errors.iter().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?;
        // The smallest one that is not less than so many of them.
        let mut rank = |share_percent: usize| {
            let place = (n * share_percent).div_ceil(100).max(1) - 1;
            errors.select_nth_unstable_by(place, |a, b| a.0.total_cmp(&b.0)).1.0
        };
        let (median, p99, worst_pixel) = (rank(50), rank(99), rays.pixel(worst_ray));
        Some(ErrorSpread { n: n as u64, median, p99, worst, worst_ray, worst_pixel })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_difference_of_two_results_is_seen() {
        let whole = Hits {
            id: vec![0, 1],
            t: vec![f32::INFINITY, 9.0],
            normal: vec![[0.0; 3], [1.0, 0.0, 0.0]],
            ..Hits::default()
        };
        assert!(compare(&whole, &whole).is_equal());
        let without_t = Hits { t: Vec::new(), ..whole.clone() };
        assert!(compare(&without_t, &without_t).is_equal());
        // What is counted: wrong ids, t, normals; and the first ray that differs.
        type Sabotage = (&'static str, [u64; 3], usize, fn(&mut Hits));
        let sabotages: [Sabotage; 9] = [
            ("an id", [1, 0, 0], 1, |hits| hits.id[1] = 2),
            ("a hit", [1, 0, 0], 0, |hits| hits.id[0] = 2),
            ("a bit of t", [0, 1, 0], 1, |hits| hits.t[1] = hits.t[1].next_up()),
            ("its sign", [0, 1, 0], 1, |hits| hits.t[1] = -hits.t[1]),
            ("NaN", [0, 1, 0], 0, |hits| hits.t[0] = f32::NAN),
            ("the sign of a zero", [0, 0, 1], 1, |hits| hits.normal[1][2] = -0.0),
            ("no t", [0, 2, 0], 0, |hits| hits.t.clear()),
            ("no normals", [0, 0, 2], 0, |hits| hits.normal.clear()),
            ("a missing row", [1, 0, 0], 1, |hits| hits.id.truncate(1)),
        ];
        for (what, counts, first, apply) in sabotages {
            let mut spoiled = whole.clone();
            apply(&mut spoiled);
            for found in [compare(&spoiled, &whole), compare(&whole, &spoiled)] {
                let RayDifferences { t_differs, normal_differs, .. } = found;
                assert_eq!([found.wrong_ids(), t_differs, normal_differs], counts, "{what}");
                assert_eq!((found.first, found.rays), (Some(first), 2), "{what}");
                assert_eq!(found.t_ulp_max > 0.0, counts[1] > 0, "{what}");
            }
        }
        assert_eq!(compare(&whole, &without_t).t_ulp_max, f64::INFINITY);
    }

    #[test]
    fn ulps_are_those_of_the_exact_value() {
        let ulp = |t: f32, exact| TError::of(t.into(), exact).ulp;
        assert_eq!(ulp(1.0, 1.0), 0.0);
        assert_eq!(ulp(1.0 + 2.0 * f32::EPSILON, 1.0), 2.0);
        assert_eq!(ulp(1.0 - f32::EPSILON / 2.0, 1.0), 0.5);
        assert_eq!(ulp(f32::from_bits(1), 0.0), 1.0);
        assert_eq!(ulp(f32::INFINITY, f64::INFINITY), 0.0);
        assert_eq!(ulp(f32::INFINITY, 1.0), f64::INFINITY);
        assert_eq!(ulp(1.0, f64::INFINITY), f64::INFINITY);
        // A `t` is never 0: what would round to it is the smallest f32.
        let least = f32::from_bits(1);
        assert_eq!(ulp(least, 1e-60), 0.5);
        assert!(ulp(least, f64::from(least) * 1.6) > 0.5 && ulp(0.0, 1e-45) > 0.5);
    }

    #[test]
    fn ranks_are_those_of_the_sorted_errors() {
        let of = |errors: &[f64]| {
            ErrorSpread::new(errors.iter().copied().zip(10..).collect(), &Rays::List(Vec::new()))
                .map(|s| (s.median, s.p99, s.worst_ray))
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[3.0]), Some((3.0, 3.0, 10)));
        assert_eq!(of(&[4.0, 1.0, 3.0, 2.0]), Some((2.0, 4.0, 10)));
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(of(&hundred), Some((50.0, 99.0, 10)));
        assert_eq!(
            of(&[1.0, f64::INFINITY, f64::INFINITY]),
            Some((f64::INFINITY, f64::INFINITY, 11))
        );
    }
}
