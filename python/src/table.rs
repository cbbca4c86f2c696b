//! Python's arguments as values of a scene file's keys, so that the scene reader's own rules and errors hold for them.

use kugelblitz::error::{Message, SceneError as Fault};
use kugelblitz::scene::Color;
use kugelblitz::scene::schema::{self, Argument, ColorSpace, Reader, Section, read_argument};
use kugelblitz::words::did_you_mean_at_end;
use numpy::PyReadonlyArray1;
use pyo3::Borrowed;
use pyo3::exceptions::{PyUnicodeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyInt, PySequence, PyString};
use serde::Serialize;

use crate::error::{SceneError, argument, wrong_type, wrong_value};

/// An argument that may be left out.
pub type Given<'py> = Option<Bound<'py, PyAny>>;

/// An object of Python, or an exception.
pub type PyValue<'py> = PyResult<Bound<'py, PyAny>>;

/// Keys whose values are colours.
pub const COLORS: [&str; 4] = ["background", "ambient", "missing_color", "color"];

/// The keyword arguments of a call, which its signature names, or the entries of a dictionary.
pub struct Keywords<'py> {
    pub given: Bound<'py, PyDict>,
    /// Whether floats of colours are linear, not encoded in sRGB.
    pub is_linear: bool,
}

impl<'py> Keywords<'py> {
    /// # Errors
    /// `TypeError` for a name that is none of `known`, and [`SceneError`] for a wrong `color_space`.
    pub fn new(
        py: Python<'py>,
        given: Option<Bound<'py, PyDict>>,
        known: &[&'static str],
    ) -> PyResult<Keywords<'py>> {
        let given = given.unwrap_or_else(|| PyDict::new(py));
        for name in given.keys() {
            let name: String = name.extract()?;
            if !known.contains(&&*name) {
                let (all, near) = (known.join(", "), did_you_mean_at_end(known.to_vec(), &name));
                return wrong_type(format!("{name}: no such argument; there are {all}{near}"));
            }
        }
        let keys = Keywords { given, is_linear: false };
        let color_space = keys.value("color_space", schema::color_space)?;
        Ok(Keywords { is_linear: color_space == Some(ColorSpace::Linear), ..keys })
    }

    /// Returns the argument, unless it is Python's None.
    pub fn get(&self, name: &str) -> Option<Bound<'py, PyAny>> {
        self.given.get_item(name).ok().flatten().filter(|value| !value.is_none())
    }

    /// Returns the argument, if it is given, as something that no scene file has.
    ///
    /// # Errors
    /// Returns the errors of [`extracted`].
    pub fn extract<T: FromPyObjectOwned<'py>>(&self, name: &str) -> PyResult<Option<T>> {
        self.get(name).map(|given| extracted(name, &given)).transpose()
    }

    /// Returns the argument, if it is given, as the value of a scene's key.
    ///
    /// # Errors
    /// Returns the errors of [`value_of`].
    pub fn value<T>(&self, name: &'static str, read: Reader<T>) -> PyResult<Option<T>> {
        self.get(name).map(|given| value_of(name, &given, read)).transpose()
    }

    /// Returns the argument, if it is given, as a colour.
    ///
    /// # Errors
    /// Returns the errors of [`color_of`].
    pub fn color(&self, name: &str) -> PyResult<Option<Color>> {
        self.get(name).map(|given| color_of(name, &given, self.is_linear)).transpose()
    }

    /// Returns the arguments that are keys of a table of scene files, but for those `without`.
    ///
    /// # Errors
    /// Returns [`SceneError`] for values that the table cannot have.
    pub fn section<S: Section>(&self, subject: &str, without: &[&str]) -> PyResult<S> {
        let names = S::INFO.keys.iter().map(|key| key.name);
        let names = names.filter(|name| !without.contains(name));
        let given = names.filter_map(|name| Some((name.to_owned(), self.get(name)?)));
        let entry = |(name, given): (String, Bound<'py, PyAny>)| {
            let value = argument_of(&name, &name, &given, self.is_linear)?;
            Ok((name, value))
        };
        let table = given.map(entry).collect::<PyResult<_>>()?;
        read_table::<S>(&Argument::Table(table)).map_err(|fault| {
            let key = fault.subject.key.filter(|key| *key != S::INFO.header);
            wrong_argument(key.unwrap_or(subject), &fault)
        })
    }

    /// Returns the tables of the list `name`, as `check` makes objects of them.
    ///
    /// # Errors
    /// Returns `TypeError` unless the argument is a list, and [`SceneError`] for values that the tables cannot have.
    pub fn sections<S: Section, T>(
        &self,
        name: &str,
        check: impl Fn(S) -> Result<T, Box<Fault>>,
    ) -> PyResult<Vec<T>> {
        let Some(given) = self.get(name) else { return Ok(Vec::new()) };
        let is_list = !given.is_instance_of::<PyDict>() && !given.is_instance_of::<PyString>();
        let entries = given.try_iter().and_then(Iterator::collect::<PyResult<Vec<_>>>);
        let (true, Ok(entries)) = (is_list, entries) else {
            return wrong_type(format!("{name}: give a list of dictionaries, also for one"));
        };
        let object = |(n, entry): (usize, Bound<'py, PyAny>)| {
            let subject = format!("{name}[{n}]");
            let table = match entry.cast::<PyDict>() {
                Ok(dict) => table_of(&subject, dict, self.is_linear)?,
                Err(_) => extracted::<KeyValue>(&subject, &entry)?.0,
            };
            let object = read_table(&table).and_then(&check);
            object.map_err(|fault| wrong_argument(&subject, &fault))
        };
        entries.into_iter().enumerate().map(object).collect()
    }
}

