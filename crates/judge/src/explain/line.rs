//! The lines of a derivation, in plain text and in LaTeX.
//!
//! A line is a chain: a formula, expressions with numbers in them, the result. Each expression has as
//! many digits as it takes to get the result from it with a calculator.

use Notation::{Latex, Text};
use kugelblitz::exact::Root;
use kugelblitz::num::V3;
use serde::{Serialize, Serializer};

use super::numbers::{MANY_DIGITS, Short};
use super::step::{self, Numbers, Step, StepValue, Writer};
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

    /// A piece of a formula between words.
    pub fn formula(self, formula: &str) -> String {
        if self == Text {
            return formula.to_owned();
        }
        let translated = |c: char| match c {
            '·' => r" \cdot ".into(),
            '×' => r" \times ".into(),
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
            Latex if is_vector && name != "I" => format!(r"\vec{{{name}}}"),
            _ => self.formula(name),
        }
    }

    /// The relation of two pieces of a line.
    fn relation(self, is_rounded: bool) -> &'static str {
        match (is_rounded, self) {
            (false, _) => " = ",
            (true, Text) => " ≈ ",
            (true, Latex) => r" \approx ",
        }
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
    fn pieces(&self, notation: Notation) -> &[String] {
        &self.pieces[notation as usize]
    }

    /// Adds a piece in either notation.
    fn push(&mut self, piece: impl Fn(Notation) -> (String, bool)) {
        let was_rounded = self.is_rounded;
        for (notation, pieces) in [Text, Latex].into_iter().zip(&mut self.pieces) {
            let (piece, is_rounded) = piece(notation);
            self.is_rounded = is_rounded;
            let relation =
                if pieces.is_empty() { "" } else { notation.relation(was_rounded || is_rounded) };
            pieces.push(relation.to_owned() + &piece);
        }
    }

    /// Adds an expression with numbers put in.
    fn push_expression(&mut self, value: StepValue, digits: usize, addends: &[Step]) {
        self.push(|notation| {
            let writer = Writer::new(notation, Some(Numbers { digits, addends }));
            (writer.written(value), writer.is_rounded.get())
        });
    }

    /// Adds a number, or three, as they are written.
    fn push_numbers(&mut self, numbers: &[Short]) {
        self.push(|notation| {
            let comma = if notation == Latex { r",\ " } else { ", " };
            let all: Vec<String> =
                numbers.iter().map(|number| notation.number(&number.text)).collect();
            let text = all.join(comma);
            let text = if numbers.len() > 1 { format!("({text})") } else { text };
            (text, numbers.iter().any(|number| number.rounded))
        });
    }

    /// Columns that the line takes in text.
    fn columns(&self) -> usize {
        self.pieces(Text).iter().map(|piece| columns(piece)).sum()
    }
}

impl Serialize for Line {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.pieces(Text).concat())
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

/// A derivation, line by line. One at a time on a thread.
pub struct Derivation {
    /// Digits of the results.
    digits: usize,
    /// The lines.
    pub lines: Vec<Line>,
}

impl Derivation {
    /// Begins one.
    pub fn new(digits: usize) -> Derivation {
        step::begin();
        Derivation { digits, lines: Vec::new() }
    }

    /// A number for the results of a line.
    fn short(&self, step: Step) -> Short {
        Short::new(&step.value(), self.digits)
    }

    fn tell(&mut self, letter: &'static str, value: StepValue, numbers: &[Short], is_joined: bool) {
        let is_vector = numbers.len() > 1;
        let mut line = Line { is_joined, ..Line::default() };
        line.push(|notation| (notation.letter(letter, is_vector), false));
        line.push_numbers(numbers);
        value.tell(Some(letter));
        self.lines.push(line);
    }

    /// A line with a number of the scene, as someone has written it.
    pub fn number(&mut self, letter: &'static str, x: f64) -> Step {
        let step = step::of_scene(letter, x);
        self.tell(letter, step.into(), &[Short::given(x)], true);
        step
    }

    /// A line with three numbers of the scene.
    pub fn vector(&mut self, letter: &'static str, v: [f64; 3], is_joined: bool) -> V3<Step> {
        let steps = step::vector_of_scene(letter, v);
        self.tell(letter, steps.into(), &v.map(Short::given), is_joined);
        steps
    }

