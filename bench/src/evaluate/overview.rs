//! Summaries of a table of results.

use std::collections::HashMap;

use serde::Serialize;

use super::run::{empty_figures, median};
use super::summary::{
    Facts, Value, default_reference, distinct, facts, mean, methods, n_both, n_results, pairs, quotients, ratios,
    select_rows, values,
};
use super::{ResultRow, Table};

// Largest numbers of values and meshes in a summary; further meshes are left out.
const MOST_VALUES: usize = 3_000_000;
const MOST_MESHES: usize = 20_000;

/// The summary of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overview {
    /// Conditions of the measurements.
    pub facts: Facts,
    /// Reference method of the quotients.
    pub relative_to: Option<String>,
    /// Methods.
    pub methods: Vec<String>,
    /// Ratios, ascending.
    pub ratios: Vec<f64>,
    /// Columns, sizes and seconds first; figures without any value are left out.
    pub columns: Vec<Column>,
    /// Summaries of the methods, n_ratios x n_methods.
    pub standings: Vec<Vec<MethodSummary>>,
    /// Failures, grouped by method and reason.
    pub failures: Vec<Failures>,
}

/// A column of the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// Name of the figure in the table.
    pub name: String,
    /// Unit of the figure.
    pub unit: String,
    /// Description of the figure.
    pub about: String,
    #[serde(skip)]
    value: Value,
}

/// The summary of a method at a ratio; a case is a mesh with a seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Number of cases with a result.
    pub results: usize,
    /// Number of cases whose input mesh could be read.
    pub cases: usize,
    /// Number of cases with results of both this and the reference method.
    pub both: usize,
    /// One summary per column.
    pub cells: Vec<FigureSummary>,
}

/// A figure of a method at a ratio.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FigureSummary {
    /// Mean of the figure over the cases with a value.
    pub mean: Option<f64>,
    /// Median of the figure over the cases with a value.
    pub median: Option<f64>,
    /// Number of cases with a value.
    pub n: usize,
    /// Median over the cases of this method's value divided by the reference method's.
    pub quotient: Option<f64>,
    /// Number of quotients.
    pub n_quotients: usize,
}

/// Rows of the table that failed for the same reason.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failures {
    /// Method that failed; `all` if the input mesh could not be read.
    pub method: String,
    /// Number of rows with this failure; an unreadable mesh has one for each method.
    pub cases: usize,
    /// Mesh, ratio and seed of the first of these rows.
    pub first: String,
    /// Reason of the failure.
    pub why: String,
}

/// Summarises a table; the reference method is `relative_to`, by default `qem` if evaluated.
///
/// ```
/// use neural_mesh_bench::evaluate::{ResultRow, Table, overview};
/// let row = ResultRow { method: "qem".into(), vertices_in: 9, figures: vec![Some(0.5)], ..ResultRow::default() };
/// let overview = overview(&Table { figures: vec!["chamfer".into()], rows: vec![row] }, None);
/// assert_eq!(overview.standings[0][0].cells.last().unwrap().median, Some(0.5));
/// ```
pub fn overview(table: &Table, relative_to: Option<&str>) -> Overview {
    let methods = methods(table);
    let other = relative_to.or_else(|| default_reference(&methods));
    let columns = columns(table);
    let standing = |ratio: f64, method: &str| {
        let rows = select_rows(table, ratio, method);
        let others = other.map(|other| select_rows(table, ratio, other)).unwrap_or_default();
        summarize_method(&rows, &others, &columns)
    };
    let at = |ratio: f64| methods.iter().map(|method| standing(ratio, method)).collect();
    let ratios = ratios(table);
    Overview {
        facts: facts(table),
        relative_to: other.map(String::from),
        standings: ratios.iter().map(|&ratio| at(ratio)).collect(),
        failures: failures(table),
        methods: methods.iter().map(|method| method.to_string()).collect(),
        ratios,
        columns,
    }
}