/// A value of a scene file's key: numbers, texts, lists and dictionaries, also arrays and scalars of NumPy.
pub struct KeyValue(pub Argument);

/// Maximum number of lists and dictionaries within each other.
const MAX_DEPTH: usize = 4;

impl<'py> FromPyObject<'_, 'py> for KeyValue {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<KeyValue> {
        key_value(&given, MAX_DEPTH).map(KeyValue)
    }
}

fn key_value(given: &Bound<'_, PyAny>, depth: usize) -> PyResult<Argument> {
    if given.is_instance_of::<PyBool>() {
        return given.extract().map(Argument::Boolean);
    }
    if given.is_instance_of::<PyInt>() {
        let integer = given.extract().map(Argument::Integer);
        return integer.or_else(|_| Ok(Argument::LargeInteger(given.str()?.to_string())));
    }
    if given.is_instance_of::<PyFloat>() {
        return given.extract().map(Argument::Float);
    }
    if given.is_instance_of::<PyString>() {
        return given.extract().map(Argument::Text);
    }
    if depth > 0 {
        if let Ok(dict) = given.cast::<PyDict>()
            && dict.keys().iter().all(|key| key.is_instance_of::<PyString>())
        {
            let entry = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
                let key: String = key.extract()?;
                let value = key_value(&value, depth - 1).map_err(named_error(&value, &key))?;
                Ok((key, value))
            };
            return dict.iter().map(entry).collect::<PyResult<_>>().map(Argument::Table);
        }
        if given.get_type().hasattr("tolist")? {
            return key_value(&given.call_method0("tolist")?, depth - 1);
        }
        let is_text = given.is_instance_of::<PyBytes>() || given.is_instance_of::<PyByteArray>();
        if !is_text && given.cast::<PySequence>().is_ok() {
            let values = given.try_iter()?.map(|value| key_value(&value?, depth - 1));
            return values.collect::<PyResult<_>>().map(Argument::List);
        }
    }
    let kind = given.get_type().name()?;
    wrong_type(format!("a {kind} has no meaning here; give numbers, texts, lists or dictionaries"))
}

/// Converts a dictionary to a table with linear colours.
fn table_of(subject: &str, dict: &Bound<'_, PyDict>, is_linear: bool) -> PyResult<Argument> {
    let mut table = Vec::new();
    for (key, value) in dict {
        let key: String = extracted(subject, &key)?;
        let value = argument_of(&format!("{subject}, {key}"), &key, &value, is_linear)?;
        table.push((key, value));
    }
    Ok(Argument::Table(table))
}

/// Converts the value of a key, a colour to linear floats.
fn argument_of(
    subject: &str,
    key: &str,
    given: &Bound<'_, PyAny>,
    is_linear: bool,
) -> PyResult<Argument> {
    if COLORS.contains(&key) && !given.is_none() {
        let Color(linear) = color_of(subject, given, is_linear)?;
        return Ok(Argument::List(linear.map(Argument::Float).into()));
    }
    Ok(extracted::<KeyValue>(subject, given)?.0)
}

