//! The tree over many spheres, and their numbers as a picture sees them.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytemuck::zeroed_vec;
use pulp::Simd;

use super::Frame;
use crate::control::Control;
use crate::error::Result;
use crate::guard;
use crate::kernel::certified::{LISTED_SPHERES, Leaf, SphereFar};
use crate::memory;
use crate::rays::Pixels;
use crate::scene::{Scene, Sphere};
use crate::trace::Rays;
use crate::tree::Tree;
use crate::tree::footprint::{Footprint, Outline, Projection};
use crate::tree::footprints::{Footprints, Parts};
use crate::vec3::Vec3;
use crate::wide::{SideBySide, WideF64};

/// Many spheres: those that are found through the tree, and the rest. Left out are those that can't
/// be hit.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The tree over the scene's spheres.
    pub tree: Arc<Tree>,
    /// The tree as a picture sees it.
    pub seen: Option<Seen>,
    /// Ids of the spheres that each ray looks at: out of range, or for a picture too close to the eye.
    /// In a very wide view, above some 160 degrees, all are too close; of an orthographic camera, those
    /// whose surface comes close to its position.
    pub rest: Vec<u32>,
    /// Time that it took to build the tree, where that was needed, and to fit it to the picture.
    pub build_time: Duration,
}

/// The tree as a picture sees it. A walk shows only spheres that a pixel may see, all of them far from a
/// perspective camera's eye.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Bounds on the screen.
    pub footprints: Footprints,
    /// The numbers of the sphere at each place of [`Tree::order`]; zeros where no walk comes.
    pub far: Vec<SphereFar>,
}

/// Bytes a sphere to see a tree from a picture: its numbers, and two nodes in two orders. What a part is
/// fitted in is little.
const SEEN_BYTES: u64 = 32 + 2 * 2 * 16;

impl Hierarchy {
    /// Fits the tree of a scene, if there is one already, to rays.
    ///
    /// # Errors
    /// Those of [`Tree::new`].
    pub(super) fn new(
        frame: &Frame,
        rays: &Rays,
        scene: &Scene,
        tree: Option<Arc<Tree>>,
        control: &Control,
    ) -> Result<Hierarchy> {
        let start = Instant::now();
        let tree = match tree {
            Some(tree) => tree,
            None => Arc::new(Tree::new(&scene.spheres, control)?),
        };
        let (seen, mut rest) = match rays {
            Rays::Pixels(pixels) => {
                let (seen, close) = see(frame, pixels, &tree, &scene.spheres, control)?;
                (Some(seen), close)
            }
            Rays::List(_) => {
                tree.prepare_visits(control)?;
                (None, Vec::new())
            }
        };
        rest.extend(&tree.outside);
        rest.sort_unstable();
        for index in &mut rest {
            *index += 1;
        }
        Ok(Hierarchy { tree, seen, rest, build_time: start.elapsed() })
    }

    /// Places of a device for the rest: few different numbers while they are few. So a moved camera,
    /// which is close to some more spheres or some less, hardly ever needs another shader.
    pub fn n_places_of_rest(&self) -> usize {
        let n = self.rest.len();
        [0, 1, 4, 16, 64, LISTED_SPHERES].into_iter().find(|&places| n <= places).unwrap_or(n)
    }

    /// Bytes of what a walk looks at: nodes and spheres as a picture sees them, or the tree itself.
    pub fn bytes(&self) -> u64 {
        match &self.seen {
            Some(Seen { footprints, far }) => {
                (size_of_val(&footprints.nodes[..]) + size_of_val(&far[..])) as u64
            }
            None => self.tree.bytes(),
        }
    }
}

/// What a picture sees of the tree, and the indices of the spheres in it that are too close for that.
fn see(
    frame: &Frame,
    pixels: &Pixels,
    tree: &Tree,
    spheres: &[Sphere],
    control: &Control,
) -> Result<(Seen, Vec<u32>)> {
    let n_spheres = tree.order.len();
    memory::require(
        format!("seeing the hierarchy over {n_spheres} spheres from a camera"),
        n_spheres as u64 * SEEN_BYTES,
        "free some, or split the scene",
    )?;
    let (longest, projection) = (pixels.longest_direction(), Projection::new(pixels));
    let mut far: Vec<SphereFar> = zeroed_vec(n_spheres);
    let parts = Parts::new(tree);
    let (mut given, mut left) = (Vec::new(), &mut far[..]);
    for places in parts.places() {
        let (far, others) = left.split_at_mut(places.len());
        given.push((&tree.order[places], far));
        left = others;
    }
    let look = |(order, far): (&[u32], &mut [SphereFar]), seen_as: &mut [Footprint]| {
        control.check()?;
        let look = Look { frame, projection: &projection, longest, spheres, order, far, seen_as };
        Ok(pulp::Arch::new().dispatch(look))
    };
    let shift = projection.cell_shift();
    let (footprints, close) = Footprints::of_parts(&parts, shift, given, look);
    let close: Vec<Vec<u32>> = close.into_iter().collect::<Result<_>>()?;
    control.check()?;
    Ok((Seen { footprints, far }, close.concat()))
}

