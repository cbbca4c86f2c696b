//! A line of a derivation, in plain text and in LaTeX.
//!
//! A line is a chain: a formula, expressions with numbers in them, the result. Each expression has as
//! many digits as it takes to get the result from it with a calculator.

use std::array;

use Notation::{Latex, Text};
use Term::{Divisor, Factor, Negated, Plain, Products, Squares, Sum, Vector};

use super::decimal::{Decimal, digits_for};
use super::numbers::Short;
use crate::exact::Root;

/// A way to write formulas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// Plain text.
    Text,
    /// LaTeX: names as text, formulas in math mode.
    Latex,
}

/// A place for a number, or for several.
#[derive(Clone, Debug)]
pub enum Term<N> {
    Plain(N),
    Factor(N),
    /// Below a line of fraction in LaTeX, behind a slash in text.
    Divisor(N),
    Negated(N),
    Sum(Vec<N>),
    Vector([N; 3]),
    /// The sum of the products of both, component by component.
    Products([N; 3], [N; 3]),
    /// The sum of the squares.
    Squares([N; 3]),
}

impl<N> Term<N> {
    fn numbers(&self) -> Vec<&N> {
        match self {
            Plain(number) | Factor(number) | Divisor(number) | Negated(number) => vec![number],
            Sum(numbers) => numbers.iter().collect(),
            Vector(numbers) | Squares(numbers) => numbers.iter().collect(),
            Products(left, right) => left.iter().chain(right).collect(),
        }
    }

    fn map<M>(&self, of: impl Fn(&N) -> M) -> Term<M> {
        match self {
            Plain(number) => Plain(of(number)),
            Factor(number) => Factor(of(number)),
            Divisor(number) => Divisor(of(number)),
            Negated(number) => Negated(of(number)),
            Sum(numbers) => Sum(numbers.iter().map(of).collect()),
            Vector(numbers) => Vector(numbers.each_ref().map(of)),
            Squares(numbers) => Squares(numbers.each_ref().map(of)),
            Products(left, right) => Products(left.each_ref().map(&of), right.each_ref().map(&of)),
        }
    }
}

impl Term<Short> {
    fn written(&self, notation: Notation) -> String {
        let of = |number: &Short| notation.number(&number.text);
        let factor = |number: &Short| {
            let needs_parentheses =
                number.text.starts_with('-') || notation == Latex && number.text.contains('e');
            if needs_parentheses { format!("({})", of(number)) } else { of(number) }
        };
        match self {
            Plain(number) => of(number),
            Divisor(number) if notation == Latex => of(number),
            Factor(number) | Divisor(number) => factor(number),
            Negated(number) => match number.text.strip_prefix('-') {
                Some(magnitude) => notation.number(magnitude),
                None if number.text == "0" => of(number),
                None => format!("-{}", of(number)),
            },
            Sum(numbers) => notation.sum(numbers),
            Vector(numbers) => {
                let comma = if notation == Latex { r",\ " } else { ", " };
                format!("({})", numbers.each_ref().map(of).join(comma))
            }
            Products(left, right) => {
                let times = if notation == Latex { r" \cdot " } else { "·" };
                let products: [String; 3] =
                    array::from_fn(|i| factor(&left[i]) + times + &factor(&right[i]));
                products.join(" + ")
            }
            Squares(numbers) => {
                let square = if notation == Latex { "^2" } else { "²" };
                numbers.each_ref().map(|number| factor(number) + square).join(" + ")
            }
        }
    }
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

    /// A piece of a formula between words.
    pub fn formula(self, formula: &str) -> String {
        if self == Text {
            return formula.to_owned();
        }
        let translated = |c: char| match c {
            '·' => r" \cdot ".into(),
            '×' => r" \times ".into(),
            'ω' => r"\vec{\omega}".into(),
            'd' | 'n' | 'o' | 'p' => format!(r"\vec{{{c}}}"),
            other => other.into(),
        };
        formula.chars().map(translated).collect()
    }

    /// `1 + 2 − 3`
    fn sum(self, numbers: &[Short]) -> String {
        let minus = if self == Latex { " - " } else { " − " };
        let mut text = String::new();
        for (i, number) in numbers.iter().enumerate() {
            let (sign, magnitude) = match number.text.strip_prefix('-') {
                _ if i == 0 => ("", &*number.text),
                Some(magnitude) => (minus, magnitude),
                None => (" + ", &*number.text),
            };
            text += sign;
            text += &self.number(magnitude);
        }
        text
    }
}

/// Numbers of an expression, and what a calculator makes of them, one number a result.
pub struct Expression {
    pub terms: Vec<Term<Root>>,
    pub value: fn(&[Decimal]) -> Vec<Decimal>,
}

/// An expression of one result.
macro_rules! expression {
    ($terms:expr, |$numbers:ident| $value:expr) => {
        Expression { terms: $terms.into(), value: |$numbers| vec![$value] }
    };
}

/// An expression of three results, one for each axis.
macro_rules! vector_expression {
    ($terms:expr, |$numbers:ident, $axis:ident| $value:expr) => {
        Expression { terms: $terms.into(), value: |$numbers| (0..3).map(|$axis| $value).collect() }
    };
}

/// One line of a derivation. In its two forms `#` stands for the next of the terms and `~` for `=`, or
/// for `≈` where digits are missing. A form breaks before relations only.
#[derive(Clone, Debug)]
pub struct Line {
    text: &'static str,
    latex: String,
    terms: Vec<Term<Short>>,
    /// True for what goes on in the line before, if that has room.
    is_joined: bool,
}

