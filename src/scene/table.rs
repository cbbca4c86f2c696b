//! Tables and values with their places: types, known keys, and error messages.

use std::fmt::{Debug, Display};
use std::ops::{Range, RangeInclusive};

use super::places::{char_start, quoted};
use super::raw::{RawContent, RawEntry, RawValue};
use super::schema::{
    CloudKeys, Key, PlaneKeys, SECTIONS, SceneKeys, Section, SectionInfo, SphereKeys,
};
use crate::error::SceneError;
use crate::plain::Shown;
use crate::words::{did_you_mean, joined};

pub type Checked<T> = std::result::Result<T, Box<SceneError>>;

/// Reads a table whose header stands there, or all of it where it is an inline table.
pub(super) fn read_table<S: Section>(table: &[RawEntry], span: Range<usize>) -> Checked<S> {
    let info = S::INFO;
    let is_known = |name: &str| info.keys.iter().any(|key| key.name == name);
    let unknown = table.iter().filter(|entry| !is_known(entry.key));
    if let Some(entry) = unknown.min_by_key(|entry| entry.span.start) {
        let is_table = |value: RawValue| matches!(value.content(), RawContent::Table(_));
        let has_table = match entry.value.content() {
            RawContent::List(values) => values.iter().any(is_table),
            _ => is_table(entry.value),
        };
        return Err(unknown_key(&info, entry.key, has_table, entry.span.clone()));
    }
    let value_of = |key: &str| table.iter().find(|entry| entry.key == key).map(|entry| entry.value);
    let mut section = S::default();
    section.spans()[0] = span;
    for (place, key) in info.keys.iter().enumerate() {
        if let Some(value) = value_of(key.name) {
            section.set(&Field { key, value })?;
            section.spans()[1 + place] = value.span();
        }
    }
    for (one, other, which) in info.exclusive {
        if let (Some(_), Some(value)) = (value_of(one), value_of(other)) {
            return Err(SceneError::new(
                value.span(),
                format!("both `{one}` and `{other}` are given"),
                format!("{which}; remove one of them"),
            ));
        }
    }
    Ok(section)
}

/// The fault of a table that has none of these keys.
pub(super) fn lacks<S: Section>(section: &S, names: &[&str]) -> Box<SceneError> {
    let keys = || S::INFO.keys.iter().filter(|key| names.contains(&key.name));
    let listed = |each: fn(&Key) -> String| joined(keys().map(each), " or ");
    SceneError::new(
        section.span(""),
        format!(
            "{} is missing in this {}",
            listed(|key| format!("`{}`", key.name)),
            S::INFO.header
        ),
        format!("add for example {}", listed(|key| format!("`{} = {}`", key.name, key.example))),
    )
}

/// A value and its key; lists share the key among their elements.
#[derive(Clone, Copy)]
pub struct Field<'t> {
    pub key: &'t Key,
    pub value: RawValue<'t>,
}

impl<'t> Field<'t> {
    pub fn span(&self) -> Range<usize> {
        self.value.span()
    }

