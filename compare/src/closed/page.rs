//! The page of scores: every contestant over meshoptimizer, the network over the others, and what became of the surfaces.

use super::versus::{Versus, all_over, meshes, ratios};
use crate::row::Row;
use crate::summary::markdown::{cells, list, number, table};
use crate::summary::statistics::{Figure, median};

const OURS: [&str; 4] = ["network", "geometry", "shuffled", "bending"];

const INTRODUCTION: &str = "\
Per mesh and ratio the median over the seeds, then medians over meshes and ratios, 90th percentiles in brackets. Distances \
are two-sided point-to-surface; the normal error is the mean of 1 - n.n'.

- *network*: the scores of the weights.
- *geometry*: all vertices count by their area alone.
- *shuffled*: the weights with the entries of every tensor in random order.
- *bending*: the importance is the square root of how much the surface bends, by a formula.
- *meshoptimizer*: its `simplify` without options or error limit, to as many faces as *network*.
";

/// The page's part that the rows make.
pub fn page(rows: &[Row]) -> String {
    let by_ratio = |of: &str, over: &str| Versus::new(rows, of, over).by_ratio();
    let against =
        format!("{}\n{}", all_over(rows, &OURS, "meshoptimizer", &ratios(rows)), by_ratio("network", "meshoptimizer"));
    let sections = [
        ("Against meshoptimizer", against),
        ("Network over geometry", by_ratio("network", "geometry")),
        ("Shuffled over network", by_ratio("shuffled", "network")),
        ("Network over bending", by_ratio("network", "bending")),
        ("Surfaces", surfaces(rows)),
        ("Every mesh", every_mesh(rows)),
    ];
    let body: String = sections.iter().map(|(title, text)| format!("\n### {title}\n\n{text}")).collect();
    format!("{INTRODUCTION}{body}")
}

/// A property of a result that its input has.
type Kept = fn(&Row, &Row) -> bool;

const KEPT: [(&str, Kept); 4] = [
    ("closed", |_, row| row.closed),
    ("manifold", |_, row| row.non_manifold_edges + row.non_manifold_vertices + row.inconsistent_edges == 0),
    ("components kept", |input, row| input.components == row.components),
    ("genus kept", |input, row| input.genus == row.genus),
];

/// How many results of closed inputs are closed and manifold, with the same pieces and handles.
fn surfaces(rows: &[Row]) -> String {
    let input = |row: &Row| rows.iter().find(|input| input.method == "input" && input.mesh == row.mesh);
    let of_closed = |method: &str| -> Vec<(&Row, &Row)> {
        let mine = rows.iter().filter(|row| row.method == method && !row.failed());
        mine.filter_map(|row| Some((input(row).filter(|input| input.closed)?, row))).collect()
    };
    let mut head = cells(&["results of closed inputs"]);
    head.extend(KEPT.iter().map(|(name, _)| (*name).to_owned()));
    head.push("faces turned over".to_owned());
    let line = |method: &&str| {
        let pairs = of_closed(method);
        let kept = KEPT.iter().map(|(_, kept)| {
            format!("{} of {}", pairs.iter().filter(|(input, row)| kept(input, row)).count(), pairs.len())
        });
        let turned: usize = pairs.iter().map(|(_, row)| row.turned_faces).sum();
        [(*method).to_owned()].into_iter().chain(kept).chain([turned.to_string()]).collect()
    };
    let all: Vec<&str> = OURS.into_iter().chain(["meshoptimizer"]).collect();
    let lines: Vec<Vec<String>> = all.iter().map(line).collect();
    format!("{}\nNot at the size asked for, or no result: {}", table(&head, &lines), list(&short_of_size(rows)))
}

fn short_of_size(rows: &[Row]) -> Vec<String> {
    let ours = rows.iter().filter(|row| OURS.contains(&row.method.as_str()) && row.outcome != "reached");
    ours.map(|row| format!("{} at {}, seed {}, {}: {}", row.mesh, row.ratio, row.seed, row.method, row.outcome))
        .collect()
}

/// A row per mesh: the network over geometry and over meshoptimizer, medians over the ratios.
fn every_mesh(rows: &[Row]) -> String {
    let figures = [Figure::Mean, Figure::NormalError, Figure::Hausdorff, Figure::Time];
    let mut head = cells(&["mesh"]);
    for over in ["geometry", "meshoptimizer"] {
        head.extend(figures.iter().map(|figure| format!("{} / {over}'s", figure.title())));
    }
    let ratios = ratios(rows);
    let over = |mesh: &str, over: &str, figure: Figure| {
        let versus = Versus::new(rows, "network", over);
        number(median(ratios.iter().filter_map(|&ratio| versus.ratio(figure, mesh, ratio)).collect()))
    };
    let line = |mesh: &&str| {
        let cells = |other| figures.iter().map(move |&figure| over(mesh, other, figure));
        [(*mesh).to_owned()].into_iter().chain(cells("geometry")).chain(cells("meshoptimizer")).collect()
    };
    table(&head, &meshes(rows).iter().map(line).collect::<Vec<Vec<String>>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_counted_and_shortfalls_named() {
        let row = |method: &str, closed: bool, outcome: &str| Row {
            mesh: "ball".into(),
            ratio: 0.5,
            method: method.into(),
            closed,
            outcome: outcome.into(),
            ..Row::default()
        };
        let rows = [row("input", true, ""), row("network", true, "reached"), row("geometry", false, "stopped")];
        let text = surfaces(&rows);
        assert!(text.contains("| network | 1 of 1 | 1 of 1 | 1 of 1 | 1 of 1 | 0 |"), "{text}");
        assert!(text.contains("| geometry | 0 of 1 | 1 of 1 |"), "{text}");
        assert!(text.contains("- ball at 0.5, seed 0, geometry: stopped"), "{text}");
    }
}
