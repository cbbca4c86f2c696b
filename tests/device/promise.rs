//! Minimal cases in which the certified kernel broke its promise, each found by a campaign or by
//! reading: they must stay right.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::scene::{Plane, Sphere};
use kugelblitz::trace::{Kernel, Ray, Rays};
use kugelblitz_tests::judge::{judge, trace};
use kugelblitz_tests::{gpu, plane, scene, sphere};

fn assert_kept(spheres: Vec<Sphere>, planes: Vec<Plane>, rays: Rays) {
    let scene = Arc::new(scene(spheres, planes));
    for gpu in [None, Some(gpu())] {
        let hits = trace(&scene, Kernel::Certified, &rays, gpu.as_ref());
        if let Err(what) = judge(&scene, &rays, &hits, 1) {
            panic!("{}: {what}", if gpu.is_some() { "GPU" } else { "CPU" });
        }
    }
}

fn list(rays: &[(DVec3, DVec3)]) -> Rays {
    Rays::List(rays.iter().map(|&(origin, direction)| Ray { origin, direction }).collect())
}

/// One pixel, whose ray is `forward`.
fn axis_ray(forward: DVec3) -> Rays {
    let view = View {
        position: DVec3::ZERO,
        forward,
        right: DVec3::Y,
        true_up: DVec3::Z,
        h: 1.0,
        lens: Lens::Perspective,
    };
    Rays::Pixels(Pixels::whole(view, 1, 1))
}

/// Two eyes 2·10²⁰ apart: in f32 the squared distance overflows, and so must not look like a miss.
#[test]
fn origins_far_apart_in_one_list() {
    let eye = DVec3::X * 1e20;
    let rays = list(&[(eye, -DVec3::X), (-eye, DVec3::X)]);
    assert_kept(vec![sphere(DVec3::ZERO, 1e19)], vec![], rays);
}

/// `(a − o)·n` of subnormal f32 numbers: three roundings to a multiple of 2⁻¹⁴⁹ turn its sign.
#[test]
fn a_plane_at_a_subnormal_f32_distance() {
    let quantum = 2f64.powi(-149);
    let point = dvec3(1.45, 1.45, -2.55) * quantum;
    let normal = DVec3::splat(1.9);
    let rays = list(&[(DVec3::ZERO, DVec3::X), (DVec3::ZERO, -DVec3::X)]);
    assert_kept(vec![], vec![plane(point, normal)], rays);
}

/// The square of the distance underflows in f64, but its products with the normal do not.
#[test]
fn a_plane_at_a_distance_whose_square_underflows_f64() {
    let tiny = 2f64.powi(-600);
    let e = 2f64.powi(-52);
    // (1 + e)² − (1 + 2e) = e², which f64 rounds to 0; then −e²/2 decides the sign wrongly.
    let point = dvec3(1.0 + e, -1.0, -e * e / 2.0) * tiny;
    let normal = dvec3(1.0 + e, 1.0 + 2.0 * e, 1.0);
    let direction = DVec3::X * tiny;
    let rays = list(&[(DVec3::ZERO, direction), (DVec3::ZERO, -direction)]);
    assert_kept(vec![], vec![plane(point, normal)], rays);
}

/// The nearness of sphere 1, `2·2²⁸/2⁻¹⁰⁰`, is beyond f32; sphere 2 is too small for f32 and nearer.
#[test]
fn an_infinite_nearness_and_an_object_out_of_range() {
    let far = 2f64.powi(28);
    let near = 2f64.powi(-140);
    let spheres = vec![
        sphere(dvec3(far, 2f64.powi(-50), 0.0), far),
        sphere(dvec3(2.0 * near, 0.0, 0.0), near),
    ];
    assert_kept(spheres, vec![], axis_ray(DVec3::X));
}

/// `k = 2⁻¹⁰⁸⁰` is 0 in f64, but the eye is not on the sphere: `t = 2⁻¹⁰⁸¹`, not 2.
#[test]
fn an_eye_so_near_a_sphere_that_k_underflows_f64() {
    let spheres =
        vec![sphere(dvec3(1.0, 2f64.powi(-540), 0.0), 1.0), sphere(dvec3(1.0, 0.0, 0.0), 0.5)];
    assert_kept(spheres, vec![], axis_ray(DVec3::X));
}

/// `(a − o)·n = 2⁻¹⁰⁷⁵` is 0 in f64, but the eye is not in the plane.
#[test]
fn an_eye_so_near_a_plane_that_its_offset_underflows_f64() {
    let small = 2f64.powi(-1000);
    let e = 2f64.powi(-52);
    let normal = dvec3(1.0, -1.0 - e, 1.0) * small;
    let point = dvec3(1.0 + e, 1.0, 2f64.powi(-75));
    assert_kept(vec![], vec![plane(point, normal)], axis_ray(DVec3::X));
}

/// Two objects at subnormal f64 distances: an infinite nearness hides one that is not known.
#[test]
fn an_infinite_f64_nearness_and_an_undecided_object() {
    let r = 2f64.powi(-14);
    let spheres = vec![sphere(-DVec3::Y * r, r)];
    let planes = vec![plane(DVec3::ZERO, -DVec3::Y)];
    let origin = DVec3::Y * -f64::from_bits(1);
    let rays = list(&[
        (origin, dvec3(-21.0, 12.0, 20.0)),
        (origin, dvec3(-21.0, -12.0, 20.0)),
        (-origin, dvec3(-21.0, -12.0, 20.0)),
    ]);
    assert_kept(spheres, planes, rays);
}
