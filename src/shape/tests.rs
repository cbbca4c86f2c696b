//! The formulas against exact arithmetic, in all numbers; every bound that is cut is seen.

mod anchors;
mod numbers;

use super::shadow::{Aim, Origin};
use super::*;
use crate::bounds;
use crate::bounds::tests::worst::{UNIT, Worst, worst};
use crate::exact::{Dyadic as Exact, ExactPoint, ExactRay, QuadraticSurd, real, visible_hit};
use crate::num::Lanes;
use crate::prepare::ScaledInteger;
use crate::scene::{Color, Plane, Sphere};
use crate::support::random::SplitMix;
use numbers::{Finite, Shaky};

/// An object, and a ray's origin and direction.
type Case<T> = (T, DVec3, DVec3);

struct Random(SplitMix);

impl Random {
    /// From −1 to 1.
    fn number(&mut self) -> f64 {
        2.0 * self.0.unit() - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    /// A size over some decades.
    fn size(&mut self, decades: f64) -> f64 {
        10f64.powf(self.number() * decades)
    }
}

/// A ray that is nearly tangent, for any unit of rounding, and its sphere.
fn tangent(random: &mut Random) -> Case<Sphere> {
    let (origin, way) = (random.vector() * random.size(2.0), random.vector());
    let radius = random.size(3.0);
    let aside = way.cross(random.vector()).normalize();
    let near = 1.0 + random.number() * 10f64.powf(-6.5 + 3.0 * random.number());
    let at = origin + way.normalize() * (random.number() * random.size(3.0));
    let away = if random.0.bits().is_multiple_of(4) { radius * 0.5 } else { radius * near };
    (Sphere { center: at + aside * away, radius }, origin, way * random.size(3.0))
}

/// An eye close to a large sphere, outside or inside, and a ray that goes anywhere.
fn ground(random: &mut Random) -> Case<Sphere> {
    let (radius, away) = (1e5 * random.size(4.0), random.vector().normalize());
    let eye = random.vector() * 10.0;
    let height = random.size(3.0) * if random.0.bits().is_multiple_of(4) { -1.0 } else { 1.0 };
    let direction = away * (-height * random.number().abs()) + random.vector() * random.size(2.0);
    (Sphere { center: eye - away * (radius + height), radius }, eye, direction)
}

/// A plane, nearly along the ray.
fn grazing(random: &mut Random) -> Case<Plane> {
    let (origin, way, normal) = (random.vector(), random.vector(), random.vector());
    let along = way.cross(normal).normalize();
    let normal = along + way * (random.number() * 10f64.powf(-5.0 + 5.0 * random.number()));
    let point = origin + random.vector() * random.size(3.0);
    let normal = normal * random.size(6.0);
    (Plane { name: None, point, normal, color: Color::BLACK }, origin, way)
}

/// A shape's record from its object.
trait Object {
    type ShapeRecord: ShapeRecord;
    fn seen<F: Float>(&self, eye: &RayOrigin) -> Self::ShapeRecord;
    fn in_scene(&self) -> crate::scene::Object<'_>;
}

impl Object for Sphere {
    type ShapeRecord = SphereRecord<f64>;
    fn seen<F: Float>(&self, eye: &RayOrigin) -> SphereRecord<f64> {
        SphereRecord::new::<F>(self, eye)
    }
    fn in_scene(&self) -> crate::scene::Object<'_> {
        crate::scene::Object::Sphere(self)
    }
}

impl Object for Plane {
    type ShapeRecord = PlaneRecord<f64>;
    fn seen<F: Float>(&self, eye: &RayOrigin) -> PlaneRecord<f64> {
        PlaneRecord::new::<F>(self, eye)
    }
    fn in_scene(&self) -> crate::scene::Object<'_> {
        crate::scene::Object::Plane(self)
    }
}

/// Whether bounds say the truth of a root.
fn holds(low: f64, high: f64, beyond: f64, root: Option<&QuadraticSurd>) -> bool {
    let at = |t: f64| real(t).unwrap_or_else(Exact::zero);
    match root {
        None => high >= beyond,
        Some(root) => {
            let is_below = high >= beyond || root.cmp_real(&at(high)).is_le();
            low < beyond && root.cmp_real(&at(low)).is_ge() && is_below
        }
    }
}

