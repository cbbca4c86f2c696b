//! Upload, tiles, read back.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::clock::Clock;
use super::compile::WORKGROUP;
use super::hierarchy::{DeviceHierarchy, of_scene};
use super::layout::{Params, ParamsDouble};
#[cfg(feature = "view")]
use super::live::{ProposeResident, Words};
use super::open::Gpu;
use super::pipeline::bind_resources;
use super::program::Program;
use super::texture::UPLOAD_BYTES;
use crate::certify::{self, DecideInF64, InF64};
use crate::control::Control;
use crate::cpu::CpuTracer;
use crate::error::{Error, Result};
use crate::kernel::coordinates::{RayRecord, RayRecordDouble};
use crate::kernel::{Float, Kernel};
use crate::memory;
use crate::prepare::{Hierarchy, Prepared, ShaderKey};
use crate::rays::{Bundle, CameraF32, CameraF64, Pixels};
use crate::trace::{Hits, Ray, Rays, Timing, Wants};
use crate::tracer::Tracer;

/// Aim for the time of a dispatch: long enough to hide its overhead, short enough for every driver's
/// watchdog and for a quick Ctrl-C.
const TILE_TARGET: Duration = Duration::from_millis(75);

/// A dispatch that takes longer than this is given up.
const TILE_TIMEOUT: Duration = Duration::from_secs(60);

/// Most rays of one dispatch; bounds the memory for results.
const TILE_MAX_RAYS: usize = 1 << 20;

/// Ray–object tests of the first dispatch, before anything is known about the device: about a
/// millisecond on two CPU cores.
const FIRST_TILE_TESTS: usize = 1 << 19;

/// Fewest rays of one dispatch, a row of a workgroup: so that it ends in time also where each ray has
/// millions of objects to look at.
const TILE_LEAST_RAYS: usize = WORKGROUP[0] as usize;

/// Traces on a Vulkan device.
pub struct GpuTracer {
    gpu: Arc<Gpu>,
    prepared: Arc<Prepared>,
    wants: Wants,
    key: ShaderKey,
    /// None before it is needed.
    program: Option<Arc<Program>>,
    params: wgpu::Buffer,
    objects: Vec<wgpu::Buffer>,
    hierarchy: Option<DeviceHierarchy>,
    results: Option<Results>,
    tile_rays: usize,
    clock: Option<Clock>,
    /// Takes the certified kernel's f32 stage where the device can't: its arithmetic doesn't suit the
    /// proof, or there is no way to the rays' many spheres.
    cpu_fallback: Option<CpuTracer>,
    /// Completes hits.
    surfaces: Option<Surfaces>,
    /// Decide in f64, made when they are first needed: all rays, and some pixels.
    in_f64: [Option<Box<GpuTracer>>; 2],
    /// Time to put together and compile the shader.
    pub compile_time: Duration,
    /// Time to hand the scene to the device.
    pub upload_time: Duration,
}

/// Device buffers for the results of `n_rays` rays and the bind group that names them.
struct Results {
    n_rays: usize,
    device: Vec<wgpu::Buffer>,
    staging: wgpu::Buffer,
    rays: Option<wgpu::Buffer>,
    bind_group: wgpu::BindGroup,
    of_surfaces: Option<wgpu::BindGroup>,
}

/// The second step of a dispatch where hits are completed.
struct Surfaces {
    program: Arc<Program>,
    params: wgpu::Buffer,
    /// In the order of the shader's bindings, behind the results.
    objects: Vec<wgpu::Buffer>,
}

impl Surfaces {
    /// `None` where the CPU completes hits.
    fn new(
        gpu: &Gpu,
        prepared: &Prepared,
        wants: Wants,
        hierarchy: Option<&DeviceHierarchy>,
    ) -> Result<Option<Surfaces>> {
        let is_picture = prepared.bundle() != Bundle::Free;
        let is_wanted = wants.surface && is_picture && certify::suits_device(prepared);
        if !(is_wanted && fits_in_f64(gpu, prepared) && gpu.completes()?) {
            return Ok(None);
        }
        let numbers = InF64::new(prepared);
        let mut objects = Vec::new();
        if !prepared.scene.spheres.is_empty() {
            objects.extend(of_scene(gpu, prepared));
        }
        let (spheres, planes) = numbers.lists.bytes();
        if !spheres.is_empty() {
            objects.push(gpu.storage("spheres", spheres));
            objects.extend(hierarchy.and_then(DeviceHierarchy::rest_ids).cloned());
        }
        if !planes.is_empty() {
            let units = numbers.units(prepared);
            objects.push(gpu.storage("planes", planes));
            objects.push(gpu.storage("units", bytemuck::cast_slice(&units)));
        }
        let program = gpu.program(&numbers.surface_key(prepared))?;
        Ok(Some(Surfaces { program, params: params_buffer(gpu, Float::F64), objects }))
    }

