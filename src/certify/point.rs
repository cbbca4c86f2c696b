//! Where rays meet their objects, in f64 with bounds of the errors.

use std::ops::Range;

use super::lanes::{self, Output, Part, Queue, Run};
use super::rows::{Finds, OfPicture, RowSight};
use super::surface::{Bounds, Found, Inside, Outside, PlaneSight, Sight, SphereSight};
use super::{Completer, Stage, StageRays, nearness};
use crate::exact::{ExactHit, ExactPoint, Shape, visible_root};
use crate::guard::{InputError, ROOM, UNIT_F64, steps};
use crate::kernel::RayOf;
use crate::rays::{CameraF64, Pixels};
use crate::scene::Object;
use crate::vec3::{Vec3, dot3};
use crate::wide::{Holds, SideBySide, WideF64};
#[cfg(feature = "gpu")]
use crate::{
    guard::{LIST_F64, input_of_picture},
    rays::Bundle,
};

/// Points side by side.
pub const LANES: usize = 8;

/// Where the registers of a row of [`LANES`] numbers begin.
#[inline(always)]
pub fn registers<S: pulp::Simd>() -> impl Iterator<Item = usize> {
    (0..LANES).step_by(WideF64::<S>::LANES)
}

/// Objects whose numbers are kept from one row to the next.
const KEPT: usize = 16;

/// Points of surfaces, relative to [`Prepared::reference`](crate::prepare::Prepared::reference), and the
/// unit normals there that face the rays.
#[derive(Clone, Copy, Debug)]
pub struct Pack {
    /// The objects' ids, 0 where there is none.
    pub id: [u32; LANES],
    /// 1 where there is an object, 0 elsewhere.
    pub is_object: [f64; LANES],
    /// The points.
    pub at: [[f64; LANES]; 3],
    /// Bounds of their distances from the true ones; infinite where nothing is known.
    pub error: [f64; LANES],
    /// The normals.
    pub normal: [[f64; LANES]; 3],
    /// Bounds of their distances from the true ones.
    pub normal_error: [f64; LANES],
    /// True where the point is on a sphere that its ray starts in.
    pub is_inside: [bool; LANES],
    /// Directions of the rays.
    pub direction: [[f64; LANES]; 3],
}

impl Pack {
    /// No points.
    pub(crate) const NONE: Pack = Pack {
        id: [0; LANES],
        is_object: [0.0; LANES],
        at: [[0.0; LANES]; 3],
        error: [f64::INFINITY; LANES],
        normal: [[0.0; LANES]; 3],
        normal_error: [f64::INFINITY; LANES],
        is_inside: [false; LANES],
        direction: [[1.0; LANES]; 3],
    };

    /// Forgets its points for those of other objects.
    fn reset(&mut self, ids: &[u32]) {
        self.id = [0; LANES];
        self.id[..ids.len()].copy_from_slice(ids);
        for lane in 0..LANES {
            self.is_object[lane] = if self.id[lane] != 0 { 1.0 } else { 0.0 };
        }
        (self.error, self.normal_error) = (Pack::NONE.error, Pack::NONE.normal_error);
        self.is_inside = [false; LANES];
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, point: &PointF64, is_inside: bool, direction: Vec3<f64>) {
        for axis in 0..3 {
            self.direction[axis][lane] = direction.0[axis];
            self.at[axis][lane] = point.at.0[axis];
            self.normal[axis][lane] = point.normal.0[axis];
        }
        (self.error[lane], self.normal_error[lane]) = (point.error, point.normal_error);
        self.is_inside[lane] = is_inside;
    }
}

/// One point of a [`Pack`].
#[derive(Clone, Copy)]
pub struct PointF64 {
    pub at: Vec3<f64>,
    pub error: f64,
    pub normal: Vec3<f64>,
    normal_error: f64,
}

impl PointF64 {
    /// The point relative to its ray's origin, without [`origin_error`].
    #[inline(always)]
    fn new(found: &Found) -> PointF64 {
        let &Found { at, error, normal, normal_error, .. } = found;
        PointF64 { at, error, normal, normal_error }
    }
}

