//! Index buffers, with the signatures and meanings of meshoptimizer's `simplify`.
#![allow(clippy::too_many_arguments, reason = "they are those of meshoptimizer")]

use std::ops::ControlFlow;
use std::ptr::{null, null_mut};

use neural_mesh::indices::{Buffers, IndexOptions, Indices, extent, simplify_indices};

use crate::errors::{CallError, run_guarded};
use crate::pointers::{read_numbers, read_rows, write_number, write_numbers, write_rows};

/// Result of failed functions that return a number of indices.
pub const NM_FAILED: usize = usize::MAX;
/// Option that keeps vertices on boundaries.
pub const NM_LOCK_BORDER: u32 = 1;
/// Option for errors relative to the box around the vertices in use, not around all vertices.
pub const NM_SPARSE: u32 = 2;
/// Option for errors in the unit of the positions, not relative to the extent.
pub const NM_ERROR_ABSOLUTE: u32 = 4;
/// Option to drop small components whose vertices are better spent elsewhere.
///
/// Above the target, components with a radius within `target_error` are dropped, too.
pub const NM_PRUNE: u32 = 8;
/// Option without effect: triangles are regular without it.
pub const NM_REGULARIZE: u32 = 16;
/// Option without effect: seams of attributes may always be simplified, at a price.
pub const NM_PERMISSIVE: u32 = 32;
/// Option without effect: triangles are regular without it.
pub const NM_REGULARIZE_LIGHT: u32 = 64;
const KNOWN_OPTIONS: u32 = 127;

/// Arguments of one call; null pointers are absent arguments.
struct Call {
    indices: *const u32,
    index_count: usize,
    positions: *const f32,
    vertex_count: usize,
    positions_stride: usize,
    attributes: *const f32,
    attributes_stride: usize,
    weights: *const f32,
    attribute_count: usize,
    locks: *const u8,
    target_index_count: usize,
    target_error: f32,
    options: u32,
    destination: *mut u32,
    /// Arrays that receive moved positions and attributes; null if vertices do not move.
    moved: (*mut f32, *mut f32),
    result_error: *mut f32,
}

impl Call {
    fn run(&self) -> Result<usize, CallError> {
        let buffers = self.read_buffers()?;
        let options = self.read_options()?;
        let result = if self.target_index_count >= self.index_count {
            buffers.check()?;
            Indices::from_buffers(buffers)
        } else {
            simplify_indices(buffers, &options, &mut |_| ControlFlow::Continue(()))?
        };
        if options.moves {
            let buffers = &result.buffers;
            write_rows(self.moved.0, buffers.positions.as_flattened(), 3, self.positions_stride);
            write_rows(self.moved.1, &buffers.attributes, self.attribute_count, self.attributes_stride);
        }
        let indices = result.indices.as_flattened();
        write_numbers("destination", self.destination, indices)?;
        write_number(self.result_error, result.error.unwrap_or_default() as f32);
        Ok(indices.len())
    }

    fn read_buffers(&self) -> Result<Buffers, CallError> {
        let Self { index_count, vertex_count, attribute_count, .. } = *self;
        if !index_count.is_multiple_of(3) {
            return Err(CallError::new("index_count", format!("{index_count}: give a multiple of 3")));
        }
        let triangles = read_numbers("indices", self.indices, index_count)?.as_chunks().0.to_vec();
        let positions = read_rows("vertex_positions", self.positions, vertex_count, 3, self.positions_stride)?;
        let mut buffers = Buffers::new(triangles, positions.as_chunks().0.to_vec());
        buffers.weights = read_numbers("attribute_weights", self.weights, attribute_count)?;
        let stride = self.attributes_stride;
        buffers.attributes = read_rows("vertex_attributes", self.attributes, vertex_count, attribute_count, stride)?;
        if !self.locks.is_null() {
            buffers.locks = read_numbers("vertex_lock", self.locks, vertex_count)?;
        }
        Ok(buffers)
    }

