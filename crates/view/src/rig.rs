//! The camera under the user's hand: pure arithmetic, without a window.

use glam::{DQuat, DVec2, DVec3};
use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{Camera, Projection, Scene, Sphere};

/// How close to straight up or down orbiting comes, radians: there "up" in the picture would turn
/// around.
const STEEPEST: f64 = 89.5 * std::f64::consts::PI / 180.0;

/// Nearest distance of `look_at`, as a part of the largest coordinate of the eye: the direction of
/// a shorter vector loses digits.
const NEAREST_LOOK_AT: f64 = 1e-3;

/// Smallest height of an orthographic camera's picture, and inverse of the largest, world units.
const SMALLEST_HEIGHT: f64 = 1e-100;

/// Room around what is framed.
const FRAME_MARGIN: f64 = 1.08;

/// The ball around all spheres of a scene, whose radius is above 0; planes have no end, so their points count only where
/// there is nothing else.
pub fn bounding_sphere(scene: &Scene) -> Sphere {
    let balls = scene.objects().map(|(_, object)| object.extent());
    let counts = |ball: &(DVec3, f64)| scene.spheres.is_empty() || ball.1 > 0.0;
    let balls: Vec<(DVec3, f64)> = balls.filter(counts).collect();
    let boxes = balls.iter().map(|&(c, r)| (c - r, c + r));
    let both = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let (low, high) = both.unwrap_or_default();
    let center = low / 2.0 + high / 2.0;
    let radius = balls.iter().map(|(c, r)| c.distance(center) + r).fold(0.0, f64::max);
    Sphere { center, radius: if radius > 0.0 { radius } else { 1.0 } }
}

/// The sides that a scene is looked at from along an axis, in the order of the keys 1 to 6: the name, and the
/// unit vector from the scene to the eye.
pub const SIDES: [(&str, DVec3); 6] = [
    ("+x", DVec3::X),
    ("+y", DVec3::Y),
    ("+z", DVec3::Z),
    ("−x", DVec3::NEG_X),
    ("−y", DVec3::NEG_Y),
    ("−z", DVec3::NEG_Z),
];

/// A camera and the point that it turns around.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The camera as it would stand in a scene file.
    pub camera: Camera,
    /// The point that orbiting turns around, world units.
    pub pivot: DVec3,
    /// The vertical that orbiting keeps; a unit vector.
    vertical: DVec3,
}

impl Rig {
    /// Begins with a scene's camera; it turns around what the camera looks at.
    pub fn new(camera: &Camera) -> Rig {
        Rig {
            camera: camera.clone(),
            pivot: camera.look_at,
            vertical: camera.up.normalize_or(DVec3::Y),
        }
    }

    /// The camera's frame.
    pub fn view(&self) -> View {
        View::new(&self.camera)
    }

    /// From the middle of the picture to a point of it, `at` in pixels from the top left corner of a
    /// picture of `size` pixels: at distance 1, or for an orthographic camera in world units.
    pub fn across(&self, at: DVec2, size: DVec2) -> DVec3 {
        let View { right, true_up, h, .. } = self.view();
        let step = 2.0 * h / size.y;
        right * (step * (at.x - size.x / 2.0)) + true_up * (step * (size.y / 2.0 - at.y))
    }

    /// Depth of the pivot along the view axis; the distance of `look_at` where the pivot lies
    /// behind the eye. It is 1 for an orthographic camera, to which all depths look alike.
    pub fn pivot_depth(&self) -> f64 {
        let View { forward, lens, .. } = self.view();
        let depth = (self.pivot - self.camera.position).dot(forward);
        match lens {
            Lens::Orthographic => 1.0,
            Lens::Perspective if depth > 0.0 => depth,
            Lens::Perspective => self.camera.look_at.distance(self.camera.position),
        }
    }

    /// Turns around the pivot: `yaw` to the right, `pitch` up, in radians.
    pub fn orbit(&mut self, yaw: f64, pitch: f64) {
        let View { forward, right, .. } = self.view();
        let steepness = forward.dot(self.vertical).clamp(-1.0, 1.0).asin();
        let pitch = (steepness + pitch).clamp(-STEEPEST, STEEPEST) - steepness;
        let turn =
            DQuat::from_axis_angle(self.vertical, yaw) * DQuat::from_axis_angle(right, pitch);
        let (pivot, camera) = (self.pivot, &mut self.camera);
        camera.position = pivot + turn * (camera.position - pivot);
        camera.look_at = pivot + turn * (camera.look_at - pivot);
        camera.up = self.vertical;
    }

