//! The header of NumPy's `.npy` files: what an array consists of, and how it lies in the file.

use std::fmt;
use std::io::{self, Read};

/// What is written in front of an array's numbers.
pub(crate) struct Header {
    /// What the array consists of.
    pub dtype: DType,
    /// How many there are along each axis. The product is below 10¹⁸.
    pub shape: Vec<u64>,
    /// True where neighbours in the file are neighbours along the first axis.
    pub is_fortran: bool,
}

/// The type of what an array consists of.
pub(crate) enum DType {
    Plain(Plain),
    Record(Vec<Field>),
}

/// A type that has no parts.
pub(crate) struct Plain {
    /// As NumPy writes it.
    pub name: String,
    /// What kind of number, of at most 64 bits; `None` for what is none.
    pub kind: Option<Kind>,
    /// `None` where that differs from one to the next.
    pub n_bytes: Option<usize>,
    pub is_big_endian: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Bool,
    Int,
    Uint,
    Float,
}

/// A part of a record.
pub(crate) struct Field {
    /// Empty for padding.
    pub name: String,
    /// The type of each of its elements.
    pub dtype: DType,
    /// Of several elements, how many there are along each axis.
    pub shape: Vec<u64>,
}

impl DType {
    /// Bytes of one; `None` where they differ from one to the next, or are beyond a `usize`.
    pub fn n_bytes(&self) -> Option<usize> {
        match self {
            DType::Plain(plain) => plain.n_bytes,
            DType::Record(fields) => {
                fields.iter().try_fold(0_usize, |sum, field| sum.checked_add(field.n_bytes()?))
            }
        }
    }
}

impl Field {
    /// Its elements: below 10¹⁸, as all of a header's numbers together.
    pub fn n_elements(&self) -> u64 {
        self.shape.iter().product()
    }

    fn n_bytes(&self) -> Option<usize> {
        usize::try_from(self.n_elements()).ok()?.checked_mul(self.dtype.n_bytes()?)
    }
}

/// As NumPy describes it.
impl fmt::Display for DType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fields = match self {
            DType::Plain(plain) => return write!(f, "'{}'", plain.name),
            DType::Record(fields) => fields,
        };
        write!(f, "[")?;
        for Field { name, dtype, shape } in fields {
            write!(f, "('{}', {dtype}", name.replace('\'', "\\'"))?;
            if !shape.is_empty() {
                let shape: String = shape.iter().map(|n| format!("{n},")).collect();
                write!(f, ", ({shape})")?;
            }
            write!(f, "), ")?;
        }
        write!(f, "]")
    }
}

impl Plain {
    /// Reads `<f8` and the like.
    fn parse(name: &str) -> Option<Plain> {
        let (order, rest) = name.split_at_checked(1)?;
        let (code, rest) = rest.split_at_checked(1)?;
        // Units of time stand behind.
        let n: Option<usize> = rest.split('[').next().and_then(|digits| digits.parse().ok());
        let kind = match (code, n) {
            ("b", Some(1)) => Some(Kind::Bool),
            ("i", Some(1 | 2 | 4 | 8)) => Some(Kind::Int),
            ("u", Some(1 | 2 | 4 | 8)) => Some(Kind::Uint),
            ("f", Some(2 | 4 | 8)) => Some(Kind::Float),
            _ => None,
        };
        ["<", ">", "|"].contains(&order).then(|| Plain {
            name: name.to_owned(),
            kind: kind.filter(|_| order != "|" || n == Some(1)),
            n_bytes: if code == "U" { n.and_then(|n| n.checked_mul(4)) } else { n },
            is_big_endian: order == ">",
        })
    }
}

/// Longest header, bytes. NumPy itself refuses to read headers of more than 10 000.
const MAX_HEADER_BYTES: u64 = 10_000;

/// Deepest nesting of brackets: the dictionary, the list of fields, a field, its shape.
const MAX_NESTING: usize = 8;

/// Most decimal digits in the shapes of all: a product of numbers with so many digits together is
/// below 10¹⁸, so below 2⁶⁴.
const MAX_DIGITS: usize = 18;

fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message.into())
}

fn no_table() -> io::Error {
    invalid("its header is not that of a table of numbers")
}

impl Header {
    /// Reads the header of versions 1 to 3, and tells its length in bytes.
    ///
    /// # Errors
    /// `InvalidData` where it is none, `UnexpectedEof` where the file ends in it.
    pub fn read(reader: &mut impl Read) -> io::Result<(Header, u64)> {
        let mut start = Vec::new();
        reader.take(8).read_to_end(&mut start)?;
        let &[0x93, b'N', b'U', b'M', b'P', b'Y', major, minor] = &start[..] else {
            return Err(invalid("it does not begin like one"));
        };
        let n_length_bytes = match (major, minor) {
            (1, 0) => 2,
            (2 | 3, 0) => 4,
            _ => return Err(invalid(format!("unsupported version: ({major}, {minor})"))),
        };
        let mut length = [0; 4];
        reader.read_exact(&mut length[..n_length_bytes])?;
        let n_text_bytes = u64::from(u32::from_le_bytes(length));
        if n_text_bytes > MAX_HEADER_BYTES {
            return Err(invalid("its header is too long"));
        }
        let mut text = vec![0; n_text_bytes as usize];
        reader.read_exact(&mut text)?;
        let text = std::str::from_utf8(&text).map_err(|_| invalid("its header is not UTF-8"))?;
        Ok((Header::parse(text)?, 8 + n_length_bytes as u64 + n_text_bytes))
    }

