//! A plane, exactly.

use super::{Place, Side};
use crate::exact::{Dyadic, ExactRay, Root, primitive, product3, real3, signum};
use crate::scene::Plane;

/// Numerator `N = (p − o)·n` and denominator `M = d·n` of a plane, for the ray's own (scaled)
/// origin and direction.
fn plane_quotient(ray: &ExactRay, plane: &Plane) -> Option<(Dyadic, Dyadic)> {
    let n = real3(plane.normal)?;
    Some((product3(&ray.to_point(plane.point)?, &n), product3(ray.direction(), &n)))
}

/// The root `t > 0`: `N/M`, written with a positive denominator. `M > 0` means that the ray runs along
/// the normal: it meets the back.
pub(super) fn visible_root(ray: &ExactRay, plane: &Plane) -> Option<(Root, Side)> {
    let (n, m) = plane_quotient(ray, plane)?;
    match (signum(&n), signum(&m)) {
        (1, 1) => Some((Root::quotient(n, m, ray.t_factor()), Side::Back)),
        (-1, -1) => Some((Root::quotient(-n, -m, ray.t_factor()), Side::Front)),
        _ => None,
    }
}

/// `nᵢ/‖n‖ = sgn(nᵢ)·√(nᵢ²·‖n‖²) / ‖n‖²`
pub(crate) fn plane_normal(plane: &Plane) -> Option<[Root; 3]> {
    let n = real3(plane.normal)?;
    let norm_squared = product3(&n, &n);
    if signum(&norm_squared) == 0 {
        return None;
    }
    Some(std::array::from_fn(|i| {
        let radicand = &n[i] * &n[i] * &norm_squared;
        Root::new(Dyadic::zero(), signum(&n[i]), radicand, norm_squared.clone(), 1)
    }))
}

/// The numbers of the plane's quotient, exactly, for the contract's `d`.
#[derive(Clone, Debug)]
pub struct PlaneNumbers {
    /// `(a − o)·n`.
    pub numerator: Root,
    /// `d·n`.
    pub denominator: Root,
}

/// The numbers of a ray and a plane; `None` where a number is not finite.
pub fn plane_numbers(ray: &ExactRay, plane: &Plane) -> Option<PlaneNumbers> {
    let (n, m) = plane_quotient(ray, plane)?;
    Some(PlaneNumbers {
        numerator: Root::ratio(n, ray.world_scale()),
        denominator: Root::ratio(m, ray.direction_scale()),
    })
}

/// The points of a plane, however long its normal is, and whichever of its points is named: the same for planes that are one.
/// Of the normal whole numbers without a common divisor, the first of which that is not 0 is positive. `None` for a normal of 0
/// and where a number is not finite.
pub(super) fn place(plane: &Plane) -> Option<Place> {
    let normal = primitive(&real3(plane.normal)?)?;
    let n = normal.each_ref().map(|x| Dyadic::from(x.clone()));
    let offset = product3(&real3(plane.point)?, &n).shortest();
    Some(Place::Plane(Box::new((normal, offset))))
}
