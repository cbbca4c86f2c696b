//! TOML tables and values with their places: types, known keys, and the words for what is wrong.

use std::ops::Range;

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::places::{Fault, char_start, quoted};
use super::read::{KINDS, OBJECTS};
use super::sniff::look_of_text;
use super::{Color, ColorMap};
use crate::words::did_you_mean;

pub(super) type Checked<T> = std::result::Result<T, Fault>;

/// A kind of table in the file: how it is written, and each known key with an example value.
pub(super) struct Kind {
    pub header: &'static str,
    pub keys: &'static [(&'static str, &'static str)],
}

/// A table whose keys are all known.
pub(super) struct Table<'t> {
    kind: &'static Kind,
    table: &'t DeTable<'t>,
    /// The header, or the whole of an inline table.
    span: Range<usize>,
}

impl<'t> Table<'t> {
    pub fn new(
        kind: &'static Kind,
        table: &'t DeTable<'t>,
        span: Range<usize>,
    ) -> Checked<Table<'t>> {
        let unknown = table
            .keys()
            .filter(|key| !kind.keys.iter().any(|(name, _)| name == key.get_ref()))
            .min_by_key(|key| key.span().start);
        match unknown {
            Some(key) => {
                let value = table.get(key.get_ref().as_ref()).map(Spanned::get_ref);
                let is_table = match value {
                    Some(DeValue::Array(values)) => values.iter().any(|v| v.get_ref().is_table()),
                    Some(value) => value.is_table(),
                    None => false,
                };
                Err(unknown_key(kind, key.get_ref(), is_table, key.span()))
            }
            None => Ok(Table { kind, table, span }),
        }
    }

    pub fn get(&self, key: &str) -> Option<Field<'t>> {
        let value = self.table.get(key)?;
        let &(key, example) = self.kind.keys.iter().find(|(name, _)| *name == key)?;
        Some(Field { key, example, value })
    }

    pub fn require(&self, key: &str) -> Checked<Field<'t>> {
        self.get(key).ok_or_else(|| {
            Fault::new(
                self.span.clone(),
                format!("`{key}` is missing in this {}", self.kind.header),
                format!("add for example {}", self.example(key)),
            )
        })
    }

    /// The fault that a table has where it has none of two keys.
    pub fn lacks(&self, [one, other]: [&str; 2]) -> Fault {
        Fault::new(
            self.span.clone(),
            format!("`{one}` or `{other}` is missing in this {}", self.kind.header),
            format!("add for example {} or {}", self.example(one), self.example(other)),
        )
    }

    fn example(&self, key: &str) -> String {
        let keys = self.kind.keys.iter();
        let example = keys.filter(|(name, _)| *name == key).map(|(_, e)| *e);
        format!("`{key} = {}`", example.collect::<String>())
    }

    /// Reads each table of the array `key`; none where the key is absent.
    pub fn each<T>(
        &self,
        key: &str,
        kind: &'static Kind,
        read: impl Fn(&Table) -> Checked<T>,
    ) -> Checked<Vec<T>> {
        let Some(field) = self.get(key) else {
            return Ok(Vec::new());
        };
        let expected = || format!("a list of tables, each under its own {}", kind.header);
        let values = field.value.get_ref().as_array();
        let values = values.ok_or_else(|| field.wrong_type(expected()))?;
        let mut objects = Vec::with_capacity(values.len());
        for value in values.iter() {
            let element = Field { value, ..field };
            let table = value.get_ref().as_table();
            let table = table.ok_or_else(|| element.wrong_type(expected()))?;
            objects.push(read(&Table::new(kind, table, value.span())?)?);
        }
        Ok(objects)
    }
}

/// A value and its key; lists share the key among their elements.
pub(super) struct Field<'t> {
    pub key: &'static str,
    example: &'static str,
    value: &'t Spanned<DeValue<'t>>,
}

impl<'t> Field<'t> {
    pub fn span(&self) -> Range<usize> {
        self.value.span()
    }

