//! The filter of the certified kernel: it proposes an object only where it is proven, and says
//! "undecided" elsewhere. Twin of `shaders/certified.wgsl`; the bounds are derived in
//! [`crate::guard`].

use super::records::{PlaneCertified, SphereCertified};
use crate::kernel::RayOf;
use crate::num::OPEN;
use crate::vec3::{Number, Real, Vec3, dot3};

/// Bounds of a visible root's nearness `1/(a·t)`: unlike `t` it needs no division.
/// `high ≤ 0`: a certain miss. `low ≤ 0`: not certain that there is a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearness<R> {
    /// Lower bound.
    pub low: R,
    /// Upper bound.
    pub high: R,
}

impl<R: Real> Nearness<R> {
    /// Nothing is known.
    pub const OPEN: Self = Nearness { low: R::ZERO, high: R::LARGEST };

    /// A certain miss.
    pub const MISS: Self = Nearness { low: R::ZERO, high: R::ZERO };
}

/// The nearest candidate, and the upper bound of the second nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest<R> {
    /// Lower bound of the nearest candidate.
    pub low: R,
    /// Upper bound of the nearest candidate.
    pub high: R,
    /// Upper bound of the second nearest candidate.
    pub second_high: R,
    /// Id of the nearest candidate, 0 for none.
    pub id: u32,
}

impl<R: Real> Nearest<R> {
    /// No candidate yet.
    pub const NONE: Self = Nearest { low: R::ZERO, high: R::ZERO, second_high: R::ZERO, id: 0 };

    /// Takes one more object into account.
    #[inline(always)]
    pub fn nearer(self, root: Nearness<R>, id: u32) -> Self {
        let is_nearer = root.high > self.high;
        let farther = if is_nearer { self.high } else { root.high };
        Nearest {
            low: if is_nearer { root.low } else { self.low },
            high: if is_nearer { root.high } else { self.high },
            second_high: if farther > self.second_high { farther } else { self.second_high },
            id: if is_nearer { id } else { self.id },
        }
    }

    /// The object, [`OPEN`] where the bounds leave it open.
    #[inline(always)]
    pub fn decide(&self) -> u32 {
        if self.id == 0 || self.low > self.second_high { self.id } else { OPEN }
    }
}

/// `1 ∓ ε·WIDENING`, rounded away from 1.
#[derive(Clone, Copy, Debug)]
pub struct Widening<R> {
    /// Below 1.
    pub narrower: R,
    /// Above 1.
    pub wider: R,
    /// For far spheres: takes the upper bound to the lower one.
    pub far_narrower: R,
}

impl<R: Real> Widening<R> {
    /// Bounds of `1/x` for `|x|` known up to an error below it.
    #[inline(always)]
    pub fn inverse(&self, magnitude: R, error: R) -> Nearness<R> {
        Nearness {
            low: self.narrower / (magnitude + error),
            high: self.wider / (magnitude - error),
        }
    }
}

/// A guard in the filter's arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct GuardOf<R> {
    /// [`crate::guard::Guard::inner2`]
    pub inner2: R,
    /// [`crate::guard::Guard::outer2`]
    pub outer2: R,
    /// [`crate::guard::Guard::slack`]
    pub slack: R,
}

impl<R: Real> SphereCertified<R> {
    #[inline(always)]
    pub(crate) fn guard(&self) -> GuardOf<R> {
        GuardOf { inner2: self.inner2, outer2: self.outer2, slack: self.slack }
    }
}

/// The sphere at `l = c − o` seen from outside: `1/(a·t) = (s + h)·q` with `q = 1/k`.
#[inline(always)]
pub fn outside_nearness<R: Real>(
    ray: &RayOf<R>,
    l: Vec3<R>,
    guard: &GuardOf<R>,
    q: Nearness<R>,
) -> Nearness<R> {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let inner = guard.inner2 - m;
    let outer = guard.outer2 - m;
    if outer < R::ZERO {
        return Nearness::MISS;
    }
    let high = ((s + guard.slack) + (outer * ray.inv_a).sqrt()) * q.high;
    if inner < R::ZERO {
        return Nearness { low: R::ZERO, high };
    }
    Nearness { low: ((s - guard.slack) + (inner * ray.inv_a).sqrt()) * q.low, high }
}

