//! Shading: the colours of pixels whose samples' objects are known, bytes in f32 first, and in f64 what that leaves open.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::before::{self, InF64};
use super::before::{LightInF32, LightInF64};
use super::compile::WORKGROUP;
use super::hierarchy::{DeviceHierarchy, uniform};
use super::layout::{Params, ParamsDouble};
use super::objects::{bytes, params_buffer, storage_in_f64};
use super::open::Gpu;
use super::pipeline::{Named, whole};
use super::program::Program;
use crate::control::Control;
use crate::error::Result;
use crate::kernel::Float;
use crate::memory;
use crate::prepare::{LightKey, Prepared};
use crate::rays::{CameraF32, CameraF64, Pixels};
use crate::trace::StageCounts;
use crate::tracer::ProposedColors;
use crate::tree::BoxOnDevice;

/// Aim for the time of a dispatch, as for that of rays.
const TILE_TARGET: Duration = Duration::from_millis(75);

/// A dispatch that takes longer than this is given up.
const TILE_TIMEOUT: Duration = Duration::from_secs(60);

/// Most samples of one dispatch; bounds the memory for their ids.
const MOST_SAMPLES: usize = 1 << 20;

/// Most ways to lamps of one dispatch: they are counted in 32 bits.
const MOST_WAYS: usize = 1 << 31;

/// Ways of the first dispatch, before anything is known about the device.
const FIRST_WAYS: usize = 1 << 14;

/// Words of the shader's `n_ways`.
const COUNTS: usize = 3;

/// Storage buffers of the shader in f64, which has the most; of a scene that has no use for some it binds fewer.
const N_STORAGE_BUFFERS: u32 = 14;

/// Shades one scene.
pub struct DeviceLight {
    /// What it was made for.
    pub key: LightKey,
    /// Ways to lamps, at least 1.
    n_ways_of_pixel: usize,
    /// In the order in which they look at a pixel.
    stages: Vec<Stage>,
    n_ways: wgpu::Buffer,
    room: Option<Room>,
    /// Pixels of a dispatch.
    n_tile_pixels: usize,
}

/// A shader with what it sees of the scene.
struct Stage {
    float: Float,
    program: Arc<Program>,
    params: wgpu::Buffer,
    objects: Vec<Named>,
}

/// The buffers whose size depends on the tile's.
struct Room {
    n_pixels: usize,
    ids: wgpu::Buffer,
    colors: wgpu::Buffer,
    staging: wgpu::Buffer,
    /// One for each stage.
    bind_groups: Vec<wgpu::BindGroup>,
}

/// What the stages share.
struct Shared {
    narrow: wgpu::Buffer,
    listed: wgpu::Buffer,
    boxes: Option<wgpu::Buffer>,
}

/// Consecutive pixels of one dispatch: whole rows, or a part of one.
#[derive(Clone, Copy)]
struct Tile {
    /// Index of its first pixel.
    first: usize,
    width: usize,
    height: usize,
}

impl DeviceLight {
    /// Whether a device has the bindings and the room for the light of a scene.
    pub fn fits(gpu: &Gpu, prepared: &Prepared) -> bool {
        let n_boxes = prepared.hierarchy.as_ref().map_or(0, |hierarchy| hierarchy.tree.n_nodes());
        let bytes = (n_boxes * size_of::<BoxOnDevice>())
            .max(size_of_val(&prepared.scene.spheres[..]))
            .max((prepared.scene.n_objects() + 1) * 32);
        let most = gpu.facts.max_binding_bytes.min(gpu.facts.max_buffer_bytes);
        gpu.facts.max_storage_buffers >= N_STORAGE_BUFFERS && bytes as u64 <= most
    }

