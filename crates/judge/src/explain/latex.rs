//! An [`Explanation`] as LaTeX: the lecture's formulas with the ray's numbers put in, and what comes of
//! them in words.
//!
//! For the package amsmath: a paragraph and an `align*` an object. Letters that are not ASCII are
//! written as they are, in UTF-8.

use super::Explanation;
use super::expression::Notation;
use super::line::latex_of;

/// The whole explanation.
pub fn latex(explanation: &Explanation) -> String {
    String::from("% \\usepackage{amsmath}\n") + &written(explanation, paragraph)
}

/// The whole explanation in math mode alone, as notebooks show it.
pub fn math(explanation: &Explanation) -> String {
    written(explanation, paragraph_in_math)
}

/// The explanation with paragraphs of a subject and what is said of it.
fn written(explanation: &Explanation, paragraph: fn(&str, Vec<String>) -> String) -> String {
    let objects = explanation.objects.iter().map(|object| object.section());
    let sections = [explanation.of_ray()].into_iter().chain(objects);
    let sections = sections.chain([explanation.of_point(explanation.digits)]);
    let mut text = String::new();
    for section in sections.chain(explanation.of_light()) {
        let why = [section.why, section.notes].concat();
        let [subject, why] = [section.subject, why].map(|remarks| {
            remarks.iter().map(|remark| remark.written(Notation::Latex)).collect::<Vec<_>>()
        });
        text += &paragraph(&subject.join(", "), why);
        if let Some(derivation) = section.derivation.filter(|of| !of.lines.is_empty()) {
            text += &align(&latex_of(&derivation.lines));
        }
    }
    text
}

/// A subject in bold letters, and what is said of it.
fn paragraph(subject: &str, why: Vec<String>) -> String {
    let said = if why.is_empty() { String::new() } else { format!(": {}", why.join("; ")) };
    format!("\n\\noindent\\textbf{{{subject}}}{said}\n")
}

/// A paragraph that stands in math mode.
fn paragraph_in_math(subject: &str, why: Vec<String>) -> String {
    let mut rows = vec![format!("&\\textbf{{{subject}}}")];
    rows.extend(why.iter().map(|why| format!("&\\text{{{why}}}")));
    align(&rows)
}

fn align(rows: &[String]) -> String {
    format!("\\begin{{align*}}\n{}\n\\end{{align*}}\n", rows.join(" \\\\\n"))
}