/// As from outside, where the slack is a small part of `s + h` for every sphere and is held in `q`.
/// The lower bound still lacks the factor [`Widening::far_narrower`].
#[inline(always)]
pub fn far_nearness<R: Real>(
    ray: &RayOf<R>,
    l: Vec3<R>,
    inner2: R,
    outer2: R,
    q: R,
) -> Nearness<R> {
    let (s, m) = closest_approach(ray.direction, ray.inv_a, l);
    far_nearness_at(s, m, ray.inv_a, inner2, outer2, q)
}

/// Parameter of the point of a line that is closest to the centre, and its squared distance.
#[inline(always)]
pub fn closest_approach<R: Number>(direction: Vec3<R>, inv_a: R, l: Vec3<R>) -> (R, R) {
    let s = dot3(direction, l) * inv_a;
    let p = l - direction * s;
    (s, dot3(p, p))
}

/// [`far_nearness`] from the closest approach.
#[inline(always)]
pub fn far_nearness_at<R: Real>(s: R, m: R, inv_a: R, inner2: R, outer2: R, q: R) -> Nearness<R> {
    let inner = inner2 - m;
    let outer = outer2 - m;
    let low = (s + (inner.abs() * inv_a).sqrt()) * q;
    let high = (s + (outer.abs() * inv_a).sqrt()) * q;
    Nearness {
        low: if inner >= R::ZERO { low } else { R::ZERO },
        high: if outer >= R::ZERO { high } else { R::ZERO },
    }
}

/// Seen from inside: `t = s + h` where `s > 0`, and `1/(a·t) = (h − s)/|k|` elsewhere. On the
/// surface `q` is 0 and the roots are 0 and `2s`.
#[inline(always)]
pub fn inside_nearness<R: Real>(
    ray: &RayOf<R>,
    l: Vec3<R>,
    guard: &GuardOf<R>,
    q: Nearness<R>,
    widening: &Widening<R>,
) -> Nearness<R> {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    if q.high == R::ZERO && s.abs() <= guard.slack {
        return Nearness::OPEN;
    }
    let u_low = (s.abs() + ((guard.inner2 - m).max(R::ZERO) * ray.inv_a).sqrt()) - guard.slack;
    let u_high = (s.abs() + ((guard.outer2 - m).max(R::ZERO) * ray.inv_a).sqrt()) + guard.slack;
    if s > R::ZERO {
        let low = ray.inv_a / u_high * widening.narrower;
        let high = if u_low > R::ZERO { ray.inv_a / u_low * widening.wider } else { R::LARGEST };
        Nearness { low, high }
    } else {
        Nearness { low: u_low * q.low, high: u_high * q.high }
    }
}

/// The sphere at `l = c − o` seen along one direction: `1/(a·t)` with `t = s − h`, or `s + h` where
/// that is behind.
#[inline(always)]
pub fn parallel_nearness<R: Real>(
    ray: &RayOf<R>,
    l: Vec3<R>,
    guard: &GuardOf<R>,
    widening: &Widening<R>,
) -> Nearness<R> {
    let (s, m) = closest_approach(ray.direction, ray.inv_a, l);
    parallel_nearness_at(s, m, ray.inv_a, guard, widening)
}