/// The part of a point's error that comes with its ray's origin.
fn origin_error(origin: Vec3<f64>, bounds: &Bounds) -> f64 {
    ROOM * UNIT_F64 * of_origin(bounds.input) * dot3(origin, origin).sqrt()
}

/// Of `t|d|` in a point's error, in units.
fn of_point(input: InputError) -> f64 {
    input.direction + steps::POINT
}

/// Of the length of its ray's origin.
fn of_origin(input: InputError) -> f64 {
    input.offset + steps::POINT_ORIGIN
}

/// The constants of the same in `shaders/lit.wgsl`, by their names there. A device's division is in the
/// bounds of `t`, its roots are lengths in bounds, and a plane's unit normal has a bound for a device.
#[cfg(feature = "gpu")]
pub fn factors_of_points(bundle: Bundle) -> [(&'static str, f64); 4] {
    let input = input_of_picture(bundle).unwrap_or(LIST_F64);
    [
        ("OF_POINT", of_point(input)),
        ("OF_ORIGIN", of_origin(input)),
        ("OF_PLANE_NORMAL", steps::NORMALIZED_WIDE),
        ("DIRECTION_ERROR", UNIT_F64 * input.direction),
    ]
}

/// The points of consecutive rays of one [`Stage`].
#[derive(Default)]
pub struct Points {
    /// In the order of the rays.
    pub packs: Vec<Pack>,
    /// Objects as all rays see them, with their ids, each in the place that its id gives it.
    sights: Vec<(u32, Option<RowSight<f64>>)>,
    lengths: Option<LengthsOfRays>,
}

impl Points {
    /// Finds the points that rays from `first` on see, whose objects are known.
    pub fn find(&mut self, completer: &mut Completer, first: usize, ids: &[u32]) {
        let stage = completer.stage();
        self.packs.resize(ids.len().div_ceil(LANES), Pack::NONE);
        for (pack, ids) in self.packs.iter_mut().zip(ids.chunks(LANES)) {
            pack.reset(ids);
        }
        self.sights.resize_with(KEPT, || (0, None));
        let mut part = Part { first, id: ids, out: Found8 { points: self, first } };
        completer.complete_in_f64(&mut part);
        for at in completer.open.drain(..) {
            let pack = &mut self.packs[at / LANES];
            let alone = stage.point_f64(first + at, ids[at]);
            if let Some((point, is_inside)) = alone {
                let direction = stage.direction(first + at);
                pack.set(at % LANES, &point, is_inside, direction);
            }
        }
    }
}

/// Takes points from the queues.
struct Found8<'a> {
    points: &'a mut Points,
    first: usize,
}

impl Output for Found8<'_> {
    fn take_run(&mut self, stage: &Stage, run: &Run, open: &mut Vec<usize>) -> bool {
        let StageRays::Pixels { pixels, camera, .. } = &stage.rays else { return false };
        let Points { packs, sights, lengths } = &mut *self.points;
        let kept = &mut sights[run.id as usize % KEPT];
        if kept.0 != run.id {
            *kept = (run.id, stage.point_sight(run.id));
        }
        let lengths = *lengths.get_or_insert_with(|| LengthsOfRays::new::<f64>(stage, pixels));
        let arch = pulp::Arch::new();
        match &kept.1 {
            None => return false,
            Some(RowSight::Sphere(sight)) => {
                arch.dispatch(FindRun { sight, camera, run, lengths, packs, open });
            }
            Some(RowSight::Plane(sight)) => {
                arch.dispatch(FindRun { sight, camera, run, lengths, packs, open });
            }
        }
        true
    }

    fn miss(&mut self, _: Range<usize>) {}

    fn take<S: Sight, const N: usize>(
        &mut self,
        stage: &Stage,
        hits: &Queue<S, N>,
        open: &mut Vec<usize>,
    ) {
        let mut columns = [[0.0; lanes::LANES]; 8];
        let bounds = stage.bounds;
        pulp::Arch::new().dispatch(FindPoints { hits, bounds, columns: &mut columns });
        for (lane, &at) in hits.places().iter().enumerate() {
            let [x, y, z, error, nx, ny, nz, normal_error] =
                std::array::from_fn(|column: usize| columns[column][lane]);
            let mut point =
                PointF64 { at: Vec3([x, y, z]), error, normal: Vec3([nx, ny, nz]), normal_error };
            if !(error.is_finite() && normal_error.is_finite()) {
                open.push(at);
                continue;
            }
            if !stage.has_one_origin {
                let origin = stage.ray_f64(self.first + at).ray.origin;
                point.at = origin + point.at;
                point.error += origin_error(origin, &bounds);
            }
            let pack = &mut self.points.packs[at / LANES];
            pack.set(at % LANES, &point, S::IS_INSIDE, hits.hit(lane).0);
        }
    }
}

