//! Pictures that stay on the device: ids are proposed into them, undecided rays are listed there, and
//! decisions are put there.

use std::sync::Arc;

use super::compile::{Shader, WORKGROUP, compile_undecided};
use super::device::OpenDevice;
use super::open::Gpu;
use super::pipeline::{Bindings, pipeline};
use crate::certify::Decided;
use crate::error::Result;

/// Undecided rays that come back together with their number: most pictures have fewer.
const HEAD_RAYS: usize = (1 << 14) - 1;

/// Decisions that are handed over at a time.
const DECISIONS: usize = 1 << 14;

/// Twin of `Job` in `shaders/undecided.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Job {
    n: u32,
    row: u32,
}

/// Lists and decides the undecided rays of pictures up to a size.
pub(crate) struct Undecided {
    gpu: Arc<Gpu>,
    find: wgpu::ComputePipeline,
    decide: wgpu::ComputePipeline,
    bindings: Bindings,
    job: wgpu::Buffer,
    decisions: wgpu::Buffer,
    room: Room,
}

/// The buffers whose size depends on the picture's.
struct Room {
    n_rays: usize,
    found: wgpu::Buffer,
    staging: wgpu::Buffer,
}

/// Words on the device: ids or colours, one a pixel.
pub struct Words {
    queue: wgpu::Queue,
    buffer: wgpu::Buffer,
    n: usize,
}

impl Words {
    /// `n` words with any values.
    fn new(gpu: &OpenDevice, n: usize) -> Words {
        Words { queue: gpu.queue.clone(), buffer: storage_buffer(gpu, "words", n), n }
    }

    /// Number of words.
    pub(crate) fn len(&self) -> usize {
        self.n
    }

    /// Replaces the words from `first` on.
    pub(crate) fn write(&self, first: usize, words: &[u32]) {
        let offset = (first * size_of::<u32>()) as u64;
        self.queue.write_buffer(&self.buffer, offset, bytemuck::cast_slice(words));
    }

    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

/// Words of one size that are used again when nobody holds them any more.
#[derive(Default)]
pub(crate) struct Pool(Vec<Arc<Words>>);

impl Pool {
    /// `n` words with any values that nobody else holds.
    pub(crate) fn take(&mut self, gpu: &OpenDevice, n: usize) -> Arc<Words> {
        self.0.retain(|words| words.n == n);
        if let Some(free) = self.0.iter().find(|words| Arc::strong_count(words) == 1) {
            return Arc::clone(free);
        }
        let new = Arc::new(Words::new(gpu, n));
        self.0.push(Arc::clone(&new));
        new
    }
}

/// A buffer of `n` words that shaders read and write and that commands copy from and to.
fn storage_buffer(gpu: &OpenDevice, label: &str, n: usize) -> wgpu::Buffer {
    use wgpu::BufferUsages as Usage;
    let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
    gpu.buffer(label, n * size_of::<u32>(), usage)
}

impl Room {
    fn new(gpu: &OpenDevice, n_rays: usize) -> Room {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let n_words = n_rays.max(HEAD_RAYS) + 1;
        Room {
            n_rays,
            found: storage_buffer(gpu, "undecided", n_words),
            staging: gpu.buffer("undecided staging", n_words * size_of::<u32>(), usage),
        }
    }
}

impl Undecided {
    /// Compiles the shader.
    ///
    /// # Errors
    /// [`crate::Error::Shader`] when the device refuses it.
    pub(crate) fn new(gpu: &Arc<Gpu>) -> Result<Undecided> {
        let shader: Shader = compile_undecided()?;
        let bindings = Bindings::new(gpu, &shader)?;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let undecided = Undecided {
            find: pipeline(gpu, &shader, "find", &bindings.layout)?,
            decide: pipeline(gpu, &shader, "decide", &bindings.layout)?,
            bindings,
            job: gpu.buffer("job", size_of::<Job>(), usage),
            decisions: storage_buffer(gpu, "decisions", 2 * DECISIONS),
            room: Room::new(gpu, HEAD_RAYS),
            gpu: Arc::clone(gpu),
        };
        gpu.check()?;
        Ok(undecided)
    }

    /// The undecided rays of a picture, ascending.
    ///
    /// # Errors
    /// [`crate::Error::Device`] when the device fails.
    pub(crate) fn find(&mut self, ids: &Words) -> Result<Vec<u32>> {
        let n_rays = ids.len();
        if self.room.n_rays < n_rays {
            self.room = Room::new(&self.gpu, n_rays);
        }
        let mut encoder = self.gpu.encoder();
        encoder.clear_buffer(&self.room.found, 0, Some(size_of::<u32>() as u64));
        self.dispatch(&mut encoder, &self.find, ids, n_rays)?;
        let mut words = self.read(encoder, HEAD_RAYS + 1)?;
        let count = words[0] as usize;
        if count > HEAD_RAYS {
            words = self.read(self.gpu.encoder(), count.min(n_rays) + 1)?;
        }
        let mut rays = words[1..count.min(words.len() - 1) + 1].to_vec();
        rays.sort_unstable();
        Ok(rays)
    }

