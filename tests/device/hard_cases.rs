//! The hard cases through the kernels that promise nothing: which they get right is written down,
//! so that a change shows. Right means hit or miss as it should be, and `t` within 1 ulp.

use std::sync::Arc;

use kugelblitz::num::ulp_distance;
use kugelblitz::prepare::Prepared;
use kugelblitz::trace::{Hits, Kernel};
use kugelblitz_tests::hard_cases::{HardCase, hard_cases};
use kugelblitz_tests::hard_scene::hard_scene;
use kugelblitz_tests::judge::trace;
use kugelblitz_tests::{broken, gpu, runs};

fn is_right(case: &HardCase, hits: &Hits) -> bool {
    match case.t {
        None => hits.id[0] == 0,
        Some(t) => hits.id[0] == 1 && ulp_distance(hits.t[0], t) <= 1,
    }
}

#[test]
fn what_is_not_certified_gets_the_written_ones_right() {
    let (gpu, mut found) = (gpu(), Vec::new());
    for case in hard_cases() {
        let (scene, rays) = hard_scene(&case);
        let right = [Kernel::Lecture, Kernel::Stable, Kernel::Double].map(|kernel| {
            let on_cpu = trace(&scene, kernel, &rays, None);
            assert_eq!(on_cpu.t.len(), rays.len(), "{}", case.name);
            if runs(kernel) {
                let on_gpu = trace(&scene, kernel, &rays, Some(&gpu));
                assert_eq!(on_gpu.t.len(), rays.len(), "{}", case.name);
                let prepared = Prepared::new(Arc::clone(&scene), kernel, &rays).unwrap();
                let broken = broken(&prepared, &rays, &on_cpu, &on_gpu);
                assert_eq!(broken, None, "{}", case.name);
            }
            is_right(&case, &on_cpu)
        });
        found.push((case.name, right));
    }
    let line = |(name, [lecture, stable, double]): &(String, [bool; 3])| {
        format!("    ({name:?}, {lecture}, {stable}, {double}),")
    };
    let table: Vec<String> = found.iter().map(line).collect();
    let expected: Vec<(String, [bool; 3])> = RIGHT
        .iter()
        .map(|&(name, lecture, stable, double)| (name.to_string(), [lecture, stable, double]))
        .collect();
    assert!(found == expected, "the table has become\n{}", table.join("\n"));
}

/// Name, whether `lecture` is right, whether `stable` is, whether `double` is.
#[rustfmt::skip]
const RIGHT: [(&str, bool, bool, bool); 54] = [
    ("S01 tangent, integers (3,4,12) r=5", true, true, true),
    ("S02 as S01, r=pred(5): miss by 1 ulp", false, true, true),
    ("S03 as S01, r=succ(5): grazing hit", false, false, true),
    ("S04 tangent, non-unit d=(3,4,0)", true, true, true),
    ("S05 S04 scaled 2^-70 (r^2 underflows)", true, true, true),
    ("S06 S04 scaled 2^70 (r^2 overflows)", false, false, true),
    ("S07 RTG far unit sphere, L=4100", false, true, true),
    ("S08 L=1e6, aim p=0.999999 r", true, true, true),
    ("S09 L=1e6, aim p=1.000001 r", false, true, true),
    ("S10 f32-normalised (1,1,1) aimed at centre 1e4*(1,1,1)", false, true, true),
    ("S11 f32-normalised (1,2,3), L=3.7e4, r=1", false, true, true),
    ("S12 c-o not representable, true p=1-1e-8", false, false, true),
    ("S13 c-o not representable, true p=1+1e-8", false, false, true),
    ("S14 far from world origin 2^24, tangent", true, true, true),
    ("S15 d=(1,+1e-38,0): D=+2e-37 r^2", true, true, true),
    ("S16 d=(1,-1e-38,0): D=-2e-37 r^2", false, false, false),
    ("S17 origin = centre, d=(1,1,1)", true, true, true),
    ("S18 on surface (2,3,6), outward", true, true, true),
    ("S19 on surface (2,3,6), inward", true, true, true),
    ("S20 on surface (2,3,6), tangent d", true, true, true),
    ("S21 1 ulp outside, grazing inward", false, false, true),
    ("S22 1 ulp inside, d tangent", false, false, true),
    ("S23 Earth r=6371000, eye 1.7 m, straight down", false, false, true),
    ("S24 Earth, eye 1.7 m, near horizon", false, false, true),
    ("S25 Earth, eye 1.7 m, just above horizon", false, false, true),
    ("S26 sphere 1e20 as plane, down", false, false, false),
    ("S27 sphere 1e20 as plane, shallow", false, false, false),
    ("S28 overflow: c=3e19 r=1e19", false, false, true),
    ("S29 underflow: c=3e-23 r=1e-23", false, false, true),
    ("S30 subnormal scene c=3*2^-140 r=2^-140", false, false, true),
    ("S31 tiny direction 1e-30", false, true, true),
    ("S32 huge direction 3e38", false, true, true),
    ("S33 behind the ray", true, true, true),
    ("S34 zero direction", true, true, true),
    ("S35 r=0, ray through the point", false, false, false),
    ("S36 negative radius -1", true, true, true),
    ("P01 parallel exactly, integers", true, true, true),
    ("P02 parallel and in plane", true, true, true),
    ("P03 origin in plane, d.n!=0", true, true, true),
    ("P04 parallel only if products are rounded alike: n=(.1,.2,0) d=(.2,-.1,0)", true, true, true),
    ("P05 parallel by cancellation (1,1,1).(1,-(1-2^-24),-2^-24)", true, true, true),
    ("P06 d.n=+2^-48 only seen beyond 24 bits: n=(1+2^-23,1,0) d=(1-2^-24... )", true, true, true),
    ("P07 grazing: horizon ray, d_y=-1e-7", true, true, true),
    ("P08 far plane point, eye 1e-3 above: a=(1e7,1e7,1e7) n=(1,1,1)", true, true, true),
    ("P09 oblique, cancellation in (a-o).n", false, false, true),
    ("P10 non-unit n=1e-20", true, true, true),
    ("P11 non-unit n=1e20 and a=1e20 (overflow)", false, true, true),
    ("P12 n=2^-100,d=2^-60 (underflow)", false, true, true),
    ("P13 behind", true, true, true),
    ("P14 zero normal", true, true, true),
    ("P15 zero direction", true, true, true),
    ("P16 t overflows f32: d_y=-1e-39", true, true, true),
    ("P18 d.n=2^-60 hidden by order: n=(1,1,1) d=(1,2^-60,-1)", false, false, false),
    ("P17 world offset 2^24: a=o+(0,-1,0)", true, true, true),
];
