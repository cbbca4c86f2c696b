//! Pixel → ray. A device has [`camera_direction`] and [`camera_origin`] in `shaders/printed/camera.wgsl`.
//!
//! Pixel `(i, j)`, twice its offset from the picture's centre, has the vector
//! `across = i·(h/H)·right + j·(h/H)·true_up` in the picture's plane. A perspective camera adds it
//! to the direction, an orthographic one to the origin.

use glam::{DVec2, DVec3};

use crate::num::{Float, Ray, Real, V3};
use crate::scene::{Camera, Projection};

/// The part of a pixel's ray that its place in the picture decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lens {
    /// The direction.
    Perspective,
    /// The origin.
    Orthographic,
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

    /// All pixels of the picture that these are a part of.
    pub fn picture(&self) -> Pixels {
        Pixels::whole(self.view, self.image_width, self.image_height)
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

    /// The part of the picture with this left column, top row, width and height; `None` where it is empty, or reaches
    /// beyond the picture.
    pub fn part(&self, [x, y, width, height]: [u32; 4]) -> Option<Pixels> {
        let part = Pixels { x, y, width, height, ..*self };
        Some(part).filter(|part| !part.is_empty() && part.is_in_picture())
    }

    /// The pixel in this column and row of the picture alone; `None` where it is outside the rectangle.
    pub fn pixel(&self, [x, y]: [i64; 2]) -> Option<Pixels> {
        let inside = |at: i64, first: u32, n: u32| {
            let at = u32::try_from(at).ok()?;
            at.checked_sub(first).filter(|at| *at < n).map(|_| at)
        };
        let (x, y) = inside(x, self.x, self.width).zip(inside(y, self.y, self.height))?;
        Some(Pixels { x, y, width: 1, height: 1, ..*self })
    }

    /// Picture column and row of the `index`-th pixel of the rectangle.
    pub fn xy(&self, index: usize) -> (u32, u32) {
        let width = self.width as usize;
        (self.x + (index % width) as u32, self.y + (index / width) as u32)
    }

    /// Where a point of the world is in the picture, in pixels from its top left corner; `None` for one that
    /// is not before the camera. The centre of pixel `(x, y)` is `(x + ½, y + ½)`.
    ///
    /// A pixel's ray has `d = forward + across`, so the point at depth `t` along it is `t·across` off the
    /// axis; with an orthographic camera it is `across`.
    pub fn seen_at(&self, point: DVec3) -> Option<DVec2> {
        let view = &self.view;
        let from_eye = point - view.position;
        let depth = from_eye.dot(view.forward);
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        let scale = match view.lens {
            Lens::Perspective => depth * view.h,
            Lens::Orthographic => view.h,
        };
        let (width, height) = (f64::from(self.image_width), f64::from(self.image_height));
        let across = DVec2::new(from_eye.dot(view.right), -from_eye.dot(view.true_up)) / scale;
        let at = DVec2::new(width, height) / 2.0 + across * (height / 2.0);
        at.is_finite().then_some(at)
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
    pub fn ray(&self, x: u32, y: u32) -> super::WorldRay {
        super::WorldRay {
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
    pub fn ray_from_position(&self, x: u32, y: u32) -> Ray<f64> {
        let ((i, j), step) = (self.offset2(x, y), self.step());
        Frame::<f64>::new(&self.view, 1.0).ray(step * i as f64, step * j as f64)
    }

    /// Half a pixel at distance 1, or in world units: `h/H`.
    pub fn step(&self) -> f64 {
        self.view.h / f64::from(self.image_height)
    }
}

/// The camera's frame in numbers of `F`, at the origin of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<F> {
    /// View axis.
    pub forward: V3<F>,
    /// A step to the right of the picture, at distance 1.
    pub right: V3<F>,
    /// A step to its top.
    pub true_up: V3<F>,
    /// Says what the steps are added to.
    pub lens: Lens,
}

impl<F: Float> Frame<F> {
    /// That of a view, rounded, with steps of this length.
    pub fn new(view: &View, step: f64) -> Frame<F> {
        Frame {
            forward: V3::lit(view.forward),
            right: V3::lit(view.right * step),
            true_up: V3::lit(view.true_up * step),
            lens: view.lens,
        }
    }

    /// That of pixels, with steps of half a pixel.
    pub fn of_pixels(pixels: &Pixels) -> Frame<F> {
        Frame::new(&pixels.view, pixels.step())
    }

    /// The two steps.
    #[inline(always)]
    pub fn steps<R: Real<One = F>>(&self) -> (V3<R>, V3<R>) {
        (V3::splat(self.right), V3::splat(self.true_up))
    }

    /// The ray so many steps from the picture's centre, to the right and to the top.
    #[inline(always)]
    pub fn ray<R: Real<One = F>>(&self, across: R, up: R) -> Ray<R> {
        let (forward, (right, true_up)) = (V3::splat(self.forward), self.steps());
        match self.lens {
            Lens::Perspective => Ray::new(
                V3([R::lit(0.0); 3]),
                camera_direction(forward, right, true_up, across, up),
            ),
            Lens::Orthographic => Ray::new(camera_origin(right, true_up, across, up), forward),
        }
    }
}

/// The direction of a perspective camera's ray, so many steps from the picture's centre, to the right and to the top.
#[inline(always)]
pub fn camera_direction<R: Real>(
    forward: V3<R>,
    right: V3<R>,
    true_up: V3<R>,
    across: R,
    up: R,
) -> V3<R> {
    (forward + right * across) + true_up * up
}

/// The origin of an orthographic camera's ray, from the camera's position.
#[inline(always)]
pub fn camera_origin<R: Real>(right: V3<R>, true_up: V3<R>, across: R, up: R) -> V3<R> {
    right * across + true_up * up
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The points of a pixel's ray are seen at its centre.
    #[test]
    fn points_are_seen_at_the_pixel_whose_ray_meets_them() {
        let mut camera = Camera::new(DVec3::new(4.0, 2.2, 7.5), DVec3::new(0.8, 0.6, 0.0));
        for height in [None, Some(3.0)] {
            if let Some(height) = height {
                camera.projection = Projection::Orthographic { height };
            }
            let pixels = Pixels::whole(View::new(&camera), 641, 360);
            for (x, y) in [(0, 0), (320, 180), (640, 359), (17, 203)] {
                let ray = pixels.ray(x, y);
                for t in [0.01, 1.0, 70.0] {
                    let at = pixels.seen_at(ray.origin + ray.direction * t).unwrap();
                    let expected = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    assert!((at - expected).length() < 1e-9, "{at}, {expected}");
                }
                assert_eq!(pixels.seen_at(ray.origin - ray.direction), None);
            }
        }
    }

    /// Nothing beyond an edge is a part of a picture, or a pixel of a part.
    #[test]
    fn parts_and_pixels_end_at_the_edges() {
        let camera = Camera::new(DVec3::Z, DVec3::ZERO);
        let whole = Pixels::whole(View::new(&camera), 6, 4);
        let part = whole.part([2, 1, 4, 3]).unwrap();
        assert_eq!((part.x, part.y, part.len()), (2, 1, 12));
        for crop in [[2, 1, 5, 3], [2, 1, 4, 4], [2, 1, 0, 3], [6, 0, 1, 1], [u32::MAX, 0, 2, 2]] {
            assert!(whole.part(crop).is_none(), "{crop:?}");
        }
        for at @ [x, y] in [[2, 1], [5, 3]] {
            let pixel = part.pixel(at).unwrap();
            assert_eq!([pixel.xy(0).0, pixel.xy(0).1].map(i64::from), [x, y]);
            assert_eq!(pixel.len(), 1);
        }
        for at in [[1, 1], [2, 0], [6, 3], [5, 4], [-1, 2], [2, i64::MIN], [1 << 32, 1]] {
            assert!(part.pixel(at).is_none(), "{at:?}");
        }
    }
}
