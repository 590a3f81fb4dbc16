//! Intrinsic Delaunay triangulation by edge flips (Bobenko and Springborn 2007).

use std::collections::VecDeque;

use super::glued_triangles::{GluedTriangles, next};
use neural_mesh::geometry::side_lengths::{area, opposite_cotangent};

// An edge is flipped if its opposite cotangents sum to less than this, not less than 0: rounding could else flip
// endlessly.
const SLACK: f64 = -1e-8;
// Largest number of flips per half-edge; a few tenths are usual.
const MOST_FLIPS: usize = 50;

pub fn flip_to_delaunay(surface: &mut GluedTriangles) {
    let n = surface.twin.len();
    let first_of_edge = |&half_edge: &usize| half_edge < surface.twin[half_edge] as usize;
    let mut queue: VecDeque<usize> = (0..n).filter(first_of_edge).collect();
    let mut flips_left = MOST_FLIPS * n;
    while let Some(half_edge) = queue.pop_front() {
        if flips_left > 0 && !is_delaunay(surface, half_edge) && flip(surface, half_edge) {
            let twin = surface.twin[half_edge] as usize;
            queue.extend([next(half_edge), next(next(half_edge)), next(twin), next(next(twin))]);
            flips_left -= 1;
        }
    }
}

fn is_delaunay(surface: &GluedTriangles, half_edge: usize) -> bool {
    let twin = surface.twin[half_edge] as usize;
    opposite_cotangent(surface.sides(half_edge)) + opposite_cotangent(surface.sides(twin)) >= SLACK
}

fn flip(surface: &mut GluedTriangles, half_edge: usize) -> bool {
    let twin = surface.twin[half_edge] as usize;
    let length = other_diagonal(surface.sides(half_edge), surface.sides(twin));
    let (ahead, behind) = (next(half_edge), next(next(half_edge)));
    let (twin_ahead, twin_behind) = (next(twin), next(next(twin)));
    let sides_of = |first: usize, second: usize| [length, surface.length[first], surface.length[second]];
    let makes_triangles = area(sides_of(twin_behind, ahead)) > 0.0 && area(sides_of(behind, twin_ahead)) > 0.0;
    // An edge stays if both its sides are of one face, or if a new face would have no area.
    if half_edge / 3 == twin / 3 || !makes_triangles {
        return false;
    }
    let [above, below] = [surface.start[behind], surface.start[twin_behind]];
    move_half_edges(surface, [ahead, behind, twin_ahead, twin_behind], [behind, twin_ahead, twin_behind, ahead]);
    (surface.start[half_edge], surface.start[twin]) = (above, below);
    (surface.length[half_edge], surface.length[twin]) = (length, length);
    true
}

fn other_diagonal([a, b, c]: [f64; 3], [_, d, e]: [f64; 3]) -> f64 {
    // Both triangles are laid flat with the common side a along x; its start, where the sides c and d meet, is the
    // origin.
    let (above_x, above_y) = ((a * a + c * c - b * b) / (2.0 * a), 2.0 * area([a, b, c]) / a);
    let (below_x, below_y) = ((a * a + d * d - e * e) / (2.0 * a), 2.0 * area([a, d, e]) / a);
    (above_x - below_x).hypot(above_y + below_y)
}

fn move_half_edges(surface: &mut GluedTriangles, from: [usize; 4], to: [usize; 4]) {
    let place = |half_edge: usize| from.iter().position(|&old| old == half_edge).map_or(half_edge, |at| to[at]);
    let twins = from.map(|old| place(surface.twin[old] as usize));
    let (starts, lengths) = (from.map(|old| surface.start[old]), from.map(|old| surface.length[old]));
    for i in 0..4 {
        (surface.start[to[i]], surface.length[to[i]]) = (starts[i], lengths[i]);
        surface.twin[to[i]] = twins[i] as u32;
        surface.twin[twins[i]] = to[i] as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tufted::tufted_cover;
    use super::*;
    use neural_mesh::mesh::{TriMesh, shapes};

    fn check(mesh: &TriMesh) {
        let mut surface = tufted_cover(mesh);
        surface.mollify(1e-5);
        let total =
            |surface: &GluedTriangles| (0..surface.twin.len() / 3).map(|f| area(surface.sides(3 * f))).sum::<f64>();
        let before = total(&surface);
        flip_to_delaunay(&mut surface);
        assert!((total(&surface) - before).abs() < 1e-9 * before, "{before} {}", total(&surface));
        for half_edge in 0..surface.twin.len() {
            let twin = surface.twin[half_edge] as usize;
            let [a, b] = surface.ends(twin);
            assert_eq!((surface.twin[twin] as usize, surface.ends(half_edge)), (half_edge, [b, a]));
            assert_eq!(surface.length[half_edge], surface.length[twin]);
            assert!(is_delaunay(&surface, half_edge));
        }
    }

    #[test]
    fn afterwards_all_edges_are_delaunay_and_the_area_is_the_same() {
        check(&shapes::plate(12, 0.01));
        check(&shapes::bolt(24));
        check(&shapes::klein_bottle(12, 8));
        check(&shapes::tetrahedra_sharing_edge());
        check(&shapes::wavy_sphere(3, 20.0));
    }

    #[test]
    fn a_kite_gets_its_short_diagonal() {
        let positions = vec![[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
        let mut surface = tufted_cover(&TriMesh::new(positions, vec![[0, 1, 2], [1, 0, 3]]).unwrap());
        flip_to_delaunay(&mut surface);
        assert!(surface.length.iter().all(|&length| length < 5.0));
        assert!(surface.length.iter().any(|&length| (length - 2.0).abs() < 1e-12));
    }
}
