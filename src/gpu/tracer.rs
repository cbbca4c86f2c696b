//! A scene and its kernel on a device: made, and run tile by tile.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::clock::Clock;
use super::compile::{MOST_TURNS_IN_SOFTWARE, turns_of_ray};
use super::hierarchy::DeviceHierarchy;
use super::layout::{Params, ParamsDouble};
#[cfg(feature = "view")]
use super::live::Words;
use super::objects::{bytes, check_limits, check_memory, object_bytes, params_buffer, storage};
use super::open::Gpu;
use super::pipeline::{Named, whole};
use super::plain_light::PlainLight;
use super::program::Program;
use super::results::Results;
use super::tiles::{Tile, TileSize};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::kernel::coordinates::{RayRecord, RayRecordDouble};
use crate::kernel::{Float, Kernel};
use crate::prepare::{PlainLighting, Prepared, ShaderKey};
use crate::rays::Pixels;
use crate::trace::{Hits, Ray, Rays, Timing, Wants};
use crate::tracer::Backend;

/// A dispatch that takes longer than this is given up.
const TILE_TIMEOUT: Duration = Duration::from_secs(60);

/// Traces on a Vulkan device.
pub struct GpuTracer {
    gpu: Arc<Gpu>,
    prepared: Arc<Prepared>,
    wants: Wants,
    key: ShaderKey,
    /// None before it is needed.
    program: Option<Arc<Program>>,
    params: wgpu::Buffer,
    objects: Vec<Named>,
    hierarchy: Option<DeviceHierarchy>,
    room: Option<Room>,
    tile_size: TileSize,
    clock: Option<Clock>,
    /// Whether the device can't take the kernel's stage: its arithmetic doesn't suit the proof of `certified`, there
    /// is no way to the rays' many spheres, or it would stop on the way through a long list of them.
    leaves_to_cpu: bool,
    /// Lights what rays of a kernel without a proof hit, made when that is first needed.
    plain_light: Option<Box<PlainLight>>,
    /// Time to put together and compile the shader.
    pub compile_time: Duration,
    /// Time to hand the scene to the device.
    pub upload_time: Duration,
}

/// Results with the bind groups that name them.
struct Room {
    results: Results,
    bind_group: wgpu::BindGroup,
}

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
        let start = Instant::now();
        let objects = storage(&gpu, prepared.objects.bytes());
        let hierarchy = DeviceHierarchy::new(&gpu, &prepared)?;
        let upload_time = start.elapsed();

        let leaves_to_cpu = leaves_to_cpu(&gpu, &prepared, hierarchy.as_ref(), wants)?;
        let key = prepared.shader_key(wants);
        let start = Instant::now();
        // Where nothing is proposed, no shader is needed.
        let needs_none = prepared.starts_in_f64() || leaves_to_cpu;
        let program = if needs_none { None } else { Some(gpu.program(&key)?) };
        let params = params_buffer(&gpu, prepared.kernel);
        gpu.check()?;
        let tile_size = TileSize::first(&prepared);
        let mut tracer = GpuTracer {
            gpu,
            prepared,
            wants,
            key,
            program,
            params,
            objects,
            hierarchy,
            room: None,
            tile_size,
            clock: None,
            leaves_to_cpu,
            plain_light: None,
            compile_time: Duration::ZERO,
            upload_time,
        };
        tracer.warm_up()?;
        tracer.compile_time = start.elapsed();
        Ok(tracer)
    }
}

fn leaves_to_cpu(
    gpu: &Gpu,
    prepared: &Prepared,
    hierarchy: Option<&DeviceHierarchy>,
    wants: Wants,
) -> Result<bool> {
    let has_no_way = prepared.hierarchy.is_some() && hierarchy.is_none();
    let is_stopped = gpu.facts.is_software()
        && turns_of_ray(&prepared.shader_key(wants)) > MOST_TURNS_IN_SOFTWARE;
    Ok(is_stopped
        || prepared.kernel == Kernel::Certified
            && (has_no_way || !gpu.arithmetic()?.suits_filter()))
}

