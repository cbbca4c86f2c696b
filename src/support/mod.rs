//! Services of the machine for the engine: threads, memory budget, cancellation and progress, the check of the FPU, seeded random
//! numbers, and differences between operating systems.

pub mod control;
pub mod fpu_check;
pub mod memory;
pub mod parallel;
pub mod random;
pub(crate) mod system;
