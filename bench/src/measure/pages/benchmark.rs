//! The benchmark against meshoptimizer's `simplify`, and the README's table.

use std::collections::BTreeMap;

use crate::evaluate::{ResultRow, Settings, Table};
use anyhow::{Context, Result};
use neural_mesh::io::write_path;
use neural_mesh::mesh::topology;

use super::{RATIOS, curve, write_csv};
use crate::measure::cgal;
use crate::measure::markdown::{count, number, table};
use crate::measure::meshes::{load, name};
use crate::measure::quotients::{Figure, Quotients};
use crate::measure::root;
use crate::measure::versions::{Subsystem, TABLE_BEGINS, TABLE_ENDS, stamp};
use crate::measure::workbench::Bench;

pub const REFERENCE: &str = "meshopt";

const THEIRS: (&str, &str) = (REFERENCE, "meshoptimizer, `simplify`");
const EFFORTS: [&str; 3] = ["fast", METHODS[0].0, "best"];
const CURVE: &str = "docs/pictures/time-and-distance.svg";

// Time limit of a run in seconds.
const TIME_LIMIT: f64 = 3600.0;

const METHODS: [(&str, &str); 11] = [
    ("closed", "neural-mesh"),
    ("fast", "neural-mesh, `--effort fast`"),
    ("best", "neural-mesh, `--effort best`"),
    ("best-mean", "neural-mesh, `--effort best --optimize mean`"),
    ("network", "neural-mesh, `--scores network`"),
    ("mean", "neural-mesh, `--optimize mean`"),
    ("max", "neural-mesh, `--optimize max`"),
    ("normals", "neural-mesh, `--optimize normals`"),
    ("meshopt-update", "meshoptimizer, `simplifyWithUpdate`"),
    ("cgal-qem", "QEM, optimal placement (CGAL)"),
    ("cgal-lt", "Lindstrom-Turk (CGAL)"),
];

const README_METHODS: [&str; 6] = ["closed", "fast", "best", "meshopt-update", "cgal-qem", "cgal-lt"];

fn readme_methods() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    METHODS.iter().filter(|method| README_METHODS.contains(&method.0))
}

pub fn page(bench: &Bench) -> Result<String> {
    let rows = evaluate_all(bench)?;
    let inputs = bench.measure_once("benchmark-inputs", || inspect_inputs(bench))?;
    update_readme(&rows, &inputs)?;
    let quotients = Quotients { table: &rows, over: REFERENCE };
    write_path(&root().join(CURVE), curve::draw_curve(&curve_points(&quotients))?.as_bytes(), true)?;
    let large = Table { rows: large_mesh_rows(&rows, &inputs), figures: rows.figures.clone() };
    let large = Quotients { table: &large, over: REFERENCE };
    let sections = [
        all_ratios(&quotients),
        by_ratio(&quotients),
        large_meshes(&large),
        topology_section(&rows, &inputs)?,
        files(&quotients, &large, &inputs)?,
        failures(&rows),
    ];
    let sections: Vec<String> = sections.into_iter().filter(|section| !section.is_empty()).collect();
    Ok(intro(&rows, &inputs) + &sections.join("\n"))
}

pub fn evaluate_all(bench: &Bench) -> Result<Table> {
    let bench = bench.for_subsystems(&[Subsystem::Closed])?;
    let mut settings = Settings::default();
    (settings.ratios, settings.repeats, settings.time_limit) = (RATIOS.into(), 1, TIME_LIMIT);
    settings.tools = cgal::build_tools(&bench.scratch("cgal")?)?;
    let with_program = METHODS.iter().map(|method| method.0).filter(|name| !cgal::NAMES.contains(name));
    settings.methods = with_program.chain(["geometry", REFERENCE]).map(String::from).collect();
    let mut table = bench.evaluate_set("benchmark", "test", settings, None)?;
    table.rows.iter_mut().for_each(|row| row.mesh.truncate(row.mesh.rfind('.').unwrap_or(row.mesh.len())));
    Ok(table)
}

// Number of faces of each mesh, and whether it is closed and manifold.
type Inputs = BTreeMap<String, (usize, bool)>;

