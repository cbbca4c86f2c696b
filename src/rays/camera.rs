//! Pixel → ray. `camera_direction` and `camera_origin` have their twins in `shaders/camera.wgsl`.
//!
//! Pixel `(i, j)`, twice its offset from the picture's centre, has the vector
//! `across = i·(h/H)·right + j·(h/H)·true_up` in the picture's plane. A perspective camera adds it
//! to the direction, an orthographic one to the origin.

use glam::DVec3;

use super::{Bundle, Ray};
use crate::kernel::RayOf;
use crate::scene::{Camera, Projection};
use crate::vec3::Vec3;

/// The part of a pixel's ray that its place in the picture decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lens {
    /// The direction.
    Perspective,
    /// The origin.
    Orthographic,
}

impl Lens {
    /// How the rays lie to each other.
    pub fn bundle(self) -> Bundle {
        match self {
            Lens::Perspective => Bundle::Point,
            Lens::Orthographic => Bundle::Parallel,
        }
    }
}

/// The camera's frame, computed once in f64. These f64 numbers *are* the camera (contract §1):
/// every exact statement about a pixel refers to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Eye point, or the middle of the picture's plane; world units.
    pub position: DVec3,
    /// Unit vector along the view axis (to f64 rounding).
    pub forward: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub true_up: DVec3,
    /// Tangent of half the vertical field of view; of an orthographic camera, half the picture's
    /// height in world units.
    pub h: f64,
    /// Says which of them `h` is.
    pub lens: Lens,
}

impl View {
    /// The frame of a checked camera.
    pub fn new(camera: &Camera) -> View {
        // Powers of two scale exactly, so a scene of any size keeps its frame bit for bit.
        let forward = unit(camera.look_at - camera.position);
        let right = unit(forward.cross(camera.up / power_of_two_near(camera.up)));
        let (lens, h) = match camera.projection {
            // The system's tangent may differ in its last bit from one machine to the next.
            Projection::Perspective { fov_degrees } => {
                (Lens::Perspective, libm::tan(fov_degrees.to_radians() / 2.0))
            }
            Projection::Orthographic { height } => (Lens::Orthographic, height / 2.0),
        };
        View { position: camera.position, forward, right, true_up: right.cross(forward), h, lens }
    }
}

/// `v / ‖v‖`, without overflow or underflow on the way.
fn unit(v: DVec3) -> DVec3 {
    let scaled = v / power_of_two_near(v);
    scaled / scaled.length()
}

/// The power of two just not above the largest component of `v` (1 for the zero vector).
fn power_of_two_near(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest == 0.0 || !largest.is_finite() {
        return 1.0;
    }
    if largest < f64::MIN_POSITIVE {
        return f64::MIN_POSITIVE;
    }
    f64::from_bits(largest.to_bits() & 0x7ff0_0000_0000_0000)
}

/// A rectangle of pixels of a picture seen by a [`View`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixels {
    /// The camera.
    pub view: View,
    /// Width of the whole picture, px.
    pub image_width: u32,
    /// Height of the whole picture, px.
    pub image_height: u32,
    /// Left column of the rectangle, px.
    pub x: u32,
    /// Top row of the rectangle, px.
    pub y: u32,
    /// Columns of the rectangle.
    pub width: u32,
    /// Rows of the rectangle.
    pub height: u32,
}

impl Pixels {
    /// The samples of these pixels, `n` × `n` each, as pixels of a picture `n` times as large: its centre
    /// rays are those through `x + (i + ½)/n`, `y + (j + ½)/n`.
    pub fn samples(&self, n: u32) -> Pixels {
        Pixels {
            view: self.view,
            image_width: self.image_width * n,
            image_height: self.image_height * n,
            x: self.x * n,
            y: self.y * n,
            width: self.width * n,
            height: self.height * n,
        }
    }

