//! A linear map with a bias.

/// Weights and bias of an affine map; `T` is a shape, a matrix, or a value on a tape.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine<T> {
    /// Matrix, n_in x n_out: one row per input.
    pub weights: T,
    /// Bias, 1 x n_out, added to each row.
    pub bias: T,
}

impl Affine<[usize; 2]> {
    pub(super) fn shape(n_in: usize, n_out: usize) -> Self {
        Self { weights: [n_in, n_out], bias: [1, n_out] }
    }
}

impl<T> Affine<T> {
    pub(super) fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<Affine<U>, E> {
        Ok(Affine {
            weights: f(&format!("{name}.weights"), &self.weights)?,
            bias: f(&format!("{name}.bias"), &self.bias)?,
        })
    }
}
