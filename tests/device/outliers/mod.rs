//! Outliers: one object, ray or lamp of any scale and place must not cost a scene.
//!
//! Each pair is an ordinary scene and the same scene with one outlier that changes few pixels. The counts of undecided work of
//! the second may exceed the counts of the first by a factor and a small share of all rays, see [`WorkCount::ratio`]. The costs of a device
//! are counted on its twins, so that no test here opens one.
//!
//! `KUGELBLITZ_PAIR=123` runs the pair with this number alone and prints its costs; `KUGELBLITZ_PAIRS=1000` runs so many pairs,
//! from this number or from 0.

mod pairs;

use std::fmt::{self, Write};
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::lighting::{Encoding, Style, certified_lighting};
use kugelblitz::num::UNDECIDED;
use kugelblitz::prepare::{LengthUnit, Prepared};
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, StageCounts};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::Samples;
use kugelblitz_tests::twins::{Twin, light_alone};
use rand::SeedableRng;
use rayon::prelude::*;

use pairs::{KINDS, Rng, Workload, kind, pair, room};

/// A kind that may exceed the limits of some counts.
struct Exception {
    kind: &'static str,
    counts: &'static [&'static str],
    /// Limit of [`WorkCount::ratio`] for these counts, instead of 1.
    max_ratio: f64,
    reason: &'static str,
}

const ALL: &[&str] = &[
    "rays after f32",
    "exact rays",
    "shadows after f32",
    "exact shadows",
    "device rays",
    "device boxes",
    "device pixels",
];

/// Kinds that cannot be mended.
const EXCEPTIONS: &[Exception] = &[
    Exception {
        kind: "huge sphere as ground",
        counts: &["rays after f32", "shadows after f32", "device rays", "device pixels"],
        max_ratio: 16.0,
        reason: "the rows of pixels at the horizon, at most 2 of 24, see points so far away that their errors matter; and of a level \
                 parallel picture, which sees the ground far away only, 4 of 24",
    },
    Exception {
        kind: "far lamp",
        counts: &["shadows after f32", "device pixels"],
        max_ratio: 8.4,
        reason: "on the rows of pixels at the horizon, at most 2 of 24, the cosine to a point depends on the error of the distance, \
                 and to a sun it does not",
    },
    Exception {
        kind: "lamp on a sphere",
        counts: &["shadows after f32", "device pixels"],
        max_ratio: 8.4,
        reason: "the rows of pixels at the horizon, at most 2 of 24, are as high as a lamp on top of a sphere",
    },
    Exception {
        kind: "sphere around everything",
        counts: &["shadows after f32"],
        max_ratio: 50.0,
        reason: "all of the background is on the outlier, where points are known less well than light asks for",
    },
    Exception {
        kind: "far plane in view",
        counts: &["shadows after f32", "device pixels"],
        max_ratio: 100.0,
        reason: "all of the background is on the outlier, where points are known less well than light asks for",
    },
    Exception {
        kind: "farther sphere out of view",
        counts: &["shadows after f32", "device pixels"],
        max_ratio: f64::INFINITY,
        reason: "f32 squares lengths up to 2^50: shadow rays past a sphere farther away are undecided, up to 2^63, from where on \
                 no shadow ray reaches it",
    },
    Exception {
        kind: "far sphere in view",
        counts: &["rays after f32", "device rays", "device pixels"],
        max_ratio: 100.0,
        reason: "parallel rays know the place of a sphere across to an error that grows with its distance along, which covers the \
                 picture",
    },
    Exception {
        kind: "farther sphere in view",
        counts: &[
            "rays after f32",
            "exact rays",
            "shadows after f32",
            "device rays",
            "device pixels",
        ],
        max_ratio: f64::INFINITY,
        reason: "as for far spheres in view, and for farther ones out of view; beyond 2^60 f32 has lower bounds of t only",
    },
    Exception {
        kind: "larger sphere as ground",
        counts: ALL,
        max_ratio: f64::INFINITY,
        reason: "parallel rays move k, whose error grows with the radius; beyond 2^60 f32 has lower bounds of t only; and points on \
                 the ground are known less well than light asks for",
    },
    Exception {
        kind: "larger sphere around everything",
        counts: ALL,
        max_ratio: f64::INFINITY,
        reason: "all of the background is on the outlier, where points are known less well than light asks for; beyond 2^60 f32 \
                 has lower bounds of t only",
    },
    Exception {
        kind: "farther plane out of view",
        counts: ALL,
        max_ratio: f64::INFINITY,
        reason: "beyond 2^60 f32 says nothing of planes, as their offset from any point is open",
    },
    Exception {
        kind: "farther plane in view",
        counts: ALL,
        max_ratio: f64::INFINITY,
        reason: "all of the background is on the outlier, where points are known less well than light asks for; beyond 2^60 f32 says \
                 nothing of planes",
    },
    Exception {
        kind: "farther lamp",
        counts: &["shadows after f32", "device pixels"],
        max_ratio: f64::INFINITY,
        reason: "f32 squares lengths up to 2^50, so that f64 finds the way to a lamp beyond; a sun in its place costs nothing",
    },
    Exception {
        kind: "scaled by 10^-15..10^20",
        counts: &["rays after f32"],
        max_ratio: 16.0,
        reason: "t from 2^66 on is left to f64, and so are the rays that see the farthest spheres",
    },
    Exception {
        kind: "lamp on the ceiling",
        counts: &["shadows after f32", "device pixels"],
        max_ratio: 4.2,
        reason: "the row of pixels at the horizon, one of 24, is as high as the ceiling for parallel rays",
    },
    Exception {
        kind: "scaled by 2^-300..2^300",
        counts: ALL,
        max_ratio: f64::INFINITY,
        reason: "above 2^60, a unit would take t out of the range of f32",
    },
];

