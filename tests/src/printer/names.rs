//! The names that a source gives to numbers: by `let`, or as fields. A wrong guess is a wrong name, and never another number.

use std::collections::HashMap;

use super::Node;
use crate::text_of;

/// A place in a source where a value gets a name.
struct Binding {
    name: String,
    is_field: bool,
    from: usize,
    to: usize,
}

/// The names of nodes, by their places.
pub(super) fn names(nodes: &[Node]) -> HashMap<u32, String> {
    let mut sources = HashMap::new();
    for node in nodes {
        let file = node.place.file();
        sources.entry(file).or_insert_with(|| Source::new(&text_of(file)));
    }
    // Of each node the bindings that it is in, from the innermost one, and whether it is in no brackets of that.
    let around = |node: &Node| sources[node.place.file()].around(node);
    let (around, mut is_named): (Vec<Vec<&Binding>>, Vec<bool>) = nodes.iter().map(around).unzip();
    // What goes on in the same place is not yet what has the name.
    for (at, node) in nodes.iter().enumerate() {
        for &operand in &node.operands {
            let inner = around[operand as usize].first();
            is_named[operand as usize] &= !around[at]
                .iter()
                .any(|binding| inner.is_some_and(|inner| std::ptr::eq(*binding, *inner)));
        }
    }
    let name = |around: &Vec<&Binding>| {
        let n_fields = around.iter().take_while(|binding| binding.is_field).count().max(1);
        let names: Vec<&str> =
            around[..n_fields].iter().rev().map(|binding| &*binding.name).collect();
        names.join("_")
    };
    (0..)
        .zip(&around)
        .filter(|&(at, _)| is_named[at as usize])
        .map(|(at, around)| (at, name(around)))
        .collect()
}

struct Source {
    /// Without comments, at the same places, and a byte a character, as columns count them.
    plain: String,
    /// Where each line begins.
    lines: Vec<usize>,
    bindings: Vec<Binding>,
}

impl Source {
    fn new(text: &str) -> Source {
        let (mut lines, mut plain) = (Vec::new(), String::new());
        for line in text.lines() {
            lines.push(plain.len());
            let code = line.split("//").next().unwrap_or_default();
            plain.extend(code.chars().map(|c| if c.is_ascii() { c } else { '_' }));
            plain += "\n";
        }
        let bindings = bindings(&plain);
        Source { plain, lines, bindings }
    }

    fn around(&self, node: &Node) -> (Vec<&Binding>, bool) {
        let at = self.lines[node.place.line() as usize - 1] + node.place.column() as usize - 1;
        let mut around: Vec<&Binding> = self
            .bindings
            .iter()
            .filter(|binding| (binding.from..binding.to).contains(&at))
            .collect();
        around.sort_by_key(|binding| binding.to - binding.from);
        let begins = around.first().is_some_and(|binding| {
            let before = &self.plain[binding.from..at];
            before.matches(['(', '[', '{']).count() == before.matches([')', ']', '}']).count()
        });
        (around, begins)
    }
}

/// Each `let name = …`, `let (name, name) = (…, …)` and `name: …` of a source.
fn bindings(plain: &str) -> Vec<Binding> {
    let mut bindings = Vec::new();
    let signs = plain.match_indices(['=', ':']);
    for (at, sign) in signs.filter(|&(at, _)| plain[at + 1..].starts_with([' ', '\n'])) {
        let (before, is_field) = (plain[..at].trim_end(), sign == ":");
        let pattern = before.rsplit_once("let ").map(|(_, pattern)| pattern);
        let names: Vec<&str> = match pattern {
            _ if is_field => {
                let name = before.rsplit(|c: char| !c.is_alphanumeric() && c != '_').take(1);
                // No type.
                name.filter(|name| name.starts_with(|c: char| c.is_ascii_lowercase())).collect()
            }
            Some(pattern) if !pattern.contains([';', '{', '}', '=']) => {
                pattern.trim_matches(['(', ')', '[', ']']).split(", ").collect()
            }
            _ => continue,
        };
        let mut from = at + 2 + usize::from(names.len() > 1);
        for name in names {
            let to = from + end(&plain[from..]);
            bindings.push(Binding { name: name.into(), is_field, from, to });
            from = to + 1;
        }
    }
    bindings
}

/// Where an expression ends.
fn end(text: &str) -> usize {
    let mut depth = 0;
    for (at, sign) in text.bytes().enumerate() {
        match sign {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' if depth == 0 => return at,
            b')' | b']' | b'}' => depth -= 1,
            b',' | b';' if depth == 0 => return at,
            _ => {}
        }
    }
    text.len()
}