/// [`parallel_nearness`] from the closest approach. Whatever is not known to be the visible root is
/// open: where `near_low ≤ 0 < near_high` it may be either of the two.
#[inline(always)]
pub fn parallel_nearness_at<R: Real>(
    s: R,
    m: R,
    inv_a: R,
    guard: &GuardOf<R>,
    widening: &Widening<R>,
) -> Nearness<R> {
    let inner = guard.inner2 - m;
    let outer = guard.outer2 - m;
    let h_inner = (inner.max(R::ZERO) * inv_a).sqrt();
    let h_outer = (outer.max(R::ZERO) * inv_a).sqrt();
    let near_low = (s - h_outer) - guard.slack;
    let near_high = (s - h_inner) + guard.slack;
    let far_low = (s + h_inner) - guard.slack;
    let far_high = (s + h_outer) + guard.slack;
    let is_near = near_low > R::SMALL;
    let is_far = near_high <= R::ZERO && far_low > R::SMALL;
    let t_low = if is_near { near_low } else { far_low };
    let t_high = if is_near { near_high } else { far_high };
    let is_missed = outer < R::ZERO || far_high <= R::ZERO;
    let is_hit = inner >= R::ZERO && far_low > R::SMALL;
    let low = inv_a / t_high.max(R::SMALL) * widening.narrower;
    let high = inv_a / t_low.max(R::SMALL) * widening.wider;
    let high = if is_near || is_far { high } else { R::LARGEST };
    Nearness {
        low: if is_hit { low } else { R::ZERO },
        high: if is_missed { R::ZERO } else { high },
    }
}

/// A sphere with `k = l·l − r²` known up to `k_error`.
#[inline(always)]
pub fn sphere_nearness<R: Real>(
    ray: &RayOf<R>,
    l: Vec3<R>,
    guard: &GuardOf<R>,
    k: R,
    k_error: R,
    widening: &Widening<R>,
) -> Nearness<R> {
    if k.abs() > k_error {
        let q = widening.inverse(k.abs(), k_error);
        match k > R::ZERO {
            true => outside_nearness(ray, l, guard, q),
            false => inside_nearness(ray, l, guard, q, widening),
        }
    } else {
        Nearness::OPEN
    }
}

/// A plane: `1/(a·t) = (d·n)·q/a` with `q = 1/((a − o)·n)` and `n` pointing away from the origin.
#[inline(always)]
pub fn plane_nearness<R: Real>(
    ray: &RayOf<R>,
    away: R,
    direction_error: R,
    q: Nearness<R>,
) -> Nearness<R> {
    let error = direction_error * ray.a.sqrt();
    Nearness { low: (away - error) * ray.inv_a * q.low, high: (away + error) * ray.inv_a * q.high }
}

/// A plane with `n_offset = (a − o)·n` known up to `n_offset_error`.
#[inline(always)]
pub fn plane_nearness_at<R: Real>(
    ray: &RayOf<R>,
    n_offset: R,
    n_offset_error: R,
    normal: Vec3<R>,
    direction_error: R,
    widening: &Widening<R>,
) -> Nearness<R> {
    let slope = dot3(ray.direction, normal);
    let away = if n_offset < R::ZERO { -slope } else { slope };
    if n_offset.abs() > n_offset_error {
        let q = widening.inverse(n_offset.abs(), n_offset_error);
        plane_nearness(ray, away, direction_error, q)
    } else {
        Nearness::OPEN
    }
}

/// `v / ‖v‖`
#[inline(always)]
pub fn normalized<R: Real>(v: Vec3<R>) -> Vec3<R> {
    v * (R::ONE / dot3(v, v).sqrt())
}

#[inline(always)]
fn offset<R: Real>(ray: &RayOf<R>, high: [R; 3], low: [R; 3]) -> Vec3<R> {
    (Vec3(high) - ray.origin) + (Vec3(low) - ray.origin_low)
}

/// The filter of one bundle of rays, on the records of the device's list.
pub(crate) trait Filter<R = f32>: Sync {
    /// A sphere.
    fn sphere_nearness(
        ray: &RayOf<R>,
        sphere: &SphereCertified<R>,
        widening: &Widening<R>,
    ) -> Nearness<R>;
    /// A plane.
    fn plane_nearness(
        ray: &RayOf<R>,
        plane: &PlaneCertified<R>,
        widening: &Widening<R>,
    ) -> Nearness<R>;
}

