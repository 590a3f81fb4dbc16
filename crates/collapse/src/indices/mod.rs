//! The small door: index buffers in, index buffers out, with the meanings of meshoptimizer's simplifier.
//!
//! Vertices at one position are one vertex of the surface (`weld`), and the sides of a seam stay apart. Errors are the
//! collapse's own estimates; nothing is measured.

mod grid;
mod groups;
mod prune;
#[cfg(test)]
mod tests;
mod weld;

use crate::collapse::{
    CollapseError, CollapseOptions, CollapseResult, CollapseSize, Sides, SidesInput, collapse_with_sides,
};

pub use grid::{select_points, simplify_sloppily};
pub use prune::prune_components;

use groups::Named;
use weld::{Compact, weld};

/// Triangles of the caller, with what holds and weighs.
#[derive(Clone, Copy, Debug, Default)]
pub struct IndexBuffers<'a> {
    /// Vertices of the triangles, n_faces x 3.
    pub indices: &'a [[u32; 3]],
    /// Positions, n_vertices x 3, in any unit.
    pub positions: &'a [[f32; 3]],
    /// Attributes, n_vertices x n_weights.
    pub attributes: &'a [f32],
    /// Weight of each attribute: a difference of 1 counts as a distance of this share of the extent. One of 0 is carried.
    pub weights: &'a [f32],
    /// Group of each triangle, such as its material; n_faces, or empty. Between groups the course of edges is kept.
    pub groups: &'a [u32],
    /// Whether a vertex, and all others at its position, stays; n_vertices, or empty.
    pub locks: &'a [bool],
}

/// Settings of [`simplify_indices`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct IndexOptions {
    /// Number of faces asked for.
    pub n_faces: usize,
    /// Largest estimated error, as a share of the extent, the longest side of the box around the positions; 1 or more,
    /// or infinite: no bound.
    pub max_error: f32,
    /// Whether errors are in the unit of the positions.
    pub is_absolute: bool,
    /// Whether the extent is that of the triangles' vertices, where most of the positions are of other triangles.
    pub is_sparse: bool,
    /// Whether vertices may move.
    pub moves: bool,
    /// Whether vertices on boundaries stay.
    pub locks_boundaries: bool,
    /// Whether components may go whose radius is within the result's error, or, above the size, within the largest.
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

/// Simplified index buffers.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct IndexResult {
    /// Vertices of the caller at the corners of the faces, n_faces x 3.
    pub indices: Vec<[u32; 3]>,
    /// For each face the one of the input that it was, n_faces.
    pub sources: Vec<u32>,
    /// The estimated error, in the unit of [`IndexOptions::max_error`].
    pub error: f32,
    /// Vertices that have moved, and their new positions.
    pub moved: Vec<(u32, [f32; 3])>,
    /// The attributes of the vertices in `moved`, n_moved x n_weights.
    pub attributes: Vec<f32>,
}

/// Simplifies index buffers to a number of faces, or as far as the error allows.
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

/// Returns the longest side of the box around points.
pub fn measure_extent(positions: &[[f32; 3]]) -> f32 {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max)
}

impl IndexBuffers<'_> {
    fn check(&self) -> Result<(), CollapseError> {
        let n = self.positions.len();
        if let Some(face) = self.indices.iter().position(|face| face.iter().any(|&v| v as usize >= n)) {
            return Err(CollapseError::IndexOutOfRange { face });
        }
        if let Some(vertex) = self.positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(CollapseError::NotFinite { vertex });
        }
        if self.attributes.len() != n * self.weights.len() {
            return Err(CollapseError::WrongLength { what: "attributes" });
        }
        if let Some(i) = self.attributes.iter().position(|x| !x.is_finite()) {
            return Err(CollapseError::NotFinite { vertex: i / self.weights.len().max(1) });
        }
        if !self.groups.is_empty() && self.groups.len() != self.indices.len() {
            return Err(CollapseError::WrongLength { what: "groups" });
        }
        if !self.locks.is_empty() && self.locks.len() != n {
            return Err(CollapseError::WrongLength { what: "locks" });
        }
        Ok(())
    }

    // Values of a vertex as the collapse has them: those with weights in units of the extent, then, if vertices move, others.
    fn sort_attributes(&self, moves: bool) -> (Vec<f32>, Vec<usize>, usize) {
        let (mut columns, others): (Vec<usize>, Vec<usize>) =
            (0..self.weights.len()).partition(|&k| self.weights[k] > 0.0);
        let n_counted = columns.len();
        columns.extend(others.into_iter().filter(|_| moves));
        let rows = self.attributes.chunks(self.weights.len().max(1));
        let values = rows.flat_map(|row| columns.iter().map(|&k| row[k] * self.scale(k))).collect();
        (values, columns, n_counted)
    }

    fn scale(&self, attribute: usize) -> f32 {
        if self.weights[attribute] > 0.0 { self.weights[attribute] } else { 1.0 }
    }
}

fn simplify_within(
    buffers: &IndexBuffers,
    options: &IndexOptions,
    max_error: f32,
) -> Result<IndexResult, CollapseError> {
    let mut out = IndexResult::default();
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
        ..CollapseOptions::new(CollapseSize::Faces(options.n_faces))
    };
    let (mut values, columns, n_counted) = buffers.sort_attributes(options.moves);
    let width = columns.len();
    let named = Named::new(buffers);
    for &v in &named.others {
        values.extend_from_within(v as usize * width..(v as usize + 1) * width);
    }
    let sides = SidesInput {
        wedges: named.wedges.as_deref().unwrap_or(buffers.indices),
        n_wedges: first.len() + named.others.len(),
        has_copies: has_copies || !named.others.is_empty(),
        values,
        width,
        n_counted,
    };
    let (result, sides) = collapse_with_sides(buffers.positions, faces, &inner, sides)?;
    let mut sides = sides.expect("sides were given");
    if options.moves {
        write_moved(buffers, (&result, &sides, &named), &columns, &mut out);
    }
    out.error = result.error;
    named.name_caller(&mut sides.wedges.faces);
    for face in &sides.wedges.faces {
        out.indices.push(face.wedges);
        out.sources.push(face.source);
    }
    Ok(out)
}

// Each wedge of the result with its position and attributes, if one of them is new.
fn write_moved(
    buffers: &IndexBuffers,
    (result, sides, named): (&CollapseResult, &Sides, &Named),
    columns: &[usize],
    out: &mut IndexResult,
) {
    let mut is_written = vec![false; buffers.positions.len()];
    for face in &sides.wedges.faces {
        for (&v, &wedge) in face.vertices.iter().zip(&face.wedges) {
            let slot = named.caller(wedge);
            if std::mem::replace(&mut is_written[slot as usize], true) {
                continue;
            }
            out.moved.push((slot, result.positions[v as usize]));
            let width = buffers.weights.len();
            let mut row = buffers.attributes[slot as usize * width..][..width].to_vec();
            if let Some(attributes) = &sides.attributes {
                for (&k, value) in columns.iter().zip(&attributes.values[wedge as usize * columns.len()..]) {
                    row[k] = value / buffers.scale(k);
                }
            }
            out.attributes.extend(row);
        }
    }
}
