//! Room for what a file makes large: asked for before it is taken, so that too little of it is an error and not the end.

use std::cell::Cell;
use std::collections::TryReserveError;

thread_local! {
    static ASKING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread asks for memory without which it can go on: then an allocator may refuse, where it would else have to end
/// the program.
///
/// ```
/// use neural_mesh::mesh::room::{asking, is_asking};
/// assert!(!is_asking() && asking(is_asking));
/// ```
pub fn is_asking() -> bool {
    ASKING.try_with(Cell::get).unwrap_or(false)
}

/// Does something that takes its memory by `try_reserve`, as the readers of the standard library do.
///
/// ```
/// use neural_mesh::mesh::room::asking;
/// let mut bytes: Vec<u8> = Vec::new();
/// assert!(asking(|| bytes.try_reserve(usize::MAX)).is_err());
/// ```
pub fn asking<T>(work: impl FnOnce() -> T) -> T {
    let before = ASKING.replace(true);
    let done = work();
    ASKING.set(before);
    done
}

/// Makes room for so many more elements behind those of `list`.
///
/// # Errors
/// Where there is not so much memory.
///
/// ```
/// use neural_mesh::mesh::room::make_room;
/// let mut list = vec![1, 2];
/// make_room(&mut list, 100).unwrap();
/// assert!(list.capacity() >= 102 && make_room(&mut list, usize::MAX).is_err());
/// ```
#[inline]
pub fn make_room<T>(list: &mut Vec<T>, n: usize) -> Result<(), TryReserveError> {
    if list.capacity() - list.len() >= n { Ok(()) } else { asking(|| list.try_reserve(n)) }
}
