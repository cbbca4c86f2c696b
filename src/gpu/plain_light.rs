//! Shading as kernels without a proof do: the light on what the rays of a picture hit.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytemuck::{Pod, Zeroable};

use super::compile::{MOST_TURNS_IN_SOFTWARE, keeps_objects, turns_of_ray};
use super::objects::{bytes, params_buffer};
use super::open::Gpu;
use super::pipeline::{Named, whole};
use super::program::Program;
use super::tiles::{Tile, TileSize};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::kernel::Float;
use crate::prepare::{Lamps, PlainLamp, PlainLighting, Prepared};
use crate::rays::Pixels;
use crate::trace::Rays;

/// A dispatch that takes longer than this is given up.
const TILE_TIMEOUT: Duration = Duration::from_secs(60);

/// Objects times lamps up to which one ray takes less than a second or so.
const MOST_TESTS_OF_RAY: usize = 1 << 24;

/// Lights the pictures of one scene.
pub struct PlainLight {
    /// What it was made for.
    lighting: PlainLighting,
    float: Float,
    program: Arc<Program>,
    params: wgpu::Buffer,
    /// The spheres and the planes.
    objects: Vec<Named>,
    of_all: wgpu::Buffer,
    lamps: wgpu::Buffer,
    room: Option<Room>,
    tile_size: TileSize,
}

/// The buffers whose size depends on the tile's.
struct Room {
    n_rays: usize,
    lights: wgpu::Buffer,
    staging: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl PlainLight {
    /// Whether a device lights this: one in software only where it is quicker than the CPU, which is where it
    /// has lamps and objects at hand.
    pub fn is_wanted(gpu: &Gpu, prepared: &Prepared, lighting: &PlainLighting) -> bool {
        let key = prepared.plain_light_key(lighting.list());
        let n_lamps = lighting.lamps.len();
        let n_tests = prepared.scene.n_objects().saturating_mul(n_lamps);
        let n_turns = (turns_of_ray(&key) + 1).saturating_mul(n_lamps + 1);
        let are_at_hand = lighting.list() == Lamps::Few && keeps_objects(&key);
        n_tests <= MOST_TESTS_OF_RAY
            && (n_turns <= MOST_TURNS_IN_SOFTWARE || !gpu.facts.is_software())
            && gpu.shades_plainly(are_at_hand)
    }

    /// Whether this was made for such light.
    pub fn is_for(&self, lighting: &PlainLighting) -> bool {
        self.lighting == *lighting
    }

    /// Compiles the shader. `objects` are the buffers of the spheres and the planes.
    ///
    /// # Errors
    /// [`Error::Shader`] when the device refuses the shader, [`Error::TooLarge`] when it binds too few
    /// buffers at once, [`Error::Device`] when it fails.
    pub fn new(
        gpu: &Gpu,
        prepared: &Prepared,
        objects: &[Named],
        lighting: &PlainLighting,
    ) -> Result<PlainLight> {
        let key = prepared.plain_light_key(lighting.list());
        let float = prepared.kernel.about().float;
        let program = gpu.program(&key)?;
        let buffer = |label, bytes: &[u8], usage| {
            let buffer = gpu.buffer(label, bytes.len(), usage | wgpu::BufferUsages::COPY_DST);
            gpu.queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let usage = match lighting.list() {
            Lamps::Few => wgpu::BufferUsages::UNIFORM,
            Lamps::Many => wgpu::BufferUsages::STORAGE,
        };
        let of_all = buffer("light of all", &of_all(lighting, float), wgpu::BufferUsages::UNIFORM);
        let lamps = buffer("lamps", &lamps(lighting, float), usage);
        let params = params_buffer(gpu, prepared.kernel);
        gpu.check()?;
        Ok(PlainLight {
            lighting: lighting.clone(),
            float,
            program,
            params,
            objects: objects.to_vec(),
            of_all,
            lamps,
            room: None,
            tile_size: TileSize::first(prepared),
        })
    }

    /// Bytes on the device, beside the objects.
    pub fn bytes(&self) -> u64 {
        let room = self.room.as_ref().map_or(0, |room| room.lights.size() + room.staging.size());
        self.params.size() + self.of_all.size() + self.lamps.size() + room
    }

    /// See [`Tracer::light_plainly`](crate::tracer::Tracer::light_plainly).
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails, [`Error::Interrupted`].
    pub fn light(
        &mut self,
        gpu: &Gpu,
        prepared: &Prepared,
        samples: &Pixels,
        control: &Control,
        lights: &mut Vec<[f64; 3]>,
    ) -> Result<()> {
        let rays = Rays::Pixels(*samples);
        prepared.check(&rays)?;
        lights.clear();
        lights.reserve(rays.len());
        while lights.len() < rays.len() {
            control.check()?;
            let start = Instant::now();
            let tile = Tile::new(&rays, lights.len(), self.tile_size.0);
            self.light_tile(gpu, prepared, &rays, &tile, lights)?;
            self.tile_size.adapt(tile.n_rays, start.elapsed());
        }
        Ok(())
    }

    fn light_tile(
        &mut self,
        gpu: &Gpu,
        prepared: &Prepared,
        rays: &Rays,
        tile: &Tile,
        lights: &mut Vec<[f64; 3]>,
    ) -> Result<()> {
        let room = match self.room.take().filter(|room| room.n_rays >= tile.n_rays) {
            Some(room) => room,
            None => self.make_room(gpu, tile.n_rays)?,
        };
        let params = match self.float {
            Float::F32 => bytes(&tile.params(prepared, rays)),
            Float::F64 => bytes(&tile.params_double(prepared, rays)),
        };
        gpu.queue.write_buffer(&self.params, 0, &params);
        let mut encoder = gpu.encoder();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.program.pipeline);
        pass.set_bind_group(0, &room.bind_group, &[]);
        let [x, y] = tile.workgroups();
        pass.dispatch_workgroups(x, y, 1);
        drop(pass);
        let n_bytes = (tile.n_rays * self.bytes_of_ray()) as u64;
        encoder.copy_buffer_to_buffer(&room.lights, 0, &room.staging, 0, Some(n_bytes));
        gpu.submit(encoder.finish());
        let mapped = gpu.map(&room.staging, n_bytes, TILE_TIMEOUT);
        gpu.check()?;
        let view = mapped.map_err(|reason| {
            let name = &gpu.facts.name;
            Error::Device(format!(
                "`{name}` did not light what {} rays hit: {reason}; try `--device cpu`, or fewer lights",
                tile.n_rays
            ))
        })?;
        match self.float {
            Float::F32 => {
                let found: &[[f32; 3]] = bytemuck::cast_slice(&view);
                lights.extend(found.iter().map(|light| light.map(f64::from)));
            }
            Float::F64 => lights.extend_from_slice(bytemuck::cast_slice(&view)),
        }
        drop(view);
        room.staging.unmap();
        self.room = Some(room);
        Ok(())
    }

    fn bytes_of_ray(&self) -> usize {
        match self.float {
            Float::F32 => size_of::<[f32; 3]>(),
            Float::F64 => size_of::<[f64; 3]>(),
        }
    }

    /// Room for a tile of so many rays.
    fn make_room(&self, gpu: &Gpu, n_rays: usize) -> Result<Room> {
        use wgpu::BufferUsages as Usage;
        let n_bytes = n_rays * self.bytes_of_ray();
        let lights = gpu.buffer("lights", n_bytes, Usage::STORAGE | Usage::COPY_SRC);
        let staging = gpu.buffer("staging", n_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let buffers = [
            ("params", &self.params),
            ("lights", &lights),
            ("lighting", &self.of_all),
            ("lamps", &self.lamps),
        ];
        let buffers = buffers.map(|(name, buffer)| (name, buffer.as_entire_binding()));
        let resources = buffers.into_iter().chain(self.objects.iter().map(whole));
        let bind_group = self.program.bindings.bind(&gpu.device, resources)?;
        gpu.check()?;
        Ok(Room { n_rays, lights, staging, bind_group })
    }
}

/// `Lighting` in `shaders/plain_light.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LightingF32 {
    pub ambient: [f32; 3],
    pub epsilon: f32,
    pub n_lamps: u32,
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: [u32; 3],
}

/// The same for the kernel `double`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LightingF64 {
    pub ambient: [f64; 3],
    pub epsilon: f64,
    pub n_lamps: u32,
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding: [u32; 7],
}

