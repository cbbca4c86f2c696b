//! Comparing two [`Hits`] of the same rays.

use crate::trace::Hits;

/// Where and how far two results differ.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Rays compared.
    pub rays: u64,
    /// Rays that one result hits and the other misses.
    pub hit_or_miss: u64,
    /// Rays that hit different objects.
    pub other_object: u64,
    /// Rays on the same object with another `t`.
    pub t_differs: u64,
    /// Largest distance of two `t` on the same object, in f32 steps.
    pub t_ulp_max: u64,
    /// Rays on the same object with another normal.
    pub normal_differs: u64,
    /// Largest Euclidean distance of two normals on the same object.
    pub normal_distance_max: f64,
    /// Index of the first ray that differs.
    pub first: Option<usize>,
}

impl Comparison {
    /// True where everything is equal bit by bit.
    pub fn is_equal(&self) -> bool {
        self.first.is_none()
    }

    /// Rays with different ids.
    pub fn ids_differ(&self) -> u64 {
        self.hit_or_miss + self.other_object
    }

    /// Adds another part of the same picture, whose rays begin at `first_ray`.
    pub fn add(&mut self, other: &Comparison, first_ray: usize) {
        self.rays += other.rays;
        self.hit_or_miss += other.hit_or_miss;
        self.other_object += other.other_object;
        self.t_differs += other.t_differs;
        self.t_ulp_max = self.t_ulp_max.max(other.t_ulp_max);
        self.normal_differs += other.normal_differs;
        self.normal_distance_max = self.normal_distance_max.max(other.normal_distance_max);
        self.first = self.first.or(other.first.map(|index| first_ray + index));
    }
}

/// A format of IEEE 754.
#[derive(Clone, Copy)]
pub(crate) enum Precision {
    Single,
    Double,
}

impl Precision {
    /// The distance of the format's numbers at `x`, and not less than its smallest subnormal.
    pub fn ulp(self, x: f64) -> f64 {
        let (lowest, fraction_bits) = match self {
            Precision::Single => (-126, 23),
            Precision::Double => (-1022, 52),
        };
        let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
        match exponent.max(lowest) - fraction_bits {
            exponent @ -1022.. => 2f64.powi(exponent),
            // Subnormal, where `powi` gives 0.
            exponent => f64::from_bits(1 << (exponent + 1074).clamp(0, 51)),
        }
    }
}

/// Number of f32 values from one to the other; equal values are 0 apart, and so are ±0.
pub fn ulp_distance(a: f32, b: f32) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::from(a.to_bits() != b.to_bits()) * u64::MAX;
    }
    let ordered = |x: f32| {
        let magnitude = i64::from(x.to_bits() & 0x7fff_ffff);
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    ordered(a).abs_diff(ordered(b))
}

/// Euclidean distance of two vectors.
pub fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let squared: f64 = a.iter().zip(b).map(|(&a, b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
    squared.sqrt()
}

/// Compares ids, and `t` and normals where both results have them.
///
/// Results of different length differ at the first ray that only one of them has.
pub fn compare(a: &Hits, b: &Hits) -> Comparison {
    let n = a.id.len().min(b.id.len());
    let surface = [&a.t, &b.t].iter().all(|t| t.len() >= n)
        && [&a.normal, &b.normal].iter().all(|normal| normal.len() >= n);
    let mut result = Comparison { rays: n as u64, ..Comparison::default() };
    for i in 0..n {
        let mut same = true;
        if a.id[i] != b.id[i] {
            same = false;
            match a.id[i] == 0 || b.id[i] == 0 {
                true => result.hit_or_miss += 1,
                false => result.other_object += 1,
            }
        } else if surface {
            if a.t[i].to_bits() != b.t[i].to_bits() {
                same = false;
                result.t_differs += 1;
                result.t_ulp_max = result.t_ulp_max.max(ulp_distance(a.t[i], b.t[i]));
            }
            if a.normal[i].map(f32::to_bits) != b.normal[i].map(f32::to_bits) {
                same = false;
                result.normal_differs += 1;
                let distance = distance(a.normal[i], b.normal[i]);
                result.normal_distance_max = result.normal_distance_max.max(distance);
            }
        }
        if !same && result.first.is_none() {
            result.first = Some(i);
        }
    }
    if a.id.len() != b.id.len() && result.first.is_none() {
        result.first = Some(n);
    }
    result
}
