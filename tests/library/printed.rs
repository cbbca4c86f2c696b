//! The formulas in `shaders/printed` are those of the Rust text.

use std::fs;

use kugelblitz::num::Real;
use kugelblitz_tests::printer::{Wgsl, formulas};
use kugelblitz_tests::root;

/// With `KUGELBLITZ_PRINT=1` they are written anew; the next build takes them into the program.
#[test]
fn formulas_are_printed_as_they_are() {
    for (file, printed) in formulas::all() {
        let path = root().join("shaders/printed").join(file);
        if std::env::var_os("KUGELBLITZ_PRINT").is_some() {
            fs::write(&path, &printed).unwrap();
        }
        let kept = fs::read_to_string(&path).unwrap();
        let of_both = kept.lines().zip(printed.lines()).zip(1..);
        let first = of_both.filter(|((kept, printed), _)| kept != printed).map(|(_, line)| line);
        assert!(
            kept == printed,
            "shaders/printed/{file}, line {:?}: print it anew with KUGELBLITZ_PRINT=1 cargo test --profile ci \
             -p kugelblitz-tests --test library printed::",
            first.min()
        );
    }
}

/// WGSL may assume that there is none.
#[test]
#[should_panic(expected = "finite")]
fn an_infinity_is_not_printed() {
    Wgsl::lit(f64::INFINITY);
}
