//! Table 1: means and the first quotients for the page, every figure for CSV.

use crate::evaluate::{FigureSummary, Overview, format_number};

use crate::measure::markdown::table;

/// Method by whose figures the others are divided.
pub const REFERENCE: &str = "qem";

// Title, name of the figure and factor of a column.
const COLUMNS: [(&str, &str, f64); 5] = [
    ("CD", "chamfer", 1e6),
    ("WA, %", "edges_without_two_faces", 1.0),
    ("LE", "laplacian_functions", 1.0),
    ("NE", "normal_error", 1.0),
    ("time, s", "seconds", 1.0),
];

/// Formats a table of means for each ratio; the least mean of a column is bold.
pub fn format_means(summary: &Overview) -> String {
    let head: Vec<&str> = ["method"].into_iter().chain(COLUMNS.map(|column| column.0)).collect();
    let section = |at: usize| {
        let least = COLUMNS.map(|(_, name, _)| {
            let means = (0..summary.methods.len()).filter_map(|method| cell(summary, at, method, name)?.mean);
            means.min_by(f64::total_cmp)
        });
        let row = |method: usize| {
            let cells = COLUMNS.iter().zip(least).map(|(&(_, name, scale), least)| {
                let mean = cell(summary, at, method, name).and_then(|cell| cell.mean);
                let shown = format_number(mean.map(|mean| scale * mean));
                if mean.is_some() && mean == least { format!("**{shown}**") } else { shown }
            });
            [summary.methods[method].clone()].into_iter().chain(cells).collect()
        };
        let rows: Vec<Vec<String>> = (0..summary.methods.len()).map(row).collect();
        format!("\n### Ratio {}\n\n{}", summary.ratios[at], table(&head, &rows))
    };
    (0..summary.ratios.len()).map(section).collect()
}

/// Formats the median quotients of figures over those of `qem`, at ratio number `at`.
pub fn format_quotients(summary: &Overview, at: usize) -> String {
    let head: Vec<String> =
        [format!("method / {REFERENCE}")].into_iter().chain(COLUMNS.map(|column| short(column.0))).collect();
    let row = |method: usize| {
        let quotient = |name: &str| format_number(cell(summary, at, method, name).and_then(|cell| cell.quotient));
        let cells = COLUMNS.iter().map(|column| quotient(column.1));
        [summary.methods[method].clone()].into_iter().chain(cells).collect()
    };
    table(&head, &(0..summary.methods.len()).map(row).collect::<Vec<Vec<String>>>())
}

/// Formats the median quotient of CD of a method at every ratio.
pub fn format_chamfer_quotients(summary: &Overview, method: &str) -> String {
    let method = summary.methods.iter().position(|other| other == method);
    let quotient = |at: usize| format_number(cell(summary, at, method?, COLUMNS[0].1)?.quotient).into();
    (0..summary.ratios.len()).filter_map(quotient).collect::<Vec<String>>().join(", ")
}

pub fn csv_head() -> Vec<String> {
    let of_column = |(title, _, _)| {
        let title = short(title);
        [format!("{title} mean"), format!("{title} median"), format!("{title} / {REFERENCE}"), "quotients".into()]
    };
    ["meshes", "ratio", "method", "results"]
        .map(String::from)
        .into_iter()
        .chain(COLUMNS.map(of_column).concat())
        .collect()
}

/// Returns a row of CSV for each ratio and method.
pub fn csv_rows(meshes: &str, summary: &Overview) -> Vec<Vec<String>> {
    let row = |(at, method): (usize, usize)| {
        let of = &summary.standings[at][method];
        let results = format!("{} of {}", of.results, of.cases);
        let head = [meshes.into(), summary.ratios[at].to_string(), summary.methods[method].clone(), results];
        let cells = COLUMNS.iter().flat_map(|&(_, name, scale)| {
            let cell = cell(summary, at, method, name);
            let [mean, median] = [cell.and_then(|cell| cell.mean), cell.and_then(|cell| cell.median)];
            let scaled = [mean, median].map(|value| format_number(value.map(|value| scale * value)));
            let n = cell.map_or(0, |cell| cell.n_quotients);
            scaled.into_iter().chain([format_number(cell.and_then(|cell| cell.quotient)), n.to_string()])
        });
        head.into_iter().chain(cells).collect()
    };
    let cases = (0..summary.ratios.len()).flat_map(|at| (0..summary.methods.len()).map(move |method| (at, method)));
    cases.map(row).collect()
}

fn cell<'a>(summary: &'a Overview, at: usize, method: usize, name: &str) -> Option<&'a FigureSummary> {
    let column = summary.columns.iter().position(|column| column.name == name)?;
    summary.standings[at][method].cells.get(column)
}

// Title of a column without its unit.
fn short(title: &str) -> String {
    title.split(',').next().unwrap_or_default().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{ResultRow, Table, overview};

    #[test]
    fn the_page_has_means_and_the_csv_all_figures() {
        let row = |mesh: &str, method: &str, chamfer| ResultRow {
            mesh: mesh.into(),
            ratio: 0.1,
            method: method.into(),
            vertices_in: 9,
            seconds: Some(0.5),
            figures: vec![Some(chamfer)],
            ..ResultRow::default()
        };
        let rows = vec![row("a", "qem", 1e-6), row("b", "qem", 3e-6), row("a", "paper", 4e-6), row("b", "paper", 6e-6)];
        let summary = overview(&Table { figures: vec!["chamfer".into()], rows }, Some(REFERENCE));
        let means = format_means(&summary);
        assert!(
            means.contains("### Ratio 0.1") && means.contains("| qem | **2.00** | - | - | - | **0.500** |"),
            "{means}"
        );
        assert!(means.contains("| paper | 5.00 | - |"), "{means}");
        assert!(format_quotients(&summary, 0).contains("| paper | 3.00 | - | - | - | 1.00 |"));
        assert_eq!(format_chamfer_quotients(&summary, "paper"), "3.00");
        let rows = csv_rows("two", &summary);
        assert_eq!(rows[1][..8], ["two", "0.1", "paper", "2 of 2", "5.00", "5.00", "3.00", "2"]);
        assert_eq!((rows[1].len(), csv_head().len()), (24, 24));
    }
}
