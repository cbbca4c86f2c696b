//! Values of keys before they are checked: TOML of a scene file, and arguments of a program.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// A value that a program gives for a key of scene files.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// True or false.
    Boolean(bool),
    /// Integer of 64 bits.
    Integer(i64),
    /// Decimal text of an integer that does not fit in 64 bits.
    LargeInteger(String),
    /// Floating-point number, also one that is not finite.
    Float(f64),
    /// Text.
    Text(String),
    /// List.
    List(Vec<Argument>),
    /// Table: keys, each once, and their values.
    Table(Vec<(String, Argument)>),
}

/// A value that is not checked yet.
#[derive(Clone, Copy)]
pub enum RawValue<'t> {
    Toml(&'t Spanned<DeValue<'t>>),
    Argument(&'t Argument),
}

/// Content of a [`RawValue`].
pub enum RawContent<'t> {
    Boolean(bool),
    /// Integer, or the text of one that does not fit in 64 bits.
    Integer(Result<i64, &'t str>),
    /// Finite number, or the text of another one.
    Float(Result<f64, Cow<'t, str>>),
    Text(&'t str),
    Time,
    List(RawList<'t>),
    Table(Vec<RawEntry<'t>>),
}

/// Values of a list.
#[derive(Clone, Copy)]
pub enum RawList<'t> {
    Toml(&'t DeArray<'t>),
    Arguments(&'t [Argument]),
}

impl<'t> RawList<'t> {
    pub fn len(self) -> usize {
        match self {
            RawList::Toml(values) => values.len(),
            RawList::Arguments(values) => values.len(),
        }
    }

    pub fn iter(self) -> impl Iterator<Item = RawValue<'t>> {
        (0..self.len()).map(move |place| match self {
            RawList::Toml(values) => RawValue::Toml(&values[place]),
            RawList::Arguments(values) => RawValue::Argument(&values[place]),
        })
    }
}

/// A key of a table and its value.
pub struct RawEntry<'t> {
    pub key: &'t str,
    /// Range of bytes of the key in the scene file.
    pub span: Range<usize>,
    pub value: RawValue<'t>,
}

impl<'t> RawValue<'t> {
    /// Returns the range of bytes in the scene file; an argument has an empty one.
    pub fn span(self) -> Range<usize> {
        match self {
            RawValue::Toml(value) => value.span(),
            RawValue::Argument(_) => 0..0,
        }
    }

    pub fn content(self) -> RawContent<'t> {
        match self {
            RawValue::Toml(value) => content_of_toml(value.get_ref()),
            RawValue::Argument(argument) => content_of_argument(argument),
        }
    }
}

fn content_of_toml<'t>(value: &'t DeValue<'t>) -> RawContent<'t> {
    match value {
        DeValue::Boolean(flag) => RawContent::Boolean(*flag),
        DeValue::Integer(integer) => {
            let text = integer.as_str();
            RawContent::Integer(i64::from_str_radix(text, integer.radix()).map_err(|_| text))
        }
        DeValue::Float(float) => {
            let number = float.as_str().parse().ok().filter(|number: &f64| number.is_finite());
            RawContent::Float(number.ok_or(Cow::Borrowed(float.as_str())))
        }
        DeValue::String(text) => RawContent::Text(text),
        DeValue::Datetime(_) => RawContent::Time,
        DeValue::Array(values) => RawContent::List(RawList::Toml(values)),
        DeValue::Table(table) => RawContent::Table(entries_of_toml(table)),
    }
}

fn content_of_argument(argument: &Argument) -> RawContent<'_> {
    match argument {
        Argument::Boolean(flag) => RawContent::Boolean(*flag),
        Argument::Integer(integer) => RawContent::Integer(Ok(*integer)),
        Argument::LargeInteger(text) => RawContent::Integer(Err(text)),
        Argument::Float(number) if number.is_finite() => RawContent::Float(Ok(*number)),
        Argument::Float(number) => RawContent::Float(Err(number.to_string().into())),
        Argument::Text(text) => RawContent::Text(text),
        Argument::List(values) => RawContent::List(RawList::Arguments(values)),
        Argument::Table(entries) => {
            let entries = entries.iter().map(|(key, value)| RawEntry {
                key,
                span: 0..0,
                value: RawValue::Argument(value),
            });
            RawContent::Table(entries.collect())
        }
    }
}

/// Returns the keys of a table of TOML and their values.
pub fn entries_of_toml<'t>(table: &'t DeTable<'t>) -> Vec<RawEntry<'t>> {
    let entries = table.iter().map(|(key, value)| RawEntry {
        key: key.get_ref(),
        span: key.span(),
        value: RawValue::Toml(value),
    });
    entries.collect()
}
