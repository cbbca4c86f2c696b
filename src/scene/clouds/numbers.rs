//! Numbers as programs write them into text.

use super::RowError;
use crate::plain::Shown;
use crate::scene::places::quoted;

/// The decimal mark of a file, once a number has shown it.
#[derive(Clone, Debug, Default, PartialEq)]
enum Mark {
    /// No number had a mark.
    #[default]
    Unknown,
    /// `0.5`, first in this line.
    Point(u64, String),
    /// `0,5`, first in this line.
    Comma(u64, String),
}

/// Reads the numbers of a file, which have one decimal mark.
pub(super) struct Numbers {
    mark: Mark,
    /// Whether a decimal point is still of interest: none was seen, and commas may be decimal marks.
    looks_for_points: bool,
    /// Whether commas between digits separate thousands.
    has_thousands: bool,
}

impl Numbers {
    /// Creates a reader for a file whose cells these bytes separate. If commas do, only quoted cells can have one, so points are
    /// of interest only after a decimal comma.
    pub fn new(separator: u8) -> Numbers {
        Numbers { mark: Mark::Unknown, looks_for_points: separator != b',', has_thousands: false }
    }

    /// Reads a number: as Rust does; with Fortran's exponents (`0.2D+01`, `1.0+100`); `True`, `T`, `False` and `F` as 1 and 0; and
    /// if commas cannot separate cells, with a decimal comma or separators of thousands. `None` for any other text.
    ///
    /// A separator of thousands is accepted only if it cannot be a decimal mark: `1,234,567` and `1,234.5`, but not `1,234`.
    ///
    /// # Errors
    /// Two decimal marks in one file.
    #[inline]
    pub fn read(
        &mut self,
        cell: &[u8],
        may_have_comma: impl FnOnce() -> bool,
        line: u64,
    ) -> Result<Option<f64>, RowError> {
        let Ok(text) = std::str::from_utf8(cell) else { return Ok(None) };
        if let Ok(number) = text.parse() {
            if self.looks_for_points && text.contains('.') {
                self.see(Mark::Point(line, text.to_owned()))?;
            }
            return Ok(Some(number));
        }
        self.read_unusual(text.trim(), may_have_comma(), line)
    }

    #[cold]
    fn read_unusual(
        &mut self,
        text: &str,
        may_have_comma: bool,
        line: u64,
    ) -> Result<Option<f64>, RowError> {
        if let Some(number) = fortran(text).or_else(|| truth(text)) {
            return Ok(Some(number));
        }
        if !may_have_comma || !text.contains([',', '.']) {
            return Ok(None);
        }
        let count = |mark: char| text.matches(mark).count();
        let [commas, points] = [count(','), count('.')];
        let comma_is_last = text.rfind(',') > text.rfind('.');
        let is_point = match (commas, points) {
            (2.., _) => true,
            (1, 1) => !comma_is_last,
            (1, 0) => self.has_thousands && is_grouped(text, ','),
            _ => false,
        };
        let (thousands, decimal) = if is_point { (',', '.') } else { ('.', ',') };
        let whole = text.split(decimal).next().unwrap_or_default();
        if whole.contains(thousands) && !is_grouped(whole, thousands) {
            return Ok(None);
        }
        let plain = text.replace(thousands, "").replacen(decimal, ".", 1);
        let Ok(number) = plain.parse() else { return Ok(None) };
        self.has_thousands |= is_point;
        let mark = if is_point { Mark::Point } else { Mark::Comma };
        self.see(mark(line, text.to_owned()))?;
        Ok(Some(number))
    }

