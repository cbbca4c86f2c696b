//! Where rays meet their objects, in f64 with bounds of the errors.

use super::Stage;
use super::surfaces::{self, Output, Surfaces};
use crate::exact::{ExactHit, ExactPoint, Shape, visible_root};
use crate::num::{Float, Lanes};
use crate::seen::Surface;
use crate::vec3::Vec3;
use crate::wide::WideF64;
#[cfg(feature = "gpu")]
use crate::{
    guard::{LIST_F64, UNIT_F64, input_of_picture, steps},
    rays::Bundle,
};

/// Points side by side.
pub const LANES: usize = super::surfaces::LANES;

/// Where the registers of a row of [`LANES`] numbers begin.
#[inline(always)]
pub fn registers<S: pulp::Simd>() -> impl Iterator<Item = usize> {
    (0..LANES).step_by(WideF64::<S>::LANES)
}

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
}

/// One point of a [`Pack`].
#[derive(Clone, Copy)]
pub struct PointF64 {
    pub at: Vec3<f64>,
    pub error: f64,
    pub normal: Vec3<f64>,
}

/// The constants of points in `shaders/lit.wgsl`, by their names there. A device's division is in the
/// bounds of `t`, its roots are lengths in bounds, and a plane's unit normal has a bound for a device.
#[cfg(feature = "gpu")]
pub fn factors_of_points(bundle: Bundle) -> [(&'static str, f64); 4] {
    let input = input_of_picture(bundle).unwrap_or(LIST_F64);
    [
        ("OF_POINT", input.direction + steps::POINT),
        ("OF_ORIGIN", input.offset + steps::POINT_ORIGIN),
        ("OF_PLANE_NORMAL", steps::NORMALIZED_WIDE),
        ("DIRECTION_ERROR", UNIT_F64 * input.direction),
    ]
}

/// The points of consecutive rays of one [`Stage`], in the order of the rays.
#[derive(Default)]
pub struct Points {
    /// The points.
    pub packs: Vec<Pack>,
    room: Vec<surfaces::Pack<Surface<Lanes<f64, LANES>>>>,
}

impl Points {
    /// Finds the points that rays from `first` on see, whose objects are known.
    pub fn find(&mut self, surfaces: &Surfaces, first: usize, ids: &[u32]) {
        self.packs.resize(ids.len().div_ceil(LANES), Pack::NONE);
        for (pack, ids) in self.packs.iter_mut().zip(ids.chunks(LANES)) {
            pack.reset(ids);
        }
        if surfaces.are_known() {
            let mut room = std::mem::take(&mut self.room);
            surfaces.find(first, ids, &mut room, self);
            self.room = room;
        }
    }
}

impl Output for Points {
    type Kept = Surface<Lanes<f64, LANES>>;

    #[inline(always)]
    fn keep(surface: &Self::Kept, kept: &mut Self::Kept) {
        *kept = *surface;
    }

    #[inline(always)]
    fn take(&mut self, at: usize, _: usize, found: &surfaces::Pack<Self::Kept>) {
        let (pack, surface) = (&mut self.packs[at / LANES], &found.kept);
        for axis in 0..3 {
            pack.at[axis] = surface.point.0[axis].0;
            pack.normal[axis] = surface.normal.0[axis].0;
            pack.direction[axis] = found.ray.direction.0[axis].0;
        }
        for lane in 0..LANES {
            let error = surface.point_error.0[lane];
            let is_known = (pack.id[lane] != 0) & (error < f64::BEYOND / 4.0);
            let known = |error: f64| if is_known { error } else { f64::INFINITY };
            pack.error[lane] = known(error);
            pack.normal_error[lane] = known(surface.normal_error.0[lane]);
            pack.is_inside[lane] = is_known & (surface.front.0[lane] == 0);
        }
    }

    #[inline(always)]
    fn miss(&mut self, _: usize, _: usize) {}
}

impl Surfaces<'_> {
    /// The point of the object that a ray is known to see, and whether that is a sphere around the ray's
    /// origin; `None` where nothing is known in f64.
    pub fn point(&self, index: usize, id: u32) -> Option<(PointF64, bool)> {
        let mut points = Points::default();
        points.find(self, index, &[id]);
        let [pack] = &points.packs[..] else { return None };
        let first = |rows: &[[f64; LANES]; 3]| Vec3([rows[0][0], rows[1][0], rows[2][0]]);
        let point =
            PointF64 { at: first(&pack.at), error: pack.error[0], normal: first(&pack.normal) };
        point.error.is_finite().then_some((point, pack.is_inside[0]))
    }
}

impl Stage<'_> {
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
    use crate::guard::UNIT_F64;
    use crate::kernel::Kernel;
    use crate::prepare::Prepared;
    use crate::rays::{Pixels, Rays, View};
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
            points.find(&Surfaces::new(&stage), 0, &ids);
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
