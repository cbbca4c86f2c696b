//! The kinds of values that keys of scene files have: how each is read, with what was expected, and written.

use glam::DVec3;
use toml::de::DeValue;

use super::{Key, Section, keys_of, lines};
use crate::error::{Hint, SceneError};
use crate::plain::steers;
use crate::scene::places::quoted;
pub use crate::scene::raw::Argument;
use crate::scene::raw::{RawContent, RawValue};
use crate::scene::table::{Checked, Field, read_table};
use crate::scene::{
    Color, ColorMap, DataFormat, MAX_SIDE, Samples, Sky, Source, hex, linear_from_srgb,
};
use crate::words::joined;

/// How a value is read.
pub type Reader<T> = fn(&Field) -> Checked<T>;

/// True or false.
pub fn flag(field: &Field) -> Checked<bool> {
    match field.content() {
        RawContent::Boolean(flag) => Ok(flag),
        _ => Err(field.wrong_type("true or false")),
    }
}

/// A text in quotes.
pub fn text(field: &Field) -> Checked<String> {
    field.text().map(str::to_owned).ok_or_else(|| field.wrong_type("a string in quotes"))
}

/// A point, world units.
pub fn point(field: &Field) -> Checked<DVec3> {
    field.numbers("three numbers").map(DVec3::from_array)
}

/// A direction of any length but zero.
pub fn direction(field: &Field) -> Checked<DVec3> {
    match point(field)? {
        DVec3::ZERO => Err(field.wrong(
            format!("`{}` is the zero vector", field.key.name),
            "a direction of any length but zero",
        )),
        vector => Ok(vector),
    }
}

/// What is expected of a number, and which are.
type NumberLimits = (&'static str, fn(f64) -> bool);

pub(in crate::scene) const FOV: NumberLimits =
    ("degrees, greater than 0 and less than 180", |angle| angle > 0.0 && angle < 180.0);
pub(in crate::scene) const HEIGHT: NumberLimits =
    ("a height in world units, greater than 0", |height| height > 0.0);

/// A vertical field of view, degrees.
pub fn fov(field: &Field) -> Checked<f64> {
    field.number_within(FOV)
}

/// The height of an orthographic camera's picture, world units.
pub fn height(field: &Field) -> Checked<f64> {
    field.number_within(HEIGHT)
}

/// A radius, world units.
pub fn radius(field: &Field) -> Checked<f64> {
    field.number_within(("a number greater than 0", |radius| radius > 0.0))
}

/// How much light there is.
pub fn intensity(field: &Field) -> Checked<f64> {
    field.number_within(("a number that is not negative", |light| light >= 0.0))
}

/// Columns or rows of a picture.
pub fn pixels(field: &Field) -> Checked<u32> {
    field.whole_number(" of pixels", 1..=MAX_SIDE)
}

/// Samples across and down a pixel.
pub fn samples(field: &Field) -> Checked<Samples> {
    field.whole_number(" of samples", 1..=Samples::MOST).map(Samples::nearest)
}

/// Suns of a sky.
pub fn directions(field: &Field) -> Checked<u32> {
    field.whole_number(" of directions", 1..=Sky::MAX_DIRECTIONS)
}

/// Frame of a file of several, from 0; from −1 backwards, counted from the last one.
pub fn frame(field: &Field) -> Checked<i32> {
    let expected = "a whole number: 0 is the first frame, -1 the last one";
    let found = field.integer(expected)?;
    i32::try_from(found).map_err(|_| field.wrong_value(found, expected))
}

/// Line of a file, from 1.
pub fn header(field: &Field) -> Checked<u32> {
    field.whole_number(": the line's number, from 1", 1..=u32::MAX)
}

/// Colour space of the colours of a data file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorSpace {
    /// Encoded for display, as `#rrggbb`.
    Srgb,
    /// Linear light.
    Linear,
}