fn columns(table: &Table) -> Vec<Column> {
    let explained = empty_figures();
    let size = |name: &str, unit: &str, about: &str, value| Column {
        name: name.into(),
        unit: unit.into(),
        about: about.into(),
        value,
    };
    let sizes = [
        size("faces", "", "faces of the result", Value::Faces),
        size("vertices", "", "vertices of the result", Value::Vertices),
        size("share_of_faces", "%", "faces of the result in percent of the input's", Value::ShareOfFaces),
        size("seconds", "s", "median time of the method's runs", Value::Seconds),
    ];
    let figure = |(at, name): (usize, &String)| {
        let (unit, about) = explained.iter().find(|figure| figure.name == name).map_or(("", ""), |f| (f.unit, f.about));
        size(name, unit, about, Value::Figure(at, 1.0))
    };
    let mut columns: Vec<Column> = sizes.into_iter().chain(table.figures.iter().enumerate().map(figure)).collect();
    columns.retain(|column| table.rows.iter().any(|row| column.value.get(row).is_some()));
    columns
}

fn summarize_method(rows: &[&ResultRow], others: &[&ResultRow], columns: &[Column]) -> MethodSummary {
    let pairs = pairs(rows, others);
    let cell = |&Column { value, .. }: &Column| {
        let (quotients, values) = (quotients(&pairs, value), values(rows, value));
        let (n, n_quotients) = (values.len(), quotients.len());
        FigureSummary { mean: mean(&values), median: median(values), n, quotient: median(quotients), n_quotients }
    };
    MethodSummary {
        results: n_results(rows),
        cases: rows.iter().filter(|row| row.vertices_in > 0).count(),
        both: n_both(&pairs),
        cells: columns.iter().map(cell).collect(),
    }
}

pub(super) fn failures(table: &Table) -> Vec<Failures> {
    let failed: Vec<&ResultRow> = table.rows.iter().filter(|row| !row.error.is_empty()).collect();
    let who = |row: &ResultRow| if row.vertices_in == 0 { "all" } else { &row.method }.to_string();
    let reasons = distinct(failed.iter().map(|row| (who(row), row.error.clone())));
    let failures = |(method, why): (String, String)| {
        let mut rows = failed.iter().filter(|row| row.error == why && who(row) == method);
        let first = rows.clone().next().map(|row| format!("{}, ratio {}, seed {}", row.mesh, row.ratio, row.seed));
        Failures { cases: rows.by_ref().count(), first: first.unwrap_or_default(), method, why }
    };
    reasons.into_iter().map(failures).collect()
}

/// Figures of every mesh, as medians over the seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Points<'a> {
    /// Name, vertices and faces of each mesh.
    pub meshes: Vec<(&'a str, usize, usize)>,
    /// Number of meshes left out.
    pub n_left_out: usize,
    /// Medians, one list per column: n_ratios x n_methods x n_meshes.
    pub values: Vec<Vec<Option<f32>>>,
}

