//! The rows as numbers to sort and to plot: every figure for each size and method, what failed, a point for each mesh.

use std::collections::HashMap;

use serde::Serialize;

use super::run::{figures, median};
use super::summary::{
    Facts, Value, distinct, facts, mean, methods, n_both, n_results, pairs, quotients, ratios, rows_of, usual, values,
};
use super::{Row, Table};

/// Values of all points at most; with more, meshes are left out.
const MOST_VALUES: usize = 3_000_000;
/// Meshes that have points at most.
const MOST_MESHES: usize = 20_000;

/// A table of rows in few numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overview {
    /// What was measured, and where.
    pub facts: Facts,
    /// The method that the others are divided by.
    pub relative_to: Option<String>,
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Sizes asked for, from the smallest.
    pub ratios: Vec<f64>,
    /// The figures that have values, sizes and seconds first.
    pub columns: Vec<Column>,
    /// How each method stands, n_ratios x n_methods.
    pub standings: Vec<Vec<Standing>>,
    /// What has no result.
    pub failures: Vec<Failures>,
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// Its name, as in the table of rows.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub about: String,
    #[serde(skip)]
    value: Value,
}

/// A method at a size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// Cases with a result.
    pub results: usize,
    /// Cases whose mesh could be read.
    pub cases: usize,
    /// Cases in which the method that it is divided by has a result as well.
    pub both: usize,
    /// One for each column.
    pub cells: Vec<Cell>,
}

/// A figure of a method at a size, over meshes and seeds; nothing where no case has a value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Mean over the cases that have a value.
    pub mean: Option<f64>,
    /// Their median.
    pub median: Option<f64>,
    /// Their number.
    pub n: usize,
    /// Median of the quotients to the other method in the same case.
    pub quotient: Option<f64>,
    /// Number of those.
    pub n_quotients: usize,
}

/// Cases that have no result for the same reason.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failures {
    /// The method; `all` for meshes that could not be read.
    pub method: String,
    /// Number of the cases.
    pub cases: usize,
    /// The first of them.
    pub first: String,
    /// The reason.
    pub why: String,
}

