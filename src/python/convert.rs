//! The only place where results become numpy arrays, and long work is watched for Ctrl-C.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use glam::{DMat4, DVec3, DVec4};
use numpy::{Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;

pub use super::arguments::{array, instance_of, number, shown, size2, texels, vec3};
pub use super::exceptions::{OrRaise, argument_error, exception, to_exception};
use crate::error::Result;
use crate::progress::Progress;
use crate::threads;

/// Between two looks at pending signals: a twentieth of what a person notices as a wait, and it costs nothing.
const SIGNAL_POLL: Duration = Duration::from_millis(10);
/// Where Python keeps what shows progress.
const PROGRESS: &str = "shadowlab.text.progress";
/// Looks at signals to a report.
const POLLS_PER_REPORT: u32 = 5;

/// Runs long work without the GIL on the pool's threads, while this one watches for Ctrl-C and calls `report(done, total)`.
/// Where there is no `report`, `shadowlab.text.progress.waiting` gives one for work that is not over at once.
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
    let mut shown = report.as_ref().map(|report| report.clone_ref(py));
    let (done, raised, shown) = py.detach(|| {
        pool.in_place_scope(|scope| {
            let (sender, receiver) = channel();
            let progress = &progress;
            scope.spawn(move |_| {
                // Nobody listens any more only if the watcher itself has panicked.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(progress))));
            });
            let mut raised = None;
            let mut polls = 0_u32;
            loop {
                match receiver.recv_timeout(SIGNAL_POLL) {
                    Ok(done) => return (done, raised, shown),
                    Err(RecvTimeoutError::Timeout) => (),
                    Err(RecvTimeoutError::Disconnected) => unreachable!("the work sends, whatever becomes of it"),
                }
                polls = polls.wrapping_add(1);
                let watched = Python::attach(|py| {
                    py.check_signals()?;
                    if polls.is_multiple_of(POLLS_PER_REPORT) {
                        let waiting = || PyResult::Ok(py.import(PROGRESS)?.call_method0("waiting")?.unbind());
                        let report = shown.take().map_or_else(waiting, Ok)?;
                        shown.insert(report).call1(py, progress.state())?;
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
    if let (Some(shown), None) = (shown, &report) {
        shown.call_method0(py, "close")?;
    }
    match (done, raised) {
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

/// Pixels or points that are looked at in some milliseconds.
pub const SOON: usize = 1 << 16;

/// Runs work as [`run_watched`] does where it may take long, and on this thread, which costs less, where it is over soon.
/// Work without parallel parts: those would get threads of rayon's own, which no child of a fork has; see [`run_parallel`].
pub fn run_sized<T: Send>(
    py: Python<'_>,
    takes_long: bool,
    work: impl FnOnce(&Progress) -> Result<T> + Send,
) -> PyResult<T> {
    if takes_long {
        return run_watched(py, None, work);
    }
    py.detach(|| work(&Progress::new())).or_raise(py)
}

/// The same of work with parallel parts, which are the pool's where it is over soon, too.
pub fn run_parallel<T: Send>(
    py: Python<'_>,
    takes_long: bool,
    work: impl FnOnce(&Progress) -> Result<T> + Send,
) -> PyResult<T> {
    let on_pool = |progress: &Progress| if takes_long { work(progress) } else { threads::install(|| work(progress))? };
    run_sized(py, takes_long, on_pool)
}

/// Calls `work` with one run of `0..n` after the other; where there are many, it may be stopped between two of them.
pub fn in_parts(py: Python<'_>, n: usize, mut work: impl FnMut(Range<usize>) -> Result<()> + Send) -> PyResult<()> {
    run_sized(py, n > SOON, |progress| {
        (0..n).step_by(SOON).try_for_each(|first| {
            progress.check()?;
            work(first..n.min(first + SOON))
        })
    })
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
