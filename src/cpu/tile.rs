//! Many spheres: tiles of neighbouring pixels go through the hierarchy together.
//!
//! A tile visits the spheres whose footprints share a cell with it, near ones first, and tests
//! each against those of its packets of eight rays that it may cover. What is left out is certainly
//! not hit, or certainly farther than a certain hit of every ray. So what is decided is right, and
//! more may be decided than by the whole list.
//!
//! A ray may stand for all samples of its pixel, with the bounds of [`crate::guard::Reach`]. The
//! footprints are of the samples, and what is decided holds for all of them.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::marker::PhantomData;
use std::ops::Range;

use super::listed::Listed;
use crate::guard::{self, Reach};
use crate::kernel::RayOf;
use crate::kernel::certified::{
    Filter, GuardOf, Nearest, Nearness, ParallelFilter, PointFilter, SphereCertified, SphereFar,
    Widening, closest_approach, far_nearness_at, parallel_nearness_at,
};
use crate::rays::{CameraF32, Pixels};
use crate::tree::footprints::{Cells, Footprints, Leaves};
use crate::vec3::{Real, Vec3};

/// Columns and rows of a tile, px.
pub const TILE: usize = 8;

/// Rays of neighbouring pixels that go side by side: two registers of four, or one of eight.
const PACKET: usize = 8;

/// Columns and rows of a packet, px.
const PACKET_SIZE: [usize; 2] = [4, 2];

/// Packets of a tile, row by row.
pub(super) const PACKETS: usize = TILE * TILE / PACKET;

/// All packets of a tile, a bit each.
pub(super) const ALL: u8 = u8::MAX;

/// The packets of a tile's left half.
const LEFT: u8 = 0b0101_0101;

/// Eight numbers side by side.
type Lanes<T> = [T; PACKET];

/// A sphere of the hierarchy with its guard.
#[derive(Clone, Copy)]
pub(crate) struct Leaf {
    center: Vec3<f32>,
    guard: GuardOf<f32>,
    /// [`SphereCertified::q_low`] and what follows it; of a [`SphereFar`] the upper one alone.
    q: Nearness<f32>,
    id: u32,
}

impl Leaf {
    /// With the numbers of rays.
    #[inline(always)]
    pub fn of_rays(sphere: &SphereFar) -> Leaf {
        let &SphereFar { center, inner2, outer2, q_or_slack, id, .. } = sphere;
        let guard = GuardOf { inner2, outer2, slack: q_or_slack };
        Leaf { center: Vec3(center), guard, q: Nearness { low: 0.0, high: q_or_slack }, id }
    }

    /// With the numbers of squares.
    #[inline(always)]
    pub fn of_squares(sphere: &SphereCertified, id: u32) -> Leaf {
        let q = Nearness { low: sphere.q_low, high: sphere.q_high_or_r2 };
        Leaf { center: Vec3(sphere.center), guard: sphere.guard(), q, id }
    }
}

/// The rays of a bundle, and how they meet the spheres of the hierarchy.
pub(crate) trait TileRays {
    /// The filter of all other objects.
    type Filter: Filter;
    /// The vector in which the rays differ.
    fn own(ray: &RayOf<f32>) -> Vec3<f32>;
    /// Parameter of the point closest to a sphere's centre, and its squared distance; `forward`
    /// is the view axis.
    fn closest_approach(
        own: Vec3<f32>,
        forward: Vec3<f32>,
        inv_a: f32,
        center: Vec3<f32>,
    ) -> (f32, f32);
    /// The root from there.
    fn nearness(s: f32, m: f32, inv_a: f32, leaf: &Leaf, widening: &Widening<f32>)
    -> Nearness<f32>;

    /// A ray and a sphere of the hierarchy.
    #[cfg(feature = "gpu")]
    #[inline(always)]
    fn leaf(ray: &RayOf<f32>, leaf: &Leaf, widening: &Widening<f32>) -> Nearness<f32> {
        let (s, m) = Self::closest_approach(Self::own(ray), ray.direction, ray.inv_a, leaf.center);
        Self::nearness(s, m, ray.inv_a, leaf, widening)
    }
}

/// They start at the reference point, far from the spheres.
pub(crate) struct PointRays;

