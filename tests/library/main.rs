//! The library as others use it, and its bounds; what opens a Vulkan device is in the binary `device`.

mod clouds;
mod damaged;
mod exact;
#[cfg(target_arch = "x86_64")]
mod host;
mod house;
mod lemmas;
mod light_oracle;
mod picture;
mod printed;
mod programs;
mod report;
mod report_page;
mod spirv;
mod subnormal;
mod thresholds;
