//! `t` and the normal of a hit that is known to exist.

use bytemuck::{Pod, Zeroable};

use super::nearness::{Foot, K, Place, PlaneF64, t_f32};
use super::{RayF64, Stage, StageRays};
use crate::exact::{ExactHit, ExactRay, Shape, visible_root};
use crate::guard::{self, InputError};
use crate::kernel::RayOf;
use crate::kernel::certified::{
    Nearness, Widening, closest_approach, half_chord_radius, normalized, plane_nearness,
};
use crate::scene::Object;
use crate::vec3::{Real, Vec3, dot3};

/// Largest error of an f64 normal before it is rounded to f32: with the rounding itself, `√3·2⁻²⁵`,
/// it stays below `2⁻²³`, also if it were twice as large; not four times.
pub const NORMAL_TOLERANCE: f64 = 1.0 / (1u64 << 25) as f64;
const _: () = assert!(NORMAL_TOLERANCE + 1.7321 / (1u64 << 25) as f64 <= 1.0 / (1u64 << 23) as f64);

/// `t` and the normal of a hit.
pub type Surface = (f32, [f32; 3]);

/// Those of a ray that hits nothing.
pub const MISS: Surface = (f32::INFINITY, [0.0; 3]);

/// An object as a ray's origin sees it, in numbers of f64 alone. The steps are the same for all rays,
/// so that they go side by side.
pub trait Sight: Pod {
    /// True for a sphere around the ray's origin.
    const IS_INSIDE: bool = false;
    /// `t` and the normal of a ray that hits it.
    fn surface(&self, ray: &RayOf<f64>, bounds: &Bounds) -> Found;
}

/// What the bounds of all hits of a picture share.
#[derive(Clone, Copy)]
pub struct Bounds {
    pub widening: Widening<f64>,
    pub input: InputError,
}

/// What f64 tells of a hit.
pub struct Found {
    /// Where the root is.
    root: Nearness<f64>,
    /// Whether the normal and the kind of root are certain.
    is_certain: bool,
    pub normal: Vec3<f64>,
    /// Bound of the normal's error.
    pub normal_error: f64,
}

impl Found {
    /// Bounds of `t`; infinite ones where there are none.
    #[inline(always)]
    pub fn t(&self, a: f64, widening: &Widening<f64>) -> (f64, f64) {
        let Nearness { low, high } = self.root;
        let (near, far) = (widening.narrower / (a * high), widening.wider / (a * low));
        if (low > 0.0) & (near > 0.0) { (near, far) } else { (0.0, f64::INFINITY) }
    }

    /// `t`, multiplied with `scale`, and the normal; a `t` of 0 where they are not certain.
    #[inline(always)]
    pub fn to_f32(&self, a: f64, scale: f64, widening: &Widening<f64>) -> Surface {
        let t = t_f32(a, self.root, scale, widening);
        (if self.is_certain { t } else { 0.0 }, self.normal.0.map(|component| component as f32))
    }
}

/// A sphere.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct SphereSight {
    l: [f64; 3],
    r: f64,
    /// Most that the halves of the chord may differ for a normal that is certain.
    most_width: f64,
    inner2: f64,
    outer2: f64,
    slack: f64,
    q_low: f64,
    q_high: f64,
    /// With the sign of `l·l − r²`; 0 where nothing is certain.
    pub k: f64,
}

/// A sphere that the ray's origin is outside of.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub struct Outside(pub SphereSight);

/// A sphere that the ray's origin is inside of.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub struct Inside(pub SphereSight);

impl SphereSight {
    /// `known` is `k` for the point that `place` is relative to.
    #[inline(always)]
    pub fn new(place: &Place, known: Option<K>, bounds: &Bounds) -> SphereSight {
        let Foot { l, k, r, distance, guard } = Foot::new(place, known, bounds.input);
        let (unit, input) = (guard::UNIT_F64, bounds.input);
        let q = bounds.widening.inverse(k.value.abs(), k.error);
        let is_certain = guard::sphere_in_range_f64(r, distance) & (k.value.abs() > k.error);
        SphereSight {
            l: l.0,
            r,
            most_width: guard::most_width(r, distance, unit, input, NORMAL_TOLERANCE),
            inner2: guard.inner2,
            outer2: guard.outer2,
            slack: guard.slack,
            q_low: q.low,
            q_high: q.high,
            k: if is_certain { k.value } else { 0.0 },
        }
    }

    /// Half the chords of a ray: of the inner radius, of the outer one, and the normal from that of
    /// the radius itself.
    #[inline(always)]
    fn chords(&self, ray: &RayOf<f64>, is_outside: bool) -> Chords {
        let &SphereSight { r, most_width, inner2, outer2, .. } = self;
        let l = Vec3(self.l);
        let (s, m) = closest_approach(ray.direction, ray.inv_a, l);
        let half = |r2: f64| (Real::max(r2 - m, 0.0) * ray.inv_a).sqrt();
        let (inner, outer) = (half(inner2), half(outer2));
        let width = outer - inner;
        Chords {
            s,
            inner,
            outer,
            is_hit: inner2 >= m,
            normal: normalized(half_chord_radius(ray, l, r, is_outside)),
            is_precise: (most_width > 0.0) & (width * width * ray.a <= most_width * most_width),
            // That of `guard::most_width` for the width that it has.
            normal_error: 1.01 * (NORMAL_TOLERANCE + (width * ray.a.sqrt() - most_width) / r),
        }
    }
}

/// See [`SphereSight::chords`].
struct Chords {
    s: f64,
    inner: f64,
    outer: f64,
    is_hit: bool,
    normal: Vec3<f64>,
    is_precise: bool,
    normal_error: f64,
}

