//! Python literals in the headers of `.npy` files: strings, whole numbers, `True` and `False`, tuples, lists and dictionaries.

use std::io;

use super::invalid;
use crate::plain::Shown;

/// A literal and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Literal {
    /// Column of the first character in the header, from 1.
    pub place: usize,
    pub value: LiteralValue,
}

/// Value of a literal.
#[derive(Clone, Debug, PartialEq)]
pub enum LiteralValue {
    Bool(bool),
    Int(i128),
    Text(String),
    /// A tuple or a list.
    Sequence(Vec<Literal>),
    Dict(Vec<(String, Literal)>),
}

/// Deepest nesting. A record within a record adds two levels.
const MAX_DEPTH: usize = 32;

/// Parses a text that contains one literal, and nothing but white space around it.
///
/// # Errors
/// `InvalidData` contains the place, the literal expected there, and the text found.
pub fn parse(text: &str) -> io::Result<Literal> {
    let mut parser = Parser { rest: text, place: 1 };
    let literal = parser.literal(0)?;
    parser.skip_space();
    if parser.rest.is_empty() { Ok(literal) } else { Err(parser.wrong("the end of the header")) }
}

/// Returns the error for a header with `found` instead of `expected`.
fn wrong(place: usize, expected: &str, found: &str) -> io::Error {
    invalid(format!("its header, character {place}: expected {expected}, found {found}"))
}

impl Literal {
    /// Returns the error for a literal of another kind or with an unexpected value.
    pub fn wrong(&self, expected: &str) -> io::Error {
        let short = |item: &Literal| match &item.value {
            LiteralValue::Bool(true) => Some("True".into()),
            LiteralValue::Bool(false) => Some("False".into()),
            LiteralValue::Int(number) => Some(number.to_string()),
            LiteralValue::Text(text) => Some(format!("'{}'", text.shown())),
            LiteralValue::Sequence(_) | LiteralValue::Dict(_) => None,
        };
        let found = match &self.value {
            LiteralValue::Sequence(items) if items.len() <= 4 => items
                .iter()
                .map(short)
                .collect::<Option<Vec<_>>>()
                .map_or("a nested tuple or list".into(), |items| format!("({})", items.join(", "))),
            LiteralValue::Sequence(items) => format!("a tuple or list of {} items", items.len()),
            _ => short(self).map_or("a dictionary".into(), |found| format!("`{found}`")),
        };
        wrong(self.place, expected, &found)
    }

    /// Returns the items of a tuple or list.
    ///
    /// # Errors
    /// `InvalidData` for any other literal.
    pub fn items(&self, expected: &str) -> io::Result<&[Literal]> {
        match &self.value {
            LiteralValue::Sequence(items) => Ok(items),
            _ => Err(self.wrong(expected)),
        }
    }
}

/// Text that is being parsed.
struct Parser<'t> {
    rest: &'t str,
    /// The first character of `rest`, counted from 1.
    place: usize,
}

impl<'t> Parser<'t> {
    fn peek(&self) -> Option<char> {
        self.rest.chars().next()
    }

    fn next(&mut self) -> Option<char> {
        let mut chars = self.rest.chars();
        let next = chars.next()?;
        self.rest = chars.as_str();
        self.place += 1;
        Some(next)
    }

    /// Skips white space, then `sign` if it is next.
    fn skip(&mut self, sign: char) -> bool {
        self.skip_space();
        let is_next = self.peek() == Some(sign);
        if is_next {
            self.next();
        }
        is_next
    }

    fn skip_space(&mut self) {
        while self.peek().is_some_and(|sign| " \t\n\r".contains(sign)) {
            self.next();
        }
    }

