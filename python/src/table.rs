//! Python's dictionaries, lists and numbers as tables of a scene file, so that the scene reader's own rules
//! and errors hold for them.

use std::path::Path;

use kugelblitz::Error;
use kugelblitz::scene::schema::{Reader, Spanned, read_value};
use kugelblitz::scene::{Scene, parse_scene};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyInt, PyString};
use serde::Serialize;
use toml::{Table, Value};

use crate::error::SceneError;

/// A scene of one table: `key` and what stands there. `subject` names the argument in errors.
///
/// # Errors
/// `TypeError` for a value that a scene file can't hold; [`SceneError`] as the reader finds it.
pub fn scene_of(subject: &str, key: &str, value: Value) -> PyResult<Scene> {
    let text = Table::from_iter([(key.to_string(), value)]).to_string();
    parse_scene(&text, Path::new(subject)).map_err(|error| match error {
        Error::Scene(fault) => {
            SceneError::new_err(format!("{subject}: {}; {}", fault.message, fault.help))
        }
        other => crate::error::exception(other, subject),
    })
}

/// The value of a scene's key, out of the argument `name`.
///
/// # Errors
/// As [`scene_of`].
pub fn value_of<T>(name: &'static str, given: &Bound<'_, PyAny>, read: Reader<T>) -> PyResult<T> {
    read_value(name, &value(name, given)?.to_string(), read)
        .map_err(|[found, help]| SceneError::new_err(format!("{name}: {found}; {help}")))
}

/// The key of a scene file that the argument `name` gives, where it is given.
///
/// # Errors
/// As [`scene_of`].
pub fn key<T>(
    name: &'static str,
    given: Option<&Bound<'_, PyAny>>,
    read: Reader<T>,
) -> PyResult<Option<Spanned<T>>> {
    given.map(|given| value_of(name, given, read).map(Into::into)).transpose()
}

/// The value of a scene file that an object stands for.
///
/// # Errors
/// `TypeError` for what a scene file can't hold.
pub fn value(subject: &str, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    if given.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(given.extract()?));
    }
    if given.is_instance_of::<PyString>() {
        return Ok(Value::String(given.extract()?));
    }
    if given.is_instance_of::<PyInt>() {
        return given.extract().map(Value::Integer).map_err(|_| {
            PyValueError::new_err(format!("{subject}: an integer that does not fit in 64 bits"))
        });
    }
    if given.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(given.extract()?));
    }
    if let Ok(dict) = given.cast::<PyDict>() {
        let mut table = Table::new();
        for (key, entry) in dict {
            let key: String = key.extract().map_err(|_| unknown(subject, &key))?;
            let entry = value(&format!("{subject}, {key}"), &entry)?;
            table.insert(key, entry);
        }
        return Ok(Value::Table(table));
    }
    if given.is_instance_of::<PyBytes>() || given.is_instance_of::<PyByteArray>() {
        return Err(unknown(subject, given));
    }
    // Arrays and scalars of numpy.
    if let Ok(list) = given.call_method0("tolist") {
        return value(subject, &list);
    }
    let Ok(entries) = given.try_iter() else { return Err(unknown(subject, given)) };
    let entries = entries.map(|entry| value(subject, &entry?));
    Ok(Value::Array(entries.collect::<PyResult<_>>()?))
}

/// What serde writes, as Python's dictionaries, lists and numbers: by JSON.
///
/// # Errors
/// `ValueError` for what JSON can't hold.
pub fn to_python<'py>(py: Python<'py>, all: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text =
        serde_json::to_string(all).map_err(|error| PyValueError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

fn unknown(subject: &str, given: &Bound<'_, PyAny>) -> PyErr {
    let kind = given.get_type().name().map_or("object".into(), |name| name.to_string());
    PyTypeError::new_err(format!(
        "{subject}: a {kind} has no meaning here; give numbers, texts, lists or dictionaries"
    ))
}
