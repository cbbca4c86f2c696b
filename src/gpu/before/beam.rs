//! The way from a point to a lamp in f64 as a device finds it: how steep the light falls, and what is in its way. Twin of
//! `shaders/beam.wgsl`, with the bounds of [`crate::seen::shadow`], whose `E` is that of this beam.
//!
//! # Shells
//! Where the beam starts on a sphere `(c₁, r₁)` and this one is nearly the same, `|p − c|² − r²` is known much better than
//! from a distance: with `a = c₁ − c` and `v = p − c₁`, whose length is `r₁` exactly, it is
//! `(r₁ − r)(r₁ + r) + a·(a + 2v)`. Its errors are `2|a|E` for `v`, with the place of `c₁` in `E`, and in units `ε`: 3 of the
//! first product; of `|a|(|a| + 2|v|)` 2 for `a`, 1 for the difference in `v`, 1 for `a + 2v` and 3 for the dot product; and of
//! both 1 for the sum: less than [`OF_SHELL`]. So a beam surely starts outside or inside:
//! - from inside, it is in the way where its end is outside, and not where its end is inside;
//! - from outside, it is not in the way if the beam leaves: `l·w < 0`, which is off by `E|w|`, where `14ε|l|` is more than the
//!   `3ε|l|` of the dot product, and by `|l|` times what the ends of `w` are off, `2E`.

use crate::guard::host::Bounded;
use crate::guard::{ROOM, UNIT_F64};
use crate::seen::shadow::{OF_LEVER, OF_OFFSET, OF_PLACE, OF_PLANE, OF_SLOPE, OF_SQUARES, OF_WAY};
use crate::vec3::{Vec3, dot3};
#[cfg(feature = "gpu")]
use crate::{guard, seen::shadow};

/// [`OF_SQUARES`] in f64.
pub const RELATIVE: f64 = OF_SQUARES * UNIT_F64;

/// Numbers up to this and above its inverse have squares in range.
pub const LARGEST: f64 = <f64 as Bounded>::LARGEST_ROOT;

/// Of the parts of the side of a shell on which a beam starts.
const OF_SHELL: f64 = 9.0;

/// Of `n·ω` on a device, where division and root are not as good as the host's.
#[cfg(feature = "gpu")]
const OF_COSINE_WIDE: f64 = 13.0;
#[cfg(feature = "gpu")]
const _: () = assert!(guard::steps::DOT + guard::steps::NORMALIZED_WIDE < OF_COSINE_WIDE);

/// The constants of the twin in `shaders/beam.wgsl`, by their names there. A device rounds each sum and
/// product to nearest as the host does. Its roots are parts of bounds alone, and its division is off by up
/// to 2.5 units where the host's is by a half: step 2 of [`crate::guard`] has room for that, and so has
/// [`ROOM`]. Only the cosine has a bound of its own.
#[cfg(feature = "gpu")]
pub const FOR_DEVICE: [(&str, f64); 11] = [
    ("RELATIVE", RELATIVE),
    ("BEYOND", LARGEST),
    ("NEGLIGIBLE", 1.0 / LARGEST),
    ("OF_WAY", OF_WAY),
    ("OF_OFFSET", OF_OFFSET),
    ("OF_PLACE", OF_PLACE),
    ("OF_PLANE", OF_PLANE),
    ("OF_SLOPE", OF_SLOPE),
    ("OF_SHELL", OF_SHELL),
    ("OF_COSINE", OF_COSINE_WIDE),
    ("OF_TURN", shadow::OF_TURN),
];