    /// Compiles the shaders and uploads the scene; `None` where there is nothing that the device can do of these
    /// colours. It has f64 where `has_f64`.
    ///
    /// # Errors
    /// [`Error::Shader`] when the device refuses a shader, [`Error::TooLarge`] where there is no memory
    /// to hand the scene over, [`Error::Device`] when the device fails.
    pub fn new(
        gpu: &Gpu,
        prepared: &Prepared,
        hierarchy: Option<&DeviceHierarchy>,
        (key, has_f64): (LightKey, bool),
        light: &LightInF64,
    ) -> Result<Option<DeviceLight>> {
        let of_f32 = light.in_f32.as_ref().map_or(0, |light| {
            size_of_val(&light.palette[..]) + size_of_val(&light.seen_spheres[..])
        });
        let of_f64 = size_of_val(&light.palette[..]) + size_of_val(&prepared.scene.spheres[..]);
        let of_f64 = if has_f64 { of_f64 } else { 0 };
        let bytes = size_of_val(&light.narrow[..]) + of_f32 + of_f64;
        let what = format!("handing the scene's light to `{}`", gpu.facts.name);
        memory::require(what, bytes as u64, "use fewer objects, or `--device cpu`")?;
        let shared = Shared::new(gpu, prepared, light);
        let mut stages = Vec::new();
        if let Some(light) = &light.in_f32 {
            stages.push(Stage::in_f32(gpu, prepared, &shared, key, light)?);
        }
        if has_f64 {
            stages.push(Stage::in_f64(gpu, prepared, hierarchy, &shared, key, light)?);
        }
        if stages.is_empty() {
            return Ok(None);
        }
        let of_count = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC;
        let n_ways_of_pixel = light.lamps.len().max(1) * (key.n_samples as usize).pow(2);
        gpu.check()?;
        Ok(Some(DeviceLight {
            key,
            n_ways_of_pixel,
            stages,
            n_ways: gpu.buffer("ways", COUNTS * size_of::<u32>(), of_count),
            room: None,
            n_tile_pixels: (FIRST_WAYS / n_ways_of_pixel).max(WORKGROUP[0] as usize),
        }))
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let room = self
            .room
            .as_ref()
            .map_or(0, |room| room.ids.size() + room.colors.size() + room.staging.size());
        let mut buffers: Vec<&wgpu::Buffer> = vec![&self.n_ways];
        for buffer in self
            .stages
            .iter()
            .flat_map(|stage| stage.objects.iter().map(|(_, buffer)| buffer).chain([&stage.params]))
        {
            // The stages share some.
            if !buffers.contains(&buffer) {
                buffers.push(buffer);
            }
        }
        buffers.into_iter().map(wgpu::Buffer::size).sum::<u64>() + room
    }

    /// See [`ProposeColors::propose_colors`](crate::tracer::ProposeColors::propose_colors).
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails, [`Error::Interrupted`].
    pub fn propose(
        &mut self,
        gpu: &Gpu,
        prepared: &Prepared,
        samples: &Pixels,
        ids: &[u32],
        control: &Control,
        colors: &mut Vec<u32>,
    ) -> Result<ProposedColors> {
        let n = self.key.n_samples as usize;
        let (columns, rows) = (samples.width as usize / n, samples.height as usize / n);
        let n_pixels = columns * rows;
        colors.clear();
        colors.reserve(n_pixels * self.key.words.per_pixel());
        let (mut proposed, mut first) = (ProposedColors::default(), 0);
        while first < n_pixels {
            control.check()?;
            let start = Instant::now();
            let tile = self.tile(first, columns, rows);
            first += tile.width * tile.height;
            proposed.add(self.propose_tile(gpu, prepared, samples, ids, tile, colors)?);
            self.adapt(tile.width * tile.height, start.elapsed());
        }
        Ok(proposed)
    }

    fn tile(&self, first: usize, columns: usize, rows: usize) -> Tile {
        let (row, column) = (first / columns, first % columns);
        if column > 0 || self.n_tile_pixels < columns {
            return Tile { first, width: self.n_tile_pixels.min(columns - column), height: 1 };
        }
        let height = (self.n_tile_pixels / columns).min(rows - row);
        Tile { first, width: columns, height }
    }

    /// Moves the tile's size toward the target time.
    fn adapt(&mut self, n_pixels: usize, spent: Duration) {
        let ratio = TILE_TARGET.as_secs_f64() / spent.as_secs_f64().max(1e-6);
        let wanted = (n_pixels as f64 * ratio.clamp(0.125, 8.0)) as usize;
        let n_samples = (self.key.n_samples as usize).pow(2);
        let most = (MOST_SAMPLES / n_samples).min(MOST_WAYS / self.n_ways_of_pixel);
        let least = if ratio >= 1.0 { self.n_tile_pixels } else { 1 };
        self.n_tile_pixels = wanted.max(least).clamp(1, most.max(1));
    }

