//! Where things of the world are in the picture: the pivot and the axes.

use glam::{DVec2, DVec3};

use crate::rays::{Lens, View};

/// Length of the axes, as a part of the picture's height.
const AXIS: f64 = 0.16;

/// The point of a picture of `size` pixels where a point of the world is seen, pixels from the top left
/// corner; `None` behind the eye.
pub fn seen_at(view: &View, size: DVec2, point: DVec3) -> Option<DVec2> {
    let View { position, forward, right, true_up, h, lens } = *view;
    let l = point - position;
    let depth = match lens {
        Lens::Perspective => l.dot(forward),
        Lens::Orthographic => 1.0,
    };
    let step = 2.0 * h / size.y * depth;
    let at = size / 2.0 + DVec2::new(l.dot(right), -l.dot(true_up)) / step;
    (depth > 0.0 && at.is_finite()).then_some(at)
}

/// The ends of the axes x, y and z at the pivot; all equally long in the world.
pub fn axes(view: &View, size: DVec2, pivot: DVec3) -> [Option<DVec2>; 3] {
    let depth = match view.lens {
        Lens::Perspective => (pivot - view.position).dot(view.forward),
        Lens::Orthographic => 1.0,
    };
    let length = AXIS * 2.0 * view.h * depth;
    [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| seen_at(view, size, pivot + axis * length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Pixels;
    use crate::scene::{Camera, Projection};

    const SIZE: DVec2 = DVec2::new(640.0, 360.0);

    fn view(projection: Projection) -> View {
        View::new(&Camera {
            position: DVec3::new(1.0, 2.0, 9.0),
            look_at: DVec3::new(0.0, 1.0, 0.0),
            up: DVec3::Y,
            projection,
        })
    }

    const LENSES: [Projection; 2] =
        [Projection::Perspective { fov_degrees: 40.0 }, Projection::Orthographic { height: 7.0 }];

    #[test]
    fn a_pixels_ray_goes_through_what_is_seen_there() {
        for projection in LENSES {
            let view = view(projection);
            let pixels = Pixels::whole(view, SIZE.x as u32, SIZE.y as u32);
            for [x, y] in [[0, 0], [17, 300], [320, 180]] {
                let ray = pixels.ray(x, y);
                let at = seen_at(&view, SIZE, ray.origin + ray.direction * 3.0).unwrap();
                let expected = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                assert!(at.distance(expected) < 1e-9, "{at}");
            }
        }
        let behind = DVec3::new(1.0, 2.0, 20.0);
        assert_eq!(seen_at(&view(LENSES[0]), SIZE, behind), None);
    }

    #[test]
    fn axes_begin_at_the_pivot_and_point_their_way() {
        for projection in LENSES {
            let view = view(projection);
            let pivot = DVec3::new(0.0, 1.0, 0.0);
            let start = seen_at(&view, SIZE, pivot).unwrap();
            let [x, y, _] = axes(&view, SIZE, pivot).map(|end| end.unwrap() - start);
            assert!(x.x > 40.0 && y.y < -40.0, "{x} {y}");
        }
    }
}
