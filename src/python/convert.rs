//! The only place where numpy meets glam, core errors become exceptions, and long work is watched for Ctrl-C.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use glam::{DMat4, DVec3, DVec4};
use numpy::{
    Element, PyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods,
};
use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::threads;

/// Between two looks at pending signals: short enough for a person, long enough to cost nothing.
const SIGNAL_POLL: Duration = Duration::from_millis(50);

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

/// Runs long work without the GIL on the pool's threads, while this one watches for Ctrl-C and calls `report(done, total)`.
///
/// The work must not wait for a lock that is held while other work runs: a thread of the pool that waits for the rest of its
/// work begins what else there is to do, and may so come to wait for itself. Callers take such locks before.
pub fn run_watched<T: Send>(
    py: Python<'_>,
    report: Option<Py<PyAny>>,
    work: impl FnOnce(&Progress) -> Result<T> + Send,
) -> PyResult<T> {
    let progress = Progress::new();
    let pool = threads::pool().or_raise(py)?;
    let outcome = py.detach(|| {
        pool.in_place_scope(|scope| {
            let (sender, receiver) = channel();
            let progress = &progress;
            scope.spawn(move |_| {
                // Nobody listens any more only if the watcher itself has panicked.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(progress))));
            });
            let mut raised = None;
            loop {
                match receiver.recv_timeout(SIGNAL_POLL) {
                    Ok(done) => return (done, raised),
                    Err(RecvTimeoutError::Timeout) => (),
                    Err(RecvTimeoutError::Disconnected) => unreachable!("the work sends, whatever becomes of it"),
                }
                let watched = Python::attach(|py| {
                    py.check_signals()?;
                    if let Some(report) = &report {
                        report.call1(py, progress.state())?;
                    }
                    Ok::<_, PyErr>(())
                });
                if let (Err(e), None) = (watched, &raised) {
                    raised = Some(e);
                    progress.stop();
                }
            }
        })
    });
    match outcome {
        (_, Some(raised)) => Err(raised),
        (Ok(result), None) => {
            if let (Some(report), true) = (report, result.is_ok()) {
                let total = progress.state().1;
                report.call1(py, (total, total))?;
            }
            result.or_raise(py)
        }
        (Err(panic), None) => {
            let what = panic.downcast_ref::<String>().cloned();
            let what = what.or_else(|| panic.downcast_ref::<&str>().map(|s| s.to_string())).unwrap_or_default();
            let message = format!("a defect in shadowlab, please report it with what you called: {what}");
            Err(exception(py, "InternalError", message))
        }
    }
}

/// A numpy view of any array-like, of the given shape (`None` = any length; no sides at all = any shape), converted to `T`
/// where needed.
pub fn array<'py, T: Element>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Option<usize>],
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = value.py();
    let expected = || {
        let sides: Vec<String> = shape.iter().map(|n| n.map_or("N".into(), |n| n.to_string())).collect();
        let comma = if shape.len() == 1 { "," } else { "" };
        format!("an array of shape ({}{comma}) of {}", sides.join(", "), T::get_dtype(py))
    };
    let fits = |actual: &[usize]| {
        shape.is_empty()
            || actual.len() == shape.len() && actual.iter().zip(shape).all(|(&a, s)| s.is_none_or(|s| s == a))
    };
    let asarray = || -> PyResult<Bound<'py, PyArrayDyn<T>>> {
        let numpy = py.import("numpy")?;
        let kwargs = PyDict::new(py);
        let raw = numpy.call_method1("asarray", (value,))?;
        if raw.getattr("size")?.extract::<usize>()? == 0 {
            // An empty list has the dtype float64, whatever it is meant to hold.
            kwargs.set_item("dtype", T::get_dtype(py))?;
            kwargs.set_item("order", "C")?;
            return Ok(numpy.call_method("asarray", (raw,), Some(&kwargs))?.cast_into::<PyArrayDyn<T>>()?);
        }
        kwargs.set_item("casting", "same_kind")?;
        kwargs.set_item("order", "C")?;
        let kind: String = raw.getattr("dtype")?.getattr("kind")?.extract()?;
        let wanted = T::get_dtype(py);
        // Unsigned indices are fine; truth values and real numbers as indices are not.
        if kind == "b" {
            return Err(pyo3::exceptions::PyTypeError::new_err("truth values are no numbers"));
        }
        if kind == "u" && wanted.getattr("kind")?.extract::<String>()? == "i" {
            kwargs.set_item("casting", "unsafe")?;
        }
        Ok(raw.call_method("astype", (wanted,), Some(&kwargs))?.cast_into::<PyArrayDyn<T>>()?)
    };
    // numpy allows arrays whose elements straddle their natural alignment; a slice may not.
    let usable =
        |a: &&Bound<'py, PyArrayDyn<T>>| a.is_c_contiguous() && (a.data() as usize).is_multiple_of(align_of::<T>());
    let direct = value.cast::<PyArrayDyn<T>>().ok().filter(usable).cloned();
    let converted = match direct {
        Some(a) => a,
        None => {
            // numpy's reason says more than the value does only where that is no text.
            let got = |e: PyErr| match value.is_instance_of::<PyString>() {
                true => shown(value),
                false => format!("{} ({})", shown(value), e.value(py)),
            };
            asarray().map_err(|e| argument_error(py, name, expected(), got(e), "convert it first"))?
        }
    };
    if !fits(converted.shape()) {
        return Err(argument_error(py, name, expected(), format!("shape {:?}", converted.shape()), "reshape it"));
    }
    Ok(converted.readonly())
}

