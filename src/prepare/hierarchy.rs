//! The tree over many spheres, and their numbers as a picture sees them.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::borrow::Cow;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use bytemuck::{Zeroable, zeroed_vec};
use glam::DVec3;
use pulp::Simd;
use rayon::prelude::*;

use super::Frame;
use crate::control::Control;
use crate::error::Result;
use crate::guard;
use crate::kernel::certified::{LISTED_SPHERES, Leaf, SphereFar};
use crate::memory::{self, Available};
use crate::num::{Lanes, Real, V3};
use crate::rays::Pixels;
use crate::scene::{Scene, Sphere};
use crate::trace::Rays;
use crate::tree::Tree;
use crate::tree::footprint::{Footprint, Outline, Projection};
use crate::tree::footprints::{Footprints, Given, Parts};

/// Many spheres: those that are found through the tree, and the rest. Left out are those that can't
/// be hit.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The tree over the scene's spheres.
    pub tree: Arc<Tree>,
    /// The tree as a picture sees it.
    pub seen: Option<Seen>,
    kept: Arc<Kept>,
    /// Ids of the spheres that each ray looks at: out of range, or for a picture too close to the eye.
    /// In a very wide view, above some 160 degrees, all are too close; of an orthographic camera, those
    /// whose surface comes close to its position.
    pub rest: Vec<u32>,
    /// Time that it took to build the tree, where that was needed, and to fit it to the picture.
    pub build_time: Duration,
}

/// The tree as a picture sees it. A walk shows only spheres that a pixel may see, all of them far from a
/// perspective camera's eye.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Bounds on the screen.
    pub footprints: Footprints,
    /// The numbers of the sphere at each place of [`Tree::order`]; zeros where no walk comes.
    pub far: Vec<SphereFar>,
}

/// Bytes a sphere to see a tree from a picture: its numbers, two nodes, and what is kept of a joint of the
/// tree. What a part is fitted in is little.
const SEEN_BYTES: u64 = 32 + 2 * 16 + 8;

/// What all views of a tree share.
#[derive(Debug, Default)]
struct Kept {
    parts: OnceLock<Parts>,
    /// The spheres at the places of the tree, for lists of rays and for second and further views: in the scene
    /// they lie anywhere, which costs a view as much as all else.
    spheres: OnceLock<Vec<Sphere>>,
    /// What an earlier view saw, to be written over: new memory costs as much as what is written to it.
    spare: Mutex<Option<Seen>>,
}

impl Kept {
    fn spare(&self) -> MutexGuard<'_, Option<Seen>> {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts the spheres in order, where there is room for them.
    fn keep_spheres(&self, tree: &Tree, spheres: &[Sphere]) {
        let bytes = size_of::<Sphere>() as u64 * tree.order.len() as u64;
        if self.spheres.get().is_none() && Available::now().bytes >= bytes {
            let sphere = |&index: &u32| spheres[index as usize];
            let in_order = tree.order.par_iter().map(sphere).collect();
            self.spheres.get_or_init(|| in_order);
        }
    }

    /// The parts of the tree. They are made before anybody waits for them: a thread of the pool that makes
    /// them may come to another view meanwhile.
    fn parts(&self, tree: &Tree) -> &Parts {
        if let Some(parts) = self.parts.get() {
            return parts;
        }
        let parts = Parts::new(tree);
        self.parts.get_or_init(|| parts)
    }
}

impl Drop for Hierarchy {
    /// Leaves what it saw to another view, if there may be one.
    fn drop(&mut self) {
        if Arc::strong_count(&self.kept) > 1 {
            let seen = self.seen.take();
            let mut spare = self.kept.spare();
            *spare = seen.or_else(|| spare.take());
        }
    }
}

impl Hierarchy {
    /// Fits the tree of a scene to rays: that of an `old` hierarchy over the same spheres, if there is one.
    ///
    /// # Errors
    /// Those of [`Tree::new`].
    pub(super) fn new(
        frame: &Frame,
        rays: &Rays,
        scene: &Scene,
        old: Option<&Hierarchy>,
        control: &Control,
    ) -> Result<Hierarchy> {
        let start = Instant::now();
        let (tree, kept) = match old {
            Some(old) => (Arc::clone(&old.tree), Arc::clone(&old.kept)),
            None => (Arc::new(Tree::new(&scene.spheres, control)?), Arc::default()),
        };
        let (seen, mut rest) = match rays {
            Rays::Pixels(pixels) => {
                if old.is_some_and(|old| old.seen.is_some()) {
                    kept.keep_spheres(&tree, &scene.spheres);
                }
                let (seen, close) = see(frame, pixels, &tree, &kept, &scene.spheres, control)?;
                (Some(seen), close)
            }
            Rays::List(_) => {
                tree.prepare_visits(control)?;
                kept.keep_spheres(&tree, &scene.spheres);
                (None, Vec::new())
            }
        };
        rest.extend(&tree.outside);
        rest.sort_unstable();
        for index in &mut rest {
            *index += 1;
        }
        Ok(Hierarchy { tree, seen, kept, rest, build_time: start.elapsed() })
    }

