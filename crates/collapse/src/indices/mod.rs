//! The small door: index buffers in, index buffers out, with the meanings of meshoptimizer's simplifier.
//!
//! Vertices at one position are one vertex of the surface (`weld`), and the sides of a seam stay apart. Errors are the
//! collapse's own estimates; nothing is measured.

mod buffers;
mod grid;
mod groups;
mod prune;
#[cfg(test)]
mod tests;
mod weld;

use crate::collapse::{CollapseError, CollapseOptions, CollapseSize, SidesInput, WedgeResult, collapse_by_wedges};

pub use grid::{select_points, simplify_sloppily};
pub use prune::prune_components;

pub use buffers::{IndexBuffers, IndexResult, measure_extent};

use groups::GroupWedges;
pub use weld::weld;

use weld::Compact;

/// Settings of [`simplify_indices`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct IndexOptions {
    /// Number of faces asked for.
    pub n_faces: usize,
    /// Largest estimated error, as a share of the longest side of the box around the positions; 1 or more: no bound.
    pub max_error: f32,
    /// True if errors are in the unit of the positions.
    pub is_absolute: bool,
    /// True if the extent is that of the triangles' vertices, where most of the positions are of other triangles.
    pub is_sparse: bool,
    /// True if vertices may move.
    pub moves: bool,
    /// True if vertices on boundaries stay.
    pub locks_boundaries: bool,
    /// True if components may go whose radius is within the result's error, or, above the size, within `max_error`.
    pub prunes: bool,
    /// Threads to use; 0 is all of the current pool.
    pub n_threads: usize,
}

impl IndexOptions {
    /// Returns the settings for a number of faces within a share of the extent, on one thread.
    pub fn new(n_faces: usize, max_error: f32) -> IndexOptions {
        IndexOptions {
            n_faces,
            max_error,
            is_absolute: false,
            is_sparse: false,
            moves: false,
            locks_boundaries: false,
            prunes: false,
            n_threads: 1,
        }
    }
}

/// Simplifies index buffers to a number of faces, or until the error forbids more.
///
/// The error is an estimate: the largest sum of the distances by which merges moved the surface. Without `moves` the
/// result names vertices of the caller, and nothing else is to be read; with it, `moved` says where they are. Without a
/// bound and with nothing held, no faces asked for is an empty result.
///
/// # Errors
/// As [`collapse`](crate::collapse()); lengths that do not fit.
///
/// # Examples
/// ```
/// use neural_mesh_collapse::{IndexBuffers, IndexOptions, simplify_indices};
///
/// // A strip of ten squares.
/// let positions: Vec<[f32; 3]> = (0..22).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
/// let indices: Vec<[u32; 3]> = (0..10).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]]).collect();
/// let buffers = IndexBuffers { indices: &indices, positions: &positions, ..IndexBuffers::default() };
/// let result = simplify_indices(&buffers, &IndexOptions::new(2, 0.01)).unwrap();
/// assert_eq!(result.indices.len(), 2);
/// ```
pub fn simplify_indices(buffers: &IndexBuffers, options: &IndexOptions) -> Result<IndexResult, CollapseError> {
    buffers.check()?;
    if options.is_sparse {
        let compact = Compact::new(buffers);
        let inner = IndexOptions { is_sparse: false, ..options.clone() };
        let mut result = simplify_indices(&compact.buffers(buffers), &inner)?;
        compact.name_caller(&mut result);
        return Ok(result);
    }
    if options.n_faces >= buffers.indices.len() && !options.prunes {
        let sources = (0..buffers.indices.len() as u32).collect();
        return Ok(IndexResult { indices: buffers.indices.to_vec(), sources, ..IndexResult::default() });
    }
    let extent = measure_extent(buffers.positions);
    let unit = if options.is_absolute || extent == 0.0 { 1.0 } else { extent };
    let max_error =
        if !options.is_absolute && options.max_error >= 1.0 { f32::INFINITY } else { options.max_error * unit };
    let is_held = options.locks_boundaries || buffers.locks.contains(&true);
    if options.n_faces == 0 && max_error >= extent && !is_held {
        return Ok(IndexResult { error: extent / unit, ..IndexResult::default() });
    }
    let mut result = simplify_within(buffers, options, max_error)?;
    if options.prunes {
        let n_above = result.indices.len().saturating_sub(options.n_faces);
        if let Some(kept) = prune::drop_smallest(buffers, &result, n_above, max_error) {
            // The others get the faces that the dropped ones had.
            let indices: Vec<[u32; 3]> = kept.faces.iter().map(|&face| buffers.indices[face as usize]).collect();
            let groups: Vec<u32> =
                kept.faces.iter().filter_map(|&face| buffers.groups.get(face as usize).copied()).collect();
            let left = IndexBuffers { indices: &indices, groups: &groups, ..*buffers };
            result = simplify_within(&left, options, max_error)?;
            result.sources.iter_mut().for_each(|face| *face = kept.faces[*face as usize]);
            result.error = result.error.max(kept.radius);
        }
    }
    result.error /= unit;
    Ok(result)
}

