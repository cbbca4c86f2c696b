//! Facts of scenes that no oracle needs. What each scene of `scenes/` shows stands in `tests/answers/scenes.txt`.

use std::f64::consts::{PI, SQRT_2};
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::query::{Kernel, Rays};
use kugelblitz::rays::{Pixels, View};
use kugelblitz_tests::{camera, plane, sphere, traced};

/// A sphere of radius r on the view axis at distance L has the outline of the cone of half-angle
/// asin(r/L): a disc of R = r/√(L² − r²) · H/(2h) pixels. Unit squares around the n pixel centres
/// in it lie within R + √½ and cover R − √½, so that |n − πR²| ≤ π(√2·R + ½).
#[test]
fn a_sphere_on_the_view_axis_covers_the_area_of_its_disc() {
    let (distance, radius) = (5.0, 1.3);
    let ball = sphere(DVec3::new(0.0, 0.0, -distance), radius);
    let scene = Arc::new(kugelblitz_tests::scene(vec![ball], vec![]));
    let view = View::new(&camera(DVec3::ZERO, DVec3::NEG_Z));
    let pixels = Pixels::whole(view, 640, 480);
    let tangent = radius / (distance * distance - radius * radius).sqrt();
    let disc_px = tangent * 480.0 / (2.0 * view.h);
    let area = PI * disc_px * disc_px;
    let slack = PI * (SQRT_2 * disc_px + 0.5);
    assert!(slack < area / 50.0, "{slack} of {area}");
    for kernel in Kernel::ALL {
        let n_hits = traced(&scene, kernel, &Rays::Pixels(pixels), None).n_hits() as f64;
        assert!((n_hits - area).abs() <= slack, "{}: {n_hits}, not {area}", kernel.name());
    }
}

/// A camera that looks down by the angle p sees a horizontal plane below it in the rows whose ray
/// goes down: d.y = −sin p + v·cos p < 0 with v = (1 − 2(y+½)/H)·h, so where v < tan p.
#[test]
fn a_plane_ends_at_its_horizon_row() {
    let down = 0.2_f64;
    let floor = plane(DVec3::ZERO, DVec3::new(0.0, 2.0, 0.0));
    let scene = Arc::new(kugelblitz_tests::scene(vec![], vec![floor]));
    let eye = DVec3::new(3.0, 1.5, -2.0);
    let view = View::new(&camera(eye, eye + DVec3::new(0.0, -down.sin(), -down.cos())));
    let pixels = Pixels::whole(view, 64, 400);
    let horizon = (1.0 - down.tan() / view.h) * 200.0 - 0.5;
    assert!((horizon - horizon.round()).abs() > 0.1, "{horizon} is too near a row");
    for kernel in Kernel::ALL {
        let hits = traced(&scene, kernel, &Rays::Pixels(pixels), None);
        for (index, &id) in hits.id.iter().enumerate() {
            let row = f64::from(pixels.xy(index).1);
            assert_eq!(id == 1, row > horizon, "{}, row {row}", kernel.name());
        }
    }
}
