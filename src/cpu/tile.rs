//! Many spheres: tiles of neighbouring pixels go through the hierarchy together.
//!
//! A tile visits the spheres whose footprints share a cell with it, near ones first, and tests
//! each against those of its packets of eight rays that it may cover. What is left out is certainly
//! not hit, or certainly farther than a certain hit of every ray. So what is decided is right, and
//! more may be decided than by the whole list.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::marker::PhantomData;

use crate::guard;
use crate::kernel::RayOf;
use crate::kernel::certified::{
    Filter, GuardOf, Nearest, Nearness, ParallelFilter, PointFilter, SphereFar, Widening,
    closest_approach, far_nearness_at, parallel_nearness_at,
};
use crate::rays::{CameraF32, Pixels};
use crate::tree::footprints::{Cells, Footprints};
use crate::vec3::Vec3;

/// Columns and rows of a tile, px.
pub const TILE: usize = 8;

/// Rays of neighbouring pixels that go side by side: two registers of four, or one of eight.
const PACKET: usize = 8;

/// Columns and rows of a packet, px.
const PACKET_SIZE: [usize; 2] = [4, 2];

/// Packets of a tile.
const PACKETS: usize = TILE * TILE / PACKET;

/// Eight numbers side by side.
type Lanes<T> = [T; PACKET];

/// The rays of a bundle, and how they meet the spheres of the hierarchy.
pub(super) trait TileRays {
    /// The filter of all other objects.
    type Filter: Filter;
    /// The vector in which the rays differ.
    fn own(ray: &RayOf<f32>) -> Vec3<f32>;
    /// Parameter of the point closest to the sphere's centre, and its squared distance; `forward`
    /// is the view axis.
    fn closest_approach(
        own: Vec3<f32>,
        forward: Vec3<f32>,
        inv_a: f32,
        sphere: &SphereFar,
    ) -> (f32, f32);
    /// The root from there.
    fn nearness(
        s: f32,
        m: f32,
        inv_a: f32,
        sphere: &SphereFar,
        widening: &Widening<f32>,
    ) -> Nearness<f32>;

    /// A ray and a sphere of the hierarchy.
    #[inline(always)]
    fn leaf(ray: &RayOf<f32>, sphere: &SphereFar, widening: &Widening<f32>) -> Nearness<f32> {
        let (s, m) = Self::closest_approach(Self::own(ray), ray.direction, ray.inv_a, sphere);
        Self::nearness(s, m, ray.inv_a, sphere, widening)
    }
}

/// They start at the reference point, far from the spheres.
pub(super) struct PointRays;

/// They run along the view axis.
pub(super) struct ParallelRays;

impl TileRays for PointRays {
    type Filter = PointFilter;

    #[inline(always)]
    fn own(ray: &RayOf<f32>) -> Vec3<f32> {
        ray.direction
    }

    #[inline(always)]
    fn closest_approach(
        own: Vec3<f32>,
        _: Vec3<f32>,
        inv_a: f32,
        sphere: &SphereFar,
    ) -> (f32, f32) {
        closest_approach(own, inv_a, Vec3(sphere.center))
    }

    #[inline(always)]
    fn nearness(
        s: f32,
        m: f32,
        inv_a: f32,
        sphere: &SphereFar,
        widening: &Widening<f32>,
    ) -> Nearness<f32> {
        let &SphereFar { inner2, outer2, q_or_slack, .. } = sphere;
        let root = far_nearness_at(s, m, inv_a, inner2, outer2, q_or_slack);
        Nearness { low: root.low * widening.far_narrower, ..root }
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
        sphere: &SphereFar,
    ) -> (f32, f32) {
        closest_approach(forward, inv_a, Vec3(sphere.center) - own)
    }

    #[inline(always)]
    fn nearness(
        s: f32,
        m: f32,
        inv_a: f32,
        sphere: &SphereFar,
        widening: &Widening<f32>,
    ) -> Nearness<f32> {
        let &SphereFar { inner2, outer2, q_or_slack: slack, .. } = sphere;
        parallel_nearness_at(s, m, inv_a, &GuardOf { inner2, outer2, slack }, widening)
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

/// The nearest objects of the pixels of one tile after the other.
pub(super) struct TileTracer<'a, T> {
    footprints: &'a Footprints,
    far: &'a [SphereFar],
    pixels: &'a Pixels,
    camera: CameraF32,
    widening: Widening<f32>,
    packets: [Packet; PACKETS],
    rays: PhantomData<T>,
}

impl<'a, T: TileRays> TileTracer<'a, T> {
    /// A tracer of the spheres that `pixels` may see.
    pub fn new(footprints: &'a Footprints, far: &'a [SphereFar], pixels: &'a Pixels) -> Self {
        let camera = CameraF32::new(pixels);
        let widening = guard::widening_f32();
        let packets = [Packet::default(); PACKETS];
        TileTracer { footprints, far, pixels, camera, widening, packets, rays: PhantomData }
    }