    fn propose_tile(
        &mut self,
        gpu: &Gpu,
        prepared: &Prepared,
        samples: &Pixels,
        ids: &[u32],
        tile: Tile,
        colors: &mut Vec<u32>,
    ) -> Result<ProposedColors> {
        let n_pixels = tile.width * tile.height;
        let room = match self.room.take().filter(|room| room.n_pixels >= n_pixels) {
            Some(room) => room,
            None => self.make_room(gpu, n_pixels)?,
        };
        let n = self.key.n_samples as usize;
        let columns = samples.width as usize / n;
        let first_sample =
            tile.first / columns * n * samples.width as usize + tile.first % columns * n;
        let (width, height) = (tile.width * n, tile.height * n);
        if tile.width == columns {
            let ids = &ids[first_sample..][..width * height];
            gpu.queue.write_buffer(&room.ids, 0, bytemuck::cast_slice(ids));
        } else {
            for row in 0..height {
                let ids = &ids[first_sample + row * samples.width as usize..][..width];
                let offset = (row * width * size_of::<u32>()) as u64;
                gpu.queue.write_buffer(&room.ids, offset, bytemuck::cast_slice(ids));
            }
        }
        let mut encoder = gpu.encoder();
        encoder.clear_buffer(&self.n_ways, 0, None);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for (stage, bind_group) in self.stages.iter().zip(&room.bind_groups) {
            let params = match stage.float {
                Float::F32 => bytes(&params(prepared, samples, first_sample, tile)),
                Float::F64 => bytes(&params_double(prepared, samples, first_sample, tile)),
            };
            gpu.queue.write_buffer(&stage.params, 0, &params);
            pass.set_pipeline(&stage.program.pipeline);
            pass.set_bind_group(0, bind_group, &[]);
            let [across, down] = WORKGROUP;
            pass.dispatch_workgroups(
                (tile.width as u32).div_ceil(across),
                (tile.height as u32).div_ceil(down),
                1,
            );
        }
        drop(pass);
        let word = size_of::<u32>() as u64;
        let n_words = n_pixels * self.key.words.per_pixel();
        let n_bytes = n_words as u64 * word;
        let of_counts = COUNTS as u64 * word;
        encoder.copy_buffer_to_buffer(&self.n_ways, 0, &room.staging, 0, Some(of_counts));
        encoder.copy_buffer_to_buffer(&room.colors, 0, &room.staging, of_counts, Some(n_bytes));
        gpu.submit(encoder.finish());
        let words: Vec<u32> =
            gpu.read(&room.staging, n_words + COUNTS, TILE_TIMEOUT, "shade some pixels")?;
        colors.extend_from_slice(&words[COUNTS..]);
        self.room = Some(room);
        let [all, in_f64, n_in_f32] = [words[0], words[1], words[2]].map(u64::from);
        let ways = StageCounts { f32: all - in_f64, f64: in_f64, exact: 0 };
        Ok(ProposedColors { ways, n_in_f32 })
    }

    /// Room for a tile of so many pixels.
    fn make_room(&self, gpu: &Gpu, n_pixels: usize) -> Result<Room> {
        use wgpu::BufferUsages as Usage;
        let n_ids = n_pixels * (self.key.n_samples as usize).pow(2);
        let word = size_of::<u32>();
        let ids = gpu.buffer("ids", n_ids * word, Usage::STORAGE | Usage::COPY_DST);
        let n_words = n_pixels * self.key.words.per_pixel();
        let colors = gpu.buffer("colors", n_words * word, Usage::STORAGE | Usage::COPY_SRC);
        let staging =
            gpu.buffer("staging", (n_words + COUNTS) * word, Usage::MAP_READ | Usage::COPY_DST);
        let bind_groups = self.stages.iter().map(|stage| {
            let of_all = [
                ("params", &stage.params),
                ("ids", &ids),
                ("colors", &colors),
                ("n_ways", &self.n_ways),
            ];
            let of_all = of_all.map(|(name, buffer)| (name, buffer.as_entire_binding()));
            let resources = of_all.into_iter().chain(stage.objects.iter().map(whole));
            stage.program.bindings.bind(&gpu.device, resources)
        });
        let bind_groups = bind_groups.collect::<Result<_>>()?;
        gpu.check()?;
        Ok(Room { n_pixels, ids, colors, staging, bind_groups })
    }
}

impl Shared {
    fn new(gpu: &Gpu, prepared: &Prepared, light: &LightInF64) -> Shared {
        let tree = prepared.hierarchy.as_ref().map(|hierarchy| &hierarchy.tree);
        Shared {
            narrow: list(gpu, "spheres in f32", &light.narrow),
            listed: list(gpu, "spheres in the way", &light.spheres),
            boxes: tree.map(|tree| list(gpu, "boxes", &tree.boxes_on_device())),
        }
    }

    fn of_spheres(&self) -> [Named; 2] {
        [("narrow_spheres", self.narrow.clone()), ("listed_spheres", self.listed.clone())]
    }
}

impl Stage {
    fn in_f32(
        gpu: &Gpu,
        prepared: &Prepared,
        shared: &Shared,
        key: LightKey,
        light: &LightInF32,
    ) -> Result<Stage> {
        let mut objects = vec![
            ("light_of_all", uniform(gpu, "light of all in f32", &light.all)),
            ("lamps", list(gpu, "lamps in f32", &light.lamps)),
            ("palette", list(gpu, "palette in f32", &light.palette)),
            ("edges", list(gpu, "edges in f32", &light.edges)),
        ];
        if !prepared.scene.spheres.is_empty() {
            objects.extend(shared.of_spheres());
            objects.push(("seen_spheres", list(gpu, "spheres as seen", &light.seen_spheres)));
        }
        if !prepared.scene.planes.is_empty() {
            objects.push(("seen_planes", list(gpu, "planes as seen", &light.seen_planes)));
            objects.push(("listed_planes", list(gpu, "planes in the way", &light.planes)));
        }
        objects.extend(shared.boxes.clone().map(|boxes| ("boxes", boxes)));
        let program = gpu.program(&before::light_key_in_f32(prepared, key.words))?;
        let params = params_buffer(gpu, Float::F32);
        Ok(Stage { float: Float::F32, program, params, objects })
    }

