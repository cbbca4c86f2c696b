//! The kernels on the CPU.

use std::sync::Arc;

use criterion::{Criterion, Throughput};
use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::Scene;
use kugelblitz::tracer::Tracer;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use kugelblitz_benches::{Candidate, compare, criterion, figure};

/// Traces a whole picture, ids alone.
fn candidate<'a>(scene: &Arc<Scene>, kernel: Kernel, rays: &'a Rays) -> Result<Candidate<'a>> {
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), kernel, rays)?);
    let mut tracer = Tracer::on_cpu(prepared, Outputs::default());
    let mut hits = Hits::default();
    let n_rays = Throughput::Elements(rays.len() as u64);
    let work = move || tracer.trace(rays, &Control::default(), &mut hits);
    Ok(Candidate::new(kernel.name(), n_rays, work))
}

fn kernels(criterion: &mut Criterion, name: &str, scene: Scene, pixels: Pixels) -> Result<()> {
    let (scene, rays) = (Arc::new(scene), Rays::Pixels(pixels));
    let others = [Kernel::Lecture, Kernel::Double, Kernel::Certified];
    let others = others.map(|kernel| candidate(&scene, kernel, &rays));
    let others = others.into_iter().collect::<Result<_>>()?;
    compare(criterion, name, candidate(&scene, Kernel::Stable, &rays)?, others)
}

/// Small enough that a hundred spheres take a tenth of a second at most.
const SIZE: [u32; 2] = [640, 360];

/// A hundred spheres in view, seeded.
fn hundred_spheres() -> (Scene, Pixels) {
    let mut rng = ChaCha8Rng::seed_from_u64(100);
    let spheres = (0..100).map(|_| {
        let center = kugelblitz_tests::in_cube(&mut rng) * 8.0 + DVec3::NEG_Z * 24.0;
        kugelblitz_tests::sphere(center, rng.random_range(0.2..1.2))
    });
    let view = View::new(&kugelblitz_tests::camera(DVec3::ZERO, DVec3::NEG_Z));
    (kugelblitz_tests::scene(spheres.collect(), vec![]), Pixels::whole(view, SIZE[0], SIZE[1]))
}

fn main() -> Result<()> {
    let mut criterion = criterion();
    let (scene, pixels) = figure("figure2.toml", SIZE)?;
    kernels(&mut criterion, "figure 2 on the CPU", scene, pixels)?;
    let (scene, pixels) = hundred_spheres();
    kernels(&mut criterion, "100 spheres on the CPU", scene, pixels)?;
    criterion.final_summary();
    Ok(())
}