/// How many of `n` cases are wrong, and how many are certain. Every other ray starts away from the eye.
fn count<T: Object, R: Real>(
    n: usize,
    case: impl Fn(&mut Random) -> Case<T>,
    cut: impl Fn(&mut T::ShapeRecord),
    number: impl Fn(R) -> f64,
) -> (usize, usize) {
    let (mut random, mut wrong, mut certain) = (Random(SplitMix::new(7)), 0, 0);
    let beyond = R::One::BEYOND;
    for k in 0..n {
        let (object, origin, way) = case(&mut random);
        let scaled = ScaledInteger::new(way).rounded();
        let away = if k % 2 == 0 { DVec3::ZERO } else { random.vector() * random.size(1.0) };
        let reference = origin - away;
        let from = origin - reference;
        let spread = if k % 2 == 0 { 0.0 } else { bounds::length_bound(from) };
        // All is rounded once, and so is a difference.
        let (reach, unit) = (Footprint::default(), R::One::UNIT);
        let eye = RayOrigin { reference, spread, input: bounds::LIST, reach, unit };
        let exact =
            ExactRay::new(&crate::rays::WorldRay { origin: reference + from, direction: scaled });
        if reference + from != origin {
            continue;
        }
        let root = visible_hit(&exact, 1, object.in_scene()).map(|hit| hit.root);
        let mut seen = object.seen::<R::One>(&eye);
        cut(&mut seen);
        let is_close = seen.is_close();
        let one = Record::round::<R::One>(&seen);
        let seen = T::ShapeRecord::splat::<R>(&one);
        let ray = Ray::new(V3::<R>::lit(from), V3::lit(scaled));
        let found = if is_close {
            T::ShapeRecord::bounds_close(&seen, &ray)
        } else {
            T::ShapeRecord::bounds(&seen, &ray)
        };
        let (low, high) =
            found.map_or((beyond, beyond), |found| (number(found.low), number(found.high)));
        wrong += usize::from(!holds(low, high, beyond, root.as_ref()));
        certain += usize::from(high < beyond || low >= beyond);
    }
    (wrong, certain)
}

fn one(x: Lanes<f64, 8>) -> f64 {
    x.0[7]
}

#[test]
fn bounds_hold_in_every_number() {
    let n = 20_000;
    for (wrong, certain) in [
        count::<Sphere, f32>(n, tangent, |_| (), f64::from),
        count::<Sphere, Shaky>(n, tangent, |_| (), |x| x.0.into()),
        count::<Sphere, Lanes<f64, 8>>(n, tangent, |_| (), one),
        count::<Sphere, f32>(n, ground, |_| (), f64::from),
        count::<Sphere, Shaky>(n, ground, |_| (), |x| x.0.into()),
        count::<Sphere, f64>(n, ground, |_| (), |x| x),
        count::<Sphere, f32>(n, from_surface, |_| (), f64::from),
        count::<Sphere, Shaky>(n, from_surface, |_| (), |x| x.0.into()),
        count::<Sphere, f64>(n, from_surface, |_| (), |x| x),
        count::<Plane, f32>(n, grazing, |_| (), f64::from),
        count::<Plane, Shaky>(n, grazing, |_| (), |x| x.0.into()),
        count::<Plane, f64>(n, grazing, |_| (), |x| x),
    ] {
        println!("{wrong} wrong, {certain} certain of {n}");
        assert!(wrong == 0 && certain > n / 10);
    }
}

