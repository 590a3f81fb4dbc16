//! Matrices, sparse rows and the kernels over them, each kernel beside its derivative; knows no geometry.
//!
//! Kernels take references and return owned results. Each output row is computed by one thread in a fixed
//! order, so results have the same bits on any number of threads (of one instruction set).

mod csr;
mod gather;
mod isa;
mod matrix;
mod neighbour_max;
mod neighbour_softmax;
mod pair_relu;
mod product;
mod sparse_product;
#[cfg(test)]
pub(crate) mod test_values;

pub use csr::{Csr, InvalidCsr};
pub use gather::{gather, gather_backward, triple_extremes, triple_extremes_backward};
pub use matrix::Matrix;
pub use neighbour_max::{neighbour_max, neighbour_max_backward, neighbour_max_product_relu};
pub use neighbour_softmax::{neighbour_dots, neighbour_dots_backward, neighbour_softmax, neighbour_softmax_backward};
pub use pair_relu::{PairReluGradients, pair_relu, pair_relu_backward, pair_relu_product};
pub use product::{concat_product, product, product_input_backward, product_weights_backward};
pub use sparse_product::{sparse_product, sparse_product_backward};
