//! Memory of finished calls for the next ones.

use std::sync::Mutex;

use super::{raster, uneven_lattice};
use crate::error::Result;

/// Scratch memory of one call.
#[derive(Debug, Default)]
pub struct Scratch {
    pub raster: raster::Scratch,
    pub lattice: uneven_lattice::Scratch,
}

/// Scratch memory that no call uses. Nobody waits for it: after a fork the lock may be held by a thread that does not exist.
#[derive(Debug, Default)]
pub struct Scratches(Mutex<Vec<Scratch>>);

impl Scratches {
    /// Runs with scratch memory that no other call uses.
    pub fn lend<T>(&self, work: impl FnOnce(&mut Scratch) -> Result<T>) -> Result<T> {
        let mut scratch = self.0.try_lock().ok().and_then(|mut free| free.pop()).unwrap_or_default();
        let result = work(&mut scratch);
        scratch.raster.shrink();
        scratch.lattice.shrink();
        if let Ok(mut free) = self.0.try_lock() {
            free.push(scratch);
        }
        result
    }

    /// Gives all of it back.
    pub fn release(&self) {
        if let Ok(mut free) = self.0.try_lock() {
            *free = Vec::new();
        }
    }
}
