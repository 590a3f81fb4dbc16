//! Expected cost of the first option kept, each kept independently with its probability.

use super::Term;
use crate::parallel;

/// Rows that a thread takes together.
const ROWS: usize = 1024;

/// Rows of options, the preferred one first in each.
pub(super) struct OptionRows<'a> {
    /// n_rows x `width`: index of each option's probability.
    pub options: &'a [u32],
    /// n_rows x `width`: cost if the option is the first one kept.
    pub costs: &'a [f64],
    /// n_rows: cost if no option is kept.
    pub costs_of_none: &'a [f64],
    pub width: usize,
}

/// Computes the expected cost, divided by the rows' mean last cost; a row without a kept option costs its last.
pub(super) fn relative_cost(options: &[u32], mut costs: Vec<f64>, width: usize, probabilities: &[f32]) -> Term {
    let lasts = last_costs(&costs, width);
    let mean = lasts.iter().sum::<f64>() / lasts.len() as f64;
    if mean > 0.0 {
        costs.iter_mut().for_each(|cost| *cost /= mean);
    }
    let costs_of_none = last_costs(&costs, width);
    expected_cost(&OptionRows { options, costs: &costs, costs_of_none: &costs_of_none, width }, probabilities)
}

pub(super) fn last_costs(costs: &[f64], width: usize) -> Vec<f64> {
    costs.chunks_exact(width).map(|row| row[width - 1]).collect()
}

/// Computes the mean over the rows of `sum_k c_k p_k prod_{j<k} (1 - p_j) + c_none prod_j (1 - p_j)`.
///
/// With `E_k = p_k c_k + (1 - p_k) E_{k+1}`, the derivative to p_k is `c_k - E_{k+1}` times the probability that no earlier
/// option is kept.
pub(super) fn expected_cost(rows: &OptionRows, probabilities: &[f32]) -> Term {
    let OptionRows { options, costs, costs_of_none, width } = *rows;
    if width == 0 || costs_of_none.is_empty() {
        let sum = costs_of_none.iter().sum();
        return Term::mean(sum, &vec![0.0; probabilities.len()], costs_of_none.len());
    }
    let mut slopes = vec![0.0f64; options.len()];
    let chunks = slopes.chunks_mut(ROWS * width).zip(options.chunks(ROWS * width)).zip(costs.chunks(ROWS * width));
    let values = parallel::each(chunks.zip(costs_of_none.chunks(ROWS)), |(((slopes, options), costs), of_none)| {
        let rows = slopes.chunks_mut(width).zip(options.chunks(width)).zip(costs.chunks(width)).zip(of_none);
        let cost = |(((slopes, options), costs), &none)| row_cost(slopes, options, costs, none, probabilities);
        rows.map(cost).collect::<Vec<f64>>()
    });
    let values = values.concat();
    let mut gradient = vec![0.0f64; probabilities.len()];
    options.iter().zip(&slopes).for_each(|(&option, slope)| gradient[option as usize] += slope);
    Term::mean(values.iter().sum(), &gradient, values.len())
}

fn row_cost(slopes: &mut [f64], options: &[u32], costs: &[f64], none: f64, probabilities: &[f32]) -> f64 {
    // From last to first: `rest` is the expected cost if no earlier option is kept.
    let mut rest = none;
    for ((slope, &option), cost) in slopes.iter_mut().zip(options).zip(costs).rev() {
        let p = f64::from(probabilities[option as usize]);
        *slope = cost - rest;
        rest = p * cost + (1.0 - p) * rest;
    }
    // From first to last: `none_before` is the probability that no earlier option is kept.
    let mut none_before = 1.0;
    for (slope, &option) in slopes.iter_mut().zip(options) {
        *slope *= none_before;
        none_before *= 1.0 - f64::from(probabilities[option as usize]);
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::*;

    fn cost_by_subsets(options: &[u32], costs: &[f64], none: f64, p: &[f32]) -> f64 {
        let of_subset = |kept: u32| {
            let chance = (0..p.len()).map(|i| if kept >> i & 1 == 1 { p[i] } else { 1.0 - p[i] });
            let first = options.iter().position(|&option| kept >> option & 1 == 1);
            chance.map(f64::from).product::<f64>() * first.map_or(none, |at| costs[at])
        };
        (0..1 << p.len()).map(of_subset).sum()
    }

    #[test]
    fn agrees_with_all_subsets_and_with_differences() {
        let options = [2, 0, 1, 3, 1, 4, 3, 0];
        let costs: Vec<f64> = uniform(8, 5).into_iter().map(f64::from).collect();
        let none = [1.5, 0.25];
        let rows = OptionRows { options: &options, costs: &costs, costs_of_none: &none, width: 4 };
        let p = uniform(5, 6);
        let row = |row: usize| cost_by_subsets(&options[4 * row..][..4], &costs[4 * row..][..4], none[row], &p);
        assert!((expected_cost(&rows, &p).value - (row(0) + row(1)) / 2.0).abs() < 1e-6);
        assert_gradient(&p, 1e-5, |p| expected_cost(&rows, p));
    }

    #[test]
    fn certain_options_end_their_row() {
        let rows = OptionRows { options: &[0, 1, 2], costs: &[1.0, 2.0, 4.0], costs_of_none: &[8.0], width: 3 };
        assert_eq!(expected_cost(&rows, &[0.0, 1.0, 0.5]), Term { value: 2.0, gradient: vec![-1.0, -4.0, 0.0] });
        assert_eq!(expected_cost(&rows, &[0.0; 3]).value, 8.0);
    }
}
