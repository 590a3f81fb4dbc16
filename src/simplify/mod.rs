//! The pipeline, Secs. 3 and 4: a mesh and a target in, a lighter mesh and its story out.

mod closed;
mod network_scores;
mod options;
pub mod paper;
mod sample_vertices;

use std::ops::ControlFlow;

use crate::mesh::TriMesh;
use closed::{Closed, End, Limit, Request, simplify_closed};

pub use network_scores::network_scores;
pub use options::{Assembly, Event, Options, Outcome, Report, ScoreSource, Simplified, SimplifyError, Target};
pub use sample_vertices::gumbel_top_k;

/// Samples per vertex asked for, where the caller leaves the choice.
const OVERSAMPLE: f64 = 2.0;

/// Simplifies `mesh` to the target of `options`; `progress` hears of every stage and can stop the run.
///
/// # Errors
/// [`SimplifyError`]: nothing to simplify, options out of range, or stopped by `progress`. A target that cannot be
/// reached is no error: the result is then as small as it can be, and `report.outcome` says what holds it.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::TriMesh;
/// use neural_mesh::simplify::{Options, Target, simplify};
/// let (positions, faces) = neural_mesh::mesh::shapes::icosphere(3).into_parts();
/// let mesh = TriMesh::new(positions, faces).unwrap();
/// let result = simplify(&mesh, &Options::new(Target::Vertices(100)), &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.mesh.positions().len(), 100);
/// ```
pub fn simplify(
    mesh: &TriMesh,
    options: &Options,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    let limit = resolve_limit(mesh, options)?;
    let oversample = resolve_oversample(options)?;
    let request = Request { limit, oversample, density: None, seed: options.seed, frame: options.frame };
    let closed = simplify_closed(mesh, &request, progress)?;
    Ok(Simplified { source_vertices: None, report: report(&closed, oversample), mesh: closed.mesh })
}

fn report(closed: &Closed, oversample: f64) -> Report {
    let outcome = match closed.end {
        End::Reached => Outcome::Reached,
        End::Smallest => Outcome::Stopped("every component is as small as its topology allows".into()),
        End::WouldTurn => Outcome::Stopped("no edge is left that could go without turning a face over".into()),
    };
    Report {
        outcome,
        scores: ScoreSource::Geometry,
        oversample,
        vertices_after_pass: closed.vertices_after_pass,
        components: 0,
        components_at_minimum: 0,
        components_pruned: 0,
        split_vertices: closed.split_vertices,
        refined_regions: closed.refined_regions,
        separated_vertices: closed.separated_vertices,
    }
}

fn resolve_oversample(options: &Options) -> Result<f64, SimplifyError> {
    let oversample = options.oversample.unwrap_or(OVERSAMPLE);
    if (1.0..=4.0).contains(&oversample) { Ok(oversample) } else { Err(SimplifyError::BadOversample(oversample)) }
}

/// The target as numbers of vertices and faces.
fn resolve_limit(mesh: &TriMesh, options: &Options) -> Result<Limit, SimplifyError> {
    if mesh.faces().is_empty() {
        return Err(SimplifyError::Empty);
    }
    let bad = Err(SimplifyError::BadTarget(options.target));
    match options.target {
        Target::Ratio(ratio) if ratio > 0.0 && ratio <= 1.0 => {
            let vertices = ((mesh.positions().len() as f64 * ratio) as usize).max(1);
            Ok(Limit { vertices, faces: usize::MAX })
        }
        Target::Vertices(vertices) if vertices > 0 => Ok(Limit { vertices, faces: usize::MAX }),
        Target::Faces(faces) if faces > 0 => Ok(Limit { vertices: usize::MAX, faces }),
        _ => bad,
    }
}
