//! The filter of the certified kernel: it proposes an object only where it is proven, and says
//! "undecided" elsewhere. Twin of `shaders/certified.wgsl`; the bounds are derived in
//! [`crate::guard`].

use bytemuck::{Pod, Zeroable};

use super::RayOf;
use crate::vec3::{Real, Vec3, dot3};

/// The id of a ray that the filter could not decide.
pub const UNDECIDED: u32 = u32::MAX;

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereCertified {
    /// Centre relative to the reference point, high part.
    pub center: [f32; 3],
    /// [`crate::guard::Guard::inner2`]
    pub inner2: f32,
    /// Centre relative to the reference point, low part.
    pub center_low: [f32; 3],
    /// [`crate::guard::Guard::outer2`]
    pub outer2: f32,
    /// Pixels: `k = l·l − r²`, exact sign, 0 on the surface. Lists: `r²`.
    pub k: f32,
    /// Lists: [`crate::guard::Guard::k_error`].
    pub k_error: f32,
    /// [`crate::guard::Guard::slack`]
    pub slack: f32,
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: f32,
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneCertified {
    /// Point of the plane relative to the reference point, high part.
    pub offset: [f32; 3],
    /// Pixels: `(a − o)·n`, exact sign, 0 in the plane.
    pub n_offset: f32,
    /// Point of the plane relative to the reference point, low part.
    pub offset_low: [f32; 3],
    /// Lists: [`crate::guard::plane_offset_error`].
    pub n_offset_error: f32,
    /// Normal, scaled by a power of two to a largest component in `1..2`.
    pub normal: [f32; 3],
    /// [`crate::guard::plane_direction_error`]
    pub direction_error: f32,
}

/// Where a root lies. `low = +∞`: a certain miss. `high = +∞`: not certain that there is a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<R> {
    /// No visible root lies below.
    pub low: R,
    /// The visible root lies not above.
    pub high: R,
}

/// The nearest candidate and the lower end of the second nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest<R> {
    /// Lower end of the nearest candidate.
    pub low: R,
    /// Upper end of the nearest candidate.
    pub high: R,
    /// Lower end of the second nearest candidate.
    pub second_low: R,
    /// Id of the nearest candidate, 0 for none.
    pub id: u32,
}

impl<R: Real> Nearest<R> {
    /// No candidate yet.
    pub const NONE: Self =
        Nearest { low: R::INFINITY, high: R::INFINITY, second_low: R::INFINITY, id: 0 };

    /// Takes one more object into account.
    #[inline(always)]
    pub fn nearer(self, root: Interval<R>, id: u32) -> Self {
        let is_nearer = root.low < self.low;
        let farther = if is_nearer { self.low } else { root.low };
        let second_low = self.second_low.min(farther);
        if is_nearer {
            Nearest { low: root.low, high: root.high, second_low, id }
        } else {
            Nearest { second_low, ..self }
        }
    }

    /// The object, [`UNDECIDED`] where the intervals leave it open.
    #[inline(always)]
    pub fn decide(&self) -> u32 {
        if self.id == 0 || self.high < self.second_low { self.id } else { UNDECIDED }
    }
}

/// `1 ∓ ε·WIDENING`, rounded away from 1.
#[derive(Clone, Copy, Debug)]
pub struct Widening<R> {
    /// Below 1.
    pub narrower: R,
    /// Above 1.
    pub wider: R,
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

/// What a ray's passage by a sphere says about the visible root.
#[derive(Clone, Copy, Debug)]
pub struct Passage<R> {
    /// Parameter of the point of the ray's line that is closest to the centre.
    pub s: R,
    /// `l·l − r²`
    pub k: R,
    /// Bound of the error of `k`.
    pub k_error: R,
    /// Bound of the error of `u`.
    pub slack: R,
    /// Bound of `r² − p²` for the lower end of `t`.
    pub low_chord2: R,
    /// Bound of `r² − p²` for the upper end of `t`.
    pub high_chord2: R,
    /// Whether there may be a visible root, given that the side of `k` is known.
    pub possible: bool,
    /// Whether there is one, given the same.
    pub certain: bool,
}

impl<R: Real> Passage<R> {
    /// The passage by no sphere at all.
    pub const NONE: Self = Passage {
        s: R::ZERO,
        k: R::ZERO,
        k_error: R::ZERO,
        slack: R::ZERO,
        low_chord2: R::ZERO,
        high_chord2: R::ZERO,
        possible: false,
        certain: false,
    };

    /// Whether the visible root is `u = |s| + h`, rather than `|k|/(a·u)`.
    #[inline(always)]
    fn root_is_u(s: R, k: R, k_error: R) -> bool {
        k <= k_error && s > R::ZERO
    }

    /// Whether it is certain on which side of the surface the ray starts.
    #[inline(always)]
    fn side_is_known(&self) -> bool {
        self.k.abs() > self.k_error
    }