    /// The sphere at a place of the tree, of the `spheres` that it was made over.
    #[inline(always)]
    pub(crate) fn sphere_at<'a>(&'a self, place: usize, spheres: &'a [Sphere]) -> &'a Sphere {
        match self.kept.spheres.get() {
            Some(in_order) => &in_order[place],
            None => &spheres[self.tree.order[place] as usize],
        }
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
    kept: &Kept,
    spheres: &[Sphere],
    control: &Control,
) -> Result<(Seen, Vec<u32>)> {
    let n_spheres = tree.order.len();
    let spare = kept.spare().take();
    if spare.is_none() {
        memory::require(
            format!("seeing the hierarchy over {n_spheres} spheres from a camera"),
            n_spheres as u64 * SEEN_BYTES,
            "free some, or split the scene",
        )?;
    }
    let Seen { footprints: Footprints { nodes, .. }, mut far } = spare.unwrap_or_default();
    if far.len() != n_spheres {
        far = zeroed_vec(n_spheres);
    }
    let (longest, projection) = (pixels.longest_direction(), Projection::new(pixels));
    let parts = kept.parts(tree);
    let (mut of_parts, mut left) = (Vec::new(), &mut far[..]);
    for places in parts.places() {
        let (far, others) = left.split_at_mut(places.len());
        let in_order = kept.spheres.get().map(|spheres| &spheres[places.clone()]);
        of_parts.push((&tree.order[places], in_order, far));
        left = others;
    }
    let look = |given: (&[u32], Option<&[Sphere]>, &mut [SphereFar]), seen_as: &mut [Footprint]| {
        control.check()?;
        let (order, in_order, far) = given;
        // They lie anywhere.
        let gather = || order.iter().map(|&index| spheres[index as usize]).collect();
        let spheres = in_order.map_or_else(|| Cow::Owned(gather()), Cow::Borrowed);
        let (projection, spheres) = (&projection, &*spheres);
        let look = Look { frame, projection, longest, spheres, order, far, seen_as };
        Ok(pulp::Arch::new().dispatch(look))
    };
    let (shift, nearest) =
        (projection.cell_shift(), parts.nearest(tree, frame.reference, projection.depth()));
    let given = Given { of_parts, nearest, nodes };
    let (footprints, close) = Footprints::of_parts(tree, parts, shift, given, look);
    let close: Vec<Vec<u32>> = close.into_iter().collect::<Result<_>>()?;
    control.check()?;
    Ok((Seen { footprints, far }, close.concat()))
}

/// Spheres side by side.
const BLOCK: usize = 16;

/// Numbers of spheres side by side.
type Column = [f64; BLOCK];

/// The spheres of some places of the tree, compiled for each instruction set that the processor may have.
struct Look<'a> {
    frame: &'a Frame,
    projection: &'a Projection,
    longest: f64,
    /// Those at these places.
    spheres: &'a [Sphere],
    /// Their indices.
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
    fn put(&mut self, spheres: &[Sphere; BLOCK], reference: DVec3) {
        let [x, y, z] = &mut self.center;
        for (lane, sphere) in spheres.iter().enumerate() {
            x[lane] = sphere.center.x - reference.x;
            y[lane] = sphere.center.y - reference.y;
            z[lane] = sphere.center.z - reference.z;
            self.radius[lane] = sphere.radius.abs();
        }
    }