/// Whether a record says anything of a ray that starts within the eye's spread.
fn says_anything<T: ShapeRecord, F: Float>(
    seen: &T,
    eye: &RayOrigin,
    origin: DVec3,
    direction: DVec3,
) -> bool {
    let seen = T::splat::<F>(&Record::round::<F>(seen));
    let ray = Ray::new(V3::lit(origin), V3::lit(direction));
    let bounds = [T::bounds(&seen, &ray), T::bounds_close(&seen, &ray)];
    let is_bounded = bounds.into_iter().any(|bounds| {
        bounds.is_none_or(|t| t.low.to_f64() > 0.0 || !(t.high.to_f64() >= F::BEYOND))
    });
    let lengths = SurfaceErrorTerms::new(eye, direction.length());
    let surfaces = [T::surface(&seen, &ray, &lengths), T::surface_close(&seen, &ray, &lengths)];
    let is_met = surfaces.iter().any(|surface| surface.is_known() || surface.t.low.to_f64() > 0.0);
    is_bounded || is_met
}

/// Compares records of spheres and planes out of the range of `F` with exact arithmetic, and counts rays that surely miss a far sphere
/// or a tiny one.
fn out_of_range<F: Float>() -> [usize; 2] {
    let (mut random, mut n_missed) = (Random(SplitMix::new(5)), [0; 2]);
    let (far, small) = (F::FARTHEST, F::SMALLEST);
    for k in 0..20_000 {
        let spread = match k % 3 {
            0 => 0.0,
            1 => far * 0.99,
            _ => far.powf(random.0.unit() * 0.99),
        };
        let unit = match k % 2 {
            0 => F::UNIT,
            _ => 0.5 * F::UNIT,
        };
        let (reference, input, reach) = (random.vector(), bounds::PARALLEL, Footprint::default());
        let eye = RayOrigin { reference, spread, input, reach, unit };
        let origin = random.vector().normalize() * (spread * random.0.unit());
        let direction = random.vector().normalize() * (1.01 + 30.0 * random.0.unit());
        // Up to the largest numbers of f64.
        let decades = if random.0.bits() % 2 == 0 { 3.0 } else { 307.0 - far.log10() };
        let beyond = far * (1.0 + 10f64.powf(decades * random.0.unit()));
        let away = random.vector().normalize();
        let (center, radius) = match random.0.bits() % 5 {
            4 => (reference, beyond),
            0 => (away * beyond, beyond * random.0.unit()),
            1 => (away * beyond, 1.0),
            2 => (away * (beyond * random.0.unit()), beyond),
            _ => (away, small * 0.99 * random.0.unit()),
        };
        let sphere = Sphere { center, radius };
        let seen = SphereRecord::new::<F>(&sphere, &eye);
        let case = || format!("{sphere:?}, {eye:?}: from {origin:?} along {direction:?}");
        let lengths = SurfaceErrorTerms::<F>::new(&eye, direction.length());
        let numbers = Record::round::<F>(&seen);
        let ray = Ray::new(V3::<F>::lit(origin), V3::lit(direction));
        assert!(!SphereRecord::surface(&numbers, &ray, &lengths).is_known(), "{}", case());
        let world = crate::rays::WorldRay { origin: reference + origin, direction };
        let hit = visible_hit(&ExactRay::new(&world), 1, crate::scene::Object::Sphere(&sphere));
        let found = SphereRecord::bounds(&numbers, &ray);
        let [low, high] = found.map_or([F::BEYOND; 2], |t| [t.low.to_f64(), t.high.to_f64()]);
        assert!(holds(low, high, F::BEYOND, hit.as_ref().map(|hit| &hit.root)), "{}", case());
        n_missed[usize::from(radius < small)] += usize::from(low >= F::BEYOND);
        let normal = random.vector() * random.size(6.0);
        let point = away * beyond;
        let plane = Plane { name: None, point, normal, color: Color::BLACK };
        let plane = PlaneRecord::new::<F>(&plane, &eye);
        let is_said = says_anything::<PlaneRecord<f64>, F>(&plane, &eye, origin, direction);
        assert!(!is_said, "{point:?} {normal:?}, {eye:?}: from {origin:?} along {direction:?}");
    }
    n_missed
}

/// An object out of range does not leave all rays undecided: most surely miss it.
#[test]
fn what_is_said_of_objects_out_of_range_is_right() {
    for [far, tiny] in [out_of_range::<f32>(), out_of_range::<f64>()] {
        println!("{far} far spheres and {tiny} tiny ones are missed");
        assert!(far > 3000 && tiny > 1000, "{far}, {tiny}");
    }
}

