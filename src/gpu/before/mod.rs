//! What shaders in f64 and for light have of formulas that the CPU has in [`crate::seen`]: their records, bounds, and twins of
//! their functions.

mod alone;
mod beam;
mod filter;
mod in_f32;
mod in_space;
pub mod narrow;
mod numbers;
pub mod point;
mod proposals;
mod records;
mod seen_from;
mod shaders;
pub mod slabs;

pub use alone::propose_alone;
pub(super) use beam::{FOR_DEVICE as BEAM_CONSTANTS, FOR_DEVICE_IN_F32 as BEAM_CONSTANTS_IN_F32};
pub(super) use filter::{InF64, ray_record, suits_device};
pub use in_space::propose_in_space;
pub(super) use narrow::{IN_F64 as NARROW_CONSTANTS, constants_in_f32 as narrow_constants_in_f32};
pub(super) use numbers::light_in_f64;
pub use proposals::propose_in_f64;
pub use records::*;
pub(super) use shaders::{factors_of_points, light_key_in_f32};
