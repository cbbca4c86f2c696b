//! Comparing two [`Hits`] of the same rays, and two pictures.

mod pictures;
mod share;

pub use pictures::{
    ChannelDifference, PictureDifference, Tolerance, compare_pictures, difference_picture,
};
pub use share::Share;

use crate::num::ulp_distance;
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

/// Euclidean distance of two vectors.
pub fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let squared: f64 = a.iter().zip(b).map(|(&a, b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
    squared.sqrt()
}

/// Compares ids, and on the same object `t` and normals; one that only one of the results has is
/// as far off as can be.
///
/// Results of different length differ at the first ray that only one of them has.
pub fn compare(a: &Hits, b: &Hits) -> Comparison {
    let n = a.id.len().min(b.id.len());
    let mut result = Comparison { rays: n as u64, ..Comparison::default() };
    for i in 0..n {
        let mut same = true;
        if a.id[i] != b.id[i] {
            same = false;
            match a.id[i] == 0 || b.id[i] == 0 {
                true => result.hit_or_miss += 1,
                false => result.other_object += 1,
            }
        } else {
            let t = [a, b].map(|hits| hits.t.get(i).copied());
            if t[0].map(f32::to_bits) != t[1].map(f32::to_bits) {
                same = false;
                result.t_differs += 1;
                let ulp = t[0].zip(t[1]).map_or(u64::MAX, |(a, b)| ulp_distance(a, b));
                result.t_ulp_max = result.t_ulp_max.max(ulp);
            }
            let normal = [a, b].map(|hits| hits.normal.get(i).copied());
            let bits = normal.map(|normal| normal.map(|normal| normal.map(f32::to_bits)));
            if bits[0] != bits[1] {
                same = false;
                result.normal_differs += 1;
                let apart = normal[0].zip(normal[1]).map_or(f64::INFINITY, |(a, b)| distance(a, b));
                result.normal_distance_max = result.normal_distance_max.max(apart);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A result without `t` or normals is not equal to one with them.
    #[test]
    fn what_one_result_lacks_differs() {
        let whole =
            Hits { id: vec![0, 1], t: vec![9.0; 2], normal: vec![[1.0; 3]; 2], ..Hits::default() };
        assert!(compare(&whole, &whole).is_equal());
        let without_t = Hits { t: Vec::new(), ..whole.clone() };
        let without_normals = Hits { normal: Vec::new(), ..whole.clone() };
        assert!(compare(&without_t, &without_t).is_equal());
        for (lacking, t_differs, normal_differs) in [(&without_t, 2, 0), (&without_normals, 0, 2)] {
            for (a, b) in [(&whole, lacking), (lacking, &whole)] {
                let found = compare(a, b);
                assert_eq!((found.t_differs, found.normal_differs), (t_differs, normal_differs));
                assert_eq!(found.first, Some(0));
            }
        }
        let found = compare(&whole, &without_t);
        assert_eq!((found.t_ulp_max, found.ids_differ()), (u64::MAX, 0));
        assert_eq!(compare(&without_normals, &whole).normal_distance_max, f64::INFINITY);
    }
}
