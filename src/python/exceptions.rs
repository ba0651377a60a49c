//! Core errors as exceptions of `shadowlab.errors`.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;

use crate::error::{Error, Result};

/// The exception for a core error; what the message is made of is in its attributes.
pub fn to_exception(py: Python<'_>, error: Error) -> PyErr {
    let class = match &error {
        Error::InvalidArgument { .. } => "ArgumentError",
        Error::UnknownName { .. } => "UnknownNameError",
        Error::FaceIndex { .. } | Error::EmptyScene { .. } => "SceneError",
        Error::UnsupportedLight { .. } | Error::UnsuitedView { .. } => "UnsupportedError",
        Error::NoAdapter { .. } | Error::Device { .. } => "DeviceError",
        Error::Interrupted => return pyo3::exceptions::PyKeyboardInterrupt::new_err(()),
    };
    let exception = exception(py, class, error.to_string());
    let (technique, reason) = error.refusal().unzip();
    for (name, text) in [("fix", error.fix()), ("technique", technique), ("reason", reason.as_deref())] {
        if let Some(Err(e)) = text.map(|text| exception.value(py).setattr(name, text)) {
            return e;
        }
    }
    exception
}

/// An exception of `shadowlab.errors` by the name of its class.
pub fn exception(py: Python<'_>, class: &str, message: String) -> PyErr {
    match py.import("shadowlab.errors").and_then(|m| m.getattr(class)).and_then(|c| c.call1((message,))) {
        Ok(instance) => PyErr::from_value(instance),
        Err(e) => e,
    }
}

/// Says something with a `ShadowlabWarning`; an error where the caller has warnings raised.
pub fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    let category = py.import("shadowlab.errors")?.getattr("ShadowlabWarning")?;
    PyErr::warn(py, &category, &std::ffi::CString::new(message)?, 1)
}

/// Turns a core result into a Python one.
pub trait OrRaise<T> {
    /// The value, or the exception.
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T> OrRaise<T> for Result<T> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|e| to_exception(py, e))
    }
}

/// An `ArgumentError`.
pub fn argument_error(
    py: Python<'_>,
    name: &str,
    expected: impl Into<String>,
    got: impl std::fmt::Display,
    fix: impl Into<String>,
) -> PyErr {
    to_exception(py, Error::argument(name.to_string(), expected.into(), got, fix.into()))
}

/// An error of somebody else's code; what is no `Exception` (Ctrl-C, the end of the process) is not to be kept from anybody.
pub fn refusable(py: Python<'_>, error: PyErr) -> PyResult<PyErr> {
    if error.is_instance_of::<PyException>(py) { Ok(error) } else { Err(error) }
}
