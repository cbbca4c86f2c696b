//! What a Vulkan device and the CPU make of the same rays, judged by oracles; `ci/drivers.sh` runs it on other drivers.

mod campaign;
mod certified;
mod digests;
mod drivers;
mod hard_cases;
mod hard_scenes;
mod hierarchy;
mod light;
mod light_campaign;
mod matrix;
mod orthographic;
mod parity;
mod plain_light;
mod promise;
mod proposals;
mod scenes;
