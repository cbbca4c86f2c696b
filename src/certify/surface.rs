//! `t` and the normal of a hit that is known to exist.

use bytemuck::{Pod, Zeroable};

use super::nearness::{Foot, K, Place, PlaneF64, t_f32};
use super::{RayF64, Stage, StageRays};
use crate::exact::{ExactHit, ExactRay, Shape, visible_root};
use crate::guard::{self, InputError, steps};
use crate::kernel::RayOf;
use crate::kernel::certified::{Nearness, Widening, closest_approach, plane_nearness};
use crate::scene::{Object, Plane};
use crate::shape::plane_normal;
use crate::vec3::{Real, Vec3, dot3};

/// Largest error of an f64 normal that is of use. No bound: what each is off by decides whether its components have
/// one nearest f32.
pub const NORMAL_TOLERANCE: f64 = 1.0 / (1u64 << 25) as f64;

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
    /// Where it is, relative to the ray's origin, and a bound of the error.
    pub at: Vec3<f64>,
    pub error: f64,
    pub normal: Vec3<f64>,
    /// Bound of the normal's error.
    pub normal_error: f64,
    /// The exact normal, each component rounded to the nearest f32, where all is certain.
    nearest: [f32; 3],
}

/// The f32 that each component is nearest to if it is off by no more than `error`, and whether there is one for each.
#[inline(always)]
fn nearest_f32(normal: Vec3<f64>, error: Vec3<f64>) -> ([f32; 3], bool) {
    let (mut nearest, mut is_one) = ([0.0; 3], true);
    for (nearest, (component, error)) in nearest.iter_mut().zip(normal.0.iter().zip(error.0)) {
        // The ends are rounded, too.
        let error = error + guard::UNIT_F64 * component.abs();
        *nearest = (component - error) as f32;
        is_one &= *nearest == (component + error) as f32;
    }
    (nearest, is_one)
}

/// The exact unit normal of a plane, each component rounded to the nearest f32. `unit` is the same in f64.
pub fn unit_f32(plane: &Plane, unit: Vec3<f64>) -> [f32; 3] {
    if let (nearest, true) = nearest_f32(unit, Vec3([steps::NORMALIZED * guard::UNIT_F64; 3])) {
        return nearest;
    }
    let exact = plane_normal(plane.normal);
    exact.map_or([0.0; 3], |normal| normal.map(|component| component.to_f32()))
}

/// Where a root is, relative to the ray's origin, and a bound of the error, which is infinite where nothing is known.
///
/// With `t` between two bounds, `Δ` half their difference, and its middle, `t·d` is off by `|d|·Δ`, by the direction's
/// `δε·t|d|`, and by the rounding of the middle, of the product and of the sum with an origin, `ε·t|d|` each. What comes with
/// the origin is left to those who add it.
#[inline(always)]
fn reach(ray: &RayOf<f64>, root: Nearness<f64>, bounds: &Bounds) -> (Vec3<f64>, f64) {
    let Bounds { widening, input } = bounds;
    let (near, far) =
        (widening.narrower / (ray.a * root.high), widening.wider / (ray.a * root.low));
    let is_known = (root.low > 0.0) & (near > 0.0);
    let (near, far) = if is_known { (near, far) } else { (0.0, f64::INFINITY) };
    let half = (far - near) / 2.0;
    let t = near + half;
    let rounding = guard::UNIT_F64 * (input.direction + steps::POINT) * t;
    (ray.direction * t, guard::ROOM * (ray.a.sqrt() * (half + rounding)))
}

impl Found {
    /// `t`, multiplied with `scale`, and the normal; a `t` of 0 where they are not certain.
    #[inline(always)]
    pub fn to_f32(&self, a: f64, scale: f64, widening: &Widening<f64>) -> Surface {
        let t = t_f32(a, self.root, scale, widening);
        (if self.is_certain { t } else { 0.0 }, self.nearest)
    }
}

