//! The lecture's formulas with an object's numbers put in: each line once, in both notations.

use Notation::{Latex, Text};
use Term::{Divisor, Factor, Negated, Plain, Sum, Vector};

use super::light::{LightExplanation, PointExplanation, WayTerms};
use super::numbers::Short;
use super::{ColorExplanation, ObjectExplanation, Reason, Terms};

/// A way to write formulas.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Notation {
    /// Plain text.
    Text,
    /// LaTeX in math mode.
    Latex,
}

/// A place for a number, or for three.
pub enum Term<'a> {
    Plain(&'a Short),
    Factor(&'a Short),
    /// Below a line of fraction in LaTeX, behind a slash in text.
    Divisor(&'a Short),
    Negated(&'a Short),
    Sum(&'a [Short]),
    Vector(&'a [Short]),
}

/// One line of a derivation. In its two forms `#` stands for the next of the terms and `~` for `=`,
/// or for `≈` where digits are missing. A line that begins with a comma continues the one before.
pub struct Line<'a> {
    text: &'static str,
    latex: String,
    terms: Vec<Term<'a>>,
}

impl<'a> Line<'a> {
    pub fn new<const N: usize>(
        text: &'static str,
        latex: impl Into<String>,
        terms: [Term<'a>; N],
    ) -> Line<'a> {
        Line { text, latex: latex.into(), terms: terms.into() }
    }

    fn written(&self, notation: Notation) -> String {
        let is_rounded = self.terms.iter().flat_map(Term::numbers).any(|number| number.rounded);
        let (form, relation) = match (notation, is_rounded) {
            (Text, true) => (self.text, "≈"),
            (Text, false) => (self.text, "="),
            (Latex, true) => (&*self.latex, r"\approx"),
            (Latex, false) => (&*self.latex, "="),
        };
        let form = form.replace('~', relation);
        let mut pieces = form.split('#');
        let mut text = pieces.next().unwrap_or_default().to_owned();
        for (term, piece) in self.terms.iter().zip(pieces) {
            text += &term.written(notation);
            text += piece;
        }
        text
    }
}

/// The lines in a notation, those that belong together as one.
pub fn written(lines: &[Line], notation: Notation) -> Vec<String> {
    let mut written: Vec<String> = Vec::new();
    for line in lines.iter().map(|line| line.written(notation)) {
        match written.last_mut() {
            Some(last) if line.starts_with(',') => *last += &line,
            _ => written.push(line),
        }
    }
    written
}

impl<'a> Term<'a> {
    fn numbers(&self) -> &'a [Short] {
        match *self {
            Plain(number) | Factor(number) | Divisor(number) | Negated(number) => {
                std::slice::from_ref(number)
            }
            Sum(numbers) | Vector(numbers) => numbers,
        }
    }

    fn written(&self, notation: Notation) -> String {
        let of = |number: &Short| notation.number(&number.text);
        match *self {
            Plain(number) => of(number),
            Divisor(number) if notation == Latex => of(number),
            Factor(number) | Divisor(number) => {
                let needs_parentheses =
                    number.text.starts_with('-') || notation == Latex && number.text.contains('e');
                if needs_parentheses { format!("({})", of(number)) } else { of(number) }
            }
            Negated(number) => match number.text.strip_prefix('-') {
                Some(magnitude) => notation.number(magnitude),
                None if number.text == "0" => of(number),
                None => format!("-{}", of(number)),
            },
            Sum(numbers) => notation.sum(numbers),
            Vector(numbers) => {
                let comma = if notation == Latex { r",\ " } else { ", " };
                format!("({})", numbers.iter().map(of).collect::<Vec<_>>().join(comma))
            }
        }
    }
}

impl Notation {
    /// A number: in LaTeX `1.5e-7` as a power of ten.
    fn number(self, number: &str) -> String {
        match number.split_once('e') {
            Some((mantissa, exponent)) if self == Latex => {
                format!(r"{mantissa} \cdot 10^{{{exponent}}}")
            }
            _ => number.to_owned(),
        }
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

/// The derivation of where the ray meets an object; empty where a number is missing.
pub fn derivation(object: &ObjectExplanation) -> Vec<Line<'_>> {
    lines(object).unwrap_or_default()
}

fn lines(object: &ObjectExplanation) -> Option<Vec<Line<'_>>> {
    let number = |symbol| object.exact(symbol).map(|exact| &exact.short);
    // Plain text says it in words.
    let behind = if object.reason == Reason::Behind { r" \le 0" } else { "" };
    Some(match &object.terms {
        Terms::Sphere {
            center,
            radius,
            offset,
            squares,
            products,
            offset_squared,
            radius_squared,
        } => {
            let (a, b, k, d) = (number("a")?, number("b")?, number("k")?, number("D")?);
            let sign = match object.exact("D")?.signum {
                -1 => " < 0",
                1 => " > 0",
                _ => "",
            };
            let mut lines = vec![
                Line::new("c ~ #", r"\vec{c} &~ #", [Vector(center)]),
                Line::new(", r ~ #", r", \quad r ~ #", [Plain(radius)]),
                Line::new("o − c ~ #", r"\vec{o} - \vec{c} &~ #", [Vector(offset)]),
                Line::new(
                    "a = d·d ~ # ~ #",
                    r"a &= \vec{d} \cdot \vec{d} ~ # ~ #",
                    [Sum(squares), Plain(a)],
                ),
                Line::new(
                    "b = 2·d·(o − c) ~ 2·(#) ~ #",
                    r"b &= 2\,\vec{d} \cdot (\vec{o} - \vec{c}) ~ 2\,(#) ~ #",
                    [Sum(products), Plain(b)],
                ),
                Line::new(
                    "k = (o − c)·(o − c) − r² ~ # − # ~ #",
                    r"k &= (\vec{o} - \vec{c}) \cdot (\vec{o} - \vec{c}) - r^2 ~ # - # ~ #",
                    [Plain(offset_squared), Plain(radius_squared), Plain(k)],
                ),
                Line::new(
                    "D = b² − 4·a·k ~ #² − 4·#·# ~ #",
                    format!(r"D &= b^2 - 4ak ~ #^2 - 4 \cdot # \cdot # ~ #{sign}"),
                    [Factor(b), Factor(a), Factor(k), Plain(d)],
                ),
            ];
            if let Some((near, far)) = number("t₁").zip(number("t₂")) {
                let latex = |index, roots| {
                    let fraction = r"\frac{-b \pm \sqrt{D}}{2a} ~ \frac{# \pm \sqrt{#}}{2 \cdot #}";
                    format!(r"t{index} &= {fraction} ~ {roots}{behind}")
                };
                lines.push(match d.text.as_str() {
                    "0" => Line::new(
                        "t = (−b ± √D) / (2·a) ~ (# ± √#) / (2·#) ~ #",
                        latex("", "#"),
                        [Negated(b), Plain(d), Factor(a), Plain(near)],
                    ),
                    _ => Line::new(
                        "t = (−b ± √D) / (2·a) ~ (# ± √#) / (2·#) ~ # and #",
                        latex("_{1,2}", r"#,\ #"),
                        [Negated(b), Plain(d), Factor(a), Plain(near), Plain(far)],
                    ),
                });
            }
            lines
        }
        Terms::Plane { point, normal, offset, numerator, denominator } => {
            let (above, below) = (number("(a−o)·n")?, number("d·n")?);
            let mut lines = vec![
                Line::new("a ~ #", r"\vec{a} &~ #", [Vector(point)]),
                Line::new("n ~ #", r", \quad \vec{n} ~ #", [Vector(normal)]),
                Line::new("a − o ~ #", r"\vec{a} - \vec{o} &~ #", [Vector(offset)]),
                Line::new(
                    "(a − o)·n ~ # ~ #",
                    r"(\vec{a} - \vec{o}) \cdot \vec{n} &~ # ~ #",
                    [Sum(numerator), Plain(above)],
                ),
                Line::new(
                    "d·n ~ # ~ #",
                    r"\vec{d} \cdot \vec{n} &~ # ~ #",
                    [Sum(denominator), Plain(below)],
                ),
            ];
            if let Some(t) = number("t") {
                let fraction = r"\frac{(\vec{a} - \vec{o}) \cdot \vec{n}}{\vec{d} \cdot \vec{n}}";
                lines.push(Line::new(
                    "t = ((a − o)·n) / (d·n) ~ # / # ~ #",
                    format!(r"t &= {fraction} ~ \frac{{#}}{{#}} ~ #{behind}"),
                    [Plain(above), Divisor(below), Plain(t)],
                ));
            }
            lines
        }
    })
}

/// The point that a ray sees.
pub fn of_point(point: &PointExplanation) -> Vec<Line<'_>> {
    let PointExplanation { at, normal, residual, is_on_sphere, .. } = point;
    vec![
        Line::new("p = o + t·d ~ #", r"\vec{p} &= \vec{o} + t\,\vec{d} ~ #", [Vector(at)]),
        match is_on_sphere {
            true => Line::new(
                "f(p) = (p − c)·(p − c) − r² ~ #",
                r"f(\vec{p}) &= (\vec{p} - \vec{c}) \cdot (\vec{p} - \vec{c}) - r^2 ~ #",
                [Plain(residual)],
            ),
            false => Line::new(
                "f(p) = (p − a)·n ~ #",
                r"f(\vec{p}) &= (\vec{p} - \vec{a}) \cdot \vec{n} ~ #",
                [Plain(residual)],
            ),
        },
        Line::new("n ~ #", r"\vec{n} &~ #", [Vector(normal)]),
    ]
}

/// The way to a light, and what it gives; empty for one that gives none.
pub fn of_light(light: &LightExplanation) -> Vec<Line<'_>> {
    let Some(WayTerms { way, form, cosine, root, gives }) = &light.terms else {
        return Vec::new();
    };
    let cosine_latex = r"\vec{n} \cdot \vec{\omega} &= \frac{\vec{n} \cdot \vec{w}}{|\vec{w}|} ~ #";
    let mut lines = vec![
        Line::new(form[0], form[1], [Vector(way)]),
        Line::new("n·ω = n·w / |w| ~ #", cosine_latex, [Plain(cosine)]),
    ];
    if let Some(root) = root {
        lines.push(Line::new(", s ~ #", r", \quad s ~ #", [Plain(root)]));
    }
    if let Some([strength, given]) = gives {
        lines.push(Line::new(
            "I·n·ω ~ #·# ~ #",
            r"I\,\vec{n} \cdot \vec{\omega} &~ # \cdot # ~ #",
            [Vector(strength), Factor(cosine), Vector(given)],
        ));
    }
    lines
}

/// The channels of a colour as sums of light; empty where no light falls on it.
pub fn of_color(color: &ColorExplanation) -> Vec<Line<'_>> {
    let Some(channels) = &color.terms else { return Vec::new() };
    let text = [
        "red = color × (ambient + Σ I·n·ω) ~ #·(# + #) ~ #",
        "green = color × (ambient + Σ I·n·ω) ~ #·(# + #) ~ #",
        "blue = color × (ambient + Σ I·n·ω) ~ #·(# + #) ~ #",
    ];
    let lines = text.into_iter().zip(&color.channels).zip(channels);
    lines
        .map(|((text, channel), [color, ambient, sum, value])| {
            let latex = format!(
                r"\mathrm{{{}}} &= c\,(a + \textstyle\sum I\,\vec{{n}} \cdot \vec{{\omega}}) ~ # \cdot (# + #) ~ #",
                channel.name
            );
            Line::new(text, latex, [Factor(color), Plain(ambient), Plain(sum), Plain(value)])
        })
        .collect()
}