/// Returns the figures of every mesh of a table.
///
/// ```
/// use neural_mesh_bench::evaluate::{ResultRow, Table, overview, points};
/// let row = ResultRow { mesh: "a.ply".into(), vertices_in: 9, figures: vec![Some(0.5)], ..ResultRow::default() };
/// let table = Table { figures: vec!["chamfer".into()], rows: vec![row] };
/// let points = points(&table, &overview(&table, None));
/// assert_eq!((points.meshes[0].0, points.values.last().unwrap()[0]), ("a.ply", Some(0.5)));
/// ```
pub fn points<'a>(table: &'a Table, overview: &Overview) -> Points<'a> {
    let Overview { methods, ratios, columns, .. } = overview;
    let mut seen = HashMap::new();
    let read = table.rows.iter().filter(|row| row.vertices_in > 0);
    let all: Vec<&ResultRow> = read.filter(|row| seen.insert(row.mesh.as_str(), ()).is_none()).collect();
    let n_lines = ratios.len() * methods.len();
    let step = (all.len() * n_lines * columns.len()).div_ceil(MOST_VALUES).max(all.len().div_ceil(MOST_MESHES)).max(1);
    let meshes: Vec<&ResultRow> = all.iter().copied().step_by(step).collect();
    let number: HashMap<&str, usize> = meshes.iter().enumerate().map(|(at, row)| (row.mesh.as_str(), at)).collect();
    let mut select_rows: Vec<Vec<&ResultRow>> = vec![Vec::new(); n_lines * meshes.len()];
    for row in &table.rows {
        let line =
            ratios.iter().position(|ratio| *ratio == row.ratio).zip(methods.iter().position(|m| *m == row.method));
        if let (Some((ratio, method)), Some(mesh)) = (line, number.get(row.mesh.as_str())) {
            select_rows[(ratio * methods.len() + method) * meshes.len() + mesh].push(row);
        }
    }
    let of =
        |column: &Column| select_rows.iter().map(|rows| median(values(rows, column.value)).map(|x| x as f32)).collect();
    Points {
        n_left_out: all.len() - meshes.len(),
        values: columns.iter().map(of).collect(),
        meshes: meshes.iter().map(|row| (row.mesh.as_str(), row.vertices_in, row.faces_in)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str, method: &str, seed: u64, value: f64) -> ResultRow {
        ResultRow {
            mesh: mesh.into(),
            ratio: 0.1,
            seed,
            method: method.into(),
            vertices_in: 10,
            faces_in: 20,
            faces_out: 5,
            seconds: Some(value),
            figures: vec![Some(value), None],
            ..ResultRow::default()
        }
    }

    fn table() -> Table {
        let failed = ResultRow { error: "alas".into(), seconds: None, figures: vec![None; 2], ..row("b", "x", 0, 0.0) };
        let rows = vec![
            row("a", "qem", 0, 2.0),
            row("a", "x", 0, 1.0),
            row("a", "x", 1, 3.0),
            row("b", "qem", 0, 4.0),
            failed,
        ];
        Table { figures: vec!["distance_mean".into(), "chamfer".into()], rows }
    }

    #[test]
    fn every_figure_with_values_has_its_mean_median_and_quotient() {
        let found = overview(&table(), None);
        let names: Vec<&str> = found.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["faces", "vertices", "share_of_faces", "seconds", "distance_mean"]);
        let x = &found.standings[0][1];
        assert_eq!((found.relative_to.as_deref(), x.results, x.cases, x.both), (Some("qem"), 2, 3, 1));
        let distance = FigureSummary { mean: Some(2.0), median: Some(2.0), n: 2, quotient: Some(0.5), n_quotients: 1 };
        assert_eq!(x.cells.last(), Some(&distance));
        assert_eq!(x.cells[2].median, Some(25.0));
        let failed =
            Failures { method: "x".into(), cases: 1, first: "b, ratio 0.1, seed 0".into(), why: "alas".into() };
        assert_eq!(found.failures, [failed]);
        assert_eq!(overview(&table(), Some("x")).standings[0][0].cells[4].quotient, Some(2.0));
    }

    #[test]
    fn a_mesh_is_a_point_of_the_median_of_its_seeds() {
        let table = table();
        let found = points(&table, &overview(&table, None));
        assert_eq!(found.meshes, [("a", 10, 20), ("b", 10, 20)]);
        assert_eq!(found.values[4], [Some(2.0), Some(4.0), Some(2.0), None]);
    }

    #[test]
    fn of_too_many_meshes_some_are_left_out() {
        let rows = (0..2 * MOST_MESHES + 2).map(|mesh| row(&mesh.to_string(), "x", 0, 1.0)).collect();
        let table = Table { figures: vec!["distance_mean".into(), "chamfer".into()], rows };
        let found = points(&table, &overview(&table, None));
        assert!(found.meshes.len() <= MOST_MESHES && found.meshes.len() + found.n_left_out == 2 * MOST_MESHES + 2);
        assert_eq!(found.values[0].len(), found.meshes.len());
    }
}