/// Where a device's results go.
enum Target<'a> {
    /// To the host.
    Hits(&'a mut Hits),
    /// The ids alone, elsewhere on the device.
    #[cfg(feature = "view")]
    Resident(&'a Words),
}

impl Backend for GpuTracer {
    fn propose(
        &mut self,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<Option<Timing>> {
        match self.leaves_to_cpu {
            true => Ok(None),
            false => self.propose_into(rays, control, Target::Hits(hits)).map(Some),
        }
    }

    #[cfg(feature = "view")]
    fn propose_resident(&mut self, rays: &Rays, control: &Control, ids: &Words) -> Result<bool> {
        if self.leaves_to_cpu {
            return Ok(false);
        }
        self.propose_into(rays, control, Target::Resident(ids))?;
        self.gpu.check().map(|()| true)
    }

    fn light_plainly(
        &mut self,
        lighting: &PlainLighting,
        samples: &Pixels,
        control: &Control,
        lights: &mut Vec<[f64; 3]>,
    ) -> Result<bool> {
        let GpuTracer { gpu, prepared, objects, plain_light: kept, leaves_to_cpu, .. } = self;
        if *leaves_to_cpu || !PlainLight::is_wanted(gpu, prepared, lighting) {
            return Ok(false);
        }
        let made = match kept.take().filter(|made| made.is_for(lighting)) {
            Some(made) => made,
            None => match PlainLight::new(gpu, prepared, objects, lighting) {
                // The device binds too few buffers at once, or has too little room.
                Err(Error::TooLarge(_)) => return Ok(false),
                made => Box::new(made?),
            },
        };
        kept.insert(made).light(gpu, prepared, samples, control, lights)?;
        Ok(true)
    }

    /// All that may fail comes first, so that a tracer that can't be retargeted stays what it was. A moved camera
    /// costs no new shader.
    fn retarget(&mut self, prepared: &Arc<Prepared>) -> Result<()> {
        self.gpu.facts.check_kernel(prepared.kernel)?;
        check_limits(&self.gpu, prepared)?;
        check_memory(&self.gpu, prepared)?;
        let hierarchy = DeviceHierarchy::new(&self.gpu, prepared)?;
        let leaves_to_cpu = leaves_to_cpu(&self.gpu, prepared, hierarchy.as_ref(), self.wants)?;
        let key = prepared.shader_key(self.wants);
        let is_new = key != self.key;
        let program = match is_new && !leaves_to_cpu {
            true => Some(self.gpu.program(&key)?),
            false => None,
        };
        let of_new = is_new.then(|| {
            let params = params_buffer(&self.gpu, prepared.kernel);
            (params, storage(&self.gpu, prepared.objects.bytes()))
        });
        self.gpu.check()?;
        match of_new {
            Some((params, objects)) => {
                (self.program, self.params, self.objects) = (program, params, objects);
                self.tile_size = TileSize::first(prepared);
            }
            None => {
                let bytes = object_bytes(prepared.objects.bytes());
                for ((_, buffer), (_, bytes)) in self.objects.iter().zip(bytes) {
                    self.gpu.queue.write_buffer(buffer, 0, bytes);
                }
            }
        }
        if is_new || hierarchy.is_some() {
            self.room = None;
        }
        self.key = key;
        self.leaves_to_cpu = leaves_to_cpu;
        self.plain_light = None;
        self.hierarchy = hierarchy;
        self.prepared = Arc::clone(prepared);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        self.objects.iter().map(|(_, buffer)| buffer.size()).sum::<u64>()
            + self.hierarchy.as_ref().map_or(0, DeviceHierarchy::bytes)
            + self.params.size()
            + self.room.as_ref().map_or(0, |room| room.results.bytes())
            + self.plain_light.as_ref().map_or(0, |light| light.bytes())
    }

    fn use_clock(&mut self) {
        self.clock = Clock::new(&self.gpu);
    }
}

impl GpuTracer {
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
        let mut timing = Timing::default();
        let mut first = 0;
        while first < rays.len() {
            control.check()?;
            let tile = Tile::new(rays, first, self.tile_size.0);
            let start = Instant::now();
            let spent = self.trace_tile(rays, &tile, &mut target)?;
            timing.add(spent);
            self.tile_size.adapt(tile.n_rays, start.elapsed());
            first += tile.n_rays;
            control.advance(tile.n_rays as u64);
        }
        Ok(timing)
    }

    fn dispatch(&self, room: &Room, program: &Program, [x, y]: [u32; 2]) -> wgpu::CommandEncoder {
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        let mut encoder = self.gpu.device.create_command_encoder(&descriptor);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.clock.as_ref().map(Clock::around_pass),
        });
        pass.set_pipeline(&program.pipeline);
        pass.set_bind_group(0, &room.bind_group, &[]);
        pass.dispatch_workgroups(x, y, 1);
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
        let room = self.make_room(64, &program)?;
        let params = match self.float() {
            Float::F64 => bytes(&ParamsDouble { n_rays: 1, ..ParamsDouble::default() }),
            Float::F32 => bytes(&Params { n_rays: 1, ..Params::default() }),
        };
        self.gpu.queue.write_buffer(&self.params, 0, &params);
        self.gpu.submit(self.dispatch(&room, &program, [1, 1]).finish());
        self.room = Some(room);
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(TILE_TIMEOUT) };
        self.gpu.device.poll(wait).map_err(|error| self.lost(&error.to_string()))?;
        self.gpu.check()
    }

    fn trace_tile(&mut self, rays: &Rays, tile: &Tile, target: &mut Target) -> Result<Timing> {
        let program = match &self.program {
            Some(program) => Arc::clone(program),
            None => Arc::clone(self.program.insert(self.gpu.program(&self.key)?)),
        };
        let room = match self.room.take().filter(|room| room.results.n_rays >= tile.n_rays) {
            Some(room) => room,
            None => self.make_room(tile.n_rays, &program)?,
        };
        let start = Instant::now();
        self.write_params(rays, tile);
        let mut exponents = Vec::new();
        if let (Some((_, buffer)), Rays::List(rays)) = (&room.results.rays, rays) {
            exponents = self.upload_rays(&rays[tile.first..][..tile.n_rays], buffer);
        }
        let encoder = self.dispatch(&room, &program, tile.workgroups());
        let timing = match target {
            Target::Hits(hits) => self.read_tile(&room, encoder, tile, &exponents, start, hits),
            #[cfg(feature = "view")]
            Target::Resident(ids) => self.keep_tile(&room, encoder, tile, start, ids),
        }?;
        self.room = Some(room);
        Ok(timing)
    }

    #[cfg(feature = "view")]
    fn keep_tile(
        &self,
        room: &Room,
        mut encoder: wgpu::CommandEncoder,
        tile: &Tile,
        start: Instant,
        ids: &Words,
    ) -> Result<Timing> {
        room.results.keep(&mut encoder, tile, ids.buffer());
        let submission = self.gpu.submit(encoder.finish());
        self.gpu.wait(submission, TILE_TIMEOUT).map_err(|reason| self.lost(&reason))?;
        self.gpu.check()?;
        Ok(Timing { trace: start.elapsed(), ..Timing::default() })
    }

    fn read_tile(
        &self,
        room: &Room,
        mut encoder: wgpu::CommandEncoder,
        tile: &Tile,
        exponents: &[i32],
        start: Instant,
        hits: &mut Hits,
    ) -> Result<Timing> {
        room.results.stage(&mut encoder, tile);
        self.gpu.submit(encoder.finish());
        let mapped = room.results.map(&self.gpu, tile, TILE_TIMEOUT);
        self.gpu.check()?;
        let view = mapped.map_err(|reason| self.lost(&reason))?;
        let trace = start.elapsed();

        let start = Instant::now();
        room.results.store(view, tile, exponents, hits);
        let readback = start.elapsed();
        let on_device =
            self.clock.as_ref().map(|clock| clock.read(&self.gpu, TILE_TIMEOUT)).transpose()?;
        Ok(Timing { trace, readback, on_device, ..Timing::default() })
    }

    fn lost(&self, reason: &str) -> Error {
        Error::Device(format!(
            "`{}` did not finish {} rays: {reason}; try `--device cpu`, or fewer objects",
            self.gpu.facts.name, self.tile_size.0
        ))
    }

    fn write_params(&self, rays: &Rays, tile: &Tile) {
        let params = match self.float() {
            Float::F64 => bytes(&tile.params_double(&self.prepared, rays)),
            Float::F32 => bytes(&tile.params(&self.prepared, rays)),
        };
        self.gpu.queue.write_buffer(&self.params, 0, &params);
    }

    fn float(&self) -> Float {
        self.prepared.kernel.about().float
    }

    fn upload_rays(&self, rays: &[Ray], buffer: &wgpu::Buffer) -> Vec<i32> {
        let (queue, coordinates) = (&self.gpu.queue, self.prepared.coordinates());
        if self.float() == Float::F64 {
            let record = |ray| coordinates.ray_record_double(ray);
            let records: Vec<RayRecordDouble> = rays.iter().map(record).collect();
            queue.write_buffer(buffer, 0, bytemuck::cast_slice(&records));
            return Vec::new();
        }
        let (records, exponents): (Vec<RayRecord>, Vec<i32>) =
            rays.iter().map(|ray| coordinates.ray_record(ray)).unzip();
        queue.write_buffer(buffer, 0, bytemuck::cast_slice(&records));
        exponents
    }

    /// Room for the results of `n_rays`.
    fn make_room(&self, n_rays: usize, program: &Program) -> Result<Room> {
        let device = &self.gpu.device;
        let results = Results::new(&self.gpu, n_rays, &self.key);
        let buffers = results.device.iter().chain(&self.objects).chain(&results.rays);
        let resources = [("params", self.params.as_entire_binding())]
            .into_iter()
            .chain(buffers.map(whole))
            .chain(self.hierarchy.iter().flat_map(DeviceHierarchy::resources));
        let bind_group = program.bindings.bind(device, resources)?;
        self.gpu.check()?;
        Ok(Room { results, bind_group })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Arithmetic, Pick};
    use crate::prepare::FEW_SPHERES;
    use crate::rays::{Pixels, View};
    use crate::scene::{Camera, Projection, Scene, Sphere};
    use crate::tracer::Tracer;
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
        let wants = Wants::default();
        let backend = GpuTracer::new(Arc::new(gpu), Arc::clone(prepared), wants).unwrap();
        assert_eq!(backend.leaves_to_cpu, !is_suited);
        traced(&mut Tracer::on(backend, Arc::clone(prepared), wants), rays)
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

    /// A ball before a plane, and what is seen of them with `t` and normals.
    fn ball_and_plane(n_balls: usize) -> (Rays, Arc<Prepared>) {
        let balls = "{ center = [0, 0, -4], radius = 1, color = \"#d62728\" }, ".repeat(n_balls);
        let text = format!(
            "camera = {{ position = [0, 1, 0], look_at = [0, 0, -4] }}\nsphere = [{balls}]\n\
             plane = [{{ point = [0, -1, 0], normal = [0, 1, 0], color = \"#8c8c8c\" }}]\n"
        );
        let scene = crate::scene::parse_scene(&text, "ball.toml".as_ref()).unwrap();
        let rays = Rays::Pixels(Pixels::whole(View::new(scene.camera.as_ref().unwrap()), 40, 30));
        let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
        (rays, Arc::new(prepared))
    }

    fn traced(tracer: &mut Tracer, rays: &Rays) -> Hits {
        let mut hits = Hits::default();
        tracer.trace(rays, &Control::default(), &mut hits).unwrap();
        hits
    }

    /// The name of a buffer tells what it is, not its place; a wrong name is seen.
    #[test]
    fn buffers_of_one_kind_cannot_be_swapped() {
        let (rays, prepared) = ball_and_plane(1);
        let wants = Wants { surface: true, level: false };
        let mut tracer = GpuTracer::new(Arc::new(open()), Arc::clone(&prepared), wants).unwrap();
        let mut propose = |objects: fn(&mut Vec<Named>)| {
            objects(&mut tracer.objects);
            tracer.room = None;
            let mut hits = Hits::default();
            tracer.propose(&rays, &Control::default(), &mut hits).map(|_| hits.id)
        };
        let expected = propose(|_| {}).unwrap();
        assert!([0, 1, 2].iter().all(|id| expected.contains(id)));
        assert_eq!(propose(|objects| objects.reverse()).unwrap(), expected);
        let swapped = propose(|objects| {
            let [(a, _), (b, _)] = objects.as_mut_slice() else { panic!("spheres and planes") };
            std::mem::swap(a, b);
        });
        assert_ne!(swapped.unwrap(), expected);
        let missing = propose(|objects| objects.truncate(1)).unwrap_err();
        assert!(matches!(missing, Error::Shader(_)), "{missing}");
    }

    /// The shader is refused for the second scene, after all else is made.
    #[test]
    fn a_tracer_that_cannot_be_retargeted_stays_what_it_was() {
        use std::sync::atomic::{AtomicBool, Ordering};
        let is_refused = Arc::new(AtomicBool::new(false));
        let refused = Arc::clone(&is_refused);
        let gpu = open().edit_shaders(move |wgsl| match refused.load(Ordering::Relaxed) {
            true => "no shader".into(),
            false => wgsl.into(),
        });
        let (rays, prepared) = ball_and_plane(1);
        let wants = Wants { surface: true, level: false };
        let backend = GpuTracer::new(Arc::new(gpu), Arc::clone(&prepared), wants).unwrap();
        let mut tracer = Tracer::on(backend, prepared, wants);
        let expected = traced(&mut tracer, &rays);
        is_refused.store(true, Ordering::Relaxed);
        let (others, other) = ball_and_plane(3);
        let error = tracer.retarget(Arc::clone(&other)).unwrap_err();
        assert!(matches!(error, Error::Shader(_)), "{error}");
        assert!(traced(&mut tracer, &rays) == expected);
        is_refused.store(false, Ordering::Relaxed);
        tracer.retarget(other).unwrap();
        // The plane comes behind all balls.
        let ids = expected.id.iter().map(|&id| if id == 2 { 4 } else { id });
        assert!(traced(&mut tracer, &others).id.into_iter().eq(ids));
    }
}