/// Number of pairs in each run of the tests.
const N_PAIRS: u64 = 232;

#[test]
fn an_outlier_costs_little() {
    let number = |name| std::env::var(name).ok().map(|text| text.parse::<u64>().expect("a number"));
    let first = number("KUGELBLITZ_PAIR");
    let n = number("KUGELBLITZ_PAIRS").unwrap_or(if first.is_some() { 1 } else { N_PAIRS });
    let numbers = first.unwrap_or(0)..first.unwrap_or(0) + n;
    let results: Vec<Comparison> = numbers.into_par_iter().map(Comparison::new).collect();
    if let [result] = &results[..] {
        let outlier = |case: Workload| case.outlier();
        println!("{result}{}", pair(result.number).map(outlier).join("with:\n"));
    }
    println!("{}", table(&results));
    let failed: Vec<&Comparison> = results.iter().filter(|result| result.is_over()).collect();
    failed.iter().take(20).for_each(|result| println!("{result}"));
    assert!(failed.is_empty(), "{} of {n} pairs are over the limit", failed.len());
}

/// Two floors that differ by less than the rounding errors leave every ray on them undecided.
#[test]
fn an_outlier_that_costs_a_scene_is_noticed() {
    let ordinary = Workload { n_samples: Samples::ONE, ..room(&mut Rng::seed_from_u64(1)) };
    let sabotaged = ordinary.with_plane(DVec3::Y * 1e-20, DVec3::Y);
    let comparison = Comparison { number: 0, counts: [&ordinary, &sabotaged].map(work_counts) };
    assert!(comparison.is_over(), "{comparison}");
    let ordinary = work_counts(&ordinary);
    for (index, WorkCount { n, slack, .. }) in ordinary.iter().enumerate() {
        for (excess, is_over) in [(0, false), (1, true)] {
            let mut with = ordinary.clone();
            with[index].n = 3 * n + *slack as u64 + excess;
            let comparison = Comparison { number: 0, counts: [ordinary.clone(), with] };
            assert_eq!(comparison.is_over(), is_over, "{comparison}");
        }
    }
}

/// A count of work.
#[derive(Clone)]
struct WorkCount {
    name: &'static str,
    n: u64,
    /// Increase that is always allowed.
    slack: f64,
}

impl WorkCount {
    /// Returns the ratio of a count to its limit, given the count of the ordinary scene.
    fn ratio(&self, ordinary: &WorkCount) -> f64 {
        self.n as f64 / (3.0 * ordinary.n as f64 + self.slack)
    }
}

/// The counts of both cases of a pair.
struct Comparison {
    number: u64,
    counts: [Vec<WorkCount>; 2],
}

impl Comparison {
    fn new(number: u64) -> Comparison {
        Comparison { number, counts: pair(number).each_ref().map(work_counts) }
    }

    fn kind(&self) -> &'static str {
        kind(self.number).0
    }

    fn ratios(&self) -> Vec<f64> {
        let [ordinary, with] = &self.counts;
        with.iter().zip(ordinary).map(|(with, ordinary)| with.ratio(ordinary)).collect()
    }

    fn worst(&self) -> f64 {
        self.ratios().into_iter().fold(0.0, f64::max)
    }

    fn is_over(&self) -> bool {
        let max_ratio = |count: &WorkCount| {
            let is_for = |e: &&Exception| e.kind == self.kind() && e.counts.contains(&count.name);
            EXCEPTIONS.iter().find(is_for).map_or(1.0, |exception| exception.max_ratio)
        };
        self.ratios().iter().zip(&self.counts[0]).any(|(ratio, count)| *ratio > max_ratio(count))
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "KUGELBLITZ_PAIR={} ({}):", self.number, self.kind())?;
        let [ordinary, with] = &self.counts;
        for ((ordinary, with), ratio) in ordinary.iter().zip(with).zip(self.ratios()) {
            writeln!(f, "{:>18} {:>8} -> {:>8} {ratio:>8.2}", with.name, ordinary.n, with.n)?;
        }
        Ok(())
    }
}

