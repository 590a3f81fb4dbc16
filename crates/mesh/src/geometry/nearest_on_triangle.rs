//! The closest point on one triangle in double precision.

use std::ops::Div;

use glam::DVec3;

/// The body of a function of a point and a triangle that returns the weights of the closest point, in their precision.
///
/// After Ericson, "Real-Time Collision Detection", Sec. 5.1.5. `ratio` divides on an edge, `share` on the inside.
macro_rules! nearest_weights_by {
    ($p:ident, $corners:ident, $ratio:path, $share:path) => {{
        let [a, b, c] = $corners;
        let (ab, ac, ap) = (b - a, c - a, $p - a);
        let (d1, d2) = (ab.dot(ap), ac.dot(ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return [1.0, 0.0, 0.0];
        }
        let bp = $p - b;
        let (d3, d4) = (ab.dot(bp), ac.dot(bp));
        if d3 >= 0.0 && d4 <= d3 {
            return [0.0, 1.0, 0.0];
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            let t = $ratio(d1, d1 - d3);
            return [1.0 - t, t, 0.0];
        }
        let cp = $p - c;
        let (d5, d6) = (ab.dot(cp), ac.dot(cp));
        if d6 >= 0.0 && d5 <= d6 {
            return [0.0, 0.0, 1.0];
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            let t = $ratio(d2, d2 - d6);
            return [1.0 - t, 0.0, t];
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            let t = $ratio(d4 - d3, (d4 - d3) + (d5 - d6));
            return [0.0, 1.0 - t, t];
        }
        let (v, w) = ($share(vb, va + vb + vc), $share(vc, va + vb + vc));
        [1.0 - v - w, v, w]
    }};
}
pub(super) use nearest_weights_by;

/// Returns barycentric weights of the point of triangle `a b c` closest to `p`.
///
/// Degenerate triangles count as their edges.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::nearest_on_triangle::nearest_weights_f64;
/// let line = [[0.0; 3], [0.0; 3], [2.0, 0.0, 0.0]].map(Into::into);
/// assert_eq!(nearest_weights_f64([1.0, 3.0, 0.0].into(), line)[2], 0.5);
/// ```
pub fn nearest_weights_f64(p: DVec3, corners: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (corners[1] - corners[0], corners[2] - corners[0]);
    if ab.cross(ac).length_squared() <= 1e-10 * ab.length_squared() * ac.length_squared() {
        return nearest_on_edges(p, corners);
    }
    nearest_weights_by!(p, corners, f64::div, times_inverse)
}

fn times_inverse(part: f64, whole: f64) -> f64 {
    part * (1.0 / whole)
}

fn nearest_on_edges(p: DVec3, corners: [DVec3; 3]) -> [f64; 3] {
    let on_edge = |i: usize, j: usize| {
        let edge = corners[j] - corners[i];
        let length2 = edge.length_squared();
        let t = if length2 > 0.0 { (edge.dot(p - corners[i]) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = [0.0; 3];
        weights[i] = 1.0 - t;
        weights[j] = t;
        (p.distance_squared(corners[i] + edge * t), weights)
    };
    let (ab, bc, ca) = (on_edge(0, 1), on_edge(1, 2), on_edge(2, 0));
    let nearer = |x: (f64, [f64; 3]), y: (f64, [f64; 3])| if y.0 < x.0 { y } else { x };
    nearer(nearer(ab, bc), ca).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    fn naive(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
        let n = 200;
        let points = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
        points
            .map(|(i, j)| {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                p.distance(a * (1.0 - u - v) + b * u + c * v)
            })
            .fold(f64::INFINITY, f64::min)
    }

    fn check(p: DVec3, corners: [DVec3; 3]) {
        let w = nearest_weights_f64(p, corners);
        assert!(w.iter().all(|&w| (-1e-12..=1.0 + 1e-12).contains(&w)), "{w:?}");
        let d = p.distance(corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]);
        let grid = naive(p, corners);
        let size = corners[0].distance(corners[1]) + corners[0].distance(corners[2]);
        assert!(d <= grid + 1e-9 && grid <= d + 0.02 * size, "{p} {corners:?}: {d} against {grid}");
    }

    #[test]
    fn agrees_with_a_dense_grid_also_on_slivers_lines_and_points() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut unit = || f64::from(rng.next_u32()) / f64::from(u32::MAX);
        let mut point = || DVec3::new(unit(), unit(), unit());
        for _ in 0..40 {
            let (p, a, b, c) = (point() * 2.0, point(), point(), point());
            check(p, [a, b, c]);
            check(p, [a, b, a.lerp(b, 0.3)]);
            check(p, [a, b, a.lerp(b, 1.3) + c * 1e-9]);
            check(p, [a, a, b]);
            check(p, [a, a, a]);
        }
    }
}
