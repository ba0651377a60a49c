//! Settings of techniques as Python has them.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::parameterization::Value;

/// A dictionary of settings.
pub fn settings_dict<'py>(py: Python<'py>, settings: &[(&'static str, Value)]) -> PyResult<Bound<'py, PyDict>> {
    let d = PyDict::new(py);
    for (name, value) in settings {
        match value {
            Value::Number(x) => d.set_item(name, x)?,
            Value::Integer(x) => d.set_item(name, x)?,
            Value::Flag(x) => d.set_item(name, x)?,
            Value::Choice(x) => d.set_item(name, x)?,
            Value::Numbers(x) => d.set_item(name, PyTuple::new(py, x)?)?,
        }
    }
    Ok(d)
}

/// A setting as Python would write it.
pub fn value_text(value: &Value) -> String {
    match value {
        Value::Number(x) => format!("{x}"),
        Value::Integer(x) => format!("{x}"),
        Value::Flag(x) => if *x { "True" } else { "False" }.to_string(),
        Value::Choice(x) => format!("{x:?}"),
        Value::Numbers(_) => value.to_string(),
    }
}