/// Reads a colour: a text; or three floats or bytes, perhaps with alpha, encoded in sRGB unless `is_linear`. A number
/// for `ambient` is the intensity of white light.
///
/// # Errors
/// Returns `ValueError` for an alpha other than 1, and the errors of [`value_of`].
pub fn color_of(subject: &str, given: &Bound<'_, PyAny>, is_linear: bool) -> PyResult<Color> {
    let mut value = match given.extract::<PyReadonlyArray1<'_, u8>>() {
        Ok(bytes) => {
            let linear = |byte: &u8| Argument::Float(f64::from(*byte) / 255.0);
            Argument::List(bytes.as_array().iter().map(linear).collect())
        }
        Err(_) => extracted::<KeyValue>(subject, given)?.0,
    };
    if let Argument::List(parts) = &mut value
        && parts.len() == 4
        && !matches!(parts.pop(), Some(Argument::Integer(1) | Argument::Float(1.0)))
    {
        let alpha = given.get_item(3)?;
        return wrong_value(format!(
            "{subject}: expected an alpha of 1 (255 in bytes), as objects are opaque, found {alpha}"
        ));
    }
    let name = COLORS.into_iter().find(|name| subject == *name).unwrap_or("color");
    let is_number =
        matches!(value, Argument::Integer(_) | Argument::LargeInteger(_) | Argument::Float(_));
    let read = match name {
        "ambient" if is_number => schema::ambient,
        _ if is_linear => schema::color,
        _ => schema::srgb_color,
    };
    read_argument(name, &value, read).map_err(|fault| wrong_argument(subject, &fault))
}

/// Converts the argument `name`.
///
/// # Errors
/// Returns the errors of the conversion, after the name.
pub fn extracted<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    given: &Bound<'py, PyAny>,
) -> PyResult<T> {
    given.extract().map_err(|error: T::Error| named_error(given, name)(error.into()))
}

/// For `map_err`: writes the name before the text of an exception.
fn named_error(given: &Bound<'_, PyAny>, name: &str) -> impl FnOnce(PyErr) -> PyErr {
    move |error| {
        let text = error.value(given.py()).to_string();
        // Exceptions about half a character are made of several parts.
        if text.starts_with(name) || error.is_instance_of::<PyUnicodeError>(given.py()) {
            return error;
        }
        PyErr::from_type(error.get_type(given.py()), format!("{name}: {text}"))
    }
}

/// Reads the value of a scene's key out of the argument `name`.
///
/// # Errors
/// Returns `TypeError` for objects of other types, and [`SceneError`] for values that the key cannot have.
pub fn value_of<T>(name: &'static str, given: &Bound<'_, PyAny>, read: Reader<T>) -> PyResult<T> {
    let KeyValue(value) = extracted(name, given)?;
    read_argument(name, &value, read).map_err(|fault| wrong_argument(name, &fault))
}

fn read_table<S: Section>(value: &Argument) -> Result<S, Box<Fault>> {
    read_argument(S::INFO.header, value, schema::table)
}

/// Returns the exception for an argument that the scene's reader refuses.
pub fn wrong_argument(subject: &str, fault: &Fault) -> PyErr {
    let text = Message::new(fault.message.as_str(), fault.hint.clone()).worded(argument);
    SceneError::new_err(if subject.is_empty() { text } else { format!("{subject}: {text}") })
}

/// What reads arguments, in Python.
pub fn helpers(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("kugelblitz._given")
}

/// Writes a result as the program's `--json` does.
///
/// # Errors
/// Returns `ValueError` for values that JSON cannot hold.
pub fn to_json(all: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(all).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Reads JSON as Python's dictionaries, lists and numbers.
pub fn from_json<'py>(py: Python<'py>, json: &str) -> PyValue<'py> {
    py.import("json")?.call_method1("loads", (json,))
}

/// Converts a result to dictionaries, lists and numbers, under the keys of the program's `--json`.
///
/// # Errors
/// Returns the errors of [`to_json`].
pub fn to_python<'py>(py: Python<'py>, all: &impl Serialize) -> PyValue<'py> {
    from_json(py, &to_json(all)?)
}
