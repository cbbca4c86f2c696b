//! Where rays meet their objects, exactly.

use super::Resolver;
use crate::exact::{ExactPoint, visible_hit};

impl<'a> Resolver<'a> {
    /// The point that a ray is known to see, exactly.
    pub(crate) fn exact_point(&self, index: usize, id: u32) -> Option<ExactPoint<'a>> {
        let ray = self.exact.ray(index);
        Some(ExactPoint::new(&ray, &visible_hit(&ray, id, self.prepared.scene.object(id)?)?))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::pack::{LANES, PackF64};
    use super::super::surfaces::Surfaces;
    use super::*;
    use crate::exact::nearest;
    use crate::kernel::Kernel;
    use crate::num::Float;
    use crate::prepare::Prepared;
    use crate::rays::{Pixels, Rays, View};
    use crate::scene::{Camera, Color, Object, Plane, Projection, Scene, Sphere};

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

    /// Looks at points that many rays see: counts those that are known, and tells those farther from the true ones than
    /// `share` of their bounds.
    fn look(width: u32, share: f64) -> (usize, Vec<String>) {
        let mut rng = ChaCha8Rng::seed_from_u64(1405);
        let (mut n_known, mut wrong) = (0, Vec::new());
        for _ in 0..200 {
            let scene = scene(&mut rng);
            let pixels = Pixels::whole(View::new(scene.camera.as_ref().unwrap()), width, 5);
            let rays = Rays::Pixels(pixels);
            let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
            let stage = Resolver::new(&prepared, &rays);
            let ids: Vec<u32> = (0..pixels.len())
                .map(|at| nearest(&stage.exact.ray(at), scene.objects()).map_or(0, |hit| hit.id))
                .collect();
            let (surfaces, mut packs) = (Surfaces::in_f64(&stage), Vec::<PackF64>::new());
            for (at, &id) in ids.iter().enumerate() {
                let column = at % width as usize;
                if column == 0 {
                    surfaces.load(at, &ids[at..][..width as usize], &mut packs);
                    surfaces.solve(&mut packs);
                }
                let seen = packs[column / LANES].surface.lane(column % LANES);
                if id == 0 || !seen.is_known() {
                    continue;
                }
                n_known += 1;
                let exact = stage.exact_point(at, id).unwrap();
                let (here, error) = (DVec3::from_array(seen.point.0), seen.point_error);
                let case = || format!("{scene:?} {at}: {here} ± {error:e}");
                if exact.is_within(error * share, here) != Some(true) {
                    wrong.push(case());
                }
                // The normal of a sphere leads from its centre to the point.
                if let Some(Object::Sphere(&Sphere { center, radius })) = scene.object(id) {
                    let turn = if seen.front { radius } else { -radius };
                    let normal = DVec3::from_array(seen.normal.0);
                    let rounding = 4.0 * f64::UNIT * (center.length() + radius);
                    let most = seen.normal_error * share * radius + rounding;
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
    /// `tests/library/lemmas.rs` halves what each step is granted, with roundings that do.
    #[test]
    fn sabotage_smaller_bounds_are_noticed() {
        for width in WIDTHS {
            assert!(!look(width, 1.0 / 48.0).1.is_empty(), "{width}");
        }
    }
}
