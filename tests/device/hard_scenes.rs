//! Which scenes of `scenes/hard` begin in f64. How wrong plain kernels are there stands in `tests/answers/scenes.txt`; that
//! every pixel of `certified` is right is the matrix's to say.

use std::sync::Arc;

use kugelblitz::control::Control;
use kugelblitz::num::OPEN;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::read_scene;
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::root;

/// The rays that are tried tell of all of them.
#[test]
fn scenes_whose_rays_f32_leaves_open_begin_in_f64() {
    let (control, mut hits) = (Control::default(), Hits::default());
    let mut in_f64 = Vec::new();
    let folder = root().join("scenes/hard");
    let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = files.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    for name in &names {
        let scene = Arc::new(read_scene(&folder.join(name)).unwrap());
        let view = View::new(scene.camera.as_ref().expect("a camera"));
        // Odd, so that the view axis is the ray of a pixel.
        let rays = Rays::Pixels(Pixels::whole(view, 161, 91));
        let prepared = Prepared::new(scene, Kernel::Certified, &rays).unwrap();
        let starts_in_f64 = prepared.starts_in_f64();
        let mut tracer = Tracer::on_cpu(Arc::new(prepared), Wants::default());
        tracer.propose(&rays, &control, &mut hits).unwrap();
        let n_open = hits.id.iter().filter(|&&id| id == OPEN).count();
        assert_eq!(starts_in_f64, 2 * n_open > rays.len(), "{name}: {n_open} open");
        tracer.trace(&rays, &control, &mut hits).unwrap();
        assert_eq!(starts_in_f64, hits.counts.f32 == 0, "{name}: {:?}", hits.counts);
        in_f64.extend(starts_in_f64.then_some(name.trim_end_matches(".toml")));
    }
    assert_eq!(in_f64, ["coincident_far", "distant_1e6", "inside_nested", "near_parallel"]);
}