    fn read_options(&self) -> Result<IndexOptions, CallError> {
        let Self { options: bits, target_error: error, .. } = *self;
        if bits & !KNOWN_OPTIONS != 0 {
            return Err(CallError::new("options", format!("{bits:#x}: unknown option bits")));
        }
        if error.is_nan() || error < 0.0 {
            return Err(CallError::new("target_error", format!("{error}: give 0 or more")));
        }
        let has = |option: u32| bits & option != 0;
        let mut options = IndexOptions::new(self.target_index_count / 3, f64::from(error));
        (options.is_absolute, options.is_sparse) = (has(NM_ERROR_ABSOLUTE), has(NM_SPARSE));
        (options.lock_borders, options.prune) = (has(NM_LOCK_BORDER), has(NM_PRUNE));
        (options.moves, options.measures_error) = (!self.moved.0.is_null(), !self.result_error.is_null());
        Ok(options)
    }
}

/// Simplifies an index buffer into `destination`, which has room for `index_count` indices; returns the new number of
/// indices.
///
/// The result has at most `target_index_count` indices if it is then within `target_error` of the original, else as few
/// as that error allows. The error is relative to the longest side of the box around the vertices; 1 or more sets no
/// bound. Vertices do not move. Triangles with two corners in one place vanish, and neighbours are wound alike.
/// `result_error`, unless null, receives the error; without it and without a bound, no distance is measured, which is
/// faster. Returns `NM_FAILED` on failure.
///
/// # Safety
/// Each array has as many values as its count says; `vertex_positions_stride` is in bytes.
// SAFETY: no other function has this name.
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
    let call = Call {
        indices,
        index_count,
        positions: vertex_positions,
        vertex_count,
        positions_stride: vertex_positions_stride,
        attributes: null(),
        attributes_stride: 0,
        weights: null(),
        attribute_count: 0,
        locks: null(),
        target_index_count,
        target_error,
        options,
        destination,
        moved: (null_mut(), null_mut()),
        result_error,
    };
    run_guarded(NM_FAILED, || call.run())
}

/// Simplifies as `nm_simplify` does, and counts attributes in the error.
///
/// Each vertex has `attribute_count` attributes. A difference of 1 in an attribute counts as a distance of its weight
/// times the extent. An odd value in `vertex_lock`, which may be null, locks a vertex.
///
/// # Safety
/// As for `nm_simplify`; `vertex_attributes_stride` is in bytes.
// SAFETY: no other function has this name.
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
    let call = Call {
        indices,
        index_count,
        positions: vertex_positions,
        vertex_count,
        positions_stride: vertex_positions_stride,
        attributes: vertex_attributes,
        attributes_stride: vertex_attributes_stride,
        weights: attribute_weights,
        attribute_count,
        locks: vertex_lock,
        target_index_count,
        target_error,
        options,
        destination,
        moved: (null_mut(), null_mut()),
        result_error,
    };
    run_guarded(NM_FAILED, || call.run())
}

/// Simplifies as `nm_simplify_with_attributes` does, and moves vertices: indices, positions and attributes are
/// overwritten.
///
/// # Safety
/// As for `nm_simplify_with_attributes`; the arrays are written to.
// SAFETY: no other function has this name.
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
    let call = Call {
        indices,
        index_count,
        positions: vertex_positions,
        vertex_count,
        positions_stride: vertex_positions_stride,
        attributes: vertex_attributes,
        attributes_stride: vertex_attributes_stride,
        weights: attribute_weights,
        attribute_count,
        locks: vertex_lock,
        target_index_count,
        target_error,
        options,
        destination: indices,
        moved: (vertex_positions, vertex_attributes),
        result_error,
    };
    run_guarded(NM_FAILED, || call.run())
}

/// Returns the longest side of the box around the vertices, the unit of relative errors; negative on failure.
///
/// # Safety
/// The array has as many positions as the count says.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify_scale(
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
) -> f32 {
    run_guarded(-1.0, || {
        let numbers = read_rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        Ok(extent(numbers.as_chunks().0) as f32)
    })
}