fn inspect_inputs(bench: &Bench) -> Result<Inputs> {
    let input = |path: &std::path::PathBuf| {
        let found = topology(&load(path)?);
        let is_manifold = found.is_closed_manifold() && found.non_manifold_vertices == 0;
        Ok((name(path), (found.faces, is_manifold)))
    };
    bench.meshes("test")?.iter().map(input).collect()
}

fn intro(rows: &Table, inputs: &Inputs) -> String {
    let faces = inputs.values().map(|input| input.0);
    let (least, most) = (faces.clone().min().unwrap_or_default(), faces.max().unwrap_or_default());
    let machine = rows.rows.first().map(|row| row.conditions.cpu.clone()).unwrap_or_default();
    format!(
        "{} meshes of {} to {} faces, none of them used in training. Every method simplifies to the face count of neural-mesh at the \
         ratios 0.05, 0.1, 0.2 and 0.5. Cells are medians of quotients over meshoptimizer's `simplify` without options or error \
         limit; below 1 is better.\n\n\
         - *mean distance*: from 50,000 samples on each surface to the other surface, mean of both directions.\n\
         - *largest distance*: the certified Hausdorff distance, an upper bound that is at most 1 % too large.\n\
         - *normal error*: mean of 1 - n.n' at the same samples; n' is the normal at the closest point.\n\
         - *time*: processor time on one thread with the mesh in memory; one process per run, methods in turns ({machine}).\n\n\
         QEM (Garland and Heckbert, optimal placement) and Lindstrom-Turk are CGAL's `edge_collapse`, compiled with \
         `-O3 -DNDEBUG`.\n\n",
        inputs.len(),
        count(least),
        count(most)
    )
}

fn curve_points(quotients: &Quotients) -> Vec<curve::CurvePoint> {
    let point = |&(method, about): &(&str, &str)| {
        let is_ours = about.starts_with(METHODS[0].1);
        let median = |figure| quotients.median(method, figure, &RATIOS);
        let place = median(Figure::Time).zip(median(Figure::Distance))?;
        let is_shown = !is_ours || EFFORTS.contains(&method);
        is_shown.then(|| curve::CurvePoint { name: about.replace('`', ""), is_ours, place })
    };
    METHODS.iter().chain([&THEIRS]).filter_map(point).collect()
}

fn all_ratios(quotients: &Quotients) -> String {
    let mut head = vec![format!("over `{REFERENCE}`: median")];
    Figure::ALL.iter().for_each(|figure| head.extend([figure.title().to_owned(), "worst mesh".into()]));
    let row = |&(method, about): &(&str, &str)| {
        let cells = Figure::ALL.iter().flat_map(|&figure| {
            let [median, mesh, worst] = median_and_worst(quotients, method, figure, &RATIOS);
            [median, format!("{mesh} {worst}")]
        });
        [about.to_owned()].into_iter().chain(cells).collect()
    };
    format!("## All ratios\n\n{}", table(&head, &METHODS.iter().map(row).collect::<Vec<_>>()))
}

fn median_and_worst(quotients: &Quotients, method: &str, figure: Figure, ratios: &[f64]) -> [String; 3] {
    let worst = quotients.worst(method, figure, ratios);
    let [mesh, worst] = worst.map_or(["-".into(), "-".into()], |worst| [worst.mesh, number(Some(worst.quotient))]);
    [number(quotients.median(method, figure, ratios)), mesh, worst]
}

fn by_ratio(quotients: &Quotients) -> String {
    const FIGURES: [Figure; 2] = [Figure::Distance, Figure::Largest];
    let mut head = vec![format!("over `{REFERENCE}`: median")];
    head.extend(FIGURES.iter().flat_map(|figure| RATIOS.map(|ratio| format!("{} at {ratio}", figure.title()))));
    let row = |&(method, about): &(&str, &str)| {
        let medians = |&figure: &Figure| RATIOS.map(|ratio| number(quotients.median(method, figure, &[ratio])));
        [about.to_owned()].into_iter().chain(FIGURES.iter().flat_map(medians)).collect()
    };
    format!("## By ratio\n\n{}", table(&head, &readme_methods().map(row).collect::<Vec<_>>()))
}

const LARGE: usize = 50_000;

fn large_mesh_rows(rows: &Table, inputs: &Inputs) -> Vec<ResultRow> {
    let is_large = |row: &&ResultRow| inputs.get(&row.mesh).is_some_and(|input| input.0 > LARGE);
    rows.rows.iter().filter(is_large).cloned().collect()
}

