//! The most that a device does in a second, for those who want to know what bounds a kernel.

use std::time::{Duration, Instant};

use super::clock::Clock;
use super::compile::{Shader, compile_ceilings};
use super::device::OpenDevice;
use super::pipeline::{Bindings, pipeline};
use crate::error::{Error, Result};

/// Rates that shaders reach on a device. Each is the best of several runs.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Ceilings {
    /// Bytes read and written by a copy from buffer to buffer, 10⁹ a second.
    pub copy_gb_per_s: f64,
    /// f32 operations of `fma`, two each, 10⁹ a second.
    pub f32_gflop_per_s: f64,
    /// The same in f64; `None` where shaders have none.
    pub f64_gflop_per_s: Option<f64>,
}

/// Bytes of each of the two buffers, at most.
const BUFFER_BYTES: u64 = 256 << 20;

/// `vec4u` of the shader.
const ELEMENT_BYTES: u64 = 16;

/// Invocations of a workgroup, as the shader says.
const WORKGROUP: u64 = 64;

/// Workgroups of the arithmetic: more than any device runs at once.
const ARITHMETIC_GROUPS: u64 = 1 << 14;

/// Steps of an invocation; each has [`CHAINS`] products with sums.
const STEPS: u64 = 256;

const CHAINS: u64 = 8;

/// A run shorter than this measures how a run begins.
const LONG_ENOUGH: Duration = Duration::from_millis(30);

/// Runs that are measured once they are long enough.
const RUNS: usize = 5;

/// A device that takes longer than this for a run is not usable.
const TIMEOUT: Duration = Duration::from_secs(60);

impl Ceilings {
    /// Measures a device, in some seconds.
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails, [`Error::Shader`] when it refuses a shader.
    pub fn measure(gpu: &OpenDevice) -> Result<Ceilings> {
        let mut runs = Runs::new(gpu)?;
        let f32 = compile_ceilings("f32", STEPS)?;
        let n_bytes = 2 * runs.n_elements * ELEMENT_BYTES;
        let copy_gb_per_s = runs.rate(&f32, "copy", runs.n_elements, n_bytes)?;
        let n_invocations = runs.n_elements.min(ARITHMETIC_GROUPS * WORKGROUP);
        let n_operations = 2 * CHAINS * STEPS * n_invocations;
        let mut arithmetic =
            |shader: &Shader| runs.rate(shader, "multiply_add", n_invocations, n_operations);
        Ok(Ceilings {
            copy_gb_per_s,
            f32_gflop_per_s: arithmetic(&f32)?,
            f64_gflop_per_s: match gpu.facts.f64 {
                true => Some(arithmetic(&compile_ceilings("f64", STEPS)?)?),
                false => None,
            },
        })
    }
}

/// What all runs share.
struct Runs<'a> {
    gpu: &'a OpenDevice,
    clock: Option<Clock>,
    input: wgpu::Buffer,
    output: wgpu::Buffer,
    /// Elements of each buffer.
    n_elements: u64,
}

impl Runs<'_> {
    fn new(gpu: &OpenDevice) -> Result<Runs<'_>> {
        let facts = &gpu.facts;
        // A software device copies from cache to cache what is smaller.
        let n_bytes = BUFFER_BYTES.min(facts.max_binding_bytes).min(facts.max_buffer_bytes);
        let row_bytes = ELEMENT_BYTES * WORKGROUP;
        let most = u64::from(facts.max_workgroups).pow(2);
        let n_bytes = (n_bytes / row_bytes).min(most) * row_bytes;
        use wgpu::BufferUsages as Usage;
        let buffer = |label| gpu.buffer(label, n_bytes as usize, Usage::STORAGE | Usage::COPY_DST);
        let runs = Runs {
            gpu,
            clock: Clock::new(gpu),
            input: buffer("ceilings: input"),
            output: buffer("ceilings: output"),
            n_elements: n_bytes / ELEMENT_BYTES,
        };
        gpu.check()?;
        Ok(runs)
    }

    /// 10⁹ of `amount` a second, where one dispatch of `n_invocations` does `amount`.
    fn rate(
        &mut self,
        shader: &Shader,
        entry_point: &str,
        n_invocations: u64,
        amount: u64,
    ) -> Result<f64> {
        let bindings = Bindings::new(self.gpu, shader)?;
        let pipeline = pipeline(self.gpu, shader, entry_point, &bindings.layout)?;
        let resources = [
            ("input", self.input.as_entire_binding()),
            ("output", self.output.as_entire_binding()),
        ];
        let group = bindings.bind(&self.gpu.device, resources)?;
        let n_groups = n_invocations.div_ceil(WORKGROUP) as u32;
        let width = n_groups.min(self.gpu.facts.max_workgroups);
        let groups = [width, n_groups.div_ceil(width)];
        let mut n_dispatches = 1;
        while self.time(&pipeline, &group, groups, n_dispatches)? < LONG_ENOUGH {
            n_dispatches *= 2;
        }
        let mut best = Duration::MAX;
        for _ in 0..RUNS {
            best = best.min(self.time(&pipeline, &group, groups, n_dispatches)?);
        }
        Ok(f64::from(n_dispatches) * amount as f64 / best.as_secs_f64() / 1e9)
    }

    fn time(
        &self,
        pipeline: &wgpu::ComputePipeline,
        group: &wgpu::BindGroup,
        [width, height]: [u32; 2],
        n_dispatches: u32,
    ) -> Result<Duration> {
        let mut encoder = self.gpu.encoder();
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("ceilings"),
                timestamp_writes: self.clock.as_ref().map(Clock::around_pass),
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            for _ in 0..n_dispatches {
                pass.dispatch_workgroups(width, height, 1);
            }
        }
        if let Some(clock) = &self.clock {
            clock.stop(&mut encoder);
        }
        let start = Instant::now();
        let submission = self.gpu.submit(encoder.finish());
        let waited = self.gpu.wait(submission, TIMEOUT);
        let spent = start.elapsed();
        self.gpu.check()?;
        waited.map_err(|reason| {
            let name = &self.gpu.facts.name;
            Error::Device(format!("`{name}` did not finish measuring its ceilings: {reason}"))
        })?;
        match &self.clock {
            Some(clock) => clock.read(self.gpu, TIMEOUT),
            None => Ok(spent),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Gpu, Pick};

    #[test]
    fn rates_are_those_of_a_device() {
        let gpu = Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one");
        let found = Ceilings::measure(&gpu).unwrap();
        // From an old processor to beyond today's largest card.
        assert!((0.01..1e5).contains(&found.copy_gb_per_s), "{found:?}");
        assert!((0.01..1e7).contains(&found.f32_gflop_per_s), "{found:?}");
        assert_eq!(found.f64_gflop_per_s.is_some(), gpu.facts.f64);
    }
}
