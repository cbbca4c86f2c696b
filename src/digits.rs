//! Numbers in as many digits as a reader wants.

/// Where there is no number.
pub const NONE: &str = "–";

/// A number with `n` digits that count, whole numbers of up to five digits with all of theirs,
/// and what is smaller than 0.001 or larger as in `1.2e-6`.
pub fn digits(x: f64, n: usize) -> String {
    match x {
        0.0 => return "0".to_string(),
        f64::INFINITY => return "∞".to_string(),
        f64::NEG_INFINITY => return "-∞".to_string(),
        _ if x.is_nan() => return NONE.to_string(),
        _ => {}
    }
    // Rounded first: 9.996 has the exponent of 10.0.
    let rounded = format!("{x:.*e}", n - 1);
    let exponent: i32 = rounded.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    match exponent {
        -3..=4 => format!("{x:.*}", (n as i32 - 1 - exponent).max(0) as usize),
        _ => format!("{x:.1e}"),
    }
}

/// A share in percent, [`NONE`] of nothing.
pub fn percent(part: u64, whole: u64) -> String {
    match whole {
        0 => NONE.to_string(),
        _ => format!("{} %", digits(100.0 * part as f64 / whole as f64, 2)),
    }
}
