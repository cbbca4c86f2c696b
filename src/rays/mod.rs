//! The rays of one call: those of a picture's pixels, and lists.

mod camera;
mod list;

use glam::DVec3;

use crate::support::parallel;

pub use camera::{Frame, Lens, Pixels, View, camera_direction, camera_origin};
pub use list::{List, Origins};

/// A ray `origin + t·direction`; the direction is not normalised and not zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldRay {
    /// Origin, world units.
    pub origin: DVec3,
    /// Direction of any length but zero.
    pub direction: DVec3,
}

/// The rays of one call.
#[derive(Clone, Debug)]
pub enum Rays {
    /// Centre rays of a rectangle of pixels, row by row.
    Pixels(Pixels),
    /// Any rays.
    List(Vec<WorldRay>),
}

impl Rays {
    /// Number of rays.
    pub fn len(&self) -> usize {
        match self {
            Rays::Pixels(pixels) => pixels.len(),
            Rays::List(rays) => rays.len(),
        }
    }

    /// The pixels whose centre rays these are; `None` for a list.
    pub fn pixels(&self) -> Option<&Pixels> {
        match self {
            Rays::Pixels(pixels) => Some(pixels),
            Rays::List(_) => None,
        }
    }

    /// Column and row of the `i`-th ray in the whole picture; `None` for a list.
    pub fn pixel(&self, i: usize) -> Option<[u32; 2]> {
        Some(self.pixels()?.xy(i).into())
    }

    /// True where there is no ray at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Fewer rays than this are looked at sooner than other threads are asked to.
const MANY: usize = 1 << 14;

/// Puts together what `look` finds of each ray; `nothing` is what is found of none.
pub(crate) fn look_at_all<T: Copy + Send + Sync>(
    rays: &[WorldRay],
    nothing: T,
    look: impl Fn(&WorldRay) -> T + Sync + Send,
    join: impl Fn(T, T) -> T + Sync + Send,
) -> T {
    let of_some = |rays: &[WorldRay]| rays.iter().map(&look).fold(nothing, &join);
    parallel::map(rays.chunks(MANY), of_some).into_iter().fold(nothing, &join)
}
