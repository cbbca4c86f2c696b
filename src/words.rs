//! Numbers, counts and sizes as words, and names that are nearly right.

use std::borrow::{Borrow, Cow};
use std::time::Duration;

/// Bytes of the longest name that may be a misspelling.
const MOST_COMPARED: usize = 40;

/// The known name that `given` is a misspelling of, in upper or lower case: its beginning of three letters
/// or more, or at most one slip (a letter that is wrong, missing or too many, or two that are swapped) in
/// three letters.
pub fn did_you_mean<'n>(known: impl IntoIterator<Item = &'n str>, given: &str) -> Option<&'n str> {
    if given.len() > MOST_COMPARED {
        return None;
    }
    let given = given.to_lowercase();
    let n_chars = given.chars().count();
    let slips = |name: &str| {
        if n_chars > 2 && name.starts_with(&given) { 1 } else { strsim::osa_distance(&given, name) }
    };
    let known = known.into_iter().filter(|name| name.len() <= MOST_COMPARED);
    let near = known.map(|name| (slips(&name.to_lowercase()), name));
    let near = near.filter(|(slips, name)| *slips <= n_chars.max(name.chars().count()) / 3);
    near.min_by_key(|(slips, _)| *slips).map(|(_, name)| name)
}

/// [`did_you_mean`] as the end of a sentence; nothing where no name is near.
pub fn did_you_mean_at_end<'n>(known: impl IntoIterator<Item = &'n str>, given: &str) -> String {
    did_you_mean(known, given).map_or(String::new(), |near| format!("; did you mean {near}?"))
}

/// The first `n_chars` of a text, with `…` in the place of the others.
pub fn cut(text: &str, n_chars: usize) -> Cow<'_, str> {
    match text.char_indices().nth(n_chars) {
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
        None => Cow::Borrowed(text),
    }
}

/// `1 plane`, `2 planes`
pub fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// All texts, with another one between each two of them.
pub fn joined(texts: impl IntoIterator<Item: Borrow<str>>, between: &str) -> String {
    texts.into_iter().collect::<Vec<_>>().join(between)
}

/// `a`, `a and b`, `a, b and c`
pub fn list(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// `24 ms`, `1.3 s`, `2 min 5 s`: as exact as a person wants it.
pub fn duration(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    if seconds < 0.01 {
        format!("{:.1} ms", seconds * 1e3)
    } else if seconds < 1.0 {
        format!("{:.0} ms", seconds * 1e3)
    } else if seconds < 120.0 {
        format!("{seconds:.1} s")
    } else {
        let seconds = time.as_secs();
        format!("{} min {} s", seconds / 60, seconds % 60)
    }
}

/// `12 bytes`, `4.0 KiB`, `1.5 MiB`
pub fn bytes(n: u64) -> String {
    let (exponent, unit) = match n {
        0..1024 => return format!("{n} bytes"),
        1024..0x10_0000 => (10, "KiB"),
        0x10_0000..0x4000_0000 => (20, "MiB"),
        _ => (30, "GiB"),
    };
    format!("{:.1} {unit}", n as f64 / f64::from(1 << exponent))
}

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
    let rounded = format!("{x:.*e}", n.saturating_sub(1));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_are_known() {
        let known = ["color", "colormap", "position", "radius", "png"];
        for (given, meant) in [
            ("colour", Some("color")),
            ("Raduis", Some("radius")),
            ("pos", Some("position")),
            ("pgn", Some("png")),
            ("po", None),
            ("height", None),
            ("", None),
        ] {
            assert_eq!(did_you_mean(known, given), meant, "{given}");
        }
        assert_eq!(did_you_mean(["x"], &"x".repeat(1000)), None);
    }
}
