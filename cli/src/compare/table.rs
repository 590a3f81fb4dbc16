//! Comparison as a table: one row per measure, one column per result.

use neural_mesh::metrics::Figure;

use super::comparison::{Comparison, MeasuredResult};
use super::meshes::NamedMesh;
use crate::escapes::escape_controls;
use crate::messages::{group_digits, shorten_path};

/// Measures that are left out where they would take too long.
const COSTLY_FIGURES: [&str; 3] = ["distance_max", "turned_faces", "self_intersecting_faces"];

/// Measures shown by default.
const DEFAULT_FIGURES: [&str; 11] = [
    "vertices",
    "faces",
    "distance_mean",
    "distance_max",
    "normal_angle",
    "boundary_edges",
    "non_manifold_edges",
    "self_intersecting_faces",
    "components_added",
    "volume_change",
    "flip",
];

pub fn format_table(comparison: &Comparison, all: bool) -> Vec<String> {
    let Comparison { original, results, options, .. } = comparison;
    let samples = group_digits(options.samples);
    let mut lines = vec![
        format!("original  {}: {}", original.name, format_size(original)),
        format!("sampled   {samples} points on each surface, seed {}", options.seed),
    ];
    lines.extend(explain_missing(original, results));
    lines.push(String::new());
    lines.extend(align_columns(&table_rows(results, all)));
    lines
}

/// Explains missing measures; `None` if all are known.
fn explain_missing(original: &NamedMesh, results: &[MeasuredResult]) -> Option<String> {
    let have_faces = |mesh: &NamedMesh| [mesh, original].iter().all(|named| !named.mesh.faces().is_empty());
    let lacks = |result: &&MeasuredResult| {
        let mut figures = result.figures.iter().filter(|figure| figure.value.is_none());
        have_faces(&result.mesh) && figures.any(|figure| COSTLY_FIGURES.contains(&figure.name))
    };
    let name = results.iter().find(lacks).map(|result| shorten_path(&escape_controls(&result.mesh.name)))?;
    let why = "needle-like faces or large intersecting faces take too long to measure: some measures may use fewer samples, and `-` marks unknown ones";
    Some(format!("bounded   {name}: {why}"))
}

fn format_size(named: &NamedMesh) -> String {
    format!("{} vertices, {} faces", group_digits(named.mesh.positions().len()), group_digits(named.mesh.faces().len()))
}

/// Returns a header row and rows of name, unit and values; omits measures without values.
fn table_rows(results: &[MeasuredResult], all: bool) -> Vec<Vec<String>> {
    let row = |name: &str, unit: &str, of: &dyn Fn(&MeasuredResult) -> String| {
        [name.to_string(), unit.to_string()].into_iter().chain(results.iter().map(of)).collect()
    };
    let mut rows = vec![row("figure", "unit", &|result| shorten_path(&escape_controls(&result.mesh.name)))];
    let figures = results.first().map_or(&[][..], |result| &result.figures);
    let is_known = |at: usize| results.iter().any(|result| result.figures[at].value.is_some());
    let is_shown = |(at, figure): &(usize, &Figure)| is_known(*at) && (all || DEFAULT_FIGURES.contains(&figure.name));
    for (at, Figure { name, unit, .. }) in figures.iter().enumerate().filter(is_shown) {
        rows.push(row(&name.replace('_', " "), unit, &|result| format_number(result.figures[at].value)));
    }
    rows
}

fn align_columns(rows: &[Vec<String>]) -> Vec<String> {
    let n_columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..n_columns).map(width).collect();
    let cell = |(column, text): (usize, &String)| match column {
        0 | 1 => format!("{text:<width$}", width = widths[column]),
        _ => format!("{text:>width$}", width = widths[column]),
    };
    let line = |row: &Vec<String>| row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ");
    rows.iter().map(|row| line(row).trim_end().to_string()).collect()
}

/// Formats four significant digits, whole numbers in full, and `-` for none.
fn format_number(value: Option<f64>) -> String {
    let Some(value) = value.filter(|value| value.is_finite()) else { return "-".into() };
    let size = value.abs();
    if value.fract() == 0.0 && size < 1e15 {
        let sign = if value < 0.0 { "-" } else { "" };
        return format!("{sign}{}", group_digits(size as usize));
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (3.0 - size.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::{TriMesh, shapes};

    #[test]
    fn numbers_have_four_digits_and_integers_all() {
        let values = [0.0, -3.0, 12345.0, 0.123456, 1.5, 98765.4321, 1.23456e-7, 3.25e9, f64::NAN];
        let shown = ["0", "-3", "12,345", "0.1235", "1.500", "98765", "1.235e-7", "3,250,000,000", "-"];
        assert_eq!(values.map(|value| format_number(Some(value))), shown);
        assert_eq!(format_number(None), "-");
    }

    #[test]
    fn skipped_measures_are_explained() {
        let named =
            |mesh| NamedMesh { name: "a.ply".into(), bytes: None, mesh, cover: None, normals: None, notes: Vec::new() };
        let figure = |name, value| Figure::new(name, "", "", value);
        let result_with = |value| {
            let figures = vec![figure("genus_added", None), figure("distance_max", value)];
            MeasuredResult { mesh: named(shapes::icosphere(1)), figures }
        };
        let sphere = named(shapes::icosphere(1));
        assert_eq!(explain_missing(&sphere, &[result_with(Some(0.5))]), None);
        assert!(
            explain_missing(&sphere, &[result_with(Some(0.5)), result_with(None)])
                .unwrap()
                .starts_with("bounded   a.ply: needle-like")
        );
        assert_eq!(explain_missing(&named(TriMesh::default()), &[result_with(None)]), None);
    }

    #[test]
    fn columns_are_aligned() {
        let rows = [["figure", "unit", "a.ply"], ["faces", "", "1,200"], ["angle", "degrees", "3.5"]];
        let rows: Vec<Vec<String>> = rows.map(|row| row.map(String::from).to_vec()).into();
        assert_eq!(
            align_columns(&rows),
            ["figure  unit     a.ply", "faces            1,200", "angle   degrees    3.5"]
        );
    }
}
