//! Simplification of Bevy meshes.

use std::ops::ControlFlow;

use bevy_mesh::Mesh;
use neural_mesh::search;
use neural_mesh::simplify::{ClosedOptions, Options, Report, Size, simplify};

use crate::MeshError;
use crate::mesh_source::MeshSource;
use crate::result_mesh::make_mesh;

/// Simplified mesh with its report.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SimplifiedMesh {
    /// Mesh with all attributes of the original, one vertex per position and set of attributes.
    pub mesh: Mesh,
    /// Outcome and statistics; `report.outcome` names the obstacle if the size was not reached.
    pub report: Report,
}

/// Simplifies a mesh to a size with all its attributes.
///
/// Vertices at one position are joined, so a seam is no boundary. Normals, tangents, texture coordinates, colours, joints
/// with weights, morph targets, and attributes of float formats are carried; 64-bit floats are rounded to 32 bits. The
/// result has indices of the original's size, and of 16 bits if the original has none. A ratio counts positions, not
/// vertices. `options.frame` has no effect.
///
/// # Errors
/// [`MeshError`] for a mesh that is no list of triangles, has attributes that cannot be interpolated, or cannot be
/// simplified.
///
/// ```
/// use bevy_mesh::{Indices, Mesh, PrimitiveTopology};
/// use neural_mesh_bevy::{ClosedOptions, Size, simplify_mesh};
/// # let (positions, faces) = neural_mesh::mesh::shapes::icosphere(3).into_parts();
/// let sphere = Mesh::new(PrimitiveTopology::TriangleList, Default::default())
///     .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
///     .with_inserted_indices(Indices::U32(faces.into_flattened()));
/// let light = simplify_mesh(&sphere, Size::Faces(200), &ClosedOptions::default())?.mesh;
/// assert_eq!(light.indices().map(Indices::len), Some(600));
/// # Ok::<(), neural_mesh_bevy::MeshError>(())
/// ```
pub fn simplify_mesh(mesh: &Mesh, target: Size, options: &ClosedOptions) -> Result<SimplifiedMesh, MeshError> {
    let source = MeshSource::read(mesh)?;
    let options = Options::with_closed(target, in_frame(options, &source));
    let result = simplify(source.input(), &options, &mut |_| ControlFlow::Continue(()))?;
    Ok(SimplifiedMesh { mesh: make_mesh(mesh, &source, &result), report: result.report })
}

/// Finds the smallest mesh whose surface is proved to be within `error` of the original, in the unit of the mesh.
///
/// If none is proved, `report.outcome` says so.
///
/// # Errors
/// As [`simplify_mesh`], and if `error` is negative or not a number.
///
/// ```
/// use bevy_mesh::{Indices, Mesh, PrimitiveTopology};
/// use neural_mesh_bevy::{ClosedOptions, Outcome, simplify_mesh_to_error};
/// # let (positions, faces) = neural_mesh::mesh::shapes::icosphere(3).into_parts();
/// # let sphere = Mesh::new(PrimitiveTopology::TriangleList, Default::default())
/// #     .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
/// #     .with_inserted_indices(Indices::U32(faces.into_flattened()));
/// // A sphere of radius 1.
/// let light = simplify_mesh_to_error(&sphere, 0.05, &ClosedOptions::default())?;
/// assert_eq!(light.report.outcome, Outcome::Reached);
/// assert!(light.mesh.indices().is_some_and(|indices| indices.len() < 3 * 500));
/// # Ok::<(), neural_mesh_bevy::MeshError>(())
/// ```
pub fn simplify_mesh_to_error(mesh: &Mesh, error: f64, options: &ClosedOptions) -> Result<SimplifiedMesh, MeshError> {
    let source = MeshSource::read(mesh)?;
    let go_on = &mut |_| ControlFlow::Continue(());
    let found = search::simplify_to_error(&source.input(), &in_frame(options, &source), error, go_on)?;
    Ok(SimplifiedMesh { mesh: make_mesh(mesh, &source, &found.simplified), report: found.simplified.report })
}

/// Returns the options with the frame of the mesh, in which results are written.
pub(crate) fn in_frame(options: &ClosedOptions, source: &MeshSource) -> ClosedOptions {
    ClosedOptions { frame: source.cleaned.frame, ..options.clone() }
}