    fn bytes(&self) -> u64 {
        self.params.size() + self.objects.iter().map(wgpu::Buffer::size).sum::<u64>()
    }
}

/// Whether the device takes a scene's own numbers at once.
fn fits_in_f64(gpu: &Gpu, prepared: &Prepared) -> bool {
    let bytes = size_of_val(&prepared.scene.spheres[..]) as u64;
    bytes <= gpu.facts.max_binding_bytes.min(gpu.facts.max_buffer_bytes)
}

/// Bytes of the id, of `t`, and of the normal of one ray.
const RESULT_BYTES: [usize; 3] = [4, 4, 12];

impl GpuTracer {
    /// Compiles the shader that the scene needs and uploads the scene.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when the scene exceeds the device's limits, [`Error::Device`] when the
    /// device fails, [`Error::Shader`] when it refuses the shader, [`Error::NoAdapter`] when the
    /// kernel needs more than the adapter has.
    pub fn new(gpu: Arc<Gpu>, prepared: Arc<Prepared>, wants: Wants) -> Result<GpuTracer> {
        gpu.facts.check_kernel(prepared.kernel)?;
        check_limits(&gpu, &prepared)?;
        check_memory(&gpu, &prepared)?;
        let cpu_fallback = cpu_fallback(&gpu, &prepared, wants)?;
        let key = prepared.shader_key(wants);
        // Who begins in f64 may never need another shader.
        let begins_in_f64 = prepared.starts_in_f64()
            && cpu_fallback.is_none()
            && certify::suits_device(&prepared)
            && gpu.begins_in_f64()?;
        let start = Instant::now();
        let objects = storage(&gpu, prepared.objects.bytes());
        let hierarchy = device_hierarchy(&gpu, &prepared)?;
        let upload_time = start.elapsed();

        let start = Instant::now();
        let program = if begins_in_f64 { None } else { Some(gpu.program(&key)?) };
        let surfaces = Surfaces::new(&gpu, &prepared, wants, hierarchy.as_ref())?;
        let mut tracer = GpuTracer::from_parts(Parts {
            gpu,
            prepared,
            wants,
            key,
            program,
            objects,
            hierarchy,
            surfaces,
            cpu_fallback,
            compile_time: start.elapsed(),
            upload_time,
        })?;
        if begins_in_f64 {
            let start = Instant::now();
            tracer.in_f64[0] = Some(Box::new(tracer.new_in_f64(false)?));
            tracer.compile_time += start.elapsed();
        }
        Ok(tracer)
    }

    /// A tracer of the same scene that proposes in f64, for all rays or for some pixels.
    fn new_in_f64(&self, some: bool) -> Result<GpuTracer> {
        let (gpu, prepared) = (Arc::clone(&self.gpu), Arc::clone(&self.prepared));
        let numbers = InF64::new(&prepared);
        let key = numbers.shader_key(&prepared, some);
        let hierarchy = self.hierarchy.as_ref();
        let wants = Wants { surface: self.wants.surface && !some, level: false };
        GpuTracer::from_parts(Parts {
            program: Some(gpu.program(&key)?),
            objects: storage(&gpu, numbers.lists.bytes()),
            hierarchy: hierarchy.map(|hierarchy| hierarchy.in_f64(&gpu, &prepared)),
            surfaces: Surfaces::new(&gpu, &prepared, wants, hierarchy)?,
            gpu,
            prepared,
            wants,
            key,
            cpu_fallback: None,
            compile_time: Duration::ZERO,
            upload_time: Duration::ZERO,
        })
    }

    fn from_parts(parts: Parts) -> Result<GpuTracer> {
        let Parts { gpu, prepared, key, .. } = parts;
        let params = params_buffer(&gpu, key.float);
        gpu.check()?;
        let tile_rays = first_tile_rays(&prepared);
        let mut tracer = GpuTracer {
            gpu,
            prepared,
            wants: parts.wants,
            key,
            program: parts.program,
            params,
            objects: parts.objects,
            hierarchy: parts.hierarchy,
            surfaces: parts.surfaces,
            results: None,
            tile_rays,
            clock: None,
            cpu_fallback: parts.cpu_fallback,
            in_f64: [None, None],
            compile_time: parts.compile_time,
            upload_time: parts.upload_time,
        };
        let start = Instant::now();
        tracer.warm_up()?;
        tracer.compile_time += start.elapsed();
        Ok(tracer)
    }
}

/// What a tracer is made of.
struct Parts {
    gpu: Arc<Gpu>,
    prepared: Arc<Prepared>,
    wants: Wants,
    key: ShaderKey,
    program: Option<Arc<Program>>,
    objects: Vec<wgpu::Buffer>,
    hierarchy: Option<DeviceHierarchy>,
    surfaces: Option<Surfaces>,
    cpu_fallback: Option<CpuTracer>,
    compile_time: Duration,
    upload_time: Duration,
}

