//! Index buffers over the caller's vertices, like those of meshoptimizer's `simplify`.
//!
//! Vertices at equal positions are one vertex of the surface, so that a seam of attributes is no boundary.

mod buffers;
mod distance;
mod error;
mod slots;
mod small_components;
mod welded;

use std::ops::ControlFlow;

use crate::search::simplify_to_error;
use crate::simplify::{
    ClosedOptions, Listener, Options, Purpose, Simplified, SimplifyError, Target, simplify, simplify_forcing_size,
};

use distance::measure_distance;
use small_components::drop_small_components;
use welded::WeldedMesh;

pub use buffers::{Buffers, extent};
pub use error::IndexError;

/// Largest number of sizes tried to find the smallest within a distance, if attributes have weights.
const MAX_TRIES: usize = 8;

/// Settings for index buffers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct IndexOptions {
    /// Largest number of faces in the result.
    pub n_faces: usize,
    /// Largest distance from the original, attributes included, as a share of the extent. Without weighted attributes,
    /// 1 or more is no bound.
    pub error: f64,
    /// True if distances are in the unit of the positions.
    pub is_absolute: bool,
    /// True if the extent is that of the triangles' vertices instead of all vertices.
    pub is_sparse: bool,
    /// True if vertices may move; otherwise the result uses the caller's positions.
    pub moves: bool,
    /// True if vertices of boundaries stay.
    pub lock_borders: bool,
    /// True if small components may be dropped to reach `n_faces`.
    pub prune: bool,
    /// True if [`Indices::error`] is measured even if no distance is requested.
    pub measures_error: bool,
}

impl IndexOptions {
    /// Makes options for `n_faces` faces within a share of the extent.
    pub fn new(n_faces: usize, error: f64) -> Self {
        Self {
            n_faces,
            error,
            is_absolute: false,
            is_sparse: false,
            moves: false,
            lock_borders: false,
            prune: false,
            measures_error: true,
        }
    }
}

/// Simplified index buffers.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Indices {
    /// Vertices of the caller at the corners of the faces, n_faces x 3.
    pub indices: Vec<[u32; 3]>,
    /// Group of each face, n_faces or empty.
    pub groups: Vec<u32>,
    /// Largest sampled distance between original and result, in the unit of [`IndexOptions::error`].
    pub error: Option<f64>,
    /// Buffers of the caller, with new positions and attributes of vertices that moved.
    pub buffers: Buffers,
}

impl Indices {
    /// Makes a result that equals the buffers.
    pub fn from_buffers(buffers: Buffers) -> Self {
        Self { indices: buffers.indices.clone(), groups: buffers.groups.clone(), error: Some(0.0), buffers }
    }

    fn empty(buffers: Buffers, error: f64) -> Self {
        Self { error: Some(error), buffers, ..Self::default() }
    }
}

/// Simplifies index buffers to the requested size, or to the smallest size found within the requested distance.
///
/// The result may be empty if no face is requested, nothing is locked and the distance is unbounded.
///
/// # Errors
/// [`IndexError`] if buffers are wrong, or the listener ends the run.
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
    buffers: Buffers,
    options: &IndexOptions,
    listener: &mut Listener,
) -> Result<Indices, IndexError> {
    buffers.check()?;
    let extent = if options.is_sparse { buffers.used_extent() } else { buffers.extent() };
    let unit = if options.is_absolute { 1.0 } else { extent.max(f64::MIN_POSITIVE) };
    let mut result = simplify_at_scale(buffers, options, &IndexScale::new(extent, options.error * unit), listener)?;
    result.error = result.error.map(|error| error / unit);
    Ok(result)
}

struct IndexScale {
    // Extent of the positions, by which the weights of attributes are multiplied.
    extent: f64,
    // Largest distance from the original.
    max_error: f64,
}

impl IndexScale {
    fn new(extent: f64, max_error: f64) -> Self {
        Self { extent, max_error }
    }

