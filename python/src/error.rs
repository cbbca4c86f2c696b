//! The library's errors as Python's exceptions, and warnings.

use std::ffi::CString;

use kugelblitz::Error;
use kugelblitz::error::{Setting, SettingValue};
use kugelblitz::words::joined;
use pyo3::create_exception;
use pyo3::exceptions::{
    PyAssertionError, PyKeyboardInterrupt, PyMemoryError, PyOSError, PyRuntimeError, PyTypeError,
    PyValueError,
};
use pyo3::prelude::*;
use pyo3::type_object::PyTypeInfo;

create_exception!(
    kugelblitz,
    SceneError,
    PyValueError,
    "A scene, or a file that it names, is wrong."
);
create_exception!(kugelblitz, NoAdapterError, PyRuntimeError, "No Vulkan device fits.");
create_exception!(
    kugelblitz,
    DeviceError,
    PyRuntimeError,
    "The device was lost, failed, or took too long."
);

/// The exception for an error; `subject` is the argument that it is about, where there is one.
pub fn exception(error: Error, subject: &str) -> PyErr {
    if let Error::Io { path, source } = &error
        && let Some(number) = source.raw_os_error()
    {
        // Python chooses the class for the number: `FileNotFoundError` and others.
        let said = source.to_string();
        let reason = said.split(" (os error").next().unwrap_or(&said).to_string();
        return PyOSError::new_err((number, reason, path.display().to_string()));
    }
    let hint = match &error {
        Error::Scene(scene) if !scene.is_about_bare_data() => scene.hint.to_string(),
        error => error.hint().worded(argument),
    };
    let text = if hint.is_empty() { error.to_string() } else { format!("{error}; {hint}") };
    let text = if subject.is_empty() { text } else { format!("{subject}: {text}") };
    match error {
        Error::Scene(_) => SceneError::new_err(text),
        Error::Usage(_) | Error::Input { .. } => PyValueError::new_err(text),
        Error::Io { .. } => PyOSError::new_err(text),
        Error::NoAdapter(_) => NoAdapterError::new_err(text),
        Error::Device(_) => DeviceError::new_err(text),
        Error::Comparison(_) => PyAssertionError::new_err(text),
        Error::TooLarge(_) => PyMemoryError::new_err(text),
        Error::Interrupted => PyKeyboardInterrupt::new_err(text),
        Error::Shader(_) | Error::Host(_) => PyRuntimeError::new_err(text),
    }
}

/// Returns a setting as an argument: `columns={"radius": False}`.
pub fn argument(Setting { key, value }: &Setting) -> String {
    match value {
        None => format!("`{key}`"),
        Some(value) => format!("`{key}={}`", object(value)),
    }
}

/// Returns the value of an argument as Python writes it.
fn object(value: &SettingValue) -> String {
    match value {
        SettingValue::Text(text) => format!("{text:?}"),
        SettingValue::Number(number) => number.clone(),
        SettingValue::Present => "True".into(),
        SettingValue::Absent => "False".into(),
        SettingValue::Table(entries) => {
            let entries =
                entries.iter().map(|(name, value)| format!("{name:?}: {}", object(value)));
            format!("{{{}}}", joined(entries, ", "))
        }
    }
}

/// For `map_err`.
pub fn of(subject: &str) -> impl FnOnce(Error) -> PyErr {
    move |error| exception(error, subject)
}

/// Warns the user by a warning of this class.
pub fn warn<W: PyTypeInfo>(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<W>(), &text, 2)
}

/// `ValueError` with this message.
///
/// # Errors
/// Always.
pub fn wrong_value<T>(message: impl Into<String>) -> PyResult<T> {
    Err(PyValueError::new_err(message.into()))
}

/// `TypeError` with this message.
///
/// # Errors
/// Always.
pub fn wrong_type<T>(message: impl Into<String>) -> PyResult<T> {
    Err(PyTypeError::new_err(message.into()))
}
