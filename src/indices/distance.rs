//! The distance of a result from the buffers, attributes included.

use crate::mesh::{Attributes, Channel, Role, TriMesh};
use crate::metrics::quick_distance;
use crate::simplify::Simplified;

use super::welded::WeldedMesh;

/// Samples on each surface for a face of the larger mesh, and how many there are at least and at most.
const SAMPLES: (usize, usize, usize) = (4, 200, 20_000);

/// Returns the largest distance between the surface and a result, as it is and in each of its poses, as far as samples show.
pub fn measure_distance(given: &WeldedMesh, made: &Simplified) -> f64 {
    let n_samples = (SAMPLES.0 * given.mesh.faces().len()).clamp(SAMPLES.1, SAMPLES.2);
    let between = |x: &TriMesh, y: &TriMesh| quick_distance(x, y, n_samples, 0).map_or(0.0, |found| found.max);
    let in_pose = |channel: &Channel| {
        let raised = made.attributes.channels.iter().find(|other| other.name == channel.name)?;
        let before = raise_surface(&given.mesh, &given.attributes, channel)?;
        Some(between(&before, &raise_surface(&made.mesh, &made.attributes, raised)?))
    };
    let poses = given.attributes.channels.iter().filter(|channel| channel.role == Role::MorphPosition);
    poses.filter_map(in_pose).fold(between(&given.mesh, &made.mesh), f64::max)
}

/// A mesh in a pose, its corners apart.
fn raise_surface(mesh: &TriMesh, attributes: &Attributes, channel: &Channel) -> Option<TriMesh> {
    let corners = mesh.faces().as_flattened().iter().zip(attributes.wedges.as_flattened());
    let place = |(&v, &wedge): (&u32, &u32)| {
        let (position, step) = (mesh.positions()[v as usize], channel.value(wedge));
        [0, 1, 2].map(|k| position[k] + step[k])
    };
    let faces = (0..mesh.faces().len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    TriMesh::new(corners.map(place).collect(), faces).ok()
}
