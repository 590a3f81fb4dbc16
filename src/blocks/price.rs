//! The price that holds for all blocks, known beforehand from what some of them pay.

use super::block::Block;
use crate::model::Weights;
use crate::simplify::{Options, SimplifyError, simplify_block_mesh};

/// What a block pays on its way to the size asked for.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sample {
    /// Vertices of the block.
    pub n_vertices: usize,
    /// Those of them that stay.
    pub n_shared: usize,
    /// How many vertices merges left, falling, and what the last of them cost.
    pub paid: Vec<(usize, f64)>,
}

/// Simplifies a block down to a share of its vertices beside those that stay, and tells what that cost.
///
/// # Errors
/// [`SimplifyError`] as of [`simplify`](crate::simplify::simplify).
pub fn sample_block(
    block: &Block,
    share: f64,
    weights: Option<&Weights>,
    options: &Options,
) -> Result<Sample, SimplifyError> {
    let n_vertices = block.mesh.positions().len();
    let asked = (block.n_left(share), None);
    let piece = simplify_block_mesh(&block.mesh, &block.shared, asked, weights, options)?;
    Ok(Sample { n_vertices, n_shared: block.n_shared(), paid: piece.paid })
}

impl Sample {
    /// What another process was told.
    pub fn new(n_vertices: usize, n_shared: usize, paid: Vec<(usize, f64)>) -> Self {
        Self { n_vertices, n_shared, paid }
    }

    /// The vertices that are left where no merge costs more.
    fn left_at(&self, price: f64) -> usize {
        let paid = self.paid.partition_point(|(_, most)| *most <= price);
        match paid.checked_sub(1) {
            Some(last) => self.paid[last].0,
            None => self.paid.first().map_or(self.n_vertices, |first| first.0),
        }
    }
}

/// The least price at which these blocks keep no more than a share of their vertices beside those that stay; the highest that was paid
/// where none does.
pub fn price_for(samples: &[Sample], share: f64) -> f64 {
    let wanted: f64 = samples.iter().map(|of| share * of.n_vertices as f64 + of.n_shared as f64).sum();
    let mut prices: Vec<f64> = samples.iter().flat_map(|sample| &sample.paid).map(|(_, price)| *price).collect();
    prices.sort_unstable_by(f64::total_cmp);
    let left = |price: f64| samples.iter().map(|sample| sample.left_at(price)).sum::<usize>() as f64;
    let at = prices.partition_point(|&price| left(price) > wanted);
    prices.get(at).or(prices.last()).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_price_leaves_more_where_more_is_paid() {
        let sample = |factor: f64| Sample {
            n_vertices: 1000,
            n_shared: 0,
            paid: (1..=9).map(|i| (1000 - 100 * i, factor * i as f64)).collect(),
        };
        let samples = [sample(1.0), sample(3.0)];
        let price = price_for(&samples, 0.5);
        assert_eq!((price, samples[0].left_at(price), samples[1].left_at(price)), (8.0, 200, 800));
        assert_eq!(price_for(&samples, 0.0), 27.0);
        assert_eq!(price_for(&[], 0.5), 0.0);
    }
}
