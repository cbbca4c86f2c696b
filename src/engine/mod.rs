//! What rays see, few objects at a time: tiles of rays in lanes of f32, large squares of pixels first, and what that
//! leaves open in lanes of f64.

mod search;
mod tile;

pub use search::{Find64, LARGEST, Room, Search};
pub use tile::{Camera, Tile, eye_of};
