//! The kernels on the best Vulkan adapter, and the light of `certified` there, in software too; without one this fails.

use std::sync::Arc;

use criterion::{Criterion, Throughput};
use kugelblitz::Control;
use kugelblitz::device::Device;
use kugelblitz::gpu::Gpu;
use kugelblitz::lighting::certified_lighting;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays};
use kugelblitz::scene::{Samples, Scene};
use kugelblitz::{Error, Result, Session};

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
    let mut tracer = device.tracer(&prepared, Outputs::default())?.tracer;
    let mut hits = Hits::default();
    let n_rays = Throughput::Elements(rays.len() as u64);
    let work = move || tracer.trace(rays, &Control::default(), &mut hits);
    Ok(Candidate::new(kernel.name(), n_rays, work))
}

/// Lights a whole picture: what f32 tells of it on the device, beside all of it on the CPU.
fn compare_light(criterion: &mut Criterion) -> Result<()> {
    let gpu = Gpu::open("")?.always_lights();
    let (scene, pixels) = figure("lit/figure1.toml", [1920, 1080])?;
    let (scene, rays) = (Arc::new(scene), Rays::Pixels(pixels));
    let name = format!("light of figure 1 on {}", gpu.facts.name);
    let prepared = Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays)?);
    let mut tracer = Device::Gpu(Arc::new(gpu)).tracer(&prepared, Outputs::default())?.tracer;
    let n_pixels = Throughput::Elements(pixels.len() as u64);
    let lighting = certified_lighting(&prepared, &pixels, Samples::ONE)
        .ok_or_else(|| Error::Usage("f32 has no say in this light".into()))?;
    let there = Candidate::new("f32 on the device", n_pixels.clone(), move || {
        let device = tracer.backend().expect("a tracer on a device");
        device.light(&lighting, &pixels, &Control::default()).map(|codes| codes.map(<[u32]>::len))
    });
    let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
    let here = Candidate::new("all of it on the CPU", n_pixels, move || {
        session.colors::<[u8; 3]>(&pixels, Samples::ONE, &Control::default())
    });
    compare(criterion, &name, here, vec![there])
}

fn main() -> Result<()> {
    let gpu = Arc::new(Gpu::open("")?);
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
    compare_light(&mut criterion)?;
    criterion.final_summary();
    Ok(())
}
