//! What is plotted of the rows: medians as points, a line for every method. Drawing them is the caller's.

use super::run::median;
use super::summary::{Value, distinct, methods, ratios, rows_of, values};
use super::{Row, Table};

/// A picture of lines, both axes logarithmic.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// A name for its file, without an ending.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// What the horizontal axis counts in.
    pub x: &'static str,
    /// What the vertical axis counts in.
    pub y: &'static str,
    /// The lines, one per method that has points.
    pub lines: Vec<Line>,
}

/// The line of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name of the method.
    pub method: String,
    /// Points from left to right, all coordinates above 0.
    pub points: Vec<(f64, f64)>,
}

const DISTANCE: &str = "mean distance, % of the bounding box's diagonal";
const SECONDS: &str = "seconds";

/// The pictures of a table: error against size, time against the size of the input, error against time. One without
/// points is left out.
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
            lines: by_ratio(table, |rows| {
                (median(rows.iter().filter_map(share_of_faces).collect()), of(rows, distance))
            }),
        },
        Chart {
            name: "time-size",
            title: "Time against size: medians over ratios and seeds, a point for each size of input",
            x: "vertices of the input",
            y: SECONDS,
            lines: by_input(table),
        },
        Chart {
            name: "error-time",
            title: "Error against time: medians over meshes and seeds, a point for each ratio",
            x: SECONDS,
            y: DISTANCE,
            lines: by_ratio(table, |rows| (of(rows, Value::Seconds), of(rows, distance))),
        },
    ];
    charts.into_iter().filter(|chart| !chart.lines.is_empty()).collect()
}

fn of(rows: &[&Row], value: Value) -> Option<f64> {
    median(values(rows, value))
}

fn share_of_faces(row: &&Row) -> Option<f64> {
    Some(Value::Faces.of(row)? / row.faces_in.max(1) as f64)
}

/// A point for each size asked for, in their order.
fn by_ratio(table: &Table, point: impl Fn(&[&Row]) -> (Option<f64>, Option<f64>)) -> Vec<Line> {
    let points = |method: &str| {
        let points = ratios(table).into_iter().map(|ratio| point(&rows_of(table, ratio, method)));
        points.filter_map(|(x, y)| Some((x?, y?))).collect()
    };
    lines(table, points)
}

/// A point for each size of input.
fn by_input(table: &Table) -> Vec<Line> {
    let points = |method: &str| {
        let rows: Vec<&Row> = table.rows.iter().filter(|row| row.method == method).collect();
        let mut sizes = distinct(rows.iter().map(|row| row.vertices_in));
        sizes.sort_unstable();
        let seconds = |size: usize| {
            median(rows.iter().filter(|row| row.vertices_in == size).filter_map(|row| row.seconds).collect())
        };
        sizes.into_iter().filter_map(|size| Some((size as f64, seconds(size)?))).collect()
    };
    lines(table, points)
}

fn lines(table: &Table, points: impl Fn(&str) -> Vec<(f64, f64)>) -> Vec<Line> {
    let line = |method: &str| {
        let mut points = points(method);
        points.retain(|(x, y)| *x > 0.0 && *y > 0.0);
        (!points.is_empty()).then(|| Line { method: method.into(), points })
    };
    methods(table).into_iter().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_medians_and_zeros_stay_out() {
        let row = |mesh: &str, ratio: f64, value: f64| Row {
            mesh: mesh.into(),
            ratio,
            method: "x".into(),
            vertices_in: 100,
            faces_in: 200,
            faces_out: 20,
            seconds: Some(10.0 * value),
            figures: vec![Some(value)],
            ..Row::default()
        };
        let rows = vec![row("a", 0.1, 1.0), row("b", 0.1, 2.0), row("c", 0.1, 6.0), row("a", 0.5, 0.0)];
        let charts = charts(&Table { figures: vec!["distance_mean".into()], rows });
        let points: Vec<_> = charts.iter().map(|chart| chart.lines[0].points.clone()).collect();
        assert_eq!(points, [vec![(0.1, 2.0)], vec![(100.0, 15.0)], vec![(20.0, 2.0)]]);
    }
}
