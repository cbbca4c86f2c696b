//! The step from a pixel to its ray, as a derivation.

use kugelblitz::exact::{QuadraticSurd, exact, integer};
use kugelblitz::num::{Real as _, V3};
use kugelblitz::rays::{Lens, Pixels};
use kugelblitz::scene::{Projection, Scene};
use serde::Serialize;

use super::calculator::Calculator as _;
use super::derivation::Derivation;
use super::derivation::LineDetail::{Numbers, Result as ResultOnly};
use super::expression::Expression;
use super::line::Line;
use super::numbers::{Short, decimal_f64};
use super::step::{Step, Tape, show};
use super::words::ExplanationWords;

/// Digits of an f64 that are printed at most, as more would be digits of its binary fraction.
const F64_DIGITS: usize = 17;

/// The camera's part of a pixel's ray: `forward + u·right + v·true_up` is the direction of a perspective camera's ray;
/// an orthographic camera adds `u·right + v·true_up` to its position.
#[derive(Clone, Debug, Serialize)]
pub struct CameraExplanation {
    /// `perspective` or `orthographic`.
    pub projection: &'static str,
    /// Tangent of half the vertical field of view; of an orthographic camera, half the height of the picture in world units.
    pub h: f64,
    /// Width of the picture divided by its height.
    pub aspect: f64,
    /// Offset of the pixel's centre to the right, in the unit of `h`.
    pub u: f64,
    /// Offset of the pixel's centre to the top, in the unit of `h`.
    pub v: f64,
    /// Unit vector along the view axis.
    pub forward: [f64; 3],
    /// Unit vector to the right of the picture.
    pub right: [f64; 3],
    /// Unit vector to the top of the picture.
    pub true_up: [f64; 3],
    /// The formulas with the exact numbers put in.
    pub formulas: Vec<String>,
}

