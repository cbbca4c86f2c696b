//! f32 and f64 as a kernel's arithmetic: how rays come into it, and hits out of it.

use super::coordinates::Coordinates;
use super::{Hit, RayOf, double};
use crate::rays::{CameraF32, CameraF64, Pixels, Ray};
use crate::vec3::{Real, Vec3};

/// The arithmetic of a kernel, as a backend needs it. Its twin on the device is the part of
/// `shaders/render.wgsl` that makes rays and stores hits.
pub trait Arithmetic: Real {
    /// A camera in the kernel's coordinates.
    type Camera: Sync;
    /// The camera of `pixels`.
    fn camera(coordinates: &Coordinates, pixels: &Pixels) -> Self::Camera;
    /// Centre ray of the pixel at twice the offset `(i, j)` from the picture's centre.
    fn pixel_ray(camera: &Self::Camera, i: i64, j: i64) -> RayOf<Self>;
    /// A ray of a list, and what its `t` must be multiplied with.
    fn list_ray(coordinates: &Coordinates, ray: &Ray) -> (RayOf<Self>, f64);
    /// The number itself.
    fn to_f64(self) -> f64;
    /// The hit as its caller sees it.
    fn seen(hit: Hit<Self>, t_scale: f64) -> Hit<f32>;
    /// The normal as its caller sees it.
    fn normal(normal: Vec3<Self>) -> [f32; 3];
}

impl Arithmetic for f32 {
    type Camera = CameraF32;

    fn camera(coordinates: &Coordinates, pixels: &Pixels) -> CameraF32 {
        CameraF32 { origin: coordinates.camera_origin().into(), ..CameraF32::new(pixels) }
    }

    #[inline(always)]
    fn pixel_ray(camera: &CameraF32, i: i64, j: i64) -> RayOf<f32> {
        camera.camera_ray(i as f32, j as f32)
    }

    #[inline(always)]
    fn list_ray(coordinates: &Coordinates, ray: &Ray) -> (RayOf<f32>, f64) {
        let (record, exponent) = coordinates.ray_record(ray);
        let ray = RayOf::new(Vec3(record.origin), Vec3(record.origin_low), Vec3(record.direction));
        (ray, 2f64.powi(-exponent))
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.into()
    }

    #[inline(always)]
    fn seen(hit: Hit<f32>, t_scale: f64) -> Hit<f32> {
        Hit { t: (f64::from(hit.t) * t_scale) as f32, id: hit.id }
    }

    #[inline(always)]
    fn normal(normal: Vec3<f32>) -> [f32; 3] {
        normal.0
    }
}

impl Arithmetic for f64 {
    type Camera = CameraF64;

    fn camera(_: &Coordinates, pixels: &Pixels) -> CameraF64 {
        CameraF64::new(pixels)
    }

    #[inline(always)]
    fn pixel_ray(camera: &CameraF64, i: i64, j: i64) -> RayOf<f64> {
        camera.camera_ray(i as f64, j as f64)
    }

    #[inline(always)]
    fn list_ray(coordinates: &Coordinates, ray: &Ray) -> (RayOf<f64>, f64) {
        let record = coordinates.ray_record_double(ray);
        (RayOf::new(Vec3(record.origin), Vec3::ZERO, Vec3(record.direction)), 1.0)
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn seen(hit: Hit<f64>, _: f64) -> Hit<f32> {
        double::narrow(hit)
    }

    #[inline(always)]
    fn normal(normal: Vec3<f64>) -> [f32; 3] {
        normal.0.map(|component| component as f32)
    }
}
