//! The scenes of `scenes/hard`, which renderers in f32 get wrong; that every pixel is right here is the matrix's to say.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use kugelblitz::control::Control;
use kugelblitz::num::OPEN;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::{root, traced};

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
    let [hits, truth] = [kernel, Kernel::Certified].map(|kernel| traced(scene, kernel, rays, None));
    let is_wrong = |i: &usize| hits.id[*i] != truth.id[*i];
    let is_far = |i: &usize| {
        let off = f64::from(hits.t[*i]) / f64::from(truth.t[*i]) - 1.0;
        truth.id[*i] != 0 && off.abs() > 2f64.powi(-20)
    };
    let share = |n: usize| n as f64 / rays.len() as f64;
    let all = || 0..rays.len();
    let n_off = all().filter(|i| is_wrong(i) || is_far(i)).count();
    [share(all().filter(is_wrong).count()), share(n_off)]
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
fn all_but_the_hidden_objects_are_in_their_pictures() {
    for (name, hidden, _) in SCENES {
        let (scene, rays) = scene(name);
        let ids = traced(&scene, Kernel::Certified, &rays, None).id;
        for id in 1..=scene.n_objects() as u32 {
            assert_eq!(ids.contains(&id), !hidden.contains(&id), "{name}: {id} in the picture");
        }
    }
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
        let mut tracer = Tracer::on_cpu(Arc::new(prepared), Wants::default());
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
