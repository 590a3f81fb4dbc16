//! The benchmark against meshoptimizer's `simplify`, and the README's table.

use anyhow::Result;
use neural_mesh::io::write_path;
use neural_mesh::mesh::topology;

use super::bench::{Bench, Blocks, LARGE, RATIOS};
use super::versions::{Subsystem, TABLE_BEGINS, TABLE_ENDS, stamp};
use super::{cgal, curve, meshes::load};
use crate::cells::{Show, largest, median, number, sum, worst, worst_mesh, zeros};
use crate::evaluate::Settings;
use crate::rows::{ResultRow, Table};
use crate::tables::{Column, Line, TextTable, pivot, replace_between};

const REFERENCE: &str = "meshopt";
const CORNER: [&str; 1] = ["over `meshopt`: median"];

// Time limit of a run in seconds.
const TIME_LIMIT: f64 = 3600.0;

/// Titles and figures of quotients over meshoptimizer's `simplify`.
pub const FIGURES: [(&str, &str); 4] = [
    ("mean distance", "/distance_mean"),
    ("largest distance", "/distance_max"),
    ("normal error", "/normal_error_signed"),
    ("time", "/seconds"),
];

// Name, description, and whether the README and the short tables have it.
const METHODS: [(&str, &str, bool); 12] = [
    ("closed", "neural-mesh", true),
    ("fast", "neural-mesh, `--effort fast`", true),
    ("best", "neural-mesh, `--effort best`", true),
    ("best-mean", "neural-mesh, `--effort best --optimize mean`", false),
    ("network", "neural-mesh, `--scores network`", false),
    ("mean", "neural-mesh, `--optimize mean`", false),
    ("max", "neural-mesh, `--optimize max`", false),
    ("normals", "neural-mesh, `--optimize normals`", false),
    ("meshopt-update", "meshoptimizer, `simplifyWithUpdate`", true),
    ("cgal-qem", "QEM, optimal placement (CGAL)", true),
    ("cgal-lt", "Lindstrom-Turk (CGAL)", true),
    (REFERENCE, "meshoptimizer, `simplify`", true),
];

pub fn measure(bench: &Bench) -> Result<Blocks> {
    let inputs = inspect_inputs(bench)?;
    let input = |row: &ResultRow, figure: &str| {
        let input = inputs.rows.iter().find(|input| input.mesh == row.mesh)?;
        inputs.value(input, figure)
    };
    let rows = evaluate_all(bench)?.with_quotients_over(REFERENCE);
    let large = rows.filter(|row| input(row, "faces") > Some(LARGE as f64));
    let closed = rows.filter(|row| row.error.is_empty() && input(row, "is_closed_manifold") == Some(1.0));
    write_path(&bench.output("docs/pictures/time-and-distance.svg"), draw_curve(&rows)?.as_bytes(), true)?;
    bench.write_csv("benchmark-ratios", &ratio_table(&rows, &large))?;
    bench.write_csv("benchmark-meshes", &mesh_table(&rows, &inputs))?;
    let topology = |lines: &[Line]| pivot(&closed, &["results of closed manifold inputs"], lines, &topology_columns());
    bench.write_csv("benchmark-topology", &topology(&lines(false, true)))?;
    update_readme(bench, &readme_table(&rows, &closed))?;
    let medians = FIGURES.map(|(title, figure)| Column::of_figure(title, figure, 1.0, median));
    Ok(vec![
        ("all-ratios", pivot(&rows, &CORNER, &lines(false, false), &worst_columns()).markdown()),
        ("by-ratio", pivot(&rows, &CORNER, &lines(true, false), &distance_columns()).markdown()),
        ("large-meshes", pivot(&large, &CORNER, &lines(true, false), &medians).markdown()),
        ("topology", topology(&lines(true, true)).markdown()),
    ])
}

/// Evaluates all methods on the benchmark meshes.
pub fn evaluate_all(bench: &Bench) -> Result<Table> {
    let bench = bench.for_subsystems(&[Subsystem::Closed])?;
    let mut settings = Settings::default();
    (settings.ratios, settings.repeats, settings.time_limit) = (RATIOS.into(), 1, TIME_LIMIT);
    settings.tools = cgal::build_tools(&bench.scratch("cgal")?)?;
    let with_program = METHODS.iter().map(|method| method.0).filter(|name| !cgal::NAMES.contains(name));
    settings.methods = with_program.chain(["geometry"]).map(String::from).collect();
    bench.evaluate_set("benchmark", "test", settings, None)
}

