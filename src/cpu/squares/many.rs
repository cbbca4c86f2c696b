//! Many spheres: tiles of pixels, of which each ray stands for all samples of its pixel, and tiles of the samples
//! of those pixels that this leaves open. The spheres that a tile of pixels may see are gathered once for all.

use std::ops::Range;

use pulp::Simd;
use rayon::prelude::*;

use crate::control::Control;
use crate::cpu::listed::Listed;
use crate::cpu::tile::{
    Leaf, PACKETS, ParallelRays, PointRays, PointSquares, TILE, TileRays, TileTracer, extent_of,
};
use crate::error::Result;
use crate::guard::Reach;
use crate::host;
use crate::kernel::Lists;
use crate::kernel::certified::{Frame, PlaneCertified, SphereCertified};
use crate::num::OPEN;
use crate::prepare::{Hierarchy, Prepared, Seen};
use crate::rays::{Lens, Pixels};
use crate::trace::Mixed;
use crate::tree::footprints::{Nearby, Node};

/// Tiles that one thread takes at a time from a row of them.
const TILES_AT_ONCE: usize = 32;

/// Pixels of a tile.
const N_PIXELS: usize = TILE * TILE;

/// Columns or rows of samples, less than which a sphere fills so few pixels that their samples are found sooner
/// than this is proven. The more samples a pixel has, the more a look at it saves.
const NARROW: u32 = 24;

/// Spheres of a tile, the nearest ones, that tell whether its pixels are worth a look.
const NEAREST: usize = 8;

/// Most spheres of a tile that are gathered, for each of the tiles that its samples make: to look through more
/// in each takes longer than a walk.
const MOST_NEARBY: usize = 64;

/// Pixels that are looked at in tiles.
pub(super) struct Many<'a> {
    prepared: &'a Prepared,
    hierarchy: &'a Hierarchy,
    seen: &'a Seen,
    pixels: &'a Pixels,
    samples: Pixels,
    n: u32,
    reach: Reach,
    /// Of squares, as are the objects outside the hierarchy.
    frame: Frame,
    lists: Lists<SphereCertified, PlaneCertified>,
    /// The pixels of each packet of a tile of pixels, and of each of the tiles of their samples.
    of_pixels: [u64; PACKETS],
    of_samples: Vec<[u64; PACKETS]>,
}

/// What is found in tiles of one row.
#[derive(Default)]
struct Found {
    /// For each pixel of each tile the object that all its samples see, or [`OPEN`].
    whole: Vec<u32>,
    /// The ids of the samples of each pixel that is undecided.
    ids: Vec<u32>,
}