    /// Traces the tile whose left upper pixel this is. `others` gives the nearest of the objects
    /// that are not in the hierarchy.
    #[inline(always)]
    pub fn trace(&mut self, x: u32, y: u32, others: impl Fn(&RayOf<f32>) -> Nearest<f32>) {
        for number in 0..PACKETS {
            self.start(number, x, y, &others);
        }
        let last = TILE as u32 - 1;
        let cells = self.footprints.cells([x, y], self.in_picture(x + last, y + last));
        let mut t_max = self.farthest();
        self.footprints.visit(cells, t_max, |node, at| {
            let sphere = &self.far[at];
            let mut hit = false;
            for packet in &mut self.packets {
                if node.covers(packet.cells) && node.t() <= packet.t_max {
                    hit |= test_packet::<T>(packet, sphere, self.camera.forward, &self.widening);
                }
            }
            if hit {
                t_max = self.farthest();
            }
            t_max
        });
    }

    /// The pixel, or the picture's last one where it ends before. So the rays of a tile that the
    /// picture cuts off are rays of the picture too, and no longer in sight than those.
    #[inline(always)]
    fn in_picture(&self, x: u32, y: u32) -> [u32; 2] {
        [x.min(self.pixels.image_width - 1), y.min(self.pixels.image_height - 1)]
    }

    #[inline(always)]
    fn start(
        &mut self,
        number: usize,
        x: u32,
        y: u32,
        others: &impl Fn(&RayOf<f32>) -> Nearest<f32>,
    ) {
        let pixel = |lane: usize| {
            let (column, row) = place(number, lane);
            self.in_picture(x + column as u32, y + row as u32)
        };
        let mut packet = Packet {
            cells: self.footprints.cells(pixel(0), pixel(PACKET - 1)),
            ..Packet::default()
        };
        for lane in 0..PACKET {
            let [x, y] = pixel(lane);
            let (i, j) = self.pixels.offset2(x, y);
            let ray = self.camera.camera_ray(i as f32, j as f32);
            for axis in 0..3 {
                packet.own[axis][lane] = T::own(&ray).0[axis];
            }
            (packet.a[lane], packet.inv_a[lane]) = (ray.a, ray.inv_a);
            let nearest = others(&ray);
            packet.low[lane] = nearest.low;
            packet.high[lane] = nearest.high;
            packet.second_high[lane] = nearest.second_high;
            packet.id[lane] = nearest.id;
        }
        packet.t_max = t_bound(&packet);
        self.packets[number] = packet;
    }

    /// An upper bound of the `t` of every ray's nearest hit.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        self.packets.iter().fold(0.0, |farthest, packet| farthest.max(packet.t_max))
    }

    /// The nearest object of a pixel of the tile.
    #[inline(always)]
    pub fn nearest(&self, x: usize, y: usize) -> Nearest<f32> {
        let [width, height] = PACKET_SIZE;
        let packet = &self.packets[y / height * (TILE / width) + x / width];
        let lane = y % height * width + x % width;
        Nearest {
            low: packet.low[lane],
            high: packet.high[lane],
            second_high: packet.second_high[lane],
            id: packet.id[lane],
        }
    }
}

/// [`guard::t_bound_f32`] of the packet's ray that sees farthest.
#[inline(always)]
fn t_bound(packet: &Packet) -> f32 {
    let mut least = f32::MAX;
    for lane in 0..PACKET {
        let nearness = packet.a[lane] * packet.low[lane];
        least = if nearness < least { nearness } else { least };
    }
    guard::t_bound_f32(least)
}

/// The same steps as the filter's on a record and [`Nearest::nearer`], each for eight rays before the
/// next, so that the compiler finds them side by side.
#[inline(always)]
fn test_packet<T: TileRays>(
    packet: &mut Packet,
    sphere: &SphereFar,
    forward: Vec3<f32>,
    widening: &Widening<f32>,
) -> bool {
    let Packet { own, inv_a, .. } = *packet;
    let (mut s, mut m) = ([0.0; PACKET], [0.0; PACKET]);
    for k in 0..PACKET {
        let own = Vec3([own[0][k], own[1][k], own[2][k]]);
        (s[k], m[k]) = T::closest_approach(own, forward, inv_a[k], sphere);
    }
    let mut hit = false;
    for &m in &m {
        hit |= m <= sphere.outer2;
    }
    if !hit {
        return false;
    }
    let (mut low, mut high) = ([0.0; PACKET], [0.0; PACKET]);
    for k in 0..PACKET {
        let root = T::nearness(s[k], m[k], inv_a[k], sphere, widening);
        (low[k], high[k]) = (root.low, root.high);
    }
    let mut best = *packet;
    for k in 0..PACKET {
        let is_nearer = high[k] > best.high[k];
        let farther = if is_nearer { best.high[k] } else { high[k] };
        best.low[k] = if is_nearer { low[k] } else { best.low[k] };
        best.high[k] = if is_nearer { high[k] } else { best.high[k] };
        best.id[k] = if is_nearer { sphere.id } else { best.id[k] };
        let second = best.second_high[k];
        best.second_high[k] = if farther > second { farther } else { second };
    }
    best.t_max = t_bound(&best);
    *packet = best;
    true
}
