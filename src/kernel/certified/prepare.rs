//! Scene → records, with the bounds of each object.

use bytemuck::Zeroable;
use glam::DVec3;

use super::records::{PlaneCertified, SphereCertified, SphereFar};
use crate::exact::{ExactRay, Root, plane_numbers, sphere_numbers};
use crate::guard::{self, Guard, InputError, Reach};
use crate::kernel::Lists;
use crate::kernel::coordinates::{Scaled, split};
use crate::num::{Float, Mask, Real, V3};
use crate::rays::{Bundle, Pixels, Ray, Rays, look_at_all};
use crate::scene::{Plane, Scene, Sphere};

/// All objects of a scene, for these rays.
pub fn objects(
    scene: &Scene,
    rays: &Rays,
    reference: DVec3,
) -> Lists<SphereCertified, PlaneCertified> {
    Frame::new(rays, reference).objects(scene, scene.spheres.iter())
}

/// Largest distance of an origin from the reference point.
pub fn farthest_origin(rays: &[Ray], reference: DVec3) -> f64 {
    let distance = |ray: &Ray| guard::length_bound(ray.origin - reference);
    look_at_all(rays, 0.0, distance, f64::max)
}

/// What [`SphereFar`] has of a sphere, before it is rounded.
pub struct Leaf<R> {
    /// The first two of a guard.
    pub inner2: R,
    /// The other radius.
    pub outer2: R,
    /// Either, as the rays ask for.
    pub q_or_slack: R,
}

impl Leaf<f64> {
    /// The inner radius rounded down, everything else up.
    #[inline(always)]
    pub fn to_f32(&self, l: V3<f64>, id: u32) -> SphereFar {
        SphereFar {
            center: l.0.map(|component| component as f32),
            inner2: guard::round_down(self.inner2),
            outer2: guard::round_up(self.outer2),
            q_or_slack: guard::round_up(self.q_or_slack),
            id,
            padding: 0,
        }
    }
}

/// The point that the numbers are relative to, and how far the rays are from it.
pub struct Frame {
    bundle: Bundle,
    /// The point.
    pub reference: DVec3,
    /// Largest distance of an origin from the reference point.
    farthest_origin: f64,
    input: InputError,
    /// Of the rays that each ray stands for.
    reach: Reach,
    /// True where the bounds hold for these rays at all.
    pub in_range: bool,
}

/// Largest relative error of `k` and of `(a − o)·n` that their f32 may hide. No test sees it halved: exact
/// arithmetic finds a few more.
const OFFSET_TOLERANCE: f64 = 1.0 / (1u64 << 24) as f64;

/// Smallest magnitude of `k` that leaves f32 room above its subnormals. No test sees it halved: these
/// begin at `2⁻¹²⁶`.
const SMALLEST_K: f64 = 1.0 / (1u128 << 100) as f64;

/// Smallest magnitude of `(a − o)·n`: its inverse leaves f32 room for `|n|` and the longest `d`, `2¹²²`
/// of `2¹²⁷`, so that no test sees it halved.
const SMALLEST_OFFSET: f64 = 1.0 / guard::LARGEST_NEARNESS;

/// Largest magnitude of them: that of `k` at the largest distance. No test sees it halved: the range may be smaller.
const LARGEST_OFFSET: f64 = guard::LARGEST_F32 * guard::LARGEST_F32;

impl Frame {
    /// The frame of these rays, in which a scene stands.
    pub fn new(rays: &Rays, reference: DVec3) -> Frame {
        match rays {
            Rays::Pixels(pixels) => {
                let farthest_origin = pixels.spread();
                Frame {
                    bundle: rays.bundle(),
                    reference,
                    farthest_origin,
                    input: guard::input_of(pixels.view.lens),
                    reach: Reach::default(),
                    in_range: pixels.is_in_range() && farthest_origin <= guard::LARGEST_F32,
                }
            }
            Rays::List(rays) => Frame::of_list(reference, farthest_origin(rays, reference)),
        }
    }

    /// That of rays of a list with origins up to `farthest_origin` from a point.
    pub fn of_list(reference: DVec3, farthest_origin: f64) -> Frame {
        Frame {
            bundle: Bundle::Free,
            reference,
            farthest_origin,
            input: guard::LIST,
            reach: Reach::default(),
            in_range: farthest_origin <= guard::LARGEST_F32,
        }
    }

