//! Crossing edges of nearby triangles (Sec. 3.4), which collisions miss on nearly flat surfaces.

use super::conflicts::near_pairs;
use super::triangles::corners_f64;
use crate::linalg::Csr;
use glam::DVec3;

/// Finds pairs (t, u) of nearby triangles whose edges cross, in both orders.
///
/// Two edges without a common vertex cross if, projected along their common normal, they meet inside both, at a distance of
/// at most `flatness` times the shorter edge.
///
/// # Shapes
/// - `neighbours`: n_triangles x n_triangles, nearby triangles
/// - `flatness`: 0 or more
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, loss::edge_crossings};
/// let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.05]];
/// let both = Csr::from_edges(2, [[0, 1]]);
/// assert_eq!(edge_crossings(&square, &[[0, 1, 2], [0, 1, 3]], &both, 0.1), [[0, 1], [1, 0]]);
/// assert!(edge_crossings(&square, &[[0, 1, 2], [0, 2, 3]], &both, 0.1).is_empty());
/// ```
pub fn edge_crossings(points: &[[f32; 3]], triangles: &[[u32; 3]], neighbours: &Csr, flatness: f64) -> Vec<[u32; 2]> {
    near_pairs(neighbours, |t, u| {
        let [t, u] = [t, u].map(|t| edges(points, triangles[t as usize]));
        t.iter().any(|(e, ends)| {
            u.iter().any(|(f, others)| !e.iter().any(|v| f.contains(v)) && segments_cross(*ends, *others, flatness))
        })
    })
}

fn edges(points: &[[f32; 3]], triangle: [u32; 3]) -> [([u32; 2], [DVec3; 2]); 3] {
    let corners = corners_f64(points, triangle);
    [[0, 1], [1, 2], [2, 0]].map(|ends| (ends.map(|i| triangle[i]), ends.map(|i| corners[i])))
}

/// Share of an edge's length at each end within which a meeting edge touches it instead of crossing.
const END: f64 = 1e-6;

fn segments_cross([a, b]: [DVec3; 2], [c, d]: [DVec3; 2], flatness: f64) -> bool {
    let (along, across, between) = (b - a, d - c, c - a);
    let normal = along.cross(across);
    let area2 = normal.length_squared();
    let shorter2 = along.length_squared().min(across.length_squared());
    if area2 <= 1e-12 * along.length_squared() * across.length_squared() {
        return false;
    }
    let is_inside = |x: f64| x > END && x < 1.0 - END;
    is_inside(between.cross(across).dot(normal) / area2)
        && is_inside(between.cross(along).dot(normal) / area2)
        && between.dot(normal).powi(2) <= flatness * flatness * shorter2 * area2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(a: [f64; 3], b: [f64; 3]) -> [DVec3; 2] {
        [a.into(), b.into()]
    }

    #[test]
    fn segments_cross_inside_of_both_and_near_each_other() {
        let x = segment([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        let upright = |x: f64, low: f64, z: f64| segment([x, low, z], [x, low + 4.0, z]);
        assert!(segments_cross(x, upright(0.5, -1.0, 0.0), 0.0));
        assert!(segments_cross(x, upright(0.5, -1.0, 0.19), 0.1), "0.1 of the shorter, which is 2 long");
        assert!(!segments_cross(x, upright(0.5, -1.0, 0.21), 0.1));
        assert!(!segments_cross(x, upright(1.5, -1.0, 0.0), 0.1), "beyond the end");
        assert!(!segments_cross(x, upright(0.5, 0.0, 0.0), 0.1), "contact");
        assert!(!segments_cross(x, segment([0.0, 0.0, 0.0], [3.0, 0.0, 0.0]), 0.1), "in line");
        assert!(!segments_cross(x, segment([0.0; 3], [0.0; 3]), 0.1), "a point");
    }

    #[test]
    fn a_flat_fan_has_none_and_one_more_spoke_crosses() {
        let ring = (0..6).map(|i| f32::to_radians(60.0 * i as f32)).map(|a| [a.cos(), a.sin(), 0.0]);
        let points: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain(ring).collect();
        let fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6], [0, 1, 6]];
        let all = |n: u32| Csr::from_edges(n as usize, (0..n).flat_map(|t| (0..t).map(move |u| [t, u])));
        assert!(edge_crossings(&points, &fan, &all(6), 0.1).is_empty());
        let mut more = fan.to_vec();
        more.push([1, 2, 3]);
        // The long side of the new triangle crosses the spoke to 2, which two faces of the fan share.
        assert_eq!(edge_crossings(&points, &more, &all(7), 0.1), [[0, 6], [1, 6], [6, 0], [6, 1]]);
    }

    #[test]
    fn nothing_is_fine() {
        assert!(edge_crossings(&[], &[], &Csr::from_edges(0, []), 0.1).is_empty());
    }
}