/// The largest part of its error that `k` of spheres is off by, moved to where a parallel ray starts that is `apart` of the
/// way to the centre away, with a radius that this part of `k` is left of.
fn part_of_k_error(apart: f64, left: f64) -> f64 {
    worst(|x: [f64; 10]| {
        let [center, origin, off] = [0, 3, 6].map(|at| DVec3::from_slice(&x[at..]));
        let center = center.as_vec3().as_dvec3();
        let origin = origin.normalize() * (apart * x[9].abs().min(1.0) * center.length());
        let radius = (center.length_squared() * (1.0 - left)).sqrt();
        let (spread, input) = (origin.length(), bounds::PARALLEL);
        let (reference, reach) = (DVec3::ZERO, Footprint::default());
        let eye = RayOrigin { reference, spread, input, reach, unit: UNIT };
        let seen = SphereRecord::new::<f32>(&Sphere { center, radius }, &eye);
        let off = off.normalize() * ((input.offset - 1.001) * UNIT * spread);
        let k = center.length_squared() - radius * radius;
        let numbers = SphereRecord::splat::<Worst>(&Record::round::<f32>(&seen));
        let rounded = V3(center.to_array().map(|x| Worst::off(x, 0.5)));
        let numbers = SphereRecord { center: rounded, k: Worst::off(k, 0.5), ..numbers };
        let from = V3((origin + off).to_array().map(Worst));
        let ray = Ray { origin: from, direction: from, a: Worst(1.0), inv_a: Worst(1.0) };
        let found = sphere::k_from(&numbers, numbers.center - from, &ray).0;
        let exact = (center - origin).length_squared() - radius * radius;
        (found - exact).abs() / seen.k_error
    })
}

/// What is granted for `k` itself, once and where it is moved, and for what moves it.
#[test]
fn errors_of_k_are_needed() {
    for (apart, left) in [(0.0, 0.5), (1e-6, 0.5), (1e-3, 1e-9)] {
        let found = part_of_k_error(apart, left);
        println!("{apart:e}, {left:e}: {found:.3}");
        assert!(found <= 1.0 && found > 0.83, "{apart:e}, {left:e}: {found}");
    }
}

/// `N` of planes close to which rays of a list start, where it cancels.
#[test]
fn offsets_of_planes_are_within_their_error() {
    let mut random = Random(SplitMix::new(17));
    let mut most: f64 = 0.0;
    for _ in 0..20_000 {
        let (normal, origin) = (random.vector(), random.vector() * random.size(1.0));
        let along = normal.cross(random.vector()) * random.size(3.0);
        let plane = Plane { name: None, point: origin + along, normal, color: Color::BLACK };
        let (input, reach) = (bounds::host::input_in_f64(None), Footprint::default());
        let unit = bounds::host::HOST_UNIT_F64;
        let eye = RayOrigin { reference: origin, spread: 0.0, input, reach, unit };
        let Some(exact) = plane::numerator(&plane, &eye) else { continue };
        let exact = exact * crate::prepare::power_of_two(-ScaledInteger::new(normal).exponent());
        let l = V3((plane.point - origin).to_array());
        let seen = PlaneRecord::of::<f64>(&plane, l, &eye);
        most = most.max((seen.offset - exact).abs() / seen.offset_error);
    }
    assert!(most <= 1.0 && most > 0.1, "{most}");
}

