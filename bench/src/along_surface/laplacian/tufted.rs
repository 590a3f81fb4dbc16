//! The tufted cover: two copies of each face, every side with one neighbour (Sharp and Crane 2020, Sec. 3).

use glam::DVec3;

use super::glued_triangles::GluedTriangles;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::half_edges::{HalfEdge, for_each_edge, next, start};

pub fn tufted_cover(mesh: &TriMesh) -> GluedTriangles {
    // Copy `2 face` is the face as given, copy `2 face + 1` its reverse.
    let n_half_edges = 6 * mesh.faces().len();
    let mut cover =
        GluedTriangles { start: starts(mesh), twin: vec![0; n_half_edges], length: vec![0.0; n_half_edges] };
    for_each_edge(mesh.positions().len(), mesh.faces(), |ends, half_edges| {
        let [from, to] = ends.map(|end| point(mesh, end));
        let length = from.distance(to);
        let order = sort_by_angle(mesh, [from, to], half_edges);
        // Around the edge, facing copies of consecutive faces are glued; at a boundary both copies of the only face.
        for (at, &side) in order.iter().enumerate() {
            let next = order[(at + 1) % order.len()];
            let here = half_edge_of_copy(side.half_edge, side.runs_up(mesh.faces()));
            let there = half_edge_of_copy(next.half_edge, !next.runs_up(mesh.faces()));
            (cover.twin[here], cover.twin[there]) = (there as u32, here as u32);
            (cover.length[here], cover.length[there]) = (length, length);
        }
    });
    cover
}

fn starts(mesh: &TriMesh) -> Vec<u32> {
    mesh.faces().iter().flat_map(|&[a, b, c]| [a, b, c, a, c, b]).collect()
}

fn half_edge_of_copy(half_edge: u32, as_it_is: bool) -> usize {
    let (face, side) = (half_edge as usize / 3, half_edge as usize % 3);
    6 * face + if as_it_is { side } else { 5 - side }
}

fn sort_by_angle(mesh: &TriMesh, [from, to]: [DVec3; 2], around: &[HalfEdge]) -> Vec<HalfEdge> {
    let mut order = around.to_vec();
    if order.len() > 2 {
        let axis = (to - from).normalize_or_zero();
        let x = axis.any_orthogonal_vector().normalize_or_zero();
        let y = axis.cross(x);
        let angle = |side: &HalfEdge| {
            let away = point(mesh, start(mesh.faces(), next(next(side.half_edge)))) - from;
            away.dot(y).atan2(away.dot(x))
        };
        order.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    }
    order
}

fn point(mesh: &TriMesh, vertex: u32) -> DVec3 {
    DVec3::from_array(mesh.positions()[vertex as usize].map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    // Every side has one neighbour with the same ends in opposite direction.
    fn check(mesh: &TriMesh) {
        let cover = tufted_cover(mesh);
        for (here, &there) in cover.twin.iter().enumerate() {
            let [a, b] = cover.ends(there as usize);
            assert_eq!((cover.twin[there as usize] as usize, cover.ends(here)), (here, [b, a]));
            assert!(here != there as usize && cover.length[here] == cover.length[there as usize]);
        }
    }

    #[test]
    fn whatever_the_mesh_its_cover_is_closed_and_oriented() {
        check(&shapes::icosphere(1));
        check(&shapes::grid(3, 2));
        check(&shapes::moebius_strip(12, 2));
        check(&shapes::klein_bottle(12, 8));
        check(&shapes::tetrahedra_sharing_edge());
        check(&shapes::tetrahedra_sharing_vertex());
        check(&TriMesh::default());
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        check(&TriMesh::new(positions, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 1, 2]]).unwrap());
    }

    #[test]
    fn a_closed_surface_is_covered_once_on_each_side() {
        let cover = tufted_cover(&shapes::icosphere(1));
        let copy = |half_edge: usize| half_edge / 3 % 2;
        assert!((0..cover.twin.len()).all(|half_edge| copy(half_edge) == copy(cover.twin[half_edge] as usize)));
    }

    // Four faces meet at an edge like the arms of a cross; each is glued to the next one.
    #[test]
    fn around_an_edge_of_many_faces_neighbours_are_glued() {
        let arms = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].map(|[x, y]| [x, y, 0.0]);
        let positions = [[0.0; 3], [0.0, 0.0, 1.0]].into_iter().chain(arms).collect();
        let mesh = TriMesh::new(positions, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 5]]).unwrap();
        let cover = tufted_cover(&mesh);
        let face_beside = |face: usize| cover.twin[6 * face] as usize / 6;
        assert_eq!([0, 1, 2, 3].map(face_beside), [2, 3, 1, 0]);
    }
}
