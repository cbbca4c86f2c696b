//! The hard cases: `certified` gets all of them right, to the last bit of `t`. Which ones the kernels get right that promise
//! nothing is written down, so that a change shows: hit or miss as it should be, and `t` within 1 ulp.

use std::fmt::Write as _;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::num::ulp_distance;
use kugelblitz::query::{Hits, Kernel, Rays, WorldRay};
use kugelblitz::scene::Scene;
use kugelblitz_tests::{broken, gpu, plane, runs, scene, sphere, text_of, traced};
use serde_json::Value;

/// One ray and one object of `tests/data/hardcases.json`, in f32 numbers (so in f64 as well).
struct HardCase {
    name: String,
    scene: Arc<Scene>,
    rays: Rays,
    /// The correctly rounded `t`; `None` for a miss.
    t: Option<f32>,
}

impl HardCase {
    fn new(case: &Value) -> HardCase {
        let number = |bits: &Value| {
            let text = bits.as_str().expect("a bit pattern in a string");
            let bits = u32::from_str_radix(text.trim_start_matches("0x"), 16);
            f32::from_bits(bits.expect("hexadecimal"))
        };
        let vector = |key: &str| DVec3::from([0, 1, 2].map(|i| f64::from(number(&case[key][i]))));
        let (spheres, planes) = match case["kind"].as_str() {
            Some("sphere") => (vec![sphere(vector("c"), number(&case["r"]).into())], vec![]),
            Some("plane") => (vec![], vec![plane(vector("a"), vector("n"))]),
            other => panic!("unknown kind {other:?}"),
        };
        HardCase {
            name: case["name"].as_str().expect("a name").to_owned(),
            scene: Arc::new(scene(spheres, planes)),
            rays: Rays::List(vec![WorldRay { origin: vector("o"), direction: vector("d") }]),
            t: case["hit"].as_bool().expect("hit or miss").then(|| number(&case["t_bits"])),
        }
    }

    fn is_right(&self, hits: &Hits, most_ulps: u64) -> bool {
        match self.t {
            None => hits.id[0] == 0,
            Some(t) => hits.id[0] == 1 && ulp_distance(hits.t[0], t) <= most_ulps,
        }
    }
}

#[test]
fn certified_gets_all_hard_cases_right_and_others_the_written_ones() {
    let (gpu, mut found) = (gpu(), String::new());
    let cases: Vec<Value> =
        serde_json::from_str(&text_of("tests/data/hardcases.json")).expect("JSON");
    assert_eq!(cases.len(), 54);
    for case in cases.iter().map(HardCase::new) {
        let HardCase { scene, rays, .. } = &case;
        for on_gpu in [None, Some(&gpu)] {
            let hits = traced(scene, Kernel::Certified, rays, on_gpu);
            assert!(case.is_right(&hits, 0), "{}: {hits:?}", case.name);
        }
        let mut right = Vec::new();
        for kernel in [Kernel::Lecture, Kernel::Stable, Kernel::Double] {
            let on_cpu = traced(scene, kernel, rays, None);
            if runs(kernel) {
                let on_gpu = traced(scene, kernel, rays, Some(&gpu));
                assert_eq!(broken(kernel, &on_cpu, &on_gpu), None, "{}", case.name);
            }
            if case.is_right(&on_cpu, 1) {
                right.push(kernel.name());
            }
        }
        let right = if right.is_empty() { "none".to_string() } else { right.join(" ") };
        let _ = writeln!(found, "{}: {right}", case.name);
    }
    let written = text_of("tests/data/plain_hard_cases.txt");
    assert!(found == written, "it has become\n{found}");
}