/// From an eye exactly on a sphere its far wall is seen, as its near root is the eye; and nothing of it is seen outward.
#[test]
fn an_eye_on_a_sphere_sees_its_far_wall() {
    let sphere = Sphere { center: DVec3::new(0.0, 0.0, -5.0), radius: 5.0 };
    let (input, reach) = (bounds::host::input_in_f64(None), Footprint::default());
    let eye = RayOrigin { reference: DVec3::ZERO, spread: 0.0, input, reach, unit: f64::UNIT };
    let seen = SphereRecord::new::<f64>(&sphere, &eye);
    assert!(seen.is_close());
    for direction in [DVec3::new(0.3, -0.2, -1.0), DVec3::new(0.9, 0.0, -0.5)] {
        let ray = Ray::new(V3([0.0; 3]), V3(direction.to_array()));
        let t = 2.0 * direction.dot(sphere.center) / direction.length_squared();
        let bounds = [SphereRecord::bounds(&seen, &ray), SphereRecord::bounds_close(&seen, &ray)];
        let lengths = SurfaceErrorTerms::new(&eye, 2.0);
        let surfaces = [
            SphereRecord::surface(&seen, &ray, &lengths),
            SphereRecord::surface_close(&seen, &ray, &lengths),
        ];
        let bounds = bounds.map(|bounds| bounds.expect("a hit"));
        for Bounds { low, high } in bounds.into_iter().chain(surfaces.map(|surface| surface.t)) {
            assert!(low <= t && t <= high && high - low < 1e-9 * t, "{low} {t} {high}");
        }
        assert!(surfaces.iter().all(|surface| surface.is_known() && !surface.front));
    }
    let seen = seen.round::<f32>();
    for direction in [DVec3::new(0.3, -0.2, 1.0), DVec3::new(0.9, 0.0, 1e-4)] {
        let ray = Ray::new(V3([0.0; 3]), V3::lit(direction));
        let found = SphereRecord::bounds_close(&seen, &ray).expect("bounds");
        assert!(found.low >= f32::BEYOND as f32, "{direction}: {found:?}");
    }
}

/// Rays from an eye exactly on a sphere, in all directions and along it.
fn from_surface(random: &mut Random) -> Case<Sphere> {
    let radius = (10.0 * random.number()).exp2().max(1.0).round();
    let at = [DVec3::X, DVec3::NEG_Z, DVec3::Y][random.0.bits() as usize % 3];
    let outward = at * (random.number() * 10f64.powf(-8.0 * random.0.unit()));
    let direction = outward + at.cross(random.vector());
    let origin = random.vector().round();
    (Sphere { center: origin - at * radius, radius }, origin, direction)
}

/// With a part of a bound a bad device is caught. Its errors are random, so that the worst do not meet.
#[test]
fn sabotage_cut_bounds_are_seen() {
    let middle = |seen: &SphereRecord<f64>| (seen.outer2 + seen.inner2) / 2.0;
    type Cut<'a> = (&'a str, fn(&mut Random) -> Case<Sphere>, &'a dyn Fn(&mut SphereRecord<f64>));
    let cuts: [Cut; 4] = [
        ("slack", tangent, &|seen| seen.slack *= 0.02),
        ("outer", tangent, &|seen| {
            seen.outer2 = middle(seen) + (seen.outer2 - middle(seen)) * 0.2;
        }),
        ("inner", tangent, &|seen| {
            seen.inner2 = middle(seen) + (seen.inner2 - middle(seen)) * 0.2;
        }),
        ("slack of a ground", ground, &|seen| seen.slack *= 0.05),
    ];
    for (name, case, cut) in cuts {
        let (wrong, _) = count::<Sphere, Shaky>(200_000, case, cut, |x| x.0.into());
        assert!(wrong > 0, "{name}");
    }
    for (name, cut) in [
        ("offset", (|seen| seen.offset_error *= 0.1) as fn(&mut PlaneRecord<f64>)),
        ("slope", |seen| seen.slope_error *= 0.1),
    ] {
        let (wrong, _) = count::<Plane, Shaky>(400_000, grazing, cut, |x| x.0.into());
        assert!(wrong > 0, "{name}");
    }
}

