//! The rays that f32 left undecided: in f64, and what is left exactly.

use std::time::Instant;

use super::{Decided, Stage};
use crate::control::Control;
use crate::engine::Scratch64;
use crate::error::Result;
use crate::exact::nearest_in;
use crate::host;
use crate::num::OPEN;
use crate::parallel;
use crate::trace::{Level, Timing};

impl Stage<'_> {
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
        let mut ids = vec![OPEN; rays.len()];
        self.find.decide(rays, control, &mut ids)?;
        timing.refine += start.elapsed();

        let start = Instant::now();
        let mut exactly: Vec<usize> = (0..ids.len()).filter(|&at| ids[at] == OPEN).collect();
        let settle = |scratch: &mut Scratch64, &at: &usize| {
            host::check()?;
            control.check()?;
            Ok(self.settle(rays[at] as usize, scratch))
        };
        let settled = parallel::try_map_in(&exactly, settle)?;
        for (&at, &(id, _)) in exactly.iter().zip(&settled) {
            ids[at] = id;
        }
        let mut levels = settled.iter().map(|&(_, level)| level);
        exactly.retain(|_| levels.next() == Some(Level::Exact));
        timing.decide += start.elapsed();
        Ok(Decided { ids, exactly })
    }

    /// What a ray sees, exactly where f64 leaves it open.
    fn settle(&self, index: usize, scratch: &mut Scratch64) -> (u32, Level) {
        let found = match self.find.look(index, scratch) {
            Ok(id) => return (id, Level::F64),
            Err(found) => found,
        };
        let object = |&(id, _): &(u32, f64)| Some((id, self.prepared.scene.object(id)?));
        let objects = found.iter().filter_map(object);
        let seen = nearest_in(&self.exact.ray(index), objects, self.prepared.unit.exponent());
        (seen.map_or(0, |hit| hit.id), Level::Exact)
    }
}