/// The same for rays that stand for the samples of squares, whose slack is no small part of a root.
pub(super) struct PointSquares;

/// They run along the view axis.
pub(crate) struct ParallelRays;

impl TileRays for PointRays {
    type Filter = PointFilter;

    #[inline(always)]
    fn own(ray: &RayOf<f32>) -> Vec3<f32> {
        ray.direction
    }

    #[inline(always)]
    fn closest_approach(own: Vec3<f32>, _: Vec3<f32>, inv_a: f32, center: Vec3<f32>) -> (f32, f32) {
        closest_approach(own, inv_a, center)
    }

    #[inline(always)]
    fn nearness(
        s: f32,
        m: f32,
        inv_a: f32,
        leaf: &Leaf,
        widening: &Widening<f32>,
    ) -> Nearness<f32> {
        let GuardOf { inner2, outer2, .. } = leaf.guard;
        let root = far_nearness_at(s, m, inv_a, inner2, outer2, leaf.q.high);
        Nearness { low: root.low * widening.far_narrower, ..root }
    }
}

impl TileRays for PointSquares {
    type Filter = PointFilter;

    #[inline(always)]
    fn own(ray: &RayOf<f32>) -> Vec3<f32> {
        PointRays::own(ray)
    }

    #[inline(always)]
    fn closest_approach(
        own: Vec3<f32>,
        forward: Vec3<f32>,
        inv_a: f32,
        center: Vec3<f32>,
    ) -> (f32, f32) {
        PointRays::closest_approach(own, forward, inv_a, center)
    }

    #[inline(always)]
    fn nearness(s: f32, m: f32, inv_a: f32, leaf: &Leaf, _: &Widening<f32>) -> Nearness<f32> {
        let GuardOf { inner2, outer2, slack } = leaf.guard;
        let (inner, outer) = (inner2 - m, outer2 - m);
        let low = ((s - slack) + (Real::max(inner, 0.0) * inv_a).sqrt()) * leaf.q.low;
        let high = ((s + slack) + (Real::max(outer, 0.0) * inv_a).sqrt()) * leaf.q.high;
        Nearness {
            low: if inner < 0.0 { 0.0 } else { low },
            high: if outer < 0.0 { 0.0 } else { high },
        }
    }
}

impl TileRays for ParallelRays {
    type Filter = ParallelFilter;

    #[inline(always)]
    fn own(ray: &RayOf<f32>) -> Vec3<f32> {
        ray.origin
    }

    #[inline(always)]
    fn closest_approach(
        own: Vec3<f32>,
        forward: Vec3<f32>,
        inv_a: f32,
        center: Vec3<f32>,
    ) -> (f32, f32) {
        closest_approach(forward, inv_a, center - own)
    }

    #[inline(always)]
    fn nearness(
        s: f32,
        m: f32,
        inv_a: f32,
        leaf: &Leaf,
        widening: &Widening<f32>,
    ) -> Nearness<f32> {
        parallel_nearness_at(s, m, inv_a, &leaf.guard, widening)
    }
}

/// The rays of a packet, and the nearest object of each.
#[derive(Clone, Copy, Default)]
#[repr(C, align(32))]
struct Packet {
    own: [Lanes<f32>; 3],
    a: Lanes<f32>,
    inv_a: Lanes<f32>,
    low: Lanes<f32>,
    high: Lanes<f32>,
    second_high: Lanes<f32>,
    id: Lanes<u32>,
    cells: Cells,
    /// An upper bound of the `t` of every ray's nearest hit.
    t_max: f32,
}

/// Column and row of a ray in its tile, px.
#[inline(always)]
fn place(packet: usize, lane: usize) -> (usize, usize) {
    let [width, height] = PACKET_SIZE;
    let per_row = TILE / width;
    (packet % per_row * width + lane % width, packet / per_row * height + lane / width)
}

impl Packet {
    #[inline(always)]
    fn nearest(&self, lane: usize) -> Nearest<f32> {
        Nearest {
            low: self.low[lane],
            high: self.high[lane],
            second_high: self.second_high[lane],
            id: self.id[lane],
        }
    }
}

/// Columns and rows of a packet in its tile.
pub(super) fn extent_of(packet: usize) -> [Range<usize>; 2] {
    let [width, height] = PACKET_SIZE;
    let (x, y) = place(packet, 0);
    [x..x + width, y..y + height]
}