    /// All pixels of a picture.
    pub fn whole(view: View, image_width: u32, image_height: u32) -> Pixels {
        Pixels {
            view,
            image_width,
            image_height,
            x: 0,
            y: 0,
            width: image_width,
            height: image_height,
        }
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// True where the picture has all pixels of the rectangle.
    pub fn is_in_picture(&self) -> bool {
        let ends_within =
            |first: u32, n: u32, side| first.checked_add(n).is_some_and(|end| end <= side);
        ends_within(self.x, self.width, self.image_width)
            && ends_within(self.y, self.height, self.image_height)
    }

    /// True where the rectangle is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The rows `first..first + n` of this rectangle.
    pub fn rows(&self, first: u32, n: u32) -> Pixels {
        Pixels { y: self.y + first, height: n, ..*self }
    }

    /// Picture column and row of the `index`-th pixel of the rectangle.
    pub fn xy(&self, index: usize) -> (u32, u32) {
        let width = self.width as usize;
        (self.x + (index % width) as u32, self.y + (index / width) as u32)
    }

    /// Twice the offset of pixel `(x, y)` from the picture's centre, in pixels, right and up:
    /// `(2x + 1 − W, H − 2y − 1)`.
    pub fn offset2(&self, x: u32, y: u32) -> (i64, i64) {
        (
            2 * i64::from(x) + 1 - i64::from(self.image_width),
            i64::from(self.image_height) - 2 * i64::from(y) - 1,
        )
    }

    /// Centre ray of pixel `(x, y)` in f64 (contract §1 with `2(x+½)/W − 1` and `W/H` put together).
    pub fn ray(&self, x: u32, y: u32) -> Ray {
        Ray {
            origin: self.view.position + self.origin_offset(x, y),
            direction: self.direction(x, y),
        }
    }

    /// Centre ray direction of pixel `(x, y)` in f64: `forward + i·(h/H)·right + j·(h/H)·true_up`,
    /// or `forward`.
    pub fn direction(&self, x: u32, y: u32) -> DVec3 {
        DVec3::from_array(self.ray_from_position(x, y).direction.0)
    }

    /// Where the centre ray of pixel `(x, y)` starts in f64, from the camera's position:
    /// `i·(h/H)·right + j·(h/H)·true_up`, or 0.
    pub fn origin_offset(&self, x: u32, y: u32) -> DVec3 {
        DVec3::from_array(self.ray_from_position(x, y).origin.0)
    }

    /// Centre ray of pixel `(x, y)` in f64, relative to the camera's position.
    pub fn ray_from_position(&self, x: u32, y: u32) -> RayOf<f64> {
        let (i, j) = self.offset2(x, y);
        CameraF64::new(self).camera_ray(i as f64, j as f64)
    }
}

/// The camera in f64, as it is, at the origin of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraF64 {
    /// View axis.
    pub forward: Vec3<f64>,
    /// Unit vector to the right of the picture.
    pub right: Vec3<f64>,
    /// Unit vector to the top of the picture.
    pub true_up: Vec3<f64>,
    /// Half a pixel, at distance 1: `h/H`.
    pub step: f64,
    /// Says what `step` is a part of.
    pub lens: Lens,
}

impl CameraF64 {
    /// The camera of `pixels`.
    pub fn new(pixels: &Pixels) -> CameraF64 {
        let view = &pixels.view;
        CameraF64 {
            forward: view.forward.into(),
            right: view.right.into(),
            true_up: view.true_up.into(),
            step: view.h / f64::from(pixels.image_height),
            lens: view.lens,
        }
    }

    #[inline(always)]
    fn camera_direction(&self, i: f64, j: f64) -> Vec3<f64> {
        (self.forward + self.right * (self.step * i)) + self.true_up * (self.step * j)
    }

    #[inline(always)]
    fn camera_origin(&self, i: f64, j: f64) -> Vec3<f64> {
        Vec3::ZERO + (self.right * (self.step * i) + self.true_up * (self.step * j))
    }

    /// Centre ray of the pixel at twice the offset `(i, j)` from the picture's centre.
    #[inline(always)]
    pub fn camera_ray(&self, i: f64, j: f64) -> RayOf<f64> {
        match self.lens {
            Lens::Perspective => RayOf::new(Vec3::ZERO, Vec3::ZERO, self.camera_direction(i, j)),
            Lens::Orthographic => RayOf::new(self.camera_origin(i, j), Vec3::ZERO, self.forward),
        }
    }
}

/// The camera that f32 kernels see: rounded, with the pixel's size multiplied in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraF32 {
    /// Position in the kernel's coordinates.
    pub origin: Vec3<f32>,
    /// View axis.
    pub forward: Vec3<f32>,
    /// Half a pixel to the right, at distance 1: `(h/H)·right`.
    pub right_step: Vec3<f32>,
    /// Half a pixel to the top, at distance 1: `(h/H)·true_up`.
    pub true_up_step: Vec3<f32>,
    /// Says what the pixels' steps are added to.
    pub lens: Lens,
}

impl CameraF32 {
    /// Rounds the camera of `pixels`, with its position as the origin of coordinates.
    pub fn new(pixels: &Pixels) -> CameraF32 {
        let view = &pixels.view;
        let step = view.h / f64::from(pixels.image_height);
        CameraF32 {
            origin: Vec3::ZERO,
            forward: view.forward.into(),
            right_step: (view.right * step).into(),
            true_up_step: (view.true_up * step).into(),
            lens: view.lens,
        }
    }

    #[inline(always)]
    fn camera_direction(&self, i: f32, j: f32) -> Vec3<f32> {
        (self.forward + self.right_step * i) + self.true_up_step * j
    }

    #[inline(always)]
    fn camera_origin(&self, i: f32, j: f32) -> Vec3<f32> {
        self.origin + (self.right_step * i + self.true_up_step * j)
    }

    /// Centre ray of the pixel at twice the offset `(i, j)` from the picture's centre.
    #[inline(always)]
    pub fn camera_ray(&self, i: f32, j: f32) -> RayOf<f32> {
        match self.lens {
            Lens::Perspective => RayOf::new(self.origin, Vec3::ZERO, self.camera_direction(i, j)),
            Lens::Orthographic => RayOf::new(self.camera_origin(i, j), Vec3::ZERO, self.forward),
        }
    }
}
