//! Means, medians and quotients of rows.

use std::collections::HashMap;

use serde::Serialize;

use super::{ResultRow, Table};

const DEFAULT_REFERENCE: &str = "qem";

/// Conditions of a table's rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Facts {
    /// Number of readable meshes.
    pub meshes: usize,
    /// Distinct seeds.
    pub seeds: Vec<u64>,
    /// Distinct numbers of sample points per surface.
    pub samples: Vec<usize>,
    /// Largest number of timed runs of a method in a case.
    pub runs: usize,
    /// Versions of this program.
    pub versions: Vec<String>,
    /// Distinct machines, each with processor, cores and threads.
    pub machines: Vec<String>,
    /// Methods whose whole process was timed.
    pub processes: Vec<String>,
}

pub(super) fn facts(table: &Table) -> Facts {
    let rows = &table.rows;
    let machine = |row: &ResultRow| {
        format!(
            "{}, {} cores, {} threads for a method",
            row.conditions.cpu, row.conditions.cores, row.conditions.threads
        )
    };
    let processes = rows.iter().filter(|row| row.conditions.timed == "process").map(|row| row.method.clone());
    Facts {
        meshes: distinct(rows.iter().filter(|row| row.vertices_in > 0).map(|row| row.mesh.as_str())).len(),
        seeds: distinct(rows.iter().map(|row| row.seed)),
        samples: distinct(rows.iter().map(|row| row.conditions.samples)),
        runs: rows.iter().map(|row| row.conditions.runs).max().unwrap_or_default(),
        versions: distinct(rows.iter().map(|row| row.conditions.version.clone())),
        machines: distinct(rows.iter().map(machine)),
        processes: distinct(processes),
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    /// Figure by its index in the table, multiplied by a factor.
    Figure(usize, f64),
    Seconds,
    Vertices,
    Faces,
    /// Number of faces in percent of the input's.
    ShareOfFaces,
}

impl Value {
    pub fn get(self, row: &ResultRow) -> Option<f64> {
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

pub(super) fn values(rows: &[&ResultRow], value: Value) -> Vec<f64> {
    rows.iter().filter_map(|row| value.get(row)).collect()
}

pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns pairs of rows of two methods with equal mesh and seed.
pub(super) fn pairs<'a>(rows: &[&'a ResultRow], others: &[&'a ResultRow]) -> Vec<(&'a ResultRow, &'a ResultRow)> {
    let case = |row: &'a ResultRow| (row.mesh.as_str(), row.seed);
    let mut of_case: HashMap<(&str, u64), &ResultRow> = HashMap::new();
    for &other in others {
        of_case.entry(case(other)).or_insert(other);
    }
    rows.iter().filter_map(|&row| Some((row, *of_case.get(&case(row))?))).collect()
}

pub(super) fn quotients(pairs: &[(&ResultRow, &ResultRow)], value: Value) -> Vec<f64> {
    let quotient = |(row, other): &(&ResultRow, &ResultRow)| Some(value.get(row)? / value.get(other)?);
    pairs.iter().filter_map(quotient).filter(|quotient| quotient.is_finite()).collect()
}

pub(super) fn n_results(rows: &[&ResultRow]) -> usize {
    rows.iter().filter(|row| row.error.is_empty()).count()
}

pub(super) fn n_both(pairs: &[(&ResultRow, &ResultRow)]) -> usize {
    pairs.iter().filter(|(row, other)| row.error.is_empty() && other.error.is_empty()).count()
}

pub(super) fn ratios(table: &Table) -> Vec<f64> {
    let mut ratios: Vec<f64> = table.rows.iter().map(|row| row.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    ratios
}

pub(super) fn methods(table: &Table) -> Vec<&str> {
    distinct(table.rows.iter().map(|row| row.method.as_str()))
}

pub(super) fn default_reference(methods: &[&str]) -> Option<&'static str> {
    methods.contains(&DEFAULT_REFERENCE).then_some(DEFAULT_REFERENCE)
}

pub(super) fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for item in items {
        if !seen.contains(&item) {
            seen.push(item);
        }
    }
    seen
}

pub(super) fn select_rows<'a>(table: &'a Table, ratio: f64, method: &str) -> Vec<&'a ResultRow> {
    table.rows.iter().filter(|row| row.ratio == ratio && row.method == method).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str, method: &str, value: Option<f64>) -> ResultRow {
        ResultRow { mesh: mesh.into(), method: method.into(), figures: vec![value], ..ResultRow::default() }
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
    fn missing_values_are_left_out() {
        let rows = [row("a", "x", Some(1.0)), row("b", "x", None)];
        let rows: Vec<&ResultRow> = rows.iter().collect();
        assert_eq!(mean(&values(&rows, Value::Figure(0, 2.0))), Some(2.0));
        assert_eq!(mean(&values(&rows, Value::Figure(1, 1.0))), None);
    }
}
