//! Kugelblitz: a ray tracer for spheres and planes that proves which object every ray sees.

pub mod camera;
pub mod error;
pub mod exact;
mod npy;
pub mod picture;
pub mod rays;
pub mod scene;
pub mod trace;

pub use error::{Error, Result};
