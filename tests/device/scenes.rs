//! The scenes of `scenes/` show what their first line says.

use std::f64::consts::{PI, SQRT_2};
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Color, Scene, Sphere, read_scene};
use kugelblitz::trace::{Kernel, Rays};
use kugelblitz_tests::{camera, plane, root, sphere, traced};

fn scene(name: &str) -> Scene {
    let path = root().join("scenes").join(name);
    read_scene(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn pixels(scene: &Scene) -> Pixels {
    let camera = scene.camera.as_ref().expect("the scene has a camera");
    let image = scene.image.expect("the scene has a size");
    Pixels::whole(View::new(camera), image.width, image.height)
}

/// b, k, D of contract §1 (a = d·d).
fn discriminant(sphere: &Sphere, origin: DVec3, d: DVec3) -> [f64; 3] {
    let from_center = origin - sphere.center;
    let b = 2.0 * d.dot(from_center);
    let k = from_center.dot(from_center) - sphere.radius * sphere.radius;
    [b, k, b * b - 4.0 * d.dot(d) * k]
}

fn sphere_t(sphere: &Sphere, origin: DVec3, d: DVec3) -> Option<f64> {
    let [b, _, discriminant] = discriminant(sphere, origin, d);
    (discriminant >= 0.0)
        .then(|| [-1.0, 1.0].map(|sign| (-b + sign * discriminant.sqrt()) / (2.0 * d.dot(d))))?
        .into_iter()
        .find(|&t| t > 0.0)
}

/// The id that the textbook formulas in f64 see: good enough away from outlines.
fn visible(scene: &Scene, origin: DVec3, d: DVec3) -> u32 {
    let spheres = scene.spheres.iter().map(|s| sphere_t(s, origin, d));
    let planes = scene.planes.iter().map(|p| {
        let t = (p.point - origin).dot(p.normal) / d.dot(p.normal);
        (t > 0.0 && t.is_finite()).then_some(t)
    });
    let mut best = (f64::INFINITY, 0);
    for (id, t) in (1..).zip(spheres.chain(planes)) {
        match t {
            Some(t) if t < best.0 => best = (t, id),
            _ => {}
        }
    }
    best.1
}

/// How many pixels of every fourth row and column show each id.
fn census(scene: &Scene) -> Vec<u32> {
    let pixels = pixels(scene);
    let mut count = vec![0; scene.n_objects() + 1];
    for y in (0..pixels.height).step_by(4) {
        for x in (0..pixels.width).step_by(4) {
            let ray = pixels.ray(x, y);
            let id = visible(scene, ray.origin, ray.direction);
            count[id as usize] += 1;
        }
    }
    count
}

#[test]
fn each_scene_starts_with_a_comment_and_shows_its_objects() {
    let folder = root().join("scenes");
    let mut n_scenes = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            // `scenes/hard` has a test of its own, tests/device/hard_scenes.rs.
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("# "), "{}", path.display());
        let name = path.file_name().unwrap().to_str().unwrap();
        let scene = scene(name);
        for (id, count) in census(&scene).into_iter().enumerate().skip(1) {
            // Their sphere 1 is the one that must not be seen.
            let hidden = ["figure2.toml", "orthographic.toml"].contains(&name) && id == 1;
            assert_eq!(count == 0, hidden, "{name}: object {id}, {count} pixels");
        }
        n_scenes += 1;
    }
    assert!(n_scenes >= 6, "{n_scenes}");
}

#[test]
fn lit_scenes_have_light() {
    let root = root().join("scenes");
    let mut n_scenes = 0;
    for folder in ["lit", "lit/hard"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|ending| ending != "toml") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.starts_with("# "), "{}", path.display());
            let scene = read_scene(&path).unwrap_or_else(|error| panic!("{error}"));
            assert!(scene.is_lit() && scene.image.is_some(), "{}", path.display());
            n_scenes += 1;
        }
    }
    assert!(n_scenes >= 22, "{n_scenes}");
}

