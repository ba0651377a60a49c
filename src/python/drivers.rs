//! What loads graphics drivers: the list of adapters, and renderers on a device.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

use pyo3::prelude::*;

use super::arguments::{word, word_or};
use super::convert::OrRaise;
use crate::error::Error;
use crate::render::Renderer;
use crate::render::cpu::CpuRenderer;
use crate::threads::in_time;

/// The first process of this line of forks that looked at graphics drivers, 0 for none.
static FIRST_LOOK: AtomicU32 = AtomicU32::new(0);
/// How many threads look at drivers with a folder of ours in the environment.
static LOOKING: AtomicUsize = AtomicUsize::new(0);
/// How long drivers are waited for that were loaded before a fork. Most open a device then as well, in a tenth of a second; one
/// that waits for threads or locks of the parent never does.
const PATIENCE: Duration = Duration::from_secs(8);

/// The graphics adapters of this machine: one dictionary each. Loads the graphics drivers.
#[pyfunction]
pub fn adapters(py: Python<'_>) -> PyResult<Vec<std::collections::BTreeMap<&'static str, String>>> {
    #[cfg(feature = "gpu")]
    {
        let found = looking_at_drivers(py, || Ok(crate::render::gpu::adapters()))?.or_raise(py)?;
        let dict = |a: crate::render::gpu::AdapterInfo| {
            [("name", a.name), ("backend", a.backend), ("device_type", a.device_type), ("driver", a.driver)].into()
        };
        Ok(found.into_iter().map(dict).collect())
    }
    #[cfg(not(feature = "gpu"))]
    {
        let _ = py;
        Ok(Vec::new())
    }
}

/// The renderer of a backend, "auto" where none is given.
pub(super) fn made(
    py: Python<'_>,
    backend: Option<&Bound<'_, PyAny>>,
    adapter: Option<&Bound<'_, PyAny>>,
) -> PyResult<crate::Result<Arc<dyn Renderer>>> {
    let cpu = || -> crate::Result<Arc<dyn Renderer>> { Ok(Arc::new(CpuRenderer::new())) };
    let adapter = adapter.map(|adapter| word(adapter, "adapter", "part of the name of an adapter")).transpose()?;
    let backend = word_or(backend, "backend", "auto", "one of auto, cpu, gpu")?;
    Ok(match backend.as_str() {
        "cpu" => cpu(),
        "gpu" => looking_at_drivers(py, move || gpu(adapter.as_deref()))?,
        "auto" if adapter.is_some() => looking_at_drivers(py, move || gpu(adapter.as_deref()))?,
        "auto" => looking_at_drivers(py, move || if hardware_adapter() { gpu(None) } else { cpu() })?,
        other => Err(Error::UnknownName {
            kind: "backend".into(),
            name: other.into(),
            valid: ["auto", "cpu", "gpu"].map(String::from).into(),
        }),
    })
}

/// Runs what loads graphics drivers, without the GIL. Where no XDG_RUNTIME_DIR is set, as in containers and notebooks
/// over ssh, it is while this runs: Mesa prints an error otherwise, though nothing here needs that folder.
///
/// Drivers that a forked process inherits may never answer: that is an error after some seconds.
fn looking_at_drivers<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> crate::Result<T> + Send + 'static,
) -> PyResult<crate::Result<T>> {
    const NAME: &str = "XDG_RUNTIME_DIR";
    let environment = py.import("os")?.getattr("environ")?;
    // By whoever looks first; it goes with the last one who looks.
    let added = cfg!(target_os = "linux") && (LOOKING.load(SeqCst) > 0 || !environment.contains(NAME)?);
    if added {
        LOOKING.fetch_add(1, SeqCst);
        environment.set_item(NAME, py.import("tempfile")?.call_method0("gettempdir")?)?;
    }
    let process = std::process::id();
    let first = FIRST_LOOK.compare_exchange(0, process, SeqCst, SeqCst).unwrap_or_else(|first| first);
    let is_inherited = first != 0 && first != process;
    if first == 0 {
        leave_children_quietly(py)?;
    }
    let done = py.detach(|| match is_inherited {
        true => in_time(work, PATIENCE).unwrap_or_else(|| {
            let what = "the drivers, which were loaded before this process was forked, do not answer".into();
            let fix = "start workers by \"spawn\" or \"forkserver\", or use backend \"cpu\"".into();
            Err(Error::Device { what, fix })
        }),
        false => work(),
    });
    if added && LOOKING.fetch_sub(1, SeqCst) == 1 {
        environment.call_method1("pop", (NAME, py.None()))?;
    }
    Ok(done)
}

/// Has the children of this process leave without what the drivers registered to do at its end.
///
/// Mesa waits there for its threads by handles that mean other threads in a child, or freed memory: a crash.
fn leave_children_quietly(py: Python<'_>) -> PyResult<()> {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use std::ffi::{c_int, c_void};

        use pyo3::types::{PyCFunction, PyDict};

        unsafe extern "C" {
            fn on_exit(function: extern "C" fn(c_int, *mut c_void), argument: *mut c_void) -> c_int;
            fn fflush(stream: *mut c_void) -> c_int;
            fn _exit(status: c_int) -> !;
        }
        /// Ends the process before the functions run that were registered earlier, in the parent.
        extern "C" fn leave(status: c_int, _: *mut c_void) {
            // SAFETY: null means all streams; nothing of this process runs after that.
            unsafe {
                fflush(std::ptr::null_mut());
                _exit(status)
            }
        }
        // SAFETY: the function lives as long as the process. Without memory for the entry the child ends as it would have.
        let in_child =
            PyCFunction::new_closure(py, None, None, |_, _| unsafe { on_exit(leave, std::ptr::null_mut()) })?;
        let keywords = PyDict::new(py);
        keywords.set_item("after_in_child", in_child)?;
        py.import("os")?.call_method("register_at_fork", (), Some(&keywords))?;
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    let _ = py;
    Ok(())
}

/// A renderer on the adapter of that name, or on the best one.
#[cfg(feature = "gpu")]
fn gpu(adapter: Option<&str>) -> crate::Result<Arc<dyn Renderer>> {
    Ok(Arc::new(crate::render::gpu::GpuRenderer::new(adapter)?))
}

/// Whether there is an adapter that is no software.
#[cfg(feature = "gpu")]
fn hardware_adapter() -> bool {
    crate::render::gpu::adapters().iter().any(|a| a.device_type != "cpu")
}

/// The error that says that there is none.
#[cfg(not(feature = "gpu"))]
fn gpu(adapter: Option<&str>) -> crate::Result<Arc<dyn Renderer>> {
    let fix = "this build has no GPU renderer: build with the feature \"gpu\", or use backend \"cpu\"";
    Err(Error::NoAdapter { wanted: adapter.map(String::from), found: Vec::new(), fix: fix.into() })
}

/// None that this build could use.
#[cfg(not(feature = "gpu"))]
fn hardware_adapter() -> bool {
    false
}
