//! Edges without exactly two faces, among them the paper's WA (Sec. 4.1).

use glam::DVec3;

use crate::mesh::{Edge, TriMesh, edges};
use crate::parallel;
use crate::spatial::NearestOnTriangles;

/// Distance from the original's boundary up to which an edge is on it, in edge lengths and mean edge lengths.
const REACH: f64 = 1.0;
/// Edges that a thread takes at least.
const LEAST: usize = 64;

/// Counts of the edges of a simplified mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct OpenEdges {
    /// All edges.
    pub edges: usize,
    /// Edges with one, three or more faces.
    pub without_two_faces: usize,
    /// Edges without two faces that are not on a boundary of the original.
    pub open: usize,
}

impl OpenEdges {
    /// Returns the paper's WA: the percentage of edges without two faces.
    pub fn wa_percent(&self) -> f64 {
        self.percent(self.without_two_faces)
    }

    /// Returns the percentage of [`open`](Self::open) edges.
    pub fn open_percent(&self) -> f64 {
        self.percent(self.open)
    }

    fn percent(&self, count: usize) -> f64 {
        100.0 * count as f64 / self.edges.max(1) as f64
    }
}

/// Counts the edges of `simplified` without two faces, and those away from the boundary of `original`.
///
/// An edge with one face is on the boundary if its ends and midpoint are no farther from the boundary edges of
/// `original` than its own length, nor than the mean edge length of `simplified`. Edges with more faces never are.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, metrics::open_edges};
/// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let tetrahedron = TriMesh::new(corners.clone(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
/// let opened = TriMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]]).unwrap();
/// let edges = open_edges(&tetrahedron, &opened);
/// assert_eq!((edges.edges, edges.without_two_faces, edges.open), (6, 3, 3));
/// assert_eq!((edges.wa_percent(), open_edges(&opened, &opened).open_percent()), (50.0, 0.0));
/// ```
pub fn open_edges(original: &TriMesh, simplified: &TriMesh) -> OpenEdges {
    let edges = edges(simplified);
    let boundary = boundary_tree(original);
    let mean = edges.iter().map(|edge| length(simplified, edge)).sum::<f64>() / edges.len().max(1) as f64;
    let irregular: Vec<&Edge> = edges.iter().filter(|edge| edge.n_faces() != 2).collect();
    let is_open = |i: usize| {
        let edge = irregular[i];
        let reach = REACH * length(simplified, edge).min(mean);
        edge.n_faces() != 1 || !is_on_boundary(&boundary, ends(simplified, edge), reach)
    };
    let open = parallel::map(irregular.len(), LEAST, is_open).into_iter().filter(|&is_open| is_open).count();
    OpenEdges { edges: edges.len(), without_two_faces: irregular.len(), open }
}

fn boundary_tree(mesh: &TriMesh) -> NearestOnTriangles {
    let boundary = edges(mesh).into_iter().filter(|edge| edge.n_faces() == 1);
    let corners: Vec<[[f32; 3]; 3]> =
        boundary.map(|Edge { ends: [a, b], .. }| [a, b, b].map(|v| mesh.positions()[v as usize])).collect();
    NearestOnTriangles::new(&corners)
}

fn ends(mesh: &TriMesh, edge: &Edge) -> [DVec3; 2] {
    edge.ends.map(|v| DVec3::from_array(mesh.positions()[v as usize].map(f64::from)))
}

fn length(mesh: &TriMesh, edge: &Edge) -> f64 {
    let [a, b] = ends(mesh, edge);
    a.distance(b)
}

fn is_on_boundary(boundary: &NearestOnTriangles, [a, b]: [DVec3; 2], reach: f64) -> bool {
    let is_near = |p: DVec3| boundary.is_within_distance(p, reach, |_| true);
    is_near(a) && is_near(b) && is_near(a.midpoint(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};

    fn remove_faces(mesh: &TriMesh, removed: &[usize]) -> TriMesh {
        let kept = (0..mesh.faces().len()).filter(|face| !removed.contains(face)).map(|face| mesh.faces()[face]);
        TriMesh::new(mesh.positions().to_vec(), kept.collect()).unwrap()
    }

    #[test]
    fn a_closed_result_of_a_closed_mesh_has_none() {
        let edges = open_edges(&shapes::icosphere(3), &shapes::icosphere(1));
        assert_eq!(edges, OpenEdges { edges: 120, without_two_faces: 0, open: 0 });
    }

    #[test]
    fn every_missing_face_of_a_closed_mesh_opens_three_edges() {
        let sphere = shapes::icosphere(2);
        let apart: Vec<usize> = (0..sphere.faces().len()).step_by(40).collect();
        let edges = open_edges(&sphere, &remove_faces(&sphere, &apart));
        assert_eq!((edges.without_two_faces, edges.open), (3 * apart.len(), 3 * apart.len()));
        assert!((edges.open_percent() - 100.0 * 3.0 * 8.0 / 480.0).abs() < 1e-12);
    }

    #[test]
    fn boundaries_of_the_input_are_forgiven_and_holes_away_from_them_not() {
        let sphere = shapes::icosphere(4);
        let cap = |mesh: &TriMesh| {
            let above = |face: &[u32; 3]| face.iter().all(|&v| mesh.positions()[v as usize][2] > 0.8);
            let removed: Vec<usize> = (0..mesh.faces().len()).filter(|&face| above(&mesh.faces()[face])).collect();
            remove_faces(mesh, &removed)
        };
        let original = cap(&sphere);
        let coarse = cap(&shapes::icosphere(2));
        let edges = open_edges(&original, &coarse);
        assert_eq!((edges.without_two_faces, edges.open), (topology(&coarse).boundary_edges, 0));
        let low = coarse.faces().iter().position(|face| coarse.positions()[face[0] as usize][2] < -0.5).unwrap();
        let holed = open_edges(&original, &remove_faces(&coarse, &[low]));
        assert_eq!(holed.open, 3);
    }

    #[test]
    fn edges_with_three_faces_never_lie_on_a_boundary() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        let fan = TriMesh::new(positions, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]).unwrap();
        assert_eq!(open_edges(&fan, &fan), OpenEdges { edges: 7, without_two_faces: 7, open: 1 });
    }

    #[test]
    fn long_edges_hide_no_holes_far_from_the_boundary() {
        let fine = shapes::cuboid([1.0; 3], 16);
        let top = |mesh: &TriMesh| {
            let is_up = |face: &[u32; 3]| face.iter().all(|&v| mesh.positions()[v as usize][2] > 0.999 * highest(mesh));
            let removed: Vec<usize> = (0..mesh.faces().len()).filter(|&face| is_up(&mesh.faces()[face])).collect();
            remove_faces(mesh, &removed)
        };
        let open_box = top(&fine);
        // One long face per half side of the pillar; small faces shorten the mean edge.
        let mut positions = open_box.positions().to_vec();
        let mut faces = open_box.faces().to_vec();
        let n = positions.len() as u32;
        let above = highest(&open_box);
        positions.extend([[0.0, 0.0, above - 0.9], [0.9, 0.0, above - 0.9], [0.5, 0.01, above - 0.9]]);
        faces.push([n, n + 1, n + 2]);
        let result = TriMesh::new(positions, faces).unwrap();
        let edges = open_edges(&open_box, &result);
        assert_eq!(edges.without_two_faces - edges.open, topology(&open_box).boundary_edges);
        assert_eq!(edges.open, 3);
    }

    fn highest(mesh: &TriMesh) -> f32 {
        mesh.positions().iter().map(|p| p[2]).fold(f32::MIN, f32::max)
    }
}
