//! Distances of rows to the first row of their group.

use super::{Tape, Value};
use crate::linalg::Matrix;

/// Lower limit of distances, which gives a derivative at zero; from the implementation of DSE.
const MIN_DISTANCE: f32 = 1e-4;

impl Tape {
    /// Computes the distance of each row to the first of its group, at least 1e-4.
    pub fn group_distances(&mut self, x: &Value, group: usize) -> Value {
        let distances = group_distances(&x.matrix, group);
        let (x_kept, kept) = (x.matrix.clone(), distances.clone());
        self.record(Matrix::new(distances.len(), 1, distances), [x], move |gradient, _| {
            let n_cols = x_kept.n_cols();
            let mut to_x = Matrix::zeros(x_kept.n_rows(), n_cols);
            for (row, (&distance, &g)) in kept.iter().zip(gradient.data()).enumerate() {
                if distance <= MIN_DISTANCE {
                    continue;
                }
                let first = row / group * group;
                for col in 0..n_cols {
                    let to = g * (x_kept.row(row)[col] - x_kept.row(first)[col]) / distance;
                    to_x.data_mut()[row * n_cols + col] += to;
                    to_x.data_mut()[first * n_cols + col] -= to;
                }
            }
            [Some(to_x)]
        })
    }
}

fn group_distances(x: &Matrix, group: usize) -> Vec<f32> {
    assert!(group > 0 && x.n_rows().is_multiple_of(group), "a whole number of groups of rows");
    let distance = |row: usize| {
        let pairs = x.row(row).iter().zip(x.row(row / group * group));
        pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt().max(MIN_DISTANCE)
    };
    (0..x.n_rows()).map(distance).collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::check_gradients;
    use super::*;
    use crate::linalg::test_values::random;

    #[test]
    fn distances_have_their_golden_values() {
        let x = Matrix::new(4, 2, vec![1.0, 1.0, 4.0, 5.0, 0.0, 0.0, 0.0, -2.0]);
        let distances = Tape::default().group_distances(&Value::constant(x), 2);
        assert_eq!(distances.matrix().data(), [1e-4, 5.0, 1e-4, 2.0]);
    }

    #[test]
    fn gradients_of_distances() {
        check_gradients(&[random(12, 3, 1)], |tape, v| tape.group_distances(&v[0], 4));
    }
}
