//! Lines of a derivation, laid out as plain text and as LaTeX.
//!
//! A line is a chain: a formula, expressions with numbers in them, the result.

use super::expression::Expression;
use super::expression::Notation::{self, Latex, Text};
use super::text::WIDTH;
use crate::markup::wrapped;

/// One line of a derivation.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// Expressions that are equal, or equal but for rounding.
    pub pieces: Vec<Expression>,
    /// Sign of the last piece that LaTeX states: -1 or 1, or 0 for none.
    pub sign: i32,
    /// Whether the line continues the line before, if that has room.
    pub is_joined: bool,
}

/// A piece of a line with its relation in front: the terms of its sum.
type Piece = Vec<String>;

impl Line {
    /// Begins with the letter of a number or vector, unless it is empty.
    pub fn of(name: &'static str, is_vector: bool) -> Line {
        let letter = (!name.is_empty()).then_some(Expression::Letter { name, is_vector });
        Line { pieces: Vec::from_iter(letter), ..Line::default() }
    }

    /// Returns for each piece but the first whether it is only about equal to the one before.
    fn is_approximate(&self) -> impl Iterator<Item = bool> {
        self.pieces.windows(2).map(|pair| pair.iter().any(Expression::is_rounded))
    }

    /// Whether a piece of the line is rounded.
    pub fn has_rounding(&self) -> bool {
        self.is_approximate().any(|is_approximate| is_approximate)
    }

    fn written(&self, notation: Notation) -> Vec<Piece> {
        let relation = |is_approximate| match (is_approximate, notation) {
            (false, _) => " = ",
            (true, Text) => " ≈ ",
            (true, Latex) => r" \approx ",
        };
        let relations = [""].into_iter().chain(self.is_approximate().map(relation));
        let mut pieces: Vec<Piece> = Vec::new();
        for (piece, relation) in self.pieces.iter().zip(relations) {
            let mut terms = piece.terms(notation);
            terms[0].insert_str(0, relation);
            pieces.push(terms);
        }
        if let (Latex, Some(last)) =
            (notation, pieces.last_mut().and_then(|terms| terms.last_mut()))
        {
            *last += match self.sign {
                1 => " > 0",
                -1 => " < 0",
                _ => "",
            };
        }
        pieces
    }

    /// Writes the whole line in plain text.
    pub fn text(&self) -> String {
        self.written(Text).concat().concat()
    }
}

/// Indent of a piece's further rows in text.
const TERM_INDENT: &str = "        ";

/// Writes the lines in plain text of at most [`WIDTH`] columns.
pub fn text_of(lines: &[Line]) -> Vec<String> {
    let mut written: Vec<String> = Vec::new();
    for line in lines {
        let pieces = line.written(Text);
        let whole = pieces.concat().concat();
        match written.last_mut() {
            Some(last) if line.is_joined && columns(last) + 2 + columns(&whole) <= WIDTH => {
                *last += &format!(", {whole}");
                continue;
            }
            _ => written.push(format!("  {}", pieces[0].concat())),
        }
        for terms in &pieces[1..] {
            let piece = terms.concat();
            match written.last_mut() {
                Some(last) if columns(last) + columns(&piece) <= WIDTH => *last += &piece,
                _ => {
                    let rows = rows_of_sum([terms; 2], WIDTH - TERM_INDENT.len());
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

/// Writes the lines as rows of an `align*`, aligned at their relations.
pub fn latex_of(lines: &[Line]) -> Vec<String> {
    let mut rows: Vec<String> = Vec::new();
    let mut used = 0;
    for line in lines {
        let (latex, text) = (line.written(Latex), line.written(Text));
        let n_columns = columns(&text.concat().concat());
        match rows.last_mut() {
            Some(last) if line.is_joined && used + n_columns <= PAGE_COLUMNS => {
                *last += &format!(r", \quad {}", latex.concat().concat());
                used += n_columns;
                continue;
            }
            _ => rows.push(latex[0].concat()),
        }
        used = columns(&text[0].concat());
        for (i, (mut latex, text)) in latex.into_iter().zip(text).enumerate().skip(1) {
            latex[0] = latex[0].trim_start().to_owned();
            let n_columns = columns(&text.concat());
            match rows.last_mut() {
                Some(last) if i == 1 => *last += &format!(" &{}", latex.concat()),
                Some(last) if used + n_columns <= PAGE_COLUMNS => {
                    *last += &format!(" {}", latex.concat());
                }
                _ => {
                    let split = rows_of_sum([&text, &latex], PAGE_COLUMNS);
                    let space = |at| if at == 0 { "" } else { r"\quad" };
                    let row = |(at, row): (usize, &String)| format!("&{}{row}", space(at));
                    rows.extend(split.iter().enumerate().map(row));
                    used = 0;
                }
            }
            used += n_columns;
        }
    }
    rows
}

/// Distributes the terms of a piece, in text and as `written`, to rows of the latter. A row has at most `width` columns of
/// text, or one longer term.
fn rows_of_sum([text, written]: [&Piece; 2], width: usize) -> Vec<String> {
    let mut rows = vec![String::new()];
    let mut used = 0;
    for (text, term) in text.iter().zip(written) {
        if used > 0 && used + columns(text) > width {
            rows.push(String::new());
            used = 0;
        }
        rows.last_mut().into_iter().for_each(|row| *row += term);
        used += columns(text);
    }
    rows
}