    /// The frame of squares of a picture's pixels, of which the ray of the middle stands for all within `reach`;
    /// `None` where that is too far.
    pub fn of_squares(pixels: &Pixels, reach: Reach) -> Option<Frame> {
        let frame = Frame::new(&Rays::Pixels(*pixels), pixels.view.position);
        let is_small = frame.in_range && reach.turned <= guard::LARGEST_TURN;
        is_small.then_some(Frame { reach, ..frame })
    }

    /// Some spheres of a scene, and its planes.
    pub fn objects<'a>(
        &self,
        scene: &Scene,
        spheres: impl Iterator<Item = &'a Sphere>,
    ) -> Lists<SphereCertified, PlaneCertified> {
        Lists {
            spheres: spheres.map(|sphere| self.sphere(sphere)).collect(),
            planes: scene.planes.iter().map(|plane| self.plane(plane)).collect(),
        }
    }

    /// True where the lean filter of a picture's tree suits a sphere.
    fn is_far(&self, sphere: &Sphere, longest: f64) -> bool {
        let r = sphere.radius.abs();
        let l = sphere.center - self.reference;
        let distance = guard::length_bound(l);
        let k = self.sphere_k(sphere, l);
        r == 0.0
            || guard::sphere_in_range_f32(r, distance)
                && k_in_range(k, r + distance)
                && guard::is_far(&Guard::new(r, distance, f32::UNIT, self.input), k, longest)
    }

    /// A sphere as the leaf of a picture's tree; `None` where it doesn't suit one. Parallel rays ask
    /// that f64 knows `k` of the camera's position well: exact arithmetic should find it once, not once
    /// a ray.
    pub fn leaf(&self, sphere: &Sphere, id: u32, longest: f64) -> Option<SphereFar> {
        let l = sphere.center - self.reference;
        let (leaf, is_known) = self.leaves(V3(l.to_array()), sphere.radius.abs(), longest);
        if is_known {
            return Some(leaf.to_f32(V3(l.to_array()), id));
        }
        if self.bundle == Bundle::Parallel {
            return None;
        }
        // Exact arithmetic may know its `k`.
        let distance = guard::length_bound(l) + self.farthest_origin;
        let k = self.sphere_k(sphere, l);
        let is_suited = self.is_far(sphere, longest) && sphere.radius != 0.0;
        let inverse = guard::far_inverse(k);
        let guard = Guard::new(sphere.radius.abs(), distance, f32::UNIT, self.input);
        let Guard { inner2, outer2, .. } = guard;
        is_suited.then(|| Leaf { inner2, outer2, q_or_slack: inverse }.to_f32(V3(l.to_array()), id))
    }

    /// Spheres at `l` from the reference point as leaves, and which of them f64 is sure of.
    #[inline(always)]
    pub fn leaves<R: Real<One = f64>>(&self, l: V3<R>, r: R, longest: f64) -> (Leaf<R>, R::Mask) {
        let distance = guard::length_bounds(l) + R::lit(self.farthest_origin);
        let [inner2, outer2, slack, _] = Guard::numbers(r, distance, f32::UNIT, self.input);
        let (l2, r2) = (l.dot(l), r * r);
        let k = l2 - r2;
        let largest = R::lit(guard::LARGEST_F32);
        let is_in_range =
            R::lit(guard::SMALLEST_RADIUS_F32).le(r).and(r.le(largest)).and(distance.le(largest));
        let error = R::lit(guard::K_ERROR * f64::UNIT) * (l2 + r2);
        let (tolerance, q_or_slack, is_far) = match self.bundle {
            Bundle::Parallel => (guard::K_TOLERANCE, slack, is_in_range),
            Bundle::Point | Bundle::Free => {
                let is_in_range = R::lit(SMALLEST_K)
                    .le(k)
                    .and(k.le(R::lit(LARGEST_OFFSET)))
                    .and((r + distance).le(k * R::lit(guard::LARGEST_NEARNESS)));
                let is_far = (slack * R::lit(longest)).le(R::lit(guard::FAR) * k.sqrt());
                (OFFSET_TOLERANCE, guard::far_inverse(k), is_in_range.and(is_far))
            }
        };
        let is_known = error.le(R::lit(tolerance) * k.abs());
        (Leaf { inner2, outer2, q_or_slack }, is_in_range.and(is_known).and(is_far))
    }

    /// Any ray, for exact statements about the reference point.
    fn exact_ray(&self) -> ExactRay {
        ExactRay::new(&Ray { origin: self.reference, direction: DVec3::X })
    }

    /// A sphere that is tested by itself.
    pub fn sphere(&self, sphere: &Sphere) -> SphereCertified {
        let r = sphere.radius.abs();
        if r == 0.0 {
            return SphereCertified::never(self.bundle);
        }
        let l = sphere.center - self.reference;
        let distance = guard::length_bound(l) + self.farthest_origin;
        let (k_or_r2, k_in_range) = match self.bundle {
            Bundle::Point => {
                let k = self.sphere_k(sphere, l);
                (k, k_in_range(k, r + distance))
            }
            Bundle::Parallel | Bundle::Free => (r * r, true),
        };
        if !(guard::sphere_in_range_f32(r, distance) && k_in_range) {
            return SphereCertified::open(self.bundle);
        }
        let (center, center_low) = self.split(l);
        let [inner2, outer2, slack, k_error] =
            Guard::new(r, distance, f32::UNIT, self.reach.widen(self.input, distance, f32::UNIT))
                .round_to_f32();
        let (q_low, q_high_or_r2) = match self.bundle {
            Bundle::Point => guard::inverse_f32(k_or_r2),
            Bundle::Parallel => (0.0, 0.0),
            Bundle::Free => (0.0, k_or_r2 as f32),
        };
        SphereCertified { center, inner2, center_low, outer2, slack, q_low, q_high_or_r2, k_error }
    }

    /// High and low part. Parallel rays, whose origins are rounded more than once, take the high
    /// part alone.
    fn split(&self, l: DVec3) -> ([f32; 3], [f32; 3]) {
        match self.bundle {
            Bundle::Parallel => (l.as_vec3().to_array(), [0.0; 3]),
            Bundle::Point | Bundle::Free => split(l),
        }
    }

    /// `l·l − r²` with exact sign or NaN; in f64 where its error is small enough, else exactly.
    #[inline(always)]
    fn sphere_k(&self, sphere: &Sphere, l: DVec3) -> f64 {
        let (l2, r2) = (l.length_squared(), sphere.radius * sphere.radius);
        let k = l2 - r2;
        let error = guard::K_ERROR * f64::UNIT * (l2 + r2);
        if error <= OFFSET_TOLERANCE * k.abs() {
            return k;
        }
        sphere_numbers(&self.exact_ray(), sphere.center, sphere.radius)
            .map_or(f64::NAN, |numbers| with_exact_sign(&numbers.k))
    }

    fn plane(&self, plane: &Plane) -> PlaneCertified {
        if plane.normal == DVec3::ZERO {
            return PlaneCertified::never();
        }
        let scaled = Scaled::new(plane.normal);
        let normal = scaled.rounded();
        let n_length = guard::length_bound(normal);
        let l = plane.point - self.reference;
        let distance = guard::length_bound(l) + self.farthest_origin;
        let n_offset = match self.bundle {
            Bundle::Point => self.plane_offset(plane, l, scaled),
            Bundle::Parallel | Bundle::Free => 0.0,
        };
        if !(guard::plane_in_range_f32(distance) && offset_in_range(n_offset)) {
            return PlaneCertified::open();
        }
        let (offset, offset_low) = self.split(l);
        let input = self.reach.widen(self.input, distance, f32::UNIT);
        let [n_offset_error, direction_error] = [
            guard::plane_offset_error(n_length, distance, f32::UNIT, input, guard::TINY_F32),
            guard::plane_direction_error(n_length, f32::UNIT, input),
        ]
        .map(guard::round_up);
        let (q_low, q_high) = self.reach.inverse_f32(n_offset.abs());
        let away = if n_offset < 0.0 { -normal } else { normal };
        PlaneCertified {
            offset,
            q_low,
            offset_low,
            q_high,
            normal: away.as_vec3().to_array(),
            direction_error,
            n_offset_error,
            padding: [0.0; 3],
        }
    }

    /// `(a − o)·n` with exact sign or NaN; in f64 where its error is small enough, else exactly.
    fn plane_offset(&self, plane: &Plane, l: DVec3, scaled: Scaled) -> f64 {
        let normal = scaled.rounded();
        let n_offset = l.dot(normal);
        let lengths = guard::length_bound(l) * guard::length_bound(normal);
        // With what underflows.
        let error = guard::N_ERROR * f64::UNIT * lengths + f64::MIN_POSITIVE;
        if error <= OFFSET_TOLERANCE * n_offset.abs() {
            return n_offset;
        }
        // Of an exactly scaled normal, rounding the product to f64 costs no digits.
        let (normal, exponent) = match scaled.exact() {
            Some(normal) => (normal, 0),
            None => (plane.normal, scaled.exponent()),
        };
        plane_numbers(&self.exact_ray(), plane.point, normal).map_or(f64::NAN, |numbers| {
            let numerator = with_exact_sign(&numbers.numerator);
            let scaled = numerator * 2f64.powi(-exponent);
            if scaled == 0.0 && numerator != 0.0 { f64::NAN } else { scaled }
        })
    }
}

