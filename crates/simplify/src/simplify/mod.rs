//! Mesh simplification: takes a mesh and a target size, returns a smaller mesh and a report (Secs. 3 and 4).

mod assemblies;
mod bending;
mod block_mesh;
mod cards;
mod closed;
mod cloud;
mod components;
mod draw;
mod driver;
mod groups;
mod hidden;
mod input;
mod levels;
mod limits;
mod map;
mod mesh_points;
mod network_scores;
mod options;
pub mod paper;
mod progress;
mod progression;
mod progression_bytes;
mod record;
mod report;
mod sample_vertices;
mod scattered_samples;
mod size;
mod sub_mesh;
mod turns;
mod versions;
mod with_importance;

use driver::run;

pub use crate::mesh::vertex_normals;
pub use bending::bending_scores;
#[doc(hidden)]
pub use block_mesh::{SimplifiedBlock, simplify_block_mesh};
pub use closed::importance_of_scores;
#[doc(hidden)]
pub use components::prune;
pub use draw::Draw;
pub use groups::{GroupRatio, SimplifiedGroups, simplify_groups};
pub use input::{Input, importance_of_channel, importance_of_groups};
pub use levels::simplify_levels_of_detail;
#[doc(hidden)]
pub use levels::{simplify_forcing_size, simplify_in_turn};
pub use mesh_points::{MeshedPoints, PointsOptions, cloud_graph, mesh_points, region_graph};
pub use network_scores::{asked_scores, edge_graph, network_scores, vertex_areas};
pub use options::{
    Assembly, ClosedOptions, DroppedComponent, Effort, Event, Hidden, Listener, Map, Optimize, Options, Outcome,
    PaperOptions, Purpose, Report, SEAM_ERROR, ScoreSource, Simplified, SimplifyError,
};
pub use progression::{Progression, ProvedLevel};
pub use record::Record;
pub use sample_vertices::gumbel_top_k;
pub use scattered_samples::scattered_samples;
pub use size::{Size, count_of_share, percent};
#[doc(hidden)]
pub use turns::{ChooseSize, NextSize, Turn};
pub use versions::{CARRIED_VERSION, CLOSED_VERSION, PAPER_VERSION};
pub use with_importance::{WeightedResult, simplify_with_importance};

/// Simplifies a mesh to the target of `options`; `progress` receives every stage and can stop the run.
///
/// The input is a mesh, or an [`Input`] with texture coordinates, normals, materials and skins; no face of the result
/// mixes two groups or the two sides of a seam.
///
/// # Errors
/// [`SimplifyError`] for an empty mesh, bad options or attributes of another mesh, or if `progress` stops the run. An
/// unreachable target is no error: `report.outcome` names the obstacle.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::{Attributes, shapes};
/// use neural_mesh::simplify::{ClosedOptions, Input, Options, ScoreSource, Size, simplify};
/// let mesh = shapes::icosphere(4);
/// let target = Size::Vertices(200);
/// let result = simplify(&mesh, &Options::new(target), &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.mesh.positions().len(), 200);
/// // Without scores, every vertex counts by its area; groups of faces are kept apart:
/// let options = Options::with_closed(target, ClosedOptions { scores: ScoreSource::Geometry, ..ClosedOptions::default() });
/// let is_north = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
/// let groups = mesh.faces().iter().map(|face| u32::from(is_north(face))).collect();
/// let attributes = Attributes { groups, ..Attributes::default() };
/// let mut input = Input::bare(&mesh);
/// input.attributes = &attributes;
/// let result = simplify(&input, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.attributes.groups.len(), result.mesh.faces().len());
/// ```
pub fn simplify<'a>(
    input: impl Into<Input<'a>>,
    options: &Options,
    progress: &mut Listener,
) -> Result<Simplified, SimplifyError> {
    run(&input.into(), options, false, progress).map(|(simplified, _)| simplified)
}

/// Simplifies as [`simplify`] does, and also returns how the result depends on the input positions.
///
/// # Errors
/// As [`simplify`].
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::simplify::{Options, Size, simplify_recorded};
/// let mesh = shapes::icosphere(3);
/// let options = Options::new(Size::Vertices(100));
/// let (result, record) =
///     simplify_recorded(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// // In which direction must the input vertices move for vertex 0 of the result to move along x?
/// let mut gradient = vec![[0.0; 3]; 100];
/// gradient[0] = [1.0, 0.0, 0.0];
/// let to_input = record.backward(mesh.positions(), &gradient);
/// // Moving all of them along x by 1 moves vertex 0 by 1.
/// assert!((to_input.iter().map(|g| g[0]).sum::<f32>() - 1.0).abs() < 1e-3);
/// assert_eq!(record.positions(mesh.positions()).len(), result.mesh.positions().len());
/// ```
pub fn simplify_recorded<'a>(
    input: impl Into<Input<'a>>,
    options: &Options,
    progress: &mut Listener,
) -> Result<(Simplified, Record), SimplifyError> {
    let input = input.into();
    let (simplified, derivative) = run(&input, options, true, progress)?;
    let mesh = input.mesh;
    let (n_input, n_output) = (mesh.positions().len(), simplified.mesh.positions().len());
    let record = match derivative {
        Some(derivative) => Record::from_derivative(n_input, n_output, derivative),
        None => Record::from_selection(mesh, simplified.source_vertices.clone().unwrap_or_default()),
    };
    Ok((simplified, record))
}
