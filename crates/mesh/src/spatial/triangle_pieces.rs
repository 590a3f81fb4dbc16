//! Cuts the boxes of thin triangles (early split clipping, Ernst and Greiner 2007).

use super::Bounds;

const MOST: f32 = 32.0;
/// Longest side of a box below which its triangle is not cut.
const LEAST: f32 = 1.5e-5;
/// Half the area of a box over twice that of its triangle, below which the triangle is not cut, and a little less.
const LEAST_EMPTY: f32 = 60.0;
/// Pieces that any mesh may add; larger meshes may add one per two triangles.
const FREE: usize = 400_000;

/// Number of additional pieces up to which the triangles do not count as thin.
const MANY: f64 = 100_000.0;

pub(super) fn are_needles(wanted_cuts: f64, n_triangles: usize) -> bool {
    wanted_cuts > MANY.max(n_triangles as f64)
}

/// Returns the boxes of all triangles with their indices, several for thin triangles.
pub(super) fn boxes(triangles: &[[[f32; 3]; 3]]) -> Vec<(Bounds, u32)> {
    let wanted: Vec<f32> = triangles.iter().map(wanted_cuts).collect();
    let added: f64 = wanted.iter().map(|&n| f64::from(n)).sum();
    let budget = FREE.max(triangles.len() / 2) as f64;
    let share = (budget / added.max(1.0)).min(1.0) as f32;
    let mut boxes = Vec::with_capacity(triangles.len() + added.min(budget) as usize);
    for ((corners, wanted), triangle) in triangles.iter().zip(wanted).zip(0..) {
        let n = 1 + (wanted * share) as usize;
        boxes.extend(pieces(corners, n).map(|bounds| (bounds, triangle)));
    }
    boxes
}

pub(super) fn wanted_cuts(corners: &[[f32; 3]; 3]) -> f32 {
    wanted_pieces(corners) - 1.0
}

/// Returns how many pieces to cut a triangle into; grows with its box's area relative to its own.
fn wanted_pieces(corners: &[[f32; 3]; 3]) -> f32 {
    let bounds @ Bounds { low, high } = Bounds::from_points(corners);
    if (0..3).all(|axis| high[axis] - low[axis] < LEAST) {
        return 1.0;
    }
    let [a, b, c] = corners.map(glam::Vec3::from_array);
    let (normal, half_area) = ((b - a).cross(c - a), bounds.half_area());
    if half_area * half_area < LEAST_EMPTY * LEAST_EMPTY * normal.length_squared() {
        return 1.0;
    }
    let emptiness = half_area / normal.length();
    // A line along an axis, or a point, has a box without area.
    if emptiness.is_nan() { 1.0 } else { (0.25 * emptiness.sqrt()).floor().clamp(1.0, MOST) }
}

fn pieces(corners: &[[f32; 3]; 3], n: usize) -> impl Iterator<Item = Bounds> {
    let whole = Bounds::from_points(corners);
    let side = move |axis: usize| whole.high[axis] - whole.low[axis];
    let axis = (1..3).fold(0, |best, axis| if side(axis) > side(best) { axis } else { best });
    let cut = move |i: usize| whole.low[axis] + side(axis) * (i as f32 / n as f32);
    let corners = *corners;
    (0..n).map(move |i| if n == 1 { whole } else { slab(&corners, axis, cut(i), cut(i + 1)) })
}

fn slab(corners: &[[f32; 3]; 3], axis: usize, low: f32, high: f32) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let (p, q) = (corners[i], corners[j]);
        let along = q[axis] - p[axis];
        // Parameters of the edge within the slab; all of the edge if it is parallel to the planes.
        let ends = if along == 0.0 { [0.0, 1.0] } else { [low, high].map(|at| (at - p[axis]) / along) };
        let [from, to] = if ends[0] <= ends[1] { ends } else { [ends[1], ends[0]] };
        if to < 0.0 || from > 1.0 || (along == 0.0 && !(low..=high).contains(&p[axis])) {
            continue;
        }
        for t in [from.clamp(0.0, 1.0), to.clamp(0.0, 1.0)] {
            let point = std::array::from_fn(|k| p[k] + t * (q[k] - p[k]));
            bounds = bounds.union(&Bounds { low: point, high: point });
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_together_cover_the_triangle_and_little_else() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.9, 0.2], [0.99, 0.91, 0.2]];
        let boxes: Vec<Bounds> = pieces(&corners, 10).collect();
        for (i, j) in (0..=50).flat_map(|i| (0..=50 - i).map(move |j| (i, j))) {
            let (u, v) = (i as f32 / 50.0, j as f32 / 50.0);
            let p: [f32; 3] = std::array::from_fn(|k| u * corners[1][k] + v * corners[2][k]);
            let near = Bounds { low: p.map(|x| x - 1e-6), high: p.map(|x| x + 1e-6) };
            assert!(boxes.iter().any(|bounds| bounds.overlaps(&near)), "{p:?}");
        }
        let area: f32 = boxes.iter().map(Bounds::half_area).sum();
        assert!(area < 0.15 * Bounds::from_points(&corners).half_area(), "{area}");
    }

    #[test]
    fn only_thin_triangles_are_cut_and_not_without_end() {
        let compact = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(boxes(&[compact]).len(), 1);
        let line = [[0.0; 3], [1.0, 1.0, 1.0], [0.5, 0.5, 0.5]];
        assert_eq!(boxes(&[line]).len(), MOST as usize);
        assert_eq!(boxes(&[[[0.0; 3]; 3]]).len(), 1);
        let many = vec![line; 30_000];
        assert!(boxes(&many).len() <= many.len() + FREE);
    }
}
