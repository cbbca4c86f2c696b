//! Numbers and names as a reader wants them: in a few digits, with what can't be shown left out.

use kugelblitz::plain::plain_document;

use super::Spread;
pub use kugelblitz::words::{NONE, count, digits, joined, list, percent};

/// Three digits that count; see [`digits`].
pub fn figure(x: f64) -> String {
    digits(x, 3)
}

/// A range wider than this share of its median leaves no third digit: of some nine runs it is about seven
/// times as wide as what their median may be off by (3.0 against 0.42 standard deviations), and a third
/// digit is worth at most 1 %.
const WIDE: f64 = 0.07;

/// Digits that a median bears.
pub fn digits_borne(spread: &Spread) -> usize {
    match spread.relative_range() {
        Some(range) if range <= WIDE => 3,
        _ => 2,
    }
}

/// A number in `n` digits, and with zeros for what is left of the point beyond them.
pub fn rounded(x: f64, n: usize) -> String {
    digits(format!("{x:.*e}", n - 1).parse().unwrap_or(x), n)
}

/// A place of a sweep, with all of its digits where they are few.
pub fn quantity(x: f64) -> String {
    let shown = [x.to_string(), format!("{x:e}")];
    shown.into_iter().find(|text| text.len() <= 6).unwrap_or_else(|| figure(x))
}

/// A figure for print: `1.2e-6` as `1.2 × 10⁻⁶`, and whole numbers of five digits and more in
/// groups, with narrow spaces between them.
pub fn typeset(figure: &str) -> String {
    joined(figure.split(' ').map(typeset_word), " ")
}

fn typeset_word(word: &str) -> String {
    if let Some((factor, exponent)) = word.split_once('e')
        && factor.parse::<f64>().is_ok()
        && exponent.parse::<i32>().is_ok()
    {
        let power = format!("10{}", superscript(exponent));
        return if factor == "1" { power } else { format!("{factor} × {power}") };
    }
    if word.len() < 5 || !word.bytes().all(|byte| byte.is_ascii_digit()) {
        return word.to_string();
    }
    let groups = word.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    joined(groups, "\u{202f}")
}

fn superscript(exponent: &str) -> String {
    let raised = |digit: u32| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit as usize);
    exponent.chars().map(|c| c.to_digit(10).and_then(raised).unwrap_or('⁻')).collect()
}

/// A name that can't break a line, a terminal or an XML file: control characters, and those that
/// turn the direction of writing, are replaced.
pub fn plain(text: &str) -> String {
    plain_document(text).replace('\n', "\u{fffd}")
}

/// A name without what stands in parentheses behind it: `llvmpipe (LLVM 15.0.6, 256 bits)`.
pub fn short_name(name: &str) -> &str {
    name.split(" (").next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::spread;

    #[test]
    fn digits_that_count() {
        let shown = [
            (0.0, "0"),
            (0.5, "0.500"),
            (9.996, "10.0"),
            (123.4, "123"),
            (1234.5, "1234"),
            (98765.0, "98765"),
            (123456.0, "1.2e5"),
            (0.001, "0.00100"),
            (0.00012, "1.2e-4"),
            (f64::INFINITY, "∞"),
            (f64::NAN, NONE),
            (f64::MIN_POSITIVE, "2.2e-308"),
            (f64::MAX, "1.8e308"),
        ];
        for (x, text) in shown {
            assert_eq!(figure(x), text, "{x:?}");
        }
    }

    #[test]
    fn a_median_has_the_digits_that_its_range_bears() {
        let shown = |median: f64, min: f64, max: f64, n: usize| {
            spread(&Spread { median, p999: max, min, max, n }).whole()
        };
        assert_eq!(shown(12.34, 12.0, 12.8, 9), "12.3 (12.0–12.8)");
        assert_eq!(shown(12.34, 11.9, 14.03, 9), "12 (12–14)");
        assert_eq!(shown(1234.5, 1230.0, 1251.0, 9), "1230 (1230–1250)");
        assert_eq!(shown(1234.5, 900.4, 2111.0, 9), "1200 (900–2100)");
        assert_eq!(shown(0.7051, 0.5049, 0.9, 9), "0.71 (0.50–0.90)");
        // Of one run nobody knows the range.
        assert_eq!(shown(12.34, 12.34, 12.34, 1), "12");
        assert_eq!(shown(0.0, 0.0, 0.0, 3), "0 (0–0)");
        // The bound is where it says.
        assert_eq!(shown(100.4, 97.0, 104.0, 9), "100 (97.0–104)");
        assert_eq!(shown(10.04, 9.6, 10.4, 9), "10 (9.6–10)");
    }

    #[test]
    fn names_stay_on_their_line() {
        assert_eq!(plain("a\u{1b}[31m\nb\u{202e}"), "a\u{fffd}[31m\u{fffd}b\u{fffd}");
        assert_eq!(plain_document("a\nb\0"), "a\nb\u{fffd}");
        assert_eq!(short_name("llvmpipe (LLVM 15.0.6, 256 bits)"), "llvmpipe");
    }

    #[test]
    fn powers_of_ten_in_print() {
        assert_eq!(typeset("1.2e-16"), "1.2 × 10⁻¹⁶");
        assert_eq!(typeset("12.5"), "12.5");
        assert_eq!(typeset("stable"), "stable");
        assert_eq!(typeset("8.3e-4 %"), "8.3 × 10⁻⁴ %");
        assert_eq!(typeset("0 of 1310720"), "0 of 1\u{202f}310\u{202f}720");
        assert_eq!(typeset("1234 0.00558 12345"), "1234 0.00558 12\u{202f}345");
    }
}
