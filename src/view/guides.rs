//! Where things of the world are in the picture: the pivot, the axes, the horizon; and which planes the eye
//! has gone through.

use glam::{DVec2, DVec3};

use crate::rays::{Lens, View};
use crate::scene::Scene;

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

/// The ends of the horizon at the left and the right edge of the picture: where directions across
/// `vertical` are seen. `None` through an orthographic camera, and straight up or down.
pub fn horizon(view: &View, size: DVec2, vertical: DVec3) -> Option<[DVec2; 2]> {
    let View { forward, right, true_up, h, lens, .. } = *view;
    if lens == Lens::Orthographic {
        return None;
    }
    let step = 2.0 * h / size.y;
    let end = |x: f64| {
        let across = (x - size.x / 2.0) * step;
        let up = -(forward.dot(vertical) + across * right.dot(vertical)) / true_up.dot(vertical);
        DVec2::new(x, size.y / 2.0 - up / step)
    };
    let ends = [end(0.0), end(size.x)];
    ends.iter().all(|end| end.is_finite() && end.y.abs() < 1e6).then_some(ends)
}

/// The ids of the planes between two eyes: one eye is on the side that the normal points to, the other is
/// not.
pub fn planes_between(scene: &Scene, eye: DVec3, other: DVec3) -> Vec<u32> {
    let first = scene.spheres.len() as u32 + 1;
    let between = scene.planes.iter().zip(first..).filter(|(plane, _)| {
        let side = |eye: DVec3| (eye - plane.point).dot(plane.normal) >= 0.0;
        side(eye) != side(other)
    });
    between.map(|(_, id)| id).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Pixels;
    use crate::scene::{Camera, Color, Plane, Projection};

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

    #[test]
    fn what_is_at_the_eyes_height_is_seen_at_the_horizon() {
        let perspective = view(LENSES[0]);
        let [left, right] = horizon(&perspective, SIZE, DVec3::Y).unwrap();
        let far = seen_at(&perspective, SIZE, DVec3::new(3.0, 2.0, -1e9)).unwrap();
        assert!((left.y - right.y).abs() < 1e-9 && (far.y - left.y).abs() < 1e-5);
        assert!(left.y < SIZE.y / 2.0, "it looks down");
        assert_eq!(horizon(&view(LENSES[1]), SIZE, DVec3::Y), None);
        let down = Camera { up: DVec3::Z, ..Camera::new(DVec3::Y, DVec3::ZERO) };
        assert_eq!(horizon(&View::new(&down), SIZE, DVec3::Y), None);
    }

    #[test]
    fn planes_that_the_eye_goes_through_are_noticed() {
        let plane = |point, normal| Plane { name: None, point, normal, color: Color::BLACK };
        let planes = vec![plane(DVec3::ZERO, DVec3::Y), plane(DVec3::Z * -9.0, DVec3::NEG_Z)];
        let scene = Scene { planes, ..Scene::default() };
        let between = |eye, other| planes_between(&scene, eye, other);
        let [above, below] = [DVec3::new(0.0, 1.0, 5.0), DVec3::new(0.0, -1.0, 5.0)];
        assert_eq!(between(above, below), [1]);
        assert_eq!(between(below, DVec3::new(0.0, 1.0, -20.0)), [1, 2]);
        assert_eq!(between(above, above), [0; 0]);
    }
}
