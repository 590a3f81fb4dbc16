//! Allocation that reports too little memory as an error.

use std::cell::Cell;
use std::collections::TryReserveError;

thread_local! {
    static IS_FALLIBLE: Cell<bool> = const { Cell::new(false) };
}

/// Returns whether this thread is inside [`with_fallible_allocation`].
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::fallible_allocation::{with_fallible_allocation, is_allocation_fallible};
/// assert!(!is_allocation_fallible() && with_fallible_allocation(is_allocation_fallible));
/// ```
pub fn is_allocation_fallible() -> bool {
    IS_FALLIBLE.try_with(Cell::get).unwrap_or(false)
}

/// Runs `work` with [`is_allocation_fallible`] true: `work` itself handles allocations that fail.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::fallible_allocation::with_fallible_allocation;
/// let mut bytes: Vec<u8> = Vec::new();
/// assert!(with_fallible_allocation(|| bytes.try_reserve(usize::MAX)).is_err());
/// ```
pub fn with_fallible_allocation<T>(work: impl FnOnce() -> T) -> T {
    let before = IS_FALLIBLE.replace(true);
    let done = work();
    IS_FALLIBLE.set(before);
    done
}

/// Reserves space for `n` more elements.
///
/// # Errors
/// [`TryReserveError`] if the memory is too small.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::fallible_allocation::make_room;
/// let mut list = vec![1, 2];
/// make_room(&mut list, 100).unwrap();
/// assert!(list.capacity() >= 102 && make_room(&mut list, usize::MAX).is_err());
/// ```
#[inline]
pub fn make_room<T>(list: &mut Vec<T>, n: usize) -> Result<(), TryReserveError> {
    if list.capacity() - list.len() >= n { Ok(()) } else { with_fallible_allocation(|| list.try_reserve(n)) }
}
