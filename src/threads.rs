//! The threads that all parallel work of the Python package shares, made anew in a process that was forked.
//!
//! The core works in whichever rayon pool it is called from. Rust programs that do nothing about it get rayon's global pool;
//! they choose another by rayon's own means, or this one by [`install`]. Python always gets this one: rayon's global pool
//! cannot be made again, and the child of a fork inherits it without its threads, where the first call would wait for ever.
//!
//! A pool carries the number of the process that made it. Who asks for the pool in another process gets a new one. Nothing on
//! the way there waits for a lock, since a thread that held it at the moment of the fork does not exist in the child. The
//! pool of the parent is left in the child as it is: even to end it would take locks.

use std::ffi::{OsStr, OsString};
use std::mem::ManuallyDrop;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::mpsc::channel;
use std::time::Duration;

use arc_swap::ArcSwapOption;
use rayon::{Scope, ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, Result};

/// The environment variable that tells how many threads there are where [`set`] does not.
pub const VARIABLE: &str = "SHADOWLAB_THREADS";
/// Most threads of a pool. Chosen above the number of cores that share one memory in machines of today.
pub const MOST: usize = 1024;
/// Bytes of a thread's stack, reserved, not used. While a thread waits for the rest of one call it may begin another, so that
/// the stacks of several calls lie on one another: four times what a single one of Rust's threads has.
const STACK: usize = 8 << 20;

/// The pool of this process.
static CURRENT: Current = Current::new();

/// Runs work whose parallel parts use the pool, on one of its threads, and waits for it.
///
/// # Errors
/// [`Error::InvalidArgument`] where [`VARIABLE`] is no number of threads, or where the system refuses to start them.
pub fn install<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T> {
    Ok(pool()?.pool.install(work))
}

/// The pool of this process, made where it is not there yet.
///
/// # Errors
/// As [`install`].
pub fn pool() -> Result<Arc<Pool>> {
    CURRENT.pool(std::process::id())
}

/// How many threads parallel work has from now on; none for the default: what [`VARIABLE`] says, else all the cores that this
/// process may use. Work that has begun ends with the threads it has.
///
/// # Errors
/// [`Error::InvalidArgument`] unless the number is between 1 and [`MOST`].
pub fn set(threads: Option<usize>) -> Result<()> {
    CURRENT.set(threads)
}

/// How many threads parallel work has.
///
/// # Errors
/// [`Error::InvalidArgument`] where [`VARIABLE`] is no number of threads.
pub fn count() -> Result<usize> {
    CURRENT.count(std::process::id())
}

/// What the work gives on a thread of its own; nothing where that takes longer than the patience, or panics. A thread that takes
/// longer stays behind.
pub fn in_time<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static, patience: Duration) -> Option<T> {
    let (sender, receiver) = channel();
    std::thread::Builder::new().spawn(move || sender.send(work())).ok()?;
    receiver.recv_timeout(patience).ok()
}

/// Threads of one process.
#[derive(Debug)]
pub struct Pool {
    pool: ManuallyDrop<ThreadPool>,
    process: u32,
    /// What had been asked for when it was made, 0 for the default.
    asked: usize,
}

impl Pool {
    /// Calls `work` on this thread; what it spawns in the scope runs on the pool, and has ended when this returns.
    pub fn in_place_scope<'scope, T>(&self, work: impl FnOnce(&Scope<'scope>) -> T) -> T {
        self.pool.in_place_scope(work)
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        if self.process == std::process::id() {
            // SAFETY: dropped once, here. The threads end by themselves, nobody waits for them.
            unsafe { ManuallyDrop::drop(&mut self.pool) }
        }
    }
}

/// The pool in use, and how many threads the next one shall have.
struct Current {
    pool: ArcSwapOption<Pool>,
    /// 0 for the default.
    asked: AtomicUsize,
}

impl Current {
    const fn new() -> Self {
        Self { pool: ArcSwapOption::const_empty(), asked: AtomicUsize::new(0) }
    }

    fn pool(&self, process: u32) -> Result<Arc<Pool>> {
        loop {
            let found = self.pool.load();
            let asked = self.asked.load(SeqCst);
            if let Some(pool) = found.as_ref().filter(|pool| pool.process == process && pool.asked == asked) {
                return Ok(pool.clone());
            }
            let made = Arc::new(Pool { pool: ManuallyDrop::new(started(resolved(asked)?)?), process, asked });
            // Another thread may have been faster; then its pool is looked at, and this one ends.
            self.pool.compare_and_swap(&*found, Some(made));
        }
    }

    fn set(&self, threads: Option<usize>) -> Result<()> {
        if let Some(n) = threads.filter(|n| !(1..=MOST).contains(n)) {
            return Err(wrong("threads", n, "choose another number; none means the default"));
        }
        self.asked.store(threads.unwrap_or(0), SeqCst);
        self.pool.store(None);
        Ok(())
    }

    fn count(&self, process: u32) -> Result<usize> {
        let asked = self.asked.load(SeqCst);
        match &*self.pool.load() {
            Some(pool) if pool.process == process && pool.asked == asked => Ok(pool.pool.current_num_threads()),
            _ => resolved(asked),
        }
    }
}

/// The number of threads that a pool gets; 0 asks for the default.
fn resolved(asked: usize) -> Result<usize> {
    let told = if asked > 0 { Some(asked) } else { told_by(std::env::var_os(VARIABLE))? };
    // A system that does not tell has at least the core that asks.
    let cores = || std::thread::available_parallelism().map_or(1, usize::from).min(MOST);
    Ok(told.unwrap_or_else(cores))
}

