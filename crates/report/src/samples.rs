//! Collects what is measured and counted until it becomes a row.

use std::collections::BTreeMap;

use kugelblitz::trace::Hits;
use kugelblitz_judge::verify::{RayError, Truth, ray_errors};

use super::{Count, Metric, Row, Spread};

/// Values and counts of one or more results.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    pub counts: BTreeMap<Count, u64>,
    values: BTreeMap<Metric, Vec<f64>>,
}

impl Samples {
    /// Adds `n` to a count.
    pub fn count(&mut self, count: Count, n: u64) {
        *self.counts.entry(count).or_default() += n;
    }

    /// Sets a count.
    pub fn set(&mut self, count: Count, n: u64) {
        self.counts.insert(count, n);
    }

    /// Adds values of a quantity.
    pub fn add(&mut self, metric: Metric, values: impl IntoIterator<Item = f64>) {
        self.values.entry(metric).or_default().extend(values);
    }

    /// Adds the errors of a result against the truth about some of its rays.
    pub fn add_errors(&mut self, hits: &Hits, truth: &Truth) {
        self.count(Count::F32, hits.counts.f32);
        self.count(Count::F64, hits.counts.f64);
        self.count(Count::Exact, hits.counts.exact);
        let [mut false_hits, mut false_misses, mut wrong_object] = [0; 3];
        for error in ray_errors(hits, truth) {
            self.count(Count::Rays, 1);
            match error {
                RayError::FalseHit => false_hits += 1,
                RayError::FalseMiss => false_misses += 1,
                RayError::WrongObject => wrong_object += 1,
                RayError::Right { id: 0, .. } => {}
                RayError::Right { t, normal, .. } => {
                    self.add(Metric::TUlp, t.map(|t| t.ulp));
                    self.add(Metric::TRelative, t.map(|t| t.relative));
                    self.add(Metric::NormalDegrees, normal.map(|normal| normal.degrees));
                }
            }
        }
        self.count(Count::FalseHits, false_hits);
        self.count(Count::FalseMisses, false_misses);
        self.count(Count::WrongObject, wrong_object);
    }

    /// Adds what another one collected.
    pub fn append(&mut self, other: &Samples) {
        other.counts.iter().for_each(|(&count, &n)| self.count(count, n));
        other.values.iter().for_each(|(&metric, values)| self.add(metric, values.iter().copied()));
    }

    /// Puts what was collected into a row.
    pub fn put_into(&self, row: &mut Row) {
        row.counts.extend(&self.counts);
        for (&metric, values) in &self.values {
            row.numbers.extend(Spread::of(values.clone()).map(|spread| (metric, spread)));
        }
    }
}
