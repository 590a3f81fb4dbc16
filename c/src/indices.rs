//! Index buffers, with the signatures and the meaning of meshoptimizer's `simplify`.
#![allow(clippy::too_many_arguments, reason = "they are those of meshoptimizer")]

use std::ops::ControlFlow;

use neural_mesh::indices::{Buffers, IndexOptions, Indices, extent, simplify_indices};

use crate::errors::{Refused, guarded};
use crate::pointers::{numbers, rows, write, write_one, write_rows};

/// What a function gives that failed; `nm_last_error` says why.
pub const NM_FAILED: usize = usize::MAX;
/// Vertices on boundaries stay.
pub const NM_LOCK_BORDER: u32 = 1;
/// Accepted for its meaning elsewhere, and of no effect here: vertices that no index names cost nothing.
pub const NM_SPARSE: u32 = 2;
/// Errors are in the unit of the positions, not shares of the extent.
pub const NM_ERROR_ABSOLUTE: u32 = 4;
/// Components that cost more than they show may go.
pub const NM_PRUNE: u32 = 8;
/// Accepted for its meaning elsewhere, and of no effect here: triangles are regular as they are.
pub const NM_REGULARIZE: u32 = 16;
/// Accepted for its meaning elsewhere, and of no effect here: seams cost their price always.
pub const NM_PERMISSIVE: u32 = 32;
/// All options together.
const KNOWN: u32 = 63;

/// Attributes of vertices as they come.
struct Attributes {
    values: *const f32,
    stride: usize,
    weights: *const f32,
    count: usize,
    locks: *const u8,
}

const NO_ATTRIBUTES: Attributes =
    Attributes { values: std::ptr::null(), stride: 0, weights: std::ptr::null(), count: 0, locks: std::ptr::null() };

/// Positions of vertices as they come.
#[derive(Clone, Copy)]
struct Positions {
    values: *const f32,
    count: usize,
    stride: usize,
}

/// Reads the buffers of a call.
fn read(
    indices: *const u32,
    index_count: usize,
    positions: Positions,
    attributes: &Attributes,
) -> Result<Buffers, Refused> {
    if !index_count.is_multiple_of(3) {
        return Err(Refused::of("index_count", format!("{index_count}: give a multiple of 3")));
    }
    let Positions { values, count, stride } = positions;
    let triangles = numbers("indices", indices, index_count)?.as_chunks().0.to_vec();
    let places = rows("vertex_positions", values, count, 3, stride)?.as_chunks().0.to_vec();
    let mut buffers = Buffers::new(triangles, places);
    buffers.weights = numbers("attribute_weights", attributes.weights, attributes.count)?;
    buffers.attributes = rows("vertex_attributes", attributes.values, count, attributes.count, attributes.stride)?;
    if !attributes.locks.is_null() {
        buffers.locks = numbers("vertex_lock", attributes.locks, count)?;
    }
    Ok(buffers)
}

/// Simplifies the buffers of a call.
fn simplified(buffers: Buffers, target: usize, error: f32, options: u32, moves: bool) -> Result<Indices, Refused> {
    if options & !KNOWN != 0 {
        return Err(Refused::of("options", format!("{options:#x}: bits that mean nothing")));
    }
    if error.is_nan() || error < 0.0 {
        return Err(Refused::of("target_error", format!("{error}: give 0 or more")));
    }
    if target >= buffers.indices.len() * 3 {
        buffers.check()?;
        return Ok(unchanged(buffers));
    }
    let mut asked = IndexOptions::new(target / 3, f64::from(error));
    (asked.is_absolute, asked.moves) = (options & NM_ERROR_ABSOLUTE != 0, moves);
    (asked.lock_borders, asked.prune) = (options & NM_LOCK_BORDER != 0, options & NM_PRUNE != 0);
    Ok(simplify_indices(buffers, &asked, &mut |_| ControlFlow::Continue(()))?)
}

/// Buffers that are small enough as they are.
fn unchanged(buffers: Buffers) -> Indices {
    let mut same = Indices::default();
    (same.indices, same.buffers) = (buffers.indices.clone(), buffers);
    same
}