/// First and last column and row of some packets in their tile, px.
#[inline(always)]
fn extent(packets: u8) -> [[u32; 2]; 2] {
    let [width, height] = PACKET_SIZE.map(|side| side as u32);
    let first_column = if packets & LEFT != 0 { 0 } else { width };
    let end_column = if packets & !LEFT != 0 { TILE as u32 } else { width };
    let [first, last] = [packets.trailing_zeros(), 7 - packets.leading_zeros()];
    [[first_column, first / 2 * height], [end_column - 1, last / 2 * height + height - 1]]
}

/// The nearest objects of the pixels of one tile after the other.
pub(super) struct TileTracer<'a, T> {
    footprints: &'a Footprints,
    listed: Listed<'a>,
    pixels: &'a Pixels,
    camera: CameraF32,
    widening: Widening<f32>,
    t_room: f32,
    /// Columns and rows of the footprints' picture to each of a pixel.
    n: u32,
    packets: [Packet; PACKETS],
    rays: PhantomData<T>,
}

impl<'a, T: TileRays> TileTracer<'a, T> {
    /// A tracer of the spheres that `pixels` may see, and of the `listed` objects.
    pub fn new(footprints: &'a Footprints, listed: Listed<'a>, pixels: &'a Pixels) -> Self {
        TileTracer {
            footprints,
            listed,
            pixels,
            camera: CameraF32::new(pixels),
            widening: guard::widening_f32(),
            t_room: guard::T_ROOM,
            n: 1,
            packets: [Packet::default(); PACKETS],
            rays: PhantomData,
        }
    }

    /// The same where each ray stands for `n` × `n` samples within `reach`, whose picture the footprints are of.
    pub fn of_squares(self, n: u32, reach: &Reach) -> Self {
        TileTracer { widening: reach.widening_f32(), t_room: reach.t_room(), n, ..self }
    }

    /// Traces these packets of the tile whose left upper pixel this is, through `leaves`, of which `leaf` gives
    /// the sphere at a place. False where every ray sees the background.
    #[inline(always)]
    pub fn trace(
        &mut self,
        [x, y]: [u32; 2],
        packets: u8,
        leaves: &impl Leaves,
        leaf: impl Fn(usize) -> Leaf,
    ) -> bool {
        let mut has_begun = !self.listed.is_empty();
        if has_begun {
            self.start([x, y], packets);
        }
        let mut t_max = if has_begun { self.farthest() } else { f32::MAX };
        // No closure: what the compiler doesn't put in its place is made for any processor.
        let (cells, mut at) = (self.cells_of([x, y], packets), 0);
        while let Some((node, place)) = leaves.next(&mut at, cells, t_max) {
            if !has_begun {
                self.start([x, y], packets);
                has_begun = true;
                t_max = self.farthest();
            }
            let leaf = leaf(place);
            let mut hit = false;
            for packet in &mut self.packets {
                if node.covers(packet.cells) && node.t() <= packet.t_max {
                    let forward = self.camera.forward;
                    hit |= test_packet::<T>(packet, &leaf, forward, &self.widening, self.t_room);
                }
            }
            if hit {
                t_max = self.farthest();
            }
        }
        has_begun
    }

    /// The cells of these packets of the tile whose left upper pixel this is.
    #[inline(always)]
    pub fn cells_of(&self, [x, y]: [u32; 2], packets: u8) -> Cells {
        let [first, last] = extent(packets);
        let pixel = |[column, row]: [u32; 2]| self.in_picture(x + column, y + row);
        self.cells(pixel(first), pixel(last))
    }

    /// The pixel, or the picture's last one where it ends before. So the rays of a tile that the
    /// picture cuts off are rays of the picture too, and no longer in sight than those.
    #[inline(always)]
    fn in_picture(&self, x: u32, y: u32) -> [u32; 2] {
        [x.min(self.pixels.image_width - 1), y.min(self.pixels.image_height - 1)]
    }

    /// The cells of all samples of the pixels from the `first` to the `last`.
    #[inline(always)]
    fn cells(&self, first: [u32; 2], last: [u32; 2]) -> Cells {
        let n = self.n;
        self.footprints.cells(first.map(|side| side * n), last.map(|side| side * n + (n - 1)))
    }