/// What the errors of a picture's points share.
#[derive(Clone, Copy)]
pub struct LengthsOfRays {
    /// No direction is longer.
    pub longest: f64,
    /// Of `t`, as a length.
    pub of_t: f64,
    /// What no ray's origin adds more than.
    pub of_origin: f64,
}

impl LengthsOfRays {
    /// Those of rays in numbers of `F`.
    pub fn new<F: OfPicture>(stage: &Stage, pixels: &Pixels) -> LengthsOfRays {
        let (longest, input) = (pixels.longest_direction(), F::input(stage));
        LengthsOfRays {
            longest,
            of_t: F::UNIT * of_point(input) * longest,
            of_origin: ROOM * F::UNIT * of_origin(input) * pixels.spread(),
        }
    }
}

/// Neighbours that hit one object. The places of those that are left open go into `open`.
///
/// The errors are those of [`super::surface::reach`]: `|d|·Δ` is what [`Finds::reach`] says of `t`, and the lengths of
/// the ray and of its origin are those that none in the picture exceeds.
struct FindRun<'a, T> {
    sight: &'a T,
    camera: &'a CameraF64,
    run: &'a Run,
    lengths: LengthsOfRays,
    packs: &'a mut [Pack],
    open: &'a mut Vec<usize>,
}

impl<T: Finds<f64>> pulp::WithSimd for FindRun<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let FindRun { sight, camera, run, lengths, packs, open } = self;
        let LengthsOfRays { longest, of_t, of_origin } = lengths;
        let like = |number: f64| WideF64::splat(simd, number);
        let lanes: [f64; LANES] = std::array::from_fn(|lane| lane as f64);
        let j = like(run.offset.1 as f64);
        let (first, end) = (run.at, run.at + run.n);
        let numbers = first / LANES..end.div_ceil(LANES);
        for (number, pack) in numbers.clone().zip(&mut packs[numbers]) {
            let start = number * LANES;
            let mut n_known = 0;
            for at in registers::<S>() {
                let places = WideF64::load(simd, &lanes[at..]) + like(start as f64);
                let columns = (places - like(first as f64)) * like(2.0);
                let rays = camera.camera_rays(like(run.offset.0 as f64) + columns, j);
                let found = sight.reach(&rays, longest);
                let is_in_run = like(first as f64).le(places).and(places.lt(like(end as f64)));
                let is_known = found.is_known.and(is_in_run);
                let place = rays.origin + rays.direction * found.t;
                let error = like(ROOM) * (found.error + found.t * like(of_t)) + like(of_origin);
                let put = |to: &mut [f64; LANES], numbers: WideF64<S>| {
                    let to = &mut to[at..];
                    is_known.select(numbers, WideF64::load(simd, to)).store(to);
                };
                for axis in 0..3 {
                    put(&mut pack.at[axis], place.0[axis]);
                    put(&mut pack.normal[axis], found.normal.0[axis]);
                    put(&mut pack.direction[axis], rays.direction.0[axis]);
                }
                put(&mut pack.error, error);
                put(&mut pack.normal_error, found.normal_error);
                n_known += is_known.bits().count_ones() as usize;
            }
            let lanes = first.max(start) - start..end.min(start + LANES) - start;
            pack.is_inside[lanes.clone()].fill(sight.is_inside());
            if n_known < lanes.len() {
                let is_open = |lane: &usize| pack.error[*lane] == f64::INFINITY;
                open.extend(lanes.filter(is_open).map(|lane| start + lane));
            }
        }
    }
}