/// The spheres that must touch do so within the rounding of their coordinates.
#[test]
fn contacts_are_contacts() {
    for (name, scale) in [
        ("contacts", 1.0),
        ("contacts_1e-3", 1e-3),
        ("contacts_1e-6", 1e-6),
        ("contacts_1e3", 1e3),
        ("contacts_moved", 1.0),
        ("contacts_on_ball", 1.0),
    ] {
        let scene = scene(&format!("lit/hard/{name}.toml"));
        let slack = match name {
            // Each stands on the ball, lower than on a plane: apart by the difference.
            "contacts_on_ball" => 1e-5,
            "contacts_moved" => 1e-9,
            _ => scale * 1e-15,
        };
        let (spheres, ground) = scene.spheres.split_at(17);
        let mut n_contacts = 0;
        for (i, a) in spheres.iter().enumerate() {
            assert_eq!(a.radius, scale);
            for b in &spheres[..i] {
                let gap = a.center.distance(b.center) - 2.0 * scale;
                assert!(gap > -slack, "{name}: {gap:e}");
                n_contacts += usize::from(gap < slack);
            }
            let height = match (ground, &scene.planes[..]) {
                ([ball], []) => a.center.distance(ball.center) - ball.radius,
                ([], [floor]) => a.center.y - floor.point.y,
                other => panic!("{name}: {other:?}"),
            };
            // The last one lies on four others.
            assert_eq!((height - scale).abs() < 1e-9 * scale, i < 16, "{name}: {height:e}");
        }
        assert_eq!(n_contacts, 24 + 4, "{name}");
    }
}

#[test]
fn figure2_hides_and_cuts_as_the_lecture_says() {
    let scene = scene("figure2.toml");
    let pixels = pixels(&scene);
    assert!(scene.spheres[0].center.z - scene.spheres[0].radius > 0.0);
    assert_eq!(scene.spheres.color(2), Color::from_hex("#d62728"));
    let (mut hides, mut n_in_view, mut n_beyond_edge) = ([0; 5], 0, 0);
    for y in (0..pixels.height).step_by(4) {
        for x in (0..2 * pixels.width).step_by(4) {
            let d = pixels.direction(x, y);
            let hit = |index: usize| sphere_t(&scene.spheres[index], DVec3::ZERO, d).is_some();
            if x >= pixels.width {
                n_beyond_edge += u32::from(hit(3));
                continue;
            }
            n_in_view += u32::from(hit(3));
            if hit(2) {
                hides[visible(&scene, DVec3::ZERO, d) as usize] += 1;
            }
        }
    }
    assert!(hides[2] > 100 && hides[3] > 1000 && hides[4] > 100, "{hides:?}");
    // Half of sphere 4: its centre stands on the picture's right edge.
    assert!(n_in_view > 1000 && n_beyond_edge > 1000);
    let center = scene.spheres[3].center;
    let half_width = pixels.view.h * f64::from(pixels.image_width) / f64::from(pixels.image_height);
    let column = (1.0 + center.x / -center.z / half_width) / 2.0 * f64::from(pixels.image_width);
    assert!((column - 1280.0).abs() < 0.5, "{column}");
}

#[test]
fn figure5_has_all_three_discriminants_on_its_centre_ray() {
    let scene = scene("figure5.toml");
    let pixels = pixels(&scene);
    let d = pixels.direction(640, 360);
    assert_eq!(d, DVec3::NEG_Z);
    assert_eq!(pixels.view.position, DVec3::ZERO);
    let table = scene.spheres.iter().map(|s| discriminant(s, DVec3::ZERO, d));
    assert_eq!(
        table.collect::<Vec<_>>(),
        [[-32.0, 283.0, -108.0], [-48.0, 576.0, 0.0], [-80.0, 1584.0, 64.0]]
    );
    let at = |x, y| visible(&scene, DVec3::ZERO, pixels.direction(x, y));
    assert_eq!([at(640, 360), at(639, 361), at(641, 359)], [2, 3, 2]);
}

#[test]
fn inside_shows_no_background() {
    let scene = scene("inside.toml");
    let hall = &scene.spheres[0];
    let eye = scene.camera.as_ref().unwrap().position;
    assert!(eye.distance(hall.center) < hall.radius);
    let count = census(&scene);
    assert_eq!(count[0], 0);
    assert!(count[1] > 1000, "{count:?}");
}

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
