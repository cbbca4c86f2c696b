//! The text of a function: which values have a line of their own, and what is in brackets.

use std::collections::HashMap;

use super::names::names;
use super::{AXES, NODES, Node, Op, Printed};

/// A number, or three that are a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Value {
    One(u32),
    Three([u32; 3]),
}

impl Value {
    /// The last node that it is made of.
    fn last(self) -> u32 {
        match self {
            Value::One(node) => node,
            Value::Three([.., z]) => z,
        }
    }
}

/// The function whose result this is, of all that was calculated since the last one.
pub fn finish<T: Printed>(name: &str, arguments: &[(&str, String)], result: &T) -> String {
    let nodes = &NODES.take();
    let mut printer = Printer { nodes, names: names(nodes), uses: HashMap::new() };
    let mut all = Vec::new();
    result.print(&mut |value| {
        printer.count(value, &mut all);
        String::new()
    });
    all.retain(|&value| printer.has_line(value));
    all.sort_by_key(|value| value.last());
    let with_types: Vec<String> =
        arguments.iter().map(|(name, kind)| format!("{name}: {kind}")).collect();
    let mut text = format!("fn {name}({}) -> {} {{\n", with_types.join(", "), T::type_name());
    // How often each name is taken.
    let mut taken: HashMap<String, usize> =
        arguments.iter().map(|&(name, _)| (name.to_string(), 1)).collect();
    for value in all {
        let wanted = printer.names.get(&value.last()).cloned().unwrap_or("v".into());
        let n = taken.entry(wanted.clone()).or_default();
        *n += 1;
        let name = if *n == 1 { wanted } else { format!("{wanted}_{n}") };
        text += &line(&format!("let {name} = {};", printer.text(value, 0, true)));
        printer.names.insert(value.last(), name);
    }
    let result = result.print(&mut |value| printer.text(value, 0, false));
    text + &line(&format!("return {result};")) + "}\n\n"
}

/// A statement, broken where it is too long: before a sign or an argument, in as few brackets as can be.
fn line(statement: &str) -> String {
    const WIDTH: usize = 96;
    let (mut text, mut rest, mut indent) = (String::new(), statement, 4);
    while indent + rest.len() > WIDTH {
        let (mut depth, mut best) = (0, (usize::MAX, WIDTH));
        for (at, sign) in rest[..WIDTH - indent].char_indices() {
            let is_place = sign == ' '
                && (rest[..at].ends_with(',')
                    || rest[at + 1..].starts_with(['+', '-', '*', '/', '&', '|']));
            match sign {
                '(' => depth += 1,
                ')' => depth -= 1,
                _ if is_place && depth <= best.0 => best = (depth, at),
                _ => {}
            }
        }
        let (now, later) = rest.split_at(best.1);
        text += &format!("{:indent$}{now}\n", "");
        (rest, indent) = (later.trim_start(), 8);
    }
    format!("{text}{:indent$}{rest}\n", "")
}

struct Printer<'a> {
    nodes: &'a [Node],
    /// Names of values, by the values' last nodes.
    names: HashMap<u32, String>,
    uses: HashMap<Value, usize>,
}

impl Printer<'_> {
    fn node(&self, at: u32) -> &Node {
        &self.nodes[at as usize]
    }

    /// What a value is made of, and its text where it is a leaf.
    fn parts(&self, value: Value) -> (Op, Vec<Value>, String) {
        let ones = |nodes: &[u32]| nodes.iter().copied().map(Value::One).collect();
        match value {
            Value::One(at) => match self.dot(at) {
                Some(vectors) => {
                    (Op::Call("dot3"), vectors.map(Value::Three).into(), String::new())
                }
                None => {
                    let Node { op, operands, text, .. } = self.node(at);
                    (*op, ones(operands), text.clone())
                }
            },
            Value::Three(all) => {
                let [x, y, z] = all.map(|at| self.node(at));
                let path = x.text.strip_suffix(".x").unwrap_or_default();
                let mut axes = [x, y, z].into_iter().zip(AXES);
                if x.op == Op::Leaf
                    && axes.all(|(node, axis)| node.text == format!("{path}.{axis}"))
                {
                    return (Op::Leaf, Vec::new(), path.into());
                }
                if all == [all[0]; 3] {
                    return (Op::Call("vec3f"), ones(&all[..1]), String::new());
                }
                if x.op == Op::Leaf || x.op != y.op || y.op != z.op {
                    return (Op::Call("vec3f"), ones(&all), String::new());
                }
                let of_axes = |at: usize| [x, y, z].map(|node| node.operands[at]);
                // Arithmetic takes a number for a vector, and a choice takes one truth.
                let takes_one = |at| match x.op {
                    Op::Call(name) => name == "select" && at == 2,
                    Op::Infix(_, rank) => rank > 2,
                    _ => true,
                };
                let operands = (0..x.operands.len()).map(|at| match of_axes(at) {
                    [a, b, c] if a == b && b == c && takes_one(at) => Value::One(a),
                    three => Value::Three(three),
                });
                (x.op, operands.collect(), String::new())
            }
        }
    }

    /// The vectors of a number that is `(a·x + b·y) + c·z`.
    fn dot(&self, at: u32) -> Option<[[u32; 3]; 2]> {
        let both = |at: u32, sign: &str| match self.node(at) {
            Node { op: Op::Infix(known, _), operands, .. } if *known == sign => {
                Some([operands[0], operands[1]])
            }
            _ => None,
        };
        let [sum, last] = both(at, "+")?;
        let [first, second] = both(sum, "+")?;
        let [[a, x], [b, y], [c, z]] = [both(first, "*")?, both(second, "*")?, both(last, "*")?];
        Some([[a, b, c], [x, y, z]])
    }

    fn count(&mut self, value: Value, all: &mut Vec<Value>) {
        let uses = self.uses.entry(value).or_insert(0);
        *uses += 1;
        if *uses == 1 {
            all.push(value);
            for part in self.parts(value).1 {
                self.count(part, all);
            }
        }
    }

    /// Whether a value has a `let` of its own.
    fn has_line(&self, value: Value) -> bool {
        let (op, parts, _) = self.parts(value);
        let is_small = match op {
            Op::Leaf | Op::Call("vec3f") => true,
            Op::Prefix(_) => self.parts(parts[0]).0 == Op::Leaf,
            _ => false,
        };
        !is_small && (self.uses[&value] > 1 || self.names.contains_key(&value.last()))
    }

    /// A value within an operation that binds as closely as `outer`.
    fn text(&self, value: Value, outer: u8, is_line: bool) -> String {
        if !is_line && self.has_line(value) {
            return self.names[&value.last()].clone();
        }
        let (op, parts, leaf) = self.parts(value);
        match op {
            Op::Leaf => leaf,
            Op::Prefix(sign) => format!("{sign}{}", self.text(parts[0], 5, false)),
            Op::Call(name) => {
                let parts: Vec<_> = parts.iter().map(|&part| self.text(part, 0, false)).collect();
                format!("{name}({})", parts.join(", "))
            }
            Op::Infix(sign, rank) => {
                // What is on the right keeps its brackets: the order of rounding is the formula's. WGSL asks for them in logic.
                let [left, right] = if rank == 1 { [5, 5] } else { [rank, rank + 1] };
                let [left, right] = [(0, left), (1, right)]
                    .map(|(part, outer)| self.text(parts[part], outer, false));
                let text = format!("{left} {sign} {right}");
                if rank < outer { format!("({text})") } else { text }
            }
        }
    }
}
