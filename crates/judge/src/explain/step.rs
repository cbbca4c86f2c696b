//! The number that remembers: a formula that runs with it gives its exact value, and can be written down, in letters and with
//! numbers put in. So the lecture's derivations are the functions that the kernels run.

use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Neg, Sub};

use kugelblitz::exact::{Root, exact};
use kugelblitz::num::{Real, V3};

use super::calculator::Calculator as _;
use super::line::Notation;
use super::numbers::{MANY_DIGITS, Short};

/// A number of the derivation that this thread is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step(u32);

/// What a number is made by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Op {
    Given,
    Add,
    Sub,
    Mul,
    Div,
    Neg,
    Sqrt,
    /// The dot product of two vectors.
    Dot,
}

#[derive(Clone, Debug)]
struct Node {
    op: Op,
    operands: [Step; 2],
    value: Root,
    /// The letter that stands for it, if one does.
    name: &'static str,
    /// True for what has a line before: its number stands in the lines that follow.
    is_told: bool,
}

thread_local! {
    static NODES: RefCell<Vec<Node>> = const { RefCell::new(Vec::new()) };
}

/// Forgets all numbers: a derivation begins.
pub fn begin() {
    NODES.with_borrow_mut(Vec::clear);
}

/// A number with a letter.
pub fn number(name: &'static str, value: Root) -> Step {
    let step = given(value);
    tell(&[step], name);
    step
}

/// A number of the scene with a letter.
pub fn of_scene(name: &'static str, x: f64) -> Step {
    number(name, Root::from(exact(x)))
}

/// Three numbers of the scene with a letter.
pub fn vector_of_scene(name: &'static str, v: impl Into<[f64; 3]>) -> V3<Step> {
    V3(v.into().map(|x| of_scene(name, x)))
}

/// Three numbers with a letter.
pub fn vector(name: &'static str, values: [Root; 3]) -> V3<Step> {
    V3(values.map(|value| number(name, value)))
}

/// From now on the letter, if there is one, and the number stand for these.
pub fn tell(steps: &[Step], name: &'static str) {
    NODES.with_borrow_mut(|nodes| {
        for step in steps {
            let node = &mut nodes[step.0 as usize];
            node.is_told = true;
            if !name.is_empty() {
                node.name = name;
            }
        }
    });
}

fn given(value: Root) -> Step {
    put(Op::Given, [Step(u32::MAX); 2], || value)
}

/// What is calculated twice is one number.
fn put(op: Op, operands: [Step; 2], value: impl FnOnce() -> Root) -> Step {
    let is_it = |node: &Node| op != Op::Given && node.op == op && node.operands == operands;
    if let Some(at) = NODES.with_borrow(|nodes| nodes.iter().position(is_it)) {
        return Step(at as u32);
    }
    let node = Node { op, operands, value: value(), name: "", is_told: false };
    NODES.with_borrow_mut(|nodes| {
        nodes.push(node);
        Step(nodes.len() as u32 - 1)
    })
}

impl Op {
    fn of(self, x: &Root, y: Root) -> Root {
        match self {
            Op::Add => x.plus(&y),
            Op::Sub => x.plus(&y.negated()),
            Op::Mul => x.times(&y),
            Op::Div => x.over(&y),
            Op::Neg => x.clone().negated(),
            Op::Sqrt => x.sqrt(),
            Op::Given | Op::Dot => x.clone(),
        }
    }
}

impl Step {
    fn node<T>(self, of: impl FnOnce(&Node) -> T) -> T {
        NODES.with_borrow(|nodes| of(&nodes[self.0 as usize]))
    }

    /// The exact number; where no square root tells it, one that nothing here tells from it.
    pub fn value(self) -> Root {
        self.node(|node| node.value.clone())
    }

    /// -1, 0 or 1.
    pub fn signum(self) -> i32 {
        self.node(|node| node.value.signum())
    }

    fn then(self, op: Op, other: Step) -> Step {
        put(op, [self, other], || op.of(&self.value(), other.value()))
    }

    fn both(self, op: Op) -> Option<[Step; 2]> {
        self.node(|node| (node.op == op).then_some(node.operands))
    }

    /// The vectors of a number that is `(a·x + b·y) + c·z`.
    fn dot(self) -> Option<[V3<Step>; 2]> {
        let [sum, last] = self.both(Op::Add)?;
        let [first, second] = sum.both(Op::Add)?;
        let [[a, x], [b, y], [c, z]] =
            [first.both(Op::Mul)?, second.both(Op::Mul)?, last.both(Op::Mul)?];
        Some([V3([a, b, c]), V3([x, y, z])])
    }

