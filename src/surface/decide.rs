//! The rays that f32 left undecided: in f64, and what is left exactly.

use std::time::Instant;

use super::{Decided, Resolver};
use crate::error::Result;
use crate::exact::nearest_in;
use crate::num::UNDECIDED;
use crate::query::{Stage, Timing};
use crate::support::control::Control;
use crate::support::fpu_check;
use crate::support::parallel;
use crate::visibility::Scratch64;

impl Resolver<'_> {
    /// Decides rays that f32 left open: in f64, and what is left exactly.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn decide(&self, rays: &[u32], control: &Control, timing: &mut Timing) -> Result<Decided> {
        // Most parts of a picture leave none.
        if rays.is_empty() {
            return Ok(Decided::default());
        }
        let start = Instant::now();
        let mut ids = vec![UNDECIDED; rays.len()];
        self.find.decide(rays, control, &mut ids)?;
        timing.refine += start.elapsed();

        let start = Instant::now();
        let mut exactly: Vec<usize> = (0..ids.len()).filter(|&at| ids[at] == UNDECIDED).collect();
        let resolve_exactly = |scratch: &mut Scratch64, &at: &usize| {
            fpu_check::check()?;
            control.check()?;
            Ok(self.resolve_exactly(rays[at] as usize, scratch))
        };
        let settled = parallel::try_map_in(&exactly, resolve_exactly)?;
        for (&at, &(id, _)) in exactly.iter().zip(&settled) {
            ids[at] = id;
        }
        let mut levels = settled.iter().map(|&(_, level)| level);
        exactly.retain(|_| levels.next() == Some(Stage::Exact));
        timing.decide += start.elapsed();
        Ok(Decided { ids, exactly })
    }

    /// What a ray sees, exactly where f64 leaves it open.
    fn resolve_exactly(&self, index: usize, scratch: &mut Scratch64) -> (u32, Stage) {
        let found = match self.find.look(index, scratch) {
            Ok(id) => return (id, Stage::F64),
            Err(found) => found,
        };
        let object = |&(id, _): &(u32, f64)| Some((id, self.prepared.scene.object(id)?));
        let objects = found.iter().filter_map(object);
        let seen = nearest_in(&self.exact.ray(index), objects, self.prepared.unit.exponent());
        (seen.map_or(0, |hit| hit.id), Stage::Exact)
    }
}
