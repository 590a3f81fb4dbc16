//! Price common to all blocks.

use super::block::Block;
use crate::model::Weights;
use crate::simplify::{ClosedOptions, SimplifyError};

/// Prices of the merges that bring a block to its requested size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BlockPrices {
    /// Vertices of the block.
    pub n_vertices: usize,
    /// Shared vertices of the block, which stay.
    pub n_shared: usize,
    /// Remaining vertices after each pass, falling, and the price of the pass's last merge.
    pub pass_prices: Vec<(usize, f64)>,
}

/// Simplifies a block to a share of its vertices plus the shared ones; returns the prices of the merges.
///
/// # Errors
/// As for [`simplify`](crate::simplify::simplify).
pub fn sample_block(
    block: &Block,
    share: f64,
    weights: Option<&Weights>,
    options: &ClosedOptions,
) -> Result<BlockPrices, SimplifyError> {
    let n_vertices = block.mesh.positions().len();
    let piece = block.simplify(share, None, weights, options)?;
    Ok(BlockPrices { n_vertices, n_shared: block.n_shared(), pass_prices: piece.pass_prices })
}

impl BlockPrices {
    /// Makes the value from prices that another process measured.
    pub fn new(n_vertices: usize, n_shared: usize, pass_prices: Vec<(usize, f64)>) -> Self {
        Self { n_vertices, n_shared, pass_prices }
    }

    /// Returns the number of vertices after all merges up to a price.
    fn vertices_left(&self, price: f64) -> usize {
        let pass_prices = self.pass_prices.partition_point(|(_, most)| *most <= price);
        match pass_prices.checked_sub(1) {
            Some(last) => self.pass_prices[last].0,
            None => self.pass_prices.first().map_or(self.n_vertices, |first| first.0),
        }
    }
}

/// Returns the least price at which these blocks keep at most a share of their vertices plus the shared ones.
pub fn price_for(samples: &[BlockPrices], share: f64) -> f64 {
    let wanted: f64 = samples.iter().map(|of| share * of.n_vertices as f64 + of.n_shared as f64).sum();
    let mut prices: Vec<f64> = samples.iter().flat_map(|sample| &sample.pass_prices).map(|(_, price)| *price).collect();
    prices.sort_unstable_by(f64::total_cmp);
    let left = |price: f64| samples.iter().map(|sample| sample.vertices_left(price)).sum::<usize>() as f64;
    let at = prices.partition_point(|&price| left(price) > wanted);
    prices.get(at).or(prices.last()).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_price_leaves_more_where_more_is_paid() {
        let sample = |factor: f64| BlockPrices {
            n_vertices: 1000,
            n_shared: 0,
            pass_prices: (1..=9).map(|i| (1000 - 100 * i, factor * i as f64)).collect(),
        };
        let samples = [sample(1.0), sample(3.0)];
        let price = price_for(&samples, 0.5);
        assert_eq!((price, samples[0].vertices_left(price), samples[1].vertices_left(price)), (8.0, 200, 800));
        assert_eq!(price_for(&samples, 0.0), 27.0);
        assert_eq!(price_for(&[], 0.5), 0.0);
    }
}