    /// Lower end of the root; +∞ for a certain miss. With `PIXELS` the sign of `k` is exact and
    /// `k_error` 0: at `k = 0` the roots are 0 and `2s`.
    #[inline(always)]
    pub fn root_low<const PIXELS: bool>(&self, ray: &RayOf<R>, widening: &Widening<R>) -> R {
        let known = PIXELS || self.side_is_known();
        if !(self.possible || (!known && self.low_chord2 >= R::ZERO)) {
            return R::INFINITY;
        }
        if !known {
            return R::ZERO;
        }
        let u = self.s.abs() + (self.low_chord2 * ray.inv_a).sqrt();
        let low = if Self::root_is_u(self.s, self.k, self.k_error) {
            u - self.slack
        } else {
            (self.k.abs() - self.k_error) * ray.inv_a / (u + self.slack)
        };
        low * widening.narrower
    }

    /// Upper end of the root; +∞ where it is not certain that there is one.
    #[inline(always)]
    pub fn root_high<const PIXELS: bool>(&self, ray: &RayOf<R>, widening: &Widening<R>) -> R {
        let is_u = Self::root_is_u(self.s, self.k, self.k_error);
        let u = self.s.abs() + (self.high_chord2.max(R::ZERO) * ray.inv_a).sqrt();
        let u_low = u - self.slack;
        let known = PIXELS || self.side_is_known();
        if !(self.certain && (is_u || u_low > R::ZERO) && known) {
            return R::INFINITY;
        }
        let high =
            if is_u { u + self.slack } else { (self.k.abs() + self.k_error) * ray.inv_a / u_low };
        high * widening.wider
    }
}

/// The passage by the sphere at `l = c − o`, with `k = l·l − r²` known up to `k_error`.
#[inline(always)]
pub fn pass_by<R: Real>(
    ray: &RayOf<R>,
    l: Vec3<R>,
    k: R,
    k_error: R,
    guard: &GuardOf<R>,
) -> Passage<R> {
    let GuardOf { inner2, outer2, slack } = *guard;
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let inner = inner2 - m;
    let outer = outer2 - m;
    let inside = k < -k_error;
    let is_u = Passage::root_is_u(s, k, k_error);
    Passage {
        s,
        k,
        k_error,
        slack,
        low_chord2: if is_u { inner.max(R::ZERO) } else { outer },
        high_chord2: if is_u { outer } else { inner },
        possible: outer >= R::ZERO && (inside || s >= -slack),
        certain: inner >= R::ZERO && (inside || s > slack),
    }
}

/// The visible root of a plane: `t = n_offset / (d·n)`, with `n_offset` known up to
/// `n_offset_error`. With `PIXELS` that error is 0 and the sign exact.
#[inline(always)]
pub fn plane_interval<R: Real, const PIXELS: bool>(
    ray: &RayOf<R>,
    n_offset: R,
    n_offset_error: R,
    normal: Vec3<R>,
    direction_error: R,
    widening: &Widening<R>,
) -> Interval<R> {
    let numerator = n_offset.abs();
    let slope = dot3(ray.direction, normal);
    let denominator = if n_offset < R::ZERO { -slope } else { slope };
    let error = direction_error * ray.a.sqrt();
    let low = (numerator - n_offset_error) / (denominator + error) * widening.narrower;
    let high = (numerator + n_offset_error) / (denominator - error) * widening.wider;
    let known = numerator > n_offset_error;
    let possible = denominator > -error;
    let certain = known && denominator > error;
    let low = match (known, possible) {
        (true, true) => low,
        (false, _) if !PIXELS => R::ZERO,
        _ => R::INFINITY,
    };
    Interval { low, high: if certain { high } else { R::INFINITY } }
}

/// The object of a ray, or [`UNDECIDED`]. With `PIXELS` all rays start at the reference point.
#[inline(always)]
pub fn propose<const PIXELS: bool>(
    ray: &RayOf<f32>,
    spheres: &[SphereCertified],
    planes: &[PlaneCertified],
    widening: &Widening<f32>,
) -> u32 {
    let mut nearest = Nearest::NONE;
    let mut nearest_passage = Passage::NONE;
    for (i, sphere) in spheres.iter().enumerate() {
        let guard = GuardOf { inner2: sphere.inner2, outer2: sphere.outer2, slack: sphere.slack };
        let (l, k, k_error) = if PIXELS {
            (Vec3(sphere.center), sphere.k, 0.0)
        } else {
            let l = (Vec3(sphere.center) - ray.origin) + (Vec3(sphere.center_low) - ray.origin_low);
            (l, dot3(l, l) - sphere.k, sphere.k_error)
        };
        let passage = pass_by(ray, l, k, k_error, &guard);
        let low = passage.root_low::<PIXELS>(ray, widening);
        // The upper end waits until the nearest is known.
        nearest = nearest.nearer(Interval { low, high: f32::INFINITY }, i as u32 + 1);
        if nearest.id == i as u32 + 1 {
            nearest_passage = passage;
        }
    }
    nearest.high = nearest_passage.root_high::<PIXELS>(ray, widening);
    for (i, plane) in planes.iter().enumerate() {
        let normal = Vec3(plane.normal);
        let (n_offset, n_offset_error) = if PIXELS {
            (plane.n_offset, 0.0)
        } else {
            let l = (Vec3(plane.offset) - ray.origin) + (Vec3(plane.offset_low) - ray.origin_low);
            (dot3(l, normal), plane.n_offset_error)
        };
        let error = plane.direction_error;
        let root =
            plane_interval::<f32, PIXELS>(ray, n_offset, n_offset_error, normal, error, widening);
        nearest = nearest.nearer(root, (spheres.len() + i) as u32 + 1);
    }
    nearest.decide()
}
