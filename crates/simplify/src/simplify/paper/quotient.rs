//! Edges, triangles and normals between the regions of the samples.

use super::NO_SAMPLE;
use crate::geometry::triangle::area_normal_f64;
use crate::linalg::Csr;
use glam::{DVec3, Vec3};

/// Edges, triangles and normals between the regions of the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Quotient {
    /// Regions joined by an edge of the mesh, n_samples x n_samples.
    pub edges: Csr,
    /// Triangles that faces of the mesh span between three regions, each ascending, sorted, without repeats.
    pub triangles: Vec<[u32; 3]>,
    /// Net winding of each triangle: number of faces wound like its ascending corners, less those wound against them.
    pub windings: Vec<i32>,
    /// Sum of the area normals of the faces at each sample's region, a third per corner.
    pub normals: Vec<DVec3>,
}

/// Finds edges, triangles and normals between the regions.
///
/// # Shapes
/// - `positions`: n x 3, `faces`: n_faces x 3
/// - `assignment`: n samples, below `n_samples` or [`NO_SAMPLE`]
///
/// # Panics
/// If an index is out of range.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::simplify::paper::quotient;
/// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
/// let between = quotient(&positions, &[[0, 1, 2], [1, 3, 2]], &[0, 2, 1, 1], 3);
/// // The second face lies in two regions only; the first turns against its samples' order.
/// assert_eq!((between.triangles, between.windings), (vec![[0, 1, 2]], vec![-1]));
/// ```
pub fn quotient(positions: &[[f32; 3]], faces: &[[u32; 3]], assignment: &[u32], n_samples: usize) -> Quotient {
    let regions = |face: &[u32; 3]| face.map(|v| assignment[v as usize]);
    let reached = faces.iter().filter(move |face| !regions(face).contains(&NO_SAMPLE));
    let pairs = reached.clone().flat_map(move |face| {
        let [a, b, c] = regions(face);
        [[a, b], [b, c], [c, a]]
    });
    let edges = Csr::from_edges(n_samples, pairs);
    let mut spanned: Vec<([u32; 3], i32)> =
        reached.clone().filter_map(|face| sort_with_winding(regions(face))).collect();
    spanned.sort_unstable();
    let copies = || spanned.chunk_by(|a, b| a.0 == b.0);
    let triangles = copies().map(|copies| copies[0].0).collect();
    let windings = copies().map(|copies| copies.iter().map(|(_, turn)| turn).sum()).collect();
    let mut normals = vec![DVec3::ZERO; n_samples];
    for face in reached {
        let normal = area_normal_f64(face.map(|v| Vec3::from(positions[v as usize]).as_dvec3()));
        regions(face).iter().for_each(|&sample| normals[sample as usize] += normal / 3.0);
    }
    Quotient { edges, triangles, windings, normals }
}

/// Sorts three different corners; also returns 1 if that keeps their winding, else -1.
fn sort_with_winding([a, b, c]: [u32; 3]) -> Option<([u32; 3], i32)> {
    if a == b || b == c || c == a {
        return None;
    }
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    let is_rotation = [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted);
    Some((sorted, if is_rotation { 1 } else { -1 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_every_vertex_a_sample_the_quotient_is_the_mesh() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let all = quotient(&positions, &faces, &[0, 1, 2, 3], 4);
        assert_eq!(all.triangles, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]);
        assert_eq!(all.windings, [-1, 1, -1, 1]);
        assert_eq!(all.edges.n_entries(), 12);
        assert!(all.normals[3].dot(DVec3::ONE) < 0.34 && all.normals.iter().sum::<DVec3>().length() < 1e-12);
    }

    #[test]
    fn opposite_copies_cancel_but_stay_triangles() {
        // Two faces of a thin sheet land on the same three samples from both sides.
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let sheet = quotient(&positions, &[[0, 1, 2], [3, 5, 4]], &[0, 1, 2, 0, 1, 2], 3);
        assert_eq!((sheet.triangles, sheet.windings), (vec![[0, 1, 2]], vec![0]));
    }

    #[test]
    fn faces_without_a_sample_are_left_out() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let nothing = quotient(&positions, &[[0, 1, 2]], &[0, 1, NO_SAMPLE], 2);
        assert!(nothing.triangles.is_empty() && nothing.edges.n_entries() == 0);
    }
}