    #[inline(always)]
    fn start(&mut self, [x, y]: [u32; 2], packets: u8) {
        for number in 0..PACKETS {
            if packets & 1 << number == 0 {
                self.packets[number] = Packet { cells: Cells::NONE, ..Packet::default() };
                continue;
            }
            let pixel = |lane: usize| {
                let (column, row) = place(number, lane);
                self.in_picture(x + column as u32, y + row as u32)
            };
            let mut packet =
                Packet { cells: self.cells(pixel(0), pixel(PACKET - 1)), ..Packet::default() };
            for lane in 0..PACKET {
                let [x, y] = pixel(lane);
                let (i, j) = self.pixels.offset2(x, y);
                let ray = self.camera.camera_ray(i as f32, j as f32);
                for axis in 0..3 {
                    packet.own[axis][lane] = T::own(&ray).0[axis];
                }
                (packet.a[lane], packet.inv_a[lane]) = (ray.a, ray.inv_a);
                let nearest = self.listed.nearest::<T::Filter>(&ray, &self.widening);
                packet.low[lane] = nearest.low;
                packet.high[lane] = nearest.high;
                packet.second_high[lane] = nearest.second_high;
                packet.id[lane] = nearest.id;
            }
            packet.t_max = t_bound(&packet, self.t_room);
            self.packets[number] = packet;
        }
    }

    /// An upper bound of the `t` of every ray's nearest hit.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        self.packets.iter().fold(0.0, |farthest, packet| farthest.max(packet.t_max))
    }

    /// The objects that the rays of the tile are proven to see, row by row.
    #[inline(always)]
    pub fn ids(&self) -> [u32; TILE * TILE] {
        let mut ids = [0; TILE * TILE];
        for (number, packet) in self.packets.iter().enumerate() {
            for lane in 0..PACKET {
                let (x, y) = place(number, lane);
                ids[y * TILE + x] = packet.nearest(lane).decide();
            }
        }
        ids
    }
}

/// [`guard::t_bound_in`] of the packet's ray that sees farthest.
#[inline(always)]
fn t_bound(packet: &Packet, room: f32) -> f32 {
    let mut least = f32::MAX;
    for lane in 0..PACKET {
        let nearness = packet.a[lane] * packet.low[lane];
        least = if nearness < least { nearness } else { least };
    }
    guard::t_bound_in(room, least)
}

/// The same steps as the filter's on a record and [`Nearest::nearer`], each for eight rays before the
/// next, so that the compiler finds them side by side.
#[inline(always)]
fn test_packet<T: TileRays>(
    packet: &mut Packet,
    leaf: &Leaf,
    forward: Vec3<f32>,
    widening: &Widening<f32>,
    t_room: f32,
) -> bool {
    let Packet { own, inv_a, .. } = *packet;
    let (mut s, mut m) = ([0.0; PACKET], [0.0; PACKET]);
    for k in 0..PACKET {
        let own = Vec3([own[0][k], own[1][k], own[2][k]]);
        (s[k], m[k]) = T::closest_approach(own, forward, inv_a[k], leaf.center);
    }
    let mut hit = false;
    for &m in &m {
        hit |= m <= leaf.guard.outer2;
    }
    if !hit {
        return false;
    }
    let (mut low, mut high) = ([0.0; PACKET], [0.0; PACKET]);
    for k in 0..PACKET {
        let root = T::nearness(s[k], m[k], inv_a[k], leaf, widening);
        (low[k], high[k]) = (root.low, root.high);
    }
    let mut best = *packet;
    for k in 0..PACKET {
        let is_nearer = high[k] > best.high[k];
        let farther = if is_nearer { best.high[k] } else { high[k] };
        best.low[k] = if is_nearer { low[k] } else { best.low[k] };
        best.high[k] = if is_nearer { high[k] } else { best.high[k] };
        best.id[k] = if is_nearer { leaf.id } else { best.id[k] };
        let second = best.second_high[k];
        best.second_high[k] = if farther > second { farther } else { second };
    }
    best.t_max = t_bound(&best, t_room);
    *packet = best;
    true
}