/// The same where the twin is in f32, for [`Beam::to_point`], [`Beam::to_eye`], [`Beam::to_sun`] and [`Beam::cosine`], whose
/// errors are those of f64 in another unit:
/// - The host rounds a lamp's place once, half a unit of the `ε|L|` that are granted, and a sun's direction, half a unit
///   more in its cosine. The cosine's bounds are a sum, 1 more.
/// - What is in a beam's way [`super::narrow`] finds, with constants of its own for `|w|`.
/// - Places and lamps that f32 has are below `2⁶⁰`; others are put beyond it, and their beams know nothing.
#[cfg(feature = "gpu")]
pub const FOR_DEVICE_IN_F32: [(&str, f64); 6] = [
    ("BEYOND", LARGEST_IN_F32),
    ("NEGLIGIBLE", 1.0 / LARGEST_IN_F32),
    ("OF_WAY", 0.0),
    ("OF_PLACE", OF_PLACE),
    ("OF_COSINE", OF_COSINE_IN_F32),
    ("OF_TURN", shadow::OF_TURN),
];

/// Largest place that a device has in f32.
pub const LARGEST_IN_F32: f64 = (1u64 << 60) as f64;

#[cfg(feature = "gpu")]
const OF_COSINE_IN_F32: f64 = 14.5;
#[cfg(feature = "gpu")]
const _: () =
    assert!(guard::steps::DOT + guard::steps::NORMALIZED_WIDE + 0.501 + 1.0 < OF_COSINE_IN_F32);

/// What is known of an object in the way, as numbers of which the largest wins.
pub mod in_the_way {
    /// It is not.
    pub const NO: f64 = 0.0;
    /// It is or it is not.
    pub const OPEN: f64 = 1.0;
    /// It is.
    pub const YES: f64 = 2.0;
}

/// The way from a point to a lamp.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Where it starts, relative to the reference point.
    pub from: Vec3<f64>,
    /// To the lamp; of any length for a sun.
    pub way: Vec3<f64>,
    /// `way·way`
    pub square: f64,
    /// The part of `E` that is the same for all objects, and all along.
    pub error: f64,
    /// What its end is off by beside that; 0 where it goes on for ever.
    pub end_error: f64,
    /// What that is at an object, for each unit of the object's distance from the start.
    pub bend: f64,
    /// Whether it goes on for ever.
    pub is_endless: bool,
    /// `ε`; the tests cut it.
    pub unit: f64,
}

/// At least the length of a vector, but for rounding: where its squares underflow, it is below the inverse of the
/// largest number whose square is in range.
fn length_of(v: Vec3<f64>) -> f64 {
    dot3(v, v).sqrt().max(1.0 / LARGEST)
}

/// Squares of `r − e`, −1 where that is negative, and of `r + e`.
fn squares(r: f64, e: f64) -> (f64, f64) {
    let (inner, outer) = (r - e, r + e);
    let inner2 = if inner > 0.0 { inner * inner * (1.0 - RELATIVE) } else { -1.0 };
    (inner2, outer * outer * (1.0 + RELATIVE))
}

impl Beam {
    /// The beam from a point that is off by `error` to a lamp at `position`. Where the two are too close
    /// to each other, its bounds say nothing.
    pub fn to_point(start: Vec3<f64>, error: f64, position: Vec3<f64>) -> Beam {
        let beam = Beam::new(start, position - start, error);
        let distance = beam.square.sqrt();
        let off = error + UNIT_F64 * (length_of(position) + distance);
        let is_far = 1.0 / LARGEST < distance && distance < LARGEST;
        let error = if 4.0 * off < distance && is_far { error } else { f64::INFINITY };
        let at_end = UNIT_F64 * (length_of(position) + (1.0 + OF_WAY) * distance);
        Beam { error, end_error: at_end, bend: OF_LEVER * at_end / distance, ..beam }
    }

    /// The beam against the direction of a sun's light, whose largest component is from 1 to 2.
    pub fn to_sun(start: Vec3<f64>, error: f64, direction: Vec3<f64>) -> Beam {
        Beam { is_endless: true, ..Beam::new(start, -direction, error) }
    }

    fn new(start: Vec3<f64>, way: Vec3<f64>, error: f64) -> Beam {
        let (square, is_endless) = (dot3(way, way), false);
        let [end_error, bend] = [0.0; 2];
        Beam { from: start, way, square, error, end_error, bend, is_endless, unit: UNIT_F64 }
    }

