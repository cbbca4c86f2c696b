//! Derivations: numbers calculated from the numbers of a scene, line by line.
//!
//! Each expression of a line has as many digits as it takes to get the result of the line from it with a calculator.

use kugelblitz::exact::{QuadraticSurd, exact};
use serde::Serialize;

use super::calculator::Calculator as _;
use super::expression::Expression;
use super::line::Line;
use super::numbers::{Approximation, Columns, Exact, FormulaNumber, MANY_DIGITS, Short, error_ulp};
use super::step::{Rounding, Step, Tape, expression, show};
use crate::compare::Precision;

/// Expressions of a line between its formula and its result.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum LineDetail {
    /// None.
    Result,
    /// The formula with numbers put in.
    Numbers,
    /// The formula with numbers put in, then their products that are added up.
    Addends,
}

/// A derivation, line by line, and the table of its numbers.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Derivation {
    /// Digits of the results.
    #[serde(skip)]
    digits: usize,
    /// The lines.
    #[serde(skip)]
    pub(super) lines: Vec<Line>,
    /// The numbers in each arithmetic. Unstable in JSON.
    pub quantities: Vec<FormulaNumber>,
}

impl Derivation {
    /// Begins a derivation whose results have so many digits.
    pub(super) fn new(digits: usize) -> Derivation {
        Derivation { digits, ..Derivation::default() }
    }

    /// Writes each line in plain text.
    pub(super) fn formulas(&self) -> Vec<String> {
        self.lines.iter().map(Line::text).collect()
    }

    /// Adds a row to the table, with errors against the exact number.
    pub(super) fn row(
        &mut self,
        symbol: &'static str,
        columns: Columns,
        exact: impl Into<Option<QuadraticSurd>>,
    ) {
        let exact = exact.into().map(Exact::from);
        let precisions = [Precision::Single, Precision::Single, Precision::Double];
        let entry = |column: usize| {
            let value = columns[column]?;
            let both = value.zip(exact.as_ref());
            Some(Approximation {
                value,
                error_ulp: both.map(|(x, exact)| error_ulp(x, &exact.root, precisions[column])),
                wrong_sign: both.is_some_and(|(x, exact)| {
                    i32::from(x > 0.0) - i32::from(x < 0.0) != exact.signum
                }),
            })
        };
        let [lecture, stable, f64] = [0, 1, 2].map(entry);
        self.quantities.push(FormulaNumber { symbol, lecture, stable, f64, exact });
    }

    /// Adds the rows of several numbers, each against its exact one.
    pub(super) fn rows<const N: usize>(
        &mut self,
        symbols: [&'static str; N],
        exact: [Step; N],
        columns: impl Fn(usize) -> Columns,
    ) {
        for (i, symbol) in symbols.into_iter().enumerate() {
            self.row(symbol, columns(i), exact[i].value());
        }
    }

    /// Rounds a number to the digits of the results.
    fn short(&self, step: Step) -> Short {
        Short::new(&step.value(), self.digits)
    }

    fn state(&mut self, letter: &'static str, value: &[Step], numbers: Vec<Short>) {
        let mut line = Line { is_joined: true, ..Line::of(letter, value.len() > 1) };
        line.pieces.push(Expression::of_numbers(numbers));
        show(value, letter);
        self.lines.push(line);
    }

    /// Adds a line with a number of the scene, or three, as someone has written them.
    pub(super) fn of_scene<'t, const N: usize>(
        &mut self,
        tape: &'t Tape,
        letter: &'static str,
        numbers: [f64; N],
    ) -> [Step<'t>; N] {
        let steps = numbers.map(|x| tape.number(letter, QuadraticSurd::from(exact(x))));
        self.state(letter, &steps, numbers.map(Short::given).into());
        steps
    }

    /// Adds a line with only a number, or three, that come from elsewhere.
    pub(super) fn given(&mut self, letter: &'static str, value: &[Step]) {
        let numbers = value.iter().map(|&step| self.short(step)).collect();
        self.state(letter, value, numbers);
    }

    /// Adds numbers that come from elsewhere, as [`Derivation::given`], on a new line.
    pub(super) fn given_below(&mut self, letter: &'static str, value: &[Step]) {
        self.given(letter, value);
        if let Some(line) = self.lines.last_mut() {
            line.is_joined = false;
        }
    }

