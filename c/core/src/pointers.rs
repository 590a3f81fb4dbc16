//! Memory of the caller: the one file for C that reads and writes it.
//!
//! The header makes the caller responsible for the memory; null pointers and overflows are checked here.
#![allow(
    clippy::not_unsafe_ptr_arg_deref,
    reason = "only functions for C call these, and their callers answer for the memory"
)]

use std::ffi::{CStr, c_char, c_void};
use std::mem::size_of;

use crate::errors::CallError;

fn count_bytes(name: &str, n: usize, each: usize) -> Result<usize, CallError> {
    let bytes = n.checked_mul(each).filter(|bytes| isize::try_from(*bytes).is_ok());
    bytes.ok_or_else(|| CallError::new(name, format!("{n} items are more than memory holds")))
}

/// Reads `n` numbers; the address may be unaligned.
pub fn read_numbers<T: Copy>(name: &str, from: *const T, n: usize) -> Result<Vec<T>, CallError> {
    if n == 0 {
        return Ok(Vec::new());
    }
    if from.is_null() {
        return Err(CallError::new(name, "is null"));
    }
    count_bytes(name, n, size_of::<T>())?;
    // SAFETY: the caller has `n` numbers there; plain numbers may be read from any bytes, aligned or not.
    Ok((0..n).map(|i| unsafe { from.add(i).read_unaligned() }).collect())
}

/// Reads the vertices of triangles, three indices each.
pub fn read_triangles(indices: *const u32, index_count: usize) -> Result<Vec<[u32; 3]>, CallError> {
    if !index_count.is_multiple_of(3) {
        return Err(CallError::new("index_count", format!("{index_count}: give a multiple of 3")));
    }
    Ok(read_numbers("indices", indices, index_count)?.as_chunks().0.to_vec())
}

/// Reads the first `width` numbers of each of `n` rows, `stride` bytes apart.
pub fn read_rows(name: &str, from: *const f32, n: usize, width: usize, stride: usize) -> Result<Vec<f32>, CallError> {
    if n == 0 || width == 0 {
        return Ok(Vec::new());
    }
    if from.is_null() {
        return Err(CallError::new(name, "is null"));
    }
    if stride < count_bytes(name, width, size_of::<f32>())? || !stride.is_multiple_of(size_of::<f32>()) {
        let reason = format!("a stride of {stride} bytes: give a multiple of 4, at least {}", 4 * width);
        return Err(CallError::new(name, reason));
    }
    count_bytes(name, n, stride)?;
    let mut numbers = Vec::with_capacity(n.saturating_mul(width));
    for row in 0..n {
        for column in 0..width {
            // SAFETY: the caller has `n` rows of `stride` bytes there, and `width` numbers fit into one.
            numbers.push(unsafe { from.byte_add(row * stride).add(column).read_unaligned() });
        }
    }
    Ok(numbers)
}

/// Writes rows of `width` numbers, `stride` bytes apart, over rows that `read_rows` has read.
pub fn write_rows(to: *mut f32, values: &[f32], width: usize, stride: usize) {
    for (row, values) in values.chunks_exact(width.max(1)).enumerate() {
        for (column, value) in values.iter().enumerate() {
            // SAFETY: `read_rows` has read the bytes that are written here.
            unsafe { to.byte_add(row * stride).add(column).write_unaligned(*value) };
        }
    }
}

/// Writes numbers to an array that the caller made large enough.
pub fn write_numbers<T: Copy>(name: &str, to: *mut T, values: &[T]) -> Result<(), CallError> {
    if values.is_empty() {
        return Ok(());
    }
    if to.is_null() {
        return Err(CallError::new(name, "is null"));
    }
    for (i, value) in values.iter().enumerate() {
        // SAFETY: the caller has room for as many values there.
        unsafe { to.add(i).write_unaligned(*value) };
    }
    Ok(())
}

/// Writes a number, unless the address is null.
pub fn write_number<T: Copy>(to: *mut T, value: T) {
    if !to.is_null() {
        // SAFETY: the caller has room for one value there.
        unsafe { to.write_unaligned(value) };
    }
}

/// Reads text that ends with a zero.
pub fn read_text(name: &str, from: *const c_char) -> Result<String, CallError> {
    if from.is_null() {
        return Err(CallError::new(name, "is null"));
    }
    // SAFETY: the caller has text there that ends with a zero.
    let text = unsafe { CStr::from_ptr(from) };
    text.to_str().map(str::to_string).map_err(|_| CallError::new(name, "is not UTF-8"))
}

/// Reads `n` bytes.
pub fn read_bytes(name: &str, from: *const c_void, n: usize) -> Result<Vec<u8>, CallError> {
    read_numbers(name, from.cast::<u8>(), n)
}

/// Moves an object to a place of its own, which the caller frees.
pub fn into_handle<T>(object: T) -> *mut T {
    Box::into_raw(Box::new(object))
}

/// Returns the object behind a handle.
pub fn borrow_handle<'a, T>(name: &str, handle: *const T) -> Result<&'a T, CallError> {
    // SAFETY: the pointer is null, or one of `into_handle` that was not taken back, as the header requires.
    unsafe { handle.as_ref() }.ok_or_else(|| CallError::new(name, "is null"))
}

/// Takes back the object behind a handle; `None` for null.
pub fn take_handle<T>(handle: *mut T) -> Option<Box<T>> {
    // SAFETY: as in `borrow_handle`; the caller does not use the handle any more.
    (!handle.is_null()).then(|| unsafe { Box::from_raw(handle) })
}

/// Pointer of the caller, passed back to the caller's function.
#[derive(Clone, Copy)]
pub struct UserPointer(pub *mut c_void);

// SAFETY: the pointer is never followed here; the caller's function, which gets it back, may be called on any thread, as the header says.
unsafe impl Send for UserPointer {}
// SAFETY: for the reason given at `Send`.
unsafe impl Sync for UserPointer {}
