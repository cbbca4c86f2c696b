//! An [`Explanation`] as LaTeX: the lecture's formulas with the ray's numbers put in.
//!
//! One `align*` an object (package amsmath), without words, so that it fits a script in any
//! language. The subject stands in comments.

use std::fmt::Write;

use super::formula::{Line, Notation, Term, derivation, written};
use super::{Explanation, Short};

/// The whole explanation.
pub fn latex(explanation: &Explanation) -> String {
    let mut text = String::new();
    if let Some(p) = &explanation.pixel {
        let _ = writeln!(text, "% pixel ({}, {}) of {}x{}", p.x, p.y, p.width, p.height);
    }
    let of = |rows: std::ops::Range<usize>| -> Vec<Short> {
        let rows = explanation.ray.get(rows).unwrap_or_default();
        rows.iter().filter_map(|row| Some(row.exact.as_ref()?.short.clone())).collect()
    };
    let (o, d) = (of(0..3), of(3..6));
    let ray = [
        Line::new("o ~ #", r"\vec{o} &~ #", [Term::Vector(&o)]),
        Line::new("d ~ #", r"\vec{d} &~ #", [Term::Vector(&d)]),
    ];
    align(&ray, &mut text);
    for object in &explanation.objects {
        let _ = writeln!(text, "\n% {}: {}", object.label, object.why.join("; "));
        align(&derivation(object), &mut text);
    }
    text
}

fn align(lines: &[Line], text: &mut String) {
    if !lines.is_empty() {
        let lines = written(lines, Notation::Latex).join(" \\\\\n");
        let _ = writeln!(text, "\\begin{{align*}}\n{lines}\n\\end{{align*}}");
    }
}