    /// What is added up in it.
    pub fn addends(self) -> Vec<Step> {
        let (op, operands) = self.node(|node| (node.op, node.operands));
        match (self.dot(), op) {
            (Some([u, v]), _) => u.times(v).0.into(),
            (_, Op::Add | Op::Sub) => operands.into(),
            (_, Op::Mul) => operands[1].addends(),
            _ => Vec::new(),
        }
    }
}

macro_rules! operators {
    ($($trait:ident $function:ident)*) => {$(
        impl $trait for Step {
            type Output = Step;
            fn $function(self, other: Step) -> Step {
                self.then(Op::$trait, other)
            }
        }
    )*};
}
operators! { Add add Sub sub Mul mul Div div }

impl Neg for Step {
    type Output = Step;
    fn neg(self) -> Step {
        self.then(Op::Neg, self)
    }
}

impl Real for Step {
    type One = f64;
    type Mask = bool;
    type Id = u32;

    fn splat(x: f64) -> Step {
        given(Root::from(exact(x)))
    }
    fn splat_id(id: u32) -> u32 {
        id
    }
    fn sqrt(self) -> Step {
        self.then(Op::Sqrt, self)
    }
    fn abs(self) -> Step {
        if self.signum() < 0 { -self } else { self }
    }
    fn lt(self, other: Step) -> bool {
        self.value() < other.value()
    }
    fn le(self, other: Step) -> bool {
        self.value() <= other.value()
    }
    fn select(mask: bool, yes: Step, no: Step) -> Step {
        if mask { yes } else { no }
    }
    fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
        if mask { yes } else { no }
    }
}

/// What a number or a vector is made of, and by what; in letters a scalar product is one.
fn parts(steps: &[Step], in_letters: bool) -> (Op, [Vec<Step>; 2]) {
    if let [step] = steps
        && in_letters
        && let Some(vectors) = step.dot()
    {
        return (Op::Dot, vectors.map(|V3(steps)| steps.to_vec()));
    }
    let part = |at: usize| {
        let mut part: Vec<Step> =
            steps.iter().map(|step| step.node(|node| node.operands[at])).collect();
        if part.iter().all(|step| *step == part[0]) {
            part.truncate(1);
        }
        part
    };
    (common(steps, |node| node.op).unwrap_or(Op::Given), [part(0), part(1)])
}

/// What is said of each of these, if that is the same.
fn common<T: PartialEq>(steps: &[Step], of: impl Fn(&Node) -> T) -> Option<T> {
    let first = steps[0].node(&of);
    steps.iter().all(|step| step.node(&of) == first).then_some(first)
}

/// How closely what is written holds together.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Rank {
    Sum,
    Product,
    Factor,
    Whole,
}
use Rank::{Factor, Product, Sum, Whole};

/// The numbers that stand in an expression, rounded.
#[derive(Clone, Copy)]
pub struct Rounding<'a> {
    pub digits: usize,
    /// Numbers that stand in the expression beside what is told or given.
    pub addends: &'a [Step],
}

impl Rounding<'_> {
    fn stands(&self, step: Step) -> bool {
        self.addends.contains(&step) || step.node(|node| node.is_told || node.op == Op::Given)
    }

    /// What a calculator makes of an expression.
    pub fn calculated(&self, step: Step) -> Root {
        if self.stands(step) {
            let is_constant = step.node(|node| node.op == Op::Given && node.name.is_empty());
            let digits = if is_constant { MANY_DIGITS } else { self.digits };
            return Root::parse(&step.value().to_decimal(digits)).unwrap_or_else(|| step.value());
        }
        let (op, [x, y]) = step.node(|node| (node.op, node.operands));
        op.of(&self.calculated(x), self.calculated(y))
    }
}

/// A number or a vector as an expression, and whether a number in it is rounded: in letters, or with numbers put in.
pub fn written(
    notation: Notation,
    value: &[Step],
    numbers: Option<Rounding<'_>>,
) -> (String, bool) {
    let writer = Writer { notation, numbers, is_rounded: Cell::new(false) };
    (writer.written(value), writer.is_rounded.get())
}

struct Writer<'a> {
    notation: Notation,
    numbers: Option<Rounding<'a>>,
    /// True once a number was rounded.
    is_rounded: Cell<bool>,
}

