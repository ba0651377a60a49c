//! How many threads parallel work has.

use pyo3::prelude::*;

use super::arguments::whole_number;
use super::convert::{OrRaise, argument_error, shown};
use crate::threads;

/// Sets how many threads parallel work has from now on, in this process and in those forked from it later.
///
/// Results do not depend on it. Work that another thread has begun ends with the threads it has. No thread is started
/// before there is parallel work.
///
/// Parameters
/// ----------
/// n : int or None
///     Threads, 1 to 1024. None goes back to the default: what the environment variable SHADOWLAB_THREADS says, else as many
///     as there are cores that this process may use.
///
/// Raises
/// ------
/// ArgumentError
///     For another number, 0 included, or what is no whole number.
#[pyfunction]
pub fn set_threads(py: Python<'_>, n: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let Some(n) = n else { return threads::set(None).or_raise(py) };
    let wanted = whole_number(n)?.and_then(|n| usize::try_from(n).ok()).filter(|n| (1..=threads::MOST).contains(n));
    let Some(wanted) = wanted else {
        let expected = format!("a whole number between 1 and {}, or None", threads::MOST);
        return Err(argument_error(py, "n", expected, shown(n), "None means as many as there are cores"));
    };
    threads::set(Some(wanted)).or_raise(py)
}

/// How many threads parallel work has.
///
/// As `set_threads` or the environment variable SHADOWLAB_THREADS says, else as many as there are cores that this
/// process may use.
///
/// Returns
/// -------
/// int
///
/// Raises
/// ------
/// ArgumentError
///     Where SHADOWLAB_THREADS is no whole number from 1 to 1024; so does the first parallel work.
#[pyfunction(name = "threads")]
pub fn thread_count(py: Python<'_>) -> PyResult<usize> {
    threads::count().or_raise(py)
}