impl<'a> Many<'a> {
    /// `None` where pixels are too large for the bounds, or the scene was not prepared for a picture.
    pub fn new(
        prepared: &'a Prepared,
        hierarchy: &'a Hierarchy,
        pixels: &'a Pixels,
        n: u32,
        reach: Reach,
    ) -> Option<Many<'a>> {
        let (seen, scene) = (hierarchy.seen.as_ref()?, &prepared.scene);
        let frame = Frame::of_squares(pixels, reach)?;
        let rest = hierarchy.rest.iter().map(|&id| &scene.spheres[id as usize - 1]);
        let lists = frame.objects(scene, rest);
        Some(Many {
            prepared,
            hierarchy,
            seen,
            pixels,
            samples: pixels.samples(n),
            n,
            reach,
            frame,
            lists,
            of_pixels: pixels_of_packets(1)[0],
            of_samples: pixels_of_packets(n as usize),
        })
    }

    /// Finds the pixels of a row of tiles that show one object alone, and what f32 sees of the samples of the
    /// others.
    pub fn look(&self, first_row: u32, whole: &mut [u32], control: &Control) -> Result<Mixed> {
        let width = self.pixels.width as usize;
        let (n_tiles, n_rows) = (width.div_ceil(TILE), whole.len() / width);
        let look = |first: usize| {
            host::check()?;
            let tiles = first..(first + TILES_AT_ONCE).min(n_tiles);
            let row = Row { many: self, tiles, first_row, n_rows, control };
            match self.pixels.view.lens {
                Lens::Perspective => row.find::<PointSquares, PointRays>(),
                Lens::Orthographic => row.find::<ParallelRays, ParallelRays>(),
            }
        };
        let firsts: Vec<usize> = (0..n_tiles).step_by(TILES_AT_ONCE).collect();
        let found = firsts.into_par_iter().map(look).collect::<Result<Vec<Found>>>()?;
        let mut tiles: Vec<(&[u32], &[u32])> = Vec::with_capacity(n_tiles);
        for Found { whole, ids } in &found {
            let mut ids = &ids[..];
            for whole in whole.chunks_exact(N_PIXELS) {
                let n_mixed = whole.iter().filter(|&&id| id == OPEN).count();
                let (of_tile, others) = ids.split_at(n_mixed * self.n_each());
                tiles.push((whole, of_tile));
                ids = others;
            }
        }
        let (mut mixed, mut ids) = Mixed::default();
        for (y, whole) in whole.chunks_exact_mut(width).enumerate() {
            let first = (first_row as usize + y) * width;
            for (x, (here, of_tile)) in (0..width).step_by(TILE).zip(&mut tiles) {
                let whole = &mut whole[x..width.min(x + TILE)];
                whole.copy_from_slice(&here[y * TILE..][..whole.len()]);
                let n_before = mixed.len();
                let open = (0..whole.len()).filter(|&column| whole[column] == OPEN);
                mixed.extend(open.map(|column| (first + x + column) as u32));
                let (of_row, others) = of_tile.split_at((mixed.len() - n_before) * self.n_each());
                ids.extend(of_row);
                *of_tile = others;
            }
        }
        Ok((mixed, ids))
    }

    /// False where most of the nearest leaves are too narrow to fill pixels.
    fn may_be_filled(&self, leaves: &[Node]) -> bool {
        let nearest = &leaves[..leaves.len().min(NEAREST)];
        let side = NARROW >> self.seen.footprints.cell_shift;
        let n_narrow = nearest.iter().filter(|leaf| leaf.is_narrower(side)).count();
        2 * n_narrow <= nearest.len()
    }

    /// Samples of a pixel.
    fn n_each(&self) -> usize {
        (self.n * self.n) as usize
    }
}

/// Some tiles of a row of them.
struct Row<'a> {
    many: &'a Many<'a>,
    tiles: Range<usize>,
    /// The first row of pixels, and how many there are.
    first_row: u32,
    n_rows: usize,
    control: &'a Control,
}

impl<'a> Row<'a> {
    fn find<Q: TileRays, T: TileRays>(self) -> Result<Found> {
        let Many { prepared, hierarchy, seen, pixels, samples, n, reach, lists, .. } = self.many;
        let of_squares = Listed::of(lists, prepared, hierarchy);
        let of_rays = Listed::new(prepared, hierarchy);
        let footprints = &seen.footprints;
        pulp::Arch::new().dispatch(WithTracers {
            squares: TileTracer::<Q>::new(footprints, of_squares, pixels).of_squares(*n, reach),
            rays: TileTracer::<T>::new(footprints, of_rays, samples),
            nearby: Nearby::default(),
            has_gathered: false,
            ids: vec![0; N_PIXELS * self.many.n_each()],
            row: self,
        })
    }
}

/// A row with the tracers of its pixels and of its samples, compiled for each instruction set that the processor
/// may have.
struct WithTracers<'a, Q, T> {
    row: Row<'a>,
    squares: TileTracer<'a, Q>,
    rays: TileTracer<'a, T>,
    /// The leaves of a tile, and whether it has them all.
    nearby: Nearby,
    has_gathered: bool,
    /// What the samples of a tile see, row by row.
    ids: Vec<u32>,
}

impl<Q: TileRays, T: TileRays> pulp::WithSimd for WithTracers<'_, Q, T> {
    type Output = Result<Found>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> Result<Found> {
        let (n, pixels) = (self.row.many.n as usize, self.row.many.pixels);
        let mut found = Found::default();
        for tile in self.row.tiles.clone() {
            self.row.control.check()?;
            let x = tile * TILE;
            let n_columns = TILE.min(pixels.width as usize - x);
            let inside = block(0..n_columns, 0..self.row.n_rows);
            let corner = [pixels.x + x as u32, pixels.y + self.row.first_row];
            let mut whole = self.find_whole(corner, inside);
            for at in (0..N_PIXELS).filter(|at| inside & 1 << at == 0) {
                whole[at] = 0;
            }
            let open = open_pixels(&whole);
            self.sample(corner, open);
            for at in (0..N_PIXELS).filter(|at| open & 1 << at != 0) {
                let (x, y) = (at % TILE * n, at / TILE * n);
                let row = |y: usize| &self.ids[y * TILE * n + x..][..n];
                let first = row(y)[0];
                if first != OPEN && (y..y + n).all(|y| row(y).iter().all(|&id| id == first)) {
                    whole[at] = first;
                } else {
                    (y..y + n).for_each(|y| found.ids.extend_from_slice(row(y)));
                }
            }
            found.whole.extend_from_slice(&whole);
        }
        Ok(found)
    }
}

