//! The Vulkan backend. Only this folder knows `wgpu` and `naga`.

mod adapter;
mod clock;
mod compile;
mod layout;
mod pipeline;
mod self_test;
mod tracer;

pub use adapter::{AdapterFacts, Gpu, Pick, list_adapters};
pub use compile::{Shader, compile};
pub use layout::Params;
pub use self_test::Arithmetic;
pub use tracer::GpuTracer;