/// `Lamp` in `shaders/plain_light.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LampF32 {
    pub at: [f32; 3],
    pub kind: u32,
    pub weight: [f32; 3],
    pub shadows: u32,
}

/// The same for the kernel `double`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LampF64 {
    pub at: [f64; 3],
    pub kind: u32,
    /// Fills WGSL's 32-byte alignment of a vector.
    pub padding: u32,
    pub weight: [f64; 3],
    pub shadows: u32,
    /// Fills it again.
    pub padding_again: u32,
}

fn of_all(lighting: &PlainLighting, float: Float) -> Vec<u8> {
    let &PlainLighting { ambient, epsilon, .. } = lighting;
    let n_lamps = lighting.lamps.len() as u32;
    match float {
        Float::F32 => bytes(&LightingF32 {
            ambient: ambient.map(|part| part as f32),
            epsilon: epsilon as f32,
            n_lamps,
            ..LightingF32::default()
        }),
        Float::F64 => bytes(&LightingF64 { ambient, epsilon, n_lamps, ..LightingF64::default() }),
    }
}

/// The lamps; few of them come with zeros up to their greatest number.
fn lamps(lighting: &PlainLighting, float: Float) -> Vec<u8> {
    let n = match lighting.list() {
        Lamps::Few => PlainLighting::FEW_LAMPS,
        Lamps::Many => lighting.lamps.len(),
    };
    match float {
        Float::F32 => list(n, &lighting.lamps, |lamp| LampF32 {
            at: lamp.at.map(|part| part as f32),
            kind: lamp.kind,
            weight: lamp.weight.map(|part| part as f32),
            shadows: lamp.shadows.into(),
        }),
        Float::F64 => list(n, &lighting.lamps, |lamp| LampF64 {
            at: lamp.at,
            kind: lamp.kind,
            weight: lamp.weight,
            shadows: lamp.shadows.into(),
            ..LampF64::default()
        }),
    }
}

fn list<T: Pod>(n: usize, lamps: &[PlainLamp], record: impl Fn(&PlainLamp) -> T) -> Vec<u8> {
    let mut records: Vec<T> = lamps.iter().map(record).collect();
    records.resize(n, T::zeroed());
    bytemuck::cast_slice(&records).to_vec()
}
