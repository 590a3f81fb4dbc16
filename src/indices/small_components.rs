//! Small components of index buffers, which may vanish if the requested size cannot be reached otherwise.

use crate::mesh::TriMesh;
use crate::mesh::pulse::Pulse;
use crate::mesh::union_find::UnionFind;
use crate::simplify::Simplified;

use super::buffers::Buffers;
use super::welded::WeldedMesh;

/// Buffers without small components.
pub struct WithoutSmall {
    /// Buffers with the remaining triangles.
    pub buffers: Buffers,
    /// Largest radius of a dropped component, in the unit of the positions.
    pub radius: f64,
}

/// Drops the smallest components until the others have at most `n_faces` faces in the result; `None` if all stay.
///
/// A radius is the largest distance of a component's vertices from their mean. Components above `max_radius`, those
/// with locked vertices, and the largest one stay.
pub fn drop_small_components(
    surface: &WeldedMesh,
    result: &Simplified,
    buffers: &Buffers,
    n_faces: usize,
    max_radius: f64,
) -> Option<WithoutSmall> {
    let (component_of, n_components) = number_components(&surface.mesh);
    let radii = measure_radii(&surface.mesh, &component_of, n_components);
    let mut may_go = vec![true; n_components];
    for (&component, &is_locked) in component_of.iter().zip(&surface.locked) {
        may_go[component as usize] &= !is_locked;
    }
    // A dropped component frees the faces that it has in the result.
    let counts = count_faces(surface, result, &component_of, n_components)?;
    let mut by_size: Vec<usize> = (0..n_components).collect();
    by_size.sort_by(|&a, &b| radii[a].total_cmp(&radii[b]).then(a.cmp(&b)));
    by_size.pop();
    let mut is_dropped = vec![false; n_components];
    let (mut n_left, mut radius) = (result.mesh.faces().len(), None);
    for component in by_size.into_iter().filter(|&component| may_go[component]) {
        if n_left <= n_faces || radii[component] > max_radius {
            break;
        }
        n_left -= counts[component];
        (is_dropped[component], radius) = (true, Some(radii[component]));
    }
    let stays = |face: &usize| !is_dropped[component_of[surface.mesh.faces()[*face][0] as usize] as usize];
    let faces: Vec<usize> = (0..surface.mesh.faces().len()).filter(stays).collect();
    let mut left = buffers.clone();
    left.indices = faces.iter().map(|&face| surface.wedges[face]).collect();
    left.groups = faces.iter().filter_map(|&face| surface.attributes.groups.get(face).copied()).collect();
    radius.map(|radius| WithoutSmall { buffers: left, radius })
}

/// Counts the faces of a result that come from each component; `None` if their origin is unknown.
fn count_faces(
    surface: &WeldedMesh,
    result: &Simplified,
    component_of: &[u32],
    n_components: usize,
) -> Option<Vec<usize>> {
    let sources = result.source_vertices.as_ref();
    let corner_faces = result.map.as_ref().map(|map| &map.corner_faces);
    let mut counts = vec![0; n_components];
    for (face, corners) in result.mesh.faces().iter().enumerate() {
        let source = match (sources, corner_faces) {
            (Some(sources), _) => sources[corners[0] as usize],
            (None, Some(corner_faces)) => surface.mesh.faces()[corner_faces[face][0] as usize][0],
            (None, None) => return None,
        };
        counts[component_of[source as usize] as usize] += 1;
    }
    Some(counts)
}

fn number_components(mesh: &TriMesh) -> (Vec<u32>, usize) {
    let mut sets = UnionFind::new(mesh.positions().len());
    for &[a, b, c] in mesh.faces() {
        sets.union(a, b);
        sets.union(b, c);
    }
    sets.number_sets(Pulse::NONE)
}

fn measure_radii(mesh: &TriMesh, component_of: &[u32], n_components: usize) -> Vec<f64> {
    let mut sums = vec![[0.0; 4]; n_components];
    for (position, &component) in mesh.positions().iter().zip(component_of) {
        let sum = &mut sums[component as usize];
        (0..3).for_each(|k| sum[k] += f64::from(position[k]));
        sum[3] += 1.0;
    }
    let mut radii = vec![0.0f64; n_components];
    for (position, &component) in mesh.positions().iter().zip(component_of) {
        let sum = sums[component as usize];
        let distance2: f64 = (0..3).map(|k| (f64::from(position[k]) - sum[k] / sum[3]).powi(2)).sum();
        let radius = &mut radii[component as usize];
        *radius = radius.max(distance2.sqrt());
    }
    radii
}
