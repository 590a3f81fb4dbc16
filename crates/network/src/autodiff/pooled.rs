//! Operations on groups of equally many rows, such as the neighbours of a point.

use super::{Tape, Value};
use crate::linalg::{self, Matrix};

impl Tape {
    /// Computes column maxima over consecutive groups of `group` rows: (n * group) x n_cols to n x n_cols.
    pub fn group_max(&mut self, x: &Value, group: usize) -> Value {
        let found = linalg::group_max(&x.matrix, group);
        let n_rows = x.matrix.n_rows();
        self.record(found.largest, [x], move |gradient, _| {
            [Some(linalg::group_max_backward(n_rows, &found.rows, gradient))]
        })
    }

    /// Computes [`Tape::group_max`] of `x w + b` for a layer `[w, b]` without storing the map.
    pub fn group_max_affine(&mut self, x: &Value, layer: [&Value; 2], group: usize) -> Value {
        let found = linalg::group_max_affine(&x.matrix, layer.map(Value::matrix), group);
        let (x_kept, weights_kept) = (x.matrix.clone(), layer[0].matrix.clone());
        self.record(found.largest, [x, layer[0], layer[1]], move |gradient, _| {
            linalg::group_max_affine_backward(&x_kept, &weights_kept, &found.rows, gradient).map(Some)
        })
    }

    /// Applies one or more affine maps `[w, b]` with ReLUs between them.
    pub fn layers(&mut self, x: &Value, layers: &[[&Value; 2]]) -> Value {
        let (last, hidden) = layers.split_last().expect("a layer");
        let x = hidden.iter().fold(x.clone(), |x, [weights, bias]| {
            let mapped = self.affine(&x, weights, bias);
            self.relu(&mapped)
        });
        self.affine(&x, last[0], last[1])
    }

    /// Computes [`Tape::group_max`] of [`Tape::layers`].
    pub fn layers_group_max(&mut self, x: &Value, layers: &[[&Value; 2]], group: usize) -> Value {
        if are_constant(x, layers) {
            return Value::constant(linalg::layers_group_max(&x.matrix, &matrices(layers), group));
        }
        let (last, hidden) = layers.split_last().expect("a layer");
        if hidden.is_empty() {
            return self.group_max_affine(x, *last, group);
        }
        let mapped = self.layers(x, hidden);
        let active = self.relu(&mapped);
        self.group_max_affine(&active, *last, group)
    }

    /// Applies [`Tape::layers`] to one column; after the first map, each group's row of `group_rows` is added.
    pub fn layers_with_group_rows(
        &mut self,
        x: &Value,
        group_rows: &Value,
        layers: &[[&Value; 2]],
        group: usize,
    ) -> Value {
        if are_constant(x, layers) && group_rows.is_constant() {
            return Value::constant(linalg::layers_with_group_rows(
                &x.matrix,
                &group_rows.matrix,
                &matrices(layers),
                group,
            ));
        }
        let rows: Vec<u32> = (0..x.matrix.n_rows()).map(|row| (row / group) as u32).collect();
        let (first, others) = layers.split_first().expect("a layer");
        let mapped = self.affine(x, first[0], first[1]);
        let row_values = self.gather(group_rows, &rows);
        let both = self.plus(&mapped, &row_values);
        let active = self.relu(&both);
        self.layers(&active, others)
    }
}

fn are_constant(x: &Value, layers: &[[&Value; 2]]) -> bool {
    x.is_constant() && layers.iter().flatten().all(|value| value.is_constant())
}

fn matrices<'a>(layers: &[[&'a Value; 2]]) -> Vec<[&'a Matrix; 2]> {
    layers.iter().map(|layer| layer.map(Value::matrix)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::check_gradients;
    use super::*;
    use crate::linalg::test_values::{assert_close, random};

    fn inputs() -> Vec<Matrix> {
        let sizes = [[30, 5], [5, 7], [1, 7], [7, 4], [1, 4], [4, 1], [1, 1], [6, 7]];
        sizes.iter().zip(1..).map(|(&[n_rows, n_cols], seed)| random(n_rows, n_cols, seed)).collect()
    }

    #[test]
    fn gradients_of_the_largest_of_groups() {
        check_gradients(&inputs()[..1], |tape, v| tape.group_max(&v[0], 6));
        check_gradients(&inputs()[..3], |tape, v| tape.group_max_affine(&v[0], [&v[1], &v[2]], 6));
    }

    #[test]
    fn gradients_of_layers() {
        check_gradients(&inputs()[..5], |tape, v| tape.layers_group_max(&v[0], &[[&v[1], &v[2]], [&v[3], &v[4]]], 6));
        check_gradients(&inputs(), |tape, v| {
            let layers = [[&v[1], &v[2]], [&v[3], &v[4]], [&v[5], &v[6]]];
            tape.layers_with_group_rows(&v[0], &v[7], &layers, 5)
        });
    }

    #[test]
    fn constants_give_the_same_and_record_nothing() {
        let mut tapes = [Tape::default(), Tape::default()];
        let found = [0, 1].map(|way| {
            let tape = &mut tapes[way];
            let value = |m: &Matrix, tape: &mut Tape| match way {
                0 => Value::constant(m.clone()),
                _ => tape.parameter(m.clone()),
            };
            let v: Vec<Value> = inputs().iter().map(|m| value(m, tape)).collect();
            let pooled = tape.layers_group_max(&v[0], &[[&v[1], &v[2]], [&v[3], &v[4]]], 6);
            let layers = [[&v[1], &v[2]], [&v[3], &v[4]], [&v[5], &v[6]]];
            let scored = tape.layers_with_group_rows(&v[0], &v[7], &layers, 5);
            [pooled.matrix().data(), scored.matrix().data()].concat()
        });
        assert_close(&found[0], &found[1], 1e-6);
        assert!(tapes[0].is_empty());
    }
}
