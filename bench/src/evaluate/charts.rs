//! Charts of a table: a line of medians per method.

use super::run::median;
use super::summary::{Value, distinct, methods, ratios, select_rows, values};
use super::{ResultRow, Table};

/// A chart of lines on logarithmic axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// File name without extension.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// Horizontal axis label.
    pub x: &'static str,
    /// Vertical axis label.
    pub y: &'static str,
    /// Lines of the methods with points.
    pub lines: Vec<MethodLine>,
}

/// The line of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodLine {
    /// Method.
    pub method: String,
    /// Points from left to right.
    pub points: Vec<(f64, f64)>,
}

const DISTANCE: &str = "mean distance, % of the bounding box's diagonal";
const SECONDS: &str = "seconds";

/// Returns the charts that have points.
///
/// ```
/// use neural_mesh_bench::evaluate::{Table, charts};
/// assert!(charts(&Table::default()).is_empty());
/// ```
pub fn charts(table: &Table) -> Vec<Chart> {
    let at = table.figures.iter().position(|name| name == "distance_mean").unwrap_or(usize::MAX);
    let distance = Value::Figure(at, 1.0);
    let charts = [
        Chart {
            name: "error-size",
            title: "Error against size: medians over meshes and seeds, a point for each ratio",
            x: "faces of the result / faces of the input",
            y: DISTANCE,
            lines: lines_by_ratio(table, |rows| {
                (median(rows.iter().filter_map(share_of_faces).collect()), median_value(rows, distance))
            }),
        },
        Chart {
            name: "time-size",
            title: "Time against size: medians over ratios and seeds, a point for each size of input",
            x: "vertices of the input",
            y: SECONDS,
            lines: lines_by_input(table),
        },
        Chart {
            name: "error-time",
            title: "Error against time: medians over meshes and seeds, a point for each ratio",
            x: SECONDS,
            y: DISTANCE,
            lines: lines_by_ratio(table, |rows| (median_value(rows, Value::Seconds), median_value(rows, distance))),
        },
    ];
    charts.into_iter().filter(|chart| !chart.lines.is_empty()).collect()
}

fn median_value(rows: &[&ResultRow], value: Value) -> Option<f64> {
    median(values(rows, value))
}

fn share_of_faces(row: &&ResultRow) -> Option<f64> {
    Some(Value::Faces.get(row)? / row.faces_in.max(1) as f64)
}

fn lines_by_ratio(table: &Table, point: impl Fn(&[&ResultRow]) -> (Option<f64>, Option<f64>)) -> Vec<MethodLine> {
    let points = |method: &str| {
        let points = ratios(table).into_iter().map(|ratio| point(&select_rows(table, ratio, method)));
        points.filter_map(|(x, y)| Some((x?, y?))).collect()
    };
    lines(table, points)
}

fn lines_by_input(table: &Table) -> Vec<MethodLine> {
    let points = |method: &str| {
        let rows: Vec<&ResultRow> = table.rows.iter().filter(|row| row.method == method).collect();
        let mut sizes = distinct(rows.iter().map(|row| row.vertices_in));
        sizes.sort_unstable();
        let seconds = |size: usize| {
            median(rows.iter().filter(|row| row.vertices_in == size).filter_map(|row| row.seconds).collect())
        };
        sizes.into_iter().filter_map(|size| Some((size as f64, seconds(size)?))).collect()
    };
    lines(table, points)
}

fn lines(table: &Table, points: impl Fn(&str) -> Vec<(f64, f64)>) -> Vec<MethodLine> {
    let line = |method: &str| {
        let mut points = points(method);
        points.retain(|(x, y)| *x > 0.0 && *y > 0.0);
        (!points.is_empty()).then(|| MethodLine { method: method.into(), points })
    };
    methods(table).into_iter().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_medians_and_zeros_stay_out() {
        let row = |mesh: &str, ratio: f64, value: f64| ResultRow {
            mesh: mesh.into(),
            ratio,
            method: "x".into(),
            vertices_in: 100,
            faces_in: 200,
            faces_out: 20,
            seconds: Some(10.0 * value),
            figures: vec![Some(value)],
            ..ResultRow::default()
        };
        let rows = vec![row("a", 0.1, 1.0), row("b", 0.1, 2.0), row("c", 0.1, 6.0), row("a", 0.5, 0.0)];
        let charts = charts(&Table { figures: vec!["distance_mean".into()], rows });
        let points: Vec<_> = charts.iter().map(|chart| chart.lines[0].points.clone()).collect();
        assert_eq!(points, [vec![(0.1, 2.0)], vec![(100.0, 15.0)], vec![(20.0, 2.0)]]);
    }
}
