//! A plain scene, which every renderer draws right if it means the same camera.

use glam::DVec3;

use crate::camera::{Pixels, View};
use crate::control::Control;
use crate::error::Result;
use crate::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use crate::verify::Truth;

/// Width and height.
pub const SIZE: [u32; 2] = [64, 48];

/// Pixels that rounding to f32 may cost. A picture that is off by half a pixel has ten times as
/// many wrong ones.
pub const MAX_WRONG: usize = 5;

/// Three spheres on a floor, nothing far, small or touching.
pub fn scene() -> Scene {
    let sphere = |x, y, z, radius| Sphere {
        name: None,
        center: DVec3::new(x, y, z),
        radius,
        color: Color::BLACK,
    };
    let floor = Plane {
        name: None,
        point: DVec3::new(0.0, -1.1, 0.0),
        normal: DVec3::new(0.1, 1.0, 0.0),
        color: Color::BLACK,
    };
    Scene {
        spheres: vec![
            sphere(-1.3, 0.9, 0.1, 0.83),
            sphere(1.1, 0.4, 0.7, 0.71),
            sphere(0.2, -0.3, -1.2, 1.07),
        ],
        planes: vec![floor],
        ..Scene::default()
    }
}

/// From the side, so that no axis of the picture is one of the world.
pub fn view() -> View {
    View::new(&Camera {
        position: DVec3::new(1.7, 1.3, 6.1),
        look_at: DVec3::new(0.1, 0.2, 0.0),
        up: DVec3::new(0.2, 1.0, 0.1),
        projection: Projection::Perspective { fov_degrees: 41.0 },
    })
}

/// Pixels with another id than the exact one.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted) when `control` was cancelled.
pub fn wrong_pixels(ids: &[u32], control: &Control) -> Result<usize> {
    let truth = exact(view(), control)?;
    Ok(truth.iter().zip(ids).filter(|(exact, found)| exact != found).count())
}

fn exact(view: View, control: &Control) -> Result<Vec<u32>> {
    let pixels = Pixels::whole(view, SIZE[0], SIZE[1]);
    Ok(Truth::of_pixels(&scene(), &pixels, (0..pixels.len()).collect(), control)?.id)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// What a renderer without fault sees.
    pub fn right() -> Vec<u32> {
        exact(view(), &Control::default()).unwrap()
    }

    /// The same, looking half a pixel beside.
    pub fn half_a_pixel_off(to_right: f64, to_top: f64) -> Vec<u32> {
        let view = view();
        let half_pixel = view.h / f64::from(SIZE[1]);
        let aside = view.right * (half_pixel * to_right) + view.true_up * (half_pixel * to_top);
        exact(View { forward: view.forward + aside, ..view }, &Control::default()).unwrap()
    }

    fn n_wrong(ids: &[u32]) -> usize {
        wrong_pixels(ids, &Control::default()).unwrap()
    }

    #[test]
    fn a_right_picture_is_right_and_has_every_object() {
        assert_eq!(n_wrong(&right()), 0);
        for id in 0..=4 {
            assert!(right().iter().filter(|&&seen| seen == id).count() > 100, "{id}");
        }
    }

    #[test]
    fn half_a_pixel_and_mirrored_pictures_are_noticed() {
        for (to_right, to_top) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let n_wrong = n_wrong(&half_a_pixel_off(to_right, to_top));
            assert!(n_wrong > 5 * MAX_WRONG, "{to_right}, {to_top}: {n_wrong}");
        }
        let right = right();
        let upside_down: Vec<u32> = right.iter().rev().copied().collect();
        assert!(n_wrong(&upside_down) > 500);
        let width = SIZE[0] as usize;
        let mirrored: Vec<u32> =
            right.chunks(width).flat_map(|row| row.iter().rev().copied()).collect();
        assert!(n_wrong(&mirrored) > 500);
    }
}
