//! The thresholds between sRGB bytes against the real numbers of the standard.

use std::fs;

use kugelblitz::scene::QuantizationTable;
use kugelblitz_tests::rational::{Q, q};
use kugelblitz_tests::root;
use num_traits::Pow;

fn decimal(numerator: i64, denominator: i64) -> Q {
    Q::new(numerator.into(), denominator.into())
}

/// Whether an f64 is the nearest one to the linear value of `(byte − ½)/255`.
///
/// The power of 2.4 is irrational, but its fifth power is a rational: `y < x^(12/5)` if `y⁵ < x¹²`.
fn is_nearest(threshold: f64, byte: i64) -> bool {
    let encoded = decimal(2 * byte - 1, 510);
    let (value, power) = if encoded <= decimal(4045, 100_000) {
        (encoded / decimal(1292, 100), 1)
    } else {
        (Pow::pow((encoded + decimal(55, 1000)) / decimal(1055, 1000), 12), 5)
    };
    let middle = |next: f64| Pow::pow((q(threshold) + q(next)) / decimal(2, 1), power);
    middle(threshold.next_down()) <= value && value <= middle(threshold.next_up())
}

/// The guide has the number of thresholds that differ from the standard's in the last bits.
#[test]
fn the_guide_counts_the_thresholds_that_are_not_the_nearest() {
    let edges = QuantizationTable::srgb8();
    let differs = |byte: &u16| !is_nearest(edges.range(*byte).0, (*byte).into());
    let n_differ = (1..=255).filter(differs).count();
    let guide = fs::read_to_string(root().join("docs/guide/src/promised.md")).unwrap();
    let claim = format!("{n_differ} of the 255 thresholds");
    assert!(guide.contains(&claim), "{claim}");
}
