//! Many spheres: what the pixels of a picture and their samples see through the tree, in f32.
//!
//! A square of pixels first cuts the tree: it takes the boxes that any of its rays may meet, near ones first. Packs of
//! neighbouring rays begin their walks there, some together. What a walk leaves out is certainly not hit, or certainly
//! farther than a certain hit of every ray. So what is decided is right.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::slice::from_ref;
use std::sync::Arc;

use glam::DVec3;
use pulp::{Simd, WithSimd};

use super::batch::RayBatch;
use crate::bounds::{Footprint, LARGEST_TURN};
use crate::bvh::{Beam, Bvh, Enter, Frontier, Leaves, Node, Traversal, Visitor};
use crate::num::{Bits, Float, Lanes, Real, UNDECIDED, dispatch};
use crate::prepare::Prepared;
use crate::query::Mixed;
use crate::rays::{Frame, Lens, Pixels};
use crate::shape::{Nearest, Objects, Ray, RayOrigin};

/// The beams of a picture's rays, relative to a tree.
pub struct TreeAim<'a> {
    /// The tree.
    pub bvh: &'a Bvh,
    /// The camera's position.
    position: DVec3,
    forward: DVec3,
    /// Half a pixel to the right, and to the top.
    right_step: DVec3,
    true_up_step: DVec3,
    lens: Lens,
    end: f64,
}

impl<'a> TreeAim<'a> {
    /// Makes what the beams of a picture's rays come from, for a tree.
    pub fn new(bvh: &'a Bvh, pixels: &Pixels) -> TreeAim<'a> {
        let view = &pixels.view;
        let step = view.h / f64::from(pixels.image_height);
        let mut aim = TreeAim {
            bvh,
            position: view.position - bvh.reference,
            forward: view.forward,
            right_step: view.right * step,
            true_up_step: view.true_up * step,
            lens: view.lens,
            end: 0.0,
        };
        let [width, height] = [pixels.image_width, pixels.image_height].map(|side| side as f32);
        let [origins, _] = aim.corners([-width, width], [-height, height]);
        aim.end = bvh.end(origins);
        aim
    }

    /// Bounds of the origins and the directions of all rays with twice their offsets from the picture's centre between these:
    /// to the right, and to the top.
    #[inline(always)]
    fn corners(&self, [left, right]: [f32; 2], [bottom, top]: [f32; 2]) -> [[DVec3; 2]; 2] {
        let (a, b) = (self.right_step * f64::from(left), self.right_step * f64::from(right));
        let (c, d) = (self.true_up_step * f64::from(bottom), self.true_up_step * f64::from(top));
        let (low, high) = (a.min(b) + c.min(d), a.max(b) + c.max(d));
        let moved = |at: DVec3| {
            // Of a step two roundings, of a product one, of a sum two, of the position one: half of it would do.
            let room =
                (a.abs().max(b.abs()) + c.abs().max(d.abs()) + at.abs()) * (8.0 * f64::EPSILON);
            [at + low - room, at + high + room]
        };
        let room = self.position.abs() * f64::EPSILON;
        match self.lens {
            Lens::Perspective => {
                [[self.position - room, self.position + room], moved(self.forward)]
            }
            Lens::Orthographic => [moved(self.position), [self.forward; 2]],
        }
    }

    /// A beam of all rays between these.
    #[inline(always)]
    pub fn beam(&self, across: [f32; 2], up: [f32; 2]) -> Beam {
        let [origins, directions] = self.corners(across, up);
        Beam::new(origins, directions, self.end)
    }
}

/// The objects as the rays of a picture see them: in the tree, and beside it.
struct FootprintView {
    leaves: Arc<Leaves>,
    beside: Objects<f32>,
    /// How far the rays reach for which one stands, in half pixels.
    reach: f32,
}

/// Lanes of a pack: pixels of a square of four by four.
const LANES: usize = 16;
const SIDE: u32 = 4;

/// Packs that walk together, a square as well.
const TOGETHER: usize = 4;

/// Squares whose samples are looked at at once, after one whose pixels show several objects each: where spheres are small, so
/// are their neighbours.
const PASSED: u32 = 7;

/// Columns and rows of the squares of samples that cut the tree together.
const COLUMNS: u32 = 64;
const ROWS: u32 = 16;

/// Rays side by side, and what they see.
struct PixelPack {
    ray: Ray<Lanes<f32, LANES>>,
    best: Nearest<Lanes<f32, LANES>>,
    beam: Beam,
    /// No ray sees what is farther.
    last: f32,
}

/// The least and the most of some packs' numbers: where these fill a square, of those of the first ray and of the last.
#[inline(always)]
fn extent(packs: &[[f32; LANES]], fill_a_square: bool) -> [f32; 2] {
    if fill_a_square {
        let (first, last) = (packs[0][0], packs[packs.len() - 1][LANES - 1]);
        return [Real::min(first, last), Real::max(first, last)];
    }
    let (mut low, mut high) = (Lanes(packs[0]), Lanes(packs[0]));
    for pack in &packs[1..] {
        (low, high) = (low.min(Lanes(*pack)), high.max(Lanes(*pack)));
    }
    [low.joined(Real::min), high.joined(Real::max)]
}

/// Packs on their way together.
struct PacketVisitor<'a> {
    search: &'a CloudSearch<'a>,
    sight: &'a FootprintView,
    across: &'a [[f32; LANES]],
    up: &'a [[f32; LANES]],
    /// Whether they, and each of them, fill a square, from its left upper corner to its right lower one.
    fill_a_square: bool,
    /// None before something is met.
    packs: &'a mut Vec<PixelPack>,
    last: f32,
}

