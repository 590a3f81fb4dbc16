//! Levels of detail and the distances from which they are shown.

use std::ops::ControlFlow;

use bevy_camera::visibility::VisibilityRange;
use bevy_mesh::Mesh;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{DistanceTolerance, certified_distance};
use neural_mesh::search::simplify_to_error;
use neural_mesh::simplify::{ClosedOptions, Report, Simplified, Size, simplify_levels_of_detail};

use crate::mesh_source::MeshSource;
use crate::result_mesh::make_mesh;
use crate::simplify::in_frame;
use crate::{MeshError, Screen, visibility_ranges};

/// Sizes of the levels below the original.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LevelSizes {
    /// Shares of the positions, each above 0, at most 1 and no larger than the one before.
    Ratios(Vec<f64>),
    /// Largest distances to the original, in the unit of the mesh, each no smaller than the one before.
    ///
    /// [`Screen::error_at`] returns the error for a distance of the camera.
    Errors(Vec<f64>),
}

/// Options of levels; end a literal with `..LevelOptions::default()`, as versions may add fields.
#[derive(Clone, Debug)]
pub struct LevelOptions {
    /// Options of the simplifier.
    pub simplify: ClosedOptions,
    /// Screen on which errors show.
    pub screen: Screen,
    /// Length of a cross-fade, as a share of the distance at which it begins.
    pub fade: f32,
    /// Largest scale of the entities that show the levels.
    pub scale: f32,
    /// Distance from which nothing is shown; `None` if the last level is always shown.
    pub end: Option<f32>,
}

impl Default for LevelOptions {
    fn default() -> Self {
        Self { simplify: ClosedOptions::default(), screen: Screen::default(), fade: 0.1, scale: 1.0, end: None }
    }
}

/// Level of detail.
#[derive(Clone)]
#[non_exhaustive]
pub struct Level {
    /// Mesh of the level.
    pub mesh: Mesh,
    /// Proved bound of its largest distance to the original, in the unit of the mesh; 0 for the original.
    pub error: f64,
    /// Range of camera distances at which it is shown, in world units.
    pub range: VisibilityRange,
    /// Outcome and statistics; `None` for the original.
    pub report: Option<Report>,
}

/// Makes levels of detail, the original first, with the range of distances for each.
///
/// A level begins where its error shows with at most [`Screen::error`] pixels in the middle of the view. Bevy measures the
/// distance to the entity's origin, so the farthest vertex from the origin is added. All levels must be children of one
/// entity without transforms of their own, as [`spawn_levels`](crate::spawn_levels) makes them. Ratios take one collapse
/// for all levels, errors a search for each.
///
/// # Errors
/// As [`simplify_mesh`](crate::simplify_mesh), and if sizes are not in order.
///
/// ```
/// use bevy_mesh::{Indices, Mesh, PrimitiveTopology};
/// use neural_mesh_bevy::{LevelOptions, LevelSizes, make_levels};
/// # let (positions, faces) = neural_mesh::mesh::shapes::icosphere(3).into_parts();
/// # let sphere = Mesh::new(PrimitiveTopology::TriangleList, Default::default())
/// #     .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
/// #     .with_inserted_indices(Indices::U32(faces.into_flattened()));
/// let sizes = LevelSizes::Ratios(vec![0.5, 0.1]);
/// let levels = make_levels(&sphere, &sizes, &LevelOptions::default())?;
/// assert_eq!(levels.len(), 3);
/// assert!(levels[0].range.is_visible_at_all(0.0) && levels[2].range.is_visible_at_all(1000.0));
/// assert!(levels[1].error < levels[2].error);
/// # Ok::<(), neural_mesh_bevy::MeshError>(())
/// ```
pub fn make_levels(mesh: &Mesh, sizes: &LevelSizes, options: &LevelOptions) -> Result<Vec<Level>, MeshError> {
    let source = MeshSource::read(mesh)?;
    let simplify = in_frame(&options.simplify, &source);
    let results = match sizes {
        LevelSizes::Ratios(ratios) => simplify_to_ratios(&source, ratios, &simplify)?,
        LevelSizes::Errors(errors) => simplify_to_errors(&source, errors, &simplify)?,
    };
    let radius = farthest_from_origin(&source);
    let scale = f64::from(options.scale);
    let start = |(_, error): &(Simplified, f64)| options.screen.distance_of(scale * error) + (scale * radius) as f32;
    let starts: Vec<f32> = std::iter::once(0.0).chain(results.iter().map(start)).collect();
    let mut ranges = visibility_ranges(&starts, options.fade, options.end).into_iter();
    let original = ranges.next().map(|range| Level { mesh: mesh.clone(), error: 0.0, range, report: None });
    let simplified = results.into_iter().zip(ranges).map(|((result, error), range)| Level {
        mesh: make_mesh(mesh, &source, &result),
        error,
        range,
        report: Some(result.report),
    });
    Ok(original.into_iter().chain(simplified).collect())
}

/// Returns results with the bounds of their errors.
fn simplify_to_ratios(
    source: &MeshSource,
    ratios: &[f64],
    options: &ClosedOptions,
) -> Result<Vec<(Simplified, f64)>, MeshError> {
    let targets: Vec<Size> = ratios.iter().copied().map(Size::Ratio).collect();
    let go_on = &mut |_| ControlFlow::Continue(());
    let results = simplify_levels_of_detail(source.input(), options, &targets, go_on)?;
    let with_bound = |result: Simplified| {
        let bound = bound_error(&source.cleaned.mesh, &result.mesh);
        (result, bound)
    };
    Ok(results.into_iter().map(with_bound).collect())
}

fn simplify_to_errors(
    source: &MeshSource,
    errors: &[f64],
    options: &ClosedOptions,
) -> Result<Vec<(Simplified, f64)>, MeshError> {
    if errors.iter().any(|error| error.is_nan() || *error < 0.0) || !errors.is_sorted() {
        return Err(MeshError::LevelErrors);
    }
    let mut results = Vec::with_capacity(errors.len());
    for &error in errors {
        let go_on = &mut |_| ControlFlow::Continue(());
        let found = simplify_to_error(&source.input(), options, error, go_on)?;
        // Dropped components count, too, which the search leaves aside.
        let bound = bound_error(&source.cleaned.mesh, &found.simplified.mesh);
        results.push((found.simplified, bound));
    }
    Ok(results)
}

/// Returns a proved bound of the largest distance between the surfaces; 0 for equal meshes.
fn bound_error(original: &TriMesh, result: &TriMesh) -> f64 {
    if original == result {
        return 0.0;
    }
    let bounds = certified_distance(original, result, &DistanceTolerance::default());
    bounds.map_or_else(|| original.diagonal(), |bounds| bounds.upper)
}

fn farthest_from_origin(source: &MeshSource) -> f64 {
    let frame = source.cleaned.frame;
    let distance2 = |&position: &[f32; 3]| frame.to_file(position).iter().map(|x| x * x).sum::<f64>();
    source.cleaned.mesh.positions().iter().map(distance2).fold(0.0, f64::max).sqrt()
}