/// Simplifies an index buffer: writes the indices that are left to `destination`, which has room for `index_count`, and returns how many.
///
/// The result has `target_index_count` indices at most where it stays within `target_error` of the original, a share of the longest side of
/// its box, else as few as stay within. Vertices stay where they are. `result_error`, unless null, gets the error. Returns `NM_FAILED` where
/// it fails.
///
/// # Safety
/// As many values as are said are at each address; `vertex_positions_stride` is in bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify(
    destination: *mut u32,
    indices: *const u32,
    index_count: usize,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    target_index_count: usize,
    target_error: f32,
    options: u32,
    result_error: *mut f32,
) -> usize {
    let positions = Positions { values: vertex_positions, count: vertex_count, stride: vertex_positions_stride };
    guarded(NM_FAILED, || {
        let buffers = read(indices, index_count, positions, &NO_ATTRIBUTES)?;
        let made = simplified(buffers, target_index_count, target_error, options, false)?;
        put(destination, result_error, &made)
    })
}

/// As `nm_simplify`, where numbers of the vertices count: `attribute_count` of them, each times its weight, are as dear as a distance of that
/// share of the extent. A vertex whose `vertex_lock` is odd stays; the array may be null.
///
/// # Safety
/// As for `nm_simplify`; `vertex_attributes_stride` is in bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify_with_attributes(
    destination: *mut u32,
    indices: *const u32,
    index_count: usize,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    vertex_attributes: *const f32,
    vertex_attributes_stride: usize,
    attribute_weights: *const f32,
    attribute_count: usize,
    vertex_lock: *const u8,
    target_index_count: usize,
    target_error: f32,
    options: u32,
    result_error: *mut f32,
) -> usize {
    let positions = Positions { values: vertex_positions, count: vertex_count, stride: vertex_positions_stride };
    let attributes = Attributes {
        values: vertex_attributes,
        stride: vertex_attributes_stride,
        weights: attribute_weights,
        count: attribute_count,
        locks: vertex_lock,
    };
    guarded(NM_FAILED, || {
        let buffers = read(indices, index_count, positions, &attributes)?;
        let made = simplified(buffers, target_index_count, target_error, options, false)?;
        put(destination, result_error, &made)
    })
}

/// As `nm_simplify_with_attributes`, where vertices move to where they serve best: indices, positions and attributes are written over.
///
/// # Safety
/// As for `nm_simplify_with_attributes`; the arrays are written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify_with_update(
    indices: *mut u32,
    index_count: usize,
    vertex_positions: *mut f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    vertex_attributes: *mut f32,
    vertex_attributes_stride: usize,
    attribute_weights: *const f32,
    attribute_count: usize,
    vertex_lock: *const u8,
    target_index_count: usize,
    target_error: f32,
    options: u32,
    result_error: *mut f32,
) -> usize {
    let positions = Positions { values: vertex_positions, count: vertex_count, stride: vertex_positions_stride };
    let attributes = Attributes {
        values: vertex_attributes,
        stride: vertex_attributes_stride,
        weights: attribute_weights,
        count: attribute_count,
        locks: vertex_lock,
    };
    guarded(NM_FAILED, || {
        let buffers = read(indices, index_count, positions, &attributes)?;
        let made = simplified(buffers, target_index_count, target_error, options, true)?;
        write_rows(vertex_positions, made.buffers.positions.as_flattened(), 3, vertex_positions_stride);
        write_rows(vertex_attributes, &made.buffers.attributes, attribute_count, vertex_attributes_stride);
        put(indices, result_error, &made)
    })
}

/// Returns the longest side of the box around vertices, which errors are shares of; negative where it fails.
///
/// # Safety
/// As many positions as are said are at the address.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify_scale(
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
) -> f32 {
    guarded(-1.0, || {
        let numbers = rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        Ok(extent(numbers.as_chunks().0) as f32)
    })
}

fn put(destination: *mut u32, result_error: *mut f32, made: &Indices) -> Result<usize, Refused> {
    let indices = made.indices.as_flattened();
    write("destination", destination, indices)?;
    write_one(result_error, made.error as f32);
    Ok(indices.len())
}
