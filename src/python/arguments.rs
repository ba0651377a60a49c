//! Arguments as the core takes them: numbers, words, lists, arrays. Whatever comes, each ends in a value or in an error that
//! names the argument.
//!
//! What is exactly of the wanted type is read here. All else may be an object with methods of its own, which raise, or a
//! sequence that says anything of its length; `shadowlab.text.arrays` reads it, for Python's side as well.

use glam::DVec3;
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyFrozenSet, PyInt, PyList, PySet, PyString, PyTuple};

use super::exceptions::{argument_error, refusable};

/// A function of the module that reads what callers give.
fn reader<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("shadowlab.text.arrays")?.getattr(name)
}

/// A numpy view of any array-like, of the given shape (`None` = any length; no sides at all = any shape), converted to `T`
/// where needed.
pub fn array<'py, T: Element>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Option<usize>],
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = value.py();
    let fits = |actual: &[usize]| {
        shape.is_empty()
            || actual.len() == shape.len() && actual.iter().zip(shape).all(|(&a, s)| s.is_none_or(|s| s == a))
    };
    // numpy allows arrays whose elements straddle their natural alignment; a slice may not. Subclasses may mask values.
    let usable = |a: &&Bound<'py, PyArrayDyn<T>>| {
        a.get_type().is(PyUntypedArray::type_object(py))
            && a.is_c_contiguous()
            && (a.data() as usize).is_multiple_of(align_of::<T>())
            && fits(a.shape())
    };
    if let Some(found) = value.cast::<PyArrayDyn<T>>().ok().filter(usable) {
        return Ok(found.readonly());
    }
    let sides = if shape.is_empty() { None } else { Some(PyTuple::new(py, shape)?) };
    let made = reader(py, "checked_array")?.call1((name, value, T::get_dtype(py), sides))?;
    Ok(made.cast_into::<PyArrayDyn<T>>()?.readonly())
}

/// Rows of three numbers (N, 3), one for each row of another argument.
pub fn paired_rows<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    other: &str,
    rows: usize,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let found = array::<f64>(value, name, &[None, Some(3)])?;
    if found.shape()[0] == rows {
        return Ok(found);
    }
    let expected = format!("an array of shape ({rows}, 3), a row for each of {other},");
    Err(argument_error(value.py(), name, expected, format!("shape {:?}", found.shape()), "give as many of both"))
}

/// What came, for messages: on one line, and no longer than one can read.
pub fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value.py().import("shadowlab.text.words").and_then(|m| m.call_method1("shown", (value,)));
    text.and_then(|text| text.extract()).unwrap_or_else(|_| type_name(value))
}

/// The name of its type.
pub fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().fully_qualified_name().map(|n| n.to_string()).unwrap_or_default()
}

/// A real number; truth values and text are none.
pub fn number(value: &Bound<'_, PyAny>, name: &str, fix: &str) -> PyResult<f64> {
    if let Ok(exact) = value.cast_exact::<PyFloat>() {
        return exact.extract();
    }
    reader(value.py(), "checked_number")?.call1((name, value, fix))?.extract()
}

/// A real number, or the default where none is given.
pub fn number_or(value: Option<&Bound<'_, PyAny>>, name: &str, default: f64) -> PyResult<f64> {
    value.map_or(Ok(default), |value| number(value, name, "give a number"))
}

/// A whole number in a range; truth values are none.
pub fn whole(value: &Bound<'_, PyAny>, name: &str, range: [i64; 2], fix: &str) -> PyResult<i64> {
    let [least, most] = range;
    whole_number(value)?.filter(|n| (least..=most).contains(n)).ok_or_else(|| {
        let expected = if most == i64::MAX {
            format!("a whole number of {least} or more")
        } else {
            format!("a whole number from {least} to {most}")
        };
        argument_error(value.py(), name, expected, shown(value), fix)
    })
}

