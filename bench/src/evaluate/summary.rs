//! Many rows as few numbers: means and medians over meshes and seeds, and quotients to one of the methods.

use std::collections::HashMap;

use serde::Serialize;

use super::{Row, Table};

const USUAL: &str = "qem";

/// What was measured, and where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Facts {
    /// Meshes that could be read.
    pub meshes: usize,
    /// Seeds of the sampling.
    pub seeds: Vec<u64>,
    /// Samples on each surface.
    pub samples: Vec<usize>,
    /// Timed runs of each method per case.
    pub runs: usize,
    /// Versions of this program.
    pub versions: Vec<String>,
    /// Processors, their cores, and threads for a method.
    pub machines: Vec<String>,
    /// Methods of which the whole process was timed.
    pub processes: Vec<String>,
}

/// What the rows say of how they were measured.
pub(super) fn facts(table: &Table) -> Facts {
    let rows = &table.rows;
    let machine =
        |row: &Row| format!("{}, {} cores, {} threads for a method", row.how.cpu, row.how.cores, row.how.threads);
    let processes = rows.iter().filter(|row| row.how.timed == "process").map(|row| row.method.clone());
    Facts {
        meshes: distinct(rows.iter().filter(|row| row.vertices_in > 0).map(|row| row.mesh.as_str())).len(),
        seeds: distinct(rows.iter().map(|row| row.seed)),
        samples: distinct(rows.iter().map(|row| row.how.samples)),
        runs: rows.iter().map(|row| row.how.runs).max().unwrap_or_default(),
        versions: distinct(rows.iter().map(|row| row.how.version.clone())),
        machines: distinct(rows.iter().map(machine)),
        processes: distinct(processes),
    }
}

/// What a column of the tables is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    /// A figure, by its place in the rows, times a factor.
    Figure(usize, f64),
    /// Seconds.
    Seconds,
    /// Vertices of the result.
    Vertices,
    /// Faces of the result.
    Faces,
    /// Faces of the result, in percent of the input's.
    ShareOfFaces,
}

impl Value {
    /// Of a row; `None` where there is none.
    pub fn of(self, row: &Row) -> Option<f64> {
        let has_result = row.error.is_empty();
        match self {
            Self::Figure(at, scale) => row.figures.get(at).copied().flatten().map(|value| scale * value),
            Self::Seconds => row.seconds,
            Self::Vertices => has_result.then_some(row.vertices_out as f64),
            Self::Faces => has_result.then_some(row.faces_out as f64),
            Self::ShareOfFaces => has_result.then_some(100.0 * row.faces_out as f64 / row.faces_in.max(1) as f64),
        }
    }
}

/// The values that are there.
pub(super) fn values(rows: &[&Row], value: Value) -> Vec<f64> {
    rows.iter().filter_map(|row| value.of(row)).collect()
}

/// Their mean; `None` of none.
pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Rows of a method and another's in the same case, mesh and seed.
pub(super) fn pairs<'a>(rows: &[&'a Row], others: &[&'a Row]) -> Vec<(&'a Row, &'a Row)> {
    let case = |row: &'a Row| (row.mesh.as_str(), row.seed);
    let mut of_case: HashMap<(&str, u64), &Row> = HashMap::new();
    for &other in others {
        of_case.entry(case(other)).or_insert(other);
    }
    rows.iter().filter_map(|&row| Some((row, *of_case.get(&case(row))?))).collect()
}

/// Values of a method divided by the other's; pairs where one has no value, or the other's is 0, have none.
pub(super) fn quotients(pairs: &[(&Row, &Row)], value: Value) -> Vec<f64> {
    let quotient = |(row, other): &(&Row, &Row)| Some(value.of(row)? / value.of(other)?);
    pairs.iter().filter_map(quotient).filter(|quotient| quotient.is_finite()).collect()
}

/// Cases with a result.
pub(super) fn n_results(rows: &[&Row]) -> usize {
    rows.iter().filter(|row| row.error.is_empty()).count()
}

/// Cases in which both have a result.
pub(super) fn n_both(pairs: &[(&Row, &Row)]) -> usize {
    pairs.iter().filter(|(row, other)| row.error.is_empty() && other.error.is_empty()).count()
}

/// Sizes asked for, from the smallest.
pub(super) fn ratios(table: &Table) -> Vec<f64> {
    let mut ratios: Vec<f64> = table.rows.iter().map(|row| row.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    ratios
}

/// Names of the methods, in the order of their first rows.
pub(super) fn methods(table: &Table) -> Vec<&str> {
    distinct(table.rows.iter().map(|row| row.method.as_str()))
}

/// The method that others are divided by where the caller names none; `None` where it takes no part.
pub(super) fn usual(methods: &[&str]) -> Option<&'static str> {
    methods.contains(&USUAL).then_some(USUAL)
}

/// Each once, in the order they come.
pub(super) fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for item in items {
        if !seen.contains(&item) {
            seen.push(item);
        }
    }
    seen
}

/// The rows of a method at a size.
pub(super) fn rows_of<'a>(table: &'a Table, ratio: f64, method: &str) -> Vec<&'a Row> {
    table.rows.iter().filter(|row| row.ratio == ratio && row.method == method).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str, method: &str, value: Option<f64>) -> Row {
        Row { mesh: mesh.into(), method: method.into(), figures: vec![value], ..Row::default() }
    }

    #[test]
    fn quotients_are_those_of_the_same_case() {
        let ours = [row("a", "x", Some(1.0)), row("b", "x", Some(9.0)), row("c", "x", Some(5.0))];
        let others = [row("b", "y", Some(3.0)), row("a", "y", Some(2.0)), row("c", "y", Some(0.0))];
        let [ours, others] = [&ours, &others].map(|rows| rows.iter().collect::<Vec<_>>());
        assert_eq!(quotients(&pairs(&ours, &others), Value::Figure(0, 1.0)), [0.5, 3.0]);
        assert!(quotients(&pairs(&ours, &[]), Value::Figure(0, 1.0)).is_empty());
    }

    #[test]
    fn what_is_missing_counts_for_nothing() {
        let rows = [row("a", "x", Some(1.0)), row("b", "x", None)];
        let rows: Vec<&Row> = rows.iter().collect();
        assert_eq!(mean(&values(&rows, Value::Figure(0, 2.0))), Some(2.0));
        assert_eq!(mean(&values(&rows, Value::Figure(1, 1.0))), None);
    }
}