/// What came, for messages: on one line, and no longer than one can read.
pub fn shown(value: &Bound<'_, PyAny>) -> String {
    const MOST: usize = 80;
    let text = value.repr().map(|r| r.to_string()).unwrap_or_default();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line,
    }
}

/// A real number; truth values and text are none.
pub fn number(value: &Bound<'_, PyAny>, name: &str, fix: &'static str) -> PyResult<f64> {
    let found = if value.is_instance_of::<PyBool>() { None } else { value.extract::<f64>().ok() };
    found.ok_or_else(|| argument_error(value.py(), name, "a number", shown(value), fix))
}

/// Three numbers.
pub fn vec3(value: &Bound<'_, PyAny>, name: &str) -> PyResult<DVec3> {
    if let Ok(v) = value.extract::<[f64; 3]>() {
        return Ok(DVec3::from_array(v));
    }
    let a = array::<f64>(value, name, &[Some(3)])?;
    Ok(DVec3::from_slice(a.as_slice()?))
}

/// Rows of three numbers as a borrowed slice.
pub fn rows3<'a, T: Element>(a: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<&'a [[T; 3]]> {
    Ok(a.as_slice()?.as_chunks::<3>().0)
}

/// A 4x4 matrix from its sixteen row-major numbers.
pub fn mat4_from_rows(rows: &[f64]) -> DMat4 {
    DMat4::from_cols_slice(rows).transpose()
}

/// A (4, 4) array, row-major, acting on columns.
pub fn mat4_to_array<'py>(py: Python<'py>, m: &DMat4) -> PyResult<Bound<'py, PyArray2<f64>>> {
    PyArray1::from_slice(py, &m.transpose().to_cols_array()).reshape([4, 4])
}

/// A vector as (3,).
pub fn vec3_to_array<'py>(py: Python<'py>, v: DVec3) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, &v.to_array())
}

/// A homogeneous point as (4,).
pub fn vec4_to_array<'py>(py: Python<'py>, v: DVec4) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, &v.to_array())
}

/// An image of any number of axes that takes over the vector: nothing is copied.
pub fn image<'py, T: Element, const N: usize>(
    py: Python<'py>,
    data: Vec<T>,
    shape: [usize; N],
) -> PyResult<Bound<'py, PyArray<T, numpy::ndarray::Dim<[usize; N]>>>>
where
    [usize; N]: numpy::ndarray::IntoDimension<Dim = numpy::ndarray::Dim<[usize; N]>>,
    numpy::ndarray::Dim<[usize; N]>: numpy::ndarray::Dimension,
{
    PyArray1::from_vec(py, data).reshape(shape)
}

/// An argument that must be one of our classes, or an `ArgumentError` that says what to make of what came.
pub fn instance_of<'py, T: PyTypeInfo>(
    value: &Bound<'py, PyAny>,
    name: &str,
    fix: &'static str,
) -> PyResult<Bound<'py, T>> {
    value.cast::<T>().cloned().map_err(|_| {
        let got = value.get_type().fully_qualified_name().map(|n| n.to_string()).unwrap_or_default();
        let expected = value.py().get_type::<T>().name().map(|n| n.to_string()).unwrap_or_default();
        argument_error(value.py(), name, format!("a shadowlab.{expected}"), got, fix)
    })
}

/// Texels along the sides of a map, 1024 where none are given.
pub fn texels(resolution: Option<&Bound<'_, PyAny>>) -> PyResult<[u32; 2]> {
    resolution.map_or(Ok([1024; 2]), |value| size2(value, "resolution"))
}

/// A count of texels or pixels: one positive whole number, or a pair (width, height).
pub fn size2(value: &Bound<'_, PyAny>, name: &'static str) -> PyResult<[u32; 2]> {
    let py = value.py();
    let sides: Option<[i64; 2]> = match value.extract::<i64>() {
        Ok(n) => Some([n, n]),
        Err(_) => value.extract::<[i64; 2]>().ok(),
    };
    let limit = crate::render::MAX_IMAGE_SIDE;
    match sides {
        Some(sides) if sides.iter().all(|&n| (1..=i64::from(limit)).contains(&n)) => Ok(sides.map(|n| n as u32)),
        _ => {
            let expected = format!("a whole number or a pair (width, height) between 1 and {limit}");
            Err(argument_error(py, name, expected, shown(value), "choose another size"))
        }
    }
}