    fn wrong_type(&self, expected: impl std::fmt::Display) -> Fault {
        let found = match self.value.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) => "an integer",
            DeValue::Float(_) => "a float",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date or time",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        };
        self.wrong(format!("found {found} in `{}`", self.key), expected)
    }

    fn wrong(&self, found: impl Into<String>, expected: impl std::fmt::Display) -> Fault {
        let help = match self.example {
            "" => format!("expected {expected}"),
            example => format!("expected {expected}, e.g. `{} = {example}`", self.key),
        };
        Fault::new(self.span(), found, help)
    }

    pub fn table(&self, kind: &'static Kind) -> Checked<Table<'t>> {
        match self.value.get_ref() {
            DeValue::Table(table) => Table::new(kind, table, self.span()),
            _ => Err(self.wrong_type(format!("one table under {}", kind.header))),
        }
    }

    pub fn is_text(&self) -> bool {
        matches!(self.value.get_ref(), DeValue::String(_))
    }

    pub fn is_number(&self) -> bool {
        matches!(self.value.get_ref(), DeValue::Float(_) | DeValue::Integer(_))
    }

    pub fn flag(&self) -> Checked<bool> {
        match self.value.get_ref() {
            DeValue::Boolean(flag) => Ok(*flag),
            _ => Err(self.wrong_type("true or false")),
        }
    }

    /// A text that is this word, and nothing else.
    pub fn require_word(&self, word: &str, expected: &str) -> Checked<()> {
        match self.text()? {
            text if text == word => Ok(()),
            text => Err(self.wrong(format!("`{}` is {:?}", self.key, quoted(&text)), expected)),
        }
    }

    pub fn text(&self) -> Checked<String> {
        match self.value.get_ref() {
            DeValue::String(text) => Ok(text.to_string()),
            _ => Err(self.wrong_type("a string in quotes")),
        }
    }

    fn integer(&self, expected: &str) -> Checked<i64> {
        let DeValue::Integer(integer) = self.value.get_ref() else {
            return Err(self.wrong_type(expected));
        };
        i64::from_str_radix(integer.as_str(), integer.radix()).map_err(|_| {
            let integer = quoted(integer.as_str());
            self.wrong(format!("the integer {integer} does not fit in 64 bits"), expected)
        })
    }

    /// A finite number, the f64 nearest to the decimal text.
    pub fn number(&self) -> Checked<f64> {
        match self.value.get_ref() {
            DeValue::Float(float) => match float.as_str().parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(self.wrong(
                    format!("{} in `{}` is not a finite number", quoted(float.as_str()), self.key),
                    "a finite number that a 64-bit float can hold (up to 1.8e308)",
                )),
            },
            DeValue::Integer(_) => self
                .integer("a number; one beyond 64 bits is written as a float like 1e20")
                .map(|integer| integer as f64),
            _ => Err(self.wrong_type("a number")),
        }
    }

    /// A finite number that is not negative.
    pub fn not_negative(&self) -> Checked<f64> {
        match self.number()? {
            number if number >= 0.0 => Ok(number),
            number => {
                let found = format!("`{}` is {number:?}", self.key);
                Err(self.wrong(found, "a number that is not negative"))
            }
        }
    }

    fn numbers<const N: usize>(&self, expected: &str) -> Checked<[f64; N]> {
        let DeValue::Array(values) = self.value.get_ref() else {
            return Err(self.wrong_type(expected));
        };
        if values.len() != N {
            let found = format!("found {} values in `{}`", values.len(), self.key);
            return Err(self.wrong(found, expected));
        }
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(values.iter()) {
            *number = Field { value, ..*self }.number()?;
        }
        Ok(numbers)
    }

    pub fn vector(&self) -> Checked<DVec3> {
        self.numbers("three numbers").map(DVec3::from_array)
    }

    pub fn nonzero_vector(&self) -> Checked<DVec3> {
        match self.vector()? {
            DVec3::ZERO => Err(self.wrong(
                format!("`{}` is the zero vector", self.key),
                "a direction of any length but zero",
            )),
            vector => Ok(vector),
        }
    }

    pub fn color(&self) -> Checked<Color> {
        let expected =
            "\"#rrggbb\" or a name of CSS (sRGB), or [r, g, b] (linear, each from 0 to 1)";
        if let DeValue::String(text) = self.value.get_ref() {
            return Color::parse(text).ok_or_else(|| {
                let mut fault = self.wrong(format!("{:?} is not a colour", quoted(text)), expected);
                if let Some(name) = Color::nearest_name(text) {
                    fault.help = format!("did you mean {name:?}? {}", fault.help);
                }
                fault
            });
        }
        let linear = self.numbers(expected)?;
        match linear.iter().find(|part| !(0.0..=1.0).contains(*part)) {
            Some(part) => Err(self.wrong(format!("{part:?} in a linear colour"), expected)),
            None => Ok(Color(linear)),
        }
    }

    /// Two numbers, of which the first is the lesser one.
    pub fn range(&self) -> Checked<[f64; 2]> {
        let [low, high] = self.numbers("two numbers, the least and the largest")?;
        if low < high {
            return Ok([low, high]);
        }
        Err(Fault::new(
            self.span(),
            format!("`{}` is [{low:?}, {high:?}]", self.key),
            "the first number is less than the second; a colour map is turned around by `_r` at its \
             name: `colormap = \"viridis_r\"`",
        ))
    }

    pub fn colormap(&self) -> Checked<ColorMap> {
        let name = self.text()?;
        ColorMap::from_name(&name).ok_or_else(|| {
            let hint = match did_you_mean(ColorMap::names(), &name) {
                Some(near) => format!("did you mean \"{near}\"? "),
                None => String::new(),
            };
            let names: Vec<_> = ColorMap::names().collect();
            let names = names.join(", ");
            Fault::new(
                self.span(),
                format!("{:?} is not a colour map", quoted(&name)),
                format!("{hint}known are {names}, and each with `_r` behind it, turned around"),
            )
        })
    }

    /// The name of a column, for which a number may stand; `None` for `false`.
    pub fn column(&self) -> Checked<Option<String>> {
        match self.value.get_ref() {
            DeValue::Boolean(false) => Ok(None),
            DeValue::Integer(_) => self.integer("a column").map(|number| Some(number.to_string())),
            DeValue::String(text) => Ok(Some(text.to_string())),
            _ => Err(self.wrong_type("the name of a column, or false for none")),
        }
    }

    /// A whole number that is not negative.
    pub fn index(&self, expected: &str) -> Checked<u32> {
        let found = self.integer(expected)?;
        u32::try_from(found).map_err(|_| self.wrong(format!("`{}` is {found}", self.key), expected))
    }

    /// A number of `things`, from 1 to `most`.
    pub fn whole_number(&self, things: &str, most: u32) -> Checked<u32> {
        let expected = format!("a whole number of {things} from 1 to {most}");
        let found = self.integer(&expected)?;
        match u32::try_from(found) {
            Ok(number) if (1..=most).contains(&number) => Ok(number),
            _ => Err(self.wrong(format!("`{}` is {found}", self.key), expected)),
        }
    }
}