    fn parse(text: &str) -> io::Result<Header> {
        let mut literals = Literals { rest: text, n_digits: 0 };
        if !literals.skip('{') {
            return Err(no_table());
        }
        let mut entries = literals.items('}', |literals| {
            let key = literals.value(1)?;
            if !literals.skip(':') {
                return Err(no_table());
            }
            Ok((key, literals.value(1)?))
        })?;
        if !literals.rest.trim_start().is_empty() {
            return Err(no_table());
        }
        let mut take = |wanted: &str| {
            let is_wanted =
                |(key, _): &(Value, Value)| matches!(key, Value::Text(key) if key == wanted);
            let place = entries.iter().rposition(is_wanted);
            let place = place.ok_or_else(|| invalid(format!("its header lacks `{wanted}`")))?;
            Ok::<_, io::Error>(entries.swap_remove(place).1)
        };
        let Value::Bool(is_fortran) = take("fortran_order")? else {
            return Err(no_table());
        };
        let shape = take("shape")?.into_shape()?;
        Ok(Header { dtype: take("descr")?.into_dtype()?, shape, is_fortran })
    }
}

/// A literal of Python, of those that stand in headers.
enum Value {
    Bool(bool),
    Number(u64),
    Text(String),
    /// A list or a tuple.
    List(Vec<Value>),
}

impl Value {
    fn into_shape(self) -> io::Result<Vec<u64>> {
        let Value::List(axes) = self else {
            return Err(no_table());
        };
        let number = |axis| match axis {
            Value::Number(n) => Ok(n),
            _ => Err(no_table()),
        };
        axes.into_iter().map(number).collect()
    }

    fn into_dtype(self) -> io::Result<DType> {
        match self {
            Value::Text(name) => match Plain::parse(&name) {
                Some(plain) => Ok(DType::Plain(plain)),
                None => Err(invalid(format!("invalid type string: '{name}'"))),
            },
            Value::List(fields) => fields
                .into_iter()
                .map(Value::into_field)
                .collect::<io::Result<_>>()
                .map(DType::Record),
            _ => Err(no_table()),
        }
    }

    fn into_field(self) -> io::Result<Field> {
        let Value::List(parts) = self else {
            return Err(no_table());
        };
        let mut parts = parts.into_iter();
        match (parts.next(), parts.next(), parts.next(), parts.next()) {
            (Some(Value::Text(name)), Some(dtype), shape, None) => Ok(Field {
                name,
                dtype: dtype.into_dtype()?,
                shape: shape.map_or(Ok(Vec::new()), Value::into_shape)?,
            }),
            _ => Err(no_table()),
        }
    }
}

/// Reads literals from the start of a text.
struct Literals<'a> {
    rest: &'a str,
    n_digits: usize,
}

impl Literals<'_> {
    /// True where `sign` comes next, which is taken then.
    fn skip(&mut self, sign: char) -> bool {
        self.rest = self.rest.trim_start();
        let behind = self.rest.strip_prefix(sign);
        self.rest = behind.unwrap_or(self.rest);
        behind.is_some()
    }

    /// What stands between commas, up to the bracket that closes it.
    fn items<T>(
        &mut self,
        close: char,
        mut item: impl FnMut(&mut Self) -> io::Result<T>,
    ) -> io::Result<Vec<T>> {
        let mut items = Vec::new();
        while !self.skip(close) {
            items.push(item(self)?);
            if !self.skip(',') {
                return if self.skip(close) { Ok(items) } else { Err(no_table()) };
            }
        }
        Ok(items)
    }

    /// A value in so many brackets.
    fn value(&mut self, depth: usize) -> io::Result<Value> {
        if depth > MAX_NESTING {
            return Err(invalid("its header is nested too deeply"));
        }
        for (open, close) in [('(', ')'), ('[', ']')] {
            if self.skip(open) {
                return self.items(close, |literals| literals.value(depth + 1)).map(Value::List);
            }
        }
        for quote in ['\'', '"'] {
            if self.skip(quote) {
                let closed = self.rest.split_once(quote);
                let (text, rest) = closed.ok_or_else(|| invalid("its header is not closed"))?;
                if text.contains(['\\', '\n', '\r']) {
                    return Err(invalid("its header has unexpected signs"));
                }
                self.rest = rest;
                return Ok(Value::Text(text.to_owned()));
            }
        }
        for (word, is_true) in [("True", true), ("False", false)] {
            if let Some(rest) = self.rest.strip_prefix(word) {
                self.rest = rest;
                return Ok(Value::Bool(is_true));
            }
        }
        let n = self.rest.bytes().take_while(u8::is_ascii_digit).count();
        let (digits, rest) = self.rest.split_at(n);
        (self.rest, self.n_digits) = (rest, self.n_digits + n);
        match digits.parse() {
            Ok(number) if self.n_digits <= MAX_DIGITS => Ok(Value::Number(number)),
            _ if n > 0 => Err(no_table()),
            _ => Err(invalid("its header has unexpected signs")),
        }
    }
}