/// Rays of the first dispatch.
fn first_tile_rays(prepared: &Prepared) -> usize {
    let n_objects = (prepared.n_listed_spheres() + prepared.scene.planes.len()).max(32);
    (FIRST_TILE_TESTS / n_objects).clamp(TILE_LEAST_RAYS, TILE_MAX_RAYS)
}

/// The labels and bytes of the kinds of objects that there are.
fn object_bytes<'a>(
    (spheres, planes): (&'a [u8], &'a [u8]),
) -> impl Iterator<Item = (&'static str, &'a [u8])> {
    [("spheres", spheres), ("planes", planes)].into_iter().filter(|(_, bytes)| !bytes.is_empty())
}

/// The spheres and the planes on the device.
fn storage(gpu: &Gpu, objects: (&[u8], &[u8])) -> Vec<wgpu::Buffer> {
    object_bytes(objects).map(|(label, bytes)| gpu.storage(label, bytes)).collect()
}

fn cpu_fallback(gpu: &Gpu, prepared: &Arc<Prepared>, wants: Wants) -> Result<Option<CpuTracer>> {
    let unsuited = prepared.kernel == Kernel::Certified
        && (prepared.is_left_to_f64() || !gpu.arithmetic()?.suits_filter());
    Ok(unsuited.then(|| CpuTracer::new(Arc::clone(prepared), wants)))
}

fn device_hierarchy(gpu: &Gpu, prepared: &Prepared) -> Result<Option<DeviceHierarchy>> {
    let hierarchy = prepared.hierarchy.as_ref();
    Ok(hierarchy.map(|hierarchy| DeviceHierarchy::new(gpu, hierarchy)).transpose()?.flatten())
}

fn params_buffer(gpu: &Gpu, float: Float) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("params"),
        size: match float {
            Float::F64 => size_of::<ParamsDouble>(),
            Float::F32 => size_of::<Params>(),
        } as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn check_limits(gpu: &Gpu, prepared: &Prepared) -> Result<()> {
    let facts = &gpu.facts;
    let limit = facts.max_binding_bytes.min(facts.max_buffer_bytes);
    let (spheres, planes) = prepared.objects.bytes();
    let parts = [
        ("spheres", spheres.len() as u64, prepared.n_listed_spheres()),
        ("planes", planes.len() as u64, prepared.scene.planes.len()),
    ];
    for (what, bytes, count) in parts {
        if bytes > limit {
            let most = limit / (bytes / count as u64);
            return Err(Error::TooLarge(format!(
                "the scene needs {} MiB for {count} {what}; `{}` binds at most {} MiB at once: \
                 use at most {most} {what}, or `--device cpu`",
                bytes >> 20,
                facts.name,
                limit >> 20
            )));
        }
    }
    Ok(())
}

/// Refuses a scene that this machine has no memory to hand over; a device in software keeps it there
/// too.
fn check_memory(gpu: &Gpu, prepared: &Prepared) -> Result<()> {
    let (spheres, planes) = prepared.objects.bytes();
    let objects = (spheres.len() + planes.len()) as u64;
    let hierarchy = prepared.hierarchy.as_ref().map_or(0, Hierarchy::bytes);
    let on_their_way = objects + hierarchy.min(UPLOAD_BYTES as u64);
    let kept = if gpu.facts.is_software() { objects + hierarchy } else { 0 };
    let what = format!("handing the scene to `{}`", gpu.facts.name);
    memory::require(what, on_their_way + kept, "use fewer objects, or `--device cpu`")
}

fn bytes(params: &impl bytemuck::NoUninit) -> Vec<u8> {
    bytemuck::bytes_of(params).to_vec()
}

/// Twice the offset of a tile's first pixel from the picture's centre, right and up. A picture has
/// at most 2^31 columns and rows, so the doubled offsets fit.
fn offsets(work: &Work, tile: &Tile) -> [i32; 2] {
    let Some((pixels, [x, y])) = work.first_pixel(tile) else { return [0; 2] };
    let (offset_i, offset_j) = pixels.offset2(x, y);
    [offset_i as i32, offset_j as i32]
}

#[cfg(feature = "view")]
impl ProposeResident for GpuTracer {
    fn propose_resident(&mut self, rays: &Rays, control: &Control, ids: &Words) -> Result<()> {
        match &mut self.cpu_fallback {
            Some(cpu) => cpu.propose_resident(rays, control, ids)?,
            None => drop(self.propose_into(rays, control, Target::Resident(ids))?),
        }
        self.gpu.check()
    }
}

