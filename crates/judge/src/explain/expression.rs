//! Formulas as trees, written in plain text and in LaTeX.

use Notation::{Latex, Text};
use Precedence::{Factor, Product, Sum, Whole};

use super::numbers::Short;

/// A way to write formulas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// Plain text.
    Text,
    /// LaTeX: names as text, formulas in math mode.
    Latex,
}

impl Notation {
    /// Writes a number; in LaTeX, `1.5e-7` is a power of ten.
    pub fn number(self, number: &str) -> String {
        match number.split_once('e') {
            Some((mantissa, exponent)) if self == Latex => {
                format!(r"{mantissa} \cdot 10^{{{exponent}}}")
            }
            _ => number.to_owned(),
        }
    }

    /// Writes words and names, without anything that LaTeX would take for a command.
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

    /// Returns the text of this notation.
    fn choose<'t>(self, text: &'t str, latex: &'t str) -> &'t str {
        match self {
            Text => text,
            Latex => latex,
        }
    }

    /// Writes a piece of a formula between words.
    pub fn formula(self, formula: &str) -> String {
        if self == Text {
            return formula.to_owned();
        }
        let translated = |c: char| match c {
            '·' => r" \cdot ".into(),
            '×' => r" \times ".into(),
            '±' => r"\pm".into(),
            '≈' => r"\approx".into(),
            '−' => "-".into(),
            '²' => "^2".into(),
            'ω' => r"\vec{\omega}".into(),
            '₁' => "_1".into(),
            '₂' => "_2".into(),
            'd' | 'n' | 'o' | 'p' => format!(r"\vec{{{c}}}"),
            other => other.into(),
        };
        formula.chars().map(translated).collect()
    }

    /// Writes the letter of a number or of a vector; `I`, which is both, has no arrow.
    fn letter(self, name: &str, is_vector: bool) -> String {
        match self {
            Latex if is_vector && name.len() > 1 => {
                format!(r"\overrightarrow{{\text{{{}}}}}", self.name(name))
            }
            Latex if is_vector && name != "I" => format!(r"\vec{{{name}}}"),
            _ => self.formula(name),
        }
    }
}

/// A formula.
#[derive(Clone, Debug)]
pub enum Expression {
    /// A formula that has its own text in each notation.
    Written {
        /// Plain text of the formula.
        text: String,
        /// LaTeX of the formula.
        latex: String,
    },
    /// The letter of a number or of a vector.
    Letter {
        /// The letter, or a name.
        name: &'static str,
        /// Whether it is the letter of a vector.
        is_vector: bool,
    },
    /// A rounded number.
    Number(Short),
    /// A vector of rounded numbers.
    Vector(Vec<Short>),
    /// `−x`
    Negative(Box<Expression>),
    /// `√x`
    Root(Box<Expression>),
    /// `|v|`
    Length(Box<Expression>),
    /// A sum or a difference.
    Sum(Box<[Expression; 2]>, Sign),
    /// `x²`
    Square(Box<Expression>),
    /// A product of two numbers, or of a number and a vector.
    Product {
        /// The factors.
        factors: Box<[Expression; 2]>,
        /// Whether LaTeX writes it without a sign, as it does between letters.
        is_in_letters: bool,
    },
    /// The dot product of two vectors.
    Dot(Box<[Expression; 2]>),
    /// A quotient.
    Quotient(Box<[Expression; 2]>),
}

/// The sign between the terms of a sum.
#[derive(Clone, Copy, Debug)]
pub enum Sign {
    /// `+`
    Plus,
    /// `−`
    Minus,
    /// `±`, for both roots of the quadratic formula.
    PlusMinus,
}

/// Binding strength of a written expression, which decides about parentheses.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Precedence {
    Sum,
    Product,
    Factor,
    Whole,
}

impl Expression {
    /// Returns a number, or a vector of several.
    pub fn of_numbers(numbers: Vec<Short>) -> Expression {
        match <[Short; 1]>::try_from(numbers) {
            Ok([number]) => Expression::Number(number),
            Err(numbers) => Expression::Vector(numbers),
        }
    }