    /// Moves sideways so that a point at the pivot's depth follows a pointer that moves by `by`
    /// pixels, right and down, over a picture `height` pixels high.
    pub fn pan(&mut self, by: DVec2, height: f64) {
        let View { right, true_up, h, .. } = self.view();
        let step = 2.0 * h / height * self.pivot_depth();
        self.translate((true_up * by.y - right * by.x) * step);
    }

    /// Goes toward the point at depth `t` that is seen `across` from the middle, so that its distance
    /// is multiplied by `factor`; an orthographic camera takes a picture of `factor` times the height.
    /// That point stays where it is in the picture.
    pub fn zoom(&mut self, across: DVec3, t: f64, factor: f64) {
        let direction = self.view().forward + across;
        let camera = &mut self.camera;
        if let Projection::Orthographic { height } = &mut camera.projection {
            let zoomed = (*height * factor).clamp(SMALLEST_HEIGHT, 1.0 / SMALLEST_HEIGHT);
            let aside = across * (1.0 - zoomed / *height);
            *height = zoomed;
            camera.position += aside;
            camera.look_at += aside;
            return;
        }
        let look = camera.look_at - camera.position;
        camera.position += direction * (t * (1.0 - factor));
        let nearest = NEAREST_LOOK_AT * camera.position.abs().max_element();
        let length = (look.length() * factor).max(nearest).max(f64::MIN_POSITIVE);
        camera.look_at = camera.position + look.normalize_or(DVec3::NEG_Z) * length;
    }

    /// Moves along the picture's axes: right, up and forward, world units.
    pub fn fly(&mut self, by: DVec3) {
        let View { right, true_up, forward, .. } = self.view();
        self.translate(right * by.x + true_up * by.y + forward * by.z);
    }

    /// Looks at all of `extent` from where it looks now; `aspect` is width over height.
    pub fn frame(&mut self, extent: Sphere, aspect: f64) {
        let View { forward, h, .. } = self.view();
        let radius = FRAME_MARGIN * extent.radius;
        let distance = match &mut self.camera.projection {
            // The narrower half angle is the one that counts.
            Projection::Perspective { .. } => radius / (h * aspect.min(1.0)).atan().sin(),
            Projection::Orthographic { height } => {
                *height = 2.0 * radius / aspect.min(1.0);
                2.0 * radius
            }
        };
        self.pivot = extent.center;
        self.camera.look_at = extent.center;
        self.camera.position = extent.center - forward * distance;
    }

    /// Looks at all of `extent` from the side of a unit vector.
    pub fn look_from(&mut self, to_eye: DVec3, extent: Sphere, aspect: f64) {
        let forward = -to_eye;
        let is_steep = forward.dot(self.vertical).abs() > STEEPEST.sin();
        // Seen from above, what lay farther away is up in the picture.
        let sideways = [DVec3::NEG_Z, DVec3::X].into_iter().find(|v| v.dot(forward).abs() < 0.5);
        let up = if is_steep { sideways.unwrap_or(DVec3::X) } else { self.vertical };
        self.camera.up = up;
        self.camera.position = extent.center;
        self.camera.look_at = extent.center + forward;
        self.frame(extent, aspect);
    }

