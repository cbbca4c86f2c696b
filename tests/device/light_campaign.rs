//! Random campaigns of light: lit pictures where it is hard, judged by the oracle of light and colour.
//! Every id, byte and float must be the exact one.
//!
//! Every run draws a fresh seed and prints it; `KUGELBLITZ_SEED=n` repeats one. The short campaign
//! runs with the other tests; the long one by
//! `KUGELBLITZ_SAMPLES=10000000 cargo test --profile ci -p kugelblitz-tests --test device -- --ignored --nocapture --exact light_campaign::long_campaign`.
//! Of each picture, all pixels that a light is aimed at are judged, and a share of the others: a third in
//! the short campaign, one in 29 in the long one. Every 17th picture is painted of what the GPU
//! sees as well.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use kugelblitz::device::Device;
use kugelblitz::gpu::{Gpu, Pick};
use kugelblitz_tests::cases;
use kugelblitz_tests::light_cases::light_case;
use kugelblitz_tests::light_judge::{Tally, judge};
use kugelblitz_tests::setups::FAMILIES;
use rayon::prelude::*;

/// One picture in so many is painted of what the GPU sees as well: a prime, so that it meets every family.
const GPU_STEP: u64 = 17;

/// Pictures before the next word on progress: whole turns through the families and both lenses.
const PICTURES_PER_ROUND: u64 = 2 * FAMILIES.len() as u64 * 8;

type Tallies = BTreeMap<&'static str, Tally>;

fn add(mut a: Tallies, b: Tallies) -> Tallies {
    for (family, tally) in b {
        a.entry(family).or_default().add(tally);
    }
    a
}

fn total(tallies: &Tallies) -> Tally {
    let mut sum = Tally::default();
    tallies.values().for_each(|&tally| sum.add(tally));
    sum
}

/// The samples of a picture, and what was judged of it.
fn run(seed: u64, index: u64, device: &Device, step: usize) -> Result<(u64, Tallies), String> {
    let (family, case) = light_case(seed, index);
    let judged = judge(&case, &case.paint(device), step);
    let tally = judged.map_err(|what| {
        let on = device.kind();
        format!("seed {seed}, case {index} ({family}) on the {on}: {what}")
    })?;
    let n_samples = case.pixels.len() as u64 * u64::from(case.n_samples).pow(2);
    Ok((n_samples, Tallies::from([(family, tally)])))
}

/// Judges one pixel in `step`, and all that are aimed at.
fn campaign(n_samples: u64, step: usize) {
    let seed = cases::seed();
    println!("seed {seed}: KUGELBLITZ_SEED={seed} repeats this run");
    let start = Instant::now();
    let gpu = Gpu::open(&Pick::Best).unwrap();
    let gpu = Device::Gpu(Arc::new(gpu));
    let (mut samples, mut tallies, mut on_gpu) = (0, Tallies::new(), Tallies::new());
    for first in (0..).step_by(PICTURES_PER_ROUND as usize) {
        let round = first..first + PICTURES_PER_ROUND;
        let none = || (0, Tallies::new());
        let of_round = round
            .clone()
            .into_par_iter()
            .map(|index| run(seed, index, &Device::Cpu, step))
            .try_reduce(none, |a, b| Ok((a.0 + b.0, add(a.1, b.1))));
        let (n, of_round) = of_round.unwrap_or_else(|what| panic!("{what}"));
        (samples, tallies) = (samples + n, add(tallies, of_round));
        for index in round.filter(|index| index % GPU_STEP == 0) {
            let (_, tally) = run(seed, index, &gpu, step).unwrap_or_else(|what| panic!("{what}"));
            on_gpu = add(on_gpu, tally);
        }
        let seconds = start.elapsed().as_secs_f64();
        println!("{samples} samples, {} judged, {seconds:.1} s", total(&tallies).samples);
        if samples >= n_samples {
            break;
        }
    }
    report(&tallies);
    println!("GPU: {:?}", total(&on_gpu));
    check_not_vacuous(&tallies);
    let Tally { lit, on_device, .. } = total(&on_gpu);
    // The CPU finds all colours of what a proof is for.
    assert!(lit > 0 && on_device == 0, "the GPU: {lit} lit, {on_device} coloured");
}

fn report(tallies: &Tallies) {
    let rows = tallies.iter().map(|(family, tally)| (*family, *tally));
    println!(
        "{:<18}{:>10}{:>10}{:>10}{:>10}{:>9}{:>7}{:>11}{:>9}{:>9}",
        "family", "pixels", "samples", "hits", "lit", "hard", "ties", "f32", "f64", "exact"
    );
    for (family, tally) in rows.chain([("all", total(tallies))]) {
        let Tally { pixels, samples, hits, lit, hard, ties, shadow_rays, .. } = tally;
        println!(
            "{family:<18}{pixels:>10}{samples:>10}{hits:>10}{lit:>10}{hard:>9}{ties:>7}{:>11}{:>9}{:>9}",
            shadow_rays.f32, shadow_rays.f64, shadow_rays.exact
        );
    }
}

fn check_not_vacuous(tallies: &Tallies) {
    let Tally { pixels, hits, lit, hard, .. } = total(tallies);
    assert!(hits > pixels / 4 && lit > hits / 4 && lit < hits * 19 / 20, "{tallies:?}");
    assert!(hard > pixels / 1000, "{hard} hard pixels of {pixels}");
    for (family, _) in FAMILIES {
        let tally = tallies[family];
        assert!(tally.hits > 0 && tally.lit > 0, "{family}: {tally:?}");
    }
}

#[test]
fn short_campaign() {
    campaign(20_000, 3);
}

#[test]
#[ignore = "minutes; the long campaign"]
fn long_campaign() {
    let samples = std::env::var("KUGELBLITZ_SAMPLES")
        .map_or(10_000_000, |text| text.parse().expect("KUGELBLITZ_SAMPLES is a number"));
    campaign(samples, 29);
}
