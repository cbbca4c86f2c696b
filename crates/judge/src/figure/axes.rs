//! Axes with numbers: those of the world, and that of t.

use glam::DVec3;

use super::drawing::{Drawing, HIDDEN, Hides};
use super::words::{multiple, number, round_step};

/// Draws axes through the origin that reach beyond all points, and the way along them to `to`.
pub fn draw(drawing: &mut Drawing, points: &[DVec3], to: DVec3, hidden: Hides) {
    let extent = points.iter().fold(0.0, |extent: f64, p| extent.max(p.abs().max_element()));
    // Some three to six steps to the largest coordinate.
    let step = if extent > 0.0 { round_step(extent / 2.5) } else { 1.0 };
    let least = points.iter().fold(DVec3::ZERO, |least, p| least.min(*p));
    let most = points.iter().fold(DVec3::ZERO, |most, p| most.max(*p));
    for (unit, letter) in DVec3::AXES.into_iter().zip(["x", "y", "z"]) {
        let from = least.dot(unit) - step / 2.0;
        let end = step * ((most.dot(unit) / step).floor() + 1.0);
        axis(drawing, letter, [DVec3::ZERO, unit], [from, end], step, hidden);
    }
    let in_floor = DVec3::new(to.x, 0.0, to.z);
    drawing.thin(&[DVec3::X * to.x, in_floor, to], HIDDEN);
}

/// Draws an axis through `origin`, from one of its numbers to another, and the numbers at its steps.
pub fn axis(
    drawing: &mut Drawing,
    letter: &str,
    [origin, unit]: [DVec3; 2],
    [from, end]: [f64; 2],
    step: f64,
    hidden: Hides,
) {
    let at = |x: f64| origin + unit * x;
    drawing.arrow([at(from), at(end)], "ink", hidden);
    drawing.label(at(end), letter, "", "ink");
    let first = (from / step).ceil() as i32;
    // None at the end itself, where the letter is.
    let last = (end / step - 0.1).floor() as i32;
    for i in (first..=last).filter(|i| *i != 0) {
        let x = multiple(step, i);
        drawing.tick(at(x), unit * step);
        drawing.label(at(x), "", &number(x), "soft");
    }
}