impl<R: Zeroable + From<f32>> SphereCertified<R> {
    /// A sphere of radius 0, seen from outside, where no line comes within −1.
    pub fn never(bundle: Bundle) -> Self {
        let q_high_or_r2 = match bundle {
            Bundle::Point | Bundle::Parallel => 1.0,
            Bundle::Free => -1.0,
        };
        SphereCertified {
            inner2: (-1.0).into(),
            outer2: (-1.0).into(),
            slack: 1.0.into(),
            q_low: 1.0.into(),
            q_high_or_r2: q_high_or_r2.into(),
            ..Self::zeroed()
        }
    }

    /// A sphere that is out of range: as seen from outside, it may be nearer than everything; see
    /// guard's "Range".
    pub fn open(bundle: Bundle) -> Self {
        // Above every `m` of parallel rays, which start beside it.
        let outer2 = if bundle == Bundle::Parallel { guard::UNKNOWN } else { 0.0 };
        let largest = guard::LARGEST_F32 as f32;
        SphereCertified {
            inner2: (-1.0).into(),
            outer2: outer2.into(),
            slack: largest.into(),
            q_low: 1.0.into(),
            q_high_or_r2: largest.into(),
            k_error: guard::UNKNOWN.into(),
            ..Self::zeroed()
        }
    }
}

