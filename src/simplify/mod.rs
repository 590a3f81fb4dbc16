//! The pipeline, Secs. 3 and 4: a mesh and a target in, a lighter mesh and its story out.

mod assemblies;
mod bending;
mod closed;
mod components;
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
mod piece;
mod progress;
mod record;
mod report;
mod sample_vertices;
mod scattered_samples;
mod symmetric;
mod used;
mod versions;
mod weighed;

use crate::mesh::TriMesh;
use crate::model::Weights;
use assemblies::Task;
use driver::run;

pub use crate::mesh::vertex_normals;
pub use bending::bending_scores;
pub use closed::{Importance, importance_of_scores};
pub(crate) use components::{Pruned, pruned};
pub use groups::{GroupRatio, GroupsSimplified, simplify_groups};
pub use hidden::hidden_faces;
pub use input::{Input, importance_of_channel, importance_of_groups};
pub(crate) use levels::levels_of_sizes;
pub use levels::simplify_levels_of_detail;
pub use mesh_points::{MeshedPoints, cloud_graph, mesh_points, region_graph};
pub use network_scores::{edge_graph, network_scores, vertex_areas};
pub use options::{
    Assembly, Axis, DroppedComponent, Effort, Event, Hidden, Listener, Map, MirrorPlane, Optimize, Options, Outcome,
    Parts, Purpose, Report, SEAM_ERROR, ScoreSource, Simplified, SimplifyError, Symmetry, Target,
};
pub(crate) use piece::simplify_piece;
pub use record::Record;
pub use sample_vertices::gumbel_top_k;
pub use scattered_samples::scattered_samples;
pub use versions::{CARRIED_VERSION, CLOSED_VERSION, PAPER_VERSION};
pub use weighed::{Weighed, simplify_weighed};

/// Simplifies `mesh` to the target of `options`; `progress` hears of every stage and can stop the run.
///
/// `weights` are those of the network; without, those that ship where one is asked for: [`Weights::shipped_default`] with
/// [`ScoreSource::Network`], those of the feature `paper` for the paper's assembly.
///
/// # Errors
/// [`SimplifyError`]: nothing to simplify, options out of range, or stopped by `progress`. A target that cannot be
/// reached is no error: the result is then as small as it can be, and `report.outcome` says what holds it.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::simplify::{Options, ScoreSource, Target, simplify};
/// let mesh = shapes::icosphere(3);
/// let mut options = Options::new(Target::Vertices(100));
/// let result = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.mesh.positions().len(), 100);
/// // Every vertex counts by its area:
/// options.scores = ScoreSource::Geometry;
/// let result = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.report.scores, ScoreSource::Geometry);
/// ```
pub fn simplify(
    mesh: &TriMesh,
    weights: Option<&Weights>,
    options: &Options,
    progress: &mut Listener,
) -> Result<Simplified, SimplifyError> {
    simplify_input(&Input::bare(mesh), weights, options, progress)
}

/// As [`simplify`], with what the mesh carries: texture coordinates, normals, materials, skins come back with the result,
/// and vertices may count more than others.
///
/// Seams stay seams: no face of the result mixes two groups, or the two sides of an edge where the values jump. The values at
/// a corner are those of the original at the nearest point on the corner's side; texture coordinates and colours are then fitted, so
/// that what the faces blend between their corners is nearest to the original's. The paper's assembly carries nothing.
///
/// # Errors
/// As [`simplify`]; [`SimplifyError::BadInput`] where attributes or importance are not those of the mesh.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::{Attributes, shapes};
/// use neural_mesh::simplify::{Input, Options, Target, simplify_input};
/// let mesh = shapes::icosphere(4);
/// let is_north = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
/// let groups = mesh.faces().iter().map(|face| u32::from(is_north(face))).collect();
/// let attributes = Attributes { groups, ..Attributes::default() };
/// let mut input = Input::bare(&mesh);
/// input.attributes = &attributes;
/// let options = Options::new(Target::Vertices(200));
/// let result = simplify_input(&input, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.attributes.groups.len(), result.mesh.faces().len());
/// ```
pub fn simplify_input(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    progress: &mut Listener,
) -> Result<Simplified, SimplifyError> {
    let task = Task::of(options);
    run(input, weights, &task, progress).map(|(simplified, _)| simplified)
}

/// As [`simplify`], with the record of how the result depends on the positions of the input. Takes longer; the result
/// is the same.
///
/// # Errors
/// As [`simplify`].
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::simplify::{Options, Target, simplify_recorded};
/// let mesh = shapes::icosphere(3);
/// let options = Options::new(Target::Vertices(100));
/// let (result, record) =
///     simplify_recorded(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// // Where do the input's vertices have to go for vertex 0 of the result to move along x?
/// let mut gradient = vec![[0.0; 3]; 100];
/// gradient[0] = [1.0, 0.0, 0.0];
/// let to_input = record.backward(mesh.positions(), &gradient);
/// // If all of them move along x by 1, so does vertex 0.
/// assert!((to_input.iter().map(|g| g[0]).sum::<f32>() - 1.0).abs() < 1e-3);
/// assert_eq!(record.positions(mesh.positions()).len(), result.mesh.positions().len());
/// ```
pub fn simplify_recorded(
    mesh: &TriMesh,
    weights: Option<&Weights>,
    options: &Options,
    progress: &mut Listener,
) -> Result<(Simplified, Record), SimplifyError> {
    let task = Task { differentiable: true, ..Task::of(options) };
    let (simplified, derivative) = run(&Input::bare(mesh), weights, &task, progress)?;
    let (n_input, n_output) = (mesh.positions().len(), simplified.mesh.positions().len());
    let record = match derivative {
        Some(derivative) => Record::closed(n_input, n_output, derivative),
        None => Record::selected(n_input, simplified.source_vertices.clone().unwrap_or_default()),
    };
    Ok((simplified, record))
}