/// Returns the number of faces of each benchmark mesh, and 1 if it is closed and manifold.
pub fn inspect_inputs(bench: &Bench) -> Result<Table> {
    bench.measure("inputs", &["faces", "is_closed_manifold"], bench.meshes("test")?, |name, path| {
        let found = topology(&load(path)?);
        let is_whole = found.is_closed_manifold() && found.non_manifold_vertices == 0;
        Ok(vec![ResultRow::new(name, 1.0, "", &[found.faces as f64, f64::from(u8::from(is_whole))])])
    })
}

fn lines(is_short: bool, with_reference: bool) -> Vec<Line> {
    let is_shown = |(name, _, is_of_readme): &&(&str, &str, bool)| {
        (!is_short || *is_of_readme) && (with_reference || *name != REFERENCE)
    };
    METHODS.iter().filter(is_shown).map(|(name, about, _)| Line::new([about]).with_method(name)).collect()
}

fn worst_columns() -> Vec<Column<'static>> {
    let of_figure = |(title, figure): (&str, &str)| {
        [Column::of_figure(title, figure, 1.0, median), Column::of_figure("worst mesh", figure, 1.0, worst)]
    };
    FIGURES.into_iter().flat_map(of_figure).collect()
}

fn distance_columns() -> Vec<Column<'static>> {
    let at_ratios = |(title, figure): (&'static str, &'static str)| {
        RATIOS.map(|ratio| Column::of_figure(&format!("{title} at {ratio}"), figure, 1.0, median).with_ratio(ratio))
    };
    FIGURES[..2].iter().copied().flat_map(at_ratios).collect()
}

fn topology_columns() -> Vec<Column<'static>> {
    let is_manifold = |table: &Table, rows: &[&ResultRow]| {
        let figures = ["non_manifold_edges", "non_manifold_vertices", "edges_without_two_faces"];
        let n = rows.iter().filter(|row| figures.iter().all(|figure| table.value(row, figure) == Some(0.0))).count();
        format!("{n} of {}", rows.len()).into()
    };
    let column = |title: &str, figure: &str, show| Column::of_figure(title, figure, 1.0, show);
    vec![
        column("closed", "open_edges", zeros),
        Column::new("manifold", is_manifold),
        column("components kept", "components_added", zeros),
        column("handles kept", "genus_added", zeros),
        column("turned faces", "turned_faces", sum),
        column("crossing faces", "self_intersecting_faces", sum),
    ]
}

fn ratio_table(rows: &Table, large: &Table) -> TextTable {
    let corner = ["meshes", "ratio", "method"];
    let of_figure = |(title, figure): (&str, &str)| {
        let shows: [(&str, Show); 3] = [(title, median), ("worst mesh", worst_mesh), ("worst", largest)];
        shows.map(|(title, show)| Column::of_figure(title, figure, 1.0, show))
    };
    let columns: Vec<Column> = FIGURES.into_iter().flat_map(of_figure).collect();
    let lines = |meshes: &str, ratio: Option<f64>| -> Vec<Line> {
        let line = |mut line: Line| {
            line.choice.ratio = ratio;
            let ratio = ratio.map_or("all".into(), |ratio| ratio.to_string());
            line.labels = [vec![meshes.to_owned(), ratio], line.labels].concat();
            line
        };
        lines(false, false).into_iter().map(line).collect()
    };
    let ratios = [None].into_iter().chain(RATIOS.map(Some));
    let all: Vec<Line> = ratios.flat_map(|ratio| lines("all", ratio)).collect();
    let above = lines(&format!("above {LARGE} faces"), None);
    pivot(rows, &corner, &all, &columns).with_lines_of(pivot(large, &corner, &above, &columns))
}