/// Where a device's results go.
enum Target<'a> {
    /// To the host.
    Hits(&'a mut Hits),
    /// The ids alone, elsewhere on the device.
    #[cfg(feature = "view")]
    Resident(&'a Words),
}

/// Workgroups that cover a tile.
fn workgroups(tile: &Tile) -> [u32; 2] {
    let [width, height] = WORKGROUP;
    [(tile.width as u32).div_ceil(width), (tile.height as u32).div_ceil(height)]
}

impl Tracer for GpuTracer {
    fn propose(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing> {
        if let Some(cpu) = &mut self.cpu_fallback {
            return cpu.propose(rays, control, hits);
        }
        self.propose_into(rays, control, Target::Hits(hits))
    }

    fn target(&self) -> Option<(&Prepared, Wants)> {
        Some((&self.prepared, self.wants))
    }

    fn certify(
        &mut self,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
        timing: Timing,
    ) -> Result<Timing> {
        let (prepared, wants) = (Arc::clone(&self.prepared), self.wants);
        certify::resolve(&prepared, rays, wants, control, Some(self), hits, timing)
    }

    /// A moved camera costs no new shader while [`Hierarchy::n_places_of_rest`] stays.
    fn retarget(&mut self, prepared: Arc<Prepared>) -> Result<()> {
        self.gpu.facts.check_kernel(prepared.kernel)?;
        check_limits(&self.gpu, &prepared)?;
        check_memory(&self.gpu, &prepared)?;
        let cpu_fallback = cpu_fallback(&self.gpu, &prepared, self.wants)?;
        let key = prepared.shader_key(self.wants);
        let is_new = key != self.key;
        let program = if is_new { Some(self.gpu.program(&key)?) } else { None };
        let hierarchy = device_hierarchy(&self.gpu, &prepared)?;
        if let Some(program) = program {
            self.program = Some(program);
            self.params = params_buffer(&self.gpu, key.float);
            self.objects = storage(&self.gpu, prepared.objects.bytes());
            self.tile_rays = first_tile_rays(&prepared);
        } else {
            for (buffer, (_, bytes)) in
                self.objects.iter().zip(object_bytes(prepared.objects.bytes()))
            {
                self.gpu.queue.write_buffer(buffer, 0, bytes);
            }
        }
        if is_new || hierarchy.is_some() || self.surfaces.is_some() {
            self.results = None;
        }
        self.key = key;
        self.cpu_fallback = cpu_fallback;
        self.in_f64 = [None, None];
        self.surfaces = Surfaces::new(&self.gpu, &prepared, self.wants, hierarchy.as_ref())?;
        self.hierarchy = hierarchy;
        self.prepared = prepared;
        self.gpu.check()
    }

    fn bytes_device(&self) -> u64 {
        let results = self.results.as_ref();
        let results_bytes = results.map_or(0, |r| {
            let device: u64 = r.device.iter().map(wgpu::Buffer::size).sum();
            device + r.staging.size() + r.rays.as_ref().map_or(0, wgpu::Buffer::size)
        });
        self.objects.iter().map(wgpu::Buffer::size).sum::<u64>()
            + self.hierarchy.as_ref().map_or(0, DeviceHierarchy::bytes)
            + self.params.size()
            + results_bytes
            + self.surfaces.as_ref().map_or(0, Surfaces::bytes)
            + self.in_f64.iter().flatten().map(|tracer| tracer.bytes_device()).sum::<u64>()
    }

    fn use_device_clock(&mut self) {
        self.clock = Clock::new(&self.gpu);
    }
}

/// Rays to be traced.
enum Work<'a> {
    /// All of them.
    All(&'a Rays),
    /// Those pixels with these indices.
    Some(&'a Pixels, &'a [u32]),
}

impl<'a> Work<'a> {
    fn n_rays(&self) -> usize {
        match self {
            Work::All(rays) => rays.len(),
            Work::Some(_, indices) => indices.len(),
        }
    }

    /// Picture column and row of a tile's first pixel; those of the picture's first one where pixels come as a
    /// list.
    fn first_pixel(&self, tile: &Tile) -> Option<(&'a Pixels, [u32; 2])> {
        match self {
            Work::All(Rays::Pixels(pixels)) => Some((pixels, pixels.xy(tile.first).into())),
            Work::All(Rays::List(_)) => None,
            Work::Some(pixels, _) => Some((pixels, [0, 0])),
        }
    }
}

impl DecideInF64 for GpuTracer {
    fn completes(&self, rays: &Rays) -> bool {
        matches!(rays, Rays::Pixels(_)) && self.cpu_fallback.is_none() && self.surfaces.is_some()
    }

    fn decide_in_f64(
        &mut self,
        rays: &Rays,
        some: Option<&[u32]>,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<bool> {
        let is_taken = match some {
            None => self.gpu.begins_in_f64()?,
            Some(some) => self.gpu.decides_in_f64(some.len())?,
        };
        if self.cpu_fallback.is_some() || !is_taken || !fits_in_f64(&self.gpu, &self.prepared) {
            return Ok(false);
        }
        self.propose_in_f64(rays, some, control, hits)?;
        Ok(true)
    }
}

/// Consecutive rays of one dispatch: whole rows, or a part of one row.
#[derive(Clone, Copy, Debug)]
struct Tile {
    first: usize,
    width: usize,
    height: usize,
    /// Rays that fill the tile; the last row of a list may be short.
    n_rays: usize,
}

/// Width of the grid that a list of rays is laid out on.
const LIST_WIDTH: usize = 1 << 13;

impl GpuTracer {
    /// Writes the objects that rays see in f64 into `hits`, for all rays or those with some indices, or
    /// [`UNDECIDED`](crate::kernel::certified::UNDECIDED): for a scene that [`propose_in_f64`] takes, which is
    /// the twin of this.
    ///
    /// [`propose_in_f64`]: crate::cpu::propose_in_f64
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    pub fn propose_in_f64(
        &mut self,
        rays: &Rays,
        some: Option<&[u32]>,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<()> {
        let list = match (rays, some) {
            (Rays::List(rays), Some(some)) => {
                Some(Rays::List(some.iter().map(|&ray| rays[ray as usize]).collect()))
            }
            _ => None,
        };
        let work = match (rays, some) {
            (Rays::Pixels(pixels), Some(some)) => Work::Some(pixels, some),
            _ => Work::All(list.as_ref().unwrap_or(rays)),
        };
        let place = usize::from(matches!(work, Work::Some(..)));
        let mut tracer = match self.in_f64[place].take() {
            Some(tracer) => tracer,
            None => Box::new(self.new_in_f64(place == 1)?),
        };
        hits.make_room(work.n_rays(), Wants { surface: tracer.wants.surface, ..self.wants });
        tracer.trace_tiles(&work, control, &mut Target::Hits(hits))?;
        self.in_f64[place] = Some(tracer);
        Ok(())
    }

    fn propose_into(
        &mut self,
        rays: &Rays,
        control: &Control,
        mut target: Target,
    ) -> Result<Timing> {
        self.prepared.check(rays)?;
        match &mut target {
            Target::Hits(hits) => hits.reset(rays.len(), self.wants),
            #[cfg(feature = "view")]
            Target::Resident(_) => {}
        }
        self.trace_tiles(&Work::All(rays), control, &mut target)
    }

    fn trace_tiles(
        &mut self,
        work: &Work,
        control: &Control,
        target: &mut Target,
    ) -> Result<Timing> {
        let mut timing = Timing::default();
        let mut first = 0;
        while first < work.n_rays() {
            control.check()?;
            let tile = self.tile(work, first);
            let start = Instant::now();
            let spent = self.trace_tile(work, &tile, target)?;
            timing.add(spent);
            self.adapt(tile.n_rays, start.elapsed());
            first += tile.n_rays;
            // In f64 rays are traced that were counted before.
            if self.key.float == self.prepared.kernel.about().float {
                control.advance(tile.n_rays as u64);
            }
        }
        Ok(timing)
    }

    fn tile(&self, work: &Work, first: usize) -> Tile {
        match work {
            Work::All(Rays::Pixels(pixels)) => {
                let (width, height) = (pixels.width as usize, pixels.height as usize);
                let (row, column) = (first / width, first % width);
                if column > 0 || self.tile_rays < width {
                    let width = self.tile_rays.min(width - column);
                    Tile { first, width, height: 1, n_rays: width }
                } else {
                    let height = (self.tile_rays / width).min(height - row);
                    Tile { first, width, height, n_rays: width * height }
                }
            }
            Work::All(Rays::List(_)) | Work::Some(..) => {
                let n_rays = self.tile_rays.min(work.n_rays() - first);
                let width = n_rays.min(LIST_WIDTH);
                Tile { first, width, height: n_rays.div_ceil(width), n_rays }
            }
        }
    }

    /// Moves the tile's size toward the target time. A short tile, such as the last one, that met
    /// its target says nothing against longer ones.
    fn adapt(&mut self, n_rays: usize, spent: Duration) {
        let ratio = TILE_TARGET.as_secs_f64() / spent.as_secs_f64().max(1e-6);
        let wanted = (n_rays as f64 * ratio.clamp(0.125, 8.0)) as usize;
        let least = if ratio >= 1.0 { self.tile_rays } else { TILE_LEAST_RAYS };
        self.tile_rays = wanted.max(least).clamp(TILE_LEAST_RAYS, TILE_MAX_RAYS);
    }

    fn dispatch(
        &self,
        results: &Results,
        program: &Program,
        [x, y]: [u32; 2],
    ) -> wgpu::CommandEncoder {
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        let mut encoder = self.gpu.device.create_command_encoder(&descriptor);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.clock.as_ref().map(Clock::around_pass),
        });
        pass.set_pipeline(&program.pipeline);
        pass.set_bind_group(0, &results.bind_group, &[]);
        pass.dispatch_workgroups(x, y, 1);
        if let (Some(surfaces), Some(bind_group)) = (&self.surfaces, &results.of_surfaces) {
            pass.set_pipeline(&surfaces.program.pipeline);
            pass.set_bind_group(0, bind_group, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
        drop(pass);
        if let Some(clock) = &self.clock {
            clock.stop(&mut encoder);
        }
        encoder
    }

    /// Runs one workgroup on an empty tile: some drivers compile a shader when it first runs, and
    /// that time belongs to compiling, nor should it mislead the tiles' size.
    fn warm_up(&mut self) -> Result<()> {
        let Some(program) = self.program.clone() else { return Ok(()) };
        self.make_room(64, &program)?;
        let Some(results) = &self.results else { return Ok(()) };
        let params = match self.key.float {
            Float::F64 => bytes(&ParamsDouble { n_rays: 1, ..ParamsDouble::default() }),
            Float::F32 => bytes(&Params { n_rays: 1, ..Params::default() }),
        };
        self.gpu.queue.write_buffer(&self.params, 0, &params);
        if let Some(surfaces) = &self.surfaces {
            let params = bytes(&ParamsDouble { n_rays: 1, ..ParamsDouble::default() });
            self.gpu.queue.write_buffer(&surfaces.params, 0, &params);
        }
        self.gpu.submit(self.dispatch(results, &program, [1, 1]).finish());
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(TILE_TIMEOUT) };
        self.gpu.device.poll(wait).map_err(|error| self.lost(&error.to_string()))?;
        self.gpu.check()
    }

    fn trace_tile(&mut self, work: &Work, tile: &Tile, target: &mut Target) -> Result<Timing> {
        let program = match &self.program {
            Some(program) => Arc::clone(program),
            None => Arc::clone(self.program.insert(self.gpu.program(&self.key)?)),
        };
        self.make_room(tile.n_rays, &program)?;
        let Some(results) = &self.results else { return Ok(Timing::default()) };
        let start = Instant::now();
        self.write_params(work, tile);
        let mut exponents = Vec::new();
        if let Some(buffer) = &results.rays {
            let range = tile.first..tile.first + tile.n_rays;
            match work {
                Work::All(Rays::Pixels(_)) => {}
                Work::All(Rays::List(rays)) => exponents = self.upload_rays(&rays[range], buffer),
                Work::Some(pixels, indices) => {
                    let place = |&index: &u32| <[u32; 2]>::from(pixels.xy(index as usize));
                    let places: Vec<[u32; 2]> = indices[range].iter().map(place).collect();
                    self.gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&places));
                }
            }
        }
        let encoder = self.dispatch(results, &program, workgroups(tile));
        match target {
            Target::Hits(hits) => self.read_tile(results, encoder, tile, &exponents, start, hits),
            #[cfg(feature = "view")]
            Target::Resident(ids) => self.keep_tile(results, encoder, tile, start, ids),
        }
    }

    /// Copies the ids of a tile to where they stay.
    #[cfg(feature = "view")]
    fn keep_tile(
        &self,
        results: &Results,
        mut encoder: wgpu::CommandEncoder,
        tile: &Tile,
        start: Instant,
        ids: &Words,
    ) -> Result<Timing> {
        let [offset, bytes] = [tile.first, tile.n_rays].map(|n| (n * RESULT_BYTES[0]) as u64);
        encoder.copy_buffer_to_buffer(&results.device[0], 0, ids.buffer(), offset, Some(bytes));
        let submission = self.gpu.submit(encoder.finish());
        self.gpu.wait(submission, TILE_TIMEOUT).map_err(|reason| self.lost(&reason))?;
        self.gpu.check()?;
        Ok(Timing { trace: start.elapsed(), ..Timing::default() })
    }

    /// Reads the results of a tile back.
    fn read_tile(
        &self,
        results: &Results,
        mut encoder: wgpu::CommandEncoder,
        tile: &Tile,
        exponents: &[i32],
        start: Instant,
        hits: &mut Hits,
    ) -> Result<Timing> {
        let mut ranges = Vec::new();
        let mut offset = 0;
        for (buffer, bytes_per_ray) in results.device.iter().zip(RESULT_BYTES) {
            let bytes = (tile.n_rays * bytes_per_ray) as u64;
            encoder.copy_buffer_to_buffer(buffer, 0, &results.staging, offset, Some(bytes));
            ranges.push(offset as usize..(offset + bytes) as usize);
            offset += bytes;
        }
        self.gpu.submit(encoder.finish());
        let mapped = self.gpu.map(&results.staging, offset, TILE_TIMEOUT);
        self.gpu.check()?;
        let view = mapped.map_err(|reason| self.lost(&reason))?;
        let trace = start.elapsed();

        let start = Instant::now();
        {
            let place = tile.first..tile.first + tile.n_rays;
            hits.id[place.clone()].copy_from_slice(bytemuck::cast_slice(&view[ranges[0].clone()]));
            if ranges.len() > 1 {
                let ts: &[f32] = bytemuck::cast_slice(&view[ranges[1].clone()]);
                hits.t[place.clone()].copy_from_slice(ts);
                let normals = bytemuck::cast_slice(&view[ranges[2].clone()]);
                hits.normal[place.clone()].copy_from_slice(normals);
                for (t, exponent) in hits.t[place].iter_mut().zip(exponents) {
                    *t = (f64::from(*t) * 2f64.powi(-exponent)) as f32;
                }
            }
        }
        drop(view);
        results.staging.unmap();
        let readback = start.elapsed();
        let on_device =
            self.clock.as_ref().map(|clock| clock.read(&self.gpu, TILE_TIMEOUT)).transpose()?;
        Ok(Timing { trace, readback, on_device, ..Timing::default() })
    }

    fn lost(&self, reason: &str) -> Error {
        Error::Device(format!(
            "`{}` did not finish {} rays: {reason}; try `--device cpu`, or fewer objects",
            self.gpu.facts.name, self.tile_rays
        ))
    }

    fn write_params(&self, work: &Work, tile: &Tile) {
        let params = match self.key.float {
            Float::F64 => bytes(&self.params_double(work, tile)),
            Float::F32 => bytes(&self.params(work, tile)),
        };
        self.gpu.queue.write_buffer(&self.params, 0, &params);
        if let Some(surfaces) = &self.surfaces {
            let params = bytes(&self.params_double(work, tile));
            self.gpu.queue.write_buffer(&surfaces.params, 0, &params);
        }
        if let (Some(hierarchy), Some((_, first))) = (&self.hierarchy, work.first_pixel(tile)) {
            hierarchy.start_at(&self.gpu, first);
        }
    }

    fn params(&self, work: &Work, tile: &Tile) -> Params {
        let [offset_i, offset_j] = offsets(work, tile);
        let common = Params {
            n_spheres: self.prepared.scene.spheres.len() as u32,
            n_planes: self.prepared.scene.planes.len() as u32,
            infinity: f32::INFINITY,
            n_rays: tile.n_rays as u32,
            offset_i,
            offset_j,
            width: tile.width as u32,
            ..Params::default()
        };
        let Some((pixels, _)) = work.first_pixel(tile) else { return common };
        let camera = CameraF32::new(pixels);
        Params {
            forward: camera.forward.0,
            right_step: camera.right_step.0,
            true_up_step: camera.true_up_step.0,
            origin: self.prepared.coordinates().camera_origin().as_vec3().to_array(),
            ..common
        }
    }

    fn params_double(&self, work: &Work, tile: &Tile) -> ParamsDouble {
        let [offset_i, offset_j] = offsets(work, tile);
        let common = ParamsDouble {
            n_spheres: self.prepared.scene.spheres.len() as u32,
            n_planes: self.prepared.scene.planes.len() as u32,
            infinity: f64::INFINITY,
            n_rays: tile.n_rays as u32,
            offset_i,
            offset_j,
            width: tile.width as u32,
            ..ParamsDouble::default()
        };
        let Some((pixels, _)) = work.first_pixel(tile) else { return common };
        let camera = CameraF64::new(pixels);
        ParamsDouble {
            forward: camera.forward.0,
            right: camera.right.0,
            step: camera.step,
            true_up: camera.true_up.0,
            origin: self.prepared.coordinates().camera_origin().to_array(),
            ..common
        }
    }

    /// The exponents of the rays' scales, empty where they have none.
    fn upload_rays(&self, rays: &[Ray], buffer: &wgpu::Buffer) -> Vec<i32> {
        let (queue, coordinates) = (&self.gpu.queue, self.prepared.coordinates());
        if self.key.float == Float::F64 {
            let record = |ray: &Ray| match self.key.kernel {
                Kernel::Certified => certify::ray_record(ray),
                _ => coordinates.ray_record_double(ray),
            };
            let records: Vec<RayRecordDouble> = rays.iter().map(record).collect();
            queue.write_buffer(buffer, 0, bytemuck::cast_slice(&records));
            return Vec::new();
        }
        let (records, exponents): (Vec<RayRecord>, Vec<i32>) =
            rays.iter().map(|ray| coordinates.ray_record(ray)).unzip();
        queue.write_buffer(buffer, 0, bytemuck::cast_slice(&records));
        exponents
    }

    /// Sees to it that results for `n_rays` fit.
    fn make_room(&mut self, n_rays: usize, program: &Program) -> Result<()> {
        if self.results.as_ref().is_some_and(|results| results.n_rays >= n_rays) {
            return Ok(());
        }
        self.results = None;
        let device = &self.gpu.device;
        let buffer = |label, bytes_per_ray: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: (n_rays * bytes_per_ray) as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let results = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let n_proposed = if self.key.surface { RESULT_BYTES.len() } else { 1 };
        let n_results = if self.surfaces.is_some() { RESULT_BYTES.len() } else { n_proposed };
        let device_buffers: Vec<_> = ["ids", "ts", "normals"]
            .into_iter()
            .zip(RESULT_BYTES)
            .take(n_results)
            .map(|(label, bytes_per_ray)| buffer(label, bytes_per_ray, results))
            .collect();
        let bytes_per_ray = RESULT_BYTES.iter().take(n_results).sum();
        let staging_usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = buffer("staging", bytes_per_ray, staging_usage);
        let rays = (self.key.bundle == Bundle::Free || self.key.some).then(|| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            let bytes_per_ray = match self.key.float {
                _ if self.key.some => size_of::<[u32; 2]>(),
                Float::F64 => size_of::<RayRecordDouble>(),
                Float::F32 => size_of::<RayRecord>(),
            };
            buffer("rays", bytes_per_ray, usage)
        });
        let proposed = &device_buffers[..n_proposed];
        let buffers =
            std::iter::once(&self.params).chain(proposed).chain(&self.objects).chain(&rays);
        let resources = buffers
            .map(wgpu::Buffer::as_entire_binding)
            .chain(self.hierarchy.iter().flat_map(DeviceHierarchy::resources));
        let bind_group = bind_resources(device, &program.bind_group_layout, resources);
        let of_surfaces = self.surfaces.as_ref().map(|surfaces| {
            let Surfaces { program, params, objects } = surfaces;
            let buffers = std::iter::once(params).chain(&device_buffers).chain(objects);
            let resources = buffers.map(wgpu::Buffer::as_entire_binding);
            bind_resources(device, &program.bind_group_layout, resources)
        });
        self.gpu.check()?;
        let device = device_buffers;
        self.results = Some(Results { n_rays, device, staging, rays, bind_group, of_surfaces });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Arithmetic, Pick};
    use crate::prepare::FEW_SPHERES;
    use crate::rays::{Pixels, View};
    use crate::scene::{Camera, Projection, Scene, Sphere};
    use glam::DVec3;

    fn row_of_spheres(n: usize) -> Arc<Scene> {
        let sphere = |i| Sphere {
            center: DVec3::new(i as f64 - n as f64 / 2.0, 0.0, -(n as f64)),
            radius: 0.4,
        };
        Arc::new(Scene { spheres: (0..n).map(sphere).collect(), ..Scene::default() })
    }

    /// A picture of `n` spheres in a row.
    fn picture_of_spheres(n: usize) -> (Rays, Arc<Prepared>) {
        let camera = Camera {
            position: DVec3::ZERO,
            look_at: DVec3::NEG_Z,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_degrees: 60.0 },
        };
        let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 80, 60));
        let prepared = Prepared::new(row_of_spheres(n), Kernel::Certified, &rays).unwrap();
        (rays, Arc::new(prepared))
    }

    fn open() -> Gpu {
        Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one")
    }

    fn hits_of(gpu: Gpu, is_suited: bool, rays: &Rays, prepared: &Arc<Prepared>) -> Hits {
        let mut tracer =
            GpuTracer::new(Arc::new(gpu), Arc::clone(prepared), Wants::default()).unwrap();
        assert_eq!(tracer.cpu_fallback.is_none(), is_suited);
        let mut hits = Hits::default();
        tracer.trace(rays, &Control::default(), &mut hits).unwrap();
        hits
    }

    /// No device here orders sums anew, so one is told that it does.
    #[test]
    fn the_cpu_takes_over_from_arithmetic_that_does_not_suit_the_proof() {
        for n in [FEW_SPHERES, 2 * FEW_SPHERES] {
            let (rays, prepared) = picture_of_spheres(n);
            let trace = |is_suited: bool| {
                let gpu = open();
                let found = gpu.arithmetic().unwrap();
                assert!(found.suits_filter());
                let told = gpu.tell_arithmetic(Arithmetic { no_contraction: is_suited, ..found });
                hits_of(told, is_suited, &rays, &prepared)
            };
            let (on_device, on_cpu) = (trace(true), trace(false));
            assert_eq!(on_device.id, on_cpu.id);
            assert!(on_cpu.n_hits() > 40);
        }
    }

    /// Where shaders can't be passed through, nothing forbids the driver to rearrange them. No
    /// adapter here is so, and one is told that it is.
    #[test]
    fn the_cpu_takes_over_without_passthrough() {
        let (rays, prepared) = picture_of_spheres(FEW_SPHERES);
        let [with, without] = [true, false].map(|passthrough| {
            let mut gpu = open();
            gpu.facts.passthrough = passthrough;
            let arithmetic = gpu.arithmetic().unwrap();
            assert_eq!(arithmetic.passthrough, passthrough);
            assert_eq!(arithmetic.suits_filter(), passthrough, "{arithmetic}");
            assert!(passthrough || !arithmetic.is_ieee());
            hits_of(gpu, passthrough, &rays, &prepared)
        });
        assert_eq!(with.id, without.id);
    }
}