/// How many surfaces are known, of `n` rays that hit, and how many are off by more than this share of what they may be: `t`, the
/// point, or the normal.
fn off<T: Object, F: Float>(
    n: usize,
    unit: f64,
    share: f64,
    is_close: bool,
    case: impl Fn(&mut Random) -> Case<T>,
) -> [usize; 4] {
    let mut random = Random(SplitMix::new(11));
    let [mut known, mut of_t, mut of_point, mut of_normal] = [0; 4];
    for k in 0..n {
        let (object, origin, way) = case(&mut random);
        let from = DVec3::from_array(origin.to_array().map(|x| F::near(x).to_f64()));
        let scaled = ScaledInteger::new(way).rounded();
        let reference = if k % 2 == 0 { from } else { DVec3::ZERO };
        let exact = ExactRay::new(&crate::rays::WorldRay { origin: from, direction: scaled });
        let Some(hit) = visible_hit(&exact, 1, object.in_scene()) else { continue };
        // The offset of a centre is rounded, and so are centre and difference; the direction is rounded once.
        let input = InputError { offset: 3.01, direction: 1.001 };
        let spread = bounds::length_bound(from - reference);
        let eye = RayOrigin { reference, spread, input, reach: Footprint::default(), unit };
        let seen = T::ShapeRecord::splat::<F>(&Record::round::<F>(&object.seen::<F>(&eye)));
        let ray = Ray::new(V3::lit(from - reference), V3::lit(scaled));
        let lengths = SurfaceErrorTerms::new(&eye, scaled.length());
        let found = match is_close {
            false => T::ShapeRecord::surface(&seen, &ray, &lengths),
            true => T::ShapeRecord::surface_close(&seen, &ray, &lengths),
        };
        let error = found.point_error.to_f64();
        if !(error < F::BEYOND / 4.0) {
            continue;
        }
        known += 1;
        let (low, high) = (found.t.low.to_f64(), found.t.high.to_f64());
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 * share);
        of_t += usize::from(!holds(middle - half, middle + half, F::BEYOND, Some(&hit.root)));
        let point = reference + DVec3::from_array(found.point.0.map(F::to_f64));
        // The sum is rounded, too.
        let error = error * share + f64::UNIT * point.length();
        let is_there = ExactPoint::new(&exact, &hit).is_within(error, point);
        of_point += usize::from(is_there != Some(true));
        let normal = hit.normal(&exact).unwrap().map(|x| x.to_f64());
        let is_off = |axis: usize| {
            let off = (found.normal.0[axis].to_f64() - normal[axis]).abs();
            off > found.component_error.0[axis].to_f64() * share
        };
        let off2: f64 =
            (0..3).map(|axis| (found.normal.0[axis].to_f64() - normal[axis]).powi(2)).sum();
        let is_far = off2.sqrt() > found.normal_error.to_f64() * share;
        of_normal += usize::from(is_far || (0..3).any(is_off));
    }
    [known, of_t, of_point, of_normal]
}

/// What [`off`] counts in f32 and in f64, of spheres by either formula and of planes, with these shares.
fn off_all(n: usize, [s, t]: [f64; 2]) -> [[usize; 4]; 8] {
    let [u, v] = [f32::UNIT, 0.5 * f64::UNIT];
    [
        off::<Sphere, f32>(n, u, s, false, tangent),
        off::<Sphere, f64>(n, v, t, false, tangent),
        off::<Sphere, f32>(n, u, s, true, tangent),
        off::<Sphere, f64>(n, v, t, true, tangent),
        off::<Sphere, f32>(n, u, s, true, ground),
        off::<Sphere, f64>(n, v, t, true, ground),
        off::<Plane, f32>(n, u, s, false, grazing),
        off::<Plane, f64>(n, v, t, false, grazing),
    ]
}

#[test]
fn surfaces_are_within_their_bounds() {
    for [known, wrong @ ..] in off_all(20_000, [1.0; 2]) {
        println!("{known} known, wrong {wrong:?}");
        assert!(wrong == [0; 3] && known > 1500, "{wrong:?} of {known}");
    }
}

/// The largest errors of all steps don't meet in one ray, and the host's are half a unit of f32 at most.
#[test]
fn sabotage_smaller_bounds_of_surfaces_are_seen() {
    for (at, [known, wrong @ ..]) in off_all(60_000, [0.03, 0.06]).into_iter().enumerate() {
        println!("{at}: {known} known, wrong {wrong:?}");
        assert!(wrong.iter().all(|&n| n > 0), "{at}: {wrong:?} of {known}");
    }
}

