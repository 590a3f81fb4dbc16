//! Distance of a result from the caller's buffers, attributes included.

use crate::mesh::{Attributes, Channel, Role, TriMesh};
use crate::metrics::quick_distance;
use crate::simplify::Simplified;

use super::welded::WeldedMesh;

/// Samples on each surface: the first per face of the original, clamped to the other two.
const SAMPLES: (usize, usize, usize) = (4, 200, 20_000);

/// Returns the largest sampled distance between surface and result, also after each weighted attribute has raised both.
pub fn measure_distance(surface: &WeldedMesh, result: &Simplified) -> f64 {
    let n_samples = (SAMPLES.0 * surface.mesh.faces().len()).clamp(SAMPLES.1, SAMPLES.2);
    let between = |x: &TriMesh, y: &TriMesh| quick_distance(x, y, n_samples, 0).map_or(0.0, |distance| distance.max);
    let in_pose = |channel: &Channel| {
        let raised = result.attributes.channels.iter().find(|other| other.name == channel.name)?;
        let before = raise_surface(&surface.mesh, &surface.attributes, channel)?;
        Some(between(&before, &raise_surface(&result.mesh, &result.attributes, raised)?))
    };
    let poses = surface.attributes.channels.iter().filter(|channel| channel.role == Role::MorphPosition);
    poses.filter_map(in_pose).fold(between(&surface.mesh, &result.mesh), f64::max)
}

fn raise_surface(mesh: &TriMesh, attributes: &Attributes, channel: &Channel) -> Option<TriMesh> {
    let corners = mesh.faces().as_flattened().iter().zip(attributes.wedges.as_flattened());
    let raise = |(&v, &wedge): (&u32, &u32)| {
        let (position, offset) = (mesh.positions()[v as usize], channel.value(wedge));
        [0, 1, 2].map(|k| position[k] + offset[k])
    };
    let faces = (0..mesh.faces().len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    TriMesh::new(corners.map(raise).collect(), faces).ok()
}
