//! Pairs of faces over the same three vertices, one for each side of a leaf.
//!
//! The collapse would part such faces and open the surface, so it does not see them.

use rustc_hash::FxHashSet;

use crate::clusters::vertices::{Patch, ReducedPatch};
use crate::mesh::union_find::join_vertices;
use crate::mesh::{Attributes, TriMesh, compact, sides};

use super::sparse_components::MOST_LEAF_FACES;
use super::vertex_clustering::distinct_faces;

/// Faces of a patch that the collapse gets, and those of leaves.
pub struct PartedPatch {
    /// Mesh, attributes and locked vertices for the collapse; `None` without faces.
    pub for_collapse: Option<(TriMesh, Attributes, Vec<bool>)>,
    /// Faces of leaves with two sides.
    pub leaves: Vec<u32>,
}

/// Sets leaves aside and drops other pairs, which two groups make where each puts one side of a flat part.
///
/// Sheets with two sides that are larger than a leaf stay for the collapse, which parts their sides.
pub fn part_double_faces(patch: &Patch) -> PartedPatch {
    let faces = patch.mesh.faces();
    let (_, single) = distinct_faces(faces.iter().copied());
    if single.len() == faces.len() {
        let whole = (patch.mesh.clone(), patch.attributes.clone(), patch.locked.clone());
        return PartedPatch { for_collapse: Some(whole), leaves: Vec::new() };
    }
    let mut is_single = vec![false; faces.len()];
    single.iter().for_each(|&face| is_single[face as usize] = true);
    let sheets = find_sheets(&patch.mesh, &is_single);
    let (leaves, sheets): (Vec<_>, Vec<_>) = sheets.into_iter().partition(|sheet| sheet.len() <= MOST_LEAF_FACES);
    let mut kept: Vec<u32> = single.into_iter().chain(sheets.into_iter().flatten()).collect();
    kept.sort_unstable();
    PartedPatch { for_collapse: select(patch, &kept), leaves: leaves.into_iter().flatten().collect() }
}

/// Returns the components of double faces of which no edge is one of a single face.
fn find_sheets(mesh: &TriMesh, is_single: &[bool]) -> Vec<Vec<u32>> {
    let faces = || (0u32..).zip(mesh.faces());
    let of_single: FxHashSet<[u32; 2]> =
        faces().filter(|(face, _)| is_single[*face as usize]).flat_map(|(_, corners)| sides(*corners)).collect();
    let double = || faces().filter(|(face, _)| !is_single[*face as usize]);
    let mut sets = join_vertices(mesh.positions().len(), double().map(|(_, corners)| *corners));
    let mut sheets: Vec<Vec<u32>> = vec![Vec::new(); mesh.positions().len()];
    let mut is_attached = vec![false; sheets.len()];
    for (face, corners) in double() {
        let sheet = sets.find(corners[0]) as usize;
        sheets[sheet].push(face);
        is_attached[sheet] |= sides(*corners).iter().any(|side| of_single.contains(side));
    }
    sheets
        .into_iter()
        .zip(is_attached)
        .filter(|(sheet, attached)| !sheet.is_empty() && !attached)
        .map(|it| it.0)
        .collect()
}

fn select(patch: &Patch, faces: &[u32]) -> Option<(TriMesh, Attributes, Vec<bool>)> {
    let corners = faces.iter().map(|&face| patch.mesh.faces()[face as usize]).collect();
    let (mesh, vertices) =
        compact(patch.mesh.positions(), corners).ok().filter(|(mesh, _)| !mesh.faces().is_empty())?;
    let locked = vertices.iter().map(|&v| patch.locked[v as usize]).collect();
    Some((mesh, patch.attributes.clone().select_faces(faces)?, locked))
}

