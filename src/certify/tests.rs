//! What is held of undecided rays, and what is left out of equal objects.

use super::decide::Decision;
use super::*;
use crate::camera::View;
use crate::scene::{Camera, Color, Plane, Projection, Sphere};
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

/// Spheres that differ in the last bits and lie in no order: f64 leaves all of them open.
fn nearly_equal(n: usize) -> Vec<Sphere> {
    let sphere = |i: usize| {
        let shift = (i * 7919 % n) as f64 * f64::EPSILON;
        let center = DVec3::new(shift, 0.0, -5.0 - shift);
        Sphere { center, radius: 1.0 }
    };
    (0..n).map(sphere).collect()
}

fn pixels(width: u32, height: u32) -> Pixels {
    let (position, look_at) = (DVec3::ZERO, DVec3::NEG_Z);
    let projection = Projection::Perspective { fov_degrees: 10.0 };
    let camera = Camera { position, look_at, up: DVec3::Y, projection };
    Pixels::whole(View::new(&camera), width, height)
}

fn decide(stage: &Stage, n_rays: u32) -> Vec<(u32, f32, Level)> {
    let wants = Wants { surface: true, level: true };
    let mut all = Vec::new();
    let rays: Vec<u32> = (0..n_rays).collect();
    let put = |_, settled: Settled| all.push((settled.id, settled.t, settled.level));
    let control = Control::default();
    stage.decide(&rays, wants, &control, &mut Timing::default(), put).unwrap();
    all
}

#[test]
fn candidates_that_are_not_held_are_found_again() {
    let (n, pixels) = (300, pixels(8, 6));
    let scene = Scene { spheres: nearly_equal(n).into(), ..Scene::default() };
    let rays = Rays::Pixels(pixels);
    let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
    let decided = |most_held| decide(&Stage { most_held, ..Stage::new(&prepared, &rays) }, 48);
    let all = decided(MOST_HELD);
    let n_exact = all.iter().filter(|(.., level)| *level == Level::Exact).count();
    assert!(n_exact > 40, "{n_exact}");
    for most_held in [0, n - 1, n, 5 * n + 17] {
        assert_eq!(decided(most_held), all, "{most_held}");
    }
}

#[test]
fn no_more_candidates_are_held_than_there_is_room_for() {
    let room = AtomicUsize::new(5);
    let open = |n| Decision::Open(vec![1; n]);
    assert!(open(3).hold(&room).is_some());
    assert!(open(3).hold(&room).is_none());
    assert!(open(2).hold(&room).is_some());
    assert!(open(1).hold(&room).is_none());
    assert!(Decision::Decided(1).hold(&room).is_some());
}

/// However many planes and spheres coincide, one of them needs no exact arithmetic.
#[test]
fn of_equal_objects_the_first_is_the_only_candidate() {
    let plane = Plane {
        name: None,
        point: DVec3::new(0.0, 0.0, -7.0),
        normal: DVec3::Z,
        color: Color::BLACK,
    };
    let sphere = nearly_equal(1).remove(0);
    for (n_spheres, n_planes) in [(500, 1), (0, 500)] {
        let scene = Scene {
            spheres: vec![sphere; n_spheres].into(),
            planes: vec![plane.clone(); n_planes],
            ..Scene::default()
        };
        let rays = Rays::Pixels(pixels(8, 6));
        let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
        let all = decide(&Stage::new(&prepared, &rays), 48);
        assert!(all.iter().all(|(id, _, level)| *id == 1 && *level == Level::F64));
    }
}
