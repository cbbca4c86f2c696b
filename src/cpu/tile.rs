//! Many far spheres: tiles of neighbouring pixels go through the hierarchy together.
//!
//! A tile has one stack. A node's children are tested against the planes around the tile and
//! against the tile's farthest nearest hit, eight boxes at a time; a sphere first against the axes
//! of the tile's packets, eight at a time, then against the eight rays of each packet that it may
//! touch. What is left out is certainly not hit, or certainly farther than a certain hit of every
//! ray: [`crate::bvh`] derives the margins. So what is
//! decided is right, and more may be decided than by the whole list.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use glam::DVec3;

use crate::bvh::{Bvh, Child, Node, WIDTH};
use crate::camera::{CameraF32, Pixels, View};
use crate::kernel::RayOf;
use crate::kernel::certified::{Nearest, SphereFar, Widening, closest_approach, far_nearness_at};
use crate::prepare::Hierarchy;
use crate::vec3::{Vec3, dot3};

/// Columns and rows of a tile, px.
pub const TILE: usize = 8;

/// Rays of a packet.
const PACKET: usize = 8;

/// Columns and rows of a packet, px.
const PACKET_SIZE: [usize; 2] = [4, 2];

/// Packets of a tile: one register of axes.
const PACKETS: usize = TILE * TILE / PACKET;

/// Relative room above `1/(a·w)` for its own rounding and that of `a`: 12 units `2⁻²³` for `a`, 4
/// for the product and the quotient.
const ROOM: f32 = 1.0 + 1.0 / (1 << 18) as f32;

/// Eight numbers side by side.
type Lanes<T> = [T; PACKET];

/// The rays of a packet, and the nearest sphere of each.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Packet {
    direction: [Lanes<f32>; 3],
    a: Lanes<f32>,
    inv_a: Lanes<f32>,
    low: Lanes<f32>,
    high: Lanes<f32>,
    second_high: Lanes<f32>,
    id: Lanes<u32>,
    /// Largest lower bound of a nearness: the nearest certain hit.
    certain: Lanes<f32>,
}

/// Column and row of a ray in its tile, px.
#[inline(always)]
fn place(packet: usize, lane: usize) -> (usize, usize) {
    let [width, height] = PACKET_SIZE;
    let per_row = TILE / width;
    (packet % per_row * width + lane % width, packet / per_row * height + lane / width)
}

/// What encloses a tile's rays. All points are relative to the eye.
struct Enclosure {
    /// Inward normals of the planes through the tile's four edges.
    normals: [Vec3<f32>; 4],
    /// `g` with `g·d = 1` for every direction `d` of the picture, so that `t = g·p`.
    depth: Vec3<f32>,
    /// `‖g‖`, rounded up.
    depth_length: f32,
    /// Directions of the packets' middles.
    axes: [[f32; PACKETS]; 3],
    /// `1/(d·d)` of the axes.
    inv_axes: [f32; PACKETS],
    /// Largest distance of a packet's direction from its axis, rounded up.
    spread: f32,
}

impl Enclosure {
    /// Of the tile whose left upper pixel has these doubled offsets from the picture's centre.
    #[inline(always)]
    fn new(frame: &TileFrame, i: f64, j: f64) -> Enclosure {
        let &TileFrame { forward, right_step, true_up_step, depth, orientation, .. } = frame;
        let (right, true_up) = (frame.right, frame.true_up);
        let reach = 2.0 * (TILE - 1) as f64;
        let edge = |i: f64, step: DVec3| forward + step * i;
        let normals = [
            true_up.cross(edge(i, right_step)),
            edge(i + reach, right_step).cross(true_up),
            right.cross(edge(j, true_up_step)),
            edge(j - reach, true_up_step).cross(right),
        ]
        .map(|normal| (normal * orientation).normalize().into());
        let [width, height] = PACKET_SIZE.map(|side| (side - 1) as f64);
        let mut axes = [[0.0; PACKETS]; 3];
        let mut inv_axes = [0.0; PACKETS];
        for packet in 0..PACKETS {
            let (x, y) = place(packet, 0);
            let (i, j) = (i + 2.0 * x as f64 + width, j - 2.0 * y as f64 - height);
            let axis: Vec3<f32> = (forward + right_step * i + true_up_step * j).into();
            for (axes, component) in axes.iter_mut().zip(axis.0) {
                axes[packet] = component;
            }
            inv_axes[packet] = 1.0 / dot3(axis, axis);
        }
        Enclosure {
            normals,
            depth: depth.into(),
            depth_length: frame.depth_length,
            axes,
            inv_axes,
            spread: frame.spread,
        }
    }

