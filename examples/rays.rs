//! Rays from arrays: what does each of them hit first, and where?
//!
//! `cargo run --release -p kugelblitz --example rays`

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, WorldRay};
use kugelblitz::scene::{Scene, Spheres};

fn main() -> kugelblitz::Result<()> {
    // x, y, z and radius.
    let rows = [[0.0, 0.0, 10.0, 1.0], [0.0, 2.0, 20.0, 1.0], [1e8, 0.0, 0.0, 1.0]];
    let scene = Scene { spheres: Spheres::from_rows(rows)?, ..Scene::default() };

    // The second one touches its sphere, the third one misses by less than f32 can tell.
    let directions = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1e8, 1.000_000_1, 0.0]];
    let origins = [[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]];
    let ray = |(origin, direction): ([f64; 3], [f64; 3])| WorldRay {
        origin: origin.into(),
        direction: direction.into(),
    };
    let rays = Rays::List(origins.into_iter().zip(directions).map(ray).collect());

    let mut session = Session::new(scene, Device::best(), Kernel::Certified);
    let mut hits = Hits::default();
    let wants = Outputs { surface: true, level: true };
    session.trace(&rays, wants, &Control::default(), &mut hits)?;
    for i in 0..hits.id.len() {
        println!(
            "ray {i}: object {}, t = {}, normal {:?}, decided by stage {}",
            hits.id[i], hits.t[i], hits.normal[i], hits.level[i]
        );
    }
    Ok(())
}
