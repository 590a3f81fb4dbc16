//! Results of the shipped weights, and effects of scores on the closed assembly.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use neural_mesh::linalg::Matrix;
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{ClosedOptions, Options, ScoreSource, Size};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::bench::{Bench, Blocks, RATIOS, thread_pool, tosca_weights};
use super::benchmark::{self, FIGURES};
use super::meshes::{hausdorff_distance, load};
use super::paper;
use super::versions::Subsystem;
use crate::cells::{Cell, Show, largest, mean, median, worst, worst_mesh};
use crate::clock::measure_time;
use crate::evaluate::simplify_ours;
use crate::rows::{ResultRow, Table};
use crate::tables::{Column, Line, TextTable, pivot};

// Name of the full assembly; figures of the others are divided by its figures.
const WHOLE: &str = "whole";
const CORNER: &str = "over the full assembly";
const SAMPLES: usize = 50_000;
// Name and description of replaced scores.
const CASES: [(&str, &str); 3] =
    [("even", "no scores"), ("network", "network scores"), ("shuffled", "shuffled weights")];

pub fn measure(bench: &Bench) -> Result<Blocks> {
    let closed = bench.for_subsystems(&[Subsystem::Closed])?;
    let figures = ["distance_mean", "distance_max", "normal_error_signed", "seconds"];
    let stages = closed
        .measure("stages", &figures, bench.meshes("test")?, |name, path| measure_stages(name, path))?
        .with_quotients_over(WHOLE);
    bench.write_csv("weights-scores", &csv_table(&stages))?;
    let scores = benchmark::evaluate_all(bench)?.with_quotients_over("geometry");
    let both = paper::class_settings(&["closed", "paper"]);
    let open = bench.evaluate_set("weights-open", "tosca", both, None)?;
    let tosca = paper::class_settings(&["paper"]);
    let tosca = bench.evaluate_set("weights-tosca", "tosca", tosca, Some(tosca_weights()))?;
    let weights =
        [("paper-open", &open, "paper"), ("paper-tosca", &tosca, "paper"), ("closed assembly", &open, "closed")];
    let weights = weights.map(|(name, rows, method)| tosca_table(name, rows, method));
    Ok(vec![
        ("scores", case_table(&stages, &CASES).markdown()),
        ("default", ratio_table(&scores, "network", &["network / no scores"], |title| vec![title]).markdown()),
        ("paper-weights", weights.into_iter().fold(TextTable::default(), TextTable::with_lines_of).markdown()),
    ])
}

fn measure_stages(name: &str, path: &Path) -> Result<Vec<ResultRow>> {
    let mesh = load(path)?;
    let weights = Weights::shipped_default();
    let shuffled = shuffle_weights(weights, 0)?;
    let cases = [
        (WHOLE, ScoreSource::Bending, None),
        ("even", ScoreSource::Geometry, None),
        ("network", ScoreSource::Network, Some(weights)),
        ("shuffled", ScoreSource::Network, Some(&shuffled)),
    ];
    let original = Surface::new(&mesh, SAMPLES, 0);
    let one = thread_pool(1)?;
    let mut rows = Vec::new();
    for ratio in RATIOS {
        let n = ((mesh.positions().len() as f64 * ratio) as usize).max(1);
        for (method, scores, weights) in cases {
            let closed = ClosedOptions { scores, prune: false, ..ClosedOptions::default() };
            let options = Options::with_closed(Size::Vertices(n), closed);
            let (simplified, time) = one
                .install(|| measure_time(|| simplify_ours(&mesh, weights, options.clone())))
                .with_context(|| format!("{method} at {ratio}"))?;
            let distance = surface_distance(&original, &Surface::new(&simplified, SAMPLES, 1)).context("no faces")?;
            let (both, share) = (distance.both, 100.0 / distance.diagonal);
            let largest = hausdorff_distance(&mesh, &simplified)? * share;
            let figures = [both.mean * share, largest, both.normal_error, time.thread];
            rows.push(ResultRow::new(name, ratio, method, &figures));
        }
    }
    Ok(rows)
}

/// Permutes the entries of every tensor (Fisher and Yates).
fn shuffle_weights(weights: &Weights, seed: u64) -> Result<Weights> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let tensors = weights.tensors().map(|_, tensor| {
        let mut shuffled = Matrix::clone(tensor);
        for last in (1..shuffled.data().len()).rev() {
            let other = (u128::from(rng.next_u64()) * (last as u128 + 1)) >> 64;
            shuffled.data_mut().swap(last, other as usize);
        }
        Arc::new(shuffled)
    });
    Ok(Weights::from_tensors(*weights.architecture(), tensors)?)
}

