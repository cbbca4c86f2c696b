//! A kernel of one's own, held against exact arithmetic pixel by pixel.
//!
//! `cargo run --release -p kugelblitz-judge --example own_kernel`

use glam::Vec3;
use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::{Hits, Kernel};
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz_judge::verify::{Truth, compare_to_exact};

/// The formula that most tutorials have: b² − 4ac, in f32 and in world coordinates.
fn closest(origin: Vec3, direction: Vec3, scene: &Scene) -> (u32, f32) {
    let mut hit = (0, f32::INFINITY);
    for (sphere, id) in scene.spheres.iter().zip(1..) {
        let oc = origin - sphere.center.as_vec3();
        let (a, b) = (direction.dot(direction), 2.0 * oc.dot(direction));
        let c = oc.dot(oc) - (sphere.radius * sphere.radius) as f32;
        let discriminant = b * b - 4.0 * a * c;
        let t = (-b - discriminant.sqrt()) / (2.0 * a);
        if discriminant >= 0.0 && t > 0.0 && t < hit.1 {
            hit = (id, t);
        }
    }
    hit
}

fn my_picture(pixels: &Pixels, scene: &Scene) -> Hits {
    let (id, t) = (0..pixels.len())
        .map(|index| {
            let (x, y) = pixels.xy(index);
            let ray = pixels.ray(x, y);
            closest(ray.origin.as_vec3(), ray.direction.as_vec3(), scene)
        })
        .unzip();
    Hits { id, t, ..Hits::default() }
}

fn main() -> kugelblitz::Result<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/hard/distant_1e4.toml");
    let scene = read_scene(path.as_ref())?;
    let session = Session::new(scene, Device::Cpu, Kernel::Certified);
    let (scene, pixels) = (session.scene(), session.pixels(320, 180)?);

    let all = (0..pixels.len()).collect();
    let truth = Truth::of_rays(scene, &Rays::Pixels(pixels), all, &Control::default())?;
    let found = compare_to_exact(&my_picture(&pixels, scene), &truth);
    println!("{found:#?}");
    Ok(())
}