impl PacketVisitor<'_> {
    /// The beam of some of the packs.
    #[inline(always)]
    fn beam(&self, across: &[[f32; LANES]], up: &[[f32; LANES]]) -> Beam {
        let bounds = |packs| wider(extent(packs, self.fill_a_square), self.sight.reach);
        self.search.aim.beam(bounds(across), bounds(up))
    }

    #[inline(always)]
    fn begin(&mut self) {
        let CloudSearch { camera, .. } = self.search;
        for (across, up) in self.across.iter().zip(self.up) {
            let ray = camera.ray(Lanes(*across), Lanes(*up));
            let beam = self.beam(from_ref(across), from_ref(up));
            self.packs.push(PixelPack { ray, best: Nearest::none(), beam, last: self.last });
        }
    }

    /// Looks at what is beside the tree.
    #[inline(always)]
    fn look_beside(&mut self) {
        for pack in &mut *self.packs {
            pack.best = self.sight.beside.nearest(&pack.ray);
            pack.last = pack.best.high().joined(Real::max);
        }
    }
}

impl Visitor for PacketVisitor<'_> {
    #[inline(always)]
    fn last(&self) -> f32 {
        self.last
    }

    #[inline(always)]
    fn expect(&self, place: u32) {
        self.sight.leaves.expect(place);
    }

    #[inline(always)]
    fn visit(&mut self, node: &Node, leaves: u32, _: &Enter) {
        if self.packs.is_empty() {
            self.begin();
        }
        self.last = 0.0;
        for pack in &mut *self.packs {
            let mut hits = pack.beam.among(node, leaves, pack.last);
            let mut is_met = false;
            while hits != 0 {
                let place = node.place(hits.trailing_zeros());
                hits &= hits - 1;
                is_met |= self.sight.leaves.add(place, &pack.ray, &mut pack.best);
            }
            if is_met {
                pack.last = pack.best.high().joined(Real::max);
            }
            self.last = Real::max(self.last, pack.last);
        }
    }
}

#[inline(always)]
fn wider([low, high]: [f32; 2], reach: f32) -> [f32; 2] {
    [low - reach, high + reach]
}

/// Memory for the squares of a picture of many spheres.
#[derive(Default)]
pub struct CloudScratch {
    tile: RayBatch,
    /// Whether its packs, and four of them together, fill squares.
    fill_a_square: bool,
    /// The pixels of the tile, by their places among those of the rows.
    index: Vec<u32>,
    cut: Frontier,
    walk: Traversal,
    packs: Vec<PixelPack>,
}

/// A tile, compiled for each instruction set that the processor may have.
struct FindInTree<'a> {
    search: &'a CloudSearch<'a>,
    sight: &'a FootprintView,
    room: &'a mut CloudScratch,
}

