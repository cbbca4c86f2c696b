//! Figure 4: a sphere with its centre, its radius, and a point on it.

use std::f64::consts::TAU;

use glam::DVec3;
use kugelblitz::exact::{Dyadic, exact};
use kugelblitz::kernel::lecture::{quadratic, quadratic_roots};
use kugelblitz::num::V3;
use kugelblitz::rays::Lens;
use kugelblitz::scene::Sphere;

use super::axes;
use super::drawing::{Drawing, VISIBLE, towards_eye};
use super::words::{number, vector};

/// Corners of a circle.
const CORNERS: usize = 240;

/// Draws a sphere, with the first of `points` that lies on it; `None` where it is not before the camera,
/// or the camera is inside of it.
pub fn draw(
    sphere: &Sphere,
    points: impl IntoIterator<Item = DVec3>,
    drawing: &mut Drawing,
) -> Option<()> {
    let (c, r) = (sphere.center, sphere.radius);
    let view = drawing.pixels.view;
    let nearest = (c - view.position).dot(view.forward) - r;
    if nearest.is_nan() || nearest <= 0.0 {
        return None;
    }
    let toward = view.right * 0.62 + view.true_up * 0.45 - view.forward * 0.6;
    let known = points.into_iter().find(|p| is_on(*p, sphere));
    let p = known.unwrap_or_else(|| c + toward.normalize_or_zero() * r);

    drawing.surface(&outline(sphere, drawing)?);
    let hidden = |point: DVec3| {
        let way = towards_eye(&view, point).normalize_or_zero();
        let [o, d, c] = [point, way, c].map(V3::<f64>::lit);
        let q = quadratic(o, d, c, r);
        // The root of a point on the sphere is 0 up to that of f64's rounding.
        q.discriminant >= 0.0 && quadratic_roots(q)[1] > r * f64::EPSILON.sqrt()
    };
    axes::draw(drawing, &[c + DVec3::splat(r), c, p], c, &hidden);
    // What faces away from the eye.
    let is_behind = |point: DVec3| (point - c).dot(towards_eye(&view, point)) <= 0.0;
    for axis in 0..3 {
        let (u, v) = (DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3]);
        drawing.stroke(&circle(c, u * r, v * r), "surface", false, &is_behind);
    }
    drawing.arrow([c, p], "given", VISIBLE);
    drawing.dot(p, "found");
    if !drawing.dot(c, "given") {
        return None;
    }
    drawing.label(c, "c", &format!(" = {}", vector(c)), "given");
    drawing.label(c.lerp(p, 0.5), "r", &format!(" = {}", number(r)), "given");
    let of_p = known.map_or(String::new(), |p| format!(" = {}", vector(p)));
    drawing.label(p, "p", &of_p, "found");
    Some(())
}

/// Whether a point is exactly on a sphere.
fn is_on(p: DVec3, sphere: &Sphere) -> bool {
    let squared = |x: Dyadic| &x * &x;
    let apart = |axis: usize| squared(exact(p[axis]) - exact(sphere.center[axis]));
    apart(0) + apart(1) + apart(2) == squared(exact(sphere.radius))
}

/// Where the lines from the eye touch the sphere: a circle, whose image is an ellipse.
///
/// With `L` from the eye to the centre, a point of it is `c − (r²/L·L)·L` and `r·√(1 − r²/L·L)` across
/// `L`; parallel lines touch the sphere around its centre.
pub fn outline(sphere: &Sphere, drawing: &Drawing) -> Option<Vec<DVec3>> {
    let (c, r, view) = (sphere.center, sphere.radius, drawing.pixels.view);
    let (middle, axis, share) = match view.lens {
        Lens::Orthographic => (c, view.forward, 0.0),
        Lens::Perspective => {
            let l = c - view.position;
            let share = r * r / l.length_squared();
            (c - l * share, l.try_normalize()?, share)
        }
    };
    let u = (view.right - axis * view.right.dot(axis)).try_normalize()?;
    let radius = r * (1.0 - share).max(0.0).sqrt();
    Some(circle(middle, u * radius, axis.cross(u) * radius))
}

fn circle(middle: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
    let at = |i: i32| {
        // Rust's own sine is the system's, which may differ in its last bit.
        let angle = TAU * f64::from(i) / CORNERS as f64;
        middle + u * libm::cos(angle) + v * libm::sin(angle)
    };
    (0..=CORNERS as i32).map(at).collect()
}