fn mesh_table(rows: &Table, inputs: &Table) -> TextTable {
    let of_figure = |(title, figure): (&str, &str)| {
        let line = |input: &ResultRow| {
            let faces = inputs.value(input, "faces").map_or("-".into(), |faces| faces.to_string());
            Line::new([title, &input.mesh, &faces]).with_mesh(&input.mesh)
        };
        let at = |ratio: f64| {
            Column::of_figure(&format!("neural-mesh at {ratio}"), figure, 1.0, median)
                .with_method(METHODS[0].0)
                .with_ratio(ratio)
        };
        let methods = METHODS.iter().filter(|method| method.0 != REFERENCE);
        let methods = methods.map(|(name, about, _)| Column::of_figure(about, figure, 1.0, median).with_method(name));
        let columns: Vec<Column> = RATIOS.map(at).into_iter().chain(methods).collect();
        let lines: Vec<Line> = inputs.rows.iter().map(line).collect();
        pivot(rows, &["figure", "mesh", "faces"], &lines, &columns)
    };
    FIGURES.into_iter().map(of_figure).fold(TextTable::default(), TextTable::with_lines_of)
}

fn draw_curve(rows: &Table) -> Result<String> {
    let point = |&(method, about, is_shown): &(&str, &str, bool)| {
        let of_method: Vec<&ResultRow> = rows.rows.iter().filter(|row| row.method == method).collect();
        let median =
            |figure: &str| crate::rows::median(of_method.iter().filter_map(|row| rows.value(row, figure)).collect());
        let place = median(FIGURES[3].1).zip(median(FIGURES[0].1))?;
        let is_ours = about.starts_with(METHODS[0].1);
        is_shown.then(|| curve::CurvePoint { name: about.replace('`', ""), is_ours, place })
    };
    curve::draw_curve(&METHODS.iter().filter_map(point).collect::<Vec<_>>())
}

fn update_readme(bench: &Bench, table: &TextTable) -> Result<()> {
    let path = bench.output("README.md");
    let content = format!("{} -->\n{}", stamp(&[Subsystem::Closed]), table.markdown());
    let text = replace_between(&std::fs::read_to_string(&path)?, TABLE_BEGINS, TABLE_ENDS, &content)?;
    Ok(write_path(&path, text.as_bytes(), true)?)
}

fn readme_table(rows: &Table, closed: &Table) -> TextTable {
    let is_whole = |row: &&ResultRow| {
        ["edges_without_two_faces", "non_manifold_vertices"].iter().all(|figure| closed.value(row, figure) == Some(0.0))
    };
    let share = |_: &Table, rows: &[&ResultRow]| {
        let of_method = closed.rows.iter().filter(|row| rows.first().is_some_and(|first| first.method == row.method));
        let n_whole = of_method.clone().filter(is_whole).count();
        format!("{n_whole} of {}", of_method.count()).into()
    };
    let figure = |(title, figure): (&'static str, &'static str)| {
        let title = if title == "time" { "time, one thread" } else { title };
        Column::new(title, move |table: &Table, rows: &[&ResultRow]| {
            let values = rows.iter().filter_map(|row| table.value(row, figure)).collect();
            let is_reference = rows.first().is_some_and(|row| row.method == REFERENCE);
            if is_reference { "1".to_owned() } else { number(crate::rows::median(values)) }.into()
        })
    };
    let last = Column::new("closed inputs that stay closed and manifold", share);
    let columns: Vec<Column> = FIGURES.map(figure).into_iter().chain([last]).collect();
    pivot(rows, &["over meshoptimizer's `simplify`"], &lines(true, true), &columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_readme_has_medians_and_counts_what_stayed_whole() {
        let figures = ["distance_mean", "seconds", "edges_without_two_faces", "non_manifold_vertices"];
        let row = |method: &str, distance, open| ResultRow::new("ball", 0.1, method, &[distance, 2.0, open, 0.0]);
        let rows = Table::new(&figures, vec![row("closed", 1.0, 0.0), row(REFERENCE, 2.0, 3.0)])
            .with_quotients_over(REFERENCE);
        let text = readme_table(&rows, &rows).markdown();
        assert!(text.contains("| neural-mesh | 0.50 | - | - | 1.00 | 1 of 1 |"), "{text}");
        assert!(text.contains("| meshoptimizer, `simplify` | 1 | 1 | 1 | 1 | 0 of 1 |"), "{text}");
    }
}
