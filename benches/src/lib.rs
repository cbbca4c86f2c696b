//! The parts that the benchmarks share.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::{Error, Result};
use kugelblitz_tests::root;

/// Pairs of samples that a ratio is taken of.
const N_PAIRS: usize = 20;

/// One way to do a piece of work.
pub struct Candidate<'a> {
    name: String,
    amount: Throughput,
    work: Box<dyn FnMut() -> Result<()> + 'a>,
    failure: Option<Error>,
}

impl<'a> Candidate<'a> {
    /// `work` does the `amount` of work that its time is told of.
    pub fn new<T>(
        name: impl Into<String>,
        amount: Throughput,
        mut work: impl FnMut() -> Result<T> + 'a,
    ) -> Candidate<'a> {
        let work = Box::new(move || work().map(|result| drop(black_box(result))));
        Candidate { name: name.into(), amount, work, failure: None }
    }

    fn run(&mut self) {
        if let Err(error) = (self.work)() {
            self.failure.get_or_insert(error);
        }
    }

    fn times(&mut self, n_runs: u64) -> Duration {
        let start = Instant::now();
        for _ in 0..n_runs {
            self.run();
        }
        start.elapsed()
    }

    /// Seconds of one run, from as many as `time` takes, and at least one.
    fn seconds_within(&mut self, time: Duration) -> f64 {
        let (start, mut n_runs) = (Instant::now(), 0);
        loop {
            self.run();
            n_runs += 1;
            let elapsed = start.elapsed();
            if elapsed >= time {
                return elapsed.as_secs_f64() / f64::from(n_runs);
            }
        }
    }

    /// Rays, pixels or bytes of one run.
    fn units(&self) -> f64 {
        match self.amount {
            Throughput::Elements(n) | Throughput::Bytes(n) => n as f64,
            _ => 1.0,
        }
    }
}

/// Criterion as the command line asks for it.
pub fn criterion() -> Criterion {
    Criterion::default()
        .sample_size(N_PAIRS)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5))
        .without_plots()
        .configure_from_args()
}

/// Measures the candidates and ends with their ratios to the baseline, for the same amount of work.
///
/// Each sample of a candidate is followed by one of the baseline that takes as long. So both see
/// the same machine, and their ratio holds even where other work makes all times long.
///
/// # Errors
/// The first one of a candidate.
pub fn compare(
    criterion: &mut Criterion,
    group_name: &str,
    mut baseline: Candidate,
    others: Vec<Candidate>,
) -> Result<()> {
    let mut group = criterion.benchmark_group(group_name);
    group.throughput(baseline.amount.clone());
    group.bench_function(BenchmarkId::from_parameter(&baseline.name), |bencher| {
        bencher.iter(|| baseline.run());
    });
    let mut lines = Vec::new();
    for mut other in others {
        let mut ratios = Vec::new();
        group.throughput(other.amount.clone());
        group.bench_function(BenchmarkId::from_parameter(&other.name), |bencher| {
            bencher.iter_custom(|n_runs| {
                let time = other.times(n_runs);
                let of_baseline = baseline.seconds_within(time) / baseline.units();
                let of_other = time.as_secs_f64() / n_runs as f64 / other.units();
                ratios.push(of_other / of_baseline);
                time
            });
        });
        other.failure.map_or(Ok(()), Err)?;
        lines.extend(line(&other.name, &ratios));
    }
    group.finish();
    baseline.failure.map_or(Ok(()), Err)?;
    if !lines.is_empty() {
        println!(
            "{group_name}: time for the same amount of work, in units of `{}`: median and middle \
             half of {N_PAIRS} pairs\n{}\n",
            baseline.name,
            lines.join("\n")
        );
    }
    Ok(())
}

/// The ratios that count: those before the last pairs were for warming up.
fn line(name: &str, ratios: &[f64]) -> Option<String> {
    let mut ratios = ratios.get(ratios.len().checked_sub(N_PAIRS)?..)?.to_vec();
    ratios.sort_by(f64::total_cmp);
    let at = |share: usize| ratios[(N_PAIRS - 1) * share / 4];
    Some(format!("  {name:<20} {:>7.3}  ({:.3} to {:.3})", at(2), at(1), at(3)))
}

/// A scene of the folder `scenes/`, and all its pixels at this size.
///
/// # Errors
/// Those of [`read_scene`].
pub fn figure(name: &str, [width, height]: [u32; 2]) -> Result<(Scene, Pixels)> {
    let path = root().join("scenes").join(name);
    let scene = read_scene(&path)?;
    let view = View::new(scene.require_camera(&path)?);
    Ok((scene, Pixels::whole(view, width, height)))
}