/// Treatment of rows without a coordinate or a radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingRows {
    /// They are left out.
    Skip,
}

/// A value that is one of a few names.
pub trait NamedValue: Copy + 'static {
    /// All values, with their names.
    const NAMES: &'static [(&'static str, Self)];
}

impl NamedValue for ColorSpace {
    const NAMES: &'static [(&'static str, ColorSpace)] =
        &[("srgb", ColorSpace::Srgb), ("linear", ColorSpace::Linear)];
}

impl NamedValue for MissingRows {
    const NAMES: &'static [(&'static str, MissingRows)] = &[("skip", MissingRows::Skip)];
}

impl NamedValue for DataFormat {
    const NAMES: &'static [(&'static str, DataFormat)] = &[
        ("npy", DataFormat::Npy),
        ("csv", DataFormat::Table),
        ("xyz", DataFormat::Xyz),
        ("lammps", DataFormat::Lammps),
    ];
}

fn named<T: NamedValue>(field: &Field, what: &str) -> Checked<T> {
    let text = text(field)?;
    let found = T::NAMES.iter().find(|(name, _)| *name == text);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names = || T::NAMES.iter().map(|(name, _)| *name);
        let quoted = names().map(|name| format!("\"{name}\""));
        field.misspelt(what, &text, names(), &joined(quoted, " or "))
    })
}

/// Colour space, by its name.
pub fn color_space(field: &Field) -> Checked<ColorSpace> {
    named(field, "a colour space")
}

/// Treatment of rows with missing numbers, by its name.
pub fn missing(field: &Field) -> Checked<MissingRows> {
    named(field, "a treatment of missing numbers")
}

/// Format of data, by its name.
pub fn data_format(field: &Field) -> Checked<DataFormat> {
    named(field, "a format of data")
}

/// A colour: `"#rrggbb"`, a name of CSS, or linear red, green and blue.
pub fn color(field: &Field) -> Checked<Color> {
    let expected = "\"#rrggbb\" or a name of CSS (sRGB), or [r, g, b] (linear, each from 0 to 1)";
    read_color(field, expected, "a linear colour", |linear| linear)
}

/// A colour of a language whose numbers are encoded for display: `"#rrggbb"`, a name of CSS, or red, green and blue in sRGB.
pub fn srgb_color(field: &Field) -> Checked<Color> {
    let expected = "\"#rrggbb\", a name of CSS, or [r, g, b], each from 0 to 1";
    read_color(field, expected, "a colour", linear_from_srgb)
}

fn read_color(field: &Field, expected: &str, what: &str, linear: fn(f64) -> f64) -> Checked<Color> {
    if let Some(text) = field.text() {
        return Color::parse(text)
            .ok_or_else(|| field.misspelt("a colour", text, Color::css_names(), expected));
    }
    let parts = field.numbers(expected)?;
    match parts.iter().find(|part| !(0.0..=1.0).contains(*part)) {
        Some(part) => Err(field.wrong(format!("{part:?} in {what}"), expected)),
        None => Ok(Color(parts.map(linear))),
    }
}

/// A colour, or a number for white light, which is not bounded by 1.
pub fn ambient(field: &Field) -> Checked<Color> {
    match field.content() {
        RawContent::Integer(_) | RawContent::Float(_) => {
            intensity(field).map(|light| Color([light; 3]))
        }
        _ => color(field),
    }
}

/// Where a lamp is: a point, or at the eye.
pub fn lamp(field: &Field) -> Checked<Source> {
    match field.text() {
        Some("eye") => Ok(Source::Eye),
        Some(other) => {
            Err(field
                .wrong_value(quoted(other), "a point of three numbers, or \"eye\" for the camera"))
        }
        None => point(field).map(Source::Point),
    }
}

