//! The lecture's formulas with numbers put in: each line once, in both notations.

use Term::{Divisor, Factor, Negated, Plain, Products, Squares, Sum, Vector};

use super::decimal::{Decimal, integer, sqrt};
use super::line::{Expression, Line, Term, expression, vector_expression};
use super::numbers::Short;
use crate::exact::Root;

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
