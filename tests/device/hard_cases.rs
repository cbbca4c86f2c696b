//! The hard cases: `certified` gets all of them right, to the last bit of `t`. Which ones the kernels get right that promise
//! nothing is written down, so that a change shows: hit or miss as it should be, and `t` within 1 ulp.

use std::fmt::Write as _;
use std::sync::Arc;

use kugelblitz::num::ulp_distance;
use kugelblitz::prepare::Prepared;
use kugelblitz::trace::{Hits, Kernel};
use kugelblitz_tests::hard_cases::{HardCase, hard_cases, hard_scene};
use kugelblitz_tests::{broken, gpu, runs, text_of, traced};

fn is_right(case: &HardCase, hits: &Hits, most_ulps: u64) -> bool {
    match case.t {
        None => hits.id[0] == 0,
        Some(t) => hits.id[0] == 1 && ulp_distance(hits.t[0], t) <= most_ulps,
    }
}

#[test]
fn certified_gets_all_hard_cases_right_and_others_the_written_ones() {
    let (gpu, mut found) = (gpu(), String::new());
    for case in hard_cases() {
        let (scene, rays) = hard_scene(&case);
        for on_gpu in [None, Some(&gpu)] {
            let hits = traced(&scene, Kernel::Certified, &rays, on_gpu);
            assert!(is_right(&case, &hits, 0), "{}: {hits:?}", case.name);
        }
        let mut right = Vec::new();
        for kernel in [Kernel::Lecture, Kernel::Stable, Kernel::Double] {
            let on_cpu = traced(&scene, kernel, &rays, None);
            if runs(kernel) {
                let prepared = Prepared::new(Arc::clone(&scene), kernel, &rays).unwrap();
                let on_gpu = traced(&scene, kernel, &rays, Some(&gpu));
                assert_eq!(broken(&prepared, &rays, &on_cpu, &on_gpu), None, "{}", case.name);
            }
            if is_right(&case, &on_cpu, 1) {
                right.push(kernel.name());
            }
        }
        let right = if right.is_empty() { "none".to_string() } else { right.join(" ") };
        let _ = writeln!(found, "{}: {right}", case.name);
    }
    let written = text_of("tests/data/plain_hard_cases.txt");
    assert!(found == written, "it has become\n{found}");
}
