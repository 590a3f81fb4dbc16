//! The watertightness loss.

use neural_mesh::loss::Term;

/// Computes the expected share of open sides, each triangle kept with its probability.
///
/// # Shapes
/// - `triangles`: n x 3, distinct; `probabilities`: n
/// - returns a fraction in 0..=1 and its gradient by the probabilities
pub fn watertightness(triangles: &[[u32; 3]], probabilities: &[f32]) -> Term {
    let p = |t: u32| f64::from(probabilities[t as usize]);
    // The share is `1 - 2 sum over edges of P_e(2) / sum over sides of p`, with the probability P_e(2) of exactly two
    // triangles at an edge.
    let mut closed = 0.0;
    let mut to_closed = vec![0.0f64; probabilities.len()];
    for edge in sides(triangles).chunk_by(|a, b| a.0 == b.0) {
        let of_edge: Vec<f64> = edge.iter().map(|&(_, t)| p(t)).collect();
        let (exactly_two, slopes) = exactly_two(&of_edge);
        closed += 2.0 * exactly_two;
        edge.iter().zip(slopes).for_each(|((_, t), slope)| to_closed[*t as usize] += 2.0 * slope);
    }
    let n_sides = 3.0 * probabilities.iter().map(|&p| f64::from(p)).sum::<f64>();
    let scale = n_sides + LEAST;
    let value = (n_sides - closed) / scale;
    // Each probability counts at three sides.
    let slope = |to_closed: &f64| ((3.0 - to_closed - 3.0 * value) / scale) as f32;
    Term { value, gradient: to_closed.iter().map(slope).collect() }
}

// Number added to that of the sides, which may be 0.
const LEAST: f64 = 1e-4;

fn sides(triangles: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let of_triangle =
        |(&[a, b, c], t): (&[u32; 3], u32)| [[a, b], [b, c], [c, a]].map(|[v, w]| ([v.min(w), v.max(w)], t));
    let mut sides: Vec<([u32; 2], u32)> = triangles.iter().zip(0..).flat_map(of_triangle).collect();
    sides.sort_unstable();
    sides
}

fn exactly_two(p: &[f64]) -> (f64, Vec<f64>) {
    let mut before = vec![[1.0, 0.0, 0.0]];
    for (i, &p) in p.iter().enumerate() {
        before.push(add_one(before[i], p));
    }
    let mut after = [1.0, 0.0, 0.0];
    let mut slopes = vec![0.0; p.len()];
    // The other triangles at the edge are those before and those after triangle i.
    for (i, &p) in p.iter().enumerate().rev() {
        let ([none, one, two], [no, once, twice]) = (before[i], after);
        let others = [none * once + one * no, none * twice + one * once + two * no];
        slopes[i] = others[0] - others[1];
        after = add_one(after, p);
    }
    (before[p.len()][2], slopes)
}

fn add_one([none, one, two]: [f64; 3], p: f64) -> [f64; 3] {
    let q = 1.0 - p;
    // The entries are the probabilities that none, one and two of the triangles are kept.
    [none * q, one * q + none * p, two * q + one * p]
}

#[cfg(test)]
mod tests {
    use super::super::test_golden::{assert_gradient, probabilities, triangles};
    use super::*;

    fn by_subsets(triangles: &[[u32; 3]], p: &[f32]) -> f64 {
        let n = p.len();
        let (mut open, mut all) = (0.0, 0.0);
        for kept in 0..1u32 << n {
            let is_kept = |t: usize| kept >> t & 1 == 1;
            let chance: f64 = (0..n).map(|t| f64::from(if is_kept(t) { p[t] } else { 1.0 - p[t] })).product();
            let of_kept: Vec<[u32; 2]> =
                sides(triangles).into_iter().filter(|&(_, t)| is_kept(t as usize)).map(|(edge, _)| edge).collect();
            let is_open = |edge: &&[u32; 2]| of_kept.iter().filter(|other| other == edge).count() != 2;
            open += chance * of_kept.iter().filter(is_open).count() as f64;
            all += chance * of_kept.len() as f64;
        }
        open / (all + LEAST)
    }

    #[test]
    fn agrees_with_all_subsets_with_numpy_and_with_differences() {
        let (triangles, p) = (triangles(), probabilities());
        let few = watertightness(&triangles[..7], &p[..7]).value;
        assert!((few - by_subsets(&triangles[..7], &p[..7])).abs() < 1e-9, "{few}");
        let value = watertightness(&triangles, &p).value;
        assert!((value - 0.5341461360967679).abs() < 1e-5, "{value}");
        assert_gradient(&p, |p| watertightness(&triangles, p));
    }

    #[test]
    fn nothing_is_fine_and_sure_ones_have_slopes() {
        assert_eq!(watertightness(&[], &[]).value, 0.0);
        assert_eq!(watertightness(&[[0, 1, 2]], &[0.0]).value, 0.0);
        let tetrahedron = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        assert!(watertightness(&tetrahedron, &[1.0, 1.0, 1.0, 0.0]).gradient[3] < 0.0, "the hole wants its face");
    }
}
