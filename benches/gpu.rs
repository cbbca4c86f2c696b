//! The kernels on the best Vulkan adapter; without one this fails.

use std::sync::Arc;

use criterion::Throughput;
use kugelblitz::Result;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::gpu::{Gpu, Pick};
use kugelblitz::prepare::Prepared;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};

use kugelblitz_benches::{Candidate, compare, criterion, figure};

/// Traces a whole picture, ids alone.
fn candidate<'a>(
    gpu: &Arc<Gpu>,
    scene: &Arc<Scene>,
    kernel: Kernel,
    rays: &'a Rays,
) -> Result<Candidate<'a>> {
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), kernel, rays)?);
    let device = Device::Gpu(Arc::clone(gpu));
    let mut tracer = device.tracer(&prepared, Wants::default())?.tracer;
    let mut hits = Hits::default();
    let n_rays = Throughput::Elements(rays.len() as u64);
    let work = move || tracer.trace(rays, &Control::default(), &mut hits);
    Ok(Candidate::new(kernel.name(), n_rays, work))
}

fn main() -> Result<()> {
    let gpu = Arc::new(Gpu::open(&Pick::Best)?);
    let (scene, pixels) = figure("figure2.toml", [1280, 720])?;
    let (scene, rays) = (Arc::new(scene), Rays::Pixels(pixels));
    let mut others = Vec::new();
    for kernel in [Kernel::Lecture, Kernel::Double, Kernel::Certified] {
        match gpu.facts.check_kernel(kernel) {
            Ok(()) => others.push(candidate(&gpu, &scene, kernel, &rays)?),
            Err(reason) => println!("left out: {reason}"),
        }
    }
    let baseline = candidate(&gpu, &scene, Kernel::Stable, &rays)?;
    let mut criterion = criterion();
    compare(&mut criterion, &format!("figure 2 on {}", gpu.facts.name), baseline, others)?;
    criterion.final_summary();
    Ok(())
}