/// Rays from the reference point.
pub(crate) struct PointFilter;

/// Rays along one direction.
pub(crate) struct ParallelFilter;

/// Any rays.
pub(crate) struct FreeFilter;

impl<R: Real> Filter<R> for PointFilter {
    #[inline(always)]
    fn sphere_nearness(
        ray: &RayOf<R>,
        sphere: &SphereCertified<R>,
        widening: &Widening<R>,
    ) -> Nearness<R> {
        let (guard, l) = (sphere.guard(), Vec3(sphere.center));
        let q = Nearness { low: sphere.q_low.abs(), high: sphere.q_high_or_r2.abs() };
        match sphere.q_low > R::ZERO {
            true => outside_nearness(ray, l, &guard, q),
            false => inside_nearness(ray, l, &guard, q, widening),
        }
    }

    #[inline(always)]
    fn plane_nearness(ray: &RayOf<R>, plane: &PlaneCertified<R>, _: &Widening<R>) -> Nearness<R> {
        let q = Nearness { low: plane.q_low, high: plane.q_high };
        plane_nearness(ray, dot3(ray.direction, Vec3(plane.normal)), plane.direction_error, q)
    }
}

impl<R: Real> Filter<R> for ParallelFilter {
    #[inline(always)]
    fn sphere_nearness(
        ray: &RayOf<R>,
        sphere: &SphereCertified<R>,
        widening: &Widening<R>,
    ) -> Nearness<R> {
        parallel_nearness(ray, Vec3(sphere.center) - ray.origin, &sphere.guard(), widening)
    }

    #[inline(always)]
    fn plane_nearness(
        ray: &RayOf<R>,
        plane: &PlaneCertified<R>,
        widening: &Widening<R>,
    ) -> Nearness<R> {
        FreeFilter::plane_nearness(ray, plane, widening)
    }
}

impl<R: Real> Filter<R> for FreeFilter {
    #[inline(always)]
    fn sphere_nearness(
        ray: &RayOf<R>,
        sphere: &SphereCertified<R>,
        widening: &Widening<R>,
    ) -> Nearness<R> {
        let l = offset(ray, sphere.center, sphere.center_low);
        let k = dot3(l, l) - sphere.q_high_or_r2;
        sphere_nearness(ray, l, &sphere.guard(), k, sphere.k_error, widening)
    }

    #[inline(always)]
    fn plane_nearness(
        ray: &RayOf<R>,
        plane: &PlaneCertified<R>,
        widening: &Widening<R>,
    ) -> Nearness<R> {
        let &PlaneCertified { n_offset_error, direction_error, .. } = plane;
        let normal = Vec3(plane.normal);
        let n_offset = dot3(offset(ray, plane.offset, plane.offset_low), normal);
        plane_nearness_at(ray, n_offset, n_offset_error, normal, direction_error, widening)
    }
}

/// The nearest of the objects that are tested one after the other. Planes have the ids after those of
/// `n_spheres`.
#[inline(always)]
pub(crate) fn nearest_listed<R: Real, F: Filter<R>>(
    ray: &RayOf<R>,
    spheres: &[SphereCertified<R>],
    planes: &[PlaneCertified<R>],
    n_spheres: u32,
    sphere_id: impl Fn(u32) -> u32,
    widening: &Widening<R>,
) -> Nearest<R> {
    let mut nearest = Nearest::NONE;
    for (i, sphere) in spheres.iter().enumerate() {
        nearest = nearest.nearer(F::sphere_nearness(ray, sphere, widening), sphere_id(i as u32));
    }
    for (i, plane) in planes.iter().enumerate() {
        let root = F::plane_nearness(ray, plane, widening);
        nearest = nearest.nearer(root, n_spheres + i as u32 + 1);
    }
    nearest
}
