//! An [`Explanation`] as LaTeX: the lecture's formulas with the ray's numbers put in.
//!
//! One `align*` an object (package amsmath), without words, so that it fits a script in any
//! language. The subject stands in comments.

use std::fmt::Write;

use super::formula::{Line, Notation, Term, derivation, of_color, of_light, of_point, written};
use super::{ColorExplanation, Explanation, Shading, Short};

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
    if let Some(shading) = &explanation.shading {
        of_shading(shading, &mut text);
    }
    text
}

fn of_shading(shading: &Shading, text: &mut String) {
    if let Some(point) = &shading.point {
        text.push_str("\n% the point that the ray sees\n");
        align(&of_point(point), text);
    }
    for light in &shading.lights {
        let _ = writeln!(text, "\n% {}, {}: {}", light.name, light.place, light.why.join("; "));
        align(&of_light(light), text);
    }
    if let Some(sky) = &shading.sky {
        let _ = writeln!(text, "\n% sky, {} of {} directions", sky.counting, sky.directions);
    }
    bytes("the ray", &shading.color, text);
    align(&of_color(&shading.color), text);
    if let Some(mean) = &shading.mean {
        bytes(&format!("the mean of {0}x{0} samples", mean.samples), &mean.color, text);
    }
}

fn bytes(of: &str, color: &ColorExplanation, text: &mut String) {
    let bytes = color.channels.each_ref().map(|channel| channel.byte.to_string());
    let _ = writeln!(text, "\n% {of}: bytes {}", bytes.join(", "));
}

fn align(lines: &[Line], text: &mut String) {
    if !lines.is_empty() {
        let lines = written(lines, Notation::Latex).join(" \\\\\n");
        let _ = writeln!(text, "\\begin{{align*}}\n{lines}\n\\end{{align*}}");
    }
}