    fn in_f64(
        gpu: &Gpu,
        prepared: &Prepared,
        hierarchy: Option<&DeviceHierarchy>,
        shared: &Shared,
        key: LightKey,
        light: &LightInF64,
    ) -> Result<Stage> {
        let numbers = InF64::new(prepared);
        let mut objects = storage_in_f64(gpu, prepared, &numbers, hierarchy);
        objects.push(("light_of_all", uniform(gpu, "light of all", &light.all)));
        objects.push(("lamps", list(gpu, "lamps", &light.lamps)));
        objects.push(("palette", list(gpu, "palette", &light.palette)));
        if !light.edges.is_empty() {
            objects.push(("edges", list(gpu, "edges", &light.edges)));
        }
        if !prepared.scene.spheres.is_empty() {
            objects.extend(shared.of_spheres());
        }
        if !prepared.scene.planes.is_empty() {
            objects.push(("listed_planes", list(gpu, "planes in the way", &light.planes)));
        }
        objects.extend(shared.boxes.clone().map(|boxes| ("boxes", boxes)));
        let program = gpu.program(&numbers.light_key(prepared, key.words))?;
        let params = params_buffer(gpu, Float::F64);
        Ok(Stage { float: Float::F64, program, params, objects })
    }
}

/// A buffer with these values, or with room for one where there is none: none can be empty.
fn list<T: bytemuck::Pod>(gpu: &Gpu, label: &str, values: &[T]) -> wgpu::Buffer {
    match values {
        [] => gpu.storage(label, bytemuck::bytes_of(&T::zeroed())),
        values => gpu.storage(label, bytemuck::cast_slice(values)),
    }
}

fn params(prepared: &Prepared, samples: &Pixels, first: usize, tile: Tile) -> Params {
    let (x, y) = samples.xy(first);
    let (offset_i, offset_j) = samples.offset2(x, y);
    let camera = CameraF32::new(samples);
    Params {
        forward: camera.forward.0,
        n_spheres: prepared.scene.spheres.len() as u32,
        n_planes: prepared.scene.planes.len() as u32,
        right_step: camera.right_step.0,
        true_up_step: camera.true_up_step.0,
        infinity: f32::INFINITY,
        origin: prepared.coordinates().camera_origin().as_vec3().to_array(),
        n_rays: (tile.width * tile.height) as u32,
        offset_i: offset_i as i32,
        offset_j: offset_j as i32,
        width: tile.width as u32,
        padding: 0,
    }
}

fn params_double(prepared: &Prepared, samples: &Pixels, first: usize, tile: Tile) -> ParamsDouble {
    let (x, y) = samples.xy(first);
    let (offset_i, offset_j) = samples.offset2(x, y);
    let camera = CameraF64::new(samples);
    ParamsDouble {
        forward: camera.forward.0,
        n_spheres: prepared.scene.spheres.len() as u32,
        n_planes: prepared.scene.planes.len() as u32,
        right: camera.right.0,
        step: camera.step,
        true_up: camera.true_up.0,
        infinity: f64::INFINITY,
        origin: prepared.coordinates().camera_origin().to_array(),
        n_rays: (tile.width * tile.height) as u32,
        offset_i: offset_i as i32,
        offset_j: offset_j as i32,
        width: tile.width as u32,
        ..ParamsDouble::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::compile::compile;
    use crate::kernel::Kernel;
    use crate::prepare::{ColorWords, Finding, ShaderKey};
    use crate::rays::Bundle;

    #[test]
    fn no_shader_binds_more_buffers_than_are_asked_for() {
        let key = |float| ShaderKey {
            kernel: Kernel::Certified,
            float,
            bundle: Bundle::Point,
            some: false,
            spheres: Finding::Hierarchy,
            n_spheres: 1,
            n_planes: 1,
            surface: false,
            light: Some(ColorWords::Bytes),
            plain_light: None,
        };
        let is_storage = |space| matches!(space, naga::AddressSpace::Storage { .. });
        let [of_f32, of_f64] = [Float::F32, Float::F64].map(|float| {
            let shader = compile(&key(float)).unwrap();
            let globals = shader.module.global_variables.iter();
            globals.filter(|(_, variable)| is_storage(variable.space)).count()
        });
        assert!(of_f32 < of_f64);
        assert_eq!(of_f64, N_STORAGE_BUFFERS as usize);
    }
}
