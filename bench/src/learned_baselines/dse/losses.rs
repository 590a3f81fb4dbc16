//! Losses of both networks.

use super::Turn;
use neural_mesh::linalg::Matrix;

/// A loss and its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct Loss {
    /// Value.
    pub value: f64,
    /// Derivative by the input, of its shape.
    pub gradient: Matrix,
}

/// Computes the mean cross entropy of the neighbour classification.
///
/// # Shapes
/// - `logits`: (n_patches * group) x 1, `are_neighbours` one each; the first of each group is skipped
pub fn neighbour_loss(logits: &Matrix, are_neighbours: &[bool], group: usize) -> Loss {
    // Cross entropy replaces the squared error of the paper's program, whose gradient vanishes for confident errors.
    let n_counted = (logits.n_rows() - logits.n_rows() / group).max(1) as f64;
    let (mut value, mut gradient) = (0.0, Matrix::zeros(logits.n_rows(), 1));
    let rows = logits.data().iter().zip(are_neighbours).zip(gradient.data_mut());
    for (_, ((&logit, &is_neighbour), to)) in rows.enumerate().filter(|(row, _)| row % group != 0) {
        let logit = f64::from(logit);
        let against = if is_neighbour { -logit } else { logit };
        // This is ln(1 + exp(x)) without overflow.
        value += against.max(0.0) + (-against.abs()).exp().ln_1p();
        let probability = 1.0 / (1.0 + (-logit).exp());
        *to = ((probability - f64::from(u8::from(is_neighbour))) / n_counted) as f32;
    }
    Loss { value: value / n_counted, gradient }
}

/// Computes the mean of `|T x - y|^2 + (|x| - |y|)^2` with the best rotation or reflection T of each patch.
///
/// # Shapes
/// - `map`: (n_patches * group) x 2, `exact` one each
pub fn map_loss(map: &Matrix, exact: &[[f64; 2]], group: usize) -> Loss {
    let scale = 1.0 / map.n_rows().max(1) as f64;
    let (mut value, mut gradient) = (0.0, Matrix::zeros(map.n_rows(), 2));
    let place = |row: usize| [0, 1].map(|axis: usize| f64::from(map.row(row)[axis]));
    for begin in (0..map.n_rows()).step_by(group) {
        let rows = begin..begin + group;
        // The best turn makes the sum stationary, so the gradient treats the turn as constant.
        let turn = Turn::fit(rows.clone().map(|row| (place(row), exact[row], 1.0)));
        for row in rows {
            let (x, y) = (place(row), turn.unapply(exact[row]));
            let [is, wanted] = [x, y].map(|at| at[0].hypot(at[1]));
            value += scale * ((x[0] - y[0]).powi(2) + (x[1] - y[1]).powi(2) + (is - wanted).powi(2));
            for axis in 0..2 {
                let outward = if is > 0.0 { x[axis] / is } else { 0.0 };
                let to = 2.0 * scale * (x[axis] - y[axis] + (is - wanted) * outward);
                gradient.data_mut()[2 * row + axis] = to as f32;
            }
        }
    }
    Loss { value, gradient }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::random;

    fn check(inputs: &Matrix, loss: impl Fn(&Matrix) -> Loss) {
        let analytic = loss(inputs).gradient;
        for at in 0..inputs.data().len() {
            let moved = |step: f32| {
                let mut moved = inputs.clone();
                moved.data_mut()[at] += step;
                loss(&moved).value
            };
            let numeric = (moved(1e-3) - moved(-1e-3)) / 2e-3;
            let analytic = f64::from(analytic.data()[at]);
            assert!((numeric - analytic).abs() < 1e-4 * (1.0 + analytic.abs()), "{at}: {numeric} {analytic}");
        }
    }

    fn exact(n: usize) -> Vec<[f64; 2]> {
        (0..n).map(|i| [(1.3 * i as f64).sin(), (0.7 * (i * i) as f64).cos()]).collect()
    }

    #[test]
    fn gradients_of_losses() {
        let are_neighbours: Vec<bool> = (0..12).map(|i| i % 3 == 1).collect();
        check(&random(12, 1, 1), |logits| neighbour_loss(logits, &are_neighbours, 4));
        check(&random(12, 2, 2), |map| map_loss(map, &exact(12), 6));
    }

    #[test]
    fn losses_have_the_values_of_their_formulas() {
        let loss = neighbour_loss(&Matrix::new(3, 1, vec![9.0, 0.0, 0.0]), &[true, true, false], 3);
        assert!((loss.value - 2f64.ln()).abs() < 1e-9);
        assert_eq!(loss.gradient.data(), [0.0, -0.25, 0.25]);
        let turned = Matrix::new(2, 2, vec![0.0, 0.0, 0.0, 3.0]);
        assert!(map_loss(&turned, &[[0.0; 2], [3.0, 0.0]], 2).value < 1e-12);
        assert_eq!(map_loss(&turned, &[[0.0; 2], [1.0, 0.0]], 2).value, 4.0);
    }

    #[test]
    fn sure_answers_stay_finite() {
        let loss = neighbour_loss(&Matrix::new(3, 1, vec![0.0, 1e5, -1e5]), &[true, false, false], 3);
        assert_eq!(loss.value, 5e4);
        assert_eq!(loss.gradient.data(), [0.0, 0.5, 0.0]);
    }

    #[test]
    fn turned_and_mirrored_maps_are_as_good() {
        let map = random(10, 2, 3);
        let turned = Matrix::from_fn(10, 2, |row, axis| {
            let turn = Turn { cos_sin: [0.6, 0.8], reflects: true };
            turn.apply([0, 1].map(|axis: usize| f64::from(map.row(row)[axis])))[axis] as f32
        });
        let [a, b] = [&map, &turned].map(|map| map_loss(map, &exact(10), 5).value);
        assert!(a > 0.1 && (a - b).abs() < 1e-6);
    }
}
