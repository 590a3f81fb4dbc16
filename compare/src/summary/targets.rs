//! What we aim at, and what is reached.

use super::cases::Cases;
use super::markdown::{cells, number, table};
use super::statistics::{Figure, median, quantile};
use crate::row::Row;

/// Faces from which a mesh counts for the time.
const LARGE: usize = 50_000;

/// Meshes whose sharp edges make them the hard ones.
const SHARP: [&str; 4] = ["fandisk", "anchor", "casting", "rocker_arm"];

/// Medians and 90th percentiles of the ratios, by ratio and over all.
pub fn medians(cases: &Cases) -> String {
    let mut groups: Vec<Vec<f64>> = cases.ratios.iter().map(|&ratio| vec![ratio]).collect();
    groups.push(cases.ratios.clone());
    let mut head = cells(&["ours / meshoptimizer: median (90th percentile)"]);
    head.extend(cases.ratios.iter().map(|ratio| format!("{ratio}")));
    head.extend(cells(&["all", "target, all"]));
    let rows: Vec<_> = Figure::ALL.into_iter().map(|figure| median_row(cases, figure, &groups)).collect();
    table(&head, &rows)
}

fn median_row(cases: &Cases, figure: Figure, groups: &[Vec<f64>]) -> Vec<String> {
    let counts = |input: &Row| figure != Figure::Time || input.faces > LARGE;
    let mut row = vec![match figure {
        Figure::Time => format!("time, one thread, above {} thousand faces", LARGE / 1000),
        _ => figure.title().to_owned(),
    }];
    for ratios in groups {
        let values = cases.ratios_of(figure, ratios, counts);
        row.push(format!("{} ({})", number(median(values.clone())), number(quantile(values, 0.9))));
    }
    row.push(match figure {
        Figure::Mean => "0.50 (1.00)".to_owned(),
        Figure::Rms => "-".to_owned(),
        Figure::Hausdorff => "0.90".to_owned(),
        Figure::NormalError => "0.95".to_owned(),
        Figure::Time => "2.00".to_owned(),
    });
    row
}

/// The mean distance on each mesh with sharp edges.
pub fn sharp(cases: &Cases) -> String {
    let mut head = cells(&["mean distance, ours / meshoptimizer"]);
    head.extend(cases.ratios.iter().map(|ratio| format!("{ratio}")));
    head.push("target, each".to_owned());
    let row = |mesh: &&str| {
        let values = cases.ratios.iter().map(|&ratio| number(cases.ratio_of(Figure::Mean, mesh, ratio)));
        [(*mesh).to_owned()].into_iter().chain(values).chain(["1.00".to_owned()]).collect()
    };
    table(&head, &SHARP.iter().map(row).collect::<Vec<_>>())
}