    /// Returns whether `max_error` can exclude a result.
    fn is_bounded(&self, has_weights: bool) -> bool {
        // A distance of the whole extent counts as no bound, but weighted attributes may differ by more.
        let most = if has_weights { f64::from(f32::MAX) } else { self.extent };
        self.max_error < most
    }
}

fn inner_options(options: &IndexOptions, has_weights: bool) -> ClosedOptions {
    ClosedOptions {
        subset: !options.moves,
        map: options.moves,
        lock_boundaries: options.lock_borders,
        prune: options.prune,
        purpose: if has_weights { Purpose::Poses } else { Purpose::Shape },
        ..ClosedOptions::default()
    }
}

/// Simplifies checked buffers; the error of the result is in the unit of the positions.
fn simplify_at_scale(
    mut buffers: Buffers,
    options: &IndexOptions,
    scale: &IndexScale,
    listener: &mut Listener,
) -> Result<Indices, IndexError> {
    let surface = WeldedMesh::new(&buffers, scale.extent)?;
    if surface.mesh.faces().is_empty() {
        return Ok(Indices::empty(buffers, 0.0));
    }
    let has_weights = buffers.weights.iter().any(|weight| *weight > 0.0);
    let is_bounded = scale.is_bounded(has_weights);
    if options.n_faces == 0 && scale.max_error >= scale.extent && !options.lock_borders && surface.locked.is_empty() {
        return Ok(Indices::empty(buffers, scale.extent));
    }
    let (target, inner) = (Target::Faces(options.n_faces.max(1)), inner_options(options, has_weights));
    let (made, error) = if is_bounded {
        let (made, error) = simplify_within(&surface, (target, &inner), scale.max_error, listener)?;
        (made, Some(error))
    } else {
        let made = simplify_forcing_size(&surface.to_input(), None, &inner, target, listener)?;
        let error = options.measures_error.then(|| measure_distance(&surface, &made));
        (made, error)
    };
    if options.prune
        && made.mesh.faces().len() > options.n_faces
        && let Some(rest) = drop_small_components(&surface, &made, &buffers, options.n_faces, scale.max_error)
    {
        // The other components are simplified again and get the faces that the dropped ones had.
        let options = IndexOptions { prune: false, ..*options };
        let mut result = simplify_at_scale(rest.buffers, &options, scale, listener)?;
        result.error = result.error.map(|error| error.max(rest.radius));
        return Ok(result);
    }
    let indices =
        if options.moves { surface.place_vertices(&made, &mut buffers) } else { surface.corner_vertices(&made) };
    Ok(Indices { indices, groups: made.attributes.groups, error, buffers })
}

/// Simplifies to the target, or to a larger size if only that is within `max_error`; also returns the distance.
fn simplify_within(
    surface: &WeldedMesh,
    (target, options): (Target, &ClosedOptions),
    max_error: f64,
    listener: &mut Listener,
) -> Result<(Simplified, f64), IndexError> {
    let input = surface.to_input();
    let simplify_to = |target: Target, listener: &mut Listener| -> Result<(Simplified, f64), IndexError> {
        let made = simplify_forcing_size(&input, None, options, target, listener)?;
        let distance = measure_distance(surface, &made);
        Ok((made, distance))
    };
    let smallest = simplify_to(target, listener)?;
    if smallest.1 <= max_error {
        return Ok(smallest);
    }
    let n_smallest = smallest.0.mesh.faces().len();
    // The search with proved distances ignores attributes, so with attributes sizes are tried and distances sampled.
    if options.purpose != Purpose::Poses {
        let found = simplify_to_error(&input, None, options, max_error, listener)?.simplified;
        let distance = measure_distance(surface, &found);
        return Ok((found, distance));
    }
    let (mut low, mut best) = (n_smallest, simplify_to(Target::Ratio(1.0), listener)?);
    for _ in 0..MAX_TRIES {
        let high = best.0.mesh.faces().len();
        let middle = ((low as f64) * (high as f64)).sqrt() as usize;
        if middle <= low || middle >= high {
            break;
        }
        let tried = simplify_to(Target::Faces(middle), listener)?;
        if tried.1 <= max_error && tried.0.mesh.faces().len() < high { best = tried } else { low = middle }
    }
    Ok(best)
}

