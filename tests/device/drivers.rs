//! What a driver may do and what it may not: spoiled shaders stand in for drivers that contract,
//! reassociate, flush or round badly. Each is noticed by the self-test, or harmless by the proof of
//! `src/guard.rs`, and the kernels without a proof are within the bounds of Vulkan's precision where it keeps to that. That
//! the certified kernel sees the exact objects either way is the matrix's to say.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz::gpu::{Arithmetic, Gpu, Pick};
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::trace::{Kernel, Rays};
use kugelblitz_tests::allowed::{Outside, compare_to_allowed};
use kugelblitz_tests::{gpu, root, scene, sphere, spoiled, traced};

fn spoiled(spoil: impl Fn(&[u32]) -> Vec<u32> + Send + Sync + 'static) -> Arc<Gpu> {
    gpu();
    Arc::new(Gpu::open(&Pick::Best).unwrap().edit_spirv(spoil))
}

/// Scenes with a camera, and a far sphere that f32 leaves open at the outline.
fn scenes() -> Vec<(Arc<Scene>, Rays)> {
    let root = root().join("scenes");
    let named =
        ["figure1", "figure2", "figure5", "hard/touching", "hard/grazing", "hard/huge_ground"];
    let mut scenes: Vec<(Arc<Scene>, Rays)> = named
        .iter()
        .map(|name| {
            let scene = read_scene(&root.join(format!("{name}.toml"))).unwrap();
            let view = View::new(scene.camera.as_ref().unwrap());
            (Arc::new(scene), Rays::Pixels(Pixels::whole(view, 80, 45)))
        })
        .collect();
    let far = vec![sphere(dvec3(0.0, 3.0, -1e4), 1.0), sphere(dvec3(0.0, 3.0, -9e3), 0.9)];
    let mut view = View::new(&kugelblitz_tests::camera(DVec3::ZERO, DVec3::NEG_Z));
    view.h = 1e-3;
    scenes.push((Arc::new(scene(far, vec![])), Rays::Pixels(Pixels::whole(view, 80, 45))));
    scenes
}

/// What the plain kernels give outside the bounds of Vulkan's precision, and how many rays another `t` than
/// on the CPU.
fn plain(gpu: &Arc<Gpu>) -> (Outside, usize) {
    let (mut outside, mut n_otherwise) = (Outside::default(), 0);
    for (scene, rays) in scenes() {
        for kernel in [Kernel::Lecture, Kernel::Stable] {
            let prepared = Prepared::new(Arc::clone(&scene), kernel, &rays).unwrap();
            let on_gpu = traced(&scene, kernel, &rays, Some(gpu));
            let on_cpu = traced(&scene, kernel, &rays, None);
            let all: Vec<usize> = (0..rays.len()).collect();
            outside.add(&compare_to_allowed(&prepared, &rays, &on_gpu, &all).unwrap(), 0);
            n_otherwise += (0..rays.len()).filter(|&i| on_gpu.t[i] != on_cpu.t[i]).count();
        }
    }
    (outside, n_otherwise)
}

#[test]
fn this_driver_keeps_to_the_precision() {
    let gpu = gpu();
    let found = gpu.arithmetic().unwrap();
    assert!(found.suits_filter(), "{found}");
    let (outside, n_otherwise) = plain(&gpu);
    assert_eq!(outside.outside, 0, "{outside:?}");
    if found.is_ieee() {
        assert_eq!(n_otherwise, 0);
    }
    if let Some(found) = gpu.arithmetic_f64().unwrap() {
        let rounds_to_nearest =
            found.sum_ulp == 0 && found.product_ulp == 0 && found.rounded_products;
        assert!(found.suits_filter() && rounds_to_nearest && found.narrows_to_nearest, "{found}");
    }
}

/// Products that are fused with sums are within the proof, but are not the CPU's. The stand-in needs f64;
/// where there is none, a driver that has it shows this.
#[test]
fn a_driver_that_contracts_is_noticed_and_harmless() {
    if !gpu().facts.f64 {
        return;
    }
    let gpu = spoiled(spoiled::contracts);
    let found = gpu.arithmetic().unwrap();
    assert!(!found.rounded_products && !found.is_ieee() && found.suits_filter(), "{found}");
    let (outside, n_otherwise) = plain(&gpu);
    assert!(outside.outside == 0 && n_otherwise > 1000, "{outside:?}, {n_otherwise} otherwise");
}

#[test]
fn a_driver_that_reassociates_is_noticed() {
    let gpu = spoiled(spoiled::reassociates);
    let found = gpu.arithmetic().unwrap();
    assert!(!found.no_contraction && !found.suits_filter() && !found.is_ieee(), "{found}");
}

#[test]
fn a_driver_that_flushes_is_noticed_and_harmless() {
    let gpu = spoiled(spoiled::flushes);
    let found = gpu.arithmetic().unwrap();
    assert!(!found.subnormals && !found.is_ieee() && found.suits_filter(), "{found}");
    assert_eq!(plain(&gpu).0.outside, 0);
}

#[test]
fn a_driver_that_rounds_badly_is_noticed() {
    let gpu = spoiled(spoiled::rounds_sums_badly);
    let found = gpu.arithmetic().unwrap();
    assert!(found.sum_ulp > 0 && !found.faithful && !found.suits_filter(), "{found}");
    let (outside, n_otherwise) = plain(&gpu);
    assert!(outside.outside > 1000 && n_otherwise > 1000, "{outside:?}, {n_otherwise} otherwise");
}

#[test]
fn a_driver_that_rounds_quotients_as_it_may_is_harmless() {
    let gpu = spoiled(spoiled::rounds_quotients_as_allowed);
    let found: Arithmetic = gpu.arithmetic().unwrap();
    assert!(found.quotient_ulp > 0 && found.reciprocal_ulp > 0 && found.root_ulp > 0, "{found}");
    assert!(found.suits_filter() && !found.is_ieee(), "{found}");
    let (outside, n_otherwise) = plain(&gpu);
    assert!(outside.outside == 0 && n_otherwise > 1000, "{outside:?}, {n_otherwise} otherwise");
}
