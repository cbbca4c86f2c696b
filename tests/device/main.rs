//! What a Vulkan device and the CPU make of the same rays, judged by an oracle; `ci/drivers.sh` runs it on other drivers.

mod digests;
mod drivers;
mod hard_cases;
mod light;
mod matrix;
mod outliers;
mod scenes;
mod tracers;
mod trees;