    /// Whether a sphere is in the way, its centre relative to the reference point.
    pub fn meets_sphere(&self, center: Vec3<f64>, r: f64) -> f64 {
        let l = center - self.from;
        let far = center.0.iter().fold(0.0, |far, x| f64::max(far, x.abs()));
        let l2 = dot3(l, l);
        let last = if self.is_endless { f64::MAX } else { 1.0 };
        let foot = (dot3(l, self.way) / self.square).max(0.0).min(last);
        let q = l - self.way * foot;
        let distance = l2.sqrt();
        let here = self.error + self.unit * (OF_PLACE * far + OF_OFFSET * distance);
        let e = here + (self.bend * distance).min(self.end_error);
        let (least2, end) = (dot3(q, q), l - self.way);
        let end2 = if self.is_endless { f64::INFINITY } else { dot3(end, end) };
        let ((inner2, outer2), (end_inner2, end_outer2)) =
            (squares(r, e), squares(r, here + self.end_error));
        let in_range = l2 < LARGEST && e < LARGEST && r < LARGEST && 1.0 / LARGEST < r;
        let is_clear = outer2 < least2 || l2 < inner2 && end2 < end_inner2;
        let is_crossed = least2 < inner2 && (outer2 < l2 || end_outer2 < end2);
        match (in_range, is_clear, is_crossed) {
            (true, true, _) => in_the_way::NO,
            (true, false, true) => in_the_way::YES,
            _ => in_the_way::OPEN,
        }
    }

    /// Whether a plane is in the way: `point` relative to the reference point, and a normal of largest
    /// component from 1 to 2. `N = n·(a − p)` at the beam's start and `N₁ = n·(a − L)` at its end; it is in the
    /// way where their signs differ. They are off by `|n|·E`, without the end's part where the beam starts, and `3ε` of the
    /// product of the lengths for the dot product. A sun's end has the sign of `−n·w`, off by `3ε|n||w|` alone, as both are exact; so its
    /// beam surely runs along a plane where each product is one with 0, and then misses it.
    pub fn meets_plane(&self, point: Vec3<f64>, normal: Vec3<f64>) -> f64 {
        let l = point - self.from;
        let (n, way, away) = (length_of(normal), self.square.sqrt(), length_of(point));
        let here = self.error + self.unit * (away + OF_PLANE * length_of(l));
        let e = here + self.end_error + self.unit * (OF_PLANE * way);
        let start = dot3(normal, l);
        let start_error = ROOM * n * here;
        let (stop, stop_error) = match self.is_endless {
            true => (-dot3(normal, self.way), OF_SLOPE * self.unit * n * way),
            false => (dot3(normal, l - self.way), ROOM * n * e),
        };
        let are_known = start_error < start.abs() && stop_error < stop.abs() && e < LARGEST;
        let is_along = |axis: usize| normal.0[axis] == 0.0 || self.way.0[axis] == 0.0;
        let is_apart = start > 0.0 && stop <= 0.0 || start <= 0.0 && stop > 0.0;
        match (self.is_endless && (0..3).all(is_along), are_known, is_apart) {
            (true, ..) | (_, true, false) => in_the_way::NO,
            (_, true, true) => in_the_way::YES,
            _ => in_the_way::OPEN,
        }
    }
}

