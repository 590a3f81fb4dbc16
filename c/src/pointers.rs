//! Memory of the caller: the one file of this package that reads and writes it.
//!
//! Every pointer is checked for null where something is to be there, and every length for overflow; whether that much memory is there only
//! the caller knows, which is what the header asks of them.

use std::ffi::{CStr, c_char, c_void};
use std::mem::size_of;

use crate::errors::Refused;

/// Returns how many bytes so many items are; refuses what no memory holds.
fn n_bytes(name: &str, n: usize, each: usize) -> Result<usize, Refused> {
    let bytes = n.checked_mul(each).filter(|bytes| isize::try_from(*bytes).is_ok());
    bytes.ok_or_else(|| Refused::of(name, format!("{n} items are more than memory holds")))
}

/// Reads so many numbers; an address without alignment is allowed.
pub fn numbers<T: Copy>(name: &str, from: *const T, n: usize) -> Result<Vec<T>, Refused> {
    if n == 0 {
        return Ok(Vec::new());
    }
    if from.is_null() {
        return Err(Refused::of(name, "is null"));
    }
    n_bytes(name, n, size_of::<T>())?;
    // SAFETY: the caller has so many numbers there, which `T: Copy` of plain numbers may be read from any bytes, aligned or not.
    Ok((0..n).map(|i| unsafe { from.add(i).read_unaligned() }).collect())
}

/// Reads the first `width` numbers of each of so many rows, `stride` bytes apart.
pub fn rows(name: &str, from: *const f32, n: usize, width: usize, stride: usize) -> Result<Vec<f32>, Refused> {
    if n == 0 || width == 0 {
        return Ok(Vec::new());
    }
    if from.is_null() {
        return Err(Refused::of(name, "is null"));
    }
    if stride < n_bytes(name, width, size_of::<f32>())? || !stride.is_multiple_of(size_of::<f32>()) {
        return Err(Refused::of(
            name,
            format!("a stride of {stride} bytes: give a multiple of 4, at least {}", 4 * width),
        ));
    }
    n_bytes(name, n, stride)?;
    let mut numbers = Vec::with_capacity(n.saturating_mul(width));
    for row in 0..n {
        for column in 0..width {
            // SAFETY: the caller has so many rows there, each of `stride` bytes, of which these are a part.
            numbers.push(unsafe { from.byte_add(row * stride).add(column).read_unaligned() });
        }
    }
    Ok(numbers)
}

/// Writes rows of `width` numbers, `stride` bytes apart; both were checked where they were read.
pub fn write_rows(to: *mut f32, values: &[f32], width: usize, stride: usize) {
    for (row, values) in values.chunks_exact(width.max(1)).enumerate() {
        for (column, value) in values.iter().enumerate() {
            // SAFETY: as in `rows`, which has read what is written here.
            unsafe { to.byte_add(row * stride).add(column).write_unaligned(*value) };
        }
    }
}

/// Writes values, as many as the caller said there is room for.
pub fn write<T: Copy>(name: &str, to: *mut T, values: &[T]) -> Result<(), Refused> {
    if values.is_empty() {
        return Ok(());
    }
    if to.is_null() {
        return Err(Refused::of(name, "is null"));
    }
    for (i, value) in values.iter().enumerate() {
        // SAFETY: the caller has room for as many values there.
        unsafe { to.add(i).write_unaligned(*value) };
    }
    Ok(())
}

/// Writes one value, where there is a place for it.
pub fn write_one<T: Copy>(to: *mut T, value: T) {
    if !to.is_null() {
        // SAFETY: the caller has room for one value there.
        unsafe { to.write_unaligned(value) };
    }
}

/// Reads text in UTF-8 that ends with a zero.
pub fn text(name: &str, from: *const c_char) -> Result<String, Refused> {
    if from.is_null() {
        return Err(Refused::of(name, "is null"));
    }
    // SAFETY: the caller has text there that ends with a zero.
    let text = unsafe { CStr::from_ptr(from) };
    text.to_str().map(str::to_string).map_err(|_| Refused::of(name, "is no UTF-8"))
}

/// Reads so many bytes.
pub fn bytes(name: &str, from: *const c_void, n: usize) -> Result<Vec<u8>, Refused> {
    numbers(name, from.cast::<u8>(), n)
}

/// Hands an object to the caller.
pub fn given<T>(object: T) -> *mut T {
    Box::into_raw(Box::new(object))
}

/// Looks at an object that was handed out.
pub fn shared<'a, T>(name: &str, object: *const T) -> Result<&'a T, Refused> {
    // SAFETY: the pointer is null, or one of `given` that was not taken back, as the header asks.
    unsafe { object.as_ref() }.ok_or_else(|| Refused::of(name, "is null"))
}

/// Takes an object back that was handed out; nothing where there is none.
pub fn taken<T>(object: *mut T) -> Option<Box<T>> {
    // SAFETY: as in `shared`; the caller does not use it any more.
    (!object.is_null()).then(|| unsafe { Box::from_raw(object) })
}

/// A pointer of the caller's that goes back to their function, on whichever thread that is called.
#[derive(Clone, Copy)]
pub struct User(pub *mut c_void);

// SAFETY: the pointer is handed back to the caller's function and never followed here; that function may be called on another thread, as the
// header says.
unsafe impl Send for User {}
// SAFETY: likewise.
unsafe impl Sync for User {}
