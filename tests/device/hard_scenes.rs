//! The scenes of `scenes/hard`, which renderers in f32 get wrong: here every pixel is right.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::exact::nearest;
use kugelblitz::num::OPEN;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::judge::{ExactRays, judge, objects, trace};
use kugelblitz_tests::{gpu, root};

/// All pixels of a picture of this size; odd, so that the view axis is the ray of a pixel.
const SIZE: [u32; 2] = [161, 91];

/// Each scene, the ids that are not in its picture, and the least share of pixels that the
/// lecture's formulas in f32 get wrong.
const SCENES: &[(&str, &[u32], f64)] = &[
    ("coincident", &[18], 0.05),
    ("coincident_far", &[], 0.9),
    ("distant_1e2", &[], 0.1),
    ("distant_1e4", &[], 0.5),
    ("distant_1e6", &[], 0.9),
    ("far_1e4", &[1], 0.2),
    ("far_1e6", &[1], 0.2),
    ("far_1e8", &[1], 0.3),
    ("grazing", &[], 0.5),
    ("huge_ground", &[1], 0.1),
    ("inside_nested", &[1, 3, 6], 0.05),
    ("near_parallel", &[], 0.1),
    // Scaling alone does not hurt the lecture's formulas: they have no epsilon.
    ("tiny", &[1], 0.0),
    ("touching", &[16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30], 0.04),
];

fn scene(name: &str) -> (Arc<Scene>, Rays) {
    let path = folder().join(name).with_extension("toml");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("# "), "{name} starts with a comment");
    let scene = read_scene(&path).unwrap_or_else(|error| panic!("{error}"));
    let view = View::new(scene.camera.as_ref().expect("a camera"));
    (Arc::new(scene), Rays::Pixels(Pixels::whole(view, SIZE[0], SIZE[1])))
}

fn folder() -> PathBuf {
    root().join("scenes/hard")
}

/// Shares of pixels whose object the formulas of a kernel get wrong, and of those where it or `t`,
/// by more than a part in 2²⁰, is.
fn wrong(kernel: Kernel, scene: &Arc<Scene>, rays: &Rays) -> [f64; 2] {
    let hits = trace(scene, kernel, rays, None);
    let (objects, exact_rays) = (objects(scene), ExactRays::new(rays));
    let mut n_wrong = [0, 0];
    for i in 0..rays.len() {
        let exact = nearest(&exact_rays.ray(i), objects.iter().copied());
        let (id, t) = exact.map_or((0, 0.0), |hit| (hit.id, hit.t_f64()));
        let is_far = id != 0 && (f64::from(hits.t[i]) / t - 1.0).abs() > 2f64.powi(-20);
        n_wrong[0] += usize::from(hits.id[i] != id);
        n_wrong[1] += usize::from(hits.id[i] != id || is_far);
    }
    n_wrong.map(|n| n as f64 / rays.len() as f64)
}

#[test]
fn every_file_is_in_the_list() {
    let files = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let files: BTreeSet<_> =
        files.map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    let listed = SCENES.iter().map(|(name, ..)| format!("{name}.toml")).collect();
    assert_eq!(files, listed);
}

#[test]
fn every_pixel_of_every_scene_is_right_on_both_devices() {
    for (name, hidden, _) in SCENES {
        let (scene, rays) = scene(name);
        let mut ids = Vec::new();
        for gpu in [None, Some(gpu())] {
            let device = if gpu.is_some() { "GPU" } else { "CPU" };
            let hits = trace(&scene, Kernel::Certified, &rays, gpu.as_ref());
            let tally =
                judge(&scene, &rays, &hits, 8).unwrap_or_else(|what| panic!("{name}: {what}"));
            println!("{name} on the {device}: {:?}", tally.counts);
            ids.push(hits.id);
        }
        assert!(ids[0] == ids[1], "{name}: GPU and CPU see the same");
        for id in 1..=scene.n_objects() as u32 {
            assert_eq!(ids[0].contains(&id), !hidden.contains(&id), "{name}: {id} in the picture");
        }
    }
}

/// Numbers at the ends of f64's range, in each of which something was certain once that was wrong.
#[test]
fn numbers_at_the_ends_of_f64_are_no_less_right() {
    let folder = &root().join("tests/data/ends");
    let mut n_scenes = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let scene = Arc::new(read_scene(&path).unwrap_or_else(|error| panic!("{error}")));
        let view = View::new(scene.camera.as_ref().expect("a camera"));
        let size = scene.image.expect("a size");
        let rays = Rays::Pixels(Pixels::whole(view, size.width, size.height));
        for gpu in [None, Some(gpu())] {
            let hits = trace(&scene, Kernel::Certified, &rays, gpu.as_ref());
            judge(&scene, &rays, &hits, 1).unwrap_or_else(|what| panic!("{path:?}: {what}"));
            let is_turned = |part: &f32| part.to_bits() == (-0f32).to_bits();
            assert!(!hits.normal.iter().flatten().any(is_turned), "{path:?}: −0");
        }
        n_scenes += 1;
    }
    assert_eq!(n_scenes, 5);
}

/// Else they would not be hard.
#[test]
fn the_lectures_formulas_get_every_scene_wrong() {
    for &(name, _, least) in SCENES {
        let (scene, rays) = scene(name);
        let [_, wrong] = wrong(Kernel::Lecture, &scene, &rays);
        println!("{name}: lecture wrong in {:.2} % of the pixels", 100.0 * wrong);
        assert!(wrong >= least, "{name}: lecture wrong in {wrong} only");
    }
}

/// The rays that are tried tell of all of them.
#[test]
fn scenes_whose_rays_f32_leaves_open_begin_in_f64() {
    let (control, mut hits) = (Control::default(), Hits::default());
    let mut in_f64 = Vec::new();
    for &(name, ..) in SCENES {
        let (scene, rays) = scene(name);
        let prepared = Prepared::new(scene, Kernel::Certified, &rays).unwrap();
        let starts_in_f64 = prepared.starts_in_f64();
        let mut tracer = CpuTracer::new(Arc::new(prepared), Wants::default());
        tracer.propose(&rays, &control, &mut hits).unwrap();
        let n_open = hits.id.iter().filter(|&&id| id == OPEN).count();
        assert_eq!(starts_in_f64, 2 * n_open > rays.len(), "{name}: {n_open} open");
        tracer.trace(&rays, &control, &mut hits).unwrap();
        assert_eq!(starts_in_f64, hits.counts.f32 == 0, "{name}: {:?}", hits.counts);
        in_f64.extend(starts_in_f64.then_some(name));
    }
    assert_eq!(in_f64, ["coincident_far", "distant_1e6", "inside_nested", "near_parallel"]);
}

/// A reason not to be content with f64.
#[test]
fn plain_f64_gets_a_scene_wrong() {
    let (scene, rays) = scene("coincident_far");
    let [wrong, _] = wrong(Kernel::Double, &scene, &rays);
    println!("double wrong in {:.2} % of the pixels", 100.0 * wrong);
    assert!(wrong > 0.002, "double wrong in {wrong} only");
}
