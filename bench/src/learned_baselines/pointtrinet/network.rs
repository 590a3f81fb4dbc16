//! Shapes of the tensors of both networks, as rows of layers.
//!
//! The classifier has layers of nearby points and of nearby triangles, each before a maximum, and of both maxima. The
//! proposal network has layers of nearby points before a maximum, and of a point joined with the maximum.

use crate::learned_baselines::scale_width;
use neural_mesh::autodiff::Tensors;

/// Number of features of a point.
pub const POINT_NUMBERS: usize = 6;
/// Number of features of a triangle.
pub const TRIANGLE_NUMBERS: usize = 13;

const CLASSIFIER_POOLED: [usize; 3] = [64, 128, 1024];
const DECISION: [usize; 2] = [512, 256];
const PROPOSALS_POOLED: [usize; 3] = [64, 64, 128];
const SCORE: [usize; 3] = [128, 64, 64];

const ROWS: [&str; 5] =
    ["classifier.points", "classifier.triangles", "classifier.decision", "proposals.points", "proposals.score"];
/// Layers before a maximum, and of the decision.
pub const DEPTH: usize = 3;
/// Layers of `proposals.score`.
pub const SCORE_DEPTH: usize = 4;

/// Returns the shapes of all tensors.
pub fn shapes(width_share: f64) -> Tensors<[usize; 2]> {
    let part =
        |widths: &[usize]| -> Vec<usize> { widths.iter().map(|&width| scale_width(width, width_share)).collect() };
    let [classifier, proposals] = [part(&CLASSIFIER_POOLED), part(&PROPOSALS_POOLED)];
    let after = |n_in: usize, widths: &[usize]| [&[n_in], widths].concat();
    let (both, of_edge) = (2 * classifier[2], proposals[2]);
    let rows = [
        after(POINT_NUMBERS, &classifier),
        after(TRIANGLE_NUMBERS, &classifier),
        after(both, &[part(&DECISION), vec![1]].concat()),
        after(POINT_NUMBERS, &proposals),
        after(POINT_NUMBERS, &[part(&SCORE), vec![1]].concat()),
    ];
    let mut shapes = Tensors::default();
    for (name, widths) in ROWS.iter().zip(&rows) {
        for (i, pair) in widths.windows(2).enumerate() {
            shapes.push(format!("{name}_{i}.weights"), [pair[0], pair[1]]);
            shapes.push(format!("{name}_{i}.bias"), [1, pair[1]]);
        }
    }
    shapes.push("proposals.pooled", [of_edge, rows[4][1]]);
    shapes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_sizes_are_those_of_the_paper() {
        let mlp = |widths: &[usize]| widths.windows(2).map(|pair| (pair[0] + 1) * pair[1]).sum::<usize>();
        let classifier = mlp(&[6, 64, 128, 1024]) + mlp(&[13, 64, 128, 1024]) + mlp(&[2048, 512, 256, 1]);
        let proposals = mlp(&[6, 64, 64, 128]) + mlp(&[134, 128, 64, 64, 1]);
        assert_eq!(shapes(1.0).n_parameters(), classifier + proposals);
        assert_eq!(shapes(0.25).get("classifier.points_2.weights"), Some(&[32, 256]));
    }
}
