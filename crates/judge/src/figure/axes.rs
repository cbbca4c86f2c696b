//! The axes of the world, with numbers.

use glam::DVec3;

use super::drawing::Drawing;
use super::words::{multiple, number, round_step};

/// Draws axes through the origin that reach beyond all points, and the way along them to `to`.
pub fn draw(drawing: &mut Drawing, points: &[DVec3], to: DVec3, hidden: &dyn Fn(DVec3) -> bool) {
    let extent = points.iter().fold(0.0, |extent: f64, p| extent.max(p.abs().max_element()));
    // Some three to six steps to the largest coordinate.
    let step = if extent > 0.0 { round_step(extent / 2.5) } else { 1.0 };
    let least = points.iter().fold(DVec3::ZERO, |least, p| least.min(*p));
    let most = points.iter().fold(DVec3::ZERO, |most, p| most.max(*p));
    for (axis, letter) in DVec3::AXES.into_iter().zip(["x", "y", "z"]) {
        let from = least.dot(axis) - step / 2.0;
        let end = step * ((most.dot(axis) / step).floor() + 1.0);
        drawing.arrow([axis * from, axis * end], "ink", hidden);
        drawing.label(axis * end, (letter, String::new()), "ink");
        let first = (from / step).ceil() as i32;
        let last = (end / step).round() as i32 - 1;
        for i in (first..=last).filter(|i| *i != 0) {
            let at = multiple(step, i);
            drawing.tick(axis * at, axis * step);
            drawing.label(axis * at, ("", number(at)), "soft");
        }
    }
    let in_floor = DVec3::new(to.x, 0.0, to.z);
    let way = [DVec3::ZERO, DVec3::X * to.x, in_floor, to];
    drawing.thin(&way[1..], &|_| true);
}