    /// Which packets a sphere may touch, one bit each; none beyond `t_max`. A point of the sphere
    /// that is seen at `t` lies within `reach + t·spread` of a packet's axis.
    #[inline(always)]
    fn touched(&self, sphere: &SphereFar, t_max: f32) -> u32 {
        let l = Vec3(sphere.center);
        let (middle, half) = (dot3(self.depth, l), sphere.reach * self.depth_length);
        if middle - half > t_max {
            return 0;
        }
        let radius = (sphere.reach + self.spread * (middle + half)) * ROOM;
        let radius2 = radius * radius * ROOM;
        let mut distance2 = [0.0; PACKETS];
        for packet in 0..PACKETS {
            let axis = Vec3([self.axes[0][packet], self.axes[1][packet], self.axes[2][packet]]);
            distance2[packet] = closest_approach(axis, self.inv_axes[packet], l).1;
        }
        let mut touched = 0;
        for packet in 0..PACKETS {
            touched |= u32::from(distance2[packet] <= radius2) << packet;
        }
        touched
    }

    /// The children of a node that the tile may see up to `t_max`, one bit each, and a lower bound
    /// of each one's `t`.
    #[inline(always)]
    fn seen(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let t = corner_products::<false>(node, self.depth);
        // Where there is no child, a corner's product is −∞ or NaN, and stays so below.
        let mut inside = corner_products::<true>(node, self.normals[0]);
        for normal in &self.normals[1..] {
            let other = corner_products::<true>(node, *normal);
            for k in 0..WIDTH {
                inside[k] = if other[k] < inside[k] { other[k] } else { inside[k] };
            }
        }
        let mut seen = 0;
        for k in 0..WIDTH {
            seen |= u32::from(inside[k] >= 0.0 && t[k] <= t_max) << k;
        }
        (seen, t)
    }
}

/// The largest (or smallest) `n·p` over each child's box.
#[inline(always)]
fn corner_products<const LARGEST: bool>(node: &Node, n: Vec3<f32>) -> [f32; WIDTH] {
    let side = |axis: usize| match (n.0[axis] > 0.0) == LARGEST {
        true => &node.high[axis],
        false => &node.low[axis],
    };
    let (x, y, z) = (side(0), side(1), side(2));
    let mut products = [0.0; WIDTH];
    for k in 0..WIDTH {
        products[k] = n.0[0] * x[k] + n.0[1] * y[k] + n.0[2] * z[k];
    }
    products
}

/// What all tiles of a picture share.
pub struct TileFrame {
    camera: CameraF32,
    forward: DVec3,
    right: DVec3,
    true_up: DVec3,
    right_step: DVec3,
    true_up_step: DVec3,
    depth: DVec3,
    depth_length: f32,
    orientation: f64,
    spread: f32,
}

impl TileFrame {
    /// Of a picture whose frame [`Pixels::is_in_range`].
    pub fn new(pixels: &Pixels) -> TileFrame {
        let View { forward, right, true_up, h, .. } = pixels.view;
        let step = h / f64::from(pixels.image_height);
        let (right_step, true_up_step) = (right * step, true_up * step);
        // Not of the steps, whose product may underflow in a very narrow view.
        let across = right.cross(true_up);
        let volume = forward.dot(across);
        let depth = across / volume;
        let [width, height] = PACKET_SIZE.map(|side| (side - 1) as f64);
        let spread = (right_step * width).length() + (true_up_step * height).length();
        TileFrame {
            camera: CameraF32::new(pixels),
            forward,
            right,
            true_up,
            right_step,
            true_up_step,
            depth,
            depth_length: depth.length() as f32 * ROOM,
            orientation: volume.signum(),
            // The rounded directions are off by some units of their length.
            spread: spread as f32 * ROOM + crate::guard::directions_error(pixels),
        }
    }
}

impl TileFrame {
    /// The ray of the pixel with these doubled offsets from the picture's centre.
    #[inline(always)]
    pub fn ray(&self, i: i64, j: i64) -> RayOf<f32> {
        RayOf::new(Vec3::ZERO, Vec3::ZERO, self.camera.camera_direction(i as f32, j as f32))
    }
}

/// The nearest far sphere of each pixel of a tile, with the lower bound already narrowed.
pub struct TileTracer<'a> {
    hierarchy: &'a Hierarchy,
    frame: &'a TileFrame,
    widening: Widening<f32>,
    packets: [Packet; PACKETS],
    /// Children to be visited, with a lower bound of their `t`.
    stack: Vec<(f32, u32)>,
}

impl<'a> TileTracer<'a> {
    /// A tracer that is used for one tile after the other.
    pub fn new(hierarchy: &'a Hierarchy, frame: &'a TileFrame, widening: Widening<f32>) -> Self {
        let empty = Packet {
            direction: [[0.0; PACKET]; 3],
            a: [0.0; PACKET],
            inv_a: [0.0; PACKET],
            low: [0.0; PACKET],
            high: [0.0; PACKET],
            second_high: [0.0; PACKET],
            id: [0; PACKET],
            certain: [0.0; PACKET],
        };
        TileTracer { hierarchy, frame, widening, packets: [empty; PACKETS], stack: Vec::new() }
    }