fn case_table(stages: &Table, cases: &[(&str, &str)]) -> TextTable {
    let lines: Vec<Line> = cases.iter().map(|(name, about)| Line::new([about]).with_method(name)).collect();
    let columns = |(title, figure): (&str, &str)| {
        [Column::of_figure(title, figure, 1.0, median), Column::of_figure("worst mesh", figure, 1.0, worst)]
    };
    pivot(stages, &[CORNER], &lines, &FIGURES.into_iter().flat_map(columns).collect::<Vec<_>>())
}

// A line for each figure with the medians at each ratio and at all; `labels` makes its first cells of the title.
fn ratio_table<'a>(rows: &Table, method: &str, corner: &[&str], labels: impl Fn(&'a str) -> Vec<&'a str>) -> TextTable {
    let line = |(title, figure): (&'a str, &str)| {
        let line =
            Line { labels: labels(title).into_iter().map(String::from).collect(), ..Line::new([]).with_method(method) };
        let column = |title: &str| Column::of_figure(title, figure, 1.0, median);
        let mut columns: Vec<Column> = RATIOS.map(|ratio| column(&ratio.to_string()).with_ratio(ratio)).into();
        columns.push(column("all"));
        pivot(rows, corner, &[line], &columns)
    };
    FIGURES.into_iter().map(line).fold(TextTable::default(), TextTable::with_lines_of)
}

fn csv_table(stages: &Table) -> TextTable {
    let case = |(name, about): (&'static str, &'static str)| {
        let mut table = ratio_table(stages, name, &[CORNER, "figure"], |title| vec![about, title]);
        let worst: [(&str, Show); 2] = [("worst mesh", worst_mesh), ("worst", largest)];
        for ((_, figure), line) in FIGURES.into_iter().zip(&mut table.lines) {
            let columns = worst.map(|(title, show)| Column::of_figure(title, figure, 1.0, show));
            line.append(&mut pivot(stages, &[], &[Line::new([]).with_method(name)], &columns).lines[0]);
        }
        table.head.extend(worst.map(|(title, _)| title.to_owned()));
        table
    };
    CASES.into_iter().map(case).fold(TextTable::default(), TextTable::with_lines_of)
}

fn tosca_table(weights: &str, rows: &Table, method: &str) -> TextTable {
    let four_decimals = |values: &[(&str, f64)]| {
        let value = crate::cells::mean_of(values);
        Cell { text: value.map_or("-".into(), |value| format!("{value:.4}")), value }
    };
    let columns = [
        Column::of_results(),
        Column::of_figure("CD", "chamfer", 1e6, mean),
        Column::of_figure("NE", "normal_error", 1.0, four_decimals),
        Column::of_figure("WA", "edges_without_two_faces", 1.0, mean),
        Column::of_figure("open", "open_edges", 1.0, mean),
    ];
    let lines = RATIOS.map(|ratio| Line::new([weights, &ratio.to_string()]).with_method(method).with_ratio(ratio));
    pivot(rows, &["weights", "ratio"], &lines, &columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tensor_keeps_its_entries() {
        let weights = Weights::random(1);
        let other = shuffle_weights(&weights, 2).unwrap();
        assert_ne!(other, weights);
        assert_eq!(other, shuffle_weights(&weights, 2).unwrap());
        let sorted = |weights: &Weights| {
            let mut all: Vec<Vec<f32>> = Vec::new();
            weights.tensors().map(|_, tensor| all.push(tensor.data().to_vec()));
            all.iter_mut().for_each(|entries| entries.sort_by(f32::total_cmp));
            all
        };
        assert_eq!(sorted(&other), sorted(&weights));
    }

    #[test]
    fn every_case_has_a_line_for_each_figure() {
        let row = |method: &str, value| ResultRow::new("ball", 0.1, method, &[value; 4]);
        let figures = ["distance_mean", "distance_max", "normal_error_signed", "seconds"];
        let stages = Table::new(&figures, vec![row(WHOLE, 2.0), row("even", 1.0)]).with_quotients_over(WHOLE);
        let csv = csv_table(&stages);
        assert_eq!((csv.lines.len(), csv.head.len()), (figures.len() * CASES.len(), 9));
        assert_eq!(csv.lines[1], ["no scores", "largest distance", "-", "0.50", "-", "-", "0.50", "ball", "0.50"]);
        assert!(case_table(&stages, &CASES).markdown().contains("| no scores | 0.50 | ball 0.50 |"));
    }
}