/// Two numbers, the lesser one first.
pub fn range(field: &Field) -> Checked<[f64; 2]> {
    match field.numbers("two numbers, the least and the largest")? {
        [low, high] if low < high => Ok([low, high]),
        range => Err(field.wrong_value(
            range,
            "the lesser number first; a colour map is turned around by `_r` at its name: \
             `colormap = \"viridis_r\"`",
        )),
    }
}

/// A colour map, by its name.
pub fn colormap(field: &Field) -> Checked<ColorMap> {
    let name = text(field)?;
    ColorMap::from_name(&name).ok_or_else(|| {
        let names = joined(ColorMap::names(), ", ");
        let expected = format!("one of {names}, or one with `_r` behind it, turned around");
        field.misspelt("a colour map", &name, ColorMap::names(), &expected)
    })
}

/// The column for a part of a sphere.
#[derive(Clone, Debug, PartialEq)]
pub enum ColumnChoice {
    /// No column.
    Absent,
    /// The column with this name, or this place from 0.
    Named(String),
    /// No column, but this number for all spheres.
    Constant(f64),
}

/// The name of a column or its place, `false` for none, or a float for all spheres.
pub fn column_choice(field: &Field) -> Checked<ColumnChoice> {
    match field.content() {
        RawContent::Boolean(false) => Ok(ColumnChoice::Absent),
        RawContent::Integer(Ok(place)) => Ok(ColumnChoice::Named(place.to_string())),
        RawContent::Text(text) => Ok(ColumnChoice::Named(text.to_owned())),
        RawContent::Float(_) => field.number().map(ColumnChoice::Constant),
        _ => Err(field.wrong_type("the name of a column, or false for none")),
    }
}

/// The name of a column, or its place.
pub fn column(field: &Field) -> Checked<String> {
    match field.content() {
        RawContent::Integer(Ok(place)) => Ok(place.to_string()),
        RawContent::Text(text) => Ok(text.to_owned()),
        _ => Err(field.wrong_type("the name of a column")),
    }
}

/// A table under its header, or in a line.
pub fn table<S: Section>(field: &Field) -> Checked<S> {
    match field.content() {
        RawContent::Table(table) => read_table(&table, field.span()),
        _ => Err(field.wrong_type(format!("one table under {}", S::INFO.header))),
    }
}

/// Tables, each under its own header, or a list of them.
pub fn tables<S: Section>(field: &Field) -> Checked<Vec<S>> {
    let expected = || format!("a list of tables, each under its own {}", S::INFO.header);
    let RawContent::List(list) = field.content() else {
        return Err(field.wrong_type(expected()));
    };
    let read = |value: RawValue| match value.content() {
        RawContent::Table(table) => read_table(&table, value.span()),
        _ => Err(Field { value, ..*field }.wrong_type(expected())),
    };
    list.iter().map(read).collect()
}

/// What stands behind a key, as it is written.
pub trait Value {
    /// In TOML: read, it is the same.
    fn toml(&self) -> String;

    /// The parts of a file that the tables are which stand behind the key, each under its header; `None` for a value.
    fn tables(&self) -> Option<Vec<String>> {
        None
    }
}

macro_rules! written_as_debug {
    ($($type:ty),*) => {$(
        impl Value for $type {
            fn toml(&self) -> String {
                format!("{self:?}")
            }
        }
    )*};
}

written_as_debug!(bool, u32, i32, f64, [f64; 2]);

impl Value for str {
    /// In double quotes; all that steers a terminal is escaped.
    fn toml(&self) -> String {
        let mut text = String::from('"');
        for c in self.chars() {
            match c {
                '"' | '\\' => text.extend(['\\', c]),
                '\n' => text += "\\n",
                '\t' => text += "\\t",
                // All of them are in Unicode's first plane.
                c if steers(c) => text += &format!("\\u{:04x}", u32::from(c)),
                c => text.push(c),
            }
        }
        text + "\""
    }
}

impl Value for String {
    fn toml(&self) -> String {
        self.as_str().toml()
    }
}

