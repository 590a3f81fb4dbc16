//! Results of the shipped weights, and effects of scores and stages.

use crate::evaluate::{ResultRow, Table};
use anyhow::Result;

use super::{RATIOS, benchmark, paper, parts};
use crate::measure::markdown::{number, table};
use crate::measure::quotients::{Figure, Quotients};
use crate::measure::versions::Subsystem;
use crate::measure::workbench::Bench;

const INTRO: &str = "[training.md](../training.md#weights-that-ship) describes the weights and their training.\n\n";

const DEFAULT: &str = "
## `default`

Figures of the closed assembly with the scores of these weights, divided by those without scores, on [the \
benchmark](benchmark.md): medians.

";

const PAPER: &str = "
## `paper-open` and `paper-tosca`

Means over the meshes of [paper.md](paper.md) for the paper's assembly with either file of weights, and for the \
closed assembly without a network. CD is in 1e-6 of the squared diagonal, NE the mean of 1 - |n.n'|, WA the edges without two faces in percent, and \
*open* the same without edges on the original's boundary. The paper's assembly does not move vertices, \
which limits its normals.

";

pub fn page(bench: &Bench) -> Result<String> {
    let rows = benchmark::evaluate_all(bench)?;
    let both = paper::settings(&["closed", "paper"]);
    let open = bench.evaluate_set("weights-open", "tosca", both, None)?;
    let tosca = bench.evaluate_set("weights-tosca", "tosca", paper::settings(&["paper"]), Some(paper::weights()))?;
    let lines =
        [("paper-open", "paper", &open), ("paper-tosca", "paper", &tosca), ("closed assembly", "closed", &open)];
    let scores = parts::sections(&bench.for_subsystems(&[Subsystem::Closed])?)?;
    Ok(format!("{INTRO}{scores}{DEFAULT}{}{PAPER}{}", network_table(&rows), tosca_table(&lines)))
}

fn network_table(rows: &Table) -> String {
    let quotients = Quotients { table: rows, over: "geometry" };
    let mut head = vec!["network / no scores".to_owned()];
    head.extend(RATIOS.map(|ratio| ratio.to_string()));
    head.push("all".into());
    let line = |figure: Figure| {
        let of = |ratios: &[f64]| number(quotients.median("network", figure, ratios));
        let cells = RATIOS.map(|ratio| of(&[ratio])).into_iter().chain([of(&RATIOS)]);
        [figure.title().to_owned()].into_iter().chain(cells).collect()
    };
    table(&head, &Figure::ALL.map(line))
}

fn tosca_table(lines: &[(&str, &str, &Table)]) -> String {
    const FIGURES: [(&str, &str, f64); 4] = [
        ("CD", "chamfer", 1e6),
        ("NE", "normal_error", 1.0),
        ("WA", "edges_without_two_faces", 1.0),
        ("open", "open_edges", 1.0),
    ];
    let mut head: Vec<String> = vec!["weights".into(), "ratio".into(), "results".into()];
    head.extend(FIGURES.map(|figure| figure.0.to_owned()));
    let line = |&(name, method, rows): &(&str, &str, &Table), ratio: f64| {
        let of: Vec<&ResultRow> = rows.rows.iter().filter(|row| row.method == method && row.ratio == ratio).collect();
        let n = of.iter().filter(|row| row.error.is_empty()).count();
        let mean = |name: &str| {
            let values: Vec<f64> = of.iter().filter_map(|row| rows.figure(row, name)).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let figures = FIGURES.map(|(_, name, scale)| match (name, mean(name)) {
            ("normal_error", Some(mean)) => format!("{mean:.4}"),
            (_, mean) => number(mean.map(|mean| scale * mean)),
        });
        [name.to_owned(), ratio.to_string(), format!("{n} of {}", of.len())].into_iter().chain(figures).collect()
    };
    let lines: Vec<Vec<String>> =
        lines.iter().flat_map(|of| RATIOS.iter().map(move |&ratio| line(of, ratio))).collect();
    table(&head, &lines)
}