/// `is_table` says whether a table or several stand under it.
fn unknown_key(kind: &Kind, key: &str, is_table: bool, span: Range<usize>) -> Fault {
    let known: Vec<_> = kind.keys.iter().map(|(name, _)| *name).collect();
    let home = KINDS.iter().find(|other| other.keys.iter().any(|(name, _)| *name == key));
    let key_shown = quoted(key);
    let hint = match (home, did_you_mean(known.iter().copied(), key)) {
        (Some(home), _) => format!("`{key_shown}` belongs to {}; ", home.header),
        (None, Some(name)) => format!("did you mean `{name}`? "),
        (None, None) if is_table => shapes(kind),
        (None, None) => String::new(),
    };
    Fault::new(
        span,
        format!("unknown key `{key_shown}` in {}", kind.header),
        format!("{hint}known keys here: {}", known.join(", ")),
    )
}

/// The objects that a table takes: those of its keys that are lists of tables.
fn shapes(kind: &Kind) -> String {
    let headers = kind.keys.iter().map(|(name, _)| format!("[[{name}]]"));
    let shapes: Vec<String> =
        headers.filter(|header| OBJECTS.iter().any(|kind| kind.header == header)).collect();
    match &shapes[..] {
        [] => String::new(),
        [only] => format!("the objects are {only}; "),
        [first @ .., last] => format!("the objects are {} and {last}; ", first.join(", ")),
    }
}

pub(super) fn syntax_fault(text: &str, error: &toml::de::Error) -> Fault {
    let span = error.span().unwrap_or(text.len()..text.len());
    if let Some(found) = look_of_text(text) {
        let help = "a scene is a text in TOML; data have a name that ends in .npy, .csv or .xyz, and then \
                    `kugelblitz render` takes them as they are";
        return Fault::new(span, format!("this is no scene: it looks like {found}"), help);
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
    Fault::new(span, format!("not valid TOML: {found}"), help)
}