impl WithSimd for FindInTree<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let FindInTree { search, sight, room } = self;
        let CloudScratch { tile, fill_a_square, cut, walk, packs, .. } = room;
        let (across, up, ids) = tile.packs::<LANES>();
        let together = across.chunks(TOGETHER).zip(up.chunks(TOGETHER));
        for ((across, up), ids) in together.zip(ids.chunks_mut(TOGETHER)) {
            packs.clear();
            let (fill_a_square, last) = (*fill_a_square, f32::BEYOND as f32);
            let mut seek = PacketVisitor { search, sight, across, up, fill_a_square, packs, last };
            let beam = seek.beam(across, up);
            if !sight.beside.is_empty() {
                seek.begin();
                seek.look_beside();
            }
            walk.all(search.aim.bvh, cut.nodes(), beam, &mut seek);
            for ids in ids.iter_mut() {
                *ids = [0; LANES];
            }
            for (pack, ids) in packs.iter().zip(ids) {
                let (found, _) = pack.best.decide();
                for lane in 0..LANES {
                    ids[lane] = found.0[lane].to_id();
                }
            }
        }
    }
}

/// A square cuts the tree, and its pixels are placed where it may see something.
struct Begin<'a> {
    search: &'a CloudSearch<'a>,
    pixels: &'a Pixels,
    corner: [u32; 2],
    size: [u32; 2],
    room: &'a mut CloudScratch,
}

impl WithSimd for Begin<'_> {
    /// Whether it may.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Begin { search, pixels, corner: [left, top], size: [columns, rows], room } = self;
        let [(across, up), (right, bottom)] = [[left, top], [left + columns - 1, top + rows - 1]]
            .map(|[x, y]| search.middle(pixels, x, y));
        let reach = search.reach;
        let beam = search.aim.beam(wider([across, right], reach), wider([bottom, up], reach));
        room.cut.make(search.aim.bvh, &beam);
        room.index.clear();
        let may_see = !room.cut.nodes().is_empty() || !search.of_rays.beside.is_empty();
        if may_see {
            search.place(pixels, [left, top], [columns, rows], room);
        }
        may_see
    }
}

/// Pixels of a picture of many spheres.
pub struct CloudSearch<'a> {
    /// Samples across and down a pixel.
    n: u32,
    /// How far they are from a pixel's middle, in half steps between them.
    reach: f32,
    aim: TreeAim<'a>,
    camera: Frame<f32>,
    /// As one ray a pixel stands for all its samples; not of one sample, nor where pixels are too large for the bounds.
    of_pixels: Option<FootprintView>,
    of_rays: FootprintView,
}