fn simplify_within(
    buffers: &IndexBuffers,
    options: &IndexOptions,
    max_error: f32,
) -> Result<IndexResult, CollapseError> {
    let first = weld(buffers.positions);
    let has_copies = first.iter().zip(0..).any(|(&first, v)| first != v);
    let welded: Vec<[u32; 3]>;
    let faces = if has_copies {
        welded = buffers.indices.iter().map(|face| face.map(|v| first[v as usize])).collect();
        &welded
    } else {
        buffers.indices
    };
    let mut locked = buffers.locks.to_vec();
    for (v, is_locked) in buffers.locks.iter().enumerate().filter(|_| has_copies) {
        locked[first[v] as usize] |= is_locked;
    }
    let inner = CollapseOptions {
        max_error,
        moves: options.moves,
        locks_boundaries: options.locks_boundaries,
        locked: &locked,
        n_threads: options.n_threads,
        ..CollapseOptions::default()
    };
    let (mut values, columns, n_counted) = buffers.sort_attributes(options.moves);
    let width = columns.len();
    let by_group = GroupWedges::new(buffers);
    for &v in &by_group.others {
        values.extend_from_within(v as usize * width..(v as usize + 1) * width);
    }
    let sides = SidesInput {
        wedges: by_group.wedges.as_deref().unwrap_or(buffers.indices),
        n_wedges: first.len() + by_group.others.len(),
        has_copies: has_copies || !by_group.others.is_empty(),
        values,
        width,
        n_counted,
    };
    let size = CollapseSize::Faces(options.n_faces);
    let mut result = collapse_by_wedges(buffers.positions, faces, size, &inner, sides)?;
    let mut out = IndexResult { error: result.error, ..IndexResult::default() };
    if options.moves {
        write_moved(buffers, (&result, &by_group), &columns, &mut out);
    }
    by_group.name_caller(&mut result.faces);
    for face in &result.faces {
        out.indices.push(face.wedges);
        out.sources.push(face.source);
    }
    Ok(out)
}

// Each wedge of the result with its position and attributes, if one of them is new.
fn write_moved(
    buffers: &IndexBuffers,
    (result, by_group): (&WedgeResult, &GroupWedges),
    columns: &[usize],
    out: &mut IndexResult,
) {
    let mut is_written = vec![false; buffers.positions.len()];
    for face in &result.faces {
        for (&v, &wedge) in face.vertices.iter().zip(&face.wedges) {
            let slot = by_group.caller(wedge);
            if std::mem::replace(&mut is_written[slot as usize], true) {
                continue;
            }
            out.moved.push((slot, result.positions[v as usize]));
            let width = buffers.weights.len();
            let mut row = buffers.attributes[slot as usize * width..][..width].to_vec();
            if let Some(attributes) = &result.attributes {
                for (&k, value) in columns.iter().zip(&attributes.values[wedge as usize * columns.len()..]) {
                    row[k] = value / buffers.scale(k);
                }
            }
            out.attributes.extend(row);
        }
    }
}
