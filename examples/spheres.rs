//! A million spheres from an array, without a file.
//!
//! `cargo run --release -p kugelblitz --example spheres`

use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::Kernel;
use kugelblitz::scene::{Camera, Projection, Scene, Spheres};

/// `n` spheres on a spiral around a ball: x, y, z and radius, and a colour for each.
fn spiral(n: usize) -> (Vec<[f64; 4]>, Vec<[f32; 3]>) {
    let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..n)
        .map(|i| {
            let y = 1.0 - (2 * i + 1) as f64 / n as f64;
            let (sin, cos) = (golden_angle * i as f64).sin_cos();
            let rho = (1.0 - y * y).sqrt();
            let height = 0.5 + 0.5 * y as f32;
            ([rho * cos, y, rho * sin, 1.5 / (n as f64).sqrt()], [height, 0.2, 1.0 - height])
        })
        .unzip()
}

fn main() -> kugelblitz::Result<()> {
    let (rows, colors) = spiral(1_000_000);
    // The vectors are taken as they are: 32 bytes a sphere, and 12 for its colour.
    let spheres = Spheres::from_rows(rows)?.with_colors(colors)?;
    let camera = Camera {
        position: [0.0, 1.0, 4.0].into(),
        look_at: [0.0; 3].into(),
        up: [0.0, 1.0, 0.0].into(),
        projection: Projection::Perspective { fov_degrees: 35.0 },
    };
    let scene = Scene { camera: Some(camera), spheres, ..Scene::default() };
    println!("{} spheres in {} MB", scene.spheres.len(), scene.bytes() / 1_000_000);

    let path = std::env::temp_dir().join("a_million_spheres.png");
    let mut session = Session::new(scene, Device::best(), Kernel::Certified);
    session.render_to_file(&path, 800, 800)?;
    println!("{} on {}", path.display(), session.device().label());
    Ok(())
}