impl<'a> CloudSearch<'a> {
    /// For `n` × `n` samples of each of these pixels, with squares whose rays are said to be this share as far apart as they
    /// are; `None` where spheres are few.
    pub fn of(
        prepared: &'a Prepared,
        pixels: &Pixels,
        n: u32,
        share: f64,
    ) -> Option<CloudSearch<'a>> {
        let hierarchy = prepared.hierarchy.as_ref()?;
        let samples = pixels.samples(n);
        let sight = |leaves: Arc<Leaves>, eye: &RayOrigin, reach| {
            let beside = Objects::new(prepared.listed(Some(&leaves.rest)), eye);
            FootprintView { leaves, beside, reach }
        };
        let reach = (n - 1) as f32;
        let Footprint { apart, turned } = Footprint::of_samples(pixels, 1, n);
        let of_pixels = (n > 1 && turned <= LARGEST_TURN).then(|| {
            let of_square = Footprint { apart: share * apart, turned: share * turned };
            let eye = RayOrigin::of_pixels(&samples, of_square, f32::UNIT);
            sight(hierarchy.of_squares(&eye), &eye, reach)
        });
        let eye = RayOrigin::of_pixels(&samples, Footprint::default(), f32::UNIT);
        Some(CloudSearch {
            n,
            reach,
            aim: TreeAim::new(&hierarchy.bvh, &samples),
            camera: Frame::of_pixels(&samples),
            of_pixels,
            of_rays: sight(Arc::clone(&hierarchy.leaves), &eye, 0.0),
        })
    }

    /// [`Search::look`](super::Search::look)
    pub fn look(&self, pixels: &Pixels, whole: &mut [u32], room: &mut CloudScratch) -> Mixed {
        let &Pixels { width, height, .. } = pixels;
        let (mut mixed, mut ids) = Mixed::default();
        // Squares in which pixels are not worth a look before their samples.
        let mut n_passed = 0;
        // A square has about as many rays as one of single samples.
        let [columns, rows] =
            [COLUMNS, ROWS].map(|side| (side / self.n).next_multiple_of(8).max(8));
        for y in (0..height).step_by(rows as usize) {
            for x in (0..width).step_by(columns as usize) {
                let size = [columns.min(width - x), rows.min(height - y)];
                let of_pixels = self.of_pixels.as_ref().filter(|_| n_passed == 0);
                self.look_at_square(pixels, [x, y], size, of_pixels, whole, room);
                if self.n == 1 {
                    continue;
                }
                let n_open = room.index.len() as u32;
                let n_decided = size[0] * size[1] - n_open;
                n_passed = match n_passed {
                    0 if n_decided * self.n * self.n < 2 * n_open => PASSED,
                    0 => 0,
                    n => n - 1,
                };
                if !room.index.is_empty() {
                    self.sample(pixels, whole, room, &mut mixed, &mut ids);
                }
            }
        }
        // By rows, as they were found by squares.
        let samples = ids.chunks_exact((self.n * self.n) as usize);
        let mut all: Vec<(u32, &[u32])> = mixed.into_iter().zip(samples).collect();
        all.sort_unstable_by_key(|&(at, _)| at);
        let (mixed, ids): (Vec<u32>, Vec<&[u32]>) = all.into_iter().unzip();
        (mixed, ids.concat())
    }

    /// Finds what the pixels of a square see; of several samples those that are left are in [`CloudScratch::index`].
    fn look_at_square(
        &self,
        pixels: &Pixels,
        corner: [u32; 2],
        size: [u32; 2],
        of_pixels: Option<&FootprintView>,
        whole: &mut [u32],
        room: &mut CloudScratch,
    ) {
        let ([left, top], [columns, rows], width) = (corner, size, pixels.width as usize);
        if !dispatch(Begin { search: self, pixels, corner, size, room }) {
            for row in whole.chunks_mut(width).skip(top as usize).take(rows as usize) {
                row[left as usize..][..columns as usize].fill(0);
            }
            return;
        }
        let sight = match of_pixels {
            Some(of_pixels) => of_pixels,
            None if self.n == 1 => &self.of_rays,
            None => return room.index.iter().for_each(|&at| whole[at as usize] = UNDECIDED),
        };
        dispatch(FindInTree { search: self, sight, room });
        let side = SIDE as usize;
        for (places, ids) in room.index.chunks(side).zip(room.tile.ids.chunks(side)) {
            if places.iter().zip(places[0]..).all(|(&at, next)| at == next) {
                whole[places[0] as usize..][..places.len()].copy_from_slice(&ids[..places.len()]);
                continue;
            }
            for (&at, &id) in places.iter().zip(ids) {
                whole[at as usize] = id;
            }
        }
        if self.n > 1 {
            room.index.retain(|&at| whole[at as usize] == UNDECIDED);
        }
    }

    /// Twice the offset of a pixel's middle from the picture's, in samples, right and up.
    #[inline(always)]
    fn middle(&self, pixels: &Pixels, x: u32, y: u32) -> (f32, f32) {
        let (i, j) = pixels.offset2(pixels.x + x, pixels.y + y);
        let n = i64::from(self.n);
        ((n * i) as f32, (n * j) as f32)
    }

    /// Puts the pixels of a square into the tile, pack by pack.
    #[inline(always)]
    fn place(
        &self,
        pixels: &Pixels,
        [left, top]: [u32; 2],
        [columns, rows]: [u32; 2],
        room: &mut CloudScratch,
    ) {
        room.fill_a_square = [columns, rows].iter().all(|side| side % (2 * SIDE) == 0);
        let CloudScratch { tile, index, .. } = room;
        let (width, step) = (pixels.width, 2.0 * self.n as f32);
        // In rows, which are written quickly; or in Morton order, so that four pixels with their samples are a square, too.
        let all: [u32; LANES] = std::array::from_fn(|k| k as u32);
        let even_bits = |k: u32| k & 1 | k >> 1 & 2;
        let in_order = match self.n {
            1 => [all.map(|k| k % SIDE), all.map(|k| k / SIDE)],
            _ => [all.map(even_bits), all.map(|k| even_bits(k >> 1))],
        };
        let packs: [[u32; 2]; TOGETHER] = [[0, 0], [SIDE, 0], [0, SIDE], [SIDE, SIDE]];
        tile.clear();
        for y in (0..rows).step_by(2 * SIDE as usize) {
            for x in (0..columns).step_by(2 * SIDE as usize) {
                for [right, down] in packs {
                    let (x, y) = (x + right, y + down);
                    if x >= columns || y >= rows {
                        continue;
                    }
                    let (across, up) = self.middle(pixels, left + x, top + y);
                    let first = (top + y) * width + left + x;
                    let (n_columns, n_rows) = (SIDE.min(columns - x), SIDE.min(rows - y));
                    let (mut places, mut i, mut j) = ([0; LANES], [0.0; LANES], [0.0; LANES]);
                    for k in 0..LANES {
                        let [column, row] = [in_order[0][k], in_order[1][k]];
                        places[k] = first + row * width + column;
                        i[k] = across + step * column as f32;
                        j[k] = up - step * row as f32;
                    }
                    if n_columns == SIDE && n_rows == SIDE {
                        index.extend_from_slice(&places);
                        tile.extend(&i, &j);
                        continue;
                    }
                    for k in 0..LANES {
                        if in_order[0][k] < n_columns && in_order[1][k] < n_rows {
                            index.push(places[k]);
                            tile.extend(&[i[k]], &[j[k]]);
                        }
                    }
                }
            }
        }
    }

    /// Finds what the samples of the pixels that are left see.
    fn sample(
        &self,
        pixels: &Pixels,
        whole: &mut [u32],
        room: &mut CloudScratch,
        mixed: &mut Vec<u32>,
        ids: &mut Vec<u32>,
    ) {
        room.tile.take_samples(pixels, self.n, &room.index);
        room.fill_a_square = false;
        dispatch(FindInTree { search: self, sight: &self.of_rays, room });
        let n_each = (self.n * self.n) as usize;
        for (&at, seen) in room.index.iter().zip(room.tile.ids.chunks_exact(n_each)) {
            let first = seen[0];
            if first != UNDECIDED && seen.iter().all(|&id| id == first) {
                whole[at as usize] = first;
            } else {
                mixed.push(at);
                ids.extend_from_slice(seen);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Distribution, Recipe};
    use crate::kernel::Kernel;
    use crate::query::Rays;
    use crate::rays::View;
    use crate::support::control::Control;

    /// Asserts that bounds by the corners are those of all rays, of each pack and of those that walk together; whether they come
    /// from corners.
    fn corners_bound_all(room: &mut CloudScratch, what: &str) -> bool {
        let (across, up, _) = room.tile.packs::<LANES>();
        for offsets in [across, up] {
            for packs in offsets.chunks(TOGETHER).chain(offsets.chunks(1)) {
                let [quick, whole] = [room.fill_a_square, false].map(|fill| extent(packs, fill));
                assert_eq!(quick, whole, "{what}: {packs:?}");
            }
        }
        room.fill_a_square
    }

    #[test]
    fn corners_bound_the_packs_of_squares() {
        let recipe = Recipe { distribution: Distribution::Uniform, count: 1000, seed: 1 };
        let scene = Arc::new(recipe.scene(&Control::default()).unwrap());
        let view = View::new(scene.camera.as_ref().unwrap());
        let pixels = Pixels::whole(view, 64, 64);
        let rays = Rays::Pixels(pixels);
        let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
        let mut n_by_corners = 0;
        for n in [1, 2, 3] {
            let search = CloudSearch::of(&prepared, &pixels, n, 1.0).unwrap();
            let mut room = CloudScratch::default();
            for columns in 1..=24 {
                for rows in 1..=24 {
                    let what = format!("{columns} × {rows} pixels, {n} × {n} samples");
                    room.index.clear();
                    search.place(&pixels, [5, 7], [columns, rows], &mut room);
                    n_by_corners += u32::from(corners_bound_all(&mut room, &what));
                    let mut whole = vec![0; pixels.len()];
                    let (mut mixed, mut ids) = Mixed::default();
                    search.sample(&pixels, &mut whole, &mut room, &mut mixed, &mut ids);
                    corners_bound_all(&mut room, &format!("samples of {what}"));
                }
            }
        }
        assert_eq!(n_by_corners, 3 * 3 * 3, "squares whose bounds are those of their corners");
    }
}
