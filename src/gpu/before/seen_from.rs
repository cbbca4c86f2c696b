//! A sphere of a picture's tree in the numbers of the filter in f64, as a device makes them of the scene's.
//! Twin of `shaders/seen.wgsl`.
//!
//! A perspective camera's eye is far from such a sphere, so that its `k` is positive and known well.

use crate::guard::{self, GuardFactors, InputError};
use crate::kernel::certified::{SphereCertified, Widening};
use crate::rays::Bundle;
use crate::scene::Sphere;
use crate::vec3::{Vec3, dot3};

/// The place that the rays of a picture are seen from.
#[derive(Clone, Copy, Debug)]
pub struct SeenFrom {
    reference: Vec3<f64>,
    /// Largest distance of an origin from there.
    spread: f64,
    bundle: Bundle,
    factors: GuardFactors,
    widening: Widening<f64>,
}

impl SeenFrom {
    /// For rays that start up to `spread` from the point `reference`.
    pub fn new(reference: glam::DVec3, spread: f64, bundle: Bundle, input: InputError) -> SeenFrom {
        SeenFrom {
            reference: reference.into(),
            spread,
            bundle,
            factors: GuardFactors::f64(input),
            widening: guard::widening_f64(),
        }
    }

    /// The numbers of a sphere.
    #[inline(always)]
    pub fn sphere_seen(&self, sphere: &Sphere) -> SphereCertified<f64> {
        let factors = &self.factors;
        let l = Vec3::from(sphere.center) - self.reference;
        let r = sphere.radius.abs();
        let l2 = dot3(l, l);
        let r2 = r * r;
        let distance = f64::max(l2.sqrt() * factors.length_room, r) + self.spread;
        let eta = guard::UNIT_F64 * distance;
        let inner = r - factors.kappa * eta;
        let outer = r + factors.kappa * eta;
        let inner2 = if inner > 0.0 { inner * inner * factors.square_narrower } else { -1.0 };
        let outer2 = (outer * outer + factors.aside * eta * eta) * factors.square_wider;
        let slack =
            guard::UNIT_F64 * (factors.slack_distance * distance + factors.slack_radius * outer);
        let (k_error, q_low, q_high);
        match self.bundle {
            Bundle::Point => {
                let k = l2 - r2;
                k_error = factors.k_error * (l2 + r2);
                q_low = self.widening.narrower / (k + k_error);
                q_high = self.widening.wider / (k - k_error);
            }
            Bundle::Parallel | Bundle::Free => {
                k_error = factors.k_distance * (distance * distance) + factors.k_radius * r2;
                (q_low, q_high) = (0.0, 0.0);
            }
        }
        SphereCertified {
            center: l.0,
            inner2,
            center_low: [0.0; 3],
            outer2,
            slack,
            q_low,
            q_high_or_r2: q_high,
            k_error,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::guard::Guard;
    use crate::random::SplitMix;

    /// The factors are those of the guard, whose constants have tests of their own.
    #[test]
    fn the_guard_is_that_of_all_other_spheres() {
        let mut random = SplitMix::new(13);
        let mut number = || random.next() as f64 / u64::MAX as f64 - 0.5;
        for _ in 0..10_000 {
            let reference = DVec3::new(number(), number(), number()) * 100.0;
            let away = DVec3::new(number(), number(), number()) * 1e4;
            let sphere = Sphere { center: reference + away, radius: number().abs() + 0.01 };
            for (bundle, spread, input) in
                [(Bundle::Point, 0.0, guard::PIXELS), (Bundle::Parallel, 7.5, guard::PARALLEL)]
            {
                let seen = SeenFrom::new(reference, spread, bundle, input).sphere_seen(&sphere);
                let l = sphere.center - reference;
                let distance = guard::length_bound(l).max(sphere.radius) + spread;
                let Guard { inner2, outer2, slack, .. } =
                    Guard::new(sphere.radius, distance, guard::UNIT_F64, input);
                let is_near = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
                assert!(is_near(seen.inner2, inner2) && is_near(seen.outer2, outer2), "{sphere:?}");
                assert!(is_near(seen.slack, slack), "{sphere:?}: {} {slack}", seen.slack);
                if let (Bundle::Point, Some((k, error))) = (bundle, guard::k_f64(l, sphere.radius))
                {
                    assert!(
                        seen.q_low <= 1.0 / (k + error) && seen.q_high_or_r2 >= 1.0 / (k - error)
                    );
                    assert!(is_near(seen.q_low, guard::widening_f64().narrower / (k + error)));
                }
            }
        }
    }
}