/// Derives `o` and `d` of the first pixel's centre ray from the camera, exactly, and returns them with the derivation.
pub(super) fn derive<'t>(
    tape: &'t Tape,
    pixels: &Pixels,
    scene: &Scene,
    words: &ExplanationWords,
    digits: usize,
) -> (Derivation, [V3<Step<'t>>; 2], CameraExplanation) {
    let Pixels { view, image_width, image_height, x, y, .. } = *pixels;
    let mut derivation = Derivation::new(digits);
    let count = |name, n: u32| tape.number(name, QuadraticSurd::from(integer(n.into())));
    let (x, y) = (count("x", x), count("y", y));
    let (width, height) = (count("W", image_width), count("H", image_height));
    let [one, two, half] = [1.0, 2.0, 0.5].map(Step::lit);

    let h = match view.lens {
        Lens::Perspective => {
            let h = tape.number("h", QuadraticSurd::from(exact(view.h)));
            derivation.lines.push(tangent(fov_degrees(scene, view.h), view.h, digits));
            h
        }
        Lens::Orthographic => {
            let h = tape.number("height", QuadraticSurd::from(exact(2.0 * view.h))) / two;
            derivation.written(["h"; 2], ["height / 2", r"\frac{\text{height}}{2}"], h);
            h
        }
    };
    let aspect = width / height;
    derivation.line("", &[aspect], Numbers);
    let u = (two * (x + half) / width - one) * h * aspect;
    let latex = r"\left(\frac{2(x + \frac{1}{2})}{W} - 1\right) h\,\frac{W}{H}";
    derivation.written(["u"; 2], ["(2·(x + ½)/W − 1)·h·W/H", latex], u);
    let v = (one - two * (y + half) / height) * h;
    let latex = r"\left(1 - \frac{2(y + \frac{1}{2})}{H}\right) h";
    derivation.written(["v"; 2], ["(1 − 2·(y + ½)/H)·h", latex], v);
    show(&[u], "u");
    show(&[v], "v");

    let of_view = |name, v: glam::DVec3| tape.vector_of_scene(name, v);
    let axes = [view.forward, view.right, view.true_up];
    let [forward, right, true_up] = [0, 1, 2].map(|axis| of_view(words.axes[axis], axes[axis]));
    derivation.given_below(words.axes[0], &forward.0);
    derivation.given(words.axes[1], &right.0);
    derivation.given(words.axes[2], &true_up.0);
    let across = |from: V3<Step<'t>>| from + V3([u; 3]).times(right) + V3([v; 3]).times(true_up);
    let ray = match view.lens {
        Lens::Perspective => {
            let o = of_view("o", view.position);
            derivation.given_below("o", &o.0);
            let d = across(forward);
            derivation.line("d", &d.0, Numbers);
            [o, d]
        }
        Lens::Orthographic => {
            let position = of_view("position", view.position);
            derivation.given_below("position", &position.0);
            let o = across(position);
            derivation.line("o", &o.0, Numbers);
            derivation.line("d", &forward.0, ResultOnly);
            [o, forward]
        }
    };
    let camera = CameraExplanation {
        projection: match view.lens {
            Lens::Perspective => "perspective",
            Lens::Orthographic => "orthographic",
        },
        h: view.h,
        aspect: aspect.value().to_f64(),
        u: u.value().to_f64(),
        v: v.value().to_f64(),
        forward: view.forward.to_array(),
        right: view.right.to_array(),
        true_up: view.true_up.to_array(),
        formulas: derivation.formulas(),
    };
    (derivation, ray, camera)
}

/// Returns the scene's field of view if its tangent is `h`, otherwise the field of view of `h`, in degrees.
fn fov_degrees(scene: &Scene, h: f64) -> f64 {
    let of_scene = scene.camera.as_ref().and_then(|camera| match camera.projection {
        Projection::Perspective { fov_degrees } => Some(fov_degrees),
        Projection::Orthographic { .. } => None,
    });
    let is_own = |fov: &f64| libm::tan(fov.to_radians() / 2.0) == h;
    of_scene.filter(is_own).unwrap_or_else(|| (2.0 * libm::atan(h)).to_degrees())
}

/// `h = tan(fov / 2)`
fn tangent(fov_degrees: f64, h: f64, digits: usize) -> Line {
    let mut line = Line::of("h", false);
    let fov = decimal_f64(fov_degrees);
    let h = QuadraticSurd::from(exact(h)).to_decimal(digits.min(F64_DIGITS));
    line.pieces.extend([
        Expression::Written { text: "tan(fov / 2)".into(), latex: r"\tan(\text{fov} / 2)".into() },
        Expression::Written {
            text: format!("tan({fov}° / 2)"),
            latex: format!(r"\tan({fov}^\circ / 2)"),
        },
        Expression::Number(Short { text: h, rounded: true }),
    ]);
    line
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use kugelblitz::exact::ExactPixels;
    use kugelblitz::rays::View;
    use kugelblitz::scene::Camera;

    use super::super::Lang;
    use super::*;

    /// The derivation ends in the very ray that exact arithmetic traces.
    #[test]
    fn the_derived_ray_is_the_exact_ray() {
        let mut camera = Camera::new(DVec3::new(4.0, 2.2, 7.5), DVec3::new(0.8, 0.6, 0.1));
        for height in [None, Some(3.7)] {
            if let Some(height) = height {
                camera.projection = Projection::Orthographic { height };
            }
            let whole = Pixels::whole(View::new(&camera), 641, 357);
            for (x, y) in [(0, 0), (320, 178), (640, 356), (17, 203)] {
                let pixels = Pixels { x, y, width: 1, height: 1, ..whole };
                let scene = Scene { camera: Some(camera.clone()), ..Scene::default() };
                let tape = Tape::default();
                let (_, [o, d], _) = derive(&tape, &pixels, &scene, Lang::English.words(), 6);
                let ray = ExactPixels::new(&pixels).ray(x, y);
                for axis in 0..3 {
                    let origin =
                        QuadraticSurd::ratio(ray.origin()[axis].clone(), ray.world_scale());
                    let scale = ray.direction_scale();
                    let direction = QuadraticSurd::ratio(ray.direction()[axis].clone(), scale);
                    assert_eq!(o.0[axis].value(), origin, "o, {x},{y}");
                    assert_eq!(d.0[axis].value(), direction, "d, {x},{y}");
                }
            }
        }
    }
}
