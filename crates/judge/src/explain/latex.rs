//! An [`Explanation`] as LaTeX: the lecture's formulas with the ray's numbers put in, and what comes of
//! them in words.
//!
//! For the package amsmath: a paragraph and an `align*` an object. Letters that are not ASCII are
//! written as they are, in UTF-8.

use std::fmt::Write;

use super::line::{Line, Notation, latex_of};
use super::words::{Remark, Words};
use super::{ColorExplanation, Explanation, Shading, Winner};

/// The whole explanation.
pub fn latex(explanation: &Explanation) -> String {
    String::from("% \\usepackage{amsmath}\n") + &written(explanation, paragraph)
}

/// The whole explanation in math mode alone, as notebooks show it.
pub fn math(explanation: &Explanation) -> String {
    written(explanation, paragraph_in_math)
}

/// How a subject and what is said of it become a paragraph at the end of a text.
type Paragraph = fn(&Remark, &[Remark], &mut String);

fn written(explanation: &Explanation, paragraph: Paragraph) -> String {
    let words = explanation.lang.words();
    let mut text = String::new();
    paragraph(&explanation.subject(), &[], &mut text);
    align(&explanation.ray_lines, &mut text);
    for object in &explanation.objects {
        paragraph(&named(&object.label), &object.why, &mut text);
        align(&object.lines, &mut text);
    }
    match &explanation.winner {
        None => paragraph(&Remark::plain(words.sees_background), &[], &mut text),
        Some(winner) => {
            let side = Remark::plain(side(words, winner));
            let t = winner.root.to_decimal(explanation.digits);
            let sees = Remark::new(words.sees, [winner.label.clone(), t]);
            paragraph(&sees, &[side], &mut text);
        }
    }
    if let Some(point) = &explanation.point {
        align(&point.lines, &mut text);
    }
    if let Some(shading) = &explanation.shading {
        of_shading(shading, words, paragraph, &mut text);
    }
    text
}

/// The side of the surface that is seen.
pub(super) fn side(words: &Words, winner: &Winner) -> &'static str {
    match winner.side {
        "back" => words.back,
        _ => words.front,
    }
}

fn named(label: &str) -> Remark {
    Remark::new("#", [label])
}

fn of_shading(shading: &Shading, words: &'static Words, paragraph: Paragraph, text: &mut String) {
    for light in &shading.lights {
        let why: Vec<Remark> = [&light.place].into_iter().chain(&light.why).cloned().collect();
        paragraph(&named(&light.name), &why, text);
        align(&light.lines, text);
    }
    if let Some(sky) = &shading.sky {
        paragraph(&sky.subject(words), &[sky.counts(words)], text);
    }
    let mut of_color = |subject, color| of_color(subject, color, words, paragraph, text);
    of_color(Remark::plain(words.color_of_ray), &shading.color);
    if let Some(mean) = &shading.mean {
        of_color(mean.subject(words), &mean.color);
    }
}

fn of_color(
    subject: Remark,
    color: &ColorExplanation,
    words: &'static Words,
    paragraph: Paragraph,
    text: &mut String,
) {
    let bytes = color.channels.each_ref().map(|channel| channel.byte.to_string());
    let mut why = vec![Remark::new(words.bytes, bytes)];
    why.extend_from_slice(&color.why);
    paragraph(&subject, &why, text);
    align(&color.lines, text);
}

/// A subject in bold letters, and what is said of it.
fn paragraph(subject: &Remark, why: &[Remark], text: &mut String) {
    let why: Vec<String> = why.iter().map(|why| why.written(Notation::Latex)).collect();
    let subject = subject.written(Notation::Latex);
    let said = if why.is_empty() { String::new() } else { format!(": {}", why.join("; ")) };
    let _ = writeln!(text, "\n\\noindent\\textbf{{{subject}}}{said}");
}

/// A paragraph that stands in math mode.
fn paragraph_in_math(subject: &Remark, why: &[Remark], text: &mut String) {
    let row = |remark: &Remark| format!("&\\text{{{}}}", remark.written(Notation::Latex));
    let subject = format!("&\\textbf{{{}}}", subject.written(Notation::Latex));
    let rows: Vec<String> = [subject].into_iter().chain(why.iter().map(row)).collect();
    let _ = writeln!(text, "\\begin{{align*}}\n{}\n\\end{{align*}}", rows.join(" \\\\\n"));
}

fn align(lines: &[Line], text: &mut String) {
    if !lines.is_empty() {
        let rows = latex_of(lines).join(" \\\\\n");
        let _ = writeln!(text, "\\begin{{align*}}\n{rows}\n\\end{{align*}}");
    }
}

impl Explanation {
    /// What is explained.
    pub(super) fn subject(&self) -> Remark {
        let words = self.lang.words();
        match &self.pixel {
            Some(p) => {
                Remark::new(words.pixel, [p.x, p.y, p.width, p.height].map(|n| n.to_string()))
            }
            None => Remark::plain(words.ray),
        }
    }
}
