//! What became of the surfaces: closed, manifold, pieces, handles, folds, and the sizes reached.

use super::cases::Cases;
use super::markdown::{cells, list, table};
use crate::row::Row;

/// Where a result is not what its input was.
fn changes(input: &Row, row: &Row) -> Vec<String> {
    let mut changes = Vec::new();
    let mut grown = |what: &str, before: usize, after: usize| {
        if after > before {
            changes.push(format!("{after} {what}, the input {before}"));
        }
    };
    grown("edges with more than two faces", input.non_manifold_edges, row.non_manifold_edges);
    grown("vertices with several fans", input.non_manifold_vertices, row.non_manifold_vertices);
    grown("edges of disagreeing faces", input.inconsistent_edges, row.inconsistent_edges);
    if input.closed && !row.closed {
        changes.push(format!("{} border edges", row.boundary_edges));
    }
    if input.components != row.components {
        changes.push(format!("{} components, the input {}", row.components, input.components));
    }
    if input.genus != row.genus {
        changes.push(format!("genus {:?}, the input {:?}", row.genus, input.genus).replace("Some", ""));
    }
    if !input.closed && input.boundary_loops != row.boundary_loops {
        changes.push(format!("{} border loops, the input {}", row.boundary_loops, input.boundary_loops));
    }
    changes
}

/// How many results keep their input's topology, per method, and every one of ours that does not.
pub fn topology(cases: &Cases) -> String {
    let count = |method: &str, closed: bool| {
        let rows: Vec<_> = cases.of(method).filter_map(|row| Some((cases.input(&row.mesh)?, row))).collect();
        let of_kind = rows.iter().filter(|(input, row)| input.closed == closed && !row.failed());
        let kept = of_kind.clone().filter(|(input, row)| changes(input, row).is_empty()).count();
        format!("{kept} of {}", of_kind.count())
    };
    let head = cells(&["results with the topology of their input", "ours", "meshoptimizer", "target"]);
    let row = |name: &str, closed, target: &str| {
        vec![name.to_owned(), count("ours", closed), count("meshoptimizer", closed), target.to_owned()]
    };
    let rows = [
        row("closed inputs: closed, edge- and vertex-manifold, same components and genus", true, "all"),
        row("open inputs: no new trouble, same components, genus and border loops", false, "-"),
    ];
    let exceptions = cases.of("ours").filter(|row| !row.failed()).filter_map(|row| {
        let changes = changes(cases.input(&row.mesh)?, row);
        (!changes.is_empty()).then(|| format!("{}: {}", case(row), changes.join(", ")))
    });
    format!(
        "{}\nOurs with another topology than the input: {}",
        table(&head, &rows),
        list(&exceptions.collect::<Vec<_>>())
    )
}

/// Crossing and turned faces of both methods.
pub fn folds(cases: &Cases) -> String {
    let beyond = |row: &Row| {
        let before = cases.input(&row.mesh).map_or(0, |input| input.self_intersecting_faces);
        row.self_intersecting_faces.saturating_sub(before)
    };
    let head = cells(&["over all results", "ours", "meshoptimizer", "target"]);
    let both = |name: &str, target: &str, figure: &dyn Fn(&Row) -> usize| {
        let sum = |method: &str| cases.of(method).map(figure).sum::<usize>().to_string();
        let with = |method: &str| cases.of(method).filter(|row| figure(row) > 0).count();
        let cell = |method: &str| format!("{} in {} results", sum(method), with(method));
        vec![name.to_owned(), cell("ours"), cell("meshoptimizer"), target.to_owned()]
    };
    let rows = [
        both("self-intersecting faces beyond the input's", "-", &beyond),
        both("faces turned against the surface", "0", &|row: &Row| row.turned_faces),
    ];
    let turned = cases.meshes.iter().filter_map(|mesh| {
        let rows = cases.of("ours").filter(|row| row.mesh == *mesh && row.turned_faces > 0);
        let parts: Vec<_> =
            rows.map(|row| format!("{} at {} (seed {})", row.turned_faces, row.ratio, row.seed)).collect();
        (!parts.is_empty()).then(|| format!("{mesh}: {}", parts.join(", ")))
    });
    let turned: Vec<_> = turned.collect();
    format!("{}\nOurs with faces turned against the surface: {}", table(&head, &rows), list(&turned))
}

/// Whether the sizes asked for were reached, and where not, why.
pub fn sizes(cases: &Cases) -> String {
    let rows: Vec<_> = cases.of("ours").filter(|row| !row.failed()).collect();
    let reached = |row: &&&Row| row.outcome == "reached" && is_at_target(cases, row);
    let exact = rows.iter().filter(reached).count();
    let others = rows
        .iter()
        .filter(|row| !reached(row))
        .map(|row| format!("{}: {} vertices, {}", case(row), row.vertices, row.outcome));
    let failed = cases.of("ours").filter(|row| row.failed()).map(|row| format!("{}: {}", case(row), row.outcome));
    format!(
        "{exact} of {} results have the number of vertices asked for or one below. Others: {}\nNo result at all: {}",
        rows.len(),
        list(&others.collect::<Vec<_>>()),
        list(&failed.collect::<Vec<_>>())
    )
}

/// At most the share of vertices asked for, rounded down, and at most one vertex below.
fn is_at_target(cases: &Cases, row: &Row) -> bool {
    let Some(input) = cases.input(&row.mesh) else { return false };
    let target = ((row.ratio * input.vertices as f64) as usize).max(1);
    row.vertices <= target && row.vertices + 1 >= target
}

/// Which share of the vertices the one pass takes away, and which the collapse.
pub fn removal(cases: &Cases) -> String {
    let mut head = cells(&["of the vertices removed (mean over results)"]);
    head.extend(cases.ratios.iter().map(|ratio| format!("{ratio}")));
    let mean = |ratio: f64, figure: &dyn Fn(&Row) -> Option<f64>| {
        let values: Vec<f64> = cases.of("ours").filter(|row| row.ratio == ratio).filter_map(figure).collect();
        if values.is_empty() {
            "-".to_owned()
        } else {
            format!("{:.2}", values.iter().sum::<f64>() / values.len() as f64)
        }
    };
    let by_pass = |row: &Row| {
        let input = cases.input(&row.mesh)?.vertices as f64;
        Some((input - row.vertices_after_pass? as f64).max(0.0) / (input - row.vertices as f64).max(1.0))
    };
    let row = |name: &str, figure: &dyn Fn(&Row) -> Option<f64>| {
        let values = cases.ratios.iter().map(|&ratio| mean(ratio, figure));
        [name.to_owned()].into_iter().chain(values).collect::<Vec<_>>()
    };
    let rows = [
        row("share removed by the one pass", &by_pass),
        row("share removed by the collapse", &|row| Some(1.0 - by_pass(row)?)),
        row("samples drawn per vertex asked for (`oversample`)", &|row| row.oversample),
    ];
    table(&head, &rows)
}

fn case(row: &Row) -> String {
    format!("{} at {}, seed {}", row.mesh, row.ratio, row.seed)
}