/// Adds leaves of the patch to its simplified other faces.
pub fn add_leaves(reduced: ReducedPatch, patch: &Patch, leaves: &[u32]) -> ReducedPatch {
    let Some((mesh, attributes, _)) = select(patch, leaves) else { return reduced };
    let n = reduced.mesh.positions().len() as u32;
    let positions = reduced.mesh.positions().iter().chain(mesh.positions()).copied().collect();
    let faces =
        reduced.mesh.faces().iter().copied().chain(mesh.faces().iter().map(|face| face.map(|v| v + n))).collect();
    let Ok(joined) = TriMesh::new(positions, faces) else { return reduced };
    let groups: Vec<u32> = [(&reduced.mesh, &reduced.attributes), (&mesh, &attributes)]
        .into_iter()
        .flat_map(|(mesh, attributes)| (0..mesh.faces().len() as u32).map(move |face| attributes.group(face)))
        .collect();
    let n_wedges = reduced.attributes.n_wedges() as u32;
    let ReducedPatch { attributes: Attributes { mut wedges, mut channels, .. }, .. } = reduced;
    wedges.extend(attributes.wedges.iter().map(|face| face.map(|wedge| wedge + n_wedges)));
    for (channel, of_leaves) in channels.iter_mut().zip(attributes.channels) {
        channel.values.extend(of_leaves.values);
    }
    let groups = if groups.iter().any(|group| *group != 0) { groups } else { Vec::new() };
    ReducedPatch { mesh: joined, attributes: Attributes { wedges, channels, groups } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clusters::vertices::VertexPool;
    use crate::mesh::shapes;
    use crate::simplify::Input;

    fn patch_of(mesh: &TriMesh) -> Patch {
        let (pool, faces) = VertexPool::new(&Input::bare(mesh));
        pool.patch(&faces, |_| false).unwrap()
    }

    fn triangles(mesh: &TriMesh) -> Vec<[[f32; 3]; 3]> {
        mesh.faces().iter().map(|face| face.map(|v| mesh.positions()[v as usize])).collect()
    }

    /// A sphere, and `n` squares with two sides next to it.
    fn with_leaves(n: u32) -> TriMesh {
        let sphere = shapes::icosphere(2);
        let first = sphere.positions().len() as u32;
        let square = |i: u32| {
            let x = 3.0 + 2.0 * i as f32;
            [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]]
        };
        let sides = [[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]];
        let faces = (0..n).flat_map(|i| sides.map(|face| face.map(|v| first + 4 * i + v)));
        let positions = sphere.positions().iter().copied().chain((0..n).flat_map(square)).collect();
        TriMesh::new(positions, sphere.faces().iter().copied().chain(faces).collect()).unwrap()
    }

    #[test]
    fn leaves_with_two_sides_come_back() {
        let mesh = with_leaves(3);
        let patch = patch_of(&mesh);
        let parted = part_double_faces(&patch);
        let (rest, attributes, _) = parted.for_collapse.unwrap();
        assert_eq!((rest.faces().len(), parted.leaves.len()), (mesh.faces().len() - 12, 12));
        let again = add_leaves(ReducedPatch { mesh: rest, attributes }, &patch, &parted.leaves);
        assert!(triangles(&again.mesh) == triangles(&mesh));
        assert_eq!(again.mesh.positions().len(), mesh.positions().len());
    }

    #[test]
    fn larger_sheets_stay_for_the_collapse() {
        let grid = shapes::grid(5, 5);
        let back = grid.faces().iter().map(|&[a, b, c]| [a, c, b]);
        let faces: Vec<[u32; 3]> = grid.faces().iter().copied().chain(back).collect();
        let sheet = TriMesh::new(grid.positions().to_vec(), faces).unwrap();
        let parted = part_double_faces(&patch_of(&sheet));
        assert!(triangles(&parted.for_collapse.unwrap().0) == triangles(&sheet) && parted.leaves.is_empty());
    }

    #[test]
    fn pairs_beside_other_faces_go() {
        let sphere = shapes::icosphere(1);
        let [a, b, c] = sphere.faces()[0];
        let faces = sphere.faces().iter().copied().chain([[a, b, c], [a, c, b]]).collect();
        let parted = part_double_faces(&patch_of(&TriMesh::new(sphere.positions().to_vec(), faces).unwrap()));
        assert_eq!(parted.for_collapse.unwrap().0.faces().len(), sphere.faces().len());
    }
}
