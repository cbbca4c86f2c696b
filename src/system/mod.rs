//! What kinds of systems do differently, under the same names for all of them.

#[cfg_attr(windows, path = "windows.rs")]
mod unix;

pub use unix::*;
