//! The Vulkan backend. Only this folder knows `wgpu` and `naga`.

mod adapter;
mod clock;
mod compile;
mod hierarchy;
mod layout;
#[cfg(feature = "view")]
mod live;
mod pipeline;
#[cfg(feature = "view")]
mod present;
mod program;
mod self_test;
mod tracer;
#[cfg(feature = "view")]
mod window;

pub use adapter::{AdapterFacts, Gpu, Pick, list_adapters};
pub use compile::{Shader, compile};
pub use layout::Params;
#[cfg(feature = "view")]
pub(crate) use live::{Pool, Undecided, Words};
#[cfg(feature = "view")]
pub(crate) use present::{Layer, Present, Presenter};
pub use self_test::Arithmetic;
pub use tracer::GpuTracer;
#[cfg(feature = "view")]
pub(crate) use window::{OpenWindow, open_window};
