//! The rows as Markdown tables.

use std::fmt::Write;

use super::overview::{self, Failures};
use super::run::{empty_figures, median};
use super::summary::{self, Facts, Value, facts, mean, methods, n_results, ratios, select_rows, values};
use super::{ResultRow, Table};
use neural_mesh::metrics::Figure;

// Title, figure and factor of a column.
type TableColumn = (&'static str, &'static str, f64);

const PAPER: [TableColumn; 4] = [
    ("CD", "chamfer", 1e6),
    ("WA, %", "edges_without_two_faces", 1.0),
    ("LE", "laplacian_functions", 1.0),
    ("NE", "normal_error", 1.0),
];

const MORE: [TableColumn; 8] = [
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

struct ShownColumn {
    title: &'static str,
    value: Value,
}

pub(super) fn make_page(table: &Table, relative_to: Option<&str>) -> String {
    let mut page = format_head(table);
    write_section(&mut page, table, "As in the paper's Table 1", &shown_columns(table, &PAPER, true), relative_to);
    write_section(&mut page, table, "More of the same results", &shown_columns(table, &MORE, false), relative_to);
    write_failures(&mut page, table);
    page
}

fn shown_columns(table: &Table, columns: &[TableColumn], with_time: bool) -> Vec<ShownColumn> {
    let place = |name: &str| table.figures.iter().position(|figure| figure == name);
    let figure =
        |&(title, name, scale): &TableColumn| Some(ShownColumn { title, value: Value::Figure(place(name)?, scale) });
    let time = ShownColumn { title: "time, s", value: Value::Seconds };
    let sizes =
        [("vertices", Value::Vertices), ("faces", Value::Faces)].map(|(title, value)| ShownColumn { title, value });
    let mut shown: Vec<ShownColumn> = columns.iter().filter_map(figure).collect();
    if with_time {
        shown.push(time);
    } else {
        shown.splice(0..0, sizes);
    }
    shown.retain(|column| table.rows.iter().any(|row| column.value.get(row).is_some()));
    shown
}

fn format_head(table: &Table) -> String {
    let Facts { meshes, seeds, samples, runs, versions, machines, processes } = facts(table);
    let [seeds, samples] = [join(&seeds), join(&samples)];
    let [versions, machines, processes] = [versions.join(", "), machines.join("; "), processes.join(", ")];
    let mut head = format!(
        "# Evaluation\n\n{meshes} meshes, seeds {seeds}, {samples} samples on each surface. neural-mesh {versions}. Times: \
         median of {runs} runs on {machines}.\n\nCells are *mean / median* over meshes and seeds; the best mean is \
         bold, lower is better. A number in brackets is the number of results with a value, where some have none. Results \
         more than a tenth larger than the target, in vertices and in faces, are counted separately; a method with mostly such \
         results is not ranked. Distances are in percent of the bounding box's diagonal.\n\n"
    );
    let explained = empty_figures();
    for (title, name, scale) in PAPER.iter().chain(&MORE).filter(|column| has_values(table, column.1)) {
        if let Some(figure) = explained.iter().find(|figure| figure.name == *name) {
            let _ = writeln!(head, "- *{title}* (`{name}`): {}", describe_figure(figure, *scale));
        }
    }
    let _ = writeln!(head, "- *time* (`seconds`): of the method alone, without reading and writing files");
    if !processes.is_empty() {
        let _ = writeln!(head, "  ({processes}: the whole process, with reading and writing)");
    }
    head
}

fn join(items: &[impl ToString]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

fn has_values(table: &Table, name: &str) -> bool {
    let at = table.figures.iter().position(|figure| figure == name);
    at.is_some_and(|at| table.rows.iter().any(|row| row.figures.get(at).copied().flatten().is_some()))
}

fn describe_figure(figure: &Figure, scale: f64) -> String {
    let unit = match (figure.unit, scale) {
        ("", 1.0) => String::new(),
        (unit, 1.0) => format!("; {unit}"),
        (unit, scale) => format!("; {:e} {unit}", 1.0 / scale),
    };
    format!("{}{unit}", figure.about)
}

fn write_section(page: &mut String, table: &Table, title: &str, columns: &[ShownColumn], relative_to: Option<&str>) {
    let _ = writeln!(page, "\n## {title}");
    for ratio in ratios(table) {
        let _ = writeln!(page, "\n### Ratio {ratio}\n");
        let header: Vec<&str> = columns.iter().map(|column| column.title).collect();
        let _ = writeln!(page, "| method | results | {} |", header.join(" | "));
        let _ = writeln!(page, "|---|---|{}", "---|".repeat(columns.len()));
        let best_of_all: Vec<Option<f64>> =
            columns.iter().map(|column| best_mean(table, ratio, column.value)).collect();
        for method in methods(table) {
            let rows = select_rows(table, ratio, method);
            let best = |best: &Option<f64>| best.filter(|_| is_ranked(&rows));
            let cells =
                columns.iter().zip(&best_of_all).map(|(column, of_all)| format_cell(&rows, column.value, best(of_all)));
            let cells: Vec<String> = cells.collect();
            let _ = writeln!(page, "| {method} | {} | {} |", format_results(&rows), cells.join(" | "));
        }
        if let Some(other) = relative_to {
            write_quotients(page, table, ratio, columns, other);
        }
    }
}

fn write_quotients(page: &mut String, table: &Table, ratio: f64, columns: &[ShownColumn], other: &str) {
    let header: Vec<&str> = columns.iter().map(|column| column.title.split(',').next().unwrap_or_default()).collect();
    let _ = writeln!(
        page,
        "\nRelative to {other}: medians of the quotients per mesh and seed, without cases where {other} has 0 (in brackets: \
         the number of quotients, where some cases have none).\n"
    );
    let _ = writeln!(page, "| method / {other} | {} |", header.join(" | "));
    let _ = writeln!(page, "|---|{}", "---|".repeat(columns.len()));
    let others = select_rows(table, ratio, other);
    for method in methods(table) {
        let rows = select_rows(table, ratio, method);
        let pairs = summary::pairs(&rows, &others);
        let n_both = summary::n_both(&pairs);
        let cells = columns.iter().map(|column| {
            let quotients = summary::quotients(&pairs, column.value);
            let fewer = format_count(quotients.len(), n_both);
            format!("{}{fewer}", format_number(median(quotients)))
        });
        let _ = writeln!(page, "| {method} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
}

fn format_results(rows: &[&ResultRow]) -> String {
    let n_cases = rows.iter().filter(|row| row.vertices_in > 0).count();
    // The cell counts results, readable cases and results that are too large: `28 of 30, 3 larger`.
    let larger = Some(count_too_large(rows)).filter(|n| *n > 0).map(|n| format!(", {n} larger")).unwrap_or_default();
    format!("{} of {n_cases}{larger}", n_results(rows))
}

fn count_too_large(rows: &[&ResultRow]) -> usize {
    let is_larger = |n: usize, asked: usize| n as f64 > LARGER * asked as f64;
    let larger = |row: &&&ResultRow| {
        is_larger(row.vertices_out, row.vertices_asked) && is_larger(row.faces_out, row.faces_asked)
    };
    rows.iter().filter(larger).count()
}

fn is_ranked(rows: &[&ResultRow]) -> bool {
    2 * count_too_large(rows) <= n_results(rows)
}

fn best_mean(table: &Table, ratio: f64, value: Value) -> Option<f64> {
    if matches!(value, Value::Vertices | Value::Faces) {
        return None;
    }
    let of_methods = methods(table).into_iter().map(|method| select_rows(table, ratio, method));
    let asked = of_methods.filter(|rows| is_ranked(rows));
    asked.filter_map(|rows| mean(&values(&rows, value))).min_by(f64::total_cmp)
}

fn format_cell(rows: &[&ResultRow], value: Value, best: Option<f64>) -> String {
    let values = values(rows, value);
    let mean = mean(&values);
    if mean.is_none() {
        return "-".into();
    }
    let fewer = format_count(values.len(), n_results(rows));
    let [shown, middle] = [mean, median(values)].map(format_number);
    if mean == best { format!("**{shown}** / {middle}{fewer}") } else { format!("{shown} / {middle}{fewer}") }
}

fn format_count(n_values: usize, n_results: usize) -> String {
    if (1..n_results).contains(&n_values) { format!(" ({n_values})") } else { String::new() }
}

/// Formats a number with three significant digits.
pub(crate) fn format_number(value: Option<f64>) -> String {
    let Some(value) = value else { return "-".into() };
    let size = value.abs();
    if size == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.2e}");
    }
    let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

fn write_failures(page: &mut String, table: &Table) {
    let failures = overview::failures(table);
    if failures.is_empty() {
        return;
    }
    let _ = writeln!(page, "\n## Without a result\n\n| method | cases | first case | reason |\n|---|---|---|---|");
    for Failures { method, cases, first, why } in failures {
        let [first, why] = [first, why].map(|text| text.replace('|', "\\|"));
        let _ = writeln!(page, "| {method} | {cases} | {first} | {why} |");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let row = |mesh: &str, method: &str, value: f64| ResultRow {
            mesh: mesh.into(),
            ratio: 0.1,
            method: method.into(),
            vertices_in: 10,
            seconds: Some(value),
            figures: vec![Some(value)],
            ..ResultRow::default()
        };
        let failed = ResultRow { error: "a | b".into(), seconds: None, figures: vec![None], ..row("b", "worse", 0.0) };
        let rows = vec![row("a", "better", 1.0), row("a", "worse", 2.0), row("b", "better", 3.0), failed];
        Table { figures: vec!["distance_mean".into()], rows }
    }

    #[test]
    fn means_stand_beside_medians_and_quotients_below() {
        let page = make_page(&table(), Some("better"));
        assert!(page.contains("| better | 2 of 2 | **2.00** / 2.00 |"), "{page}");
        assert!(page.contains("| worse | 1 of 2 | **2.00** / 2.00 |"), "{page}");
        assert!(page.contains("| method / better | time |") && page.contains("| worse | 2.00 |"), "{page}");
        assert!(page.contains("| worse | 1 | b, ratio 0.1, seed 0 | a \\| b |"), "{page}");
        assert!(!page.contains("CD |"), "columns without values stay out: {page}");
    }

    #[test]
    fn a_method_that_leaves_all_as_it_is_wins_nothing() {
        let mut table = table();
        for row in &mut table.rows {
            (row.vertices_asked, row.faces_asked) = (100, 196);
            let n = if row.method == "better" { 1000 } else { 101 };
            (row.vertices_out, row.faces_out) = if row.error.is_empty() { (n, 2 * n) } else { (0, 0) };
        }
        let page = make_page(&table, None);
        assert!(page.contains("| better | 2 of 2, 2 larger |") && page.contains("| worse | 1 of 2 |"), "{page}");
        assert!(page.contains("**2.00** / 2.00 |") && page.matches("**").count() == 2 * 2, "{page}");
    }

    #[test]
    fn means_and_quotients_of_fewer_cases_say_of_how_many() {
        let mut table = table();
        table.rows.pop();
        table.rows[2].figures = vec![None];
        table.rows.push(ResultRow { mesh: "b".into(), figures: vec![Some(5.0)], ..table.rows[1].clone() });
        let page = make_page(&table, Some("better"));
        assert!(page.contains("| better | 2 of 2 | 0 / 0 | 0 / 0 | **1.00** / 1.00 (1) |"), "{page}");
        assert!(page.contains("| worse | - | - | 2.00 (1) |"), "{page}");
        table.rows[0].figures = vec![Some(0.0)];
        assert!(self::make_page(&table, Some("better")).contains("| worse | - | - | - |"), "nothing is divided by 0");
    }

    #[test]
    fn numbers_have_three_digits() {
        let numbers = [0.0, 1.0, 0.0123456, 123.456, 123456.0, 1e-7, -2.5].map(|value| format_number(Some(value)));
        assert_eq!(numbers, ["0", "1.00", "0.0123", "123", "123456", "1.00e-7", "-2.50"]);
        assert_eq!(format_number(None), "-");
    }
}
