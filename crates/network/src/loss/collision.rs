//! Triangles that pass through each other: m_c(t) of Eq. (9).

use super::conflicts::near_pairs;
use super::triangles::corners;
use crate::geometry::crossing::edge_passes_through;
use crate::linalg::Csr;

/// Finds pairs (t, u) of nearby triangles where an edge of t passes through u, by Shewchuk's exact predicates.
///
/// Triangles with a common edge never collide. Contact and coplanar overlap (see [`overlaps`](super::overlaps)) are no
/// collisions. Triangles without area are ignored.
///
/// # Shapes
/// - `neighbours`: n_triangles x n_triangles, nearby triangles
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, loss::collisions};
/// let points = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 1.0, -1.0], [1.0, 1.5, 1.0], [1.5, 1.0, 1.0]];
/// let both = Csr::from_edges(2, [[0, 1]]);
/// assert_eq!(collisions(&points, &[[0, 1, 2], [3, 4, 5]], &both), [[1, 0]]);
/// assert!(collisions(&points, &[[0, 1, 2], [0, 1, 4]], &both).is_empty());
/// ```
pub fn collisions(points: &[[f32; 3]], triangles: &[[u32; 3]], neighbours: &Csr) -> Vec<[u32; 2]> {
    near_pairs(neighbours, |t, u| {
        let [t, u] = [t, u].map(|t| corners(points, triangles[t as usize]));
        boxes_meet(t, u) && edge_passes_through(t, u)
    })
}

fn boxes_meet(t: [[f32; 3]; 3], u: [[f32; 3]; 3]) -> bool {
    let low = |t: [[f32; 3]; 3], axis: usize| t[0][axis].min(t[1][axis]).min(t[2][axis]);
    let high = |t: [[f32; 3]; 3], axis: usize| t[0][axis].max(t[1][axis]).max(t[2][axis]);
    (0..3).all(|axis| low(t, axis) <= high(u, axis) && low(u, axis) <= high(t, axis))
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{points, triangles};
    use super::*;
    use crate::geometry::crossing::triangles_cross;

    fn all_of(n: u32) -> Csr {
        Csr::from_edges(n as usize, (0..n).flat_map(|t| (0..t).map(move |u| [t, u])))
    }

    #[test]
    fn random_triangles_collide_where_they_cross() {
        let points = points(24, 1);
        let triangles = triangles(40, 24, 2);
        let found = collisions(&points, &triangles, &all_of(triangles.len() as u32));
        assert!(found.len() > 20);
        for t in 0..triangles.len() as u32 {
            for u in 0..t {
                let [a, b] = [t, u].map(|t| corners(&points, triangles[t as usize]));
                let collide = found.contains(&[t, u]) || found.contains(&[u, t]);
                assert_eq!(collide, triangles_cross(a, b), "{t} {u}");
            }
        }
    }

    #[test]
    fn neighbours_are_taken_as_what_they_are() {
        let points = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [2.0, 1.0, -1.0], [1.0, 2.0, 1.0], [-1.0, -2.0, 1.0]];
        let collide = |other: [u32; 3]| !collisions(&points, &[[0, 1, 2], other], &all_of(2)).is_empty();
        assert!(collide([0, 3, 4]), "the edge opposite of the common vertex passes through");
        assert!(!collide([0, 3, 5]), "it passes outside");
        assert!(!collide([0, 1, 3]) && !collide([1, 2, 4]), "a common edge");
        assert!(!collide([0, 1, 2]), "the same triangle");
    }

    #[test]
    fn a_folded_strip_far_from_the_origin_has_none() {
        let strip: Vec<[f32; 3]> =
            (0..40).map(|i| [1e4 + (i / 2) as f32 * 0.01, (i % 2) as f32, (i / 2 % 2) as f32]).collect();
        let triangles: Vec<[u32; 3]> = (0..38).map(|i| [i, i + 1, i + 2]).collect();
        assert!(collisions(&strip, &triangles, &all_of(38)).is_empty());
    }
}
