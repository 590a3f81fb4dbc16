//! Index buffers, with the signatures and meanings of meshoptimizer's `simplify`.
#![allow(clippy::too_many_arguments, reason = "they are those of meshoptimizer")]

use std::ptr::{null, null_mut};

use neural_mesh_collapse::{
    IndexBuffers, IndexOptions, measure_extent, prune_components, select_points, simplify_indices, simplify_sloppily,
};

use crate::errors::{CallError, run_guarded};
use crate::pointers::{read_numbers, read_rows, read_triangles, write_number, write_numbers, write_rows};
use crate::pool::run_in_pool;

/// Result of failed functions that return a number of indices.
pub const NM_FAILED: usize = usize::MAX;
/// Option that keeps vertices on boundaries.
pub const NM_LOCK_BORDER: u32 = 1;
/// Option for few triangles of many vertices: time and errors are those of the vertices in use.
pub const NM_SPARSE: u32 = 2;
/// Option for errors in the unit of the positions, not relative to the extent.
pub const NM_ERROR_ABSOLUTE: u32 = 4;
/// Option to drop small components whose vertices are better spent elsewhere.
///
/// Above the target, components with a radius within `target_error` are dropped, too.
pub const NM_PRUNE: u32 = 8;
/// Option without effect: triangles are regular without it.
pub const NM_REGULARIZE: u32 = 16;
/// Option without effect.
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

/// The caller's arrays.
struct Arrays {
    indices: Vec<[u32; 3]>,
    positions: Vec<[f32; 3]>,
    attributes: Vec<f32>,
    weights: Vec<f32>,
    locks: Vec<bool>,
}

impl Arrays {
    fn to_buffers(&self) -> IndexBuffers<'_> {
        let Arrays { indices, positions, attributes, weights, locks } = self;
        IndexBuffers { indices, positions, attributes, weights, locks, groups: &[] }
    }
}

impl Call {
    fn run(&self) -> Result<usize, CallError> {
        let mut arrays = self.read_arrays()?;
        let mut options = self.read_options()?;
        let result = run_in_pool(|n_threads| {
            options.n_threads = n_threads;
            simplify_indices(&arrays.to_buffers(), &options)
        })?;
        if !self.moved.0.is_null() {
            result.write_moved(&mut arrays.positions, &mut arrays.attributes);
            write_rows(self.moved.0, arrays.positions.as_flattened(), 3, self.positions_stride);
            write_rows(self.moved.1, &arrays.attributes, self.attribute_count, self.attributes_stride);
        }
        let indices = result.indices.as_flattened();
        write_numbers("destination", self.destination, indices)?;
        write_number(self.result_error, result.error);
        Ok(indices.len())
    }

    fn read_arrays(&self) -> Result<Arrays, CallError> {
        let Self { vertex_count, attribute_count, .. } = *self;
        let indices = read_triangles(self.indices, self.index_count)?;
        let positions = read_rows("vertex_positions", self.positions, vertex_count, 3, self.positions_stride)?;
        let weights = read_numbers("attribute_weights", self.weights, attribute_count)?;
        if weights.iter().any(|weight| !weight.is_finite()) {
            return Err(CallError::new("attribute_weights", "a number is not finite"));
        }
        let stride = self.attributes_stride;
        let attributes = read_rows("vertex_attributes", self.attributes, vertex_count, attribute_count, stride)?;
        let locks = read_locks(self.locks, vertex_count)?;
        Ok(Arrays { indices, positions: positions.as_chunks().0.to_vec(), attributes, weights, locks })
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
        let mut options = IndexOptions::new(self.target_index_count / 3, error);
        (options.is_absolute, options.is_sparse) = (has(NM_ERROR_ABSOLUTE), has(NM_SPARSE));
        (options.locks_boundaries, options.prunes) = (has(NM_LOCK_BORDER), has(NM_PRUNE));
        options.moves = !self.moved.0.is_null();
        Ok(options)
    }
}

