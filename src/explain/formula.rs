//! The lecture's formulas with numbers put in: each line once, in both notations.
//!
//! A line is a chain: a formula, expressions with numbers in them, the result. Each expression has as
//! many digits as it takes to get the result from it with a calculator.

use std::array;

use Notation::{Latex, Text};
use Term::{Divisor, Factor, Negated, Plain, Products, Squares, Sum, Vector};

use super::decimal::{Decimal, digits_for, integer, sqrt};
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
    terms: Vec<Term<Root>>,
    value: fn(&[Decimal]) -> Vec<Decimal>,
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
    fn chain(
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

    fn joined(self) -> Line {
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

/// Where a ray begins and goes.
pub fn of_ray([o, d]: [[Short; 3]; 2]) -> Vec<Line> {
    vec![
        Line::given("o ~ #", r"\vec{o} ~ #", [Vector(o)]),
        Line::given("d ~ #", r"\vec{d} ~ #", [Vector(d)]).joined(),
    ]
}

/// The exact numbers of a ray and a sphere, on the way to the roots.
pub struct SphereSteps {
    /// As the scene has them.
    pub given: ([Short; 3], Short),
    pub origin: [Root; 3],
    pub direction: [Root; 3],
    pub center: [Root; 3],
    pub radius: Root,
    /// `o − c`
    pub offset: [Root; 3],
    /// `dᵢ·(oᵢ − cᵢ)`
    pub products: [Root; 3],
    /// `(o − c)·(o − c)` and `−r²`
    pub parts_of_k: [Root; 2],
    /// `b²` and `−4ak`
    pub parts_of_d: [Root; 2],
    pub a: Root,
    pub b: Root,
    pub k: Root,
    pub discriminant: Root,
    pub roots: Option<[Root; 2]>,
}

/// The derivation of where a ray meets a sphere.
pub fn of_sphere(steps: SphereSteps, digits: usize) -> Vec<Line> {
    let SphereSteps { given: (center, radius), a, b, k, discriminant: d, .. } = &steps;
    let offset = &steps.offset;
    let sign = match d.signum() {
        -1 => " < 0",
        1 => " > 0",
        _ => "",
    };
    let mut lines = vec![
        Line::given("c ~ #", r"\vec{c} ~ #", [Vector(center.clone())]),
        Line::given("r ~ #", "r ~ #", [Plain(radius.clone())]).joined(),
        difference(
            ("o − c ~ # − # ~ #", r"\vec{o} - \vec{c} ~ # - # ~ #"),
            [&steps.origin, &steps.center, offset],
            digits,
        ),
        Line::chain(
            ("a = d·d ~ # ~ #", r"a = \vec{d} \cdot \vec{d} ~ # ~ #"),
            [squares(&steps.direction)],
            &[Plain(a.clone())],
            digits,
        ),
        Line::chain(
            (
                "b = 2·d·(o − c) ~ 2·(#) ~ 2·(#) ~ #",
                r"b = 2\,\vec{d} \cdot (\vec{o} - \vec{c}) ~ 2\,(#) ~ 2\,(#) ~ #",
            ),
            [
                expression!([Products(steps.direction.clone(), offset.clone())], |v| {
                    integer(2) * dot(v)
                }),
                expression!([Sum(steps.products.to_vec())], |v| integer(2) * sum(v)),
            ],
            &[Plain(b.clone())],
            digits,
        ),
        Line::chain(
            (
                "k = (o − c)·(o − c) − r² ~ # − #² ~ # ~ #",
                r"k = (\vec{o} - \vec{c}) \cdot (\vec{o} - \vec{c}) - r^2 ~ # - #^2 ~ # ~ #",
            ),
            [
                expression!([Squares(offset.clone()), Factor(steps.radius.clone())], |v| {
                    norm_squared(v) - &v[3] * &v[3]
                }),
                expression!([Sum(steps.parts_of_k.to_vec())], |v| sum(v)),
            ],
            &[Plain(k.clone())],
            digits,
        ),
        Line::chain(
            (
                "D = b² − 4·a·k ~ #² − 4·#·# ~ # ~ #",
                format!(r"D = b^2 - 4ak ~ #^2 - 4 \cdot # \cdot # ~ # ~ #{sign}"),
            ),
            [
                expression!([Factor(b.clone()), Factor(a.clone()), Factor(k.clone())], |v| {
                    &v[0] * &v[0] - integer(4) * &v[1] * &v[2]
                }),
                expression!([Sum(steps.parts_of_d.to_vec())], |v| sum(v)),
            ],
            &[Plain(d.clone())],
            digits,
        ),
    ];
    let Some([near, far]) = &steps.roots else { return lines };
    let latex = r"t = \frac{-b \pm \sqrt{D}}{2a} ~ \frac{# \pm \sqrt{#}}{2 \cdot #}";
    let terms = [Negated(b.clone()), Plain(d.clone()), Factor(a.clone())];
    if d.signum() == 0 {
        lines.push(Line::chain(
            ("t = (−b ± √D) / (2·a) ~ (# ± √#) / (2·#) ~ #", format!("{latex} ~ #")),
            [expression!(terms, |v| -&v[0] / (integer(2) * &v[2]))],
            &[Plain(near.clone())],
            digits,
        ));
        return lines;
    }
    lines.push(Line::chain(
        ("t = (−b ± √D) / (2·a) ~ (# ± √#) / (2·#)", latex),
        [Expression {
            terms: terms.into(),
            value: |v| {
                let (half_width, divisor) = (sqrt(&v[1]), integer(2) * &v[2]);
                vec![(-&v[0] - &half_width) / &divisor, (half_width - &v[0]) / &divisor]
            },
        }],
        &[Plain(near.clone()), Plain(far.clone())],
        digits,
    ));
    let root = |root: &Root| [Plain(Short::new(root, digits))];
    lines.push(Line::given("t₁ ~ #", "t_1 ~ #", root(near)).joined());
    lines.push(Line::given("t₂ ~ #", "t_2 ~ #", root(far)).joined());
    lines
}

/// The exact numbers of a ray and a plane, on the way to the root.
pub struct PlaneSteps {
    /// As the scene has them.
    pub given: [[Short; 3]; 2],
    pub origin: [Root; 3],
    pub direction: [Root; 3],
    pub point: [Root; 3],
    pub normal: [Root; 3],
    /// `a − o`
    pub offset: [Root; 3],
    /// `(aᵢ − oᵢ)·nᵢ`
    pub numerator_products: [Root; 3],
    /// `dᵢ·nᵢ`
    pub denominator_products: [Root; 3],
    pub numerator: Root,
    pub denominator: Root,
    pub root: Option<Root>,
}

/// The derivation of where a ray meets a plane.
pub fn of_plane(steps: PlaneSteps, digits: usize) -> Vec<Line> {
    let PlaneSteps { given: [point, normal], numerator: above, denominator: below, .. } = &steps;
    let product = |forms, [left, right, products]: [&[Root; 3]; 3], result: &Root| {
        let expressions = [
            expression!([Products(left.clone(), right.clone())], |v| dot(v)),
            expression!([Sum(products.to_vec())], |v| sum(v)),
        ];
        Line::chain(forms, expressions, &[Plain(result.clone())], digits)
    };
    let mut lines = vec![
        Line::given("a ~ #", r"\vec{a} ~ #", [Vector(point.clone())]),
        Line::given("n ~ #", r"\vec{n} ~ #", [Vector(normal.clone())]).joined(),
        difference(
            ("a − o ~ # − # ~ #", r"\vec{a} - \vec{o} ~ # - # ~ #"),
            [&steps.point, &steps.origin, &steps.offset],
            digits,
        ),
        product(
            ("(a − o)·n ~ # ~ # ~ #", r"(\vec{a} - \vec{o}) \cdot \vec{n} ~ # ~ # ~ #"),
            [&steps.offset, &steps.normal, &steps.numerator_products],
            above,
        ),
        product(
            ("d·n ~ # ~ # ~ #", r"\vec{d} \cdot \vec{n} ~ # ~ # ~ #"),
            [&steps.direction, &steps.normal, &steps.denominator_products],
            below,
        ),
    ];
    if let Some(root) = &steps.root {
        let fraction = r"\frac{(\vec{a} - \vec{o}) \cdot \vec{n}}{\vec{d} \cdot \vec{n}}";
        lines.push(Line::chain(
            (
                "t = ((a − o)·n) / (d·n) ~ # / # ~ #",
                format!(r"t = {fraction} ~ \frac{{#}}{{#}} ~ #"),
            ),
            [expression!([Plain(above.clone()), Divisor(below.clone())], |v| &v[0] / &v[1])],
            &[Plain(root.clone())],
            digits,
        ));
    }
    lines
}

/// The exact numbers of the point that a ray sees.
pub struct PointSteps {
    pub origin: [Root; 3],
    pub direction: [Root; 3],
    pub t: Root,
    pub at: [Root; 3],
    /// The centre of the sphere or the point of the plane, and `p` from there.
    pub base: [Root; 3],
    pub from_base: [Root; 3],
    pub surface: Surface,
    /// `f(p)`
    pub residual: Root,
    /// The unit normal that faces the ray, and whether it is the one inward or on the back.
    pub normal: [Root; 3],
    pub is_turned: bool,
}

/// What the point is on.
pub enum Surface {
    /// A sphere of this radius.
    Sphere(Root),
    /// A plane with this normal, of this length.
    Plane(Box<[Root; 3]>, Root),
}

/// The point that a ray sees, `f(p)`, and the unit normal.
pub fn of_point(steps: PointSteps, digits: usize) -> Vec<Line> {
    let PointSteps { origin, direction, t, at, base, from_base, residual, normal, .. } = &steps;
    let terms = [Vector(origin.clone()), Factor(t.clone()), Vector(direction.clone())];
    let mut lines = vec![Line::chain(
        ("p = o + t·d ~ # + #·# ~ #", r"\vec{p} = \vec{o} + t\,\vec{d} ~ # + # \cdot # ~ #"),
        [vector_expression!(terms, |v, axis| &v[axis] + &v[3] * &v[4 + axis])],
        &[Vector(at.clone())],
        digits,
    )];
    let (quotient, divisor) = match &steps.surface {
        Surface::Sphere(radius) => {
            let forms = ("p − c ~ # − # ~ #", r"\vec{p} - \vec{c} ~ # - # ~ #");
            lines.push(difference(forms, [at, base, from_base], digits));
            let terms = [Squares(from_base.clone()), Factor(radius.clone())];
            lines.push(Line::chain(
                (
                    "f(p) = (p − c)·(p − c) − r² ~ # − #² ~ #",
                    r"f(\vec{p}) = (\vec{p} - \vec{c}) \cdot (\vec{p} - \vec{c}) - r^2 ~ # - #^2 ~ #",
                ),
                [expression!(terms, |v| norm_squared(v) - &v[3] * &v[3])],
                &[Plain(residual.clone())],
                digits,
            ));
            (vec![Vector(from_base.clone()), Divisor(radius.clone())], radius)
        }
        Surface::Plane(of_plane, length) => {
            let forms = ("p − a ~ # − # ~ #", r"\vec{p} - \vec{a} ~ # - # ~ #");
            lines.push(difference(forms, [at, base, from_base], digits));
            let terms = [Products(from_base.clone(), (**of_plane).clone())];
            lines.push(Line::chain(
                (
                    "f(p) = (p − a)·n ~ # ~ #",
                    r"f(\vec{p}) = (\vec{p} - \vec{a}) \cdot \vec{n} ~ # ~ #",
                ),
                [expression!(terms, |v| dot(v))],
                &[Plain(residual.clone())],
                digits,
            ));
            (vec![Vector((**of_plane).clone()), Divisor(length.clone())], length)
        }
    };
    debug_assert!(divisor.signum() > 0);
    let is_sphere = matches!(steps.surface, Surface::Sphere(_));
    let forms = match (is_sphere, steps.is_turned) {
        (true, false) => (
            "n = (p − c) / r ~ # / # ~ #",
            r"\vec{n} = \frac{\vec{p} - \vec{c}}{r} ~ \frac{#}{#} ~ #",
        ),
        (true, true) => (
            "n = −(p − c) / r ~ −# / # ~ #",
            r"\vec{n} = -\frac{\vec{p} - \vec{c}}{r} ~ -\frac{#}{#} ~ #",
        ),
        (false, false) => ("n / |n| ~ # / # ~ #", r"\frac{\vec{n}}{|\vec{n}|} ~ \frac{#}{#} ~ #"),
        (false, true) => {
            ("−n / |n| ~ −# / # ~ #", r"-\frac{\vec{n}}{|\vec{n}|} ~ -\frac{#}{#} ~ #")
        }
    };
    let value: fn(&[Decimal]) -> Vec<Decimal> = match steps.is_turned {
        false => |v| (0..3).map(|axis| &v[axis] / &v[3]).collect(),
        true => |v| (0..3).map(|axis| -&v[axis] / &v[3]).collect(),
    };
    let expression = Expression { terms: quotient, value };
    lines.push(Line::chain(forms, [expression], &[Vector(normal.clone())], digits));
    lines
}

/// The exact numbers of the way to a light.
pub struct WaySteps {
    /// The unit normal that faces the ray.
    pub normal: [Root; 3],
    pub way: [Root; 3],
    pub from: WayFrom,
    /// `n·ω`
    pub cosine: Root,
    /// `s` of what is in the way.
    pub root: Option<Root>,
    /// `I` and what the light gives, where it counts.
    pub gives: Option<[[Root; 3]; 2]>,
}

/// How `w` comes about.
pub enum WayFrom {
    /// `l − p`
    Point([Root; 3], [Root; 3]),
    /// `o − p`
    Eye([Root; 3], [Root; 3]),
    /// `−l`
    Sun,
    /// `−d`
    Axis,
}

/// The way to a light, and what it gives.
pub fn of_light(steps: WaySteps, digits: usize) -> Vec<Line> {
    let WaySteps { normal, way, cosine, .. } = &steps;
    let given = |text, latex| {
        Line::given(text, latex, [Vector(way.each_ref().map(|x| Short::new(x, digits)))])
    };
    let mut lines = vec![match &steps.from {
        WayFrom::Point(light, point) => difference(
            ("w = l − p ~ # − # ~ #", r"\vec{w} = \vec{l} - \vec{p} ~ # - # ~ #"),
            [light, point, way],
            digits,
        ),
        WayFrom::Eye(origin, point) => difference(
            ("w = o − p ~ # − # ~ #", r"\vec{w} = \vec{o} - \vec{p} ~ # - # ~ #"),
            [origin, point, way],
            digits,
        ),
        WayFrom::Sun => given("w = −l ~ #", r"\vec{w} = -\vec{l} ~ #"),
        WayFrom::Axis => given("w = −d ~ #", r"\vec{w} = -\vec{d} ~ #"),
    }];
    if way.iter().any(|component| component.signum() != 0) {
        lines.push(Line::chain(
            (
                "n·ω = n·w / |w| ~ (#) / √(#) ~ #",
                r"\vec{n} \cdot \vec{\omega} = \frac{\vec{n} \cdot \vec{w}}{|\vec{w}|} ~ \frac{#}{\sqrt{#}} ~ #",
            ),
            [expression!([Products(normal.clone(), way.clone()), Squares(way.clone())], |v| {
                dot(v) / sqrt(&norm_squared(&v[6..]))
            })],
            &[Plain(cosine.clone())],
            digits,
        ));
    }
    if let Some(root) = &steps.root {
        lines.push(Line::given("s ~ #", "s ~ #", [Plain(Short::new(root, digits))]).joined());
    }
    if let Some([strength, given]) = &steps.gives {
        let terms = [Vector(strength.clone()), Factor(cosine.clone())];
        lines.push(Line::chain(
            ("I·n·ω ~ #·# ~ #", r"I\,\vec{n} \cdot \vec{\omega} ~ # \cdot # ~ #"),
            [vector_expression!(terms, |v, axis| &v[axis] * &v[3])],
            &[Vector(given.clone())],
            digits,
        ));
    }
    lines
}

/// A channel of a colour: that of the object, ambient light, the sum of all other, and the result.
pub fn of_channel(
    (text, name): (&'static str, &str),
    [color, ambient, sum_of_lights, value]: [Root; 4],
    digits: usize,
) -> Line {
    let latex = format!(
        r"\text{{{name}}} = c\,(a + \textstyle\sum I\,\vec{{n}} \cdot \vec{{\omega}}) ~ # \cdot (# + #) ~ #"
    );
    let terms = [Factor(color), Plain(ambient), Plain(sum_of_lights)];
    let expression = expression!(terms, |v| &v[0] * (&v[1] + &v[2]));
    Line::chain((text, latex), [expression], &[Plain(value)], digits)
}

/// `x − y`, and what it is.
fn difference(forms: (&'static str, &str), [x, y, result]: [&[Root; 3]; 3], digits: usize) -> Line {
    let terms = [Vector(x.clone()), Vector(y.clone())];
    let expression = vector_expression!(terms, |v, axis| &v[axis] - &v[3 + axis]);
    Line::chain(forms, [expression], &[Vector(result.clone())], digits)
}

fn squares(v: &[Root; 3]) -> Expression {
    expression!([Squares(v.clone())], |v| norm_squared(v))
}

fn norm_squared(v: &[Decimal]) -> Decimal {
    &v[0] * &v[0] + &v[1] * &v[1] + &v[2] * &v[2]
}

fn dot(v: &[Decimal]) -> Decimal {
    &v[0] * &v[3] + &v[1] * &v[4] + &v[2] * &v[5]
}

fn sum(v: &[Decimal]) -> Decimal {
    v.iter().fold(integer(0), |sum, x| sum + x)
}