/// Formats the largest ratio of each count by kind, and the pair with the largest of all.
fn table(results: &[Comparison]) -> String {
    let names = results[0].counts[0].iter().map(|count| format!("{:>18}", count.name));
    let names: String = names.collect();
    let mut text =
        format!("{:<30}{:>6}{:>6}{names}{:>12}\n", "kind", "pairs", "over", "worst pair");
    for (kind, _) in KINDS {
        let of_kind: Vec<_> = results.iter().filter(|result| result.kind() == kind).collect();
        let n_over = of_kind.iter().filter(|result| result.is_over()).count();
        let by_ratio = |a: &&&Comparison, b: &&&Comparison| a.worst().total_cmp(&b.worst());
        let Some(worst) = of_kind.iter().max_by(by_ratio) else { continue };
        write!(text, "{kind:<30}{:>6}{n_over:>6}", of_kind.len()).unwrap();
        for index in 0..worst.counts[0].len() {
            let ratios = of_kind.iter().map(|result| result.ratios()[index]);
            write!(text, "{:>18.2}", ratios.fold(0.0, f64::max)).unwrap();
        }
        writeln!(text, "{:>12}", worst.number).unwrap();
    }
    for Exception { kind, counts, max_ratio, reason } in EXCEPTIONS {
        let counts = counts.join(", ");
        writeln!(text, "allowed: {kind}, {counts}, up to {max_ratio}: {reason}").unwrap();
    }
    text
}

/// Counts the work that a case takes. On the CPU: rays and shadow rays that f32 leaves undecided, and how many need exact
/// arithmetic. On a device: rays and lit pixels that it leaves undecided, and the boxes that it visits.
fn work_counts(case: &Workload) -> Vec<WorkCount> {
    let [counts, shadow_rays] = stage_counts(case);
    // As a session traces them.
    let unit = LengthUnit::of(&case.scene);
    let in_unit = unit.scene(&case.scene).zip(unit.rays(&case.rays()));
    let (scene, rays) = in_unit.unwrap_or_else(|| (Arc::new(case.scene.clone()), case.rays()));
    let of_samples = match &rays {
        Rays::Pixels(pixels) => Rays::Pixels(pixels.samples(case.n_samples.across())),
        Rays::List(_) => rays.clone(),
    };
    let prepared = Prepared::new(scene, Kernel::Certified, &of_samples).unwrap().in_unit(unit);
    let [undecided, n_boxes] = counts_on_device(&prepared, &of_samples);
    let of_pixels = |pixels| undecided_pixels_on_device(&prepared, pixels, case.n_samples);
    let undecided_pixels = rays.pixels().map_or(0, of_pixels);
    let [n_traced, n_samples, n_rays] =
        [counts.total(), of_samples.len() as u64, rays.len() as u64].map(|n| n as f64);
    [
        ("rays after f32", counts.f64 + counts.exact, 0.01 * n_traced),
        ("exact rays", counts.exact, 0.01 * n_traced),
        ("shadows after f32", shadow_rays.f64 + shadow_rays.exact, 0.01 * n_samples),
        ("exact shadows", shadow_rays.exact, 0.01 * n_samples),
        ("device rays", undecided, 0.01 * n_samples),
        ("device boxes", n_boxes, 2.0 * n_samples),
        ("device pixels", undecided_pixels, 0.01 * n_rays),
    ]
    .map(|(name, n, slack)| WorkCount { name, n, slack })
    .to_vec()
}

/// Returns the stages that decided rays, and shadow rays.
fn stage_counts(case: &Workload) -> [StageCounts; 2] {
    let mut session = Session::new(case.scene.clone(), Device::Cpu, Kernel::Certified);
    let (wants, control) = (Outputs::default(), Control::default());
    match case.rays() {
        Rays::Pixels(pixels) => {
            let style = Style { n_samples: case.n_samples, ..Style::new(Encoding::Srgb8) };
            let (_, stats) = session.keep(&pixels, style, wants, &control).unwrap();
            [stats.counts, stats.shadow_rays]
        }
        rays @ Rays::List(_) => {
            let mut hits = Hits::default();
            session.trace(&rays, wants, &control, &mut hits).unwrap();
            [hits.counts, StageCounts::default()]
        }
    }
}

/// Counts the rays that a device leaves undecided, and the boxes that it visits. A device that cannot trace the scene leaves all
/// rays undecided.
fn counts_on_device(prepared: &Prepared, rays: &Rays) -> [u64; 2] {
    let twin = Twin::new(prepared).filter(|_| !prepared.starts_in_f64());
    let Some(twin) = twin else { return [rays.len() as u64, 0] };
    let count = |index| {
        let ray = twin.ray(rays, index);
        [u64::from(twin.decide(&ray) == UNDECIDED), u64::from(twin.n_boxes(&ray))]
    };
    (0..rays.len()).map(count).fold([0, 0], |[a, b], [x, y]| [a + x, b + y])
}

/// Counts the lit pixels whose color a device leaves undecided: all if it cannot light the scene.
fn undecided_pixels_on_device(prepared: &Prepared, pixels: &Pixels, n_samples: Samples) -> u64 {
    if !prepared.scene.is_lit() {
        return 0;
    }
    match certified_lighting(prepared, pixels, n_samples) {
        Some(lighting) if Twin::new(prepared).is_some() => {
            let codes = light_alone(prepared, &lighting, pixels);
            codes.iter().filter(|&&code| code == UNDECIDED).count() as u64
        }
        _ => pixels.len() as u64,
    }
}
