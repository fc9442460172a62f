//! Threads that calls compute on, in the children of forks as well.

use std::collections::BTreeMap;
use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;

use musculo_collide::surface::parallel::on_calling_thread;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::refused;

/// Process that has loaded the module. The default pool has its threads there, and in no child.
static LOADED_BY: OnceLock<u32> = OnceLock::new();

/// Pools by the process that has made them, and by their number of threads: 0 for the default one.
///
/// The child of a fork has none of its parent's threads, and would wait for them without end. Pools
/// of parents are kept: dropping one takes locks that its threads may have held at the fork.
static POOLS: Mutex<BTreeMap<(u32, usize), Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());

/// Threads that a call computes on.
#[derive(Debug)]
pub(crate) enum Threads {
    /// The caller's.
    Own,
    /// All of the default pool.
    All,
    /// Those of another pool.
    Pool(Arc<ThreadPool>),
}

/// Keeps the number of the process that loads the module.
pub(crate) fn keep_process() {
    LOADED_BY.get_or_init(process::id);
}

impl Threads {
    /// Returns a number of threads: all where it is `None`, the caller's own for 1.
    pub(crate) fn new(number: Option<i64>) -> PyResult<Self> {
        let Some(number) = number else { return Self::all() };
        let most = 64.max(4 * thread::available_parallelism().map_or(1, usize::from));
        match usize::try_from(number) {
            Ok(1) => Ok(Self::Own),
            Ok(number) if 0 < number && number <= most => Ok(Self::Pool(pool(number)?)),
            _ => Err(refused(format!("{number} threads: from 1 to {most} are allowed"))),
        }
    }

    /// Returns as many threads as there are by default.
    fn all() -> PyResult<Self> {
        if LOADED_BY.get() == Some(&process::id()) {
            let is_alone = rayon::current_num_threads() == 1;
            return Ok(if is_alone { Self::Own } else { Self::All });
        }

        let pool = pool(0)?;
        Ok(if pool.current_num_threads() == 1 { Self::Own } else { Self::Pool(pool) })
    }

    /// Returns the number of threads.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Own => 1,
            Self::All => rayon::current_num_threads(),
            Self::Pool(pool) => pool.current_num_threads(),
        }
    }

    /// Computes on these threads; the caller's waits for the others.
    pub(crate) fn compute<T: Send>(&self, compute: impl FnOnce() -> T + Send) -> T {
        match self {
            Self::Own => on_calling_thread(compute),
            Self::All => compute(),
            Self::Pool(pool) => pool.install(compute),
        }
    }
}

/// Returns this process's pool of a number of threads, which is kept for later calls.
fn pool(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let key = (process::id(), threads);
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = pools.get(&key) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(refused)?;
    let pool = Arc::new(pool);
    pools.insert(key, Arc::clone(&pool));
    Ok(pool)
}