/// Puts a table of rows together. Others are divided by `relative_to`, or by the usual method where it takes part.
///
/// ```
/// use neural_mesh_bench::evaluate::{Row, Table, overview};
/// let row = Row { method: "qem".into(), vertices_in: 9, figures: vec![Some(0.5)], ..Row::default() };
/// let overview = overview(&Table { figures: vec!["chamfer".into()], rows: vec![row] }, None);
/// assert_eq!(overview.standings[0][0].cells.last().unwrap().median, Some(0.5));
/// ```
pub fn overview(table: &Table, relative_to: Option<&str>) -> Overview {
    let methods = methods(table);
    let other = relative_to.or_else(|| usual(&methods));
    let columns = columns(table);
    let standing = |ratio: f64, method: &str| {
        let rows = rows_of(table, ratio, method);
        let others = other.map(|other| rows_of(table, ratio, other)).unwrap_or_default();
        standing(&rows, &others, &columns)
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

/// Sizes, seconds and the figures of which there is any value.
fn columns(table: &Table) -> Vec<Column> {
    let explained = figures();
    let size = |name: &str, unit: &str, about: &str, value| Column {
        name: name.into(),
        unit: unit.into(),
        about: about.into(),
        value,
    };
    let sizes = [
        size("faces", "", "faces of the result", Value::Faces),
        size("vertices", "", "vertices of the result", Value::Vertices),
        size("share_of_faces", "%", "faces of the result, of those of the input", Value::ShareOfFaces),
        size("seconds", "s", "time of the method, the median of its runs", Value::Seconds),
    ];
    let figure = |(at, name): (usize, &String)| {
        let (unit, about) = explained.iter().find(|figure| figure.name == name).map_or(("", ""), |f| (f.unit, f.about));
        size(name, unit, about, Value::Figure(at, 1.0))
    };
    let mut columns: Vec<Column> = sizes.into_iter().chain(table.figures.iter().enumerate().map(figure)).collect();
    columns.retain(|column| table.rows.iter().any(|row| column.value.of(row).is_some()));
    columns
}

fn standing(rows: &[&Row], others: &[&Row], columns: &[Column]) -> Standing {
    let pairs = pairs(rows, others);
    let cell = |&Column { value, .. }: &Column| {
        let (quotients, values) = (quotients(&pairs, value), values(rows, value));
        let (n, n_quotients) = (values.len(), quotients.len());
        Cell { mean: mean(&values), median: median(values), n, quotient: median(quotients), n_quotients }
    };
    Standing {
        results: n_results(rows),
        cases: rows.iter().filter(|row| row.vertices_in > 0).count(),
        both: n_both(&pairs),
        cells: columns.iter().map(cell).collect(),
    }
}

/// What has no result, each reason once.
pub(super) fn failures(table: &Table) -> Vec<Failures> {
    let failed: Vec<&Row> = table.rows.iter().filter(|row| !row.error.is_empty()).collect();
    let who = |row: &Row| if row.vertices_in == 0 { "all" } else { &row.method }.to_string();
    let reasons = distinct(failed.iter().map(|row| (who(row), row.error.clone())));
    let failures = |(method, why): (String, String)| {
        let mut rows = failed.iter().filter(|row| row.error == why && who(row) == method);
        let first = rows.clone().next().map(|row| format!("{}, ratio {}, seed {}", row.mesh, row.ratio, row.seed));
        Failures { cases: rows.by_ref().count(), first: first.unwrap_or_default(), method, why }
    };
    reasons.into_iter().map(failures).collect()
}

/// Every figure of every mesh, the median over the seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Points<'a> {
    /// Name, vertices and faces of each mesh.
    pub meshes: Vec<(&'a str, usize, usize)>,
    /// Meshes that are left out because there are too many.
    pub n_left_out: usize,
    /// For each column n_ratios x n_methods x n_meshes values, row by row.
    pub values: Vec<Vec<Option<f32>>>,
}

/// The points of an overview of these rows.
///
/// ```
/// use neural_mesh_bench::evaluate::{Row, Table, overview, points};
/// let row = Row { mesh: "a.ply".into(), vertices_in: 9, figures: vec![Some(0.5)], ..Row::default() };
/// let table = Table { figures: vec!["chamfer".into()], rows: vec![row] };
/// let points = points(&table, &overview(&table, None));
/// assert_eq!((points.meshes[0].0, points.values.last().unwrap()[0]), ("a.ply", Some(0.5)));
/// ```
pub fn points<'a>(table: &'a Table, overview: &Overview) -> Points<'a> {
    let Overview { methods, ratios, columns, .. } = overview;
    let mut seen = HashMap::new();
    let read = table.rows.iter().filter(|row| row.vertices_in > 0);
    let all: Vec<&Row> = read.filter(|row| seen.insert(row.mesh.as_str(), ()).is_none()).collect();
    let n_lines = ratios.len() * methods.len();
    let step = (all.len() * n_lines * columns.len()).div_ceil(MOST_VALUES).max(all.len().div_ceil(MOST_MESHES)).max(1);
    let meshes: Vec<&Row> = all.iter().copied().step_by(step).collect();
    let number: HashMap<&str, usize> = meshes.iter().enumerate().map(|(at, row)| (row.mesh.as_str(), at)).collect();
    let mut rows_of: Vec<Vec<&Row>> = vec![Vec::new(); n_lines * meshes.len()];
    for row in &table.rows {
        let line =
            ratios.iter().position(|ratio| *ratio == row.ratio).zip(methods.iter().position(|m| *m == row.method));
        if let (Some((ratio, method)), Some(mesh)) = (line, number.get(row.mesh.as_str())) {
            rows_of[(ratio * methods.len() + method) * meshes.len() + mesh].push(row);
        }
    }
    let of =
        |column: &Column| rows_of.iter().map(|rows| median(values(rows, column.value)).map(|x| x as f32)).collect();
    Points {
        n_left_out: all.len() - meshes.len(),
        values: columns.iter().map(of).collect(),
        meshes: meshes.iter().map(|row| (row.mesh.as_str(), row.vertices_in, row.faces_in)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str, method: &str, seed: u64, value: f64) -> Row {
        Row {
            mesh: mesh.into(),
            ratio: 0.1,
            seed,
            method: method.into(),
            vertices_in: 10,
            faces_in: 20,
            faces_out: 5,
            seconds: Some(value),
            figures: vec![Some(value), None],
            ..Row::default()
        }
    }

    fn table() -> Table {
        let failed = Row { error: "alas".into(), seconds: None, figures: vec![None; 2], ..row("b", "x", 0, 0.0) };
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
        let distance = Cell { mean: Some(2.0), median: Some(2.0), n: 2, quotient: Some(0.5), n_quotients: 1 };
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
