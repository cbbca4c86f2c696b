//! Python's dictionaries, lists and numbers as tables of a scene file, so that the scene reader's own rules
//! and errors hold for them.

use std::path::Path;

use kugelblitz::Error;
use kugelblitz::error::Message;
use kugelblitz::scene::schema::{self, ColorSpace, Reader, Section, read_value};
use kugelblitz::scene::{Scene, parse_scene};
use kugelblitz::words::did_you_mean_at_end;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::error::{SceneError, argument, exception, wrong_type};

/// An argument that may be left out.
pub type Given<'py> = Option<Bound<'py, PyAny>>;

/// An object of Python, or an exception.
pub type Object<'py> = PyResult<Bound<'py, PyAny>>;

/// The keyword arguments of a call, which its signature names.
pub struct Keywords<'py>(pub Bound<'py, PyDict>);

impl<'py> Keywords<'py> {
    /// # Errors
    /// `TypeError` for a name that is none of `known`.
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
        Ok(Keywords(given))
    }

    /// What stands there, but for Python's None.
    pub fn get(&self, name: &str) -> Option<Bound<'py, PyAny>> {
        self.0.get_item(name).ok().flatten().filter(|value| !value.is_none())
    }

    /// What stands there, as something that no scene file has.
    ///
    /// # Errors
    /// Those of the conversion, with the name before them.
    pub fn extract<T: FromPyObjectOwned<'py>>(&self, name: &str) -> PyResult<Option<T>> {
        let Some(given) = self.get(name) else { return Ok(None) };
        given.extract().map(Some).map_err(|error: T::Error| {
            let (error, py): (PyErr, _) = (error.into(), given.py());
            let said = error.value(py).to_string();
            if said.starts_with(name) {
                return error;
            }
            PyErr::from_type(error.get_type(py), format!("{name}: {said}"))
        })
    }

    /// What stands there, as the value of a scene's key.
    ///
    /// # Errors
    /// As [`value_of`].
    pub fn value<T>(&self, name: &'static str, read: Reader<T>) -> PyResult<Option<T>> {
        self.get(name).map(|given| value_of(name, &given, read)).transpose()
    }

    /// Whether floats of colours are linear: the argument `color_space`, which is "srgb" by default.
    ///
    /// # Errors
    /// As [`value_of`].
    pub fn is_linear(&self) -> PyResult<bool> {
        Ok(self.value("color_space", schema::color_space)? == Some(ColorSpace::Linear))
    }

    /// Returns the arguments with linear colours, for these names and in planes and lights.
    ///
    /// # Errors
    /// [`SceneError`] names the colour that cannot be read.
    pub fn with_linear_colors(self, names: &[&str], is_linear: bool) -> PyResult<Keywords<'py>> {
        let made = helpers(self.0.py())?.call_method1("in_linear", (&self.0, names, is_linear))?;
        Ok(Keywords(made.cast_into()?))
    }

    /// The lines of a scene file for what is there of these names.
    ///
    /// # Errors
    /// `TypeError` for what a scene file can't hold.
    pub fn lines(&self, names: &[&str]) -> PyResult<Vec<String>> {
        helpers(self.0.py())?.call_method1("lines", (names, &self.0))?.extract()
    }
}

/// A table in a line.
pub fn inline(lines: &[String]) -> String {
    format!("{{ {} }}", lines.join(", "))
}

/// The names of the keys of a table of scene files.
pub fn keys_of<S: Section>() -> Vec<&'static str> {
    S::INFO.keys.iter().map(|key| key.name).collect()
}

/// What keys of a table of scene files say.
///
/// # Errors
/// As [`scene_of`].
pub fn section<S: Section>(lines: &[String]) -> PyResult<S> {
    if lines.is_empty() {
        return Ok(S::default());
    }
    read_value(S::INFO.header, &inline(lines), schema::table)
        .map_err(|fault| wrong_argument(fault.subject.key.unwrap_or_default(), &fault))
}

/// A scene of lines, before each of which the argument stands that it is of.
///
/// # Errors
/// [`SceneError`] as the reader finds it.
pub fn scene_of(lines: &[(String, String)]) -> PyResult<Scene> {
    let text: Vec<&str> = lines.iter().map(|(_, line)| &**line).collect();
    parse_scene(&text.join("\n"), Path::new("arguments")).map_err(|error| match error {
        Error::Scene(fault) => {
            let line = lines.get(fault.line.wrapping_sub(1));
            let subject = line.map_or("arguments", |(subject, _)| subject);
            wrong_argument(subject, &fault)
        }
        other => exception(other, ""),
    })
}

/// The exception for an argument that the scene's reader refuses.
fn wrong_argument(subject: &str, fault: &kugelblitz::error::SceneError) -> PyErr {
    let text = Message::new(fault.message.as_str(), fault.hint.clone()).worded(argument);
    SceneError::new_err(if subject.is_empty() { text } else { format!("{subject}: {text}") })
}

/// The value of a scene's key, out of the argument `name`.
///
/// # Errors
/// As [`scene_of`].
pub fn value_of<T>(name: &'static str, given: &Bound<'_, PyAny>, read: Reader<T>) -> PyResult<T> {
    read_value(name, &value(name, given)?, read).map_err(|fault| wrong_argument(name, &fault))
}

/// The value of a scene file that an object stands for, in TOML.
///
/// # Errors
/// `TypeError` for what a scene file can't hold.
pub fn value(subject: &str, it: &Bound<'_, PyAny>) -> PyResult<String> {
    helpers(it.py())?.call_method1("toml", (subject, it))?.extract()
}

/// What reads arguments, in Python.
pub fn helpers(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("kugelblitz._given")
}

/// What serde writes, as Python's dictionaries, lists and numbers: by JSON.
///
/// # Errors
/// `ValueError` for what JSON can't hold.
pub fn to_python<'py>(py: Python<'py>, all: &impl Serialize) -> Object<'py> {
    let json = serde_json::to_string(all);
    let json = json.map_err(|error| PyValueError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (json,))
}

/// Returns the linear colour of a value in TOML, whose floats are encoded in sRGB unless `is_linear`; `subject` names it
/// in errors.
///
/// # Errors
/// [`SceneError`] for any other value.
#[pyfunction]
pub fn linear_color(subject: &str, toml: &str, is_linear: bool) -> PyResult<[f64; 3]> {
    let names = ["background", "missing_color", "ambient"];
    let name = names.into_iter().find(|name| subject == *name).unwrap_or("color");
    let read = if is_linear { schema::color } else { schema::srgb_color };
    let color = read_value(name, toml, read).map_err(|fault| wrong_argument(subject, &fault))?;
    Ok(color.0)
}
