//! Figure 3: a plane with its point, its normal, and another point.

use glam::DVec3;
use kugelblitz::scene::Plane;

use super::axes;
use super::drawing::{Drawing, VISIBLE, towards_eye};
use super::words::vector;

/// Half the side of the piece of the plane that is shown, as a part of the larger of `|a|` and `|n|`.
const REACH: f64 = 1.3;

/// Side of the mark of a right angle, as a part of `|n|`.
const RIGHT_ANGLE: f64 = 0.14;

/// Draws a plane; `None` where its point is not before the camera.
pub fn draw(plane: &Plane, drawing: &mut Drawing) -> Option<()> {
    let (a, n) = (plane.point, plane.normal);
    let unit = n.try_normalize()?;
    let view = drawing.pixels.view;
    // Along the picture's right side, and away from the eye or up.
    let in_plane = |v: DVec3| (v - unit * v.dot(unit)).try_normalize();
    let right = in_plane(view.right).or_else(|| in_plane(view.true_up))?;
    let across = unit.cross(right);
    let back = if across.dot(view.forward + view.true_up) < 0.0 { -across } else { across };
    let half = REACH * a.length().max(n.length());
    let at = |x: f64, y: f64| a + right * (x * half) + back * (y * half);
    let p = at(0.55, -0.5);

    let corners = [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
    drawing.surface(&corners);
    let hidden = |point: DVec3| {
        let way = towards_eye(&view, point);
        let s = (a - point).dot(unit) / way.dot(unit);
        let off = point + way * s - a;
        // What lies in the plane itself is not hidden by it.
        let in_it = (a - point).dot(unit).abs() <= half * f64::EPSILON.sqrt();
        !in_it && s > 0.0 && off.dot(right).abs() <= half && off.dot(back).abs() <= half
    };
    axes::draw(drawing, &[a, a + n, p, DVec3::splat(1.8 * half)], a, &hidden);
    drawing.arrow([a, p], "found", VISIBLE);
    drawing.arrow([a, a + n], "given", VISIBLE);
    let side = RIGHT_ANGLE * n.length();
    let along = (p - a).normalize_or_zero() * side;
    let mark = [a + along, a + along + unit * side, a + unit * side];
    drawing.stroke(&mark, "soft", false, VISIBLE);
    drawing.dot(p, "found");
    if !drawing.dot(a, "given") {
        return None;
    }
    drawing.label(a, "a", &format!(" = {}", vector(a)), "given");
    drawing.label(a + n * 0.9, "n", &format!(" = {}", vector(n)), "given");
    drawing.label(p, "p", "", "found");
    drawing.label(a.lerp(p, 0.55), "p − a", "", "found");
    Some(())
}