/// Drops components with a radius of at most this share of the extent; returns the other triangles, n_faces x 3.
///
/// # Errors
/// [`IndexError`] if buffers are wrong.
pub fn prune_components(buffers: &Buffers, error: f64) -> Result<Vec<[u32; 3]>, IndexError> {
    buffers.check()?;
    let surface = WeldedMesh::new(buffers, buffers.extent())?;
    let prune_below = 2.0 * error * buffers.extent();
    let options = ClosedOptions { prune_below, prune: false, subset: true, ..ClosedOptions::default() };
    let options = Options::with_closed(Target::Ratio(1.0), options);
    match simplify(surface.to_input(), None, &options, &mut |_| ControlFlow::Continue(())) {
        Err(SimplifyError::Empty) => Ok(Vec::new()),
        made => Ok(surface.corner_vertices(&made?)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn simplify(buffers: &Buffers, options: &IndexOptions) -> Indices {
        simplify_indices(buffers.clone(), options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    fn pyramid(height: f32) -> Buffers {
        let mut positions: Vec<[f32; 3]> = (0..9).map(|v| [(v / 3) as f32, (v % 3) as f32, 0.0]).collect();
        positions[4][2] = height;
        let faces = [[0, 1, 3], [3, 1, 4], [1, 2, 4], [4, 2, 5], [3, 4, 6], [6, 4, 7], [4, 5, 7], [7, 5, 8]];
        Buffers::new(faces.to_vec(), positions)
    }

    fn three_triangles() -> Buffers {
        let corners = |k: u32| {
            let (size, z) = (2f32.powi(k as i32), k as f32);
            [[0.0, 0.0, z], [0.0, size, z], [size, 0.0, z]]
        };
        Buffers::new(vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]], (0..3).flat_map(corners).collect())
    }

    #[test]
    fn an_error_is_measured_only_where_something_needs_it() {
        let (positions, faces) = shapes::icosphere(3).into_parts();
        let buffers = Buffers::new(faces, positions);
        let unmeasured = IndexOptions { measures_error: false, ..IndexOptions::new(200, 1.0) };
        let (fast, slow) = (simplify(&buffers, &unmeasured), simplify(&buffers, &IndexOptions::new(200, 1.0)));
        assert_eq!((fast.error, &fast.indices), (None, &slow.indices));
        assert!(slow.error.is_some_and(|error| error > 0.0 && error < 0.1));
        // With a requested distance, the error is measured all the same.
        let bounded = simplify(&buffers, &IndexOptions { error: 0.01, ..unmeasured });
        assert!(bounded.error.is_some_and(|error| error <= 0.01) && bounded.indices.len() > 200);
    }

    #[test]
    fn locked_vertices_leave_the_size_to_the_error() {
        let locked = IndexOptions { lock_borders: true, is_absolute: true, ..IndexOptions::new(6, 2.0) };
        let result = simplify(&pyramid(1.0), &locked);
        assert_eq!((result.indices.len(), result.error), (6, Some(1.0)));
        let near = simplify(&pyramid(1.0), &IndexOptions { error: 0.9, ..locked });
        assert_eq!(near.indices.len(), 8);
    }

    #[test]
    fn nothing_is_left_where_nothing_is_requested() {
        let none = IndexOptions::new(0, 1.0);
        let result = simplify(&pyramid(1.0), &none);
        assert!(result.indices.is_empty() && result.error == Some(1.0));
        assert!(!simplify(&pyramid(1.0), &IndexOptions { error: 0.99, ..none }).indices.is_empty());
        let mut locked = pyramid(1.0);
        locked.locks = vec![0, 0, 0, 1, 0, 0, 0, 0, 0];
        assert!(simplify(&locked, &none).indices.iter().flatten().any(|&v| v == 3));
    }

    #[test]
    fn small_components_go_where_the_size_leaves_no_other_way() {
        let pruned = IndexOptions { lock_borders: true, prune: true, ..IndexOptions::new(1, 1.0) };
        let result = simplify(&three_triangles(), &pruned);
        assert_eq!(result.indices, [[6, 7, 8]]);
        // The radius of the middle one, as a share of 4: its corners' largest distance from their mean.
        assert!((result.error.unwrap() - f64::hypot(2.0 / 3.0, 4.0 / 3.0) / 4.0).abs() < 1e-6);
        assert_eq!(simplify(&three_triangles(), &IndexOptions { n_faces: 2, ..pruned }).indices.len(), 2);
        assert_eq!(simplify(&three_triangles(), &IndexOptions { error: 0.2, ..pruned }).indices.len(), 2);
        assert_eq!(simplify(&three_triangles(), &IndexOptions { prune: false, ..pruned }).indices.len(), 3);
        let mut locked = three_triangles();
        locked.locks = vec![1, 0, 0, 0, 0, 0, 0, 0, 0];
        assert_eq!(simplify(&locked, &pruned).indices, [[0, 1, 2], [6, 7, 8]]);
    }

    #[test]
    fn unused_vertices_count_unless_the_buffers_are_sparse() {
        let mut buffers = pyramid(0.5);
        buffers.positions.push([100.0; 3]);
        let near = IndexOptions { lock_borders: true, ..IndexOptions::new(6, 0.1) };
        assert_eq!(simplify(&buffers, &near).indices.len(), 6);
        assert_eq!(simplify(&buffers, &IndexOptions { is_sparse: true, ..near }).indices.len(), 8);
    }
    #[test]
    fn faces_that_are_turned_over_or_join_two_positions_do_not_stop_it() {
        let strip = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 1.0, 0.0], [1.5, 1.0, 0.0]];
        // The middle one of three is turned over; the result faces one way.
        let turned = Buffers::new(vec![[0, 1, 3], [1, 3, 4], [1, 2, 4]], strip);
        let result = simplify(&turned, &IndexOptions::new(2, 1e-3));
        let doubled_area = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|v| turned.positions[v as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        };
        let doubled_areas: Vec<f32> = result.indices.iter().map(doubled_area).collect();
        assert!(doubled_areas.len() == 2 && doubled_areas.iter().all(|area| *area > 0.0));
        assert!(doubled_areas.iter().sum::<f32>() == 3.0 && result.error.is_some_and(|error| error < 1e-9));
        let flat = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]];
        let flat = Buffers::new(vec![[0, 1, 2], [2, 1, 3]], flat);
        assert!(simplify(&flat, &IndexOptions::new(0, 1.0)).indices.is_empty());
    }

    #[test]
    fn a_seam_between_equal_attributes_costs_no_error() {
        // Rows of x = 0, 1 and 4 with an attribute that is linear between them, and a seam along y = 1.
        let rows = [(0.0, 0.0), (1.0, 1.0), (4.0, 2.0)];
        let row = |(x, _): (f32, f32)| [0.0, 1.0, 1.0, 2.0].map(|y| [x, y, 0.0]);
        let faces = [[0, 1, 4], [4, 1, 5], [2, 3, 6], [6, 3, 7], [4, 5, 8], [8, 5, 9], [6, 7, 10], [10, 7, 11]];
        let mut seamed = Buffers::new(faces.to_vec(), rows.into_iter().flat_map(row).collect());
        seamed.attributes = rows.into_iter().flat_map(|(_, value)| [value; 4]).collect();
        seamed.weights = vec![1.0];
        let result = simplify(&seamed, &IndexOptions { lock_borders: true, ..IndexOptions::new(4, 2.0) });
        assert!(result.indices.len() == 6 && result.error.is_some_and(|error| error < 1e-6));
    }
}
