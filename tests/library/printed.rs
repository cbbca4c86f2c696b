//! The formulas in `shaders/printed` are those of the Rust text.

use kugelblitz::num::Real;
use kugelblitz_tests::assert_kept;
use kugelblitz_tests::printer::{Wgsl, formulas};

/// The next build takes what is written anew into the program.
#[test]
fn formulas_are_printed_as_they_are() {
    for (file, printed) in formulas::all() {
        assert_kept(&format!("shaders/printed/{file}"), &printed);
    }
}

/// WGSL may assume that there is none.
#[test]
#[should_panic(expected = "finite")]
fn an_infinity_is_not_printed() {
    Wgsl::lit(f64::INFINITY);
}
