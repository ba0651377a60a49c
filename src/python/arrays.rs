//! Arrays of states: numpy arrays as pickle brings them, checked.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::state::Parts;
use crate::digest;
use crate::error::{Error, Result};

/// An array of a state: of this type and shape (`None` = any length), contiguous; the very object where it is that already.
pub fn stored<'py, T: numpy::Element>(
    py: Python<'py>,
    parts: &Parts<'py>,
    index: usize,
    shape: &[Option<usize>],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let value = &parts.arrays[index];
    let wrong = |what: String| parts.error(py, format!("array {index} is {what}"));
    // Another byte order is that of another machine; every other difference of types is damage.
    let same_type = || -> PyResult<bool> {
        let ndarray = py.import("numpy")?.getattr("ndarray")?;
        if !value.get_type().is(&ndarray) {
            return Ok(false);
        }
        value.getattr("dtype")?.call_method1("newbyteorder", ("=",))?.eq(T::get_dtype(py))
    };
    if !same_type()? {
        return Err(wrong("no array of its type".into()));
    }
    let options = PyDict::new(py);
    options.set_item("requirements", ["C_CONTIGUOUS", "ALIGNED"])?;
    let required = py.import("numpy")?.call_method("require", (value, T::get_dtype(py)), Some(&options))?;
    let array = required.cast_into::<PyArrayDyn<T>>()?;
    let actual = array.shape();
    if actual.len() != shape.len() || actual.iter().zip(shape).any(|(&n, side)| side.is_some_and(|side| side != n)) {
        return Err(wrong(format!("of shape {actual:?}")));
    }
    Ok(array)
}

/// A borrowed array of a state.
pub fn borrowed<'py, T: numpy::Element>(
    py: Python<'py>,
    parts: &Parts<'py>,
    index: usize,
    shape: &[Option<usize>],
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let array = stored::<T>(py, parts, index, shape)?;
    array.try_readonly().map_err(|e| parts.error(py, e))
}

/// Whether two lists of numbers are equal, NaN to NaN.
pub fn equal_lists<T: digest::Element + PartialEq>(a: &[T], b: &[T]) -> bool {
    // A NaN is what does not equal itself.
    #[allow(clippy::eq_op)]
    let same = |(x, y): (&T, &T)| x == y || (x != x && y != y);
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// The first `rows` rows of `width` numbers.
pub fn cut<'a, T>(rest: &mut &'a [T], rows: u32, width: usize) -> Result<&'a [T]> {
    let (first, others) = rest.split_at_checked((rows as usize).saturating_mul(width)).ok_or_else(uncounted)?;
    *rest = others;
    Ok(first)
}

/// The error for arrays whose lengths do not fit each other.
pub fn uncounted() -> Error {
    Error::argument("counts", "as many rows as arrays have", "others", "take all of them from one scene")
}
