//! World → picture: the way of a pixel's ray back.

use glam::{DVec2, DVec3};

use crate::rays::{Lens, Pixels};

/// Where a point of the world is in a picture, in pixels from its top left corner; `None` for one that
/// is not before the camera. The centre of pixel `(x, y)` is `(x + ½, y + ½)`.
///
/// A pixel's ray has `d = forward + across`, so the point at depth `t` along it is `t·across` off the
/// axis; with an orthographic camera it is `across`.
pub fn project(pixels: &Pixels, point: DVec3) -> Option<DVec2> {
    let view = &pixels.view;
    let from_eye = point - view.position;
    let depth = from_eye.dot(view.forward);
    if depth.is_nan() || depth <= 0.0 {
        return None;
    }
    let scale = match view.lens {
        Lens::Perspective => depth * view.h,
        Lens::Orthographic => view.h,
    };
    let (width, height) = (f64::from(pixels.image_width), f64::from(pixels.image_height));
    let across = DVec2::new(from_eye.dot(view.right), -from_eye.dot(view.true_up)) / scale;
    let at = DVec2::new(width, height) / 2.0 + across * (height / 2.0);
    at.is_finite().then_some(at)
}

/// From a point towards the eye, not of any length.
pub fn towards_eye(pixels: &Pixels, point: DVec3) -> DVec3 {
    match pixels.view.lens {
        Lens::Perspective => pixels.view.position - point,
        Lens::Orthographic => -pixels.view.forward,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::View;
    use crate::scene::{Camera, Projection};

    /// The points of a pixel's ray are seen at its centre.
    #[test]
    fn it_is_the_way_of_a_ray_back() {
        let mut camera = Camera::new(DVec3::new(4.0, 2.2, 7.5), DVec3::new(0.8, 0.6, 0.0));
        for height in [None, Some(3.0)] {
            if let Some(height) = height {
                camera.projection = Projection::Orthographic { height };
            }
            let pixels = Pixels::whole(View::new(&camera), 641, 360);
            for (x, y) in [(0, 0), (320, 180), (640, 359), (17, 203)] {
                let ray = pixels.ray(x, y);
                for t in [0.01, 1.0, 70.0] {
                    let at = project(&pixels, ray.origin + ray.direction * t).unwrap();
                    let expected = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    assert!((at - expected).length() < 1e-9, "{at}, {expected}");
                }
                assert_eq!(project(&pixels, ray.origin - ray.direction), None);
            }
        }
    }
}