    fn translate(&mut self, by: DVec3) {
        self.camera.position += by;
        self.camera.look_at += by;
        self.pivot += by;
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use kugelblitz::scene::{Color, Plane, parse_scene};

    use super::*;

    fn rig() -> Rig {
        Rig::new(&Camera {
            position: DVec3::new(1.0, 2.0, 9.0),
            look_at: DVec3::new(0.0, 1.0, 0.0),
            up: DVec3::Y,
            projection: Projection::Perspective { fov_degrees: 40.0 },
        })
    }

    fn sphere(center: DVec3, radius: f64) -> Sphere {
        Sphere { center, radius }
    }

    fn scene(spheres: Vec<Sphere>, planes: Vec<Plane>) -> Scene {
        Scene { spheres: spheres.into(), planes, ..Scene::default() }
    }

    const SIZE: DVec2 = DVec2::new(640.0, 360.0);

    /// Where a point appears in a picture of [`SIZE`].
    fn seen_at(rig: &Rig, point: DVec3) -> DVec2 {
        let View { position, forward, right, true_up, h, lens } = rig.view();
        let l = point - position;
        let depth = if lens == Lens::Perspective { l.dot(forward) } else { 1.0 };
        let step = 2.0 * h / SIZE.y * depth;
        SIZE / 2.0 + DVec2::new(l.dot(right), -l.dot(true_up)) / step
    }

    #[track_caller]
    fn assert_close(a: DVec2, b: DVec2) {
        assert!(a.distance(b) < 1e-6, "{a} and {b}");
    }

    #[test]
    fn orbit_keeps_the_distance_the_horizon_and_where_the_pivot_is_seen() {
        let mut rig = rig();
        rig.pivot = DVec3::new(0.5, 0.3, -1.0);
        let before = rig.clone();
        rig.orbit(0.7, -0.4);
        let distance = |rig: &Rig| rig.camera.position.distance(rig.pivot);
        assert!((distance(&rig) - distance(&before)).abs() < 1e-9);
        assert!(rig.view().right.y.abs() < 1e-12, "the horizon is level");
        assert_close(seen_at(&rig, rig.pivot), seen_at(&before, rig.pivot));
        assert!(rig.camera.position.distance(before.camera.position) > 1.0);
        rig.orbit(-0.7, 0.0);
        rig.orbit(0.0, 0.4);
        assert!(rig.camera.position.distance(before.camera.position) < 1e-9, "and back");
    }

    #[test]
    fn orbit_stops_before_the_poles() {
        let mut rig = rig();
        for _ in 0..100 {
            rig.orbit(0.01, -0.3);
        }
        let view = rig.view();
        assert!(view.forward.y < -0.999 && view.right.is_finite());
        assert!(rig.camera.position.is_finite() && view.true_up.y > 0.0);
        rig.orbit(0.0, 0.5);
        assert!(rig.view().forward.y > -0.99);
    }

    #[test]
    fn pan_moves_the_pivot_with_the_pointer() {
        for mut rig in [rig(), orthographic_rig()] {
            let by = DVec2::new(31.0, -17.0);
            let (point, before) = (rig.pivot, seen_at(&rig, rig.pivot));
            rig.pan(by, SIZE.y);
            assert_close(seen_at(&rig, point), before + by);
            assert_eq!(rig.view().forward, self::rig().view().forward);
        }
    }

    fn orthographic_rig() -> Rig {
        let mut rig = rig();
        rig.camera.projection = Projection::Orthographic { height: 7.0 };
        rig
    }

    /// It comes nearer, or takes another height; endlessly it still has a view.
    #[test]
    fn zoom_keeps_the_point_under_the_pointer() {
        let pointer = DVec2::new(500.0, 90.0);
        for mut rig in [rig(), orthographic_rig()] {
            let (depth, across) = (6.0, rig.across(pointer, SIZE));
            let View { position, forward, lens, .. } = rig.view();
            let is_perspective = lens == Lens::Perspective;
            let aside = if is_perspective { across * depth } else { across };
            let point = position + forward * depth + aside;
            let size = |rig: &Rig| match rig.camera.projection {
                Projection::Orthographic { height } => height,
                _ => rig.camera.position.distance(point),
            };
            for factor in [0.5, 0.9, 3.0] {
                let before = size(&rig);
                let depth = (point - rig.camera.position).dot(forward);
                rig.zoom(rig.across(pointer, SIZE), depth, factor);
                assert_close(seen_at(&rig, point), pointer);
                assert!((size(&rig) - before * factor).abs() < 1e-9);
            }
            for _ in 0..5000 {
                rig.zoom(rig.across(SIZE / 2.0, SIZE), rig.pivot_depth(), 0.8);
            }
            let View { position, forward, right, h, .. } = rig.view();
            assert!(h > 0.0 && position.is_finite() && right.is_finite(), "{:?}", rig.view());
            assert!((forward.length() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn an_orthographic_camera_frames() {
        let mut rig = orthographic_rig();
        let extent = Sphere { center: DVec3::new(1.0, 2.0, 3.0), radius: 4.0 };
        for aspect in [1.5, 0.5] {
            rig.frame(extent, aspect);
            let View { position, forward, h, .. } = rig.view();
            assert!((extent.center - position).dot(forward) > extent.radius, "before the plane");
            let narrower = h * aspect.min(1.0);
            assert!((1.0..1.2).contains(&(narrower / extent.radius)), "fills it");
        }
    }

    #[test]
    fn flying_goes_along_the_pictures_axes() {
        let mut rig = rig();
        let (view, before) = (rig.view(), rig.camera.position);
        rig.fly(DVec3::new(1.0, 2.0, 3.0));
        let moved = rig.camera.position - before;
        let along = [view.right, view.true_up, view.forward].map(|axis| moved.dot(axis));
        for (found, expected) in along.into_iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-9);
        }
        assert!(rig.view().forward.distance(view.forward) < 1e-12);
    }

    #[test]
    fn everything_is_in_the_frame_and_fills_it() {
        let spheres = vec![sphere(DVec3::new(-3.0, 0.0, 2.0), 1.0), sphere(DVec3::X * 5.0, 2.0)];
        let extent = bounding_sphere(&scene(spheres.clone(), Vec::new()));
        for aspect in [SIZE.x / SIZE.y, 0.5] {
            let size = DVec2::new(SIZE.y * aspect, SIZE.y);
            let mut rig = rig();
            rig.frame(extent, aspect);
            let View { position, forward, right, true_up, h, .. } = rig.view();
            // The planes of the frame's sides: a ball is inside where it is far enough from them.
            let sides = [(right, h * aspect), (-right, h * aspect), (true_up, h), (-true_up, h)];
            let room = |center: DVec3, radius: f64| {
                let gap = |(axis, h): (DVec3, f64)| {
                    let inward = (forward * h - axis).normalize();
                    (center - position).dot(inward) - radius
                };
                sides.map(gap).into_iter().fold(f64::INFINITY, f64::min)
            };
            for sphere in &spheres {
                assert!(room(sphere.center, sphere.radius) > 0.0, "{size}");
            }
            assert!(room(extent.center, extent.radius) < 0.1 * extent.radius, "fills it");
        }
    }

    #[test]
    fn axes_look_along_themselves() {
        let extent = Sphere { center: DVec3::new(1.0, 2.0, 3.0), radius: 4.0 };
        for (name, to_eye) in SIDES {
            let mut rig = rig();
            rig.look_from(to_eye, extent, 1.5);
            let view = rig.view();
            assert!(view.forward.distance(-to_eye) < 1e-12, "{name}");
            assert!(view.right.is_finite(), "{name}");
            assert_close(seen_at(&rig, extent.center), SIZE / 2.0);
            // From there, orbiting works and the horizon is level again.
            rig.orbit(0.3, 0.2);
            assert!(rig.view().right.y.abs() < 1e-9, "{name}");
        }
    }

    #[test]
    fn the_extent_counts_planes_only_where_there_is_nothing_else() {
        let plane = |point| Plane { name: None, point, normal: DVec3::Y, color: Color::BLACK };
        let ball = sphere(DVec3::X, 2.0);
        let far = vec![plane(DVec3::ZERO), plane(DVec3::Z * 8.0)];
        let extent = bounding_sphere(&scene(vec![ball], far.clone()));
        assert_eq!((extent.center, extent.radius), (DVec3::X, 2.0));
        let extent = bounding_sphere(&scene(Vec::new(), far));
        assert_eq!((extent.center, extent.radius), (DVec3::Z * 4.0, 4.0));
        assert_eq!(bounding_sphere(&scene(Vec::new(), Vec::new())).radius, 1.0);
    }

    #[test]
    fn a_printed_camera_is_the_same_camera() {
        for mut rig in [rig(), orthographic_rig()] {
            rig.orbit(0.123, 0.0456);
            rig.zoom(rig.across(DVec2::new(3.0, 4.0), SIZE), 1e-7, 0.3);
            let scene = parse_scene(&rig.camera.to_toml(), Path::new("p.toml")).unwrap();
            assert_eq!(scene.camera, Some(rig.camera));
        }
    }
}
