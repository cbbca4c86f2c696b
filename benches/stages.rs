//! The stages of the kernel `certified`, one ray at a time: rays through figure 2 that f32, f64 or
//! exact arithmetic decides.

use std::sync::Arc;

use criterion::Throughput;
use kugelblitz::Control;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, StageCounts, WorldRay};
use kugelblitz::scene::Scene;
use kugelblitz::tracer::Tracer;
use kugelblitz::{Error, Result};

use kugelblitz_benches::{Candidate, compare, criterion, figure};

const N_RAYS: usize = 4096;

/// Traces `rays`, which the stage of `expected` must decide.
fn candidate<'a>(
    name: &str,
    scene: &Arc<Scene>,
    rays: &'a Rays,
    expected: StageCounts,
) -> Result<Candidate<'a>> {
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), Kernel::Certified, rays)?);
    let mut tracer = Tracer::on_cpu(prepared, Outputs::default());
    let mut hits = Hits::default();
    tracer.trace(rays, &Control::default(), &mut hits)?;
    if hits.counts != expected {
        return Err(Error::Comparison(format!("{name}: {:?}, not {expected:?}", hits.counts)));
    }
    let n_rays = Throughput::Elements(N_RAYS as u64);
    Ok(Candidate::new(name, n_rays, move || tracer.trace(rays, &Control::default(), &mut hits)))
}

fn main() -> Result<()> {
    let (scene, pixels) = figure("figure2.toml", [1280, 720])?;
    let twice: Vec<_> = scene.spheres.iter().flat_map(|&sphere| [sphere, sphere]).collect();
    let twice = Arc::new(Scene { spheres: twice.into(), ..scene.clone() });
    let scene = Arc::new(scene);

    // Rays at the middle of the large red sphere, all of them hits.
    let center = scene.spheres[2].center;
    let ray = |i: usize| {
        let at = pixels.xy(i);
        WorldRay { origin: pixels.view.position, direction: center + pixels.direction(at.0, at.1) }
    };
    let rays: Vec<WorldRay> = (0..N_RAYS).map(ray).collect();
    // So long a direction that the f32 stage leaves it alone.
    let long = |ray: &WorldRay| WorldRay { direction: ray.direction * 2f64.powi(40), ..*ray };
    let long = Rays::List(rays.iter().map(long).collect());
    let rays = Rays::List(rays);

    let n = N_RAYS as u64;
    let none = StageCounts::default();
    let f32 = candidate("f32", &scene, &rays, StageCounts { f32: n, ..none })?;
    let f64 = candidate("f64", &scene, &long, StageCounts { f64: n, ..none })?;
    // Each sphere twice: only exact arithmetic can tell that the two are equally near.
    let exact = candidate("exact", &twice, &rays, StageCounts { exact: n, ..none })?;
    let mut criterion = criterion();
    compare(&mut criterion, "stages of certified", f32, vec![f64, exact])?;
    criterion.final_summary();
    Ok(())
}