    /// A line with nothing but a number, or three, that come from elsewhere.
    pub fn given(&mut self, letter: &'static str, value: impl Into<StepValue>, is_joined: bool) {
        let value = value.into();
        let numbers: Vec<Short> = value.steps().iter().map(|&step| self.short(step)).collect();
        self.tell(letter, value, &numbers, is_joined);
    }

    /// A line with the formula of a number or vector; without a letter, the formula stands for itself.
    pub fn line(&mut self, letter: &'static str, value: impl Into<StepValue>, shown: LineDetail) {
        let value = value.into();
        let mut line = Line::default();
        if !letter.is_empty() {
            let is_vector = value.steps().len() > 1;
            line.push(|notation| (notation.letter(letter, is_vector), false));
        }
        line.push(|notation| (Writer::new(notation, None).written(value), false));
        self.calculate(&mut line, value, value.steps(), shown);
        value.tell((!letter.is_empty()).then_some(letter));
        self.end(line, value);
    }

    /// A line with a formula in words.
    pub fn said(&mut self, name: [&str; 2], formula: [&str; 2], value: Step) {
        let mut line = Line::default();
        for words in [name, formula] {
            line.push(|notation| (words[notation as usize].to_owned(), false));
        }
        self.calculate(&mut line, value.into(), &[value], LineDetail::Numbers);
        StepValue::from(value).tell(None);
        self.end(line, value.into());
    }

    /// The line with the formula of two roots, and theirs.
    pub fn roots(&mut self, [near, far]: [Step; 2]) {
        let mut line = Line::default();
        line.push(|_| ("t".into(), false));
        line.push(|notation| (Writer::new(notation, None).written(near.into()), false));
        self.calculate(&mut line, near.into(), &[near, far], LineDetail::Numbers);
        if near.value() == far.value() {
            StepValue::from(near).tell(None);
            return self.end(line, near.into());
        }
        self.lines.push(line);
        self.given("t₁", near, true);
        self.given("t₂", far, true);
    }

    /// Says in LaTeX what the sign of the last result is.
    pub fn say_sign(&mut self, sign: i32) {
        let sign = match sign {
            1 => " > 0",
            -1 => " < 0",
            _ => "",
        };
        if let Some(last) = self.lines.last_mut().and_then(|line| line.pieces[1].last_mut()) {
            *last += sign;
        }
    }

    /// Ends a line with its result, which is told.
    fn end(&mut self, mut line: Line, value: StepValue) {
        line.push_expression(value, self.digits, &[]);
        self.lines.push(line);
    }

    /// Adds the expressions that a calculator takes from the formula of `value` to `results`.
    fn calculate(&self, line: &mut Line, value: StepValue, results: &[Step], shown: LineDetail) {
        let forms = match shown {
            LineDetail::Result => vec![],
            LineDetail::Numbers => vec![vec![]],
            LineDetail::Addends => vec![vec![], value.addends()],
        };
        for addends in forms {
            let digits = self.digits_for(results, &addends);
            line.push_expression(value, digits, &addends);
        }
    }

    /// The fewest digits with which what the numbers give rounds to what is printed of the results. A
    /// result of 0 has no digits to be wrong in.
    fn digits_for(&self, results: &[Step], addends: &[Step]) -> usize {
        let printed: Vec<_> = results.iter().map(|&step| (step, self.short(step).text)).collect();
        let agree = |&digits: &usize| {
            let numbers = Numbers { digits, addends };
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
    let (half_unit, printed) = (Root::read(&format!("5e{power}")), Root::read(printed));
    half_unit.zip(printed).is_some_and(|(half_unit, printed)| {
        let error = value.plus(&printed.negated());
        error <= half_unit && error.negated() <= half_unit
    })
}

/// Before a piece that goes on in another line, and where that line is too long.
const INDENTS: [&str; 2] = ["      ", "        "];

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
                _ => written.extend(wrapped(piece, width, INDENTS[0], INDENTS[1])),
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
        for (i, (latex, text)) in latex.iter().zip(text).enumerate().skip(1) {
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
