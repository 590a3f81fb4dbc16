//! The report of an evaluation: a Markdown page of tables made from the rows.

use std::path::Path;

use super::folder::{ROWS, write_whole};
use crate::cells::{Cell, mean_digits, median_digits};
use crate::rows::{ResultRow, Table, distinct};
use crate::rows_file::read_rows;
use crate::tables::{Column, Line, TextTable, pivot};
use neural_mesh_cli::shared::Failure;

/// File name of the report.
pub const REPORT: &str = "report.md";

const DEFAULT_REFERENCE: &str = "qem";

// Title, figure and factor of a column.
const COLUMNS: [(&str, &str, f64); 13] = [
    ("CD, 1e-6", "chamfer", 1e6),
    ("WA, %", "edges_without_two_faces", 1.0),
    ("LE", "laplacian_functions", 1.0),
    ("NE", "normal_error", 1.0),
    ("time, s", "seconds", 1.0),
    ("distance, %", "distance_mean", 1.0),
    ("Hausdorff, %", "distance_max", 1.0),
    ("FLIP", "flip", 1.0),
    ("normals, degrees", "normal_angle", 1.0),
    ("open edges, %", "open_edges", 1.0),
    ("turned faces", "turned_faces", 1.0),
    ("crossing faces", "self_intersecting_faces", 1.0),
    ("curvature", "curvature_error", 1.0),
];

// A result counts as too large if both its vertices and its faces exceed the target by this factor.
const LARGER: f64 = 1.1;

/// Writes `report.md` next to the rows of an evaluation, and returns the rows.
///
/// # Errors
/// [`Failure`] where the folder or the method `relative_to` has no rows.
pub fn write_report(folder: &Path, relative_to: Option<&str>) -> Result<Table, Failure> {
    let table = read_rows(&folder.join(ROWS))?;
    let methods = table.methods();
    if let Some(name) = relative_to.filter(|name| !methods.contains(name)) {
        let methods = methods.join(", ");
        let what = format!("--relative-to {name}: the evaluation has no rows of this method: give one of {methods}");
        return Err(Failure::Usage(what));
    }
    let relative_to = relative_to.or_else(|| methods.contains(&DEFAULT_REFERENCE).then_some(DEFAULT_REFERENCE));
    write_whole(&folder.join(REPORT), &format_report(&table, relative_to))?;
    Ok(table)
}

fn format_report(table: &Table, relative_to: Option<&str>) -> String {
    let mut report = format_head(table);
    let mut ratios = distinct(table.rows.iter().map(|row| row.ratio));
    ratios.sort_by(f64::total_cmp);
    for ratio in ratios {
        let rows = table.filter(|row| row.ratio == ratio);
        report += &format!("\n## Ratio {ratio}\n\n{}", mean_table(&rows).markdown());
        if let Some(other) = relative_to {
            let quotients = quotient_table(&rows, other).markdown();
            report += &format!(
                "\nRelative to {other}: medians of the quotients per mesh and seed, where both have a value and \
                 {other}'s is not 0.\n\n{quotients}"
            );
        }
    }
    report + &format_failures(table)
}

fn format_head(table: &Table) -> String {
    let n_meshes = distinct(table.rows.iter().filter(|row| is_read(table, row)).map(|row| &row.mesh)).len();
    let machines = distinct(table.rows.iter().map(|row| row.machine.as_str())).join("; ");
    let of_processes = |row: &&ResultRow| table.value(row, "whole_process") == Some(1.0);
    let tools = distinct(table.rows.iter().filter(of_processes).map(|row| row.method.as_str())).join(", ");
    let tools =
        if tools.is_empty() { tools } else { format!(" Times of {tools} are those of the whole process with files.") };
    format!(
        "# Evaluation\n\n{n_meshes} meshes, on {machines}. Cells are means over meshes and seeds, lower is better, the best \
         is bold. Results more than a tenth larger than the target, in vertices and in faces, are counted separately; a \
         method with mostly such results is not ranked. Figures are those of `rows.csv`.{tools}\n"
    )
}

fn is_read(table: &Table, row: &ResultRow) -> bool {
    table.value(row, "vertices_in").is_some()
}

fn method_lines(table: &Table) -> Vec<Line> {
    let line = |method: &str| {
        let rows: Vec<&ResultRow> = table.rows.iter().filter(|row| row.method == method).collect();
        let n_results = rows.iter().filter(|row| row.error.is_empty()).count();
        Line { is_ranked: 2 * count_too_large(table, &rows) <= n_results, ..Line::new([method]).with_method(method) }
    };
    table.methods().into_iter().map(line).collect()
}

fn count_too_large(table: &Table, rows: &[&ResultRow]) -> usize {
    let exceeds = |row: &ResultRow, out: &str, asked: &str| {
        table.value(row, out).zip(table.value(row, asked)).is_some_and(|(out, asked)| out > LARGER * asked)
    };
    let is_larger =
        |row: &&&ResultRow| exceeds(row, "vertices_out", "vertices_asked") && exceeds(row, "faces_out", "faces_asked");
    rows.iter().filter(is_larger).count()
}

