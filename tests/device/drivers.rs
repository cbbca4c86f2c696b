//! What a driver may do and what it may not: spoiled shaders stand in for drivers that contract,
//! reassociate, flush or round badly. Each is noticed by the self-test, or harmless by the proof of
//! `src/bounds.rs`, and then the kernels without a proof show the lecture's figures all the same. That the certified kernel sees the exact objects either way is the matrix's to say.

use std::sync::Arc;

use kugelblitz::gpu::{Arithmetic, Gpu};
use kugelblitz::query::{Hits, Kernel, Rays};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::read_scene;
use kugelblitz_tests::{gpu, root, spoiled, traced};

fn spoiled(spoil: impl Fn(&[u32]) -> Vec<u32> + Send + Sync + 'static) -> Arc<Gpu> {
    gpu();
    Arc::new(Gpu::open("").unwrap().edit_spirv(spoil))
}

/// What the plain kernels see of the lecture's figures.
#[derive(Debug)]
struct Baseline {
    rays: usize,
    /// Rays with another `t` than on the CPU.
    otherwise: usize,
    /// Those that see another object, or whose `t` is off by more than 2⁻¹⁰ of it.
    apart: usize,
}

impl Baseline {
    fn on(gpu: &Arc<Gpu>) -> Baseline {
        let mut found = Baseline { rays: 0, otherwise: 0, apart: 0 };
        for name in ["figure1", "figure2", "figure5"] {
            let scene = read_scene(&root().join(format!("scenes/{name}.toml"))).unwrap();
            let view = View::new(scene.camera.as_ref().unwrap());
            let (scene, rays) = (Arc::new(scene), Rays::Pixels(Pixels::whole(view, 80, 45)));
            for kernel in [Kernel::Lecture, Kernel::Stable] {
                let [on_cpu, on_gpu] =
                    [None, Some(gpu)].map(|device| traced(&scene, kernel, &rays, device));
                found.compare(&on_cpu, &on_gpu);
            }
        }
        found
    }

    fn compare(&mut self, on_cpu: &Hits, on_gpu: &Hits) {
        self.rays += on_cpu.id.len();
        for (i, (cpu, gpu)) in on_cpu.t.iter().zip(&on_gpu.t).enumerate() {
            let is_near = cpu == gpu || (cpu - gpu).abs() <= cpu.abs() * 2f32.powi(-10);
            self.otherwise += usize::from(cpu != gpu);
            self.apart += usize::from(on_cpu.id[i] != on_gpu.id[i] || !is_near);
        }
    }

    /// Nothing but roundings differs, which shows near silhouettes alone.
    fn is_harmless(&self) -> bool {
        1000 * self.apart < self.rays
    }
}

#[test]
fn what_is_no_rounding_is_seen() {
    let n = 1000;
    let all = |id, t| Hits { id: vec![id; n], t: vec![t; n], ..Hits::default() };
    let right = all(1, 2.0);
    for (wrong, is_harmless) in [
        (right.clone(), true),
        (all(1, 2f32.next_up()), true),
        (all(2, 2.0), false),
        (all(1, 2.01), false),
        (all(1, f32::NAN), false),
        (all(0, f32::INFINITY), false),
    ] {
        let mut found = Baseline { rays: 0, otherwise: 0, apart: 0 };
        found.compare(&right, &wrong);
        assert_eq!(found.is_harmless(), is_harmless, "{found:?}");
        assert_eq!(found.otherwise == 0, wrong.t == right.t, "{found:?}");
    }
}

#[test]
fn this_driver_keeps_to_the_precision() {
    let gpu = gpu();
    let found = gpu.arithmetic().unwrap();
    assert!(found.suits_filter(), "{found}");
    let plain = Baseline::on(&gpu);
    assert!(plain.is_harmless() && (plain.otherwise == 0 || !found.is_ieee()), "{plain:?}");
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
    let plain = Baseline::on(&gpu);
    assert!(plain.is_harmless() && plain.otherwise > 500, "{plain:?}");
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
    assert!(Baseline::on(&gpu).is_harmless());
}

#[test]
fn a_driver_that_rounds_badly_is_noticed() {
    let gpu = spoiled(spoiled::rounds_sums_badly);
    let found = gpu.arithmetic().unwrap();
    assert!(found.sum_ulp > 0 && !found.faithful && !found.suits_filter(), "{found}");
    let plain = Baseline::on(&gpu);
    assert!(plain.otherwise > 500, "{plain:?}");
}

/// A card whose own quotients are rounded otherwise shows that by itself; the stand-in's errors would come on top of these.
#[test]
fn a_driver_that_rounds_quotients_as_it_may_is_harmless() {
    if gpu().arithmetic().unwrap().quotient_ulp > 0 {
        return;
    }
    let gpu = spoiled(spoiled::rounds_quotients_as_allowed);
    let found: Arithmetic = gpu.arithmetic().unwrap();
    assert!(found.quotient_ulp > 0 && found.reciprocal_ulp > 0 && found.root_ulp > 0, "{found}");
    assert!(found.suits_filter() && !found.is_ieee(), "{found}");
    let plain = Baseline::on(&gpu);
    assert!(plain.is_harmless() && plain.otherwise > 500, "{plain:?}");
}