/// A sphere.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct SphereSight {
    l: [f64; 3],
    inverse_radius: f64,
    /// What `l` is off by, and each of its components.
    offset_error: f64,
    offset_errors: [f64; 3],
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
        let offset_error = input.offset * unit * distance;
        // From the origin itself a component is but a difference that is rounded.
        let is_there = place.origin == [0.0; 3];
        let offset_errors =
            l.0.map(|component| if is_there { unit * component.abs() } else { offset_error });
        SphereSight {
            l: l.0,
            inverse_radius: 1.0 / r,
            offset_error,
            offset_errors,
            inner2: guard.inner2,
            outer2: guard.outer2,
            slack: guard.slack,
            q_low: q.low,
            q_high: q.high,
            k: if is_certain { k.value } else { 0.0 },
        }
    }

    /// Half the chords of a ray: of the inner radius, and of the outer one.
    #[inline(always)]
    fn chords(&self, ray: &RayOf<f64>) -> Chords {
        let &SphereSight { inner2, outer2, .. } = self;
        let l = Vec3(self.l);
        let (s, m) = closest_approach(ray.direction, ray.inv_a, l);
        let half = |r2: f64| (Real::max(r2 - m, 0.0) * ray.inv_a).sqrt();
        Chords { s, inner: half(inner2), outer: half(outer2), is_hit: inner2 >= m }
    }

    /// What is found where its root is, with the normal `(t·d − l)/r`: off by what the point and `l` are, by the difference's
    /// rounding, and by that of the inverse and the product, each `ε` of the component. The shorter way: where the eye is
    /// near a large sphere, half a chord would be off by far more than `t·d`.
    #[inline(always)]
    fn found(
        &self,
        ray: &RayOf<f64>,
        root: Nearness<f64>,
        bounds: &Bounds,
        is_inside: bool,
        is_certain: bool,
    ) -> Found {
        let (at, error) = reach(ray, root, bounds);
        let outward = (at - Vec3(self.l)) * self.inverse_radius;
        let normal = if is_inside { -outward } else { outward };
        let rounding = steps::NORMAL_OF_POINT * guard::UNIT_F64;
        let of_point = (error + self.offset_error) * self.inverse_radius;
        let normal_error = guard::ROOM * (of_point + rounding);
        let mut errors = Vec3::ZERO;
        for axis in 0..3 {
            let of_point = (error + self.offset_errors[axis]) * self.inverse_radius;
            errors.0[axis] = guard::ROOM * (of_point + rounding * normal.0[axis].abs());
        }
        let (nearest, is_one) = nearest_f32(normal, errors);
        let is_certain = is_certain & is_one;
        Found { root, is_certain, at, error, normal, normal_error, nearest }
    }
}

/// See [`SphereSight::chords`].
struct Chords {
    s: f64,
    inner: f64,
    outer: f64,
    is_hit: bool,
}

impl Sight for Outside {
    /// [`crate::kernel::certified::outside_nearness`] without its branches.
    #[inline(always)]
    fn surface(&self, ray: &RayOf<f64>, bounds: &Bounds) -> Found {
        let Outside(sight) = self;
        let SphereSight { slack, q_low, q_high, .. } = *sight;
        let chords = sight.chords(ray);
        let low = ((chords.s - slack) + chords.inner) * q_low;
        let high = ((chords.s + slack) + chords.outer) * q_high;
        let is_certain = chords.is_hit & (sight.k > 0.0);
        sight.found(ray, Nearness { low, high }, bounds, false, is_certain)
    }
}

impl Sight for Inside {
    const IS_INSIDE: bool = true;

    /// [`crate::kernel::certified::inside_nearness`] without its branches.
    #[inline(always)]
    fn surface(&self, ray: &RayOf<f64>, bounds: &Bounds) -> Found {
        let Inside(sight) = self;
        let SphereSight { slack, q_low, q_high, .. } = *sight;
        let chords = sight.chords(ray);
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
        sight.found(ray, root, bounds, true, sight.k < 0.0)
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
    /// The same, exactly and rounded to f32.
    nearest: [f64; 3],
    direction_error: f64,
    q_low: f64,
    q_high: f64,
}

impl PlaneSight {
    pub fn new(plane: &PlaneF64, ray: &RayF64, bounds: &Bounds) -> PlaneSight {
        let PlaneF64 { normal, unit, unit_f32, direction_error, .. } = *plane;
        let (offset, error) = plane.offset(ray, bounds.input);
        let q = match offset.abs() > error {
            true => bounds.widening.inverse(offset.abs(), error),
            false => Nearness { low: 0.0, high: 0.0 },
        };
        let away = if offset < 0.0 { -normal } else { normal };
        let (unit, nearest) = (unit.0, unit_f32.map(f64::from));
        PlaneSight { away: away.0, unit, nearest, direction_error, q_low: q.low, q_high: q.high }
    }
}

impl Sight for PlaneSight {
    #[inline(always)]
    fn surface(&self, ray: &RayOf<f64>, bounds: &Bounds) -> Found {
        let q = Nearness { low: self.q_low, high: self.q_high };
        let away = dot3(ray.direction, Vec3(self.away));
        let root = plane_nearness(ray, away, self.direction_error, q);
        let unit = Vec3(self.unit);
        let is_along = dot3(unit, ray.direction) > 0.0;
        let normal = if is_along { -unit } else { unit };
        let normal_error = steps::NORMALIZED * guard::UNIT_F64;
        // Not `−0`.
        let nearest = self.nearest.map(|x| if is_along { 0.0 - x } else { x } as f32);
        let (at, error) = reach(ray, root, bounds);
        Found { root, is_certain: true, at, error, normal, normal_error, nearest }
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

    /// `t` and normal of a hit that is known to exist: in f64, else with more digits, else exactly.
    pub fn surface(&self, index: usize, id: u32) -> Option<Surface> {
        let object = self.scene.object(id)?;
        if let Some(surface) = self.surface_in_row(index, id) {
            return Some(surface);
        }
        if let Some(surface) = self.surface_f64(&self.ray_f64(index), id, object) {
            return Some(surface);
        }
        if let Some(surface) = self.surface_in_balls(index, id, object) {
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

pub(super) fn exact_surface(ray: &ExactRay, hit: &ExactHit, shape: &Shape) -> Surface {
    (hit.t_f32(), hit.normal_f32(ray, shape))
}