impl Beam {
    /// [`Beam::meets_sphere`] of a beam that starts on another sphere, whose centre lies `apart` from this one's, for
    /// spheres that are nearly the same.
    pub fn meets_shell(
        &self,
        center: Vec3<f64>,
        r: f64,
        own_center: Vec3<f64>,
        own_r: f64,
        apart: Vec3<f64>,
    ) -> f64 {
        let l = center - self.from;
        let far = |v: Vec3<f64>| v.0.iter().fold(0.0, |far, x| f64::max(far, x.abs()));
        let far = f64::max(far(center), far(own_center));
        let e =
            self.error + self.end_error + self.unit * (OF_PLACE * far + OF_OFFSET * length_of(l));
        let way = self.square.sqrt();
        let v = self.from - own_center;
        let a = length_of(apart);
        let k = (own_r - r) * (own_r + r);
        let side = k + dot3(apart, apart + v * 2.0);
        let reach = a + 2.0 * length_of(v);
        let side_error = ROOM * (2.0 * a * e + self.unit * OF_SHELL * (k.abs() + a * reach));
        let leaves = dot3(l, self.way) < -ROOM * e * (way + 2.0 * length_of(l));
        let end = l - self.way;
        let end2 = if self.is_endless { f64::INFINITY } else { dot3(end, end) };
        let (inner, outer) = (r - e, r + e);
        let inner2 = if inner > 0.0 { inner * inner * (1.0 - RELATIVE) } else { -1.0 };
        let outer2 = outer * outer * (1.0 + RELATIVE);
        let starts_inside = side < -side_error;
        let are_in_range = [length_of(l), r, own_r, e, a, way].iter().all(|&x| x < LARGEST)
            && r.min(own_r) > 1.0 / LARGEST;
        let is_clear = (starts_inside & (end2 < inner2)) | ((side > side_error) & leaves);
        let known =
            if starts_inside & (end2 > outer2) { in_the_way::YES } else { in_the_way::OPEN };
        let known = if is_clear { in_the_way::NO } else { known };
        if are_in_range { known } else { in_the_way::OPEN }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::exact::{ExactBeam, ExactHit, ExactPoint, ExactRay, Shape, visible_root};
    use crate::rays::Ray;

    /// A point in a plane across the x axis, where a ray along that meets it: a point of f64, exactly.
    fn exact_point(at: DVec3) -> ExactPoint {
        let ray = ExactRay::new(&Ray { origin: at - DVec3::X, direction: DVec3::X });
        let plane = Shape::Plane { point: at, normal: DVec3::X };
        let (root, side) = visible_root(&ray, &plane).unwrap();
        let point = ExactPoint::new(&ray, &ExactHit { id: 1, root, side });
        assert_eq!(point.is_within(0.0, at), Some(true), "{at}");
        point
    }

    fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
    }

    struct Case {
        from: DVec3,
        lamp: DVec3,
        is_sun: bool,
        shape: Shape,
    }

    /// Spheres and planes that a beam touches, begins at, or ends at, within some units of f64.
    fn case(rng: &mut ChaCha8Rng, unit: f64) -> Case {
        let size = 2f64.powi(rng.random_range(-12..12));
        // x keeps its digits when 1 is taken away and added again.
        let from = DVec3::new(rng.random_range(-8..8).into(), 0.0, 0.0)
            + vector(rng) * DVec3::new(0.0, 1.0, 1.0) * 2f64.powi(rng.random_range(-6..6));
        let lamp = vector(rng) * size;
        let is_sun = rng.random_bool(0.3);
        let way = if is_sun { -lamp } else { lamp - from };
        let s = [0.0, 1.0, rng.random_range(0.0..1.0)][rng.random_range(0..3)];
        let on_beam = from + way * s;
        let aside = way.cross(vector(rng)).normalize();
        let near = 1.0 + f64::from(rng.random_range(-24..=24)) * unit;
        let shape = if rng.random_bool(0.7) {
            let radius = way.length() * rng.random_range(0.01..1.0);
            let across = if s > 0.0 && s < 1.0 { aside } else { vector(rng).normalize() };
            Shape::Sphere { center: on_beam + across * radius * near, radius }
        } else {
            Shape::Plane {
                point: on_beam + aside * way.length(),
                normal: way.cross(aside) + way * 1e-3,
            }
        };
        Case { from, lamp, is_sun, shape }
    }

