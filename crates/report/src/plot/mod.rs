//! A [`Report`](super::Report) as SVG pictures.
//!
//! They need nothing beside themselves and fit light and dark pages: `prefers-color-scheme` chooses
//! the colours. All numbers in them are also in the tables.

mod chart;
mod plane;
mod scale;
mod sweep;
pub(super) mod theme;

pub(super) use plane::has_plane;
pub use plane::plane;
pub(super) use sweep::has_sweep;
pub use sweep::sweep;