fn large_meshes(quotients: &Quotients) -> String {
    let n = quotients.meshes().len();
    let mut head = vec![format!("over `{REFERENCE}`: median")];
    head.extend(Figure::ALL.map(|figure| figure.title().to_owned()));
    let row = |&(method, about): &(&str, &str)| {
        let medians = Figure::ALL.map(|figure| number(quotients.median(method, figure, &RATIOS)));
        [about.to_owned()].into_iter().chain(medians).collect()
    };
    format!(
        "## Meshes above {} faces\n\n{n} of them, all ratios.\n\n{}",
        count(LARGE),
        table(&head, &readme_methods().map(row).collect::<Vec<_>>())
    )
}

fn topology_section(rows: &Table, inputs: &Inputs) -> Result<String> {
    let head = [
        "results of closed manifold inputs",
        "closed",
        "manifold",
        "components kept",
        "handles kept",
        "turned faces",
        "crossing faces",
    ];
    let line = |&(method, about): &(&str, &str)| {
        let rows_of: Vec<&ResultRow> = closed_results(rows, inputs, method).collect();
        let of = |n: usize| format!("{n} of {}", rows_of.len());
        let zero = |names: &[&str]| of(rows_of.iter().filter(|row| are_zero(rows, row, names)).count());
        let sum = |name: &str| {
            let total: f64 = rows_of.iter().filter_map(|row| rows.figure(row, name)).sum();
            count(total as usize)
        };
        vec![
            about.to_owned(),
            zero(&["open_edges"]),
            zero(&["non_manifold_edges", "non_manifold_vertices", "edges_without_two_faces"]),
            zero(&["components_added"]),
            zero(&["genus_added"]),
            sum("turned_faces"),
            sum("self_intersecting_faces"),
        ]
    };
    let all: Vec<Vec<String>> = METHODS.iter().chain([&THEIRS]).map(line).collect();
    let of_page: Vec<Vec<String>> = readme_methods().chain([&THEIRS]).map(line).collect();
    let link = write_csv("benchmark-topology", &head, &all)?;
    Ok(format!("## Topology\n\nAll methods: {link}.\n\n{}", table(&head, &of_page)))
}

fn are_zero(rows: &Table, row: &ResultRow, figures: &[&str]) -> bool {
    figures.iter().all(|figure| rows.figure(row, figure) == Some(0.0))
}

fn closed_results<'a>(rows: &'a Table, inputs: &'a Inputs, method: &'a str) -> impl Iterator<Item = &'a ResultRow> {
    let is_closed = |row: &&ResultRow| inputs.get(&row.mesh).is_some_and(|input| input.1);
    rows.rows.iter().filter(move |row| row.method == method && row.error.is_empty()).filter(is_closed)
}

fn files(quotients: &Quotients, large: &Quotients, inputs: &Inputs) -> Result<String> {
    Ok(format!(
        "## Every figure\n\n- {}: each method at each ratio, with the worst mesh.\n- {}: each mesh; medians over the four ratios, for \
         neural-mesh each ratio as well.\n",
        write_ratios(quotients, large)?,
        write_meshes(quotients, inputs)?
    ))
}

fn write_ratios(quotients: &Quotients, large: &Quotients) -> Result<String> {
    let mut head: Vec<String> = ["meshes", "ratio", "method"].map(String::from).into();
    head.extend(Figure::ALL.iter().flat_map(|figure| [figure.title(), "worst mesh", "worst"].map(String::from)));
    let (all, above) = ("all".to_owned(), format!("above {LARGE} faces"));
    let mut sets = vec![(&all, "all".to_owned(), quotients, RATIOS.to_vec())];
    sets.extend(RATIOS.map(|ratio| (&all, ratio.to_string(), quotients, vec![ratio])));
    sets.push((&above, "all".into(), large, RATIOS.to_vec()));
    let mut rows = Vec::new();
    for (meshes, ratio, of, ratios) in &sets {
        for (method, about) in METHODS {
            let mut row = vec![(*meshes).clone(), ratio.clone(), about.to_owned()];
            row.extend(Figure::ALL.iter().flat_map(|&figure| median_and_worst(of, method, figure, ratios)));
            rows.push(row);
        }
    }
    write_csv("benchmark-ratios", &head, &rows)
}