    #[inline(always)]
    fn look(&mut self, frame: &Frame, projection: &Projection, longest: f64) {
        const N: usize = 8;
        let put = |column: &mut Column, first: usize, numbers: Lanes<f64, N>| {
            column[first..first + N].copy_from_slice(&numbers.0);
        };
        for first in (0..BLOCK).step_by(N) {
            let lanes = |column: &Column| Lanes::<f64, N>::load(&column[first..]);
            let [x, y, z] = &self.center;
            let (l, r) = (V3([lanes(x), lanes(y), lanes(z)]), lanes(&self.radius));
            let (leaf, is_known) = frame.leaves(l, r, longest);
            let Leaf { inner2, outer2, q_or_slack } = leaf;
            for (column, numbers) in self.leaf.iter_mut().zip([inner2, outer2, q_or_slack]) {
                put(column, first, numbers);
            }
            let is_known = Lanes::select(is_known, Lanes::lit(1.0), Lanes::lit(0.0));
            put(&mut self.is_known, first, is_known);
            let Outline { columns: [left, right], rows: [top, bottom], t, farthest } =
                projection.outline(l, r);
            let outline = [left, right, top, bottom, t, farthest];
            for (column, numbers) in self.outline.iter_mut().zip(outline) {
                put(column, first, numbers);
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
    fn with_simd<S: Simd>(self, _: S) -> Vec<u32> {
        let Look { frame, projection, longest, spheres, order, far, seen_as } = self;
        let mut close = Vec::new();
        let (mut columns, mut rounded) = (Columns::default(), Rounded::default());
        let blocks = order.chunks(BLOCK).zip(far.chunks_mut(BLOCK)).zip(seen_as.chunks_mut(BLOCK));
        for (((order, far), seen_as), spheres) in blocks.zip(spheres.chunks(BLOCK)) {
            match <&[Sphere; BLOCK]>::try_from(spheres) {
                Ok(spheres) => columns.put(spheres, frame.reference),
                Err(_) => {
                    let mut padded = [Sphere::default(); BLOCK];
                    padded[..spheres.len()].copy_from_slice(spheres);
                    columns.put(&padded, frame.reference);
                }
            }
            columns.look(frame, projection, longest);
            columns.round(projection, &mut rounded);
            for (lane, &index) in order.iter().enumerate() {
                // Put together in its place: from elsewhere, its copy would wait for its parts.
                if columns.is_known[lane] == 1.0 && rounded.is_seen[lane] {
                    far[lane] = rounded.leaf(lane, index + 1);
                    seen_as[lane] = rounded.footprint(lane);
                    continue;
                }
                (far[lane], seen_as[lane]) = (SphereFar::zeroed(), Footprint::NONE);
                if columns.is_known[lane] == 1.0 {
                    continue;
                }
                match frame.leaf(&spheres[lane], index + 1, longest) {
                    Some(leaf) if rounded.is_seen[lane] => {
                        (far[lane], seen_as[lane]) = (leaf, rounded.footprint(lane));
                    }
                    Some(_) => {}
                    None => close.push(index),
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

    /// A cloud of several parts, seen again with what earlier views have left.
    #[test]
    fn views_of_one_tree_are_as_each_alone() {
        let mut random = SplitMix::new(1312);
        let mut number = || 2.0 * random.unit() - 1.0;
        let mut sphere =
            |_| Sphere { center: DVec3::new(number(), number(), number()), radius: 0.01 };
        let spheres: Vec<Sphere> = (0..30_000).map(&mut sphere).collect();
        let scene = Scene { spheres: spheres.into(), ..Scene::default() };
        let control = Control::default();
        let seen = |step: u32, old: Option<&Hierarchy>| {
            let position = DVec3::new(2.0, 0.1, 0.3 * f64::from(step));
            let view = View::new(&Camera::new(position, DVec3::ZERO));
            let rays = Rays::Pixels(Pixels::whole(view, 97, 41));
            let frame = Frame::new(&rays, position);
            Hierarchy::new(&frame, &rays, &scene, old, &control).unwrap()
        };
        let bytes = |hierarchy: &Hierarchy| {
            let super::Seen { footprints, far } = hierarchy.seen.as_ref().unwrap();
            let (nodes, far) = (bytemuck::cast_slice(&footprints.nodes), bytemuck::cast_slice(far));
            (<[u8]>::to_vec(nodes), <[u8]>::to_vec(far))
        };
        let mut last: Option<Hierarchy> = None;
        for step in 0..5 {
            let next = seen(step, last.as_ref());
            assert!(next.kept.parts.get().is_some_and(|parts| parts.places().count() > 1));
            assert_eq!(next.kept.spheres.get().is_some(), step > 0);
            let alone = seen(step, None);
            assert_eq!((bytes(&next), &next.rest), (bytes(&alone), &alone.rest), "{step}");
            let kept = Arc::clone(&next.kept);
            last = Some(next);
            assert_eq!(kept.spare().is_some(), step > 0, "{step}");
        }
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
            let frame = Frame::new(&rays, camera.position);
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
