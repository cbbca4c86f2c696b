//! An [`Explanation`] as LaTeX: the lecture's formulas with the ray's numbers put in.
//!
//! One `align*` an object (package amsmath), without words, so that it fits a script in any
//! language. What it is about stands in comments.

use std::fmt::Write;

use super::text::short;
use super::{Explanation, ObjectExplanation, Reason, Short, Terms};

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
    align(
        &[
            format!(r"\vec{{o}} &{} {}", equals(&o), vector(&o)),
            format!(r"\vec{{d}} &{} {}", equals(&d), vector(&d)),
        ],
        &mut text,
    );
    for object in &explanation.objects {
        let _ = writeln!(text, "\n% {}: {}", object.label, object.why.join("; "));
        align(&formula(object), &mut text);
    }
    text
}

fn align(lines: &[String], text: &mut String) {
    if !lines.is_empty() {
        let _ = writeln!(text, "\\begin{{align*}}\n{}\n\\end{{align*}}", lines.join(" \\\\\n"));
    }
}

fn equals<'a>(numbers: impl IntoIterator<Item = &'a Short>) -> &'static str {
    if numbers.into_iter().any(|number| number.rounded) { r"\approx" } else { "=" }
}

/// A number in math mode: `1.5e-7` as a power of ten.
fn math(number: &str) -> String {
    match number.split_once('e') {
        Some((mantissa, exponent)) => format!(r"{mantissa} \cdot 10^{{{exponent}}}"),
        None => number.to_owned(),
    }
}

/// A factor: what is no plain number in parentheses.
fn factor(number: &str) -> String {
    let text = math(number);
    if number.starts_with('-') || number.contains('e') { format!("({text})") } else { text }
}

fn negated(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(magnitude) => math(magnitude),
        None if number == "0" => "0".into(),
        None => format!("-{}", math(number)),
    }
}

fn vector(v: &[Short]) -> String {
    let numbers: Vec<String> = v.iter().map(|number| math(&number.text)).collect();
    format!(r"({})", numbers.join(r",\ "))
}

fn sum(terms: &[Short]) -> String {
    let mut text = String::new();
    for (i, term) in terms.iter().enumerate() {
        match term.text.strip_prefix('-') {
            Some(magnitude) if i > 0 => text = format!("{text} - {}", math(magnitude)),
            None if i > 0 => text = format!("{text} + {}", math(&term.text)),
            _ => text = math(&term.text),
        }
    }
    text
}

fn formula(object: &ObjectExplanation) -> Vec<String> {
    let number = |symbol| short(object, symbol);
    let mut lines = Vec::new();
    match &object.terms {
        Terms::Sphere {
            center,
            radius,
            offset,
            squares,
            products,
            offset_squared,
            radius_squared,
        } => {
            let (Some(a), Some(b), Some(k), Some(d)) =
                (number("a"), number("b"), number("k"), number("D"))
            else {
                return lines;
            };
            lines.push(format!(
                r"\vec{{c}} &{} {}, \quad r {} {}",
                equals(center),
                vector(center),
                equals([radius]),
                math(&radius.text)
            ));
            let eq = equals(offset);
            lines.push(format!(r"\vec{{o}} - \vec{{c}} &{eq} {}", vector(offset)));
            let eq = equals(squares.iter().chain([a]));
            lines.push(format!(
                r"a &= \vec{{d}} \cdot \vec{{d}} {eq} {} {eq} {}",
                sum(squares),
                math(&a.text)
            ));
            let eq = equals(products.iter().chain([b]));
            lines.push(format!(
                r"b &= 2\,\vec{{d}} \cdot (\vec{{o}} - \vec{{c}}) {eq} 2\,({}) {eq} {}",
                sum(products),
                math(&b.text)
            ));
            let eq = equals([offset_squared, radius_squared, k]);
            lines.push(format!(
                r"k &= (\vec{{o}} - \vec{{c}}) \cdot (\vec{{o}} - \vec{{c}}) - r^2 {eq} {} - {} {eq} {}",
                math(&offset_squared.text),
                math(&radius_squared.text),
                math(&k.text)
            ));
            let eq = equals([a, b, k, d]);
            let sign = object.exact("D").map_or("", |exact| match exact.signum {
                -1 => " < 0",
                1 => " > 0",
                _ => "",
            });
            lines.push(format!(
                r"D &= b^2 - 4ak {eq} {}^2 - 4 \cdot {} \cdot {} {eq} {}{sign}",
                factor(&b.text),
                factor(&a.text),
                factor(&k.text),
                math(&d.text)
            ));
            if let Some((near, far)) = number("t₁").zip(number("t₂")) {
                let eq = equals([a, b, d, near, far]);
                let (index, roots) = match d.text.as_str() {
                    "0" => ("", math(&near.text)),
                    _ => ("_{1,2}", format!(r"{},\ {}", math(&near.text), math(&far.text))),
                };
                let behind = if object.reason == Reason::Behind { r" \le 0" } else { "" };
                lines.push(format!(
                    r"t{index} &= \frac{{-b \pm \sqrt{{D}}}}{{2a}} {eq} \frac{{{} \pm \sqrt{{{}}}}}{{2 \cdot {}}} {eq} {roots}{behind}",
                    negated(&b.text),
                    math(&d.text),
                    factor(&a.text)
                ));
            }
        }
        Terms::Plane { point, normal, offset, numerator, denominator } => {
            let (Some(above), Some(below)) = (number("(a−o)·n"), number("d·n")) else {
                return lines;
            };
            lines.push(format!(
                r"\vec{{a}} &{} {}, \quad \vec{{n}} {} {}",
                equals(point),
                vector(point),
                equals(normal),
                vector(normal)
            ));
            let eq = equals(offset);
            lines.push(format!(r"\vec{{a}} - \vec{{o}} &{eq} {}", vector(offset)));
            let eq = equals(numerator.iter().chain([above]));
            lines.push(format!(
                r"(\vec{{a}} - \vec{{o}}) \cdot \vec{{n}} &{eq} {} {eq} {}",
                sum(numerator),
                math(&above.text)
            ));
            let eq = equals(denominator.iter().chain([below]));
            lines.push(format!(
                r"\vec{{d}} \cdot \vec{{n}} &{eq} {} {eq} {}",
                sum(denominator),
                math(&below.text)
            ));
            if let Some(t) = number("t") {
                let eq = equals([above, below, t]);
                let behind = if object.reason == Reason::Behind { r" \le 0" } else { "" };
                lines.push(format!(
                    r"t &= \frac{{(\vec{{a}} - \vec{{o}}) \cdot \vec{{n}}}}{{\vec{{d}} \cdot \vec{{n}}}} {eq} \frac{{{}}}{{{}}} {eq} {}{behind}",
                    math(&above.text),
                    math(&below.text),
                    math(&t.text)
                ));
            }
        }
    }
    lines
}
