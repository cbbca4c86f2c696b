//! A shader at work: what it binds, room for what it makes of each ray, and rays tile by tile.

use std::sync::Arc;
use std::time::Instant;

use super::layout::{Layout, Params, RayRecord};
use super::open::Gpu;
use super::pipeline::{Named, Program};
use super::room::{BufferRoom, PerRay};
use super::tiles::{DeviceTile, TileSize};
use crate::error::{Error, Hint, Message, Result, Setting};
use crate::kernel::FloatType;
use crate::prepare::{LightKey, Prepared, ShaderKey};
use crate::query::{Rays, Timing};
use crate::support::control::Control;

/// What a shader makes of each ray, in the order in which it comes to the host.
fn results_of(key: &ShaderKey) -> Vec<PerRay> {
    match (key.light, key.surface) {
        (Some(LightKey::Baseline { .. }), _) => {
            vec![("lights", 3 * key.kernel.about().float.size())]
        }
        (Some(LightKey::Certified { .. }), _) => vec![("codes", 4)],
        (None, true) => vec![("ids", 4), ("ts", 4), ("normals", 12)],
        (None, false) => vec![("ids", 4)],
    }
}

/// Takes the results of a tile, array by array.
pub type Take<'a> = &'a mut dyn FnMut(&DeviceTile, &[&[u8]]);

/// A shader and what it needs to run.
pub struct Pass {
    gpu: Arc<Gpu>,
    program: Arc<Program>,
    float: FloatType,
    /// Samples across and down a pixel.
    n_samples: u32,
    params: wgpu::Buffer,
    /// What all tiles bind.
    bound: Vec<Named>,
    results: Vec<PerRay>,
    /// Bytes of a ray that the host gives, and where they lie.
    ray_bytes: Option<usize>,
    rays: Option<wgpu::Buffer>,
    room: Option<BufferRoom>,
    tile_size: TileSize,
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
        let (n_samples, n_times) = match key.light {
            Some(LightKey::Certified { n_samples, n_lamps, .. }) => {
                (n_samples, (n_samples as usize).pow(2) * (n_lamps + 1))
            }
            _ => (1, 1),
        };
        let one_ray = Params { n_rays: 1, ..Params::default() }.bytes(float);
        let ray_bytes = RayRecord::default().bytes(float).len();
        let mut pass = Pass {
            program: gpu.program(key)?,
            float,
            n_samples,
            params: gpu.filled("params", &one_ray),
            bound,
            results: results_of(key),
            ray_bytes: key.lens.is_none().then_some(ray_bytes),
            rays: None,
            room: None,
            tile_size: TileSize::first(prepared, n_times, gpu.facts.is_software()),
            gpu: Arc::clone(gpu),
        };
        let room = pass.make_room(64)?;
        let encoder = room.dispatch(gpu, &pass.program, [1, 1]);
        let submission = gpu.submit(encoder.finish());
        pass.room = Some(room);
        gpu.wait(Some(submission)).map_err(|reason| pass.lost(1, &reason))?;
        gpu.check()?;
        Ok(pass)
    }

    /// Binds these from now on.
    pub fn bind(&mut self, bound: Vec<Named>) {
        (self.bound, self.room) = (bound, None);
    }

    /// Bytes on the device, beside what is bound.
    pub fn bytes(&self) -> u64 {
        self.params.size()
            + self.rays.as_ref().map_or(0, wgpu::Buffer::size)
            + self.room.as_ref().map_or(0, BufferRoom::bytes)
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
            let tile = DeviceTile::new(rays, first, self.tile_size.n_rays);
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
        tile: &DeviceTile,
        room: &BufferRoom,
        take: Take,
    ) -> Result<Timing> {
        let start = Instant::now();
        let params = tile.params(prepared, rays, self.n_samples).bytes(self.float);
        self.gpu.queue.write_buffer(&self.params, 0, &params);
        if let (Some(buffer), Rays::List(rays)) = (&self.rays, rays) {
            let mut bytes = Vec::with_capacity(buffer.size() as usize);
            for ray in &rays[tile.first..][..tile.n_rays] {
                RayRecord::new(prepared.coordinates(), ray).put(self.float, &mut bytes);
            }
            self.gpu.queue.write_buffer(buffer, 0, &bytes);
        }
        let encoder = room.dispatch(&self.gpu, &self.program, tile.workgroups());
        let (n, take) = (tile.n_rays, &mut |arrays: &[&[u8]]| take(tile, arrays));
        let made = room.read(&self.gpu, encoder, n, |reason| self.lost(n, reason), take)?;
        let (trace, readback) = (made - start, made.elapsed());
        Ok(Timing { trace, readback, ..Timing::default() })
    }

    fn lost(&self, n_rays: usize, reason: &str) -> Error {
        let text =
            format!("`{}` did not finish tracing {n_rays} rays: {reason}", self.gpu.facts.name);
        let hint = Hint::new(
            "try {}, or a scene with fewer objects and lights",
            [Setting::text("device", "cpu")],
        );
        Error::Device(Message::new(text, hint))
    }

    /// Room for a tile of so many rays.
    fn make_room(&mut self, n_rays: usize) -> Result<BufferRoom> {
        use wgpu::BufferUsages as Usage;
        let gpu = &self.gpu;
        let rays = |bytes| gpu.buffer("rays", n_rays * bytes, Usage::STORAGE | Usage::COPY_DST);
        self.rays = self.ray_bytes.map(rays);
        let mut bound = self.bound.clone();
        bound.push(("params", self.params.clone().into()));
        bound.extend(self.rays.iter().map(|rays| ("rays", rays.clone().into())));
        BufferRoom::new(gpu, &self.program, n_rays, &self.results, bound)
    }
}