impl<R: Zeroable + From<f32>> PlaneCertified<R> {
    /// A plane without a normal.
    pub fn never() -> Self {
        PlaneCertified { n_offset_error: (-1.0).into(), ..Self::zeroed() }
    }

    /// A plane that is out of range: as seen along the normal, it may be nearer than everything.
    pub fn open() -> Self {
        let largest = guard::LARGEST_F32 as f32;
        PlaneCertified {
            q_low: 1.0.into(),
            q_high: largest.into(),
            direction_error: largest.into(),
            n_offset_error: guard::UNKNOWN.into(),
            ..Self::zeroed()
        }
    }
}

/// The number in f64; NaN where it is not 0 but f64 says so.
fn with_exact_sign(exact: &Root) -> f64 {
    match exact.to_f64() {
        0.0 if exact.signum() != 0 => f64::NAN,
        rounded => rounded,
    }
}

/// True where neither `(a − o)·n` nor its inverse leaves f32's range.
pub fn offset_in_range(offset: f64) -> bool {
    offset == 0.0 || (SMALLEST_OFFSET..=LARGEST_OFFSET).contains(&offset.abs())
}

/// True where neither `k` nor a nearness `u/k`, with `u` up to `2·reach`, leaves f32's range.
#[inline(always)]
pub fn k_in_range(k: f64, reach: f64) -> bool {
    k == 0.0
        || (SMALLEST_K..=LARGEST_OFFSET).contains(&k.abs())
            && reach <= k.abs() * guard::LARGEST_NEARNESS
}