// Counts results, readable cases and results that are too large: `28 of 30, 3 larger`.
fn count_results(table: &Table, rows: &[&ResultRow]) -> Cell {
    let n_cases = rows.iter().filter(|row| is_read(table, row)).count();
    let n_results = rows.iter().filter(|row| row.error.is_empty()).count();
    let larger = Some(count_too_large(table, rows)).filter(|n| *n > 0).map(|n| format!(", {n} larger"));
    format!("{n_results} of {n_cases}{}", larger.unwrap_or_default()).into()
}

// Columns of the figures that have values, with their units.
fn figure_columns(table: &Table) -> impl Iterator<Item = (&'static str, &'static str, f64)> {
    let has_values = |figure: &str| table.rows.iter().any(|row| table.value(row, figure).is_some());
    COLUMNS.into_iter().filter(move |(_, figure, _)| has_values(figure))
}

fn mean_table(table: &Table) -> TextTable {
    let sizes = [("vertices", "vertices_out"), ("faces", "faces_out")];
    let sizes = sizes.map(|(title, figure)| Column::of_figure(title, figure, 1.0, mean_digits));
    let figures = figure_columns(table)
        .map(|(title, figure, factor)| Column::of_figure(title, figure, factor, mean_digits).with_best());
    let columns: Vec<Column> =
        [Column::new("results", count_results)].into_iter().chain(sizes).chain(figures).collect();
    pivot(table, &["method"], &method_lines(table), &columns)
}

fn quotient_table(table: &Table, other: &str) -> TextTable {
    let title = |title: &'static str| title.split(',').next().unwrap_or_default();
    let columns: Vec<Column> = figure_columns(table)
        .map(|(name, figure, _)| Column::of_figure(title(name), &format!("/{figure}"), 1.0, median_digits))
        .collect();
    pivot(&table.with_quotients_over(other), &[&format!("method / {other}")], &method_lines(table), &columns)
}

fn format_failures(table: &Table) -> String {
    let failed: Vec<&ResultRow> = table.rows.iter().filter(|row| !row.error.is_empty()).collect();
    let who = |row: &ResultRow| if is_read(table, row) { row.method.clone() } else { "all".into() };
    let lines = distinct(failed.iter().map(|row| (who(row), &row.error))).into_iter().map(|(method, why)| {
        let rows: Vec<_> = failed.iter().filter(|row| row.error == *why && who(row) == method).collect();
        let ResultRow { mesh, ratio, seed, .. } = rows[0];
        let first = format!("{mesh}, ratio {ratio}, seed {seed}");
        [method, rows.len().to_string(), first, why.clone()].map(|text| text.replace('|', "\\|")).into()
    });
    let lines: Vec<Vec<String>> = lines.collect();
    if lines.is_empty() {
        return String::new();
    }
    let head = ["method", "cases", "first case", "reason"].map(String::from).into();
    format!("\n## Without a result\n\n{}", TextTable { head, lines }.markdown())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIGURES: [&str; 6] =
        ["vertices_in", "vertices_asked", "faces_asked", "vertices_out", "faces_out", "distance_mean"];

    fn table(n_better: f64) -> Table {
        let row = |mesh: &str, method: &str, n: f64, value: f64| {
            ResultRow::new(mesh, 0.1, method, &[1000.0, 100.0, 196.0, n, 2.0 * n, value])
        };
        let values = vec![Some(1000.0), Some(100.0), Some(196.0), None, None, None];
        let failed = ResultRow { error: "a | b".into(), values, ..row("b", "worse", 0.0, 0.0) };
        let better = ["a", "b"].map(|mesh| row(mesh, "better", n_better, if mesh == "a" { 1.0 } else { 3.0 }));
        Table::new(&FIGURES, [&better[..], &[row("a", "worse", 101.0, 2.5), failed]].concat())
    }

    #[test]
    fn means_have_quotients_below_and_failures_their_reason() {
        let page = format_report(&table(100.0), Some("better"));
        assert!(page.contains("| better | 2 of 2 | 100 | 200 | **2.00** |"), "{page}");
        assert!(page.contains("| worse | 1 of 2 | 101 | 202 | 2.50 |"), "{page}");
        assert!(page.contains("| method / better | distance |") && page.contains("| worse | 2.50 |"), "{page}");
        assert!(page.contains("| worse | 1 | b, ratio 0.1, seed 0 | a \\| b |"), "{page}");
        assert!(!page.contains("CD"), "columns without values stay out: {page}");
    }

    #[test]
    fn a_method_that_leaves_all_as_it_is_wins_nothing() {
        let page = format_report(&table(1000.0), None);
        assert!(page.contains("| better | 2 of 2, 2 larger | 1000 | 2000 | 2.00 |"), "{page}");
        assert!(page.contains("| worse | 1 of 2 | 101 | 202 | **2.50** |"), "{page}");
    }
}
