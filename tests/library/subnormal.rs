//! Directions and normals below f64's normal range: they are as good as any.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz::exact::{ExactRay, nearest};
use kugelblitz::prepare::{Scaled, exponent_of, power_of_two};
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::trace::{Kernel, Ray, Rays};
use kugelblitz_tests::{in_cube, judge, plane, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn subnormal(rng: &mut ChaCha8Rng, direction: DVec3) -> DVec3 {
    let exponent = rng.random_range(-1073..=-1022);
    times_power_of_two(direction, exponent - exponent_of(direction))
}

fn times_power_of_two(v: DVec3, exponent: i32) -> DVec3 {
    v * power_of_two(exponent / 2) * power_of_two(exponent - exponent / 2)
}

/// `1 ≤ |d|`, as the bounds of the slack assume, whatever the length was; and exactly.
#[test]
fn directions_are_scaled_to_at_least_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(1181);
    for _ in 0..20_000 {
        let length = 2f64.powi(rng.random_range(-1074..=1023));
        let direction = in_cube(&mut rng) * length;
        if direction == DVec3::ZERO {
            continue;
        }
        let scaled = Scaled::new(direction);
        let (scaled, exponent) = (scaled.rounded(), scaled.exponent());
        let largest = scaled.abs().max_element();
        assert!((1.0..2.0).contains(&largest), "{direction:?}: 2^{exponent}, {scaled:?}");
        if exponent < 0 {
            assert_eq!(times_power_of_two(scaled, exponent), direction);
        }
    }
    for (v, is_exact) in [
        (dvec3(0.5, 5e-324, 0.0), true),
        (dvec3(2f64.powi(-1000), 0.0, -5e-324), true),
        (dvec3(4.0, -5e-324, 0.0), false),
        (dvec3(1e300, 1e-100, 0.0), false),
        (dvec3(1e300, 1e-7, 0.0), true),
    ] {
        let scaled = Scaled::new(v);
        assert_eq!(scaled.exact().is_some(), is_exact, "{v}");
        for axis in 0..3 {
            let (of, x) = (v[axis], scaled.rounded()[axis]);
            assert!((x == 0.0) == (of == 0.0) && x.is_sign_negative() == of.is_sign_negative());
        }
        if let Some(exact) = scaled.exact() {
            assert_eq!(times_power_of_two(exact, scaled.exponent()), v);
        }
    }
    assert_eq!(
        [0.0, 5e-324, f64::MIN_POSITIVE].map(|x| exponent_of(DVec3::X * x)),
        [0, -1074, -1022]
    );
}

/// Spheres and planes so near to the origin of such rays that `t` is an f32, or nearly.
#[test]
fn subnormal_directions_see_what_is_there() {
    let mut rng = ChaCha8Rng::seed_from_u64(1182);
    let mut n_hits = 0;
    for _ in 0..300 {
        // |d| is about 2⁻¹⁰⁴⁸: t up to 2¹²⁸ for a distance of 2⁻⁹²⁰.
        let size = 2f64.powi(rng.random_range(-1000..-880));
        let at = |rng: &mut ChaCha8Rng| in_cube(rng) * size;
        let spheres = (0..3).map(|_| sphere(at(&mut rng), 0.4 * size)).collect();
        let planes = vec![
            plane(at(&mut rng), subnormal(&mut rng, DVec3::ONE)),
            plane(at(&mut rng), DVec3::Y),
        ];
        let scene = Arc::new(scene(spheres, planes));
        let mut rays: Vec<Ray> = (0..20)
            .map(|_| {
                let (origin, toward) = (at(&mut rng), in_cube(&mut rng));
                Ray { origin, direction: subnormal(&mut rng, toward) }
            })
            .collect();
        rays.push(Ray { origin: DVec3::ZERO, direction: DVec3::Z * 5e-324 });
        let objects = judge::objects(&scene);
        let exact = |ray: &Ray| nearest(&ExactRay::new(ray), objects.iter().copied());
        n_hits += rays.iter().filter(|ray| exact(ray).is_some()).count();
        let list = Rays::List(rays);
        let hits = judge::trace(&scene, Kernel::Certified, &list, None);
        if let Err(what) = judge::judge(&scene, &list, &hits, 1) {
            panic!("{what}");
        }
        // The others promise nothing, but give an answer.
        for kernel in [Kernel::Lecture, Kernel::Stable, Kernel::Double] {
            let hits = judge::trace(&scene, kernel, &list, None);
            assert!(hits.t.iter().all(|t| !t.is_nan()), "{}", kernel.name());
        }
    }
    println!("{n_hits} hits");
    assert!(n_hits > 500);
}

/// Ordinary distances: `t` is beyond f32, and that is no hit.
#[test]
fn ordinary_spheres_are_too_far_for_subnormal_directions() {
    let mut rng = ChaCha8Rng::seed_from_u64(1183);
    let scene =
        Arc::new(scene(vec![sphere(DVec3::NEG_Z * 5.0, 2.0)], vec![plane(DVec3::NEG_Y, DVec3::Y)]));
    let rays = (0..100).map(|_| {
        let toward = dvec3(0.0, 0.0, -1.0) + 0.5 * in_cube(&mut rng);
        Ray { origin: DVec3::ZERO, direction: subnormal(&mut rng, toward) }
    });
    let list = Rays::List(rays.collect());
    let hits = judge::trace(&scene, Kernel::Certified, &list, None);
    assert!(judge::judge(&scene, &list, &hits, 1).is_ok());
    assert!(hits.id.iter().all(|&id| id == 0));
}

/// The distance from a plane with a subnormal normal, where f64 cancels: `N = n·(a − o)` itself has no
/// digits left.
#[test]
fn planes_with_subnormal_normals_are_told_apart() {
    let tiny = 2f64.powi(-1048);
    let at = |x: f64, length: f64| {
        plane(dvec3(1.0 + x * 2f64.powi(-26), 1.0, 0.0), dvec3(1.0, -1.0, 0.0) * length)
    };
    // Rounded to f64's last subnormals, 1.5 becomes 2 and 1.25 becomes 1.
    for (x, other) in [(1.5, 1.75), (1.25, 1.125), (1.25, 1.5), (1.5, 1.25)] {
        let scene = Arc::new(scene(vec![], vec![at(x, tiny), at(other, 1.0)]));
        let forward = dvec3(1.0, -1.0, 0.0).normalize();
        let view = View {
            position: DVec3::ZERO,
            forward,
            right: forward.cross(DVec3::Z),
            true_up: DVec3::Z,
            h: 0.1,
            lens: Lens::Perspective,
        };
        let rays = Rays::Pixels(Pixels::whole(view, 4, 3));
        let hits = judge::trace(&scene, Kernel::Certified, &rays, None);
        if let Err(what) = judge::judge(&scene, &rays, &hits, 1) {
            panic!("{what}");
        }
    }
}
