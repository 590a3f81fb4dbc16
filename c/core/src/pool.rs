//! Threads that stay between calls.

use std::cell::RefCell;
use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::run_guarded;
use crate::pointers::{borrow_handle, into_handle, take_handle};

thread_local! {
    static USED: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// Threads that calls may use.
pub struct NmPool(Arc<ThreadPool>);

/// Returns a pool of `thread_count` threads, one per core for 0, to be freed by `nm_pool_free`; null on failure.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn nm_pool_new(thread_count: usize) -> *mut NmPool {
    run_guarded(std::ptr::null_mut(), || {
        let pool = ThreadPoolBuilder::new().num_threads(thread_count).build()?;
        Ok(into_handle(NmPool(Arc::new(pool))))
    })
}

/// Makes later calls of this thread use a pool; null, as at first, is this thread alone. Results do not depend on it.
///
/// The pool stays as long as a thread uses it, also if it is freed before.
///
/// # Safety
/// The pool is valid or null.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_pool_use(pool: *const NmPool) {
    run_guarded((), || {
        let pool = if pool.is_null() { None } else { Some(Arc::clone(&borrow_handle("pool", pool)?.0)) };
        USED.with_borrow_mut(|used| *used = pool);
        Ok(())
    });
}

/// Frees a pool; does nothing for null.
///
/// # Safety
/// The pool comes from `nm_pool_new`, and is not named any more.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_pool_free(pool: *mut NmPool) {
    run_guarded((), || {
        drop(take_handle(pool));
        Ok(())
    });
}

/// Calls `work` with the number of threads to use, within this thread's pool.
pub(crate) fn run_in_pool<T: Send>(work: impl FnOnce(usize) -> T + Send) -> T {
    match USED.with_borrow(Clone::clone) {
        Some(pool) => pool.install(|| work(pool.current_num_threads())),
        None => work(1),
    }
}
