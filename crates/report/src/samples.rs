//! Collects what is measured and counted until it becomes a row.

use std::collections::BTreeMap;

use kugelblitz::trace::Hits;
use kugelblitz_judge::compare::RayDifferences;
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
        let mut found = RayDifferences::default();
        for (ray, error) in ray_errors(hits, truth).enumerate() {
            found.see(ray, &error);
            if let RayError::Right { id: 1.., t, normal } = error {
                self.add(Metric::TUlp, t.map(|t| t.ulp));
                self.add(Metric::TRelative, t.map(|t| t.relative));
                self.add(Metric::NormalDegrees, normal.map(|normal| normal.degrees));
            }
        }
        for (count, n) in [
            (Count::Rays, found.rays),
            (Count::FalseHits, found.false_hits),
            (Count::FalseMisses, found.false_misses),
            (Count::WrongObject, found.wrong_object),
            (Count::F32, hits.counts.f32),
            (Count::F64, hits.counts.f64),
            (Count::Exact, hits.counts.exact),
        ] {
            self.count(count, n);
        }
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
