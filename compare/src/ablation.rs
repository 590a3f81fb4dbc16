//! What each part of the closed assembly is worth: without one at a time, over all of them.

use anyhow::Result;
use neural_mesh::model::Weights;
use neural_mesh::simplify::Parts;

use crate::closed::Args;
use crate::closed::versus::{all_over, ratios};
use crate::closed::weighed::{Source, weighed};
use crate::row::Row;
use crate::turns::Contestant;

/// The row that the others stand over.
const ALL: &str = "everything";

const WITHOUT: [&str; 5] =
    ["without learned importance", "with sweeps", "without flips", "without fit", "without oversampling"];

const INTRODUCTION: &str = "\
The closed assembly without one of its parts, over the whole of it: per mesh and ratio the median over the seeds, then medians \
over meshes and ratios, 90th percentiles in brackets; above 1 the part is worth something. Distances are two-sided \
point-to-surface; the normal error is the mean of 1 - n.n'. Flips are made from 15 input vertices per output vertex on.
";

/// Measures every row and writes table and page.
pub fn ablation(args: &Args) -> Result<()> {
    let weights = args.read_weights()?;
    args.publish(&contestants(&weights), page)
}

fn contestants(weights: &Weights) -> Vec<Contestant<'_>> {
    let all = Parts::default();
    let (network, [importance, sweeps, flips, fit, oversampling]) = (Source::Network(weights), WITHOUT);
    let cases = [
        (ALL, network, all),
        (importance, Source::Even, all),
        (sweeps, network, Parts { sweeps: true, ..all }),
        (flips, network, Parts { flips: false, ..all }),
        (fit, network, Parts { fit: false, ..all }),
        (oversampling, network, Parts { oversampling: false, ..all }),
    ];
    let contestant = |(name, source, parts)| Contestant::new(name, move |case, _| weighed(case, source, &parts));
    cases.into_iter().map(contestant).collect()
}

/// A table over all ratios, and one for each.
fn page(rows: &[Row]) -> String {
    let all = ratios(rows);
    let of = |ratios: &[f64]| all_over(rows, &WITHOUT, ALL, ratios);
    let each: String = all.iter().map(|&ratio| format!("\n### Ratio {ratio}\n\n{}", of(&[ratio]))).collect();
    format!("{INTRODUCTION}\n### All ratios\n\n{}{each}", of(&all))
}
