//! A number that records its formula: a formula of a kernel that runs with it yields an exact value, and the
//! [`Expression`] of each result. So the derivations of the lecture are the functions that the kernels run.

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use kugelblitz::exact::{QuadraticSurd, exact};
use kugelblitz::num::{Real, V3};

use super::calculator::Calculator as _;
use super::expression::{Expression, Sign};
use super::numbers::{MANY_DIGITS, Short};

/// The numbers of a derivation, in the order of calculation.
#[derive(Debug, Default)]
pub struct Tape {
    entries: RefCell<Vec<TapeEntry>>,
}

/// A number of a formula.
#[derive(Clone, Copy, Debug)]
pub enum Step<'t> {
    /// A constant of the formula. Two constants are combined in f64.
    Constant(f64),
    /// A number on a tape, by its index.
    Recorded(&'t Tape, usize),
}

/// Operation that calculates a number from its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Op {
    /// Not at all.
    Given,
    /// Not at all: it is part of the formula.
    Constant,
    Add,
    Sub,
    Mul,
    Div,
    Neg,
    Sqrt,
    /// Dot product of two vectors.
    Dot,
}

#[derive(Clone, Debug)]
struct TapeEntry {
    op: Op,
    /// Indices of the operands, if the operation has any.
    operands: [usize; 2],
    value: QuadraticSurd,
    /// Letter of the number; empty if there is none.
    name: &'static str,
    /// Whether an earlier line shows the number, which then replaces its formula.
    is_shown: bool,
}

impl TapeEntry {
    fn new(op: Op, operands: [usize; 2], value: QuadraticSurd) -> TapeEntry {
        TapeEntry { op, operands, value, name: "", is_shown: false }
    }

    fn constant(x: f64) -> TapeEntry {
        TapeEntry::new(Op::Constant, [0; 2], QuadraticSurd::from(exact(x)))
    }
}

impl Tape {
    /// Records a number with a letter.
    pub fn number(&self, name: &'static str, value: QuadraticSurd) -> Step<'_> {
        let step = Step::Recorded(self, self.push(TapeEntry::new(Op::Given, [0; 2], value)));
        show(&[step], name);
        step
    }

    /// Records a number of the scene with a letter.
    pub fn of_scene(&self, name: &'static str, x: f64) -> Step<'_> {
        self.number(name, QuadraticSurd::from(exact(x)))
    }

    /// Records three numbers of the scene with a letter.
    pub fn vector_of_scene(&self, name: &'static str, v: impl Into<[f64; 3]>) -> V3<Step<'_>> {
        V3(v.into().map(|x| self.of_scene(name, x)))
    }

    /// Records three numbers with a letter.
    pub fn vector(&self, name: &'static str, values: [QuadraticSurd; 3]) -> V3<Step<'_>> {
        V3(values.map(|value| self.number(name, value)))
    }

    fn push(&self, entry: TapeEntry) -> usize {
        let mut entries = self.entries.borrow_mut();
        entries.push(entry);
        entries.len() - 1
    }

    fn position(&self, is_it: impl Fn(&TapeEntry) -> bool) -> Option<usize> {
        self.entries.borrow().iter().position(is_it)
    }

    /// Records the result of an operation, once for equal operands.
    fn calculate(&self, op: Op, operands: [Step; 2]) -> Step<'_> {
        let places = operands.map(|operand| match operand {
            Step::Recorded(_, place) => place,
            Step::Constant(x) => {
                let constant = TapeEntry::constant(x);
                let is_it =
                    |entry: &TapeEntry| entry.op == Op::Constant && entry.value == constant.value;
                self.position(is_it).unwrap_or_else(|| self.push(constant))
            }
        });
        let known = self.position(|entry| entry.op == op && entry.operands == places);
        let place = known.unwrap_or_else(|| {
            let [x, y] = operands.map(Step::value);
            self.push(TapeEntry::new(op, places, op.of(&x, y)))
        });
        Step::Recorded(self, place)
    }
}

/// Marks numbers as shown: from now on, their values and the letter, unless it is empty, replace their formulas.
pub fn show(steps: &[Step], name: &'static str) {
    for step in steps {
        if let Step::Recorded(tape, place) = step {
            let entry = &mut tape.entries.borrow_mut()[*place];
            entry.is_shown = true;
            if !name.is_empty() {
                entry.name = name;
            }
        }
    }
}

impl Op {
    fn of(self, x: &QuadraticSurd, y: QuadraticSurd) -> QuadraticSurd {
        match self {
            Op::Add => x.plus(&y),
            Op::Sub => x.plus(&y.negated()),
            Op::Mul => x.times(&y),
            Op::Div => x.over(&y),
            Op::Neg => x.clone().negated(),
            Op::Sqrt => x.sqrt(),
            Op::Given | Op::Constant | Op::Dot => x.clone(),
        }
    }
}

/// Compares numbers of one tape by their places, not by their values.
impl PartialEq for Step<'_> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Step::Constant(x), Step::Constant(y)) => x == y,
            (Step::Recorded(_, x), Step::Recorded(_, y)) => x == y,
            _ => false,
        }
    }
}