impl Value for ColumnChoice {
    fn toml(&self) -> String {
        match self {
            ColumnChoice::Absent => "false".into(),
            // Places are names as well, if quoted.
            ColumnChoice::Named(name) => name.toml(),
            ColumnChoice::Constant(number) => number.toml(),
        }
    }
}

/// Writes values that are one of a few names.
macro_rules! written_by_name {
    ($($type:ty),*) => {$(
        impl Value for $type {
            fn toml(&self) -> String {
                let found = <$type>::NAMES.iter().find(|(_, value)| value == self);
                found.map_or(String::new(), |(name, _)| name.toml())
            }
        }
    )*};
}

written_by_name!(ColorSpace, DataFormat, MissingRows);

impl Value for DVec3 {
    fn toml(&self) -> String {
        format!("{:?}", self.to_array())
    }
}

impl Value for Source {
    fn toml(&self) -> String {
        match self {
            Source::Eye => "\"eye\"".into(),
            Source::Point(place) | Source::Sun(place) => place.toml(),
        }
    }
}

impl Value for Samples {
    fn toml(&self) -> String {
        self.across().to_string()
    }
}

impl Value for ColorMap {
    fn toml(&self) -> String {
        self.name().toml()
    }
}

impl Value for Color {
    /// `#rrggbb` where that is this colour to the last bit; a number where it is more than a colour can be, as white
    /// ambient light may.
    fn toml(&self) -> String {
        let srgb = self.to_srgb8();
        match self.0 {
            _ if Color::from_srgb8(srgb) == *self => hex(srgb).toml(),
            [light, g, b] if light > 1.0 && [g, b] == [light; 2] => light.toml(),
            linear => format!("{linear:?}"),
        }
    }
}

impl<S: Section> Value for S {
    fn toml(&self) -> String {
        let parts = keys_of(self).into_iter().map(|(key, value)| format!("{key} = {value}"));
        format!("{{ {} }}", joined(parts, ", "))
    }

    fn tables(&self) -> Option<Vec<String>> {
        Some(vec![format!("{}\n{}", S::INFO.header, lines(&keys_of(self)))])
    }
}

impl<S: Section> Value for Vec<S> {
    fn toml(&self) -> String {
        format!("[{}]", joined(self.iter().map(Value::toml), ", "))
    }

    fn tables(&self) -> Option<Vec<String>> {
        Some(self.iter().filter_map(Value::tables).flatten().collect())
    }
}

/// Reads values as a command line gives them: a number, numbers between commas, or a text. What it can't read, it
/// answers with what was expected.
pub fn option<T>(read: Reader<T>) -> impl Fn(&str) -> Result<T, String> + Clone {
    // Whole numbers stay whole.
    let number = |part: &str| {
        let part = part.trim();
        let whole = part.parse().ok().map(Argument::Integer);
        whole.or_else(|| part.parse().ok().map(Argument::Float))
    };
    move |text| {
        let numbers: Option<Vec<Argument>> = text.split(',').map(number).collect();
        let value = match numbers {
            Some(mut numbers) if numbers.len() == 1 => numbers.remove(0),
            Some(several) => Argument::List(several),
            None => Argument::Text(text.to_owned()),
        };
        // Lists have no brackets there.
        let hint = |fault: Box<SceneError>| fault.hint.to_string().replace(['[', ']'], "");
        read_argument("", &value, read).map_err(hint)
    }
}

/// Reads the TOML value of the key `name`.
///
/// # Errors
/// Reports the value found and the values expected; the subject is the key, or a key of its table.
pub fn read_value<T>(name: &'static str, toml: &str, read: Reader<T>) -> Checked<T> {
    let value =
        DeValue::parse(toml).map_err(|error| SceneError::new(0..0, error.message(), Hint::NONE))?;
    read_raw(name, RawValue::Toml(&value), read)
}

