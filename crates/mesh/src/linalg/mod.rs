//! Matrices, sparse rows and kernels over them, with derivatives.
//!
//! Results have the same bits on any number of threads of one instruction set. Functions panic if shapes do not match
//! or an index is out of range.

mod bits;
mod csr;
mod gather;
mod group_layers;
mod group_max;
mod isa;
mod matrix;
mod neighbour_max;
mod neighbour_softmax;
mod pair_relu;
mod product;
#[doc(hidden)]
pub mod rounded;
mod rows;
mod scored_dev_conv;
mod sparse_product;
#[cfg(any(test, feature = "test-support"))]
#[doc(hidden)]
pub mod test_values;
mod two_layers;

#[cfg(any(test, feature = "test-support"))]
#[doc(hidden)]
pub use bits::golden;
pub use csr::{Csr, InvalidCsr};
pub use gather::{gather, gather_backward, triple_extremes, triple_extremes_backward};
pub use group_layers::{layers_group_max, layers_with_group_rows};
pub use group_max::{GroupMax, group_max, group_max_affine, group_max_affine_backward, group_max_backward};
#[doc(hidden)]
pub use isa::{Isa, Work};
pub use matrix::Matrix;
pub use neighbour_max::{
    neighbour_max, neighbour_max_backward, neighbour_max_product_relu, neighbour_max_two_products,
};
pub use neighbour_softmax::{neighbour_dots, neighbour_dots_backward, neighbour_softmax, neighbour_softmax_backward};
pub use pair_relu::{PairReluGradients, concat_pair_relu_product, pair_relu, pair_relu_backward, pair_relu_product};
#[doc(hidden)]
pub use product::column_sums;
pub use product::{concat_product, product, product_input_backward, product_weights_backward};
#[doc(hidden)]
pub use rows::Rows;
pub use scored_dev_conv::scored_dev_conv;
#[doc(hidden)]
pub use sparse_product::{sparse_product, sparse_product_backward};
pub use two_layers::two_layers;

#[cfg(test)]
mod tests {
    use super::test_values::{ragged_graph, random, run_on_threads};
    use super::*;

    fn all_derivatives() -> Vec<Vec<f32>> {
        let n = 500;
        let (graph, u, g) = (ragged_graph(n), random(n, 37, 1), random(n, 37, 2));
        let symmetric = Csr::from_edges(n, graph.entries().collect::<Vec<_>>());
        let [values, gradient] = [3, 4].map(|seed| random(1, symmetric.n_entries(), seed).into_data());
        let triples: Vec<[u32; 3]> = (0..n as u32 - 2).map(|i| [i, i + 1, i + 2]).collect();
        let pairs = pair_relu_backward(&u, random(1, 37, 5).data(), &graph, &g);
        let [to_q, to_k] = neighbour_dots_backward(&u, &g, &symmetric, &gradient);
        let softmax = neighbour_softmax(&values, &symmetric);
        vec![
            product_input_backward(&g, &random(20, 37, 6)).into_data(),
            product_weights_backward(&u, &g).into_data(),
            neighbour_max_backward(&u, &graph, &g).into_data(),
            pairs.u.into_data(),
            pairs.bias.into_data(),
            to_q.into_data(),
            to_k.into_data(),
            neighbour_softmax_backward(&softmax, &symmetric, &gradient),
            sparse_product_backward(&values, &symmetric, &graph_of_edges(n), &gradient),
            gather_backward(n, &(0..n as u32).map(|i| i / 3).collect::<Vec<_>>(), &g).into_data(),
            triple_extremes_backward(&u, &triples, &random(n - 2, 3 * 37, 7)).into_data(),
        ]
    }

    fn graph_of_edges(n: usize) -> Csr {
        Csr::from_edges(n, (0..n as u32).map(|i| [i, (i * i + 3) % n as u32]))
    }

    #[test]
    fn derivatives_have_the_same_bits_on_any_number_of_threads() {
        let on_threads = |n| run_on_threads(n, all_derivatives);
        let one = on_threads(1);
        assert!(one.iter().flatten().any(|&x| x != 0.0));
        for n in [1, 2, 8] {
            assert_eq!(on_threads(n), one);
        }
    }
}