/// What the environment says; nothing where the variable is empty or not there.
fn told_by(value: Option<OsString>) -> Result<Option<usize>> {
    let Some(value) = value.filter(|v| !v.is_empty()) else { return Ok(None) };
    let number = value.to_str().and_then(|text| text.trim().parse().ok()).filter(|n| (1..=MOST).contains(n));
    let fix = "give a number, or unset it for all the cores that this process may use";
    number.map(Some).ok_or_else(|| wrong(VARIABLE, format!("{:?}", OsStr::to_string_lossy(&value)), fix))
}

fn wrong(name: &'static str, got: impl std::fmt::Display, fix: &'static str) -> Error {
    Error::argument(name, format!("a whole number between 1 and {MOST}"), got, fix)
}

fn started(threads: usize) -> Result<ThreadPool> {
    let builder = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK);
    builder.thread_name(|i| format!("shadowlab-{i}")).build().map_err(|error| {
        let fix = format!("ask for fewer with set_threads or {VARIABLE}");
        Error::argument("threads", "as many threads as the system starts", format!("{threads} ({error})"), fix)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;

    use super::*;

    fn threads_of(pool: &Pool) -> usize {
        pool.pool.current_num_threads()
    }

    #[test]
    fn another_process_gets_another_pool_and_leaves_the_old_one_alone() {
        let (current, here) = (Current::new(), std::process::id());
        let ours = current.pool(here).unwrap();
        assert!(Arc::ptr_eq(&ours, &current.pool(here).unwrap()));
        let child = current.pool(here + 1).unwrap();
        assert!(!Arc::ptr_eq(&ours, &child));
        assert!(Arc::ptr_eq(&child, &current.pool(here + 1).unwrap()));
        // And the grandchild.
        let grandchild = current.pool(here + 2).unwrap();
        assert!(!Arc::ptr_eq(&child, &grandchild));
        for pool in [ours, child, grandchild] {
            assert_eq!(pool.pool.install(rayon::current_num_threads), threads_of(&pool));
        }
    }

    #[test]
    fn a_pool_of_another_process_is_not_ended() {
        let pool = |process| Pool { pool: ManuallyDrop::new(started(1).unwrap()), process, asked: 0 };
        let ends = |pool: Pool| {
            // A thread of the pool that ends drops what it holds for itself.
            struct Told(std::sync::mpsc::Sender<()>);
            impl Drop for Told {
                fn drop(&mut self) {
                    let _ = self.0.send(());
                }
            }
            thread_local!(static HELD: std::cell::RefCell<Option<Told>> = const { std::cell::RefCell::new(None) });
            let (sender, receiver) = channel();
            pool.pool.install(|| HELD.set(Some(Told(sender))));
            drop(pool);
            receiver.recv_timeout(Duration::from_secs(2)).is_ok()
        };
        assert!(ends(pool(std::process::id())));
        assert!(!ends(pool(std::process::id() + 1)));
    }

    #[test]
    fn the_number_of_threads_is_the_one_asked_for() {
        let (current, here) = (Current::new(), std::process::id());
        for n in [1, 2, 5] {
            current.set(Some(n)).unwrap();
            assert_eq!(current.count(here), Ok(n));
            assert_eq!(threads_of(&current.pool(here).unwrap()), n);
            // A fork keeps it.
            assert_eq!(current.count(here + 1), Ok(n));
            assert_eq!(threads_of(&current.pool(here + 1).unwrap()), n);
        }
        current.set(None).unwrap();
        assert_eq!(threads_of(&current.pool(here).unwrap()), resolved(0).unwrap());
        for n in [0, MOST + 1, usize::MAX] {
            let error = current.set(Some(n)).unwrap_err().to_string();
            assert!(error.contains("between 1 and 1024") && error.contains(&n.to_string()), "{error}");
        }
    }

    #[test]
    fn work_that_has_begun_keeps_its_threads() {
        let (current, here) = (Current::new(), std::process::id());
        current.set(Some(2)).unwrap();
        let pool = current.pool(here).unwrap();
        current.set(Some(3)).unwrap();
        // Both threads are needed at once: they are still there.
        let both = Barrier::new(2);
        pool.pool.install(|| rayon::join(|| both.wait(), || both.wait()));
        assert_eq!(threads_of(&current.pool(here).unwrap()), 3);
    }

    #[test]
    fn threads_that_ask_at_once_share_one_pool() {
        let (current, here) = (Current::new(), std::process::id());
        let together = Barrier::new(8);
        let ask = || {
            together.wait();
            current.pool(here).unwrap()
        };
        let pools: Vec<_> = std::thread::scope(|scope| {
            let asked: Vec<_> = (0..8).map(|_| scope.spawn(ask)).collect();
            asked.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(pools.iter().all(|pool| Arc::ptr_eq(pool, &pools[0])));
    }

    #[test]
    fn the_environment_is_read_or_refused_by_name() {
        let told = |text: &str| told_by(Some(text.into()));
        assert_eq!(told_by(None), Ok(None));
        assert_eq!(told(""), Ok(None));
        assert_eq!(told("3"), Ok(Some(3)));
        assert_eq!(told(" 1024 "), Ok(Some(MOST)));
        for text in ["0", "-1", "1025", "2.0", "four", "99999999999999999999999"] {
            let error = told(text).unwrap_err().to_string();
            assert!(error.starts_with(VARIABLE) && error.contains(text), "{error}");
        }
    }

    #[test]
    fn work_that_takes_too_long_is_left_behind() {
        let (never, forgotten) = channel::<()>();
        assert_eq!(in_time(move || forgotten.recv().is_ok(), Duration::from_millis(20)), None);
        drop(never);
        assert_eq!(in_time(|| 1, Duration::from_secs(60)), Some(1));
        assert_eq!(in_time(|| -> u8 { panic!("of the work") }, Duration::from_secs(60)), None);
    }
}