/// Reads the value that a program gives for the key `name`.
///
/// # Errors
/// Returns the errors of [`read_value`].
pub fn read_argument<T>(name: &'static str, value: &Argument, read: Reader<T>) -> Checked<T> {
    read_raw(name, RawValue::Argument(value), read)
}

fn read_raw<T>(name: &'static str, value: RawValue, read: Reader<T>) -> Checked<T> {
    let key = &Key { name, example: "", meaning: "" };
    read(&Field { key, value }).map_err(|mut fault| {
        fault.subject.key.get_or_insert(name);
        fault
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_floats_are_linear_or_encoded() {
        let read = |toml: &str, read: Reader<Color>| read_value("color", toml, read);
        let [encoded, linear] = [srgb_color, color].map(|reader| read("[0.5, 0.0, 1.0]", reader));
        assert_eq!(encoded.unwrap(), Color([linear_from_srgb(0.5), 0.0, 1.0]));
        assert_eq!(linear.unwrap(), Color([0.5, 0.0, 1.0]));
        let byte = format!("[{:?}, 0.0, 1.0]", 128.0 / 255.0);
        assert_eq!(read(&byte, srgb_color).unwrap(), Color::from_srgb8([128, 0, 255]));
        for wrong in ["[1.5, 0.0, 0.0]", "[-0.5, 0.0, 0.0]", "[0.0, 0.0]", "\"no colour\""] {
            let fault = read(wrong, srgb_color).unwrap_err();
            assert!(!fault.hint.to_string().contains("linear"), "{wrong}: {}", fault.hint);
        }
    }

    #[test]
    fn arguments_are_read_as_toml() {
        use crate::scene::schema::{CloudKeys, PlaneKeys};
        let numbers = |numbers: [f64; 3]| Argument::List(numbers.map(Argument::Float).into());
        let entries = [
            ("name", Argument::Text("floor".into())),
            ("point", numbers([0.0, -1.0, 0.0])),
            ("normal", Argument::List([0, 1, 0].map(Argument::Integer).into())),
            ("color", numbers([0.5, 0.0, 1.0])),
        ];
        let mut entries = entries.map(|(key, value)| (key.to_owned(), value));
        let plane = |entries: &[(String, Argument)]| {
            read_argument("plane", &Argument::Table(entries.to_vec()), table::<PlaneKeys>)
        };
        let toml = "{ name = \"floor\", point = [0.0, -1.0, 0.0], normal = [0, 1, 0], color = [0.5, 0.0, 1.0] }";
        let mut of_toml: PlaneKeys = read_value("plane", toml, table).unwrap();
        of_toml.spans().fill(0..0);
        assert_eq!(plane(&entries).unwrap(), of_toml);
        for (value, toml) in [
            (Argument::Float(f64::INFINITY), "inf"),
            (Argument::LargeInteger("9223372036854775808".into()), "9223372036854775808"),
            (Argument::Boolean(true), "true"),
            (Argument::List(Vec::new()), "[]"),
            (Argument::Table(Vec::new()), "{}"),
        ] {
            let of_argument = read_argument("radius", &value, radius).unwrap_err();
            let of_toml = read_value("radius", toml, radius).unwrap_err();
            assert_eq!(of_argument.message, of_toml.message);
        }
        entries[0].0 = "nam".into();
        assert!(plane(&entries).unwrap_err().hint.to_string().contains("`name`"));
        let both = ["color", "color_by"].map(|key| (key.to_owned(), Argument::Text("red".into())));
        read_argument("spheres", &Argument::Table(both.into()), table::<CloudKeys>).unwrap_err();
    }

    #[test]
    fn a_fault_within_a_table_is_about_the_key_there() {
        use crate::scene::schema::CloudKeys;
        let fault = read_value::<CloudKeys>("spheres", "{ header = 0 }", table).unwrap_err();
        assert_eq!(fault.subject.key, Some("header"));
    }
}
