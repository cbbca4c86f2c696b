//! A [`Report`] as SVG pictures.
//!
//! They need nothing beside themselves and fit light and dark pages: `prefers-color-scheme` chooses
//! the colours. All numbers in them are also in the tables.

pub(super) mod chart;
pub(super) mod plane;
mod scale;
pub(super) mod sweep;
pub(super) mod theme;

use super::{Report, Sweep};

/// The plane of time and error as an SVG file.
pub fn plane(report: &Report) -> String {
    plane::chart(report).svg()
}

/// A sweep as an SVG file.
pub fn sweep(report: &Report, sweep: &Sweep) -> String {
    sweep::chart(report, sweep).svg()
}
