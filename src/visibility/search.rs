//! What the pixels of a picture see, and the samples of those that show several objects.

use super::batch::RayBatch;
use super::cloud::{self, CloudSearch};
use crate::bounds::{Footprint, LARGEST_TURN};
use crate::num::{Float, UNDECIDED};
use crate::prepare::Prepared;
use crate::query::Mixed;
use crate::rays::{Frame, Pixels};
use crate::shape::{Objects, RayOrigin};

/// Columns and rows of the largest squares, px.
pub const LARGEST: u32 = 16;

/// Columns of a block, px: what is looked at together.
const COLUMNS: u32 = 128;

/// The objects as squares of some size see them.
struct SquareSize {
    /// Columns and rows, px.
    side: u32,
    objects: Objects<f32>,
}

/// The pixels of a picture, and how their objects are found.
pub enum Search<'a> {
    /// Few objects.
    Few(SquareSearch),
    /// Many spheres.
    Many(Box<CloudSearch<'a>>),
}

/// Pixels of a picture of few objects, that are looked at in squares before each by itself.
pub struct SquareSearch {
    /// Samples across and down a pixel.
    n: u32,
    /// From large squares to small ones, the last of which are pixels.
    levels: Vec<SquareSize>,
    /// The camera's frame for the samples.
    camera: Frame<f32>,
    /// The objects as single samples see them, where a pixel has several.
    of_samples: Option<Objects<f32>>,
}

/// Memory for the squares of a block.
#[derive(Default)]
pub struct SearchScratch {
    open: Vec<[u32; 2]>,
    next: Vec<[u32; 2]>,
    tile: RayBatch,
    cloud: cloud::CloudScratch,
}

impl<'a> Search<'a> {
    /// For `n` × `n` samples of each of these pixels; `prepared` is of the picture of the samples.
    pub fn new(prepared: &'a Prepared, pixels: &Pixels, n: u32) -> Search<'a> {
        Search::with_reach(prepared, pixels, n, 1.0)
    }

    /// With squares whose rays are said to be this share as far apart as they are.
    pub(crate) fn with_reach(
        prepared: &'a Prepared,
        pixels: &Pixels,
        n: u32,
        share: f64,
    ) -> Search<'a> {
        if let Some(cloud) = CloudSearch::of(prepared, pixels, n, share) {
            return Search::Many(Box::new(cloud));
        }
        let samples = pixels.samples(n);
        let objects = |reach| {
            Objects::new(prepared.listed(None), &RayOrigin::of_pixels(&samples, reach, f32::UNIT))
        };
        let level = |side| {
            let Footprint { apart, turned } = Footprint::of_samples(pixels, side, n);
            let reach = Footprint { apart: share * apart, turned: share * turned };
            (turned <= LARGEST_TURN).then(|| SquareSize { side, objects: objects(reach) })
        };
        Search::Few(SquareSearch {
            n,
            levels: [LARGEST, LARGEST / 4, 1].into_iter().filter_map(level).collect(),
            camera: Frame::of_pixels(&samples),
            of_samples: (n > 1).then(|| objects(Footprint::default())),
        })
    }

    /// Finds what some of the pixels see in f32: of each the object that all its samples see, or [`UNDECIDED`]; and of those with
    /// several samples that are left, these.
    pub fn look(&self, pixels: &Pixels, whole: &mut [u32], room: &mut SearchScratch) -> Mixed {
        match self {
            Search::Few(search) => search.look(pixels, whole, room),
            Search::Many(search) => search.look(pixels, whole, &mut room.cloud),
        }
    }
}

impl SquareSearch {
    fn look(&self, pixels: &Pixels, whole: &mut [u32], room: &mut SearchScratch) -> Mixed {
        whole.fill(UNDECIDED);
        for y in (0..pixels.height).step_by(LARGEST as usize) {
            for x in (0..pixels.width).step_by(COLUMNS as usize) {
                let size = [COLUMNS.min(pixels.width - x), LARGEST.min(pixels.height - y)];
                self.look_at_block(pixels, [x, y], size, whole, room);
            }
        }
        let of_samples = self.of_samples.as_ref();
        of_samples.map_or_else(Mixed::default, |objects| self.sample(pixels, objects, whole, room))
    }

    /// What a block of pixels sees. `corner` is its left upper one.
    fn look_at_block(
        &self,
        pixels: &Pixels,
        [left, top]: [u32; 2],
        [columns, rows]: [u32; 2],
        whole: &mut [u32],
        room: &mut SearchScratch,
    ) {
        let width = pixels.width;
        let SearchScratch { open, next, tile, .. } = room;
        let (right, bottom) = (left + columns, top + rows);
        let split = |[x, y]: [u32; 2], [columns, rows]: [u32; 2], step: u32, to: &mut Vec<_>| {
            for y in (y..(y + rows).min(bottom)).step_by(step as usize) {
                to.extend((x..(x + columns).min(right)).step_by(step as usize).map(|x| [x, y]));
            }
        };
        open.clear();
        let first = self.levels.first().map_or(1, |level| level.side);
        split([left, top], [columns, rows], first, open);
        for (at, level) in self.levels.iter().enumerate() {
            let side = level.side;
            let smaller = self.levels.get(at + 1).map_or(1, |level| level.side);
            next.clear();
            // What the block cuts off is no square of the picture.
            open.retain(|&[x, y]| {
                let is_inside = x + side <= right && y + side <= bottom;
                if !is_inside {
                    split([x, y], [side; 2], smaller, next);
                }
                is_inside
            });
            self.aim(pixels, open, side, tile);
            tile.find_f32(&self.camera, &level.objects);
            for (&[x, y], &id) in open.iter().zip(&tile.ids) {
                if id == UNDECIDED && side > 1 {
                    split([x, y], [side; 2], smaller, next);
                    continue;
                }
                for row in y..y + side {
                    let first = (row * width + x) as usize;
                    whole[first..first + side as usize].fill(id);
                }
            }
            std::mem::swap(open, next);
        }
    }

    /// The rays through the middles of squares.
    fn aim(&self, pixels: &Pixels, squares: &[[u32; 2]], side: u32, tile: &mut RayBatch) {
        let Pixels { x, y, image_width, image_height, .. } = *pixels;
        let n = i64::from(self.n);
        tile.clear();
        for [column, row] in squares {
            let (x, y) = (x + column, y + row);
            // As `Pixels::offset2` has it of a pixel's.
            let i = i64::from(2 * x + side) - i64::from(image_width);
            let j = i64::from(image_height) - i64::from(2 * y + side);
            tile.push((n * i, n * j));
        }
    }

    /// What f32 sees of the samples of those pixels of some rows that are left.
    fn sample(
        &self,
        pixels: &Pixels,
        objects: &Objects<f32>,
        whole: &[u32],
        room: &mut SearchScratch,
    ) -> Mixed {
        let tile = &mut room.tile;
        let places = 0..whole.len() as u32;
        let mixed: Vec<u32> = places.filter(|&at| whole[at as usize] == UNDECIDED).collect();
        tile.take_samples(pixels, self.n, &mixed);
        tile.find_f32(&self.camera, objects);
        (mixed, std::mem::take(&mut tile.ids))
    }
}
