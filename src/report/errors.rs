//! How wrong a result is: counts of wrong ids, and distributions of the errors of `t` and normals.

use serde::Serialize;

use crate::trace::{Hits, StageCounts};
use crate::verify::{RayError, Truth, ray_errors};

/// The errors of one kernel, against exact arithmetic.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit an object where there is none.
    pub false_hits: u64,
    /// Rays that miss an object that is there.
    pub false_misses: u64,
    /// Rays that hit another object than the visible one.
    pub wrong_object: u64,
    /// Error of `t` in f32 steps at the exact `t`, where the object is right.
    pub t_ulp: Option<Distribution>,
    /// The same, relative to the exact `t`.
    pub t_relative: Option<Distribution>,
    /// Angle to the exact normal in degrees, where the object is right.
    pub normal_degrees: Option<Distribution>,
    /// How many rays of the whole picture each stage decided.
    pub stages: StageCounts,
}

/// Middle, nearly worst and worst of many errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Distribution {
    /// Half of the errors are not larger.
    pub median: f64,
    /// 99.9 % of the errors are not larger.
    pub p999: f64,
    /// The largest error. JSON has no infinity; there it is `null`.
    pub max: f64,
    /// Number of errors.
    pub n: usize,
}

impl Distribution {
    /// Of some errors, none of them NaN; `None` for none.
    pub fn of(errors: &mut [f64]) -> Option<Distribution> {
        errors.sort_unstable_by(f64::total_cmp);
        let n = errors.len();
        // Nearest rank: the smallest error that at least this share does not exceed.
        let rank = |share: f64| errors[((share * n as f64).ceil() as usize).clamp(1, n) - 1];
        (n > 0).then(|| Distribution { median: rank(0.5), p999: rank(0.999), max: rank(1.0), n })
    }
}

impl Errors {
    /// Rays with a wrong id.
    pub fn wrong_ids(&self) -> u64 {
        self.false_hits + self.false_misses + self.wrong_object
    }

    /// Share of rays with a wrong id, 0 to 1.
    pub fn wrong_share(&self) -> f64 {
        self.wrong_ids() as f64 / self.rays.max(1) as f64
    }
}

/// Collects the errors of one or more results.
#[derive(Clone, Debug, Default)]
pub(super) struct Collector {
    counted: Errors,
    t_ulp: Vec<f64>,
    t_relative: Vec<f64>,
    normal_degrees: Vec<f64>,
}

impl Collector {
    /// Compares a result with the truth about some of its rays.
    pub fn add(&mut self, hits: &Hits, truth: &Truth) {
        self.counted.stages.add(hits.counts);
        for error in ray_errors(hits, truth) {
            self.counted.rays += 1;
            match error {
                RayError::FalseHit => self.counted.false_hits += 1,
                RayError::FalseMiss => self.counted.false_misses += 1,
                RayError::WrongObject => self.counted.wrong_object += 1,
                RayError::Right { id: 0, .. } => {}
                RayError::Right { t, normal, .. } => {
                    self.t_ulp.extend(t.map(|t| t.ulp));
                    self.t_relative.extend(t.map(|t| t.relative));
                    self.normal_degrees.extend(normal.map(|normal| normal.degrees));
                }
            }
        }
    }

    /// Adds what another one collected.
    pub fn append(&mut self, other: &Collector) {
        let Collector { counted, t_ulp, t_relative, normal_degrees } = other;
        self.counted.rays += counted.rays;
        self.counted.false_hits += counted.false_hits;
        self.counted.false_misses += counted.false_misses;
        self.counted.wrong_object += counted.wrong_object;
        self.counted.stages.add(counted.stages);
        self.t_ulp.extend(t_ulp);
        self.t_relative.extend(t_relative);
        self.normal_degrees.extend(normal_degrees);
    }

    /// The errors collected.
    pub fn finish(mut self) -> Errors {
        self.counted.t_ulp = Distribution::of(&mut self.t_ulp);
        self.counted.t_relative = Distribution::of(&mut self.t_relative);
        self.counted.normal_degrees = Distribution::of(&mut self.normal_degrees);
        self.counted
    }
}