struct FindPoints<'a, S, const N: usize> {
    hits: &'a Queue<S, N>,
    bounds: Bounds,
    columns: &'a mut [[f64; lanes::LANES]; 8],
}

impl<S: Sight, const N: usize> pulp::WithSimd for FindPoints<'_, S, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) {
        let FindPoints { hits, bounds, columns } = self;
        for lane in 0..lanes::LANES {
            let (direction, sight) = hits.hit(lane);
            let ray = RayOf::new(Vec3::ZERO, Vec3::ZERO, direction);
            let point = PointF64::new(&sight.surface(&ray, &bounds));
            let [[x, y, z], [nx, ny, nz]] = [point.at.0, point.normal.0];
            let row = [x, y, z, point.error, nx, ny, nz, point.normal_error];
            for (column, number) in columns.iter_mut().zip(row) {
                column[lane] = number;
            }
        }
    }
}

impl Stage<'_> {
    /// Bound of the relative error of a picture's directions in numbers of `F`.
    pub(crate) fn direction_error<F: OfPicture>(&self) -> f64 {
        F::UNIT * F::input(self).direction
    }

    /// Direction of a ray.
    pub(crate) fn direction(&self, index: usize) -> Vec3<f64> {
        self.ray_f64(index).ray.direction
    }

    /// The point of the object that a ray is known to see, and whether that is a sphere around the ray's
    /// origin; `None` where nothing is known in f64.
    pub(crate) fn point_f64(&self, index: usize, id: u32) -> Option<(PointF64, bool)> {
        let ray = self.ray_f64(index);
        if !self.usable || ray.exponent != 0 {
            return None;
        }
        let (bounds, seen) = (&self.bounds, &ray.ray);
        let (found, is_inside) = match self.scene.object(id)? {
            Object::Sphere(sphere) => {
                let place = nearness::Place::new(sphere, ray.reference, seen.origin);
                let sight = SphereSight::new(&place, self.known_k(id, sphere), bounds);
                match sight.k {
                    0.0 => return None,
                    k if k > 0.0 => (Outside(sight).surface(seen, bounds), false),
                    _ => (Inside(sight).surface(seen, bounds), true),
                }
            }
            Object::Plane(_) => {
                (PlaneSight::new(self.plane(id), &ray, bounds).surface(seen, bounds), false)
            }
        };
        let mut point = PointF64::new(&found);
        point.at = seen.origin + point.at;
        point.error += origin_error(seen.origin, bounds);
        let is_known = point.error.is_finite() && point.normal_error.is_finite();
        is_known.then_some((point, is_inside))
    }

    /// The point that a ray is known to see, exactly, and the shape of its object.
    pub(crate) fn exact_point(&self, index: usize, id: u32) -> Option<(ExactPoint, Shape)> {
        let ray = self.exact_ray(index);
        let shape = Shape::from(self.scene.object(id)?);
        let (root, side) = visible_root(&ray, &shape)?;
        Some((ExactPoint::new(&ray, &ExactHit { id, root, side }), shape))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::kernel::Kernel;
    use crate::prepare::Prepared;
    use crate::rays::{Rays, View};
    use crate::scene::{Camera, Color, Plane, Projection, Scene, Sphere};

    /// A sphere and a plane as a camera at the origin sees them, from far or from inside.
    fn scene(rng: &mut ChaCha8Rng) -> Arc<Scene> {
        let mut vector = || DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let (aside, normal) = (vector() * 0.1, vector());
        let distance = 2f64.powi(rng.random_range(-3..12));
        let radius = distance * [0.3, 0.01, 1e-4, 1.5][rng.random_range(0..4)];
        let sphere = Sphere { center: (DVec3::NEG_Z + aside) * distance, radius };
        let color = Color([0.5; 3]);
        let point = DVec3::NEG_Z * (distance * 2.0);
        let plane = Plane { name: None, point, normal: normal + DVec3::Z * 0.3, color };
        let projection = match rng.random_bool(0.5) {
            true => Projection::Perspective { fov_degrees: 20.0 * radius.min(distance) / distance },
            false => Projection::Orthographic { height: radius },
        };
        let camera = Camera { projection, ..Camera::new(DVec3::ZERO, sphere.center) };
        let spheres = [(sphere, color)].into_iter().collect();
        Arc::new(Scene { camera: Some(camera), spheres, planes: vec![plane], ..Scene::default() })
    }

    /// A width of pictures whose points are found side by side, each with its own object, and one whose points are
    /// found as neighbours in a row.
    const WIDTHS: [u32; 2] = [7, 19];

    /// Of points that many rays see: how many are known, and those farther from the true ones than
    /// `share` of their bounds.
    fn look(width: u32, share: f64) -> (usize, Vec<String>) {
        let mut rng = ChaCha8Rng::seed_from_u64(1405);
        let (mut n_known, mut wrong) = (0, Vec::new());
        for _ in 0..200 {
            let scene = scene(&mut rng);
            let pixels = Pixels::whole(View::new(scene.camera.as_ref().unwrap()), width, 5);
            let rays = Rays::Pixels(pixels);
            let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
            let stage = Stage::new(&prepared, &rays);
            let ids: Vec<u32> = (0..pixels.len())
                .map(|at| {
                    let shapes = scene.objects().map(|(id, object)| (id, Shape::from(object)));
                    crate::exact::nearest(&stage.exact_ray(at), shapes).map_or(0, |hit| hit.id)
                })
                .collect();
            let mut points = Points::default();
            points.find(&mut Completer::new(&stage), 0, &ids);
            for (at, &id) in ids.iter().enumerate().filter(|(_, id)| **id != 0) {
                let (pack, lane) = (&points.packs[at / LANES], at % LANES);
                let error = pack.error[lane];
                if !error.is_finite() {
                    continue;
                }
                n_known += 1;
                let (exact, shape) = stage.exact_point(at, id).unwrap();
                let here = DVec3::from_array(std::array::from_fn(|axis| pack.at[axis][lane]));
                let case = || format!("{scene:?} {at}: {here} ± {error:e}");
                if exact.is_within(error * share, here) != Some(true) {
                    wrong.push(case());
                }
                // The normal of a sphere leads from its centre to the point.
                if let Shape::Sphere { center, radius } = shape {
                    let turn = if pack.is_inside[lane] { -radius } else { radius };
                    let normal =
                        DVec3::from_array(std::array::from_fn(|axis| pack.normal[axis][lane]));
                    let rounding = 4.0 * UNIT_F64 * (center.length() + radius);
                    let most = pack.normal_error[lane] * share * radius + rounding;
                    if exact.is_within(most, center + normal * turn) != Some(true) {
                        wrong.push(case());
                    }
                }
            }
        }
        (n_known, wrong)
    }

    #[test]
    fn points_are_within_their_bounds() {
        for width in WIDTHS {
            let (n_known, wrong) = look(width, 1.0);
            assert!(wrong.is_empty(), "{}", wrong[0]);
            assert!(n_known > 700 * width as usize, "{n_known}");
        }
    }

    /// Roundings to the nearest hardly ever add up as the bounds grant: wrong points begin at a 32nd.
    /// `tests/lemmas.rs` halves what each step is granted, with roundings that do.
    #[test]
    fn sabotage_smaller_bounds_are_noticed() {
        for width in WIDTHS {
            assert!(!look(width, 1.0 / 48.0).1.is_empty(), "{width}");
        }
    }
}
