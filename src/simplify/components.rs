//! Connected components: which may be pruned, and which ended in their smallest form.

use crate::mesh::union_find::UnionFind;
use crate::mesh::{TriMesh, compact};

/// A component too small to be worth keeping has room for fewer vertices than this.
const LEAST_SHARE: f64 = 4.0;
/// Faces of the smallest closed surface, a tetrahedron.
const TETRAHEDRON: usize = 4;

/// The component of every face, numbered in the order of their first faces, and how many there are.
fn components(mesh: &TriMesh) -> (Vec<u32>, usize) {
    let mut sets = UnionFind::new(mesh.positions().len());
    for &[a, b, c] in mesh.faces() {
        sets.union(a, b);
        sets.union(b, c);
    }
    let mut number = vec![u32::MAX; mesh.positions().len()];
    let mut n = 0;
    let component = mesh.faces().iter().map(|face| {
        let slot = &mut number[sets.find(face[0]) as usize];
        if *slot == u32::MAX {
            *slot = n;
            n += 1;
        }
        *slot
    });
    let component = component.collect();
    (component, n as usize)
}

/// Number of components, and of those that no collapse can make smaller (a tetrahedron or a single triangle).
pub(super) fn count_components(mesh: &TriMesh) -> (usize, usize) {
    let (component, n) = components(mesh);
    let mut n_faces = vec![0; n];
    component.iter().for_each(|&c| n_faces[c as usize] += 1);
    (n, n_faces.iter().filter(|&&n| n == 1 || n == TETRAHEDRON).count())
}

/// A mesh without its smallest components.
pub(super) struct Pruned {
    /// What is left.
    pub mesh: TriMesh,
    /// Where its vertices stood.
    pub sources: Vec<u32>,
    /// Which of its faces are left.
    pub faces: Vec<u32>,
    /// Number of components dropped.
    pub n_dropped: usize,
}

/// Drops, smallest first, the components whose share of `n_target` vertices by area is below four.
///
/// The largest component always stays. `None` where nothing is dropped.
pub(super) fn pruned(mesh: &TriMesh, n_target: usize) -> Option<Pruned> {
    let (component, n) = components(mesh);
    let mut areas = vec![0.0f64; n];
    for (face, &c) in mesh.faces().iter().zip(&component) {
        let corners = face.map(|v| glam::Vec3::from(mesh.positions()[v as usize]).as_dvec3());
        areas[c as usize] += crate::geometry::triangle::area_normal_f64(corners).length();
    }
    let mut by_area: Vec<usize> = (0..n).collect();
    by_area.sort_by(|&x, &y| areas[x].total_cmp(&areas[y]).then(x.cmp(&y)));
    let mut left: f64 = areas.iter().sum();
    let mut dropped = vec![false; n];
    for &c in &by_area[..n - 1] {
        if n_target as f64 * areas[c] >= LEAST_SHARE * left {
            break;
        }
        dropped[c] = true;
        left -= areas[c];
    }
    let n_dropped = dropped.iter().filter(|&&d| d).count();
    if n_dropped == 0 {
        return None;
    }
    let faces: Vec<u32> = (0u32..).zip(&component).filter(|(_, c)| !dropped[**c as usize]).map(|(f, _)| f).collect();
    let kept = faces.iter().map(|&f| mesh.faces()[f as usize]).collect();
    compact(mesh.positions(), kept).ok().map(|(mesh, sources)| Pruned { mesh, sources, faces, n_dropped })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn small_boxes_go_first_and_the_largest_always_stays() {
        let boxes = shapes::many_boxes(94);
        assert_eq!(count_components(&boxes), (94, 0));
        assert!(pruned(&boxes, 1_000_000_000).is_none());
        let some = pruned(&boxes, 100).unwrap();
        assert_eq!(count_components(&some.mesh).0, 94 - some.n_dropped);
        let last = pruned(&boxes, 4).unwrap();
        assert_eq!((count_components(&last.mesh).0, last.n_dropped), (1, 93));
    }

    #[test]
    fn a_tetrahedron_is_as_small_as_it_gets() {
        assert_eq!(count_components(&shapes::tetrahedron()), (1, 1));
    }
}
