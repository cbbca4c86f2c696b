//! A shader at work: what it binds, room for what it makes of each ray, and rays tile by tile.

use std::sync::Arc;
use std::time::Instant;

use super::clock::Clock;
use super::layout::{Params, ParamsDouble};
use super::open::Gpu;
use super::pipeline::{Named, whole};
use super::program::Program;
use super::tiles::{Tile, TileSize};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::kernel::Float;
use crate::kernel::coordinates::{RayRecord, RayRecordDouble};
use crate::prepare::{LightKey, Prepared, ShaderKey};
use crate::rays::Bundle;
use crate::trace::{Rays, Timing};

/// An array with an element for each ray, as a shader has it: its name, and bytes of an element.
type PerRay = (&'static str, usize);

/// What a shader makes of each ray, in the order in which it comes to the host.
fn results_of(key: &ShaderKey) -> Vec<PerRay> {
    let light = match key.kernel.about().float {
        Float::F64 => size_of::<[f64; 3]>(),
        Float::F32 => size_of::<[f32; 3]>(),
    };
    match (key.light, key.surface) {
        (Some(LightKey::Plain { .. }), _) => vec![("lights", light)],
        (Some(LightKey::Certified { .. }), _) => vec![("codes", 4)],
        (None, true) => vec![("ids", 4), ("ts", 4), ("normals", 12)],
        (None, false) => vec![("ids", 4)],
    }
}

/// Takes the results of a tile, array by array.
pub type Take<'a> = &'a mut dyn FnMut(&Tile, &[&[u8]]);

/// A shader and what it needs to run.
pub struct Pass {
    gpu: Arc<Gpu>,
    program: Arc<Program>,
    float: Float,
    /// Samples across and down a pixel.
    n_samples: u32,
    params: wgpu::Buffer,
    /// What all tiles bind.
    bound: Vec<Named>,
    results: Vec<PerRay>,
    /// Bytes of a ray that the host gives.
    ray_bytes: Option<usize>,
    room: Option<Room>,
    tile_size: TileSize,
    clock: Option<Clock>,
}

/// The buffers whose size depends on the tile's, and the bind group that names them.
struct Room {
    n_rays: usize,
    results: Vec<wgpu::Buffer>,
    rays: Option<wgpu::Buffer>,
    staging: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl Pass {
    /// Compiles the shader of a key, which binds `bound` beside its parameters and what it has of each ray, and runs it on an
    /// empty tile: some drivers compile a shader when it first runs, and that time should not mislead the tiles' size.
    ///
    /// # Errors
    /// [`Error::Shader`] when the device refuses the shader, [`Error::TooLarge`] when it binds too few buffers at once,
    /// [`Error::Device`] when it fails.
    pub fn new(
        gpu: &Arc<Gpu>,
        prepared: &Prepared,
        key: &ShaderKey,
        bound: Vec<Named>,
    ) -> Result<Pass> {
        let float = key.kernel.about().float;
        let (n_bytes, ray_bytes) = match float {
            Float::F64 => (size_of::<ParamsDouble>(), size_of::<RayRecordDouble>()),
            Float::F32 => (size_of::<Params>(), size_of::<RayRecord>()),
        };
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let mut pass = Pass {
            program: gpu.program(key)?,
            float,
            n_samples: match key.light {
                Some(LightKey::Certified { n_samples, .. }) => n_samples,
                _ => 1,
            },
            params: gpu.buffer("params", n_bytes, usage),
            bound,
            results: results_of(key),
            ray_bytes: (key.bundle == Bundle::Free).then_some(ray_bytes),
            room: None,
            tile_size: TileSize::first(prepared),
            clock: None,
            gpu: Arc::clone(gpu),
        };
        let room = pass.make_room(64)?;
        match float {
            Float::F64 => pass.write_params(&ParamsDouble { n_rays: 1, ..Default::default() }),
            Float::F32 => pass.write_params(&Params { n_rays: 1, ..Default::default() }),
        }
        let submission = gpu.submit(pass.dispatch(&room, [1, 1]).finish());
        pass.room = Some(room);
        gpu.wait(submission).map_err(|reason| pass.lost(1, &reason))?;
        gpu.check()?;
        Ok(pass)
    }

    /// Binds these from now on.
    pub fn bind(&mut self, bound: Vec<Named>) {
        (self.bound, self.room) = (bound, None);
    }

    /// Gives [`Timing::on_device`] from now on, or not; a device without a clock leaves it out.
    pub fn use_clock(&mut self, is_wanted: bool) {
        if is_wanted != self.clock.is_some() {
            self.clock = Clock::new(&self.gpu).filter(|_| is_wanted);
        }
    }

    /// Bytes on the device, beside what is bound.
    pub fn bytes(&self) -> u64 {
        let of_room = |room: &Room| {
            let buffers = room.results.iter().chain(&room.rays).chain([&room.staging]);
            buffers.map(wgpu::Buffer::size).sum::<u64>()
        };
        self.params.size() + self.room.as_ref().map_or(0, of_room)
    }

    /// Runs the shader for rays that the scene is prepared for, or for pixels of whose samples it is.
    ///
    /// # Errors
    /// [`Error::Usage`] for other rays, [`Error::Device`] when the device fails or takes too long, [`Error::Interrupted`].
    pub fn run(
        &mut self,
        prepared: &Prepared,
        rays: &Rays,
        control: &Control,
        take: Take,
    ) -> Result<Timing> {
        match rays {
            Rays::Pixels(pixels) => {
                prepared.check(&Rays::Pixels(pixels.samples(self.n_samples)))?
            }
            Rays::List(_) => prepared.check(rays)?,
        }
        let (mut timing, mut first) = (Timing::default(), 0);
        while first < rays.len() {
            control.check()?;
            let tile = Tile::new(rays, first, self.tile_size.0);
            let start = Instant::now();
            let room = match self.room.take().filter(|room| room.n_rays >= tile.n_rays) {
                Some(room) => room,
                None => self.make_room(tile.n_rays)?,
            };
            timing.add(self.run_tile(prepared, rays, &tile, &room, take)?);
            self.room = Some(room);
            self.tile_size.adapt(tile.n_rays, start.elapsed());
            first += tile.n_rays;
        }
        Ok(timing)
    }

    fn run_tile(
        &self,
        prepared: &Prepared,
        rays: &Rays,
        tile: &Tile,
        room: &Room,
        take: Take,
    ) -> Result<Timing> {
        let start = Instant::now();
        match self.float {
            Float::F64 => self.write_params(&tile.params_double(prepared, rays)),
            Float::F32 => self.write_params(&tile.params(prepared, rays, self.n_samples)),
        }
        if let (Some(buffer), Rays::List(rays)) = (&room.rays, rays) {
            let (coordinates, rays) = (prepared.coordinates(), &rays[tile.first..][..tile.n_rays]);
            match self.float {
                Float::F64 => {
                    self.write(buffer, rays.iter().map(|ray| coordinates.ray_record_double(ray)));
                }
                Float::F32 => {
                    self.write(buffer, rays.iter().map(|ray| coordinates.ray_record(ray).0))
                }
            }
        }
        let (gpu, mut encoder) = (&self.gpu, self.dispatch(room, tile.workgroups()));
        let mut end = 0;
        let ranges: Vec<_> = self
            .results
            .iter()
            .map(|(_, bytes)| {
                let begin = end;
                end += tile.n_rays * bytes;
                begin..end
            })
            .collect();
        for (buffer, range) in room.results.iter().zip(&ranges) {
            let (offset, size) = (range.start as u64, range.len() as u64);
            encoder.copy_buffer_to_buffer(buffer, 0, &room.staging, offset, Some(size));
        }
        gpu.submit(encoder.finish());
        let mapped = gpu.map(&room.staging, end as u64);
        gpu.check()?;
        let view = mapped.map_err(|reason| self.lost(tile.n_rays, &reason))?;
        let trace = start.elapsed();

        let start = Instant::now();
        let arrays: Vec<&[u8]> = ranges.into_iter().map(|range| &view[range]).collect();
        take(tile, &arrays);
        drop(view);
        room.staging.unmap();
        let readback = start.elapsed();
        let on_device = self.clock.as_ref().map(|clock| clock.read(gpu)).transpose()?;
        Ok(Timing { trace, readback, on_device, ..Timing::default() })
    }

    fn dispatch(&self, room: &Room, [x, y]: [u32; 2]) -> wgpu::CommandEncoder {
        let mut encoder = self.gpu.encoder();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.clock.as_ref().map(Clock::around_pass),
        });
        pass.set_pipeline(&self.program.pipeline);
        pass.set_bind_group(0, &room.bind_group, &[]);
        pass.dispatch_workgroups(x, y, 1);
        drop(pass);
        if let Some(clock) = &self.clock {
            clock.stop(&mut encoder);
        }
        encoder
    }

    fn write_params(&self, params: &impl bytemuck::NoUninit) {
        self.gpu.queue.write_buffer(&self.params, 0, bytemuck::bytes_of(params));
    }

    fn write<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer, records: impl Iterator<Item = T>) {
        let records: Vec<T> = records.collect();
        self.gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&records));
    }

    fn lost(&self, n_rays: usize, reason: &str) -> Error {
        Error::Device(format!(
            "`{}` did not finish {n_rays} rays: {reason}; try `--device cpu`, or fewer objects and lights",
            self.gpu.facts.name
        ))
    }

    /// Room for a tile of so many rays.
    fn make_room(&self, n_rays: usize) -> Result<Room> {
        use wgpu::BufferUsages as Usage;
        let gpu = &self.gpu;
        let buffer = |&(name, bytes): &PerRay| {
            gpu.buffer(name, n_rays * bytes, Usage::STORAGE | Usage::COPY_SRC)
        };
        let results: Vec<_> = self.results.iter().map(buffer).collect();
        let rays = self
            .ray_bytes
            .map(|bytes| gpu.buffer("rays", n_rays * bytes, Usage::STORAGE | Usage::COPY_DST));
        let n_bytes = n_rays * self.results.iter().map(|(_, bytes)| bytes).sum::<usize>();
        let staging = gpu.buffer("staging", n_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let names = self.results.iter().map(|(name, _)| *name).chain(["rays"]);
        let of_rays = names.zip(results.iter().chain(&rays));
        let named = |(name, buffer): (&'static str, &wgpu::Buffer)| (name, buffer.clone().into());
        let of_tile: Vec<Named> = of_rays.chain([("params", &self.params)]).map(named).collect();
        let bound = self.bound.iter().chain(&of_tile).map(whole);
        let bind_group = self.program.bindings.bind(&gpu.device, bound)?;
        gpu.check()?;
        Ok(Room { n_rays, results, rays, staging, bind_group })
    }
}
