//! Whatever goes wrong on a device becomes an [`Error::Device`].

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};

/// What a closure gives, a panic inside it turned into an [`Error::Device`].
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        Err(Error::Device {
            what: format!("the graphics library gave up: {}", text.unwrap_or("no reason given").trim()),
            fix: "make a new renderer, or use backend \"cpu\"".into(),
        })
    })
}

/// The value of a mutex, whatever happened to threads that held it: every holder leaves it whole.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The error that wgpu reports.
pub(super) fn from_wgpu(error: &wgpu::Error) -> Error {
    match error {
        wgpu::Error::OutOfMemory { .. } => Error::Device {
            what: "out of device memory".into(),
            fix: "choose a smaller size or fewer maps, or use backend \"cpu\"".into(),
        },
        wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => Error::Device {
            what: description.split_whitespace().collect::<Vec<_>>().join(" "),
            fix: "please report this; backend \"cpu\" does without the device".into(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_inside_becomes_an_error() {
        let error = guarded::<()>(|| panic!("device {}", "lost")).unwrap_err();
        assert!(matches!(&error, Error::Device { what, .. } if what.contains("device lost")), "{error}");
        assert_eq!(guarded(|| Ok(1)), Ok(1));
    }
}
