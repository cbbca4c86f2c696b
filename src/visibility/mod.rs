//! What rays see: in lanes of f32, few objects in squares of pixels first and many through the tree, and what that
//! leaves open in f64.

mod batch;
mod cloud;
mod find64;
mod list;
mod search;

pub use batch::RayBatch;
pub use find64::{Find64, Scratch64};
pub use list::ListSearch;
pub use search::{LARGEST, Search, SearchScratch};
