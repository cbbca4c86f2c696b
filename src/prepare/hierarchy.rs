//! The tree over many spheres, and their numbers as a picture sees them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytemuck::zeroed_vec;
use rayon::prelude::*;

use super::Frame;
use crate::control::Control;
use crate::error::Result;
use crate::kernel::certified::{LISTED_SPHERES, SphereFar};
use crate::memory;
use crate::rays::Pixels;
use crate::scene::{Scene, Sphere};
use crate::trace::Rays;
use crate::tree::Tree;
use crate::tree::footprint::{Footprint, Projection};
use crate::tree::footprints::Footprints;

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

/// Spheres that one thread looks at at a time.
const RUN: usize = 1024;

/// Bytes a sphere to see a tree from a picture: its numbers, its footprint, and for two nodes hulls and
/// the nodes themselves.
const SEEN_BYTES: u64 = 32 + 12 + 2 * 12 + 2 * 16;

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
    let mut far = zeroed_vec(tree.order.len());
    let mut seen_as = zeroed_vec(tree.order.len());
    let runs = tree.order.par_chunks(RUN).zip(far.par_chunks_mut(RUN));
    let close: Vec<Vec<u32>> = runs
        .zip(seen_as.par_chunks_mut(RUN))
        .map(|((order, far), seen_as)| {
            control.check()?;
            let run = Run { frame, projection: &projection, longest, spheres, order, far, seen_as };
            Ok(pulp::Arch::new().dispatch(run))
        })
        .collect::<Result<_>>()?;
    let footprints = Footprints::new(tree, &seen_as, projection.cell_shift());
    control.check()?;
    Ok((Seen { footprints, far }, close.concat()))
}

/// Some places of the tree, compiled for each instruction set that the processor may have.
struct Run<'a> {
    frame: &'a Frame,
    projection: &'a Projection,
    longest: f64,
    spheres: &'a [Sphere],
    order: &'a [u32],
    far: &'a mut [SphereFar],
    seen_as: &'a mut [Footprint],
}

impl pulp::WithSimd for Run<'_> {
    /// Indices of the spheres that are too close.
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Vec<u32> {
        let mut close = Vec::new();
        // They lie anywhere.
        let spheres: Vec<Sphere> = self.order.iter().map(|&i| self.spheres[i as usize]).collect();
        let places = spheres.iter().zip(self.order).zip(self.far).zip(self.seen_as);
        for (((sphere, &index), far), seen_as) in places {
            *seen_as = Footprint::NONE;
            match self.frame.leaf(sphere, index + 1, self.longest) {
                None => close.push(index),
                Some(leaf) => {
                    let l = sphere.center - self.frame.reference;
                    if let Some(footprint) = self.projection.footprint(l, sphere.radius.abs()) {
                        (*far, *seen_as) = (leaf, footprint);
                    }
                }
            }
        }
        close
    }
}
