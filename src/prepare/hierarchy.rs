//! The tree over many spheres, and their numbers as rays see them.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::bvh::{Bvh, Leaves};
use crate::error::Result;
use crate::kernel::certified::LISTED_SPHERES;
use crate::scene::Scene;
use crate::shape::RayOrigin;
use crate::support::control::Control;
use crate::support::memory;

/// Many spheres: those that are found through the tree, and the rest. Left out are those that can't
/// be hit.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The tree over the scene's spheres.
    pub bvh: Arc<Bvh>,
    /// The tree's spheres as the rays see them in f32.
    pub leaves: Arc<Leaves>,
    /// The tree's spheres as one ray sees them that stands for all samples of a pixel, for the last eye that asked.
    squares: Arc<Mutex<Option<OfSquares>>>,
    /// Time that it took to build the tree, where that was needed, and to see its spheres.
    pub build_time: Duration,
}

/// An eye, and what it sees.
type OfSquares = (RayOrigin, Arc<Leaves>);

impl Hierarchy {
    /// Over the spheres of a scene, for an eye, with the tree of an `old` hierarchy over the same spheres, if there is one.
    ///
    /// # Errors
    /// Those of [`Bvh::new`].
    pub(super) fn new(
        eye: &RayOrigin,
        scene: &Scene,
        old: Option<&Hierarchy>,
        control: &Control,
    ) -> Result<Hierarchy> {
        let start = Instant::now();
        let bvh = match old {
            Some(old) => Arc::clone(&old.bvh),
            None => Arc::new(Bvh::new(&scene.spheres, control)?),
        };
        let n_spheres = bvh.spheres.len();
        memory::require(
            format!("seeing the hierarchy over {n_spheres} spheres"),
            (n_spheres * Leaves::BYTES) as u64,
            "free some, or split the scene",
        )?;
        let leaves = Arc::new(Leaves::new(&bvh, eye));
        control.check()?;
        Ok(Hierarchy { bvh, leaves, squares: Arc::default(), build_time: start.elapsed() })
    }

    /// The tree's spheres as an eye sees them whose rays stand for all samples of a pixel each.
    pub(crate) fn of_squares(&self, eye: &RayOrigin) -> Arc<Leaves> {
        let kept = || self.squares.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, leaves)) = kept().as_ref().filter(|(for_eye, _)| for_eye == eye) {
            return Arc::clone(leaves);
        }
        let leaves = Arc::new(Leaves::new(&self.bvh, eye));
        *kept() = Some((*eye, Arc::clone(&leaves)));
        leaves
    }

    /// Places of a device for the [rest](Leaves::rest): few different numbers while they are few. So a moved camera,
    /// which is close to some more spheres or some less, hardly ever needs another shader.
    pub fn n_places_of_rest(&self) -> usize {
        let n = self.leaves.rest.len();
        [0, 1, 4, 16, 64, LISTED_SPHERES].into_iter().find(|&places| n <= places).unwrap_or(n)
    }

    /// Bytes of what a walk looks at: the tree, and its spheres as rays see them.
    pub fn bytes(&self) -> u64 {
        self.bvh.bytes() + self.leaves.bytes()
    }
}