/// Spheres side by side.
const BLOCK: usize = 16;

/// Numbers of spheres side by side.
type Column = [f64; BLOCK];

/// Some places of the tree, compiled for each instruction set that the processor may have.
struct Look<'a> {
    frame: &'a Frame,
    projection: &'a Projection,
    longest: f64,
    spheres: &'a [Sphere],
    order: &'a [u32],
    far: &'a mut [SphereFar],
    seen_as: &'a mut [Footprint],
}

/// Spheres as a picture sees them.
#[derive(Default)]
struct Columns {
    center: [Column; 3],
    radius: Column,
    leaf: [Column; 3],
    /// 1 where f64 is sure of the leaf.
    is_known: Column,
    outline: [Column; 6],
}

/// Their numbers in the end.
#[derive(Default)]
struct Rounded {
    center: [[f32; BLOCK]; 3],
    leaf: [[f32; BLOCK]; 3],
    cells: [[u16; BLOCK]; 4],
    t: [f32; BLOCK],
    is_seen: [bool; BLOCK],
}

impl Columns {
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, frame: &Frame, projection: &Projection, longest: f64) {
        for first in (0..BLOCK).step_by(WideF64::<S>::LANES) {
            let [x, y, z] = &self.center;
            let l = Vec3([
                WideF64::load(simd, &x[first..]),
                WideF64::load(simd, &y[first..]),
                WideF64::load(simd, &z[first..]),
            ]);
            let r = WideF64::load(simd, &self.radius[first..]);
            let (leaf, is_known) = frame.leaves(l, r, longest);
            let Leaf { inner2, outer2, q_or_slack } = leaf;
            for (column, numbers) in self.leaf.iter_mut().zip([inner2, outer2, q_or_slack]) {
                numbers.store(&mut column[first..]);
            }
            is_known.select(r.like(1.0), r.like(0.0)).store(&mut self.is_known[first..]);
            let Outline { columns: [left, right], rows: [top, bottom], t, farthest } =
                projection.outline(l, r);
            let outline = [left, right, top, bottom, t, farthest];
            for (column, numbers) in self.outline.iter_mut().zip(outline) {
                numbers.store(&mut column[first..]);
            }
        }
    }

    /// One step of all after the other, so that the compiler finds them side by side.
    #[inline(always)]
    fn round(&self, projection: &Projection, rounded: &mut Rounded) {
        let Columns { center, leaf: [inner2, outer2, q_or_slack], outline, .. } = self;
        let [left, right, top, bottom, t, farthest] = outline;
        for lane in 0..BLOCK {
            for (rounded, column) in rounded.center.iter_mut().zip(center) {
                rounded[lane] = column[lane] as f32;
            }
        }
        for lane in 0..BLOCK {
            rounded.leaf[0][lane] = guard::round_down(inner2[lane]);
        }
        for lane in 0..BLOCK {
            rounded.leaf[1][lane] = guard::round_up(outer2[lane]);
        }
        for lane in 0..BLOCK {
            rounded.leaf[2][lane] = guard::round_up(q_or_slack[lane]);
        }
        for lane in 0..BLOCK {
            rounded.t[lane] = guard::round_down(t[lane]);
        }
        for lane in 0..BLOCK {
            let (columns, has_columns) = projection.columns(left[lane], right[lane]);
            let (rows, has_rows) = projection.rows(top[lane], bottom[lane]);
            for (end, cells) in rounded.cells.iter_mut().enumerate() {
                cells[lane] = [columns[0], columns[1], rows[0], rows[1]][end];
            }
            rounded.is_seen[lane] = has_columns & has_rows & (farthest[lane] > 0.0);
        }
    }
}

impl Rounded {
    #[inline(always)]
    fn leaf(&self, lane: usize, id: u32) -> SphereFar {
        let ([x, y, z], [inner2, outer2, q_or_slack]) = (&self.center, &self.leaf);
        SphereFar {
            center: [x[lane], y[lane], z[lane]],
            inner2: inner2[lane],
            outer2: outer2[lane],
            q_or_slack: q_or_slack[lane],
            id,
            padding: 0,
        }
    }

    #[inline(always)]
    fn footprint(&self, lane: usize) -> Footprint {
        let [left, right, top, bottom] = &self.cells;
        Footprint {
            columns: [left[lane], right[lane]],
            rows: [top[lane], bottom[lane]],
            t: self.t[lane],
        }
    }
}