/// A whole number of 64 bits; nothing for what is none.
pub fn whole_number(value: &Bound<'_, PyAny>) -> PyResult<Option<i64>> {
    if value.is_instance_of::<PyBool>() {
        return Ok(None);
    }
    value.extract::<i64>().map(Some).or_else(|error| refusable(value.py(), error).map(|_| None))
}

/// Something to call.
pub fn callable(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Py<PyAny>> {
    if value.is_callable() {
        return Ok(value.clone().unbind());
    }
    let fix = "give a function, or None";
    Err(argument_error(value.py(), name, "a function of how much is done and of how much", shown(value), fix))
}

/// A text.
pub fn word(value: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyResult<String> {
    let text = value.cast::<PyString>().ok().and_then(|text| text.to_cow().ok().map(|text| text.into_owned()));
    text.ok_or_else(|| argument_error(value.py(), name, expected, shown(value), "give its name as text"))
}

/// A text, or the default where none is given.
pub fn word_or(value: Option<&Bound<'_, PyAny>>, name: &str, default: &str, expected: &str) -> PyResult<String> {
    value.map_or_else(|| Ok(default.to_string()), |value| word(value, name, expected))
}

/// The items of anything that can be gone through; text is none of that.
pub fn items<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    expected: &str,
    fix: &str,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let list = match value.cast_exact::<PyList>() {
        Ok(list) => list.clone(),
        Err(_) => reader(value.py(), "checked_items")?.call1((name, value, expected, fix))?.cast_into::<PyList>()?,
    };
    Ok(list.iter().collect())
}

/// Three numbers.
pub fn vec3(value: &Bound<'_, PyAny>, name: &str) -> PyResult<DVec3> {
    let is_number =
        |item: &Bound<'_, PyAny>| item.is_exact_instance_of::<PyFloat>() || item.is_exact_instance_of::<PyInt>();
    if let Ok(tuple) = value.cast_exact::<PyTuple>()
        && tuple.len() == 3
        && tuple.iter().all(|item| is_number(&item))
        && let Ok(v) = tuple.extract::<[f64; 3]>()
    {
        return Ok(DVec3::from_array(v));
    }
    let a = array::<f64>(value, name, &[Some(3)])?;
    Ok(DVec3::from_slice(a.as_slice()?))
}

/// An argument that must be one of our classes, or an `ArgumentError` that says what to make of what came.
pub fn instance_of<'py, T: PyTypeInfo>(
    value: &Bound<'py, PyAny>,
    name: &str,
    fix: &'static str,
) -> PyResult<Bound<'py, T>> {
    value.cast::<T>().cloned().map_err(|_| {
        let expected = value.py().get_type::<T>().name().map(|n| n.to_string()).unwrap_or_default();
        argument_error(value.py(), name, format!("a shadowlab.{expected}"), type_name(value), fix)
    })
}

/// Texels along the sides of a map, 1024 where none are given.
pub fn texels(resolution: Option<&Bound<'_, PyAny>>) -> PyResult<[u32; 2]> {
    resolution.map_or(Ok([1024; 2]), |value| size2(value, "resolution"))
}

/// A count of texels or pixels: one positive whole number, or a pair (width, height).
pub fn size2(value: &Bound<'_, PyAny>, name: &'static str) -> PyResult<[u32; 2]> {
    let py = value.py();
    let limit = crate::render::MAX_IMAGE_SIDE;
    let expected = || format!("a whole number or a pair (width, height) between 1 and {limit}");
    let sides: Option<[i64; 2]> = match whole_number(value)? {
        Some(n) => Some([n, n]),
        // A set has no order.
        None if value.is_instance_of::<PySet>() || value.is_instance_of::<PyFrozenSet>() => None,
        None => match items(value, name, &expected(), "choose another size")?.as_slice() {
            [width, height] => whole_number(width)?.zip(whole_number(height)?).map(|(w, h)| [w, h]),
            _ => None,
        },
    };
    match sides {
        Some(sides) if sides.iter().all(|&n| (1..=i64::from(limit)).contains(&n)) => Ok(sides.map(|n| n as u32)),
        _ => Err(argument_error(py, name, expected(), shown(value), "choose another size")),
    }
}