    /// Returns the characters from here on that `is_part` accepts, and skips them.
    fn take(&mut self, is_part: fn(char) -> bool) -> &'t str {
        let whole = self.rest;
        while self.peek().is_some_and(is_part) {
            self.next();
        }
        &whole[..whole.len() - self.rest.len()]
    }

    /// Returns the error for a text that has something else here.
    fn wrong(&self, expected: &str) -> io::Error {
        let found = self.peek().map_or("the end of the header".into(), |sign| {
            format!("`{}`", sign.to_string().shown())
        });
        wrong(self.place, expected, &found)
    }

    fn literal(&mut self, depth: usize) -> io::Result<Literal> {
        self.skip_space();
        let place = self.place;
        if depth > MAX_DEPTH {
            return Err(
                self.wrong(&format!("at most {MAX_DEPTH} nested tuples, lists and dictionaries"))
            );
        }
        let value = match self.peek() {
            Some('(' | '[') => self.sequence(depth)?,
            Some('{') => self.dict(depth)?,
            Some('\'' | '"') => LiteralValue::Text(self.text()?),
            Some(sign) if sign == '-' || sign.is_ascii_digit() => LiteralValue::Int(self.int()?),
            Some(sign) if sign.is_ascii_alphabetic() => LiteralValue::Bool(self.bool()?),
            _ => return Err(self.wrong("a Python literal")),
        };
        Ok(Literal { place, value })
    }

    /// Parses a tuple, a list, or a literal in parentheses.
    fn sequence(&mut self, depth: usize) -> io::Result<LiteralValue> {
        let is_tuple = self.next() == Some('(');
        let close = if is_tuple { ')' } else { ']' };
        let mut items = Vec::new();
        let mut has_comma = false;
        while !self.skip(close) {
            if !items.is_empty() && !has_comma {
                return Err(self.wrong(&format!("`,` or `{close}`")));
            }
            items.push(self.literal(depth + 1)?);
            has_comma = self.skip(',');
        }
        Ok(match (is_tuple && !has_comma, items.len()) {
            (true, 1) => items.remove(0).value,
            _ => LiteralValue::Sequence(items),
        })
    }

    fn dict(&mut self, depth: usize) -> io::Result<LiteralValue> {
        self.next();
        let mut entries: Vec<(String, Literal)> = Vec::new();
        let mut has_comma = true;
        while !self.skip('}') {
            if !has_comma {
                return Err(self.wrong("`,` or `}`"));
            }
            if !matches!(self.peek(), Some('\'' | '"')) {
                return Err(self.wrong("a key in quotes"));
            }
            let place = self.place;
            let key = self.text()?;
            if entries.iter().any(|(known, _)| *known == key) {
                return Err(wrong(place, "each key once", &format!("'{}' again", key.shown())));
            }
            if !self.skip(':') {
                return Err(self.wrong("`:`"));
            }
            entries.push((key, self.literal(depth + 1)?));
            has_comma = self.skip(',');
        }
        Ok(LiteralValue::Dict(entries))
    }

    /// Parses a string in single or double quotes.
    fn text(&mut self) -> io::Result<String> {
        let quote = self.next();
        let mut text = String::new();
        loop {
            let place = self.place;
            match self.next() {
                None => return Err(self.wrong("the end of a string")),
                sign if sign == quote => return Ok(text),
                Some('\\') => text.push(self.escaped(place)?),
                Some(sign) => text.push(sign),
            }
        }
    }

    /// Parses the part of an escape sequence after its backslash, which is at `place`.
    fn escaped(&mut self, place: usize) -> io::Result<char> {
        let start = self.rest;
        let code = |n_digits: usize| {
            let digits = start.get(1..=n_digits)?;
            let is_hex = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
            is_hex.then(|| u32::from_str_radix(digits, 16).ok()).flatten().and_then(char::from_u32)
        };
        let (sign, n_digits) = match self.next() {
            Some(sign @ ('\\' | '\'' | '"')) => (Some(sign), 0),
            Some('n') => (Some('\n'), 0),
            Some('r') => (Some('\r'), 0),
            Some('t') => (Some('\t'), 0),
            Some('x') => (code(2), 2),
            Some('u') => (code(4), 4),
            Some('U') => (code(8), 8),
            _ => (None, 0),
        };
        let found = || format!("`\\{}`", start.chars().next().unwrap_or(' ').to_string().shown());
        let sign = sign.ok_or_else(|| wrong(place, "an escape sequence of Python", &found()))?;
        for _ in 0..n_digits {
            self.next();
        }
        Ok(sign)
    }

    /// Parses a whole number in decimal digits. Python 2 wrote an `L` after long ones.
    fn int(&mut self) -> io::Result<i128> {
        let place = self.place;
        let whole = self.rest;
        self.take(|sign| sign == '-' || sign.is_ascii_digit());
        let digits = &whole[..whole.len() - self.rest.len()];
        let number = digits.parse().map_err(|_| {
            wrong(place, "a whole number of at most 38 digits", &format!("`{digits}`"))
        })?;
        if self.rest.starts_with('L') {
            self.next();
        }
        match self.peek() {
            Some(sign) if sign.is_alphanumeric() || "._".contains(sign) => {
                Err(self.wrong("the end of a whole number"))
            }
            _ => Ok(number),
        }
    }

    fn bool(&mut self) -> io::Result<bool> {
        let place = self.place;
        match self.take(|sign| sign.is_alphanumeric() || sign == '_') {
            "True" => Ok(true),
            "False" => Ok(false),
            word => Err(wrong(place, "a Python literal", &format!("`{}`", word.shown()))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the text of a literal without its places.
    fn shown(literal: &Literal) -> String {
        let all = |items: &[Literal]| items.iter().map(shown).collect::<Vec<_>>().join(" ");
        match &literal.value {
            LiteralValue::Bool(value) => value.to_string(),
            LiteralValue::Int(number) => number.to_string(),
            LiteralValue::Text(text) => format!("{text:?}"),
            LiteralValue::Sequence(items) => format!("({})", all(items)),
            LiteralValue::Dict(entries) => {
                let entry = |(key, value): &(String, Literal)| format!("{key}={}", shown(value));
                format!("{{{}}}", entries.iter().map(entry).collect::<Vec<_>>().join(" "))
            }
        }
    }

    #[test]
    fn literals_are_read_as_python_reads_them() {
        for (text, expected) in [
            (
                "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }   \n",
                "{descr=\"<f8\" fortran_order=false shape=(3 4)}",
            ),
            (
                "[('id', '<u4'), ('normal', '<f4', (3,))]",
                "((\"id\" \"<u4\") (\"normal\" \"<f4\" (3)))",
            ),
            (" ( ) ", "()"),
            ("(1,)", "(1)"),
            ("(1)", "1"),
            ("((1, 2))", "(1 2)"),
            ("[1]", "(1)"),
            ("(3L, -40L)", "(3 -40)"),
            ("{}", "{}"),
            ("\"it's\"", "\"it's\""),
            (r"'a\\b\'\x41\u00fc\U0001f40d\n'", "\"a\\\\b'Aü🐍\\n\""),
            ("True", "true"),
        ] {
            assert_eq!(shown(&parse(text).unwrap()), expected, "{text}");
        }
    }

    #[test]
    fn errors_name_the_place() {
        for (text, expected) in [
            ("", "1: expected a Python literal, found the end of the header"),
            ("{'a' 1}", "6: expected `:`, found `1`"),
            ("{'a': 1 'b': 2}", "9: expected `,` or `}`, found `'`"),
            ("{a: 1}", "2: expected a key in quotes, found `a`"),
            ("{'a': 1, 'a': 2}", "10: expected each key once, found 'a' again"),
            ("(1 2)", "4: expected `,` or `)`, found `2`"),
            ("(,)", "2: expected a Python literal, found `,`"),
            ("(1,,)", "4: expected a Python literal, found `,`"),
            ("(1, 2]", "6: expected `,` or `)`, found `]`"),
            ("('ü', None)", "7: expected a Python literal, found `None`"),
            ("(0x10,)", "3: expected the end of a whole number, found `x`"),
            ("1.5", "2: expected the end of a whole number, found `.`"),
            ("-", "1: expected a whole number of at most 38 digits, found `-`"),
            ("'a\\q'", "3: expected an escape sequence of Python, found `\\q`"),
            ("'\\ud800'", "2: expected an escape sequence of Python, found `\\u`"),
            ("'\\x4", "2: expected an escape sequence of Python, found `\\x`"),
            ("'a", "3: expected the end of a string, found the end of the header"),
            ("1 2", "3: expected the end of the header, found `2`"),
            ("1 \x1b", "3: expected the end of the header, found `\\u{1b}`"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert_eq!(error, format!("its header, character {expected}"), "{text}");
        }
        let deep = parse(&"(".repeat(10_000)).unwrap_err().to_string();
        assert!(deep.contains("character 34: expected at most 32 nested"), "{deep}");
    }
}