impl<'t> Step<'t> {
    fn entry<T>(self, of: impl FnOnce(&TapeEntry) -> T) -> T {
        match self {
            Step::Constant(x) => of(&TapeEntry::constant(x)),
            Step::Recorded(tape, place) => of(&tape.entries.borrow()[place]),
        }
    }

    /// Returns the exact number; if it is no [`QuadraticSurd`], one with an error that no explanation shows.
    pub fn value(self) -> QuadraticSurd {
        self.entry(|entry| entry.value.clone())
    }

    /// Returns the sign: -1, 0 or 1.
    pub fn signum(self) -> i32 {
        self.entry(|entry| entry.value.signum())
    }

    fn operands(self) -> [Step<'t>; 2] {
        match self {
            Step::Constant(_) => [self; 2],
            Step::Recorded(tape, _) => {
                self.entry(|entry| entry.operands.map(|place| Step::Recorded(tape, place)))
            }
        }
    }

    fn op(self) -> Op {
        self.entry(|entry| entry.op)
    }

    /// Returns the operands of this operation, if it is the one of the number.
    fn operands_of(self, op: Op) -> Option<[Step<'t>; 2]> {
        (self.op() == op).then(|| self.operands())
    }

    /// Returns the vectors of a number that is `(a·x + b·y) + c·z`.
    fn dot(self) -> Option<[V3<Step<'t>>; 2]> {
        let [sum, last] = self.operands_of(Op::Add)?;
        let [first, second] = sum.operands_of(Op::Add)?;
        let [[a, x], [b, y], [c, z]] =
            [first.operands_of(Op::Mul)?, second.operands_of(Op::Mul)?, last.operands_of(Op::Mul)?];
        Some([V3([a, b, c]), V3([x, y, z])])
    }

    /// Returns the terms of its sum.
    pub fn addends(self) -> Vec<Step<'t>> {
        match (self.dot(), self.op()) {
            (Some([u, v]), _) => u.times(v).0.into(),
            (_, Op::Add | Op::Sub) => self.operands().into(),
            (_, Op::Mul) => self.operands()[1].addends(),
            _ => Vec::new(),
        }
    }
}

macro_rules! operators {
    ($($trait:ident $function:ident $sign:tt)*) => {$(
        impl<'t> $trait for Step<'t> {
            type Output = Step<'t>;
            fn $function(self, other: Step<'t>) -> Step<'t> {
                match (self, other) {
                    (Step::Constant(x), Step::Constant(y)) => Step::Constant(x $sign y),
                    (Step::Recorded(tape, _), _) | (_, Step::Recorded(tape, _)) => {
                        tape.calculate(Op::$trait, [self, other])
                    }
                }
            }
        }
    )*};
}
operators! { Add add + Sub sub - Mul mul * Div div / }

impl<'t> Neg for Step<'t> {
    type Output = Step<'t>;
    fn neg(self) -> Step<'t> {
        match self {
            Step::Constant(x) => Step::Constant(-x),
            Step::Recorded(tape, _) => tape.calculate(Op::Neg, [self; 2]),
        }
    }
}

impl Real for Step<'_> {
    type One = f64;
    type Mask = bool;
    type Id = u32;

    fn splat(x: f64) -> Self {
        Step::Constant(x)
    }
    fn splat_id(id: u32) -> u32 {
        id
    }
    fn sqrt(self) -> Self {
        match self {
            Step::Constant(x) => Step::Constant(x.sqrt()),
            Step::Recorded(tape, _) => tape.calculate(Op::Sqrt, [self; 2]),
        }
    }
    fn abs(self) -> Self {
        if self.signum() < 0 { -self } else { self }
    }
    fn lt(self, other: Self) -> bool {
        self.value() < other.value()
    }
    fn le(self, other: Self) -> bool {
        self.value() <= other.value()
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
        if mask { yes } else { no }
    }
}

