//! A scene in memory → a picture on disk.
//!
//! `cargo run --release -p kugelblitz --example picture`

use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::Kernel;
use kugelblitz::scene::{Camera, Color, Plane, Projection, Scene, Spheres};

fn main() -> kugelblitz::Result<()> {
    // x, y, z and radius.
    let spheres = Spheres::from_rows([[-1.0, 1.0, 0.0, 1.0], [1.0, 1.0, 0.0, 1.0]])?;
    let colors = [[0xd6, 0x27, 0x28], [0x1f, 0x77, 0xb4]].map(Color::from_srgb8);
    let scene = Scene {
        background: Color::from_srgb8([0x20, 0x24, 0x2c]),
        camera: Some(Camera {
            position: [0.0, 2.0, 8.0].into(),
            look_at: [0.0, 1.0, 0.0].into(),
            up: [0.0, 1.0, 0.0].into(),
            projection: Projection::Perspective { fov_degrees: 40.0 },
        }),
        spheres: spheres.with_colors(colors)?,
        planes: vec![Plane {
            name: None,
            point: [0.0; 3].into(),
            normal: [0.0, 1.0, 0.0].into(),
            color: Color::from_srgb8([0x8c; 3]),
        }],
        ..Scene::default()
    };
    let path = std::env::temp_dir().join("two_balls.png");
    let mut session = Session::new(scene, Device::best(), Kernel::Certified);
    let drawn = session.render_to_file(&path, 1280, 720)?;
    println!(
        "{}: {} of {} pixels needed more than f32, on {}",
        path.display(),
        drawn.counts.f64 + drawn.counts.exact,
        drawn.counts.total(),
        session.device().label()
    );
    Ok(())
}