impl Sight for Outside {
    /// [`crate::kernel::certified::outside_nearness`] without its branches.
    #[inline(always)]
    fn surface(&self, ray: &RayOf<f64>, _: &Bounds) -> Found {
        let Outside(sight) = self;
        let SphereSight { slack, q_low, q_high, .. } = *sight;
        let chords = sight.chords(ray, true);
        let low = ((chords.s - slack) + chords.inner) * q_low;
        let high = ((chords.s + slack) + chords.outer) * q_high;
        let is_certain = chords.is_hit & chords.is_precise & (sight.k > 0.0);
        let Chords { normal, normal_error, .. } = chords;
        Found { root: Nearness { low, high }, is_certain, normal, normal_error }
    }
}

impl Sight for Inside {
    const IS_INSIDE: bool = true;

    /// [`crate::kernel::certified::inside_nearness`] without its branches.
    #[inline(always)]
    fn surface(&self, ray: &RayOf<f64>, bounds: &Bounds) -> Found {
        let Inside(sight) = self;
        let SphereSight { slack, q_low, q_high, .. } = *sight;
        let chords = sight.chords(ray, false);
        let s = chords.s;
        let u_low = (s.abs() + chords.inner) - slack;
        let u_high = (s.abs() + chords.outer) + slack;
        let ahead_low = ray.inv_a / u_high * bounds.widening.narrower;
        let ahead_high = ray.inv_a / u_low * bounds.widening.wider;
        let ahead_high = if u_low > 0.0 { ahead_high } else { f64::LARGEST };
        let root = Nearness {
            low: if s > 0.0 { ahead_low } else { u_low * q_low },
            high: if s > 0.0 { ahead_high } else { u_high * q_high },
        };
        let is_certain = chords.is_precise & (sight.k < 0.0);
        Found { root, is_certain, normal: chords.normal, normal_error: chords.normal_error }
    }
}

/// A plane.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneSight {
    /// Away from the origin.
    away: [f64; 3],
    /// Unit length, either way.
    unit: [f64; 3],
    direction_error: f64,
    q_low: f64,
    q_high: f64,
}

impl PlaneSight {
    pub fn new(plane: &PlaneF64, ray: &RayF64, bounds: &Bounds) -> PlaneSight {
        let PlaneF64 { normal, unit, direction_error, .. } = *plane;
        let (offset, error) = plane.offset(ray, bounds.input);
        let q = match offset.abs() > error {
            true => bounds.widening.inverse(offset.abs(), error),
            false => Nearness { low: 0.0, high: 0.0 },
        };
        let away = if offset < 0.0 { -normal } else { normal };
        PlaneSight { away: away.0, unit: unit.0, direction_error, q_low: q.low, q_high: q.high }
    }
}

impl Sight for PlaneSight {
    #[inline(always)]
    fn surface(&self, ray: &RayOf<f64>, _: &Bounds) -> Found {
        let q = Nearness { low: self.q_low, high: self.q_high };
        let away = dot3(ray.direction, Vec3(self.away));
        let root = plane_nearness(ray, away, self.direction_error, q);
        let unit = Vec3(self.unit);
        let normal = if dot3(unit, ray.direction) > 0.0 { -unit } else { unit };
        let normal_error = guard::steps::NORMALIZED * guard::UNIT_F64;
        Found { root, is_certain: true, normal, normal_error }
    }
}

impl Stage<'_> {
    /// `t` and normal in f64, or `None` where their bounds are too wide.
    pub fn surface_f64(&self, ray: &RayF64, id: u32, object: Object) -> Option<Surface> {
        let scale = ray.scale();
        if !(self.usable && scale.is_normal()) {
            return None;
        }
        let bounds = self.bounds;
        let found = match object {
            Object::Sphere(sphere) => {
                let place = Place::new(sphere, ray.reference, ray.ray.origin);
                let sight = SphereSight::new(&place, self.known_k(id, sphere), &bounds);
                match sight.k > 0.0 {
                    true => Outside(sight).surface(&ray.ray, &bounds),
                    false => Inside(sight).surface(&ray.ray, &bounds),
                }
            }
            Object::Plane(_) => {
                PlaneSight::new(self.plane(id), ray, &bounds).surface(&ray.ray, &bounds)
            }
        };
        let (t, normal) = found.to_f32(ray.ray.a, scale, &bounds.widening);
        (t > 0.0).then_some((t, normal))
    }

    /// Those that neighbours in a row give; what these leave open is better known alone.
    pub fn surface_in_row(&self, index: usize, id: u32) -> Option<Surface> {
        let StageRays::Pixels { pixels, camera, .. } = &self.rays else { return None };
        let (x, y) = pixels.xy(index);
        self.row_sight(id)?.find_one(camera, pixels.offset2(x, y))
    }

    /// `t` and normal of a hit that is known to exist: in f64, else exactly.
    pub fn surface(&self, index: usize, id: u32) -> Option<Surface> {
        let object = self.scene.object(id)?;
        if let Some(surface) = self.surface_in_row(index, id) {
            return Some(surface);
        }
        if let Some(surface) = self.surface_f64(&self.ray_f64(index), id, object) {
            return Some(surface);
        }
        let ray = self.exact_ray(index);
        let shape = Shape::from(object);
        let visible = visible_root(&ray, &shape);
        debug_assert!(visible.is_some(), "object {id} was decided for ray {index} but is not hit");
        let (root, side) = visible?;
        Some(exact_surface(&ray, &ExactHit { id, root, side }, &shape))
    }
}

fn exact_surface(ray: &ExactRay, hit: &ExactHit, shape: &Shape) -> Surface {
    (hit.t_f32(), hit.normal_f32(ray, shape))
}
