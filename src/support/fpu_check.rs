//! What the proofs ask of the host's arithmetic, and a check of it.
//!
//! f32 and f64 are IEEE 754's binary32 and binary64 with these attributes:
//! - `+ − × ÷ √` and conversions round to the nearest, ties to even. The bounds of [`crate::bounds`]
//!   would survive another direction in f64; [`crate::num::round_down`], the exact stage's first
//!   guesses and the CPU's equality with the device would not.
//! - Subnormal operands and results are kept: neither flush to zero nor "denormals are zero".
//! - Every operation rounds to its own format: no x87 registers, which round twice.
//! - ∞ and NaN are what IEEE 754 says, as on every target of Rust.
//!
//! Rust takes the first three for granted. A program in another language that calls this library may
//! have changed them (`MXCSR` on x86-64, `FPCR` on AArch64; `-ffast-math` of C compilers sets flush to
//! zero when a program starts). They belong to a thread, and on Linux a new thread inherits them. So
//! the certified kernel asks on the threads that calculate: once for the calling thread and all of
//! rayon's when a scene is prepared, and on each worker again with every part of its rays. The plain
//! kernels promise nothing, and ask for nothing.

use std::hint::black_box;

use crate::error::{Error, Result};

/// A fault of this thread's arithmetic.
fn defect() -> Option<&'static str> {
    // `1 + x` for a tie above an even and above an odd number, and for `x` just beside it.
    let (one, tie) = (black_box(1.0f64), black_box(f64::EPSILON / 2.0));
    let odd = one + 2.0 * tie;
    let nearest = one + tie == 1.0
        && odd + tie == 1.0 + 2.0 * f64::EPSILON
        && -one - tie == -1.0
        && one + tie.next_up() == odd
        && black_box(1.0f32) + black_box(f32::EPSILON / 2.0) == 1.0
        && black_box(-1.0f32) - black_box(f32::EPSILON * 0.75) == -1.0 - f32::EPSILON
        && black_box(1.0 + f64::EPSILON) as f32 == 1.0;
    if !nearest {
        return Some("it does not round to the nearest number");
    }
    let (least, least_f32) = (black_box(f64::MIN_POSITIVE), black_box(f32::MIN_POSITIVE));
    if (least / 2.0).to_bits() == 0 || (least_f32 / 2.0).to_bits() == 0 {
        return Some("it flushes subnormal results to zero (FTZ)");
    }
    let (bit, bit_f32) = (black_box(f64::from_bits(1)), black_box(f32::from_bits(1)));
    if bit * 2f64.powi(1000) == 0.0 || bit_f32 * 2f32.powi(100) == 0.0 {
        return Some("it takes subnormal operands for zero (DAZ)");
    }
    // Beyond f64 and back, which x87's registers can do.
    let largest = black_box(f64::MAX);
    if largest * 2.0 / 2.0 == largest {
        return Some("it keeps more than an f64 between two operations (x87)");
    }
    None
}

/// Makes sure that this thread calculates as the proofs ask for.
///
/// # Errors
/// [`Error::Host`] says what differs.
pub fn check() -> Result<()> {
    match defect() {
        None => Ok(()),
        Some(what) => Err(Error::Host(format!(
            "this thread's floating-point arithmetic does not suit the certified kernel: {what}. Call \
             with the default floating-point environment (on x86-64 MXCSR = 0x1F80; programs compiled \
             with -ffast-math change it), or use another kernel"
        ))),
    }
}

/// [`check`] for this thread and all of rayon's. One of rayon's checks itself alone: while it waited
/// for the others, it would take up other work of its pool, which could ask the same, ever deeper.
///
/// # Errors
/// [`Error::Host`] says what differs.
pub fn check_all() -> Result<()> {
    check()?;
    match rayon::current_thread_index() {
        Some(_) => Ok(()),
        None => rayon::broadcast(|_| check()).into_iter().collect(),
    }
}
