//! The Vulkan backend. Only this folder knows `wgpu` and `naga`.

mod adapter;
mod clock;
mod compile;
mod device;
mod hierarchy;
mod layout;
mod light;
#[cfg(feature = "view")]
mod live;
mod objects;
mod open;
mod pass;
mod pipeline;
mod plain_light;
#[cfg(feature = "view")]
mod present;
mod program;
mod self_test;
pub mod slabs;
mod texture;
mod tiles;
mod tracer;
#[cfg(feature = "view")]
mod window;

pub use adapter::{AdapterFacts, Pick, has_software_alone, list_adapters};
pub use compile::{Shader, compile};
pub use layout::Params;
#[cfg(feature = "view")]
pub use live::Words;
#[cfg(feature = "view")]
pub(crate) use live::{Pool, Undecided};
pub use open::Gpu;
#[cfg(feature = "view")]
pub(crate) use present::{Layer, Present, Presenter};
pub use self_test::Arithmetic;
pub use tracer::GpuTracer;
#[cfg(feature = "view")]
pub(crate) use window::{OpenWindow, open_window};
