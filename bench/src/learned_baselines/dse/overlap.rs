//! Whether two triangles lie over each other, as two attempts at the same piece of a surface do.

use glam::DVec3;

/// Triangles that share an edge are folded onto each other below this angle between them, 30 degrees, given by its cosine.
const FOLDED: f64 = 0.866;
/// Crossings nearer to the ends of an edge than this share of its length are touches.
const TOUCH: f64 = 1e-3;

/// Whether triangles lie over each other: folded at an edge that they share, or with edges that cross, or pass each other
/// within a distance, away from their ends.
///
/// ```
/// use neural_mesh_bench::learned_baselines::dse::lie_over_each_other;
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// assert!(!lie_over_each_other(&points, [[0, 1, 2], [0, 2, 3]], 0.1));
/// assert!(lie_over_each_other(&points, [[0, 1, 2], [0, 1, 3]], 0.1));
/// ```
pub fn lie_over_each_other(points: &[[f32; 3]], [a, b]: [[u32; 3]; 2], within: f64) -> bool {
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
    pairs.filter(|&(e, f)| apart(e, f)).any(|(e, f)| cross(e.map(at), f.map(at), within))
}

/// Whether the tips of two triangles on an edge lie in nearly the same direction from it.
fn is_folded([from, to]: [DVec3; 2], tips: [DVec3; 2]) -> bool {
    let along = (to - from).normalize_or_zero();
    let [p, q] = tips.map(|tip| (tip - from) - along * along.dot(tip - from));
    p.dot(q) > FOLDED * p.length() * q.length()
}

/// Whether two segments come within a distance at places away from their ends.
fn cross([a, b]: [DVec3; 2], [c, d]: [DVec3; 2], within: f64) -> bool {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let determinant = uu * vv - uv * uv;
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
    fn crossings_count_near_the_plane_alone() {
        let corners =
            |z: f32| [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.5, z], [3.0, 0.6, z], [3.0, 3.0, z]];
        assert!(lie_over_each_other(&corners(0.01), [[0, 1, 2], [3, 4, 5]], 0.1));
        assert!(!lie_over_each_other(&corners(0.5), [[0, 1, 2], [3, 4, 5]], 0.1));
    }

    #[test]
    fn neighbours_around_a_vertex_do_not() {
        let mesh = neural_mesh::mesh::shapes::icosphere(1);
        for a in mesh.faces() {
            let others = mesh.faces().iter().filter(|b| *b != a);
            assert!(others.into_iter().all(|b| !lie_over_each_other(mesh.positions(), [*a, *b], 0.1)));
        }
    }
}
