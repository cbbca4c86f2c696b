//! An [`Explanation`] as LaTeX: the lecture's formulas with the ray's numbers put in, and what comes of
//! them in words.
//!
//! For the package amsmath: a paragraph and an `align*` an object. Letters that are not ASCII are
//! written as they are, in UTF-8.

use std::fmt::Write;

use super::Explanation;
use super::line::{Notation, latex_of};

/// The whole explanation.
pub fn latex(explanation: &Explanation) -> String {
    String::from("% \\usepackage{amsmath}\n") + &written(explanation, paragraph)
}

/// The whole explanation in math mode alone, as notebooks show it.
pub fn math(explanation: &Explanation) -> String {
    written(explanation, paragraph_in_math)
}

/// How a subject and what is said of it become a paragraph at the end of a text.
type Paragraph = fn(&str, &[String], &mut String);

fn written(explanation: &Explanation, paragraph: Paragraph) -> String {
    let objects = explanation.objects.iter().map(|object| object.section());
    let sections = [explanation.of_ray()].into_iter().chain(objects);
    let sections = sections.chain([explanation.of_point(explanation.digits)]);
    let mut text = String::new();
    for section in sections.chain(explanation.of_light()) {
        let [subject, why] = [&section.subject, &section.why].map(|remarks| {
            remarks.iter().map(|remark| remark.written(Notation::Latex)).collect::<Vec<_>>()
        });
        paragraph(&subject.join(", "), &why, &mut text);
        if !section.lines.is_empty() {
            align(&latex_of(section.lines), &mut text);
        }
    }
    text
}

/// A subject in bold letters, and what is said of it.
fn paragraph(subject: &str, why: &[String], text: &mut String) {
    let said = if why.is_empty() { String::new() } else { format!(": {}", why.join("; ")) };
    let _ = writeln!(text, "\n\\noindent\\textbf{{{subject}}}{said}");
}

/// A paragraph that stands in math mode.
fn paragraph_in_math(subject: &str, why: &[String], text: &mut String) {
    let mut rows = vec![format!("&\\textbf{{{subject}}}")];
    rows.extend(why.iter().map(|why| format!("&\\text{{{why}}}")));
    align(&rows, text);
}

fn align(rows: &[String], text: &mut String) {
    let rows = rows.join(" \\\\\n");
    let _ = writeln!(text, "\\begin{{align*}}\n{rows}\n\\end{{align*}}");
}
