//! How long work tells how far it is, and learns that it should stop.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

use crate::error::{Error, Result};

/// Shared between the thread that works and the one that watches.
#[derive(Debug, Default)]
pub struct Progress {
    stop: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
}

impl Progress {
    /// A fresh one; the total is set by whoever does the work.
    pub fn new() -> Self {
        Self::default()
    }
    /// Asks the work to stop at its next check.
    pub fn stop(&self) {
        self.stop.store(true, Relaxed);
    }
    /// [`Error::Interrupted`] once somebody asked to stop. Cheap enough for every tile or row.
    pub fn check(&self) -> Result<()> {
        if self.stop.load(Relaxed) { Err(Error::Interrupted) } else { Ok(()) }
    }
    /// Says how many steps there will be.
    pub fn set_total(&self, steps: u64) {
        self.total.store(steps, Relaxed);
        self.done.store(0, Relaxed);
    }
    /// Counts finished steps.
    pub fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Relaxed);
    }
    /// (done, total).
    pub fn state(&self) -> (u64, u64) {
        (self.done.load(Relaxed), self.total.load(Relaxed))
    }
}