/// Returns the operation and the operands of a number or a vector; in letters, a dot product is one operation.
fn parts<'t>(steps: &[Step<'t>], in_letters: bool) -> (Op, [Vec<Step<'t>>; 2]) {
    if let [step] = steps
        && in_letters
        && let Some(vectors) = step.dot()
    {
        return (Op::Dot, vectors.map(|V3(steps)| steps.to_vec()));
    }
    let part = |at: usize| {
        let mut part: Vec<Step> = steps.iter().map(|step| step.operands()[at]).collect();
        if part.iter().all(|step| *step == part[0]) {
            part.truncate(1);
        }
        part
    };
    (common(steps, |entry| entry.op).unwrap_or(Op::Given), [part(0), part(1)])
}

/// Returns a property of these numbers, if all have the same.
fn common<T: PartialEq>(steps: &[Step], of: impl Fn(&TapeEntry) -> T) -> Option<T> {
    let first = steps[0].entry(&of);
    steps.iter().all(|step| step.entry(&of) == first).then_some(first)
}

/// The numbers in an expression, rounded.
#[derive(Clone, Copy)]
pub struct Rounding<'a> {
    /// Significant digits of the numbers.
    pub digits: usize,
    /// Numbers that replace their formulas, besides those that are shown or given.
    pub addends: &'a [Step<'a>],
}

impl Rounding<'_> {
    /// Whether the number replaces its formula.
    fn replaces(&self, step: Step) -> bool {
        let is_known =
            |entry: &TapeEntry| entry.is_shown || matches!(entry.op, Op::Given | Op::Constant);
        self.addends.contains(&step) || step.entry(is_known)
    }

    /// Returns the result of a calculator that evaluates the expression.
    pub fn calculated(&self, step: Step) -> QuadraticSurd {
        if self.replaces(step) {
            let digits = if step.op() == Op::Constant { MANY_DIGITS } else { self.digits };
            return QuadraticSurd::parse(&step.value().to_decimal(digits))
                .unwrap_or_else(|| step.value());
        }
        let [x, y] = step.operands();
        step.op().of(&self.calculated(x), self.calculated(y))
    }
}

/// Returns the expression of a number or a vector: in letters, or with `numbers` put in.
pub fn expression(value: &[Step], numbers: Option<Rounding>) -> Expression {
    let name = common(value, |entry| entry.name).unwrap_or_default();
    // A number in a formula in letters is a constant of one digit.
    let short =
        |root: &QuadraticSurd| Short::new(root, numbers.map_or(1, |numbers| numbers.digits));
    let replacement = |value: &[Step]| match (numbers, value) {
        (Some(numbers), [step]) => numbers.replaces(*step).then(|| step.value()),
        _ => None,
    };
    match numbers {
        None if !name.is_empty() => {
            return Expression::Letter { name, is_vector: value.len() > 1 };
        }
        Some(numbers) if numbers.replaces(value[0]) => {
            let shorts = value.iter().map(|step| short(&step.value()));
            return Expression::of_numbers(shorts.collect());
        }
        _ => {}
    }
    let (op, [x, y]) = parts(value, numbers.is_none());
    let one = |part: &[Step]| Box::new(expression(part, numbers));
    let both = || Box::new([expression(&x, numbers), expression(&y, numbers)]);
    match op {
        Op::Given | Op::Constant => Expression::Number(short(&value[0].value())),
        Op::Neg => match replacement(&x) {
            Some(root) => Expression::Number(short(&root.negated())),
            None => Expression::Negative(one(&x)),
        },
        // In letters, the root of a square is a length.
        Op::Sqrt => match parts(&x, numbers.is_none()) {
            (Op::Dot, [vector, _]) => Expression::Length(one(&vector)),
            _ => Expression::Root(one(&x)),
        },
        Op::Add | Op::Sub => match replacement(&y) {
            Some(root) => {
                let is_minus = (root.signum() < 0) != (op == Op::Sub);
                let right = Expression::Number(short(&root.magnitude()));
                let sign = if is_minus { Sign::Minus } else { Sign::Plus };
                Expression::Sum(Box::new([expression(&x, numbers), right]), sign)
            }
            None if op == Op::Add => Expression::Sum(both(), Sign::Plus),
            // The difference with a root is the quadratic formula, and represents both roots.
            None if parts(&y, false).0 == Op::Sqrt => Expression::Sum(both(), Sign::PlusMinus),
            None => Expression::Sum(both(), Sign::Minus),
        },
        Op::Dot => Expression::Dot(both()),
        Op::Mul if x == y => Expression::Square(one(&x)),
        Op::Mul => Expression::Product { factors: both(), is_in_letters: numbers.is_none() },
        Op::Div => Expression::Quotient(both()),
    }
}