impl pulp::WithSimd for Look<'_> {
    /// Indices of the spheres that are too close.
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<u32> {
        let Look { frame, projection, longest, spheres, order, far, seen_as } = self;
        let mut close = Vec::new();
        let (mut columns, mut rounded) = (Columns::default(), Rounded::default());
        // They lie anywhere.
        let spheres: Vec<Sphere> = order.iter().map(|&index| spheres[index as usize]).collect();
        let blocks = order.chunks(BLOCK).zip(far.chunks_mut(BLOCK)).zip(seen_as.chunks_mut(BLOCK));
        for (((order, far), seen_as), spheres) in blocks.zip(spheres.chunks(BLOCK)) {
            for (lane, sphere) in spheres.iter().enumerate() {
                let l = sphere.center - frame.reference;
                columns.center[0][lane] = l.x;
                columns.center[1][lane] = l.y;
                columns.center[2][lane] = l.z;
                columns.radius[lane] = sphere.radius.abs();
            }
            columns.look(simd, frame, projection, longest);
            columns.round(projection, &mut rounded);
            for (lane, &index) in order.iter().enumerate() {
                let leaf = match columns.is_known[lane] {
                    1.0 => Some(rounded.leaf(lane, index + 1)),
                    _ => frame.leaf(&spheres[lane], index + 1, longest),
                };
                if leaf.is_none() {
                    close.push(index);
                }
                seen_as[lane] = Footprint::NONE;
                if let Some(leaf) = leaf.filter(|_| rounded.is_seen[lane]) {
                    (far[lane], seen_as[lane]) = (leaf, rounded.footprint(lane));
                }
            }
        }
        close
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::random::SplitMix;
    use crate::rays::View;
    use crate::scene::{Camera, Projection as Lens};

    type Seen = (Vec<SphereFar>, Vec<Footprint>, Vec<u32>);

    /// All spheres, side by side, or each by itself.
    fn look(frame: &Frame, pixels: &Pixels, spheres: &[Sphere], side_by_side: bool) -> Seen {
        let (longest, projection) = (pixels.longest_direction(), Projection::new(pixels));
        let order: Vec<u32> = (0..spheres.len() as u32).collect();
        let mut far: Vec<SphereFar> = zeroed_vec(spheres.len());
        let mut seen_as = vec![Footprint::NONE; spheres.len()];
        if side_by_side {
            let (far_of, seen_of) = (&mut far[..], &mut seen_as[..]);
            let projection = &projection;
            let order = &order;
            let look =
                Look { frame, projection, longest, spheres, order, far: far_of, seen_as: seen_of };
            let close = pulp::Arch::new().dispatch(look);
            return (far, seen_as, close);
        }
        let mut close = Vec::new();
        for (at, sphere) in spheres.iter().enumerate() {
            let Some(leaf) = frame.leaf(sphere, at as u32 + 1, longest) else {
                close.push(at as u32);
                continue;
            };
            let l = sphere.center - frame.reference;
            if let Some(footprint) = projection.footprint(l, sphere.radius.abs()) {
                (far[at], seen_as[at]) = (leaf, footprint);
            }
        }
        (far, seen_as, close)
    }

    fn is_same(a: &Seen, b: &Seen) -> bool {
        let bytes = |seen: &Seen| bytemuck::cast_slice::<SphereFar, u8>(&seen.0).to_vec();
        bytes(a) == bytes(b) && a.1 == b.1 && a.2 == b.2
    }

    #[test]
    fn spheres_side_by_side_are_seen_as_each_alone() {
        let mut random = SplitMix::new(1311);
        let mut n = [0; 2];
        for projection in [
            Lens::Perspective { fov_degrees: 60.0 },
            Lens::Perspective { fov_degrees: 170.0 },
            Lens::Orthographic { height: 3.0 },
        ] {
            let camera = Camera {
                position: DVec3::new(0.1, 0.2, 0.3),
                look_at: DVec3::new(1.0, -0.5, -2.0),
                up: DVec3::Y,
                projection,
            };
            let pixels = Pixels::whole(View::new(&camera), 97, 41);
            let rays = Rays::Pixels(pixels);
            let mut number = || 2.0 * random.unit() - 1.0;
            let mut sphere = |_| {
                let away = DVec3::new(number(), number(), number()) * 10f64.powf(3.0 * number());
                let radius = away.length() * 10f64.powf(4.0 * number() - 4.0);
                Sphere { center: camera.position + away, radius }
            };
            let mut spheres: Vec<Sphere> = (0..5003).map(&mut sphere).collect();
            // Too far, too large, not there.
            spheres[7].center *= 1e30;
            spheres[8].radius = 1e25;
            spheres[9].radius = 0.0;
            let scene = Scene { spheres: spheres.clone().into(), ..Scene::default() };
            let frame = Frame::new(&rays, camera.position, &scene);
            let alone = look(&frame, &pixels, &spheres, false);
            let mut side_by_side = look(&frame, &pixels, &spheres, true);
            assert!(is_same(&alone, &side_by_side), "{projection:?}");
            n[0] += alone.1.iter().filter(|&&footprint| footprint != Footprint::NONE).count();
            n[1] += alone.2.len();
            side_by_side.0[11].outer2 = side_by_side.0[11].outer2.next_up();
            assert!(!is_same(&alone, &side_by_side));
        }
        println!("{n:?} seen and too close");
        assert!(n.into_iter().all(|n| n > 500));
    }
}
