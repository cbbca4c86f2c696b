//! The scenes of `scenes/hard`, which renderers in f32 get wrong: here every pixel is right.

mod common;
#[path = "common/judge.rs"]
mod judge;

use std::path::Path;
use std::sync::Arc;

use common::gpu;
use kugelblitz::camera::{Pixels, View};
use kugelblitz::exact::nearest;
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::trace::{Kernel, Rays};

use judge::{ExactRays, judge, objects, trace};

/// All pixels of a picture of this size.
const SIZE: [u32; 2] = [320, 180];

fn scene(name: &str) -> (Arc<Scene>, Rays) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/hard").join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("# "), "{name} starts with a comment");
    let scene = read_scene(&path).unwrap_or_else(|error| panic!("{error}"));
    let view = View::new(scene.camera.as_ref().expect("a camera"));
    (Arc::new(scene), Rays::Pixels(Pixels::whole(view, SIZE[0], SIZE[1])))
}

/// Share of pixels whose object the lecture's formulas in f32 get wrong, or whose `t` is off by
/// more than a part in 2²⁰.
fn lecture_is_wrong(scene: &Arc<Scene>, rays: &Rays) -> f64 {
    let hits = trace(scene, Kernel::Lecture, rays, None);
    let (objects, exact_rays) = (objects(scene), ExactRays::new(rays));
    let wrong = (0..rays.len()).filter(|&i| {
        let exact = nearest(&exact_rays.ray(i), objects.iter().copied());
        let (id, t) = exact.map_or((0, 0.0), |hit| (hit.id, hit.t_f64()));
        hits.id[i] != id || (id != 0 && (f64::from(hits.t[i]) / t - 1.0).abs() > 2f64.powi(-20))
    });
    wrong.count() as f64 / rays.len() as f64
}

/// Every pixel on both devices; `visible` are the ids that must be seen.
fn assert_right(name: &str, visible: &[u32], lecture_wrong: f64) {
    let (scene, rays) = scene(name);
    let mut ids = Vec::new();
    for gpu in [None, Some(gpu())] {
        let device = if gpu.is_some() { "GPU" } else { "CPU" };
        let hits = trace(&scene, Kernel::Certified, &rays, gpu.as_ref());
        let tally = judge(&scene, &rays, &hits, 8).unwrap_or_else(|what| panic!("{what}"));
        println!("{name} on the {device}: {:?}", tally.counts);
        ids.push(hits.id);
    }
    assert!(ids[0] == ids[1], "{name}: GPU and CPU see the same");
    for id in 0..=scene.n_objects() as u32 {
        assert_eq!(ids[0].contains(&id), visible.contains(&id), "{name}: {id} in the picture");
    }
    // Else the scene would not be hard.
    let wrong = lecture_is_wrong(&scene, &rays);
    println!("{name}: lecture wrong in {:.1} % of the pixels", 100.0 * wrong);
    assert!(wrong >= lecture_wrong, "{name}: lecture wrong in {wrong} only");
}

#[test]
fn figure2_moved_by_1e8() {
    assert_right("moved.toml", &[0, 2, 3, 4], 0.1);
}

#[test]
fn figure2_scaled_by_1e_minus_6() {
    // Scaling alone does not hurt the lecture's formulas: they have no epsilon.
    assert_right("tiny.toml", &[0, 2, 3, 4], 0.0);
}

#[test]
fn figure2_on_a_ground_of_radius_1e9() {
    assert_right("huge_ground.toml", &[0, 2, 3, 4, 5], 0.1);
}