impl Writer<'_> {
    fn written(&self, value: &[Step]) -> String {
        self.expression(value).0
    }

    fn is_latex(&self) -> bool {
        self.notation == Notation::Latex
    }

    /// In parentheses where it holds together less than is asked for.
    fn within(&self, value: &[Step], rank: Rank) -> String {
        let (text, found) = self.expression(value);
        if found < rank { format!("({text})") } else { text }
    }

    /// A number; one that stands in letters is a constant of one digit.
    fn number(&self, root: &Root) -> (String, Rank) {
        let short = Short::new(root, self.numbers.map_or(1, |numbers| numbers.digits));
        self.is_rounded.set(self.is_rounded.get() | short.rounded);
        let is_product = self.is_latex() && short.text.contains('e');
        let is_whole = !short.text.starts_with('-') && !is_product;
        (self.notation.number(&short.text), if is_whole { Whole } else { Sum })
    }

    /// The number that stands for an expression, if one does.
    fn standing(&self, value: &[Step]) -> Option<Root> {
        let (Some(numbers), [step]) = (self.numbers, value) else { return None };
        numbers.stands(*step).then(|| step.value())
    }

    fn expression(&self, value: &[Step]) -> (String, Rank) {
        match (self.numbers, common(value, |node| node.name).unwrap_or_default()) {
            (None, name) if !name.is_empty() => {
                return (self.notation.letter(name, value.len() > 1), Whole);
            }
            (Some(numbers), _) if numbers.stands(value[0]) => {
                let written: Vec<_> = value.iter().map(|step| self.number(&step.value())).collect();
                let rank = if let [(_, rank)] = written[..] { rank } else { Whole };
                return (self.notation.tuple(written.into_iter().map(|(text, _)| text)), rank);
            }
            _ => {}
        }
        let [times, minus, square] = ["·", "−", "²"].map(|sign| self.notation.formula(sign));
        let (op, [x, y]) = parts(value, self.numbers.is_none());
        let (x, y) = (&*x, &*y);
        match op {
            Op::Given => self.number(&value[0].value()),
            Op::Neg => match self.standing(x) {
                Some(root) => self.number(&root.negated()),
                None => (minus + &self.within(x, Product), Sum),
            },
            Op::Sqrt => (self.root(x), Whole),
            Op::Add | Op::Sub => (self.sum(x, y, op == Op::Sub), Sum),
            Op::Dot => (self.within(x, Factor) + &times + &self.within(y, Factor), Factor),
            Op::Mul if x == y => (self.within(x, Whole) + &square, Factor),
            Op::Mul => {
                let (left, right) = (self.within(x, Product), self.within(y, Factor));
                let times = match self.numbers {
                    None if self.is_latex() && right.len() > 1 => r"\,",
                    None if self.is_latex() => "",
                    _ => &times,
                };
                (left + times + &right, Product)
            }
            Op::Div if self.is_latex() => {
                (format!(r"\frac{{{}}}{{{}}}", self.written(x), self.written(y)), Product)
            }
            Op::Div => {
                let rank = if self.standing(x).is_some() { Sum } else { Product };
                (self.within(x, rank) + " / " + &self.within(y, Whole), Product)
            }
        }
    }

    /// A square root; in letters that of a square is a length.
    fn root(&self, x: &[Step]) -> String {
        match (parts(x, self.numbers.is_none()), self.is_latex()) {
            ((Op::Dot, [vector, _]), _) => format!("|{}|", self.written(&vector)),
            (_, true) => format!(r"\sqrt{{{}}}", self.written(x)),
            (_, false) => format!("√{}", self.within(x, Whole)),
        }
    }

    /// A sum or a difference. The one with a root is that of the quadratic formula, and stands for both.
    fn sum(&self, x: &[Step], y: &[Step], is_difference: bool) -> String {
        let left = self.within(x, Sum);
        let (sign, right) = match self.standing(y) {
            Some(root) => {
                let is_negative = root.signum() < 0;
                let sign = if is_negative != is_difference { "−" } else { "+" };
                (sign, self.number(&root.magnitude()).0)
            }
            None if !is_difference => ("+", self.within(y, Sum)),
            None if parts(y, false).0 == Op::Sqrt => ("±", self.within(y, Product)),
            None => ("−", self.within(y, Product)),
        };
        format!("{left} {} {right}", self.notation.formula(sign))
    }
}