/// Each number of a surface is finite, also where a ray misses it, and each of the light on it where it surely hits: as
/// `shaders/lit.wgsl` asks for them.
fn light<T: Object>(
    numbers: &In<T::ShapeRecord, Finite>,
    ray: &Ray<Finite>,
    lengths: &SurfaceErrorTerms<f32>,
    object: &T,
    (is_hit, is_close): (bool, bool),
) {
    let (lengths, met) =
        (lengths.map(Finite::splat), Occluder::<f32>::new(object.in_scene(), DVec3::ZERO));
    let far = T::ShapeRecord::surface(numbers, ray, &lengths);
    let close = T::ShapeRecord::surface_close(numbers, ray, &lengths);
    let (surface, zero) = (if is_close { close } else { far }, V3([Finite(0.0); 3]));
    let is_known = is_hit && surface.is_known();
    let point = V3::select(is_known, surface.point, zero);
    let normal = V3::select(is_known && surface.normal_error.lt(Finite(1.0)), surface.normal, zero);
    for origin in
        [Origin::Point(DVec3::ONE), Origin::Point(DVec3::X * f32::FARTHEST), Origin::Sun(DVec3::Y)]
    {
        let way = ShadowRay::new(&Aim::new(origin), point, surface.point_error);
        way.cosine(normal, surface.normal_error);
        met.occlude(&way, None);
        met.occlude(&way, Some(0.0));
    }
}

/// Whether the bounds are certain; each number on the way to them is finite.
fn is_certain<T: Object>(object: &T, from: DVec3, direction: DVec3) -> bool {
    let (reference, spread) = (DVec3::ZERO, bounds::length_bound(from));
    let (reach, unit) = (Footprint::default(), f32::UNIT);
    let eye = RayOrigin { reference, spread, input: bounds::LIST, reach, unit };
    let seen = object.seen::<f32>(&eye);
    let numbers = T::ShapeRecord::splat::<Finite>(&Record::round::<f32>(&seen));
    let ray = Ray::new(V3::lit(from), V3::lit(direction));
    let far = T::ShapeRecord::bounds(&numbers, &ray);
    let close = T::ShapeRecord::bounds_close(&numbers, &ray);
    let beyond = f32::BEYOND as f32;
    let found = if seen.is_close() { close } else { far };
    if direction.length() < bounds::LONGEST_IN_F32 {
        let is_hit = found.is_some_and(|found| found.high.0 < beyond);
        let lengths = SurfaceErrorTerms::new(&eye, direction.length());
        light(&numbers, &ray, &lengths, object, (is_hit, seen.is_close()));
    }
    found.is_none_or(|found| found.high.0 < beyond || beyond <= found.low.0)
}

/// Spheres up to the ends of f32's range and beyond. Planes as far away as a quotient by [`Float::TINY`] is in range.
#[test]
fn bounds_have_only_finite_numbers() {
    const N: usize = 100_000;
    let size = |random: &mut Random, most: f64| match random.0.bits() % 4 {
        0 => (3.0 * random.0.unit() - 40.0).exp2(),
        1 => (most - 3.0 * random.0.unit()).exp2(),
        _ => (6.0 * random.number()).exp2(),
    };
    let (mut random, mut certain) = (Random(SplitMix::new(13)), [0; 2]);
    for k in 0..N {
        let mut place = |most| random.vector().normalize() * size(&mut random, most);
        let (center, point, away) = (place(60.5), place(33.0), place(33.0));
        let from = if k % 2 == 0 { DVec3::ZERO } else { away };
        let radius = size(&mut random, 60.5);
        let toward = match random.0.bits() % 2 {
            0 => center - from + random.vector() * radius,
            _ => random.vector(),
        };
        let direction = ScaledInteger::new(toward).rounded() * (28.0 * random.0.unit()).exp2();
        certain[0] += usize::from(is_certain(&Sphere { center, radius }, from, direction));
        let normal = match k % 3 {
            0 => direction.cross(random.vector()),
            _ => random.vector(),
        };
        let plane = Plane { name: None, point, normal, color: Color::BLACK };
        certain[1] += usize::from(is_certain(&plane, from, direction));
    }
    println!("{certain:?} certain of {N}");
    assert!(certain.iter().all(|&certain| certain > N / 10), "{certain:?}");
}
