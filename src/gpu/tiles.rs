//! Parts of the rays that are dispatched at a time, and what a shader has to know of each.

use std::time::Duration;

use super::compile::WORKGROUP;
use super::layout::Params;
use crate::kernel::baseline::BaselineRays;
use crate::prepare::Prepared;
use crate::query::Rays;

/// Aim for the time of a dispatch: long enough to hide its overhead, short enough for every driver's
/// watchdog and for a quick Ctrl-C.
const TILE_TARGET: Duration = Duration::from_millis(75);

/// Most rays of one dispatch; bounds the memory for results.
const TILE_MAX_RAYS: usize = 1 << 20;

/// Most rays of one dispatch where a device in software walks through a tree: [`MOST_BOXES`](crate::bvh::MOST_BOXES) of each ray
/// without light then take half a minute on two cores, and a driver is given up after one.
const TILE_MAX_RAYS_IN_SOFTWARE: usize = 1 << 17;

/// Ray–object tests of the first dispatch, before anything is known about the device: about a
/// millisecond on two CPU cores.
const FIRST_TILE_TESTS: usize = 1 << 19;

/// Fewest rays of one dispatch, a row of a workgroup: so that it ends in time also where each ray has
/// millions of objects to look at.
const TILE_LEAST_RAYS: usize = WORKGROUP[0] as usize;

/// Width of the grid that a list of rays is laid out on.
const LIST_WIDTH: usize = 1 << 13;

/// Consecutive rays of one dispatch: whole rows, or a part of one row.
#[derive(Clone, Copy, Debug)]
pub struct DeviceTile {
    /// The first of them.
    pub first: usize,
    width: usize,
    height: usize,
    /// Rays that fill the tile; the last row of a list may be short.
    pub n_rays: usize,
}

impl DeviceTile {
    /// The tile of up to `most` of these rays that begins with ray `first`.
    pub fn new(rays: &Rays, first: usize, most: usize) -> DeviceTile {
        match rays {
            Rays::Pixels(pixels) => {
                let (width, height) = (pixels.width as usize, pixels.height as usize);
                let (row, column) = (first / width, first % width);
                if column > 0 || most < width {
                    let width = most.min(width - column);
                    DeviceTile { first, width, height: 1, n_rays: width }
                } else {
                    let height = (most / width).min(height - row);
                    DeviceTile { first, width, height, n_rays: width * height }
                }
            }
            Rays::List(rays) => {
                let n_rays = most.min(rays.len() - first);
                let width = n_rays.min(LIST_WIDTH);
                DeviceTile { first, width, height: n_rays.div_ceil(width), n_rays }
            }
        }
    }

    /// Workgroups that cover it.
    pub fn workgroups(&self) -> [u32; 2] {
        let [width, height] = WORKGROUP;
        [(self.width as u32).div_ceil(width), (self.height as u32).div_ceil(height)]
    }

    /// What a shader has to know of it, with `n` × `n` samples a pixel.
    pub fn params(&self, prepared: &Prepared, rays: &Rays, n: u32) -> Params {
        let common = Params {
            n_spheres: prepared.scene.spheres.len() as u32,
            n_planes: prepared.scene.planes.len() as u32,
            infinity: f64::INFINITY,
            n_rays: self.n_rays as u32,
            width: self.width as u32,
            ..Params::default()
        };
        let first_pixel = rays.pixels().zip(rays.pixel(self.first));
        let Some((pixels, [x, y])) = first_pixel else { return common };
        let samples = pixels.samples(n);
        // A picture of samples has at most 2^31 columns and rows, so the doubled offsets fit.
        let (offset_i, offset_j) = samples.offset2(x * n, y * n);
        // In f64 the shader multiplies, as the kernel does on the CPU.
        let on_cpu = BaselineRays::<f64>::of_pixels(prepared.coordinates(), &samples);
        let BaselineRays::Pixels { camera, step, origin, .. } = on_cpu else { return common };
        Params {
            forward: camera.forward.0,
            right: camera.right.0,
            true_up: camera.true_up.0,
            step,
            origin: origin.0,
            offset_i: offset_i as i32,
            offset_j: offset_j as i32,
            ..common
        }
    }
}

/// Most rays of the next tile.
#[derive(Clone, Copy, Debug)]
pub struct TileSize {
    /// Now.
    pub n_rays: usize,
    most: usize,
}

impl TileSize {
    /// That of the first one, where each ray looks at all objects so many times.
    pub fn first(prepared: &Prepared, n_times: usize, is_software: bool) -> TileSize {
        let n_objects = prepared.n_listed().max(32);
        let most = match prepared.hierarchy {
            Some(_) if is_software => TILE_MAX_RAYS_IN_SOFTWARE,
            _ => TILE_MAX_RAYS,
        };
        let n_rays = (FIRST_TILE_TESTS / n_objects / n_times).clamp(TILE_LEAST_RAYS, most);
        TileSize { n_rays, most }
    }

    /// Moves toward the target time. A short tile, such as the last one, that met its target says
    /// nothing against longer ones.
    pub fn adapt(&mut self, n_rays: usize, spent: Duration) {
        let ratio = TILE_TARGET.as_secs_f64() / spent.as_secs_f64().max(1e-6);
        let wanted = (n_rays as f64 * ratio.clamp(0.125, 8.0)) as usize;
        let least = if ratio >= 1.0 { self.n_rays } else { TILE_LEAST_RAYS };
        self.n_rays = wanted.max(least).clamp(TILE_LEAST_RAYS, self.most);
    }
}