fn read_locks(locks: *const u8, vertex_count: usize) -> Result<Vec<bool>, CallError> {
    if locks.is_null() {
        return Ok(Vec::new());
    }
    Ok(read_numbers("vertex_lock", locks, vertex_count)?.into_iter().map(|lock| lock & 1 == 1).collect())
}

/// Simplifies an index buffer into `destination`, which has room for `index_count` indices; returns the new number of
/// indices.
///
/// The result has at most `target_index_count` indices if it is then within `target_error` of the original, else as few
/// as that error allows. The error is relative to the longest side of the box around the vertices; 1 or more sets no
/// bound. Vertices do not move. Triangles with two corners in one place vanish. `result_error`, unless null, receives the
/// error: an estimate of the largest distance. Returns `NM_FAILED` on failure.
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

/// Simplifies an index buffer into `destination` to a size that topology does not limit; returns the new number of
/// indices.
///
/// Vertices of one cell of a grid become one, and components join; vertices do not move. `vertex_lock` may be null.
/// Returns all indices if a vertex would go farther than `target_error`, a share of the extent; none below the coarsest
/// grid. `result_error`, unless null, receives the longest way. Returns `NM_FAILED` on failure.
///
/// # Safety
/// As for `nm_simplify`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify_sloppy(
    destination: *mut u32,
    indices: *const u32,
    index_count: usize,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    vertex_lock: *const u8,
    target_index_count: usize,
    target_error: f32,
    result_error: *mut f32,
) -> usize {
    run_guarded(NM_FAILED, || {
        let triangles = read_triangles(indices, index_count)?;
        let positions = read_rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        let locks = read_locks(vertex_lock, vertex_count)?;
        let (indices, positions) = (&triangles[..], positions.as_chunks().0);
        let buffers = IndexBuffers { indices, positions, locks: &locks, ..IndexBuffers::default() };
        let (faces, error) = simplify_sloppily(&buffers, target_index_count / 3, target_error)?;
        write_numbers("destination", destination, faces.as_flattened())?;
        write_number(result_error, error);
        Ok(3 * faces.len())
    })
}

/// Drops components with a radius of at most `target_error`, a share of the extent; returns the new number of indices,
/// which are in `destination`, or `NM_FAILED`.
///
/// # Safety
/// As for `nm_simplify`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify_prune(
    destination: *mut u32,
    indices: *const u32,
    index_count: usize,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    target_error: f32,
) -> usize {
    run_guarded(NM_FAILED, || {
        let triangles = read_triangles(indices, index_count)?;
        let positions = read_rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        let (indices, positions) = (&triangles[..], positions.as_chunks().0);
        let faces = prune_components(&IndexBuffers { indices, positions, ..IndexBuffers::default() }, target_error)?;
        write_numbers("destination", destination, faces.as_flattened())?;
        Ok(3 * faces.len())
    })
}

/// Selects `target_vertex_count` points, spread over the cloud; returns their number, and their indices in
/// `destination`, or `NM_FAILED`.
///
/// `vertex_colors`, which may be null, has three numbers for each point; a difference of 1 counts as `color_weight` times
/// the extent.
///
/// # Safety
/// As for `nm_simplify`; `vertex_colors_stride` is in bytes.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_simplify_points(
    destination: *mut u32,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    vertex_colors: *const f32,
    vertex_colors_stride: usize,
    color_weight: f32,
    target_vertex_count: usize,
) -> usize {
    run_guarded(NM_FAILED, || {
        let positions = read_rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        let n_colors = if vertex_colors.is_null() { 0 } else { vertex_count };
        let colors = read_rows("vertex_colors", vertex_colors, n_colors, 3, vertex_colors_stride)?;
        let (positions, colors) = (positions.as_chunks().0, colors.as_chunks().0);
        let points = select_points(positions, colors, color_weight, target_vertex_count)?;
        write_numbers("destination", destination, &points)?;
        Ok(points.len())
    })
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
        Ok(measure_extent(numbers.as_chunks().0).max(0.0))
    })
}
