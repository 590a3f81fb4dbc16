//! Index buffers over vertices that stay where they are in their buffers: what engines ask of meshoptimizer's simplifier.
//!
//! Vertices at one position are one vertex of the surface, so that a seam of attributes is no boundary; results are indices of the caller's
//! vertices again.

mod buffers;
mod distance;
mod places;
mod welded;

use std::fmt;
use std::ops::ControlFlow;

use crate::search::simplify_to_error;
use crate::simplify::{Listener, Options, Purpose, Simplified, SimplifyError, Target, simplify_input};

use distance::measure_distance;
use welded::WeldedMesh;

pub use buffers::{Buffers, extent};

/// Sizes that are tried to find the smallest within a distance in numbers of vertices.
const TRIES: usize = 8;

/// What is asked of index buffers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct IndexOptions {
    /// Faces that may be left.
    pub n_faces: usize,
    /// Largest distance from the original, attributes included: a share of the longest side of its box, or in its unit.
    pub error: f64,
    /// Whether distances are in the unit of the positions.
    pub is_absolute: bool,
    /// Whether vertices move to where they serve best; else they are some of those given.
    pub moves: bool,
    /// Whether vertices of boundaries stay.
    pub lock_borders: bool,
    /// Whether components that cost more than they show may go.
    pub prune: bool,
}

impl IndexOptions {
    /// Down to so many faces within this share of the extent; vertices stay.
    pub fn new(n_faces: usize, error: f64) -> Self {
        Self { n_faces, error, is_absolute: false, moves: false, lock_borders: false, prune: false }
    }
}

/// Lighter index buffers.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Indices {
    /// The caller's vertices at the corners of the faces that are left, n_faces x 3.
    pub indices: Vec<[u32; 3]>,
    /// The group of each face, n_faces, where groups were given.
    pub groups: Vec<u32>,
    /// Largest distance found between original and result, as a share of the extent or in the unit of the positions, as it was asked.
    pub error: f64,
    /// The caller's positions and attributes; those of vertices that moved are written over.
    pub buffers: Buffers,
}

/// Why index buffers have no result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum IndexError {
    /// Buffers are wrong, and how.
    Buffers(String),
    /// The simplifier has no result.
    Simplify(SimplifyError),
}

impl fmt::Display for IndexError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Buffers(what) => f.write_str(what),
            Self::Simplify(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for IndexError {}

impl From<SimplifyError> for IndexError {
    fn from(error: SimplifyError) -> Self {
        Self::Simplify(error)
    }
}

/// Simplifies index buffers, to the size, or to a larger one that holds the distance.
///
/// # Errors
/// [`IndexError`] where buffers are wrong, or the listener ends the run.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::indices::{Buffers, IndexOptions, simplify_indices};
/// use neural_mesh::mesh::shapes;
///
/// let (positions, indices) = shapes::icosphere(3).into_parts();
/// let buffers = Buffers::new(indices, positions);
/// let light = simplify_indices(buffers, &IndexOptions::new(200, 1.0), &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(light.indices.len(), 200);
/// ```
pub fn simplify_indices(
    mut buffers: Buffers,
    asked: &IndexOptions,
    listener: &mut Listener,
) -> Result<Indices, IndexError> {
    buffers.check()?;
    let mut options = Options::new(Target::Faces(asked.n_faces.max(1)));
    (options.subset, options.map) = (!asked.moves, asked.moves);
    (options.lock_boundaries, options.prune) = (asked.lock_borders, asked.prune);
    let given = WeldedMesh::new(&buffers)?;
    if given.mesh.faces().is_empty() {
        return Ok(Indices { buffers, ..Indices::default() });
    }
    if buffers.weights.iter().any(|weight| *weight > 0.0) {
        options.purpose = Purpose::Poses;
    }
    let unit = if asked.is_absolute { 1.0 } else { buffers.extent().max(f64::MIN_POSITIVE) };
    let (made, error) = simplify_within(&given, options, asked.error * unit, listener)?;
    let indices = if asked.moves { given.place_vertices(&made, &mut buffers) } else { given.corner_vertices(&made) };
    Ok(Indices { indices, groups: made.attributes.groups, error: error / unit, buffers })
}

/// Simplifies to the size, or to a larger one that holds the distance; returns the distance, too.
fn simplify_within(
    given: &WeldedMesh,
    options: Options,
    most: f64,
    listener: &mut Listener,
) -> Result<(Simplified, f64), IndexError> {
    let input = given.to_input();
    let at = |target: Target, listener: &mut Listener| -> Result<(Simplified, f64), IndexError> {
        let mut options = options.clone();
        options.target = target;
        let made = simplify_input(&input, None, &options, listener)?;
        let distance = measure_distance(given, &made);
        Ok((made, distance))
    };
    let small = at(options.target, listener)?;
    if small.1 <= most {
        return Ok(small);
    }
    let n_small = small.0.mesh.faces().len();
    if options.purpose != Purpose::Poses {
        let near = simplify_to_error(&input, None, &options, most, listener)?.simplified;
        let distance = measure_distance(given, &near);
        return Ok((near, distance));
    }
    let (mut low, mut best) = (n_small, at(Target::Ratio(1.0), listener)?);
    for _ in 0..TRIES {
        let high = best.0.mesh.faces().len();
        let middle = ((low as f64) * (high as f64)).sqrt() as usize;
        if middle <= low || middle >= high {
            break;
        }
        let made = at(Target::Faces(middle), listener)?;
        if made.1 <= most && made.0.mesh.faces().len() < high { best = made } else { low = middle }
    }
    Ok(best)
}

/// Leaves out components whose radius is at most this share of the extent; the indices of the others, n_faces x 3.
///
/// # Errors
/// [`IndexError`] where buffers are wrong.
pub fn prune_components(buffers: &Buffers, error: f64) -> Result<Vec<[u32; 3]>, IndexError> {
    buffers.check()?;
    let given = WeldedMesh::new(buffers)?;
    let mut options = Options::new(Target::Ratio(1.0));
    (options.prune_below, options.prune, options.subset) = (2.0 * error * buffers.extent(), false, true);
    match simplify_input(&given.to_input(), None, &options, &mut |_| ControlFlow::Continue(())) {
        Err(SimplifyError::Empty) => Ok(Vec::new()),
        made => Ok(given.corner_vertices(&made?)),
    }
}