fn write_meshes(quotients: &Quotients, inputs: &Inputs) -> Result<String> {
    let mut head: Vec<String> = ["figure", "mesh", "faces"].map(String::from).into();
    head.extend(RATIOS.map(|ratio| format!("neural-mesh at {ratio}")));
    head.extend(METHODS.iter().map(|method| method.1.to_owned()));
    let mut rows = Vec::new();
    for figure in Figure::ALL {
        for mesh in quotients.meshes() {
            let n_faces = inputs.get(&mesh).map_or("-".into(), |input| input.0.to_string());
            let of = |method: &str, ratios: &[f64]| number(quotients.median_of_mesh(&mesh, method, figure, ratios));
            let mut row = vec![figure.title().to_owned(), mesh.clone(), n_faces];
            row.extend(RATIOS.map(|ratio| of(METHODS[0].0, &[ratio])));
            row.extend(METHODS.iter().map(|method| of(method.0, &RATIOS)));
            rows.push(row);
        }
    }
    write_csv("benchmark-meshes", &head, &rows)
}

fn failures(rows: &Table) -> String {
    let failed = rows.rows.iter().filter(|row| !row.error.is_empty());
    let lines: Vec<String> =
        failed.map(|row| format!("- {} on {} at {}: {}\n", row.method, row.mesh, row.ratio, row.error)).collect();
    if lines.is_empty() { String::new() } else { format!("## Without a result\n\n{}", lines.concat()) }
}

fn update_readme(rows: &Table, inputs: &Inputs) -> Result<()> {
    let path = root().join("README.md");
    let text = std::fs::read_to_string(&path)?;
    let (before, rest) = text.split_once(TABLE_BEGINS).context("README.md has no mark where its table begins")?;
    let (_, after) = rest.split_once(TABLE_ENDS).context("README.md has no mark where its table ends")?;
    let table =
        format!("{TABLE_BEGINS}{} -->\n{}{TABLE_ENDS}", stamp(&[Subsystem::Closed]), readme_table(rows, inputs));
    Ok(write_path(&path, format!("{before}{table}{after}").as_bytes(), true)?)
}

fn readme_table(rows: &Table, inputs: &Inputs) -> String {
    let quotients = Quotients { table: rows, over: REFERENCE };
    let head = [
        "over meshoptimizer's `simplify`",
        "mean distance",
        "largest distance",
        "normal error",
        "time, one thread",
        "closed inputs that stay closed and manifold",
    ];
    let line = |&(method, about): &(&str, &str)| {
        let rows_of: Vec<&ResultRow> = closed_results(rows, inputs, method).collect();
        let is_whole = |row: &&&ResultRow| are_zero(rows, row, &["edges_without_two_faces", "non_manifold_vertices"]);
        let n_whole = rows_of.iter().filter(is_whole).count();
        let figures = Figure::ALL.iter().map(|&figure| match method {
            REFERENCE => "1".into(),
            _ => number(quotients.median(method, figure, &RATIOS)),
        });
        let share = format!("{n_whole} of {}", rows_of.len());
        [about.to_owned()].into_iter().chain(figures).chain([share]).collect()
    };
    table(&head, &readme_methods().chain([&THEIRS]).map(line).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, distance: f64, open: f64) -> ResultRow {
        let figures = vec![Some(distance), Some(open), Some(0.0)];
        ResultRow {
            mesh: "ball".into(),
            ratio: 0.1,
            method: method.into(),
            figures,
            seconds: Some(2.0),
            ..ResultRow::default()
        }
    }

    #[test]
    fn the_readme_has_medians_and_counts_what_stayed_whole() {
        let figures = ["distance_mean", "edges_without_two_faces", "non_manifold_vertices"].map(String::from).into();
        let table = Table { figures, rows: vec![row("closed", 1.0, 0.0), row(REFERENCE, 2.0, 3.0)] };
        let inputs = Inputs::from([("ball".to_owned(), (100, true))]);
        let text = readme_table(&table, &inputs);
        assert!(text.contains("| neural-mesh | 0.50 | - | - | 1.00 | 1 of 1 |"), "{text}");
        assert!(text.contains("| meshoptimizer, `simplify` | 1 | 1 | 1 | 1 | 0 of 1 |"), "{text}");
    }
}
