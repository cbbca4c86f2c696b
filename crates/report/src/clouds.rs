//! Many spheres: what they take with `certified`, which finds those of a picture through a
//! hierarchy.

use std::sync::Arc;

use kugelblitz::control::Control;
use kugelblitz::generate::{Distribution, Recipe};
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Rays};
use kugelblitz::{Error, Result};
use kugelblitz_judge::verify::{Truth, sample};

use super::measure::{IDS, SURFACE, Work, ms, n_pixels, run};
use super::samples::Samples;
use super::{Benchmark, Metric, Missing, Of, Row};

/// Size of the pictures, px.
pub const CLOUD_SIZE: [u32; 2] = [1920, 1080];

/// Rays that are compared with exact arithmetic, which looks at each sphere for each of them.
const SAMPLES: usize = 1 << 10;

/// Spheres evenly in a cube, as `kugelblitz generate cloud` makes them, and a picture of all of it.
pub fn cloud(
    count: u64,
    seed: u64,
    [width, height]: [u32; 2],
    control: &Control,
) -> Result<(Arc<Scene>, Pixels)> {
    let recipe = Recipe { distribution: Distribution::Uniform, count, seed };
    let pixels = Pixels::whole(View::new(&recipe.camera()), width, height);
    Ok((Arc::new(recipe.scene(control)?), pixels))
}

impl<'a> Work<'a> {
    /// The other kernels test every ray against each sphere.
    fn certified(&self) -> impl Iterator<Item = &'a Benchmark> + use<'a> {
        self.benchmarks.iter().filter(|benchmark| benchmark.kernel == Kernel::Certified)
    }

    fn n_cloud_samples(&self) -> usize {
        self.settings.samples.min(SAMPLES)
    }

    /// Rays that [`Work::cloud_rows`] traces or compares.
    pub fn n_cloud_rays(&self) -> u64 {
        let pictures = 1 + self.settings.rounds * (1 + self.settings.runs);
        let traced = n_pixels(CLOUD_SIZE) * (self.certified().count() * pictures) as u64;
        let compared = if traced > 0 { self.n_cloud_samples() as u64 } else { 0 };
        self.settings.clouds.len() as u64 * (traced + compared)
    }

    /// Each cloud on each device that traces with `certified`, and what did not fit.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`].
    pub fn cloud_rows(&self, control: &Control) -> Result<(Vec<Row>, Vec<Missing>)> {
        let (mut rows, mut missing) = (Vec::new(), Vec::new());
        if self.certified().next().is_none() {
            return Ok((rows, missing));
        }
        for &spheres in &self.settings.clouds {
            let (scene, pixels) = cloud(spheres, 1, CLOUD_SIZE, control)?;
            let index = sample(pixels.len(), self.n_cloud_samples(), self.settings.seed);
            let truth = Truth::of_pixels(&scene, &pixels, index, control)?;
            for benchmark in self.certified() {
                match self.in_cloud(benchmark, &scene, &Rays::Pixels(pixels), &truth, control) {
                    Ok(samples) => {
                        rows.push(Row::new(Of::Cloud { spheres }, benchmark, &[&samples]));
                    }
                    Err(Error::TooLarge(why)) => {
                        let what = format!("{spheres} spheres on {}", benchmark.device);
                        missing.push(Missing { what, why });
                    }
                    Err(error) => return Err(error),
                }
            }
        }
        Ok((rows, missing))
    }

    fn in_cloud(
        &self,
        benchmark: &Benchmark,
        scene: &Arc<Scene>,
        rays: &Rays,
        truth: &Truth,
        control: &Control,
    ) -> Result<Samples> {
        let (mut samples, mut hits) = (Samples::default(), Hits::default());
        for round in 0..self.settings.rounds {
            let prepared = Arc::new(Prepared::new(Arc::clone(scene), benchmark.kernel, rays)?);
            samples.add(Metric::BuildMs, [ms(prepared.build_time())]);
            if round == 0 {
                (benchmark.make)(&prepared, SURFACE)?.tracer.trace(rays, control, &mut hits)?;
                samples.add_errors(&hits, truth);
            }
            let made = (benchmark.make)(&prepared, IDS)?;
            let runs = run(made, rays, self.settings.runs, control, &mut hits)?;
            let times = runs.timed.iter().map(|timing| ms(timing.deciding() + timing.readback));
            samples.add(Metric::PictureMs, times);
        }
        Ok(samples)
    }
}
