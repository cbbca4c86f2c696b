//! The lines of a derivation, in plain text and in LaTeX.
//!
//! A line is a chain: a formula, expressions with numbers in them, the result. Each expression has as
//! many digits as it takes to get the result from it with a calculator.

use Notation::{Latex, Text};
use kugelblitz::exact::Root;
use kugelblitz::num::Real as _;
use serde::Serialize;

use super::calculator::Calculator as _;
use super::numbers::{Approximation, Columns, Exact, FormulaNumber, MANY_DIGITS, Short, error_ulp};
use super::step::{self, Rounding, Step};
use super::text::WIDTH;
use crate::compare::Precision;
use crate::markup::wrapped;

/// A way to write formulas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// Plain text.
    Text,
    /// LaTeX: names as text, formulas in math mode.
    Latex,
}

impl Notation {
    /// A number: in LaTeX `1.5e-7` as a power of ten.
    pub fn number(self, number: &str) -> String {
        match number.split_once('e') {
            Some((mantissa, exponent)) if self == Latex => {
                format!(r"{mantissa} \cdot 10^{{{exponent}}}")
            }
            _ => number.to_owned(),
        }
    }

    /// Words and names, without anything that LaTeX would take for a command.
    pub fn name(self, name: &str) -> String {
        if self == Text {
            return name.to_owned();
        }
        let escaped = |c: char| match c {
            '#' | '$' | '%' | '&' | '_' | '{' | '}' => format!("\\{c}"),
            '\\' => r"\textbackslash{}".into(),
            '~' => r"\textasciitilde{}".into(),
            '^' => r"\textasciicircum{}".into(),
            '<' => r"\textless{}".into(),
            '>' => r"\textgreater{}".into(),
            '|' => r"\textbar{}".into(),
            '"' => r"\textquotedbl{}".into(),
            '…' => r"\ldots{}".into(),
            other => other.into(),
        };
        name.chars().map(escaped).collect()
    }

    /// Returns the text of this notation.
    pub fn choose(self, text: &str, latex: &str) -> String {
        match self {
            Text => text.to_owned(),
            Latex => latex.to_owned(),
        }
    }

    /// A piece of a formula between words.
    pub fn formula(self, formula: &str) -> String {
        if self == Text {
            return formula.to_owned();
        }
        let translated = |c: char| match c {
            '·' => r" \cdot ".into(),
            '×' => r" \times ".into(),
            '±' => r"\pm".into(),
            '≈' => r"\approx".into(),
            '−' => "-".into(),
            '²' => "^2".into(),
            'ω' => r"\vec{\omega}".into(),
            '₁' => "_1".into(),
            '₂' => "_2".into(),
            'd' | 'n' | 'o' | 'p' => format!(r"\vec{{{c}}}"),
            other => other.into(),
        };
        formula.chars().map(translated).collect()
    }

    /// What stands for a number or for a vector; `I`, which is both, has no arrow.
    pub fn letter(self, name: &str, is_vector: bool) -> String {
        match self {
            Latex if is_vector && name.len() > 1 => {
                format!(r"\overrightarrow{{\text{{{}}}}}", self.name(name))
            }
            Latex if is_vector && name != "I" => format!(r"\vec{{{name}}}"),
            _ => self.formula(name),
        }
    }

    /// A number, or three in parentheses.
    pub fn tuple(self, numbers: impl Iterator<Item = String>) -> String {
        let numbers: Vec<String> = numbers.collect();
        let all = numbers.join(if self == Latex { r",\ " } else { ", " });
        if numbers.len() > 1 { format!("({all})") } else { all }
    }
}

/// One line of a derivation.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// In text and in LaTeX, each but the first with its relation in front.
    pieces: [Vec<String>; 2],
    /// Whether the last one was rounded.
    is_rounded: bool,
    /// True for what goes on in the line before, if that has room.
    is_joined: bool,
}

impl Line {
    /// Begins with the letter of a number or vector, if it has one.
    pub(super) fn of(letter: &str, is_vector: bool) -> Line {
        let mut line = Line::default();
        if !letter.is_empty() {
            line.push(|notation| (notation.letter(letter, is_vector), false));
        }
        line
    }

    fn pieces(&self, notation: Notation) -> &[String] {
        &self.pieces[notation as usize]
    }

    /// Adds a piece in either notation, and says whether it is rounded.
    pub(super) fn push(&mut self, piece: impl Fn(Notation) -> (String, bool)) {
        let was_rounded = self.is_rounded;
        for (notation, pieces) in [Text, Latex].into_iter().zip(&mut self.pieces) {
            let (piece, is_rounded) = piece(notation);
            self.is_rounded = is_rounded;
            let relation = match (was_rounded || is_rounded, notation) {
                _ if pieces.is_empty() => "",
                (false, _) => " = ",
                (true, Text) => " ≈ ",
                (true, Latex) => r" \approx ",
            };
            pieces.push(relation.to_owned() + &piece);
        }
    }

    /// Adds an expression in letters, or with numbers put in.
    fn push_expression(&mut self, value: &[Step], numbers: Option<Rounding>) {
        self.push(|notation| step::written(notation, value, numbers));
    }