impl<Q: TileRays, T: TileRays> WithTracers<'_, Q, T> {
    /// The objects that fill the pixels of the tile with this left upper pixel, of which those `inside` are looked
    /// at.
    #[inline(always)]
    fn find_whole(&mut self, corner: [u32; 2], inside: u64) -> [u32; N_PIXELS] {
        let Many { prepared, hierarchy, seen, frame, of_pixels, .. } = self.row.many;
        let packets = packets_of(of_pixels, inside);
        let cells = self.squares.cells_of(corner, packets);
        let most = MOST_NEARBY * self.row.many.n_each();
        self.has_gathered = self.nearby.gather(&seen.footprints, cells, most);
        if !self.has_gathered || !self.row.many.may_be_filled(self.nearby.leaves()) {
            return [OPEN; N_PIXELS];
        }
        let leaf = |place: usize| {
            let sphere = hierarchy.sphere_at(place, &prepared.scene.spheres);
            Leaf::of_squares(&frame.sphere(sphere), seen.far[place].id)
        };
        match self.squares.trace(corner, packets, &self.nearby, leaf) {
            true => self.squares.ids(),
            false => [0; N_PIXELS],
        }
    }

    /// Finds what the samples of the `open` pixels of a tile see.
    #[inline(always)]
    fn sample(&mut self, corner: [u32; 2], open: u64) {
        let Many { seen, n, of_samples, .. } = self.row.many;
        let n = *n as usize;
        for (tile, of_packets) in of_samples.iter().enumerate() {
            let packets = packets_of(of_packets, open);
            if packets == 0 {
                continue;
            }
            let (x, y) = (tile % n * TILE, tile / n * TILE);
            let corner = [corner[0] * n as u32 + x as u32, corner[1] * n as u32 + y as u32];
            let leaf = |place: usize| Leaf::of_rays(&seen.far[place]);
            let has_begun = match self.has_gathered {
                true => self.rays.trace(corner, packets, &self.nearby, leaf),
                false => self.rays.trace(corner, packets, &seen.footprints, leaf),
            };
            let ids = if has_begun { self.rays.ids() } else { [0; N_PIXELS] };
            for (row, ids) in ids.chunks_exact(TILE).enumerate() {
                self.ids[(y + row) * TILE * n + x..][..TILE].copy_from_slice(ids);
            }
        }
    }
}

/// Pixels of a tile, a bit each, row by row.
fn block(columns: Range<usize>, rows: Range<usize>) -> u64 {
    let row = columns.fold(0, |bits, x| bits | 1 << x);
    rows.fold(0, |bits, y| bits | row << (y * TILE))
}

/// Those that are undecided.
#[inline(always)]
fn open_pixels(whole: &[u32; N_PIXELS]) -> u64 {
    let mut open = 0;
    for (at, &id) in whole.iter().enumerate() {
        open |= u64::from(id == OPEN) << at;
    }
    open
}

/// The packets that have some of these pixels.
#[inline(always)]
fn packets_of(of_packets: &[u64; PACKETS], pixels: u64) -> u8 {
    let mut packets = 0;
    for (packet, of_packet) in of_packets.iter().enumerate() {
        packets |= u8::from(of_packet & pixels != 0) << packet;
    }
    packets
}

/// The pixels of each packet of the tiles that the `n` × `n` samples of each pixel of a tile make.
fn pixels_of_packets(n: usize) -> Vec<[u64; PACKETS]> {
    let of_tile = |tile: usize| {
        std::array::from_fn(|packet| {
            let [columns, rows] = extent_of(packet);
            let pixels = |samples: Range<usize>, first: usize| {
                (first + samples.start) / n..(first + samples.end).div_ceil(n)
            };
            block(pixels(columns, tile % n * TILE), pixels(rows, tile / n * TILE))
        })
    };
    (0..n * n).map(of_tile).collect()
}