    /// Whether a number in it is rounded.
    pub fn is_rounded(&self) -> bool {
        match self {
            Expression::Written { .. } | Expression::Letter { .. } => false,
            Expression::Number(number) => number.rounded,
            Expression::Vector(numbers) => numbers.iter().any(|number| number.rounded),
            Expression::Negative(x)
            | Expression::Root(x)
            | Expression::Length(x)
            | Expression::Square(x) => x.is_rounded(),
            Expression::Sum(parts, _)
            | Expression::Product { factors: parts, .. }
            | Expression::Dot(parts)
            | Expression::Quotient(parts) => parts.iter().any(Expression::is_rounded),
        }
    }

    /// Writes the terms of the outermost sum, each but the first with its `+` in front.
    pub fn terms(&self, notation: Notation) -> Vec<String> {
        match self {
            Expression::Sum(parts, sign) => {
                let [left, right] = &**parts;
                let mut terms = left.terms(notation);
                let written =
                    |sign: &str, right: &str| format!(" {} {right}", notation.formula(sign));
                let minus = match sign {
                    Sign::Plus => {
                        let mut right = right.terms(notation);
                        right[0] = written("+", &right[0]);
                        terms.append(&mut right);
                        return terms;
                    }
                    Sign::Minus => "−",
                    Sign::PlusMinus => "±",
                };
                let right = match right {
                    // Needs no parentheses: the number is not negative.
                    Expression::Number(number) => notation.number(&number.text),
                    other => other.within(notation, Product),
                };
                let last = terms.len() - 1;
                terms[last] += &written(minus, &right);
                terms
            }
            other => vec![other.written(notation).0],
        }
    }

    /// Writes the expression, in parentheses if it binds less closely than `rank`.
    fn within(&self, notation: Notation, rank: Precedence) -> String {
        let (text, own) = self.written(notation);
        if own < rank { format!("({text})") } else { text }
    }

    fn written(&self, notation: Notation) -> (String, Precedence) {
        let within = |x: &Expression, rank| x.within(notation, rank);
        let alone = |x: &Expression| x.written(notation).0;
        let [times, minus, square] = ["·", "−", "²"].map(|sign| notation.formula(sign));
        match self {
            Expression::Written { text, latex } => (notation.choose(text, latex).into(), Whole),
            Expression::Letter { name, is_vector } => (notation.letter(name, *is_vector), Whole),
            Expression::Number(number) => {
                let is_product = notation == Latex && number.text.contains('e');
                let is_whole = !number.text.starts_with('-') && !is_product;
                (notation.number(&number.text), if is_whole { Whole } else { Sum })
            }
            Expression::Vector(numbers) => {
                let numbers = numbers.iter().map(|number| notation.number(&number.text));
                let all = numbers.collect::<Vec<_>>().join(notation.choose(", ", r",\ "));
                (format!("({all})"), Whole)
            }
            Expression::Negative(x) => (minus + &within(x, Product), Sum),
            Expression::Root(x) => match notation {
                Text => (format!("√{}", within(x, Whole)), Whole),
                Latex => (format!(r"\sqrt{{{}}}", alone(x)), Whole),
            },
            Expression::Length(vector) => (format!("|{}|", alone(vector)), Whole),
            Expression::Sum(..) => (self.terms(notation).concat(), Sum),
            Expression::Square(x) => (within(x, Whole) + &square, Factor),
            Expression::Product { factors, is_in_letters } => {
                let [left, right] = &**factors;
                let (left, right) = (within(left, Product), within(right, Factor));
                let times = match notation {
                    Latex if *is_in_letters && right.len() > 1 => r"\,",
                    Latex if *is_in_letters => "",
                    _ => &times,
                };
                (left + times + &right, Product)
            }
            Expression::Dot(vectors) => {
                let [left, right] = vectors.each_ref().map(|vector| within(vector, Factor));
                (left + &times + &right, Factor)
            }
            Expression::Quotient(parts) => {
                let [numerator, denominator] = &**parts;
                if notation == Latex {
                    let [numerator, denominator] = [alone(numerator), alone(denominator)];
                    return (format!(r"\frac{{{numerator}}}{{{denominator}}}"), Product);
                }
                let is_number = matches!(numerator, Expression::Number(_));
                let numerator = within(numerator, if is_number { Sum } else { Product });
                (numerator + " / " + &within(denominator, Whole), Product)
            }
        }
    }
}
