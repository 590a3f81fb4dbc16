//! Many rows as few numbers: means and medians over meshes and seeds, and quotients to one of the methods.

use super::{Row, Table};

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

/// Values of a method divided by another's in the same case, meshes and seeds; cases where one has no value, or the other's
/// is 0, have none.
pub(super) fn quotients(rows: &[&Row], others: &[&Row], value: Value) -> Vec<f64> {
    let quotient = |row: &&Row| Some(value.of(row)? / value.of(partner(row, others)?)?);
    rows.iter().filter_map(quotient).filter(|quotient| quotient.is_finite()).collect()
}

/// Cases in which both have a result.
pub(super) fn n_both(rows: &[&Row], others: &[&Row]) -> usize {
    let has_result = |row: &Row| row.error.is_empty();
    rows.iter().filter(|row| has_result(row) && partner(row, others).is_some_and(has_result)).count()
}

/// The row of the same mesh and seed.
fn partner<'a>(row: &Row, others: &[&'a Row]) -> Option<&'a Row> {
    others.iter().copied().find(|other| other.mesh == row.mesh && other.seed == row.seed)
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
        assert_eq!(quotients(&ours, &others, Value::Figure(0, 1.0)), [0.5, 3.0]);
        assert!(quotients(&ours, &[], Value::Figure(0, 1.0)).is_empty());
    }

    #[test]
    fn what_is_missing_counts_for_nothing() {
        let rows = [row("a", "x", Some(1.0)), row("b", "x", None)];
        let rows: Vec<&Row> = rows.iter().collect();
        assert_eq!(mean(&values(&rows, Value::Figure(0, 2.0))), Some(2.0));
        assert_eq!(mean(&values(&rows, Value::Figure(1, 1.0))), None);
    }
}
