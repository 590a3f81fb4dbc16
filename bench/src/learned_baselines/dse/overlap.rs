//! Overlap of two triangles on a surface.

use glam::DVec3;

// Cosine of 30 degrees, the angle at a shared edge below which triangles are folded.
const FOLDED: f64 = 0.866;
// Crossings nearer to an edge's ends than this fraction of its length are touches.
const TOUCH: f64 = 1e-3;

/// Returns whether triangles overlap: folded at a shared edge, or with edges that pass, away from their
/// ends, closer than `within`.
pub fn are_overlapping(points: &[[f32; 3]], [a, b]: [[u32; 3]; 2], within: f64) -> bool {
    let at = |v: u32| glam::Vec3::from(points[v as usize]).as_dvec3();
    let shared: Vec<u32> = a.into_iter().filter(|v| b.contains(v)).collect();
    if let [from, to] = shared[..] {
        let opposite = |corners: [u32; 3]| corners.into_iter().find(|v| !shared.contains(v));
        let [Some(p), Some(q)] = [a, b].map(opposite) else { return false };
        if is_folded([at(from), at(to)], [at(p), at(q)]) {
            return true;
        }
    }
    let edges = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    let apart = |e: [u32; 2], f: [u32; 2]| !e.iter().any(|v| f.contains(v));
    let pairs = edges(a).into_iter().flat_map(|e| edges(b).into_iter().map(move |f| (e, f)));
    pairs.filter(|&(e, f)| apart(e, f)).any(|(e, f)| segments_cross(e.map(at), f.map(at), within))
}

fn is_folded([from, to]: [DVec3; 2], tips: [DVec3; 2]) -> bool {
    let along = (to - from).normalize_or_zero();
    let [p, q] = tips.map(|tip| (tip - from) - along * along.dot(tip - from));
    p.dot(q) > FOLDED * p.length() * q.length()
}

fn segments_cross([a, b]: [DVec3; 2], [c, d]: [DVec3; 2], within: f64) -> bool {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let determinant = uu * vv - uv * uv;
    // Parallel segments do not cross.
    if determinant <= 1e-12 * uu * vv {
        return false;
    }
    let s = (uv * v.dot(w) - vv * u.dot(w)) / determinant;
    let t = (uu * v.dot(w) - uv * u.dot(w)) / determinant;
    let inside = |x: f64| (TOUCH..1.0 - TOUCH).contains(&x);
    inside(s) && inside(t) && (w + u * s - v * t).length() < within
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagonals_of_a_square_overlap() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(!are_overlapping(&points, [[0, 1, 2], [0, 2, 3]], 0.1));
        assert!(are_overlapping(&points, [[0, 1, 2], [0, 1, 3]], 0.1));
    }

    #[test]
    fn crossings_count_near_the_plane_alone() {
        let corners =
            |z: f32| [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.5, z], [3.0, 0.6, z], [3.0, 3.0, z]];
        assert!(are_overlapping(&corners(0.01), [[0, 1, 2], [3, 4, 5]], 0.1));
        assert!(!are_overlapping(&corners(0.5), [[0, 1, 2], [3, 4, 5]], 0.1));
    }

    #[test]
    fn neighbours_around_a_vertex_do_not() {
        let mesh = neural_mesh::mesh::shapes::icosphere(1);
        for a in mesh.faces() {
            let others = mesh.faces().iter().filter(|b| *b != a);
            assert!(others.into_iter().all(|b| !are_overlapping(mesh.positions(), [*a, *b], 0.1)));
        }
    }
}