    /// Wrong statements about `n` cases with this part of the bounds' unit, and statements at all.
    fn statements(n: usize, part: f64) -> (Vec<String>, usize) {
        let mut rng = ChaCha8Rng::seed_from_u64(1404);
        let (mut wrong, mut n_said) = (Vec::new(), 0);
        let unit = UNIT_F64 * part;
        for _ in 0..n {
            let Case { from, lamp, is_sun, shape } = case(&mut rng, UNIT_F64);
            // The computed point is the true one.
            let beam = match is_sun {
                true => Beam::to_sun(from.into(), 0.0, lamp.into()),
                false => Beam::to_point(from.into(), 0.0, lamp.into()),
            };
            let beam = Beam { unit, error: beam.error * part, ..beam };
            let said = match shape {
                Shape::Sphere { center, radius } => beam.meets_sphere(center.into(), radius),
                Shape::Plane { point, normal } => {
                    let largest = normal.abs().max_element().log2().floor() as i32;
                    beam.meets_plane(point.into(), (normal * 2f64.powi(-largest)).into())
                }
            };
            if said == in_the_way::OPEN {
                continue;
            }
            n_said += 1;
            let point = exact_point(from);
            let exact = match is_sun {
                true => ExactBeam::against(&point, lamp).unwrap(),
                false => ExactBeam::to_position(&point, lamp).unwrap(),
            };
            if exact.is_blocked_by(&shape) != (said == in_the_way::YES) {
                wrong.push(format!("{from:?} {lamp:?} {is_sun} {shape:?}: {said}"));
            }
        }
        (wrong, n_said)
    }

    /// So near that the squares of lengths underflow, the rounding of a dot product is as large as ever: this one has the wrong
    /// sign.
    #[test]
    fn planes_nearer_than_squares_tell_are_open() {
        let normal = Vec3([1.6980664066748499, -1.592633229472514, -0.7121360615149421]);
        let point = Vec3([-3.324926991026493e-166, 6.670777831146176e-166, -2.28468268181911e-165]);
        for sun in [normal, -normal] {
            let beam = Beam::to_sun(Vec3::ZERO, 0.0, sun);
            assert_eq!(beam.meets_plane(point, normal), in_the_way::OPEN, "{sun:?}");
        }
        // The same of spheres whose centres are that close.
        let beam = Beam::to_sun(Vec3([1.0, 0.0, 0.0]), 1e-15, Vec3([-1.0, 0.3, 0.0]));
        let apart = Vec3([0.0, 1e-165, 0.0]);
        let met = beam.meets_shell(Vec3::ZERO, 1.0, apart, 1.0, apart);
        assert_eq!(met, in_the_way::OPEN);
    }

    /// A sun at the horizon of a floor, which is often exactly there.
    #[test]
    fn suns_along_a_plane_are_known() {
        let floor = (Vec3([0.0, -1.0, 3.0]), Vec3([0.0, 1.0, 0.0]));
        for (sun, known) in [
            (DVec3::new(1.0, 0.0, -0.5), in_the_way::NO),
            (DVec3::new(1.0, 1e-300, -0.5), in_the_way::OPEN),
            (DVec3::new(1.0, 1e-9, -0.5), in_the_way::YES),
            (DVec3::new(1.0, -1e-9, -0.5), in_the_way::NO),
        ] {
            // Its light comes from there.
            let beam = Beam::to_sun(Vec3([0.1, 0.7, 0.3]), 1e-15, sun.into());
            assert_eq!(beam.meets_plane(floor.0, floor.1), known, "{sun}");
        }
    }

    #[test]
    fn what_is_said_is_right() {
        let (wrong, n_said) = statements(100_000, 1.0);
        assert_eq!(wrong.len(), 0, "{}", wrong[0]);
        assert!(n_said > 20_000, "{n_said}");
    }

