//! Axes: where a number is drawn, and which numbers are written beside it.

/// A range of numbers along a range of pixels.
#[derive(Clone)]
pub struct Scale {
    is_log: bool,
    /// Of the numbers, or of their decimal logarithms.
    low: f64,
    high: f64,
    from_px: f64,
    to_px: f64,
}

/// Left free beyond the outermost numbers, in decades.
const MARGIN: f64 = 0.06;

/// What is drawn where nothing is left to draw.
const DECADE: (f64, f64) = (0.0, 1.0);

impl Scale {
    /// A logarithmic axis for all `values` that are positive and finite.
    pub fn log(values: impl IntoIterator<Item = f64>, px: (f64, f64)) -> Scale {
        let logs = values.into_iter().filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
        let (low, high) = range(logs).unwrap_or(DECADE);
        let (low, high) = (step_down(low - MARGIN), step_up(high + MARGIN));
        Scale { is_log: true, low, high, from_px: px.0, to_px: px.1 }
    }

    /// The axis of a quantity: logarithmic where it spans more than a decade.
    pub fn of_quantity(values: &[f64], px: (f64, f64)) -> Scale {
        let finite = values.iter().copied().filter(|x| x.is_finite());
        let (low, high) = range(finite).unwrap_or(DECADE);
        if low > 0.0 && (high / low > 10.0 || high == low) {
            return Scale::log(values.iter().copied(), px);
        }
        let margin = if high > low { 0.03 * (high - low) } else { low.abs().max(1.0) };
        let (low, high) = (low - margin, high + margin);
        Scale { is_log: false, low, high, from_px: px.0, to_px: px.1 }
    }

    /// Where `x` is.
    pub fn px(&self, x: f64) -> f64 {
        let x = if self.is_log { x.log10() } else { x };
        let share = ((x - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        self.from_px + share * (self.to_px - self.from_px)
    }

    /// Both ends of the axis, px.
    pub fn ends(&self) -> (f64, f64) {
        (self.from_px, self.to_px)
    }

    /// The numbers to be written.
    pub fn ticks(&self) -> Vec<f64> {
        if self.is_log { self.log_ticks() } else { self.linear_ticks() }
    }

    fn log_ticks(&self) -> Vec<f64> {
        let decades = self.high - self.low;
        let factors: &[f64] = if decades <= 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = (decades / 8.0).ceil().max(1.0) as i32;
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let exponents = (first..=last).filter(|exponent| exponent.rem_euclid(every) == 0);
        exponents
            .flat_map(|exponent| factors.iter().map(move |factor| factor * 10f64.powi(exponent)))
            .filter(|tick| (self.low - 1e-9..=self.high + 1e-9).contains(&tick.log10()))
            .collect()
    }

    fn linear_ticks(&self) -> Vec<f64> {
        let rough = (self.high - self.low) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= rough);
        let step = factor.unwrap_or(10.0) * power;
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        (first..=last).map(|i| i as f64 * step).filter(|tick| tick.is_finite()).collect()
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, x| {
        let (low, high) = range.unwrap_or((x, x));
        Some((low.min(x), high.max(x)))
    })
}

/// The logarithm of the next 1, 2 or 5 times a power of ten that is not above `log`.
fn step_down(log: f64) -> f64 {
    let decade = log.floor();
    let steps = [5f64.log10(), 2f64.log10(), 0.0];
    decade + steps.into_iter().find(|step| decade + step <= log).unwrap_or(0.0)
}

/// The same, not below `log`. The inverses of 1, 2 and 5 are such numbers, too.
fn step_up(log: f64) -> f64 {
    -step_down(-log)
}

/// A number as it stands beside an axis: `0.01`, `500`, `10⁻⁶`, `2·10⁶`.
pub fn tick_label(x: f64) -> String {
    if x == 0.0 {
        return "0".to_string();
    }
    let text = format!("{x:.0e}");
    let (factor, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    match exponent.parse::<i32>() {
        Ok(places @ -3..=-1) => format!("{x:.*}", places.unsigned_abs() as usize),
        Ok(0..=3) if x.fract() == 0.0 => format!("{x:.0}"),
        Ok(0..=3) => format!("{x:.1}"),
        _ if factor == "1" => format!("10{}", superscript(exponent)),
        _ => format!("{factor}·10{}", superscript(exponent)),
    }
}

/// A share as it stands beside an axis, in percent.
pub fn percent_label(share: f64) -> String {
    format!("{} %", tick_label(100.0 * share))
}

/// A figure for print: `1.2e-6` as `1.2 × 10⁻⁶`, and whole numbers of five digits and more in
/// groups, with narrow spaces between them.
pub fn typeset(figure: &str) -> String {
    figure.split(' ').map(typeset_word).collect::<Vec<_>>().join(" ")
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
    let group = |(i, digit): (usize, char)| match i > 0 && (word.len() - i).is_multiple_of(3) {
        true => vec!['\u{202f}', digit],
        false => vec![digit],
    };
    word.chars().enumerate().flat_map(group).collect()
}

fn superscript(exponent: &str) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    exponent.chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_and_their_labels() {
        let labels =
            |scale: Scale| -> Vec<String> { scale.ticks().into_iter().map(tick_label).collect() };
        assert_eq!(labels(Scale::log([7.0, 80.0], (0.0, 1.0))), ["5", "10", "20", "50", "100"]);
        assert_eq!(
            labels(Scale::log([2e-5, 0.4], (0.0, 1.0))),
            ["10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1"]
        );
        assert_eq!(labels(Scale::log([3e-6, 5e-6], (0.0, 1.0))), ["2·10⁻⁶", "5·10⁻⁶", "10⁻⁵"]);
        assert_eq!(
            labels(Scale::of_quantity(&[0.0, 1.0, 2.0], (0.0, 1.0))),
            ["0", "0.5", "1", "1.5", "2"]
        );
    }

    #[test]
    fn numbers_are_where_they_belong() {
        let scale = Scale::log([1.0, 100.0], (0.0, 300.0));
        let (a, b, c) = (scale.px(1.0), scale.px(10.0), scale.px(100.0));
        assert!(0.0 < a && a < b && b < c && c < 300.0 && (a + c - 2.0 * b).abs() < 1e-9);
    }

    #[test]
    fn an_axis_of_one_number_or_none() {
        for values in [&[][..], &[3.0], &[0.0], &[f64::INFINITY, f64::NAN], &[1e300, 1e-300]] {
            let scales = [
                Scale::log(values.iter().copied(), (5.0, 95.0)),
                Scale::of_quantity(values, (5.0, 95.0)),
            ];
            for scale in scales {
                let ticks: Vec<f64> =
                    scale.ticks().into_iter().map(|tick| scale.px(tick)).collect();
                assert!(!ticks.is_empty() && ticks.len() < 30, "{values:?}");
                assert!(ticks.is_sorted_by(|a, b| a < b), "{values:?}: {ticks:?}");
                // An axis without numbers shows something, one with numbers shows these; what is
                // beyond an axis is drawn at its very end.
                let drawn = values.iter().filter(|x| **x > 0.0 && x.is_finite());
                for x in drawn {
                    let px = scale.px(*x);
                    assert!(5.0 < px && px < 95.0, "{x} of {values:?} at {px}");
                }
            }
        }
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
