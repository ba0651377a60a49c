//! How long work tells how far it is, and learns that it should stop.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

use crate::error::{Error, Result};

/// Shared between the thread that works and the one that watches.
#[derive(Debug, Default)]
pub struct Progress {
    stop: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    /// Of equal parts of the work, those that are done, and all of them but one.
    parts_done: AtomicU64,
    more_parts: AtomicU64,
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
    /// Says that part `k` of `n` equal parts begins; its steps are counted anew.
    pub fn begin_part(&self, k: usize, n: usize) {
        self.parts_done.store(k as u64, Relaxed);
        self.more_parts.store(n.saturating_sub(1) as u64, Relaxed);
        self.set_total(0);
    }
    /// Counts finished steps.
    pub fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Relaxed);
    }
    /// (done, total) in steps of the part that is being worked on; total is 0 where nobody said.
    pub fn state(&self) -> (u64, u64) {
        let (done, total) = (self.done.load(Relaxed), self.total.load(Relaxed));
        let (before, parts) = (self.parts_done.load(Relaxed), self.more_parts.load(Relaxed).saturating_add(1));
        (total.saturating_mul(before).saturating_add(done), total.saturating_mul(parts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_a_part_are_a_part_of_all() {
        let progress = Progress::new();
        assert_eq!(progress.state(), (0, 0));
        progress.set_total(10);
        progress.advance(4);
        assert_eq!(progress.state(), (4, 10));
        progress.begin_part(1, 4);
        progress.set_total(10);
        progress.advance(5);
        assert_eq!(progress.state(), (15, 40));
    }

    #[test]
    fn work_learns_that_it_should_stop() {
        let progress = Progress::new();
        assert!(progress.check().is_ok());
        progress.stop();
        assert_eq!(progress.check(), Err(Error::Interrupted));
    }
}