    /// The unit of f64 is twice what rounding to nearest takes, the largest errors of all steps don't meet in one
    /// beam, and coordinates are rarely as large as their sums: wrong statements begin at a 24th.
    #[test]
    fn sabotage_smaller_bounds_are_noticed() {
        assert!(!statements(100_000, 1.0 / 48.0).0.is_empty());
    }

    /// Wrong statements about `n` cases of beams that start on a sphere and meet one that is nearly the same, or
    /// goes through the point, with this part of the bounds; and statements at all.
    fn statements_of_shells(n: usize, part: f64) -> (Vec<String>, [usize; 3]) {
        let mut rng = ChaCha8Rng::seed_from_u64(1430);
        let (mut wrong, mut n_said) = (Vec::new(), [0; 3]);
        for _ in 0..n {
            let (own, own_r) = (vector(&mut rng), rng.random_range(0.5..2.0));
            let origin = own + vector(&mut rng) * [0.4, 6.0][rng.random_range(0..2)];
            let target = own + vector(&mut rng) * own_r * 0.5;
            let ray = Ray { origin, direction: target - origin };
            let sphere = Shape::Sphere { center: own, radius: own_r };
            let exact_ray = ExactRay::new(&ray);
            let Some((root, side)) = visible_root(&exact_ray, &sphere) else { continue };
            let point = ExactPoint::new(&exact_ray, &ExactHit { id: 1, root, side });
            // The same point in f64.
            let d = ray.direction.normalize();
            let foot = (own - origin).dot(d);
            let across = (own - origin - d * foot).length_squared();
            let half = (own_r * own_r - across).max(0.0).sqrt();
            let t = if origin.distance(own) > own_r { foot - half } else { foot + half };
            let at = origin + d * t;
            let error = 16.0 * UNIT_F64;
            if point.is_within(error, at) != Some(true) {
                continue;
            }
            let steps = |rng: &mut ChaCha8Rng| f64::from(rng.random_range(-6..=6)) * UNIT_F64;
            let size = [0.0, 1e-15, 1e-12, 1e-7, 0.3][rng.random_range(0..5)];
            let center = own + vector(&mut rng) * size;
            let radius = match rng.random_bool(0.5) {
                true => own_r * (1.0 + steps(&mut rng)),
                false => at.distance(center) * (1.0 + steps(&mut rng)),
            };
            let lamp = own + vector(&mut rng) * [0.5, 5.0][rng.random_range(0..2)];
            let is_sun = rng.random_bool(0.3);
            let beam = match is_sun {
                true => Beam::to_sun(at.into(), error, (at - lamp).into()),
                false => Beam::to_point(at.into(), error, lamp.into()),
            };
            let beam = Beam { unit: UNIT_F64 * part, error: beam.error * part, ..beam };
            let apart = (own - center).into();
            let said = beam.meets_shell(center.into(), radius, own.into(), own_r, apart);
            n_said[said as usize] += 1;
            let exact = match is_sun {
                true => ExactBeam::against(&point, at - lamp).unwrap(),
                false => ExactBeam::to_position(&point, lamp).unwrap(),
            };
            let is_blocked = exact.is_blocked_by(&Shape::Sphere { center, radius });
            if said != in_the_way::OPEN && is_blocked != (said == in_the_way::YES) {
                wrong.push(format!("{ray:?} {own:?} {own_r} {center:?} {radius}: {said}"));
            }
        }
        (wrong, n_said)
    }

    #[test]
    fn what_is_said_of_shells_is_right() {
        let (wrong, [n_no, n_open, n_yes]) = statements_of_shells(40_000, 1.0);
        assert_eq!(wrong.len(), 0, "{}", wrong[0]);
        assert!(n_no.min(n_yes) > 5000 && n_open < 20_000, "{n_no} {n_open} {n_yes}");
    }

    /// The point is known better than is said, too.
    #[test]
    fn sabotage_smaller_bounds_of_shells_are_noticed() {
        assert!(!statements_of_shells(40_000, 1.0 / 48.0).0.is_empty());
    }
}