impl Line {
    /// A line of numbers that are given.
    pub fn given(
        text: &'static str,
        latex: impl Into<String>,
        terms: impl Into<Vec<Term<Short>>>,
    ) -> Line {
        Line { text, latex: latex.into(), terms: terms.into(), is_joined: false }
    }

    /// A chain of expressions and what comes out; where `results` are told elsewhere, they are left out.
    pub fn chain(
        forms: (&'static str, impl Into<String>),
        expressions: impl IntoIterator<Item = Expression>,
        results: &[Term<Root>],
        digits: usize,
    ) -> Line {
        let results: Vec<_> =
            results.iter().map(|term| term.map(|n| Short::new(n, digits))).collect();
        let expected: Vec<&Short> = results.iter().flat_map(Term::numbers).collect();
        let mut terms = Vec::new();
        for Expression { terms: roots, value } in expressions {
            let numbers: Vec<&Root> = roots.iter().flat_map(Term::numbers).collect();
            let needed = digits_for(&numbers, value, &expected, digits);
            terms.extend(roots.iter().map(|term| term.map(|number| Short::new(number, needed))));
        }
        let has_room = forms.0.matches('#').count() > terms.len();
        if has_room {
            terms.extend(results);
        }
        Line { text: forms.0, latex: forms.1.into(), terms, is_joined: false }
    }

    /// The line going on in the one before, if that has room.
    pub fn joined(self) -> Line {
        Line { is_joined: true, ..self }
    }

    /// The pieces of the line, each but the first with its relation in front.
    fn pieces(&self, notation: Notation) -> Vec<String> {
        let form = match notation {
            Text => self.text,
            Latex => &self.latex,
        };
        let mut terms = self.terms.iter();
        let mut was_rounded = false;
        let mut pieces = Vec::new();
        let mut rest = form;
        loop {
            // What begins a piece is no end of it.
            let first = rest.chars().next().map_or(0, char::len_utf8);
            let relations = [" = ", " ~ "].into_iter();
            let end = relations.filter_map(|relation| rest[first..].find(relation)).min();
            let (piece, next) = rest.split_at(end.map_or(rest.len(), |end| first + end));
            let mut text = String::new();
            let mut is_rounded = false;
            for (i, words) in piece.split('#').enumerate() {
                if i > 0
                    && let Some(term) = terms.next()
                {
                    is_rounded |= term.numbers().into_iter().any(|number| number.rounded);
                    text += &term.written(notation);
                }
                text += words;
            }
            let relation = match (is_rounded || was_rounded, notation) {
                (false, _) => " = ",
                (true, Text) => " ≈ ",
                (true, Latex) => r" \approx ",
            };
            was_rounded = is_rounded;
            pieces.push(match text.strip_prefix(" ~ ") {
                Some(after) => format!("{relation}{after}"),
                None => text,
            });
            if next.is_empty() {
                return pieces;
            }
            rest = next;
        }
    }

    /// Columns that the line takes in text.
    fn columns(&self) -> usize {
        self.pieces(Text).iter().map(|piece| piece.chars().count()).sum()
    }
}

/// How far the lines that go on are indented.
const INDENT: usize = 6;

/// The lines in plain text of at most `width` columns.
pub fn text_of(lines: &[Line], width: usize) -> Vec<String> {
    let mut written: Vec<String> = Vec::new();
    for line in lines {
        let pieces = line.pieces(Text);
        let joined = line.is_joined.then(|| written.last().map(|last| columns(last))).flatten();
        match joined.filter(|before| before + 2 + line.columns() <= width) {
            Some(_) => {
                if let Some(last) = written.last_mut() {
                    *last += ", ";
                    *last += &pieces.concat();
                }
                continue;
            }
            None => written.push(format!("  {}", pieces[0])),
        }
        for piece in &pieces[1..] {
            match written.last_mut() {
                Some(last) if columns(last) + columns(piece) <= width => *last += piece,
                _ => fold(piece.trim_start(), width, &mut written),
            }
        }
    }
    written
}

/// Adds lines of `width` columns with a piece that begins a line, broken at blanks where it is too long.
fn fold(piece: &str, width: usize, written: &mut Vec<String>) {
    let mut line = " ".repeat(INDENT);
    for word in piece.split(' ') {
        let is_first = line.trim_start().is_empty();
        if !is_first && columns(&line) + 1 + columns(word) > width {
            written.push(std::mem::replace(&mut line, " ".repeat(INDENT + 2)));
        } else if !is_first {
            line.push(' ');
        }
        line += word;
    }
    written.push(line);
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
        let is_joined = line.is_joined && used + line.columns() <= PAGE_COLUMNS;
        match rows.last_mut() {
            Some(last) if is_joined => {
                *last += r", \quad ";
                *last += &latex.concat();
                used += line.columns();
                continue;
            }
            _ => rows.push(latex[0].clone()),
        }
        used = columns(&text[0]);
        for (i, (latex, text)) in latex.iter().zip(&text).enumerate().skip(1) {
            let latex = latex.trim_start();
            match rows.last_mut() {
                Some(last) if i == 1 => *last += &format!(" &{latex}"),
                Some(last) if used + columns(text) <= PAGE_COLUMNS => *last += &format!(" {latex}"),
                _ => {
                    rows.push(format!("&{latex}"));
                    used = 0;
                }
            }
            used += columns(text);
        }
    }
    rows
}

pub(super) use {expression, vector_expression};
