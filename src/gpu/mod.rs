//! The Vulkan backend. Only this folder knows `wgpu` and `naga`.

mod adapter;
mod baseline_light;
mod compile;
mod device;
mod drivers;
mod hierarchy;
mod layout;
mod light;
mod objects;
mod open;
mod pass;
mod pipeline;
mod room;
mod self_test;
pub mod slabs;
mod texture;
mod tiles;
mod tracer;

pub use adapter::{AdapterFacts, find_adapter, has_software_alone, list_adapters};
pub(crate) use baseline_light::are_at_hand;
pub use compile::{Shader, compile};
pub use drivers::no_device;
pub use open::Gpu;
pub use self_test::Arithmetic;
pub use tracer::GpuTracer;