    fn see(&mut self, mark: Mark) -> Result<(), RowError> {
        match (&self.mark, &mark) {
            (Mark::Unknown, _) => {
                self.looks_for_points = matches!(mark, Mark::Comma(..));
                self.mark = mark;
            }
            (Mark::Point(first, one), Mark::Comma(_, other))
            | (Mark::Comma(first, one), Mark::Point(_, other)) => {
                let (one, other) = (quoted(one), quoted(other));
                let message = format!(
                    "two decimal marks in one file: {one:?} in line {first}, {other:?} here"
                );
                let fault = RowError::new(message, "write all numbers with the same decimal mark");
                return Err(fault.with_value(other));
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns a note of the first number with a decimal comma.
    pub fn note(&self) -> Option<String> {
        let Mark::Comma(line, text) = &self.mark else { return None };
        let number = Numbers::new(b';').read(text.as_bytes(), || true, *line).ok()??;
        let text = quoted(text).shown();
        Some(format!(
            "commas in numbers are read as decimal marks: \"{text}\" in line {line} is {number:?}"
        ))
    }
}

/// Whether a word is a number, with any decimal mark.
pub(super) fn is_number(word: &str) -> bool {
    let mut numbers = Numbers::new(b';');
    truth(word).is_none()
        && numbers.read(word.as_bytes(), || true, 0).is_ok_and(|number| number.is_some())
}

/// Counts the numbers in a line.
pub(in crate::scene) fn n_numbers(line: &str) -> usize {
    let words = line.split([',', ';', '\t', ' ', '"']).filter(|word| !word.is_empty());
    words.filter(|word| is_number(word)).count()
}

/// Whether the mark separates groups of three digits; the first group may be shorter.
fn is_grouped(text: &str, mark: char) -> bool {
    let text = text.trim_start_matches(['-', '+']);
    let is_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let mut groups = text.split(mark);
    let first = groups.next().unwrap_or_default();
    (1..=3).contains(&first.len())
        && is_digits(first)
        && groups.all(|group| group.len() == 3 && is_digits(group))
}

/// Reads a real number of Fortran, whose exponent begins with D or Q, or is only a sign if it has three digits.
fn fortran(text: &str) -> Option<f64> {
    let is_mantissa = |text: &str| text.ends_with(|c: char| c.is_ascii_digit() || c == '.');
    if let Some((mantissa, exponent)) = text.split_once(['d', 'D', 'q', 'Q']) {
        return is_mantissa(mantissa)
            .then(|| format!("{mantissa}e{exponent}").parse().ok())
            .flatten();
    }
    let at = text.rfind(['+', '-']).filter(|at| *at > 0 && text.is_ascii())?;
    let (mantissa, exponent) = text.split_at(at);
    (is_mantissa(mantissa) && exponent.len() == 4)
        .then(|| format!("{mantissa}e{exponent}").parse().ok())
        .flatten()
}

/// Reads a truth value of Python, R, Julia or Fortran.
fn truth(text: &str) -> Option<f64> {
    match text.trim_matches('.').to_ascii_lowercase().as_str() {
        "true" | "t" => Some(1.0),
        "false" | "f" => Some(0.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(cells: &[&str]) -> (Vec<Option<f64>>, Option<String>) {
        let mut numbers = Numbers::new(b';');
        let read = |(line, cell): (u64, &&str)| {
            numbers.read(cell.as_bytes(), || true, line).ok().flatten()
        };
        let values = (1..).zip(cells).map(read).collect();
        (values, numbers.note())
    }

    #[test]
    fn numbers_of_programs_are_read() {
        for (cell, number) in [
            ("1", 1.0),
            ("-2.5e-3", -2.5e-3),
            ("0.2D+01", 2.0),
            ("1d0", 1.0),
            ("-.5Q-1", -0.05),
            ("1.0+100", 1e100),
            ("1.5-300", 1.5e-300),
            ("True", 1.0),
            ("F", 0.0),
            (".TRUE.", 1.0),
            ("2,5", 2.5),
            ("-2,5e3", -2500.0),
            ("1,234", 1.234),
            ("1,234,567", 1_234_567.0),
            ("-1,234,567.8", -1_234_567.8),
            ("1,234.5", 1234.5),
            ("1.234,5", 1234.5),
            ("1.234.567,8", 1_234_567.8),
            ("1.234.567", 1_234_567.0),
        ] {
            assert_eq!(read(&[cell]).0, [Some(number)], "{cell}");
        }
        for wrong in [
            "",
            "sand",
            "1,2,3",
            "1.2.3",
            "12,34,567",
            "1,2345.6",
            "1 2",
            "D0",
            "e5",
            "+",
            "1-2",
            "truth",
            "1,",
            ".",
        ] {
            let value = read(&[wrong]).0[0];
            assert!(value.is_none() || wrong == "1," && value == Some(1.0), "{wrong}: {value:?}");
        }
    }

    #[test]
    fn one_file_has_one_decimal_mark() {
        assert_eq!(read(&["1,234", "2", "0,5"]).0, [Some(1.234), Some(2.0), Some(0.5)]);
        assert_eq!(read(&["1,234", "0.5"]).0, [Some(1.234), None]);
        assert_eq!(read(&["0.5", "1,5"]).0, [Some(0.5), None]);
        // After a comma that separates thousands, the next one does so as well.
        assert_eq!(read(&["1,234,567", "1,234"]).0, [Some(1_234_567.0), Some(1234.0)]);
        assert_eq!(read(&["1,234.5", "1,5"]).0, [Some(1234.5), None]);
        let note = read(&["7", "1,234", "5,5"]).1.unwrap();
        assert!(note.ends_with("\"1,234\" in line 2 is 1.234"), "{note}");
        assert_eq!(read(&["1,234.5"]).1, None);
        let mut numbers = Numbers::new(b';');
        numbers.read(b"1,5", || true, 2).unwrap();
        let fault = numbers.read(b"0.5", || true, 7).unwrap_err();
        assert!(fault.message.contains("\"1,5\" in line 2, \"0.5\" here"), "{}", fault.message);
    }
}