    pub fn content(&self) -> RawContent<'t> {
        self.value.content()
    }

    /// Returns the text, if the value is one.
    pub fn text(&self) -> Option<&'t str> {
        match self.content() {
            RawContent::Text(text) => Some(text),
            _ => None,
        }
    }

    pub fn wrong_type(&self, expected: impl Display) -> Box<SceneError> {
        let found = match self.content() {
            RawContent::Text(_) => "a string",
            RawContent::Integer(_) => "an integer",
            RawContent::Float(_) => "a float",
            RawContent::Boolean(_) => "a boolean",
            RawContent::Time => "a date or time",
            RawContent::List(_) => "a list",
            RawContent::Table(_) => "a table",
        };
        self.wrong(format!("found {found} in `{}`", self.key.name), expected)
    }

    pub fn wrong_value(&self, found: impl Debug, expected: impl Display) -> Box<SceneError> {
        let value = format!("{found:?}");
        self.wrong(format!("`{}` is {value}", self.key.name), expected).with_value(value)
    }

    pub fn wrong(&self, found: impl Into<String>, expected: impl Display) -> Box<SceneError> {
        let help = match self.key.example {
            "" => format!("expected {expected}"),
            example => format!("expected {expected}, e.g. `{} = {example}`", self.key.name),
        };
        let mut error = SceneError::new(self.span(), found, help);
        error.subject.key = Some(self.key.name);
        error
    }

    /// The fault of a name that is none of the `known` ones of `what`.
    pub fn misspelt(
        &self,
        what: &str,
        name: &str,
        known: impl Iterator<Item = &'static str>,
        expected: &str,
    ) -> Box<SceneError> {
        let mut fault = self.wrong(format!("{:?} is not {what}", quoted(name)), expected);
        if let Some(near) = did_you_mean(known, name) {
            fault.hint = fault.hint.after(format!("did you mean {near:?}? "));
        }
        fault
    }

    pub fn integer(&self, expected: &str) -> Checked<i64> {
        let RawContent::Integer(integer) = self.content() else {
            return Err(self.wrong_type(expected));
        };
        integer.map_err(|text| {
            let integer = quoted(text);
            self.wrong(format!("the integer {integer} does not fit in 64 bits"), expected)
        })
    }

    /// A finite number; of a decimal text, the nearest f64.
    pub fn number(&self) -> Checked<f64> {
        match self.content() {
            RawContent::Float(float) => float.map_err(|text| {
                let name = self.key.name;
                self.wrong(
                    format!("{} in `{name}` is not a finite number", quoted(&text)),
                    "a finite number that a 64-bit float can hold (up to 1.8e308)",
                )
            }),
            RawContent::Integer(_) => self
                .integer("a number; one beyond 64 bits is written as a float like 1e20")
                .map(|integer| integer as f64),
            _ => Err(self.wrong_type("a number")),
        }
    }

    /// A number of which something is expected.
    pub fn number_within(&self, (expected, is_possible): (&str, fn(f64) -> bool)) -> Checked<f64> {
        match self.number()? {
            number if is_possible(number) => Ok(number),
            number => Err(self.wrong_value(number, expected)),
        }
    }

    pub fn numbers<const N: usize>(&self, expected: &str) -> Checked<[f64; N]> {
        let RawContent::List(values) = self.content() else {
            return Err(self.wrong_type(expected));
        };
        if values.len() != N {
            let found = format!("found {} values in `{}`", values.len(), self.key.name);
            return Err(self.wrong(found, expected));
        }
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(values.iter()) {
            *number = Field { value, ..*self }.number()?;
        }
        Ok(numbers)
    }

    /// A whole number in this range; `of` says of what, behind these words.
    pub fn whole_number(&self, of: &str, range: RangeInclusive<u32>) -> Checked<u32> {
        let (least, most) = (range.start(), range.end());
        let expected = match *most {
            u32::MAX => format!("a whole number{of}"),
            _ => format!("a whole number{of} from {least} to {most}"),
        };
        let found = self.integer(&expected)?;
        match u32::try_from(found) {
            Ok(number) if range.contains(&number) => Ok(number),
            _ => Err(self.wrong_value(found, expected)),
        }
    }
}

/// `is_table` says whether a table or several stand under it.
fn unknown_key(
    info: &SectionInfo,
    key: &str,
    is_table: bool,
    span: Range<usize>,
) -> Box<SceneError> {
    let known: Vec<_> = info.keys.iter().map(|key| key.name).collect();
    let home = SECTIONS.iter().find(|other| other.keys.iter().any(|known| known.name == key));
    let key_shown = quoted(key).shown();
    let hint = match (home, did_you_mean(known.iter().copied(), key)) {
        (Some(home), _) => format!("`{key_shown}` belongs to {}; ", home.header),
        (None, Some(name)) => format!("did you mean `{name}`? "),
        (None, None) if is_table && info.header == SceneKeys::INFO.header => {
            let [sphere, cloud, plane] =
                [SphereKeys::INFO.header, CloudKeys::INFO.header, PlaneKeys::INFO.header];
            format!("the objects are {sphere}, {cloud} and {plane}; ")
        }
        (None, None) => String::new(),
    };
    SceneError::new(
        span,
        format!("unknown key `{key_shown}` in {}", info.header),
        format!("{hint}known keys here: {}", known.join(", ")),
    )
}

pub(super) fn syntax_fault(text: &str, error: &toml::de::Error) -> Box<SceneError> {
    let span = error.span().unwrap_or(text.len()..text.len());
    if is_windows_path(text, &span) {
        let help = "in \"…\", a backslash starts an escape; write paths with `/`, or in '…': file = 'C:\\data\\table.csv'";
        return SceneError::new(span, format!("invalid TOML: {}", error.message()), help);
    }
    let (found, expected) = match error.message().split_once(", expected ") {
        Some((found, expected)) => (found, format!("expected {expected}")),
        None => (error.message(), String::new()),
    };
    let line = text[char_start(text, span.start)..].lines().next();
    let help = if line.is_some_and(|rest| rest.trim_start().starts_with('#')) {
        "`#` starts a comment; a colour stands in quotes, e.g. \"#d62728\"".to_owned()
    } else if !expected.is_empty() && expected != "expected nothing" {
        expected
    } else if found == "duplicate key" {
        "each key stands once in a table; another sphere starts with its own [[sphere]]".to_owned()
    } else {
        "lines are `key = value` under [table] headers; see https://toml.io".to_owned()
    };
    SceneError::new(span, format!("invalid TOML: {found}"), help)
}

/// Whether an error at this place of a scene file is about a backslash in a string that may be a path of Windows.
fn is_windows_path(text: &str, span: &Range<usize>) -> bool {
    let start = text[..char_start(text, span.start)].rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[start..].lines().next().unwrap_or_default();
    line.contains('\\') && line.contains('"')
}