    /// Traces the tile whose left upper pixel has these doubled offsets from the picture's centre.
    #[inline(always)]
    pub fn trace(&mut self, i: i64, j: i64) {
        self.start(i, j);
        let enclosure = Enclosure::new(self.frame, i as f64, j as f64);
        let Bvh { nodes, .. } = &self.hierarchy.bvh;
        let mut t_max = f32::INFINITY;
        self.stack.clear();
        self.stack.push((0.0, Bvh::ROOT));
        while let Some((t, child)) = self.stack.pop() {
            if t > t_max {
                continue;
            }
            match Child::unpack(child) {
                Child::Leaf { first, n } => {
                    let mut hit = false;
                    for sphere in &self.hierarchy.far[first as usize..(first + n) as usize] {
                        hit |= self.test(sphere, enclosure.touched(sphere, t_max));
                    }
                    if hit {
                        t_max = self.farthest();
                    }
                }
                Child::Node(index) => {
                    let node = &nodes[index as usize];
                    let (seen, ts) = enclosure.seen(node, t_max);
                    self.push_sorted(node, seen, &ts);
                }
            }
        }
    }

    #[inline(always)]
    fn start(&mut self, i: i64, j: i64) {
        for (number, packet) in self.packets.iter_mut().enumerate() {
            for lane in 0..PACKET {
                let (x, y) = place(number, lane);
                let ray = self.frame.ray(i + 2 * x as i64, j - 2 * y as i64);
                for axis in 0..3 {
                    packet.direction[axis][lane] = ray.direction.0[axis];
                }
                (packet.a[lane], packet.inv_a[lane]) = (ray.a, ray.inv_a);
            }
            packet.low = [0.0; PACKET];
            packet.high = [0.0; PACKET];
            packet.second_high = [0.0; PACKET];
            packet.id = [0; PACKET];
            packet.certain = [0.0; PACKET];
        }
    }

    /// The seen children onto the stack, the nearest on top.
    #[inline(always)]
    fn push_sorted(&mut self, node: &Node, mut seen: u32, ts: &[f32; WIDTH]) {
        let base = self.stack.len();
        while seen != 0 {
            let k = seen.trailing_zeros() as usize;
            seen &= seen - 1;
            let item = (ts[k], node.child_bits(k));
            let mut at = self.stack.len();
            self.stack.push(item);
            while at > base && self.stack[at - 1].0 < item.0 {
                self.stack[at] = self.stack[at - 1];
                at -= 1;
            }
            self.stack[at] = item;
        }
    }

    /// Tests the rays of the touched packets; says whether one may be hit.
    #[inline(always)]
    fn test(&mut self, sphere: &SphereFar, mut touched: u32) -> bool {
        let mut hit = false;
        while touched != 0 {
            let number = touched.trailing_zeros() as usize;
            touched &= touched - 1;
            hit |= test_packet(&mut self.packets[number], sphere);
        }
        hit
    }

    /// An upper bound of the `t` of every ray's nearest certain hit.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        let mut least = [f32::INFINITY; PACKET];
        for packet in &self.packets {
            for lane in 0..PACKET {
                let nearness = packet.a[lane] * packet.certain[lane];
                least[lane] = if nearness < least[lane] { nearness } else { least[lane] };
            }
        }
        let least = least.iter().fold(f32::INFINITY, |least, &lane| least.min(lane));
        ROOM / (least * self.widening.far_narrower)
    }

    /// The nearest sphere of a pixel of the tile.
    #[inline(always)]
    pub fn nearest(&self, x: usize, y: usize) -> Nearest<f32> {
        let [width, height] = PACKET_SIZE;
        let packet = &self.packets[y / height * (TILE / width) + x / width];
        let lane = y % height * width + x % width;
        Nearest {
            low: packet.low[lane] * self.widening.far_narrower,
            high: packet.high[lane],
            second_high: packet.second_high[lane],
            id: packet.id[lane],
        }
    }
}

/// The same steps as [`crate::kernel::certified::far_nearness`] and [`Nearest::nearer`], each for
/// eight rays before the next, so that the compiler finds them side by side.
#[inline(always)]
fn test_packet(packet: &mut Packet, sphere: &SphereFar) -> bool {
    let l = Vec3(sphere.center);
    let Packet { direction, inv_a, .. } = *packet;
    let (mut s, mut m) = ([0.0; PACKET], [0.0; PACKET]);
    for k in 0..PACKET {
        let d = Vec3([direction[0][k], direction[1][k], direction[2][k]]);
        (s[k], m[k]) = closest_approach(d, inv_a[k], l);
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
        let root = far_nearness_at(s[k], m[k], inv_a[k], sphere.inner2, sphere.outer2, sphere.q);
        (low[k], high[k]) = (root.low, root.high);
    }
    let mut best = *packet;
    for k in 0..PACKET {
        best.certain[k] = if low[k] > best.certain[k] { low[k] } else { best.certain[k] };
        let is_nearer = high[k] > best.high[k];
        let farther = if is_nearer { best.high[k] } else { high[k] };
        best.low[k] = if is_nearer { low[k] } else { best.low[k] };
        best.high[k] = if is_nearer { high[k] } else { best.high[k] };
        best.id[k] = if is_nearer { sphere.id } else { best.id[k] };
        let second = best.second_high[k];
        best.second_high[k] = if farther > second { farther } else { second };
    }
    *packet = best;
    true
}