    /// Puts decisions into the ids.
    ///
    /// # Errors
    /// [`crate::Error::Device`] when the device fails.
    pub(crate) fn decide(&self, ids: &Words, decided: &[Decided]) -> Result<()> {
        for some in decided.chunks(DECISIONS) {
            let words: Vec<[u32; 2]> = some.iter().map(|one| [one.ray, one.id]).collect();
            self.gpu.queue.write_buffer(&self.decisions, 0, bytemuck::cast_slice(&words));
            let mut encoder = self.gpu.encoder();
            self.dispatch(&mut encoder, &self.decide, ids, some.len())?;
            self.gpu.submit(encoder.finish());
        }
        self.gpu.check()
    }

    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::ComputePipeline,
        ids: &Words,
        n: usize,
    ) -> Result<()> {
        let groups = (n as u32).div_ceil(WORKGROUP.iter().product());
        let row = groups.clamp(1, self.gpu.facts.max_workgroups);
        let job = Job { n: n as u32, row };
        self.gpu.queue.write_buffer(&self.job, 0, bytemuck::bytes_of(&job));
        let buffers = [
            ("job", &self.job),
            ("ids", ids.buffer()),
            ("found", &self.room.found),
            ("decisions", &self.decisions),
        ];
        let resources = buffers.map(|(name, buffer)| (name, buffer.as_entire_binding()));
        let bind_group = self.bindings.bind(&self.gpu.device, resources)?;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(row, groups.div_ceil(row), 1);
        Ok(())
    }

    /// Hands over the commands, and then reads the first words of the list.
    fn read(&self, mut encoder: wgpu::CommandEncoder, n_words: usize) -> Result<Vec<u32>> {
        let Room { found, staging, .. } = &self.room;
        let bytes = (n_words * size_of::<u32>()) as u64;
        encoder.copy_buffer_to_buffer(found, 0, staging, 0, Some(bytes));
        self.gpu.submit(encoder.finish());
        self.gpu.read(staging, n_words, "list its undecided rays")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::Stage;
    use crate::control::Control;
    use crate::device::Device;
    use crate::gpu::Pick;
    use crate::num::OPEN;
    use crate::prepare::Prepared;
    use crate::rays::{Pixels, View};
    use crate::scene::parse_scene;
    use crate::trace::{Hits, Kernel, Rays, Timing, Wants};

    /// A picture of two spheres at nearly one place: f32 can't tell which is hit.
    fn twins(fov: f64, eye: f64) -> (Rays, Arc<Prepared>) {
        let sphere =
            |x: f64| format!("{{ center = [{x}, 0, 0], radius = 1, color = \"#d62728\" }}");
        let text = format!(
            "camera = {{ position = [0, 0, {eye:?}], look_at = [0, 0, -9], fov = {fov:?} }}\n\
             sphere = [{}, {}]\n",
            sphere(0.0),
            sphere(1e-9)
        );
        let scene = parse_scene(&text, "twins.toml".as_ref()).unwrap();
        let camera = scene.camera.clone().unwrap();
        let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 80, 60));
        let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
        (rays, Arc::new(prepared))
    }

    #[test]
    fn resident_proposals_are_decided_as_those_of_the_host() {
        let gpu = Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one");
        let gpu = Arc::new(gpu);
        let mut undecided = Undecided::new(&gpu).unwrap();
        let control = Control::default();
        for (fov, eye, in_range) in [(60.0, 3.0, true), (179.999_999_999_9, 0.5, false)] {
            let (rays, prepared) = twins(fov, eye);
            assert_eq!(prepared.in_range, in_range);
            let wants = Wants::default();
            let device = Device::Gpu(Arc::clone(&gpu));
            let tracers =
                [device, Device::Cpu].map(|device| device.tracer(&prepared, wants).unwrap().tracer);
            for mut tracer in tracers {
                let mut hits = Hits::default();
                tracer.propose(&rays, &control, &mut hits).unwrap();
                let is_open =
                    |ray: &u32| hits.id[*ray as usize] == OPEN || prepared.starts_in_f64();
                let expected: Vec<u32> = (0..rays.len() as u32).filter(is_open).collect();
                assert!(expected.len() > 200);
                let ids = Words::new(&gpu, rays.len());
                tracer.propose_resident(&rays, &control, &ids).unwrap();
                let found = undecided.find(&ids).unwrap();
                assert_eq!(found, expected, "{fov}");
                let stage = Stage::new(&prepared, &rays);
                let decided = stage.decide(&found, &control, &mut Timing::default()).unwrap();
                undecided.decide(&ids, &decided).unwrap();
                assert_eq!(undecided.find(&ids).unwrap(), Vec::<u32>::new());
                tracer.trace(&rays, &control, &mut hits).unwrap();
                assert!(decided.iter().all(|one| hits.id[one.ray as usize] == one.id));
                assert!(hits.n_hits() > 200);
            }
        }
    }
}
