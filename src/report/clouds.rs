//! Many spheres: what they take with `certified`, which finds those of a picture through a
//! hierarchy.

use std::sync::Arc;

use super::errors::Collector;
use super::measure::{IDS, SURFACE, Subject, run, spread};
use super::{CloudResult, Effort, Missing};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::generate::{Distribution, Recipe};
use crate::prepare::Prepared;
use crate::rays::{Pixels, View};
use crate::scene::Scene;
use crate::trace::{Hits, Kernel, Rays};
use crate::verify::{Truth, sample};

/// Size of the pictures, px.
pub const CLOUD_SIZE: [u32; 2] = [1920, 1080];

/// Rays that are compared with exact arithmetic, which looks at each sphere for each of them.
const SAMPLES: usize = 1 << 10;

/// Evenly in a cube, as `kugelblitz generate cloud` makes them.
fn recipe(count: u64) -> Recipe {
    Recipe { distribution: Distribution::Uniform, count, seed: 1 }
}

/// The other kernels test every ray against each sphere.
fn certified(subjects: &[Subject]) -> impl Iterator<Item = &Subject> {
    subjects.iter().filter(|subject| subject.kernel == Kernel::Certified)
}

/// Rays that [`measure_clouds`] traces or compares.
pub(super) fn n_rays(subjects: &[Subject], effort: &Effort) -> u64 {
    let [width, height] = CLOUD_SIZE.map(u64::from);
    let pictures = 1 + effort.rounds * (1 + effort.runs);
    let traced = width * height * (certified(subjects).count() * pictures) as u64;
    match traced {
        0 => 0,
        _ => effort.clouds.len() as u64 * (traced + effort.samples.min(SAMPLES) as u64),
    }
}

/// Each cloud on each device that traces with `certified`, and what did not fit.
///
/// # Errors
/// Those of tracing; [`Error::Interrupted`].
pub(super) fn measure_clouds(
    subjects: &[Subject],
    effort: &Effort,
    control: &Control,
) -> Result<(Vec<CloudResult>, Vec<Missing>)> {
    let (mut results, mut missing) = (Vec::new(), Vec::new());
    if certified(subjects).next().is_none() {
        return Ok((results, missing));
    }
    for &count in &effort.clouds {
        let scene = Arc::new(recipe(count).scene(control)?);
        let [width, height] = CLOUD_SIZE;
        let pixels = Pixels::whole(View::new(&recipe(count).camera()), width, height);
        let index = sample(pixels.len(), effort.samples.min(SAMPLES), effort.seed);
        let truth = Truth::of_pixels(&scene, &pixels, index, control)?;
        for subject in certified(subjects) {
            match measure_on(subject, &scene, &Rays::Pixels(pixels), &truth, effort, control) {
                Ok(result) => results.push(result),
                Err(Error::TooLarge(why)) => missing.push(Missing {
                    what: format!("{count} spheres on {}", subject.contestant.device),
                    why,
                }),
                Err(error) => return Err(error),
            }
        }
    }
    Ok((results, missing))
}

fn measure_on(
    subject: &Subject,
    scene: &Arc<Scene>,
    rays: &Rays,
    truth: &Truth,
    effort: &Effort,
    control: &Control,
) -> Result<CloudResult> {
    let (mut errors, mut hits) = (Collector::default(), Hits::default());
    let (mut builds, mut pictures) = (Vec::new(), Vec::new());
    for round in 0..effort.rounds {
        let prepared = Arc::new(Prepared::new(Arc::clone(scene), subject.kernel, rays)?);
        builds.push(prepared.build_time());
        if round == 0 {
            (subject.make)(&prepared, SURFACE)?.tracer.trace(rays, control, &mut hits)?;
            errors.add(&hits, truth);
        }
        let made = (subject.make)(&prepared, IDS)?;
        let runs = run(made, rays, effort.runs, control, &mut hits)?;
        pictures.extend(runs.timed.iter().map(|timing| timing.deciding() + timing.readback));
    }
    Ok(CloudResult {
        n_spheres: scene.spheres.len() as u64,
        contestant: subject.contestant.clone(),
        errors: errors.finish(),
        build_ms: spread(builds.into_iter(), 1e3).unwrap_or_default(),
        picture_ms: spread(pictures.into_iter(), 1e3).unwrap_or_default(),
    })
}
