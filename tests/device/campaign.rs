//! Random campaigns: rays where it is hard, all judged by exact arithmetic. Every id must be the
//! exact one, every `t` the nearest f32 of the exact one, and of every 16th ray each component of
//! the normal, too.
//!
//! Every run draws a fresh seed and prints it; `KUGELBLITZ_SEED=n` repeats one. The short campaign
//! runs with the other tests; the long one by
//! `KUGELBLITZ_RAYS=100000000 cargo test --profile ci -p kugelblitz-tests --test device -- --ignored --nocapture --exact campaign::long_campaign`.
//!
//! Every 64th batch is traced on the GPU as well.

use std::sync::Arc;
use std::time::{Duration, Instant};

use kugelblitz::gpu::Gpu;
use kugelblitz::trace::Kernel;
use kugelblitz_tests::cases;
use kugelblitz_tests::judge::{Tally, judge, trace};
use kugelblitz_tests::setups::{Batch, FAMILIES, SOURCES, batch};
use rayon::prelude::*;

/// One ray in so many has its normal looked at.
const NORMAL_STEP: usize = 16;

/// One batch in so many is traced on the GPU as well: a prime, so that it meets every family.
const GPU_STEP: u64 = 61;

/// Batches that run before the next word on progress.
const BATCHES_PER_ROUND: u64 = 4096;

/// Tallies by family and source.
type Tallies = Vec<[Tally; SOURCES.len()]>;

fn no_tallies() -> Tallies {
    vec![[Tally::default(); SOURCES.len()]; FAMILIES.len()]
}

fn add(mut a: Tallies, b: Tallies) -> Tallies {
    for (a, b) in a.iter_mut().flatten().zip(b.into_iter().flatten()) {
        a.add(b);
    }
    a
}

fn run_batch(seed: u64, index: u64, gpu: Option<&Arc<Gpu>>) -> Result<Tallies, String> {
    let Batch { family, source, scene, rays } = batch(seed, index);
    let scene = Arc::new(scene);
    let hits = trace(&scene, Kernel::Certified, &rays, gpu);
    let device = if gpu.is_some() { "GPU" } else { "CPU" };
    let tally = judge(&scene, &rays, &hits, NORMAL_STEP).map_err(|what| {
        let family = FAMILIES[family].0;
        format!("seed {seed}, batch {index} ({family}, {source:?}) on the {device}: {what}")
    })?;
    let mut tallies = no_tallies();
    tallies[family][source as usize] = tally;
    Ok(tallies)
}

fn total(tallies: &Tallies) -> Tally {
    let mut sum = Tally::default();
    tallies.iter().flatten().for_each(|&tally| sum.add(tally));
    sum
}

fn campaign(n_rays: u64) {
    let seed = cases::seed();
    println!("seed {seed}: KUGELBLITZ_SEED={seed} repeats this run");
    let start = Instant::now();
    let (mut on_cpu, mut on_gpu, mut gpu_time) = (no_tallies(), no_tallies(), Duration::ZERO);
    let gpu = kugelblitz_tests::gpu();
    let mut first = 0;
    // Whole turns through families and sources, so that none is left out.
    let turn = (FAMILIES.len() * SOURCES.len()) as u64;
    while total(&on_cpu).rays < n_rays || first % turn != 0 {
        let missing = n_rays.saturating_sub(total(&on_cpu).rays);
        let n = (missing.div_ceil(300).next_multiple_of(turn)).clamp(turn, BATCHES_PER_ROUND);
        let n = n / turn * turn;
        let round = first..first + n;
        let tallies = round
            .clone()
            .into_par_iter()
            .map(|index| run_batch(seed, index, None))
            .try_reduce(no_tallies, |a, b| Ok(add(a, b)));
        on_cpu = add(on_cpu, tallies.unwrap_or_else(|what| panic!("{what}")));
        let gpu_start = Instant::now();
        for index in round.filter(|index| index % GPU_STEP == 0) {
            let tallies = run_batch(seed, index, Some(&gpu));
            on_gpu = add(on_gpu, tallies.unwrap_or_else(|what| panic!("{what}")));
        }
        gpu_time += gpu_start.elapsed();
        first += n;
        let seconds = start.elapsed().as_secs_f64();
        println!("{first} batches, {} rays, {seconds:.1} s", total(&on_cpu).rays);
    }
    report(&on_cpu, start.elapsed() - gpu_time);
    let gpu_total = total(&on_gpu);
    println!("GPU: {gpu_total:?} in {:.1} s", gpu_time.as_secs_f64());
    check_not_vacuous(&on_cpu);
    assert!(gpu_total.rays > 0 && gpu_total.hits > 0, "the GPU traced nothing");
}

fn report(tallies: &Tallies, time: Duration) {
    println!(
        "{:<18}{:<13}{:>11}{:>11}{:>11}{:>11}{:>11}{:>9}",
        "family", "rays from", "rays", "hits", "f32", "f64", "exact", "normals"
    );
    let line = |family: &str, source: &str, tally: &Tally| {
        let Tally { rays, hits, normals, counts } = tally;
        println!(
            "{family:<18}{source:<13}{rays:>11}{hits:>11}{:>11}{:>11}{:>11}{normals:>9}",
            counts.f32, counts.f64, counts.exact
        );
    };
    for ((family, _), by_source) in FAMILIES.iter().zip(tallies) {
        for (source, tally) in SOURCES.iter().zip(by_source) {
            line(family, &format!("{source:?}"), tally);
        }
    }
    let sum = total(tallies);
    line("all", "", &sum);
    let per_second = sum.rays as f64 / time.as_secs_f64();
    println!("all right; {per_second:.0} rays a second, traced and judged");
}

fn check_not_vacuous(tallies: &Tallies) {
    let sum = total(tallies);
    let counts = sum.counts;
    let tenth = sum.rays / 10;
    assert!(sum.hits > tenth && sum.rays - sum.hits > tenth, "hits and misses: {sum:?}");
    // A share that a filter which decides nothing, or everything, could not keep.
    assert!(counts.f32 > tenth && counts.f64 > sum.rays / 100, "stages: {counts:?}");
    assert!(counts.exact > sum.rays / 1000, "stages: {counts:?}");
    assert!(sum.normals > sum.hits / 32, "normals: {sum:?}");
    for ((family, _), by_source) in FAMILIES.iter().zip(tallies) {
        for (source, tally) in SOURCES.iter().zip(by_source) {
            assert!(tally.rays > 0 && tally.hits > 0, "{family}, {source:?}: {tally:?}");
        }
    }
}

#[test]
fn short_campaign() {
    campaign(500_000);
}

#[test]
#[ignore = "minutes; the long campaign"]
fn long_campaign() {
    let rays = std::env::var("KUGELBLITZ_RAYS")
        .map_or(100_000_000, |text| text.parse().expect("KUGELBLITZ_RAYS is a number"));
    campaign(rays);
}