    /// The whole line in plain text.
    pub fn text(&self) -> String {
        self.pieces(Text).concat()
    }

    /// Whether a piece of the line is rounded.
    pub(super) fn has_rounding(&self) -> bool {
        self.pieces(Text).iter().any(|piece| piece.contains('≈'))
    }

    /// Columns that the line takes in text.
    fn columns(&self) -> usize {
        self.pieces(Text).iter().map(|piece| columns(piece)).sum()
    }
}

/// What a line shows between its formula and its result.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum LineDetail {
    /// Nothing.
    Result,
    /// The numbers put in.
    Numbers,
    /// These, and what they make before they are added up.
    Addends,
}

/// A derivation, line by line, and the table of its numbers. One at a time is written on a thread.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Derivation {
    /// Digits of the results.
    #[serde(skip)]
    digits: usize,
    /// The lines.
    #[serde(skip)]
    pub(super) lines: Vec<Line>,
    /// The numbers in each arithmetic, as rows of the table.
    pub quantities: Vec<FormulaNumber>,
}

impl Derivation {
    /// Begins one.
    pub(super) fn new(digits: usize) -> Derivation {
        step::begin();
        Derivation { digits, ..Derivation::default() }
    }

    /// Adds a row to the table, with errors against the exact number.
    pub(super) fn row(
        &mut self,
        symbol: &'static str,
        columns: Columns,
        exact: impl Into<Option<Root>>,
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

    /// A number for the results of a line.
    fn short(&self, step: Step) -> Short {
        Short::new(&step.value(), self.digits)
    }

    fn tell(&mut self, letter: &'static str, value: &[Step], numbers: &[Short]) {
        let mut line = Line { is_joined: true, ..Line::of(letter, value.len() > 1) };
        line.push(|notation| {
            let texts = numbers.iter().map(|number| notation.number(&number.text));
            (notation.tuple(texts), numbers.iter().any(|number| number.rounded))
        });
        step::tell(value, letter);
        self.lines.push(line);
    }

    /// A line with a number of the scene, or three, as someone has written them.
    pub(super) fn of_scene<const N: usize>(
        &mut self,
        letter: &'static str,
        numbers: [f64; N],
    ) -> [Step; N] {
        let steps = numbers.map(Step::lit);
        self.tell(letter, &steps, &numbers.map(Short::given));
        steps
    }

    /// A line with nothing but a number, or three, that come from elsewhere.
    pub(super) fn given(&mut self, letter: &'static str, value: &[Step]) {
        let numbers: Vec<Short> = value.iter().map(|&step| self.short(step)).collect();
        self.tell(letter, value, &numbers);
    }

    /// Adds numbers that come from elsewhere, as [`Derivation::given`], on a new line.
    pub(super) fn given_below(&mut self, letter: &'static str, value: &[Step]) {
        self.given(letter, value);
        if let Some(line) = self.lines.last_mut() {
            line.is_joined = false;
        }
    }

    /// A line with the formula of a number or vector; without a letter, the formula stands for itself.
    pub(super) fn line(&mut self, letter: &'static str, value: &[Step], shown: LineDetail) {
        let mut line = Line::of(letter, value.len() > 1);
        line.push_expression(value, None);
        self.end(line, letter, value, shown);
    }

    /// A line with a formula in words.
    pub(super) fn said(&mut self, name: [&str; 2], formula: [&str; 2], value: Step) {
        let mut line = Line::default();
        for words in [name, formula] {
            line.push(|notation| (words[notation as usize].to_owned(), false));
        }
        self.end(line, "", &[value], LineDetail::Numbers);
    }

    /// The line with the formula of two roots, and theirs.
    pub(super) fn roots(&mut self, [near, far]: [Step; 2]) {
        let mut line = Line::of("t", false);
        line.push_expression(&[near], None);
        if near.value() == far.value() {
            return self.end(line, "", &[near], LineDetail::Numbers);
        }
        self.calculate(&mut line, &[near], &[near, far], LineDetail::Numbers);
        self.lines.push(line);
        self.given("t₁", &[near]);
        self.given("t₂", &[far]);
    }

    /// Says in LaTeX what the sign of the last result is.
    pub(super) fn say_sign(&mut self, sign: i32) {
        let sign = match sign {
            1 => " > 0",
            -1 => " < 0",
            _ => "",
        };
        if let Some(last) = self.lines.last_mut().and_then(|line| line.pieces[1].last_mut()) {
            *last += sign;
        }
    }

    /// Ends a line with the expressions of `value` and its result, which is told.
    fn end(&mut self, mut line: Line, letter: &'static str, value: &[Step], shown: LineDetail) {
        self.calculate(&mut line, value, value, shown);
        step::tell(value, letter);
        line.push_expression(value, Some(Rounding { digits: self.digits, addends: &[] }));
        self.lines.push(line);
    }

    /// Adds the expressions that a calculator takes from the formula of `value` to `results`.
    fn calculate(&self, line: &mut Line, value: &[Step], results: &[Step], shown: LineDetail) {
        let addends = value.iter().flat_map(|step| step.addends()).collect();
        let forms = match shown {
            LineDetail::Result => vec![],
            LineDetail::Numbers => vec![vec![]],
            LineDetail::Addends => vec![vec![], addends],
        };
        for addends in &forms {
            let digits = self.digits_for(results, addends);
            line.push_expression(value, Some(Rounding { digits, addends }));
        }
    }

    /// The fewest digits with which what the numbers give rounds to what is printed of the results. A
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

/// Whether a number is at most half a unit of the last of so many digits away from a printed one.
fn rounds_to(value: &Root, printed: &str, digits: usize) -> bool {
    let (mantissa, exponent) = printed.split_once('e').unwrap_or((printed, "0"));
    let n_behind = mantissa.split_once('.').map_or(0, |(_, part)| part.len()) as isize;
    let leading = mantissa.trim_start_matches(['-', '0', '.']);
    let n_digits = leading.chars().filter(char::is_ascii_digit).count() as isize;
    let power = exponent.parse().unwrap_or(0) - n_behind + n_digits - 1 - digits as isize;
    let (half_unit, printed) = (Root::parse(&format!("5e{power}")), Root::parse(printed));
    half_unit
        .zip(printed)
        .is_some_and(|(half_unit, printed)| value.plus(&printed.negated()).magnitude() <= half_unit)
}

/// Indent of a piece's further rows in text.
const TERM_INDENT: &str = "        ";

/// The lines in plain text of at most [`WIDTH`] columns.
pub fn text_of(lines: &[Line]) -> Vec<String> {
    let mut written: Vec<String> = Vec::new();
    for line in lines {
        let pieces = line.pieces(Text);
        match written.last_mut() {
            Some(last) if line.is_joined && columns(last) + 2 + line.columns() <= WIDTH => {
                *last += &format!(", {}", pieces.concat());
                continue;
            }
            _ => written.push(format!("  {}", pieces[0])),
        }
        for piece in &pieces[1..] {
            match written.last_mut() {
                Some(last) if columns(last) + columns(piece) <= WIDTH => *last += piece,
                _ => {
                    let rows = rows_of_sum([piece; 2], Text, WIDTH - TERM_INDENT.len());
                    for (at, row) in rows.iter().enumerate() {
                        let first = if at == 0 { "      " } else { TERM_INDENT };
                        written.extend(wrapped(row, WIDTH, first, TERM_INDENT));
                    }
                }
            }
        }
    }
    written
}

fn columns(text: &str) -> usize {
    text.chars().count()
}

/// Columns of text whose formulas fit a page.
const PAGE_COLUMNS: usize = 66;

/// The lines as rows of an `align*`, which meet at their relations.
pub fn latex_of(lines: &[Line]) -> Vec<String> {
    let mut rows: Vec<String> = Vec::new();
    let mut used = 0;
    for line in lines {
        let (latex, text) = (line.pieces(Latex), line.pieces(Text));
        match rows.last_mut() {
            Some(last) if line.is_joined && used + line.columns() <= PAGE_COLUMNS => {
                *last += &format!(r", \quad {}", latex.concat());
                used += line.columns();
                continue;
            }
            _ => rows.push(latex[0].clone()),
        }
        used = columns(&text[0]);
        for (i, (latex, text)) in latex.iter().zip(text).enumerate().skip(1) {
            let latex = latex.trim_start();
            match rows.last_mut() {
                Some(last) if i == 1 => *last += &format!(" &{latex}"),
                Some(last) if used + columns(text) <= PAGE_COLUMNS => *last += &format!(" {latex}"),
                _ => {
                    let split = rows_of_sum([text, latex], Latex, PAGE_COLUMNS);
                    let space = |at| if at == 0 { "" } else { r"\quad" };
                    let row = |(at, row): (usize, &String)| format!("&{}{row}", space(at));
                    rows.extend(split.iter().enumerate().map(row));
                    used = 0;
                }
            }
            used += columns(text);
        }
    }
    rows
}

/// Terms of a sum in either notation, each but the first with its sign in front.
fn terms(sum: &str) -> Vec<&str> {
    let (mut depth, mut start, mut terms) = (0, 0, Vec::new());
    for (at, c) in sum.char_indices() {
        match c {
            '(' | '{' => depth += 1,
            ')' | '}' => depth -= 1,
            '+' if depth == 0 && sum[..at].ends_with(' ') => {
                terms.push(&sum[start..at - 1]);
                start = at - 1;
            }
            _ => {}
        }
    }
    terms.push(&sum[start..]);
    terms
}

/// Splits a piece before the terms of its sum into rows of at most `width` columns of text, if its terms are that short, and
/// returns them in a notation.
fn rows_of_sum(pieces: [&str; 2], notation: Notation, width: usize) -> Vec<String> {
    let [text, latex] = pieces.map(terms);
    let mut rows = vec![String::new()];
    let mut used = 0;
    for (text, latex) in text.into_iter().zip(latex) {
        if used > 0 && used + columns(text) > width {
            rows.push(String::new());
            used = 0;
        }
        rows.last_mut().into_iter().for_each(|row| *row += notation.choose(text, latex).as_str());
        used += columns(text);
    }
    rows
}