    /// Adds a line with the formula of a number or vector; without a letter, it begins with the formula.
    pub(super) fn line(&mut self, letter: &'static str, value: &[Step], detail: LineDetail) {
        let mut line = Line::of(letter, value.len() > 1);
        line.pieces.push(expression(value, None));
        self.end(line, letter, value, detail);
    }

    /// Adds a line with a formula that is written by hand, in text and in LaTeX.
    pub(super) fn written(&mut self, name: [&str; 2], formula: [&str; 2], value: Step) {
        let pieces = [name, formula].map(|written| {
            let [text, latex] = written.map(str::to_owned);
            Expression::Written { text, latex }
        });
        self.end(
            Line { pieces: pieces.into(), ..Line::default() },
            "",
            &[value],
            LineDetail::Numbers,
        );
    }

    /// Adds the formula of two roots, and the roots.
    pub(super) fn roots(&mut self, [near, far]: [Step; 2]) {
        let mut line = Line::of("t", false);
        line.pieces.push(expression(&[near], None));
        if near.value() == far.value() {
            return self.end(line, "", &[near], LineDetail::Numbers);
        }
        self.calculate(&mut line, &[near], &[near, far], LineDetail::Numbers);
        self.lines.push(line);
        self.given("t₁", &[near]);
        self.given("t₂", &[far]);
    }

    /// Lets LaTeX state the sign of the last result.
    pub(super) fn state_sign(&mut self, sign: i32) {
        if let Some(last) = self.lines.last_mut() {
            last.sign = sign;
        }
    }

    /// Ends a line with the expressions of `value` and its result, and shows it.
    fn end(&mut self, mut line: Line, letter: &'static str, value: &[Step], detail: LineDetail) {
        self.calculate(&mut line, value, value, detail);
        show(value, letter);
        line.pieces.push(expression(value, Some(Rounding { digits: self.digits, addends: &[] })));
        self.lines.push(line);
    }

    /// Adds the expressions that a calculator takes from the formula of `value` to `results`.
    fn calculate(&self, line: &mut Line, value: &[Step], results: &[Step], detail: LineDetail) {
        let addends = value.iter().flat_map(|step| step.addends()).collect();
        let forms = match detail {
            LineDetail::Result => vec![],
            LineDetail::Numbers => vec![vec![]],
            LineDetail::Addends => vec![vec![], addends],
        };
        for addends in &forms {
            let digits = self.digits_for(results, addends);
            line.pieces.push(expression(value, Some(Rounding { digits, addends })));
        }
    }

    /// Returns the fewest digits with which the calculated numbers round to the printed results. A
    /// result of 0 has no digits to be wrong in.
    fn digits_for(&self, results: &[Step], addends: &[Step]) -> usize {
        let printed: Vec<_> = results.iter().map(|&step| (step, self.short(step).text)).collect();
        let agree = |&digits: &usize| {
            let numbers = Rounding { digits, addends };
            printed.iter().all(|(step, text)| {
                text == "0" || rounds_to(&numbers.calculated(*step), text, self.digits)
            })
        };
        (self.digits..MANY_DIGITS).find(agree).unwrap_or(MANY_DIGITS)
    }
}

/// Whether the distance of a number from a printed one is at most half a unit of the last of so many digits.
fn rounds_to(value: &QuadraticSurd, printed: &str, digits: usize) -> bool {
    let (mantissa, exponent) = printed.split_once('e').unwrap_or((printed, "0"));
    let n_behind = mantissa.split_once('.').map_or(0, |(_, part)| part.len()) as isize;
    let leading = mantissa.trim_start_matches(['-', '0', '.']);
    let n_digits = leading.chars().filter(char::is_ascii_digit).count() as isize;
    let power = exponent.parse().unwrap_or(0) - n_behind + n_digits - 1 - digits as isize;
    let (half_unit, printed) =
        (QuadraticSurd::parse(&format!("5e{power}")), QuadraticSurd::parse(printed));
    half_unit
        .zip(printed)
        .is_some_and(|(half_unit, printed)| value.plus(&printed.negated()).magnitude() <= half_unit)
}
