//! Kugelblitz: a ray tracer for spheres and planes that proves which object every ray sees.

pub mod camera;
mod certify;
pub mod compare;
pub mod cpu;
pub mod error;
pub mod exact;
pub mod explain;
pub mod gpu;
pub mod guard;
pub mod kernel;
mod npy;
pub mod picture;
pub mod prepare;
pub mod rays;
pub mod render;
pub mod scene;
pub mod trace;
pub mod vec3;
pub mod verify;

pub use error::{Error, Result};
