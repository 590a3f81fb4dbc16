//! The shipped weights: contents, training and results.

use crate::evaluate::{ResultRow, Table};
use anyhow::Result;

use super::{RATIOS, benchmark, paper};
use crate::measure::markdown::{number, table};
use crate::measure::quotients::{Figure, Quotients};
use crate::measure::workbench::Bench;

const DEFAULT: &str = "\
All can be made again with `neural-mesh train` ([training.md](../training.md)). They have the repository's licence, except \
`paper-tosca` ([its own](../../weights/LICENSE-paper-tosca.md)).

## `default`: scores for the closed assembly

| | |
|---|---|
| network | Point Sampler: one DevConv over positions and normals, 16 wide, a hidden layer of 16, one score |
| file | `weights/default.safetensors`, 4 KB, embedded in the library |
| data | 139 open meshes (humans, animals, statues, household things, robot and CAD parts, procedural shapes): 116 to train, 23 of ten families to validate |
| loss | first a formula for the surface's bending, then the measured errors of results |

The last weights of the second run are shipped:

```
neural-mesh train --data TRAIN --out A --config weights/default-1.toml
neural-mesh train --data TRAIN --out B --config weights/default-2.toml --init A/last.safetensors
```

The closed assembly with these scores over the same without scores, on [the benchmark](benchmark.md): medians of quotients.

";

const PAPER: &str = "
Effects of the formula, of shuffled weights and of each stage: [parts.md](parts.md).

## `paper-open` and `paper-tosca`: the network of the paper

| | `paper-open` | `paper-tosca` |
|---|---|---|
| network | three stages, 32 wide, 14,658 parameters | the same |
| file | `weights/paper-open.safetensors`, 60 KB, embedded; used by `--assembly paper` and `mesh-points` where no weights are given | `weights/paper-tosca.safetensors`, for research use, not in the published crate |
| data | as above | TOSCA without cat, gorilla, victoria, wolf: 50 meshes |

The first two commands make `paper-open`; in the second run every second step is on a cloud. The third makes `paper-tosca`.

```
neural-mesh train --data TRAIN --out A --config weights/paper-open.toml
neural-mesh train --data TRAIN --out B --config weights/paper-open-2.toml --init A/last.safetensors
neural-mesh train --data TOSCA --out RUN --config weights/paper-tosca.toml
```

Each file holds the last weights of its run; nothing is selected by the meshes below. The paper's assembly keeps vertices where \
they were, so it cannot reach the normals of QEM, which moves them.

Means over the meshes of [paper.md](paper.md) for the paper's assembly with both, and for the closed assembly, which uses no \
network. CD is in 1e-6 of the squared diagonal, NE the mean of 1 - |n.n'|, WA the edges without two faces in percent, and *open* \
those of them off the original's boundary.

";

pub fn page(bench: &Bench) -> Result<String> {
    let rows = benchmark::evaluate_all(bench)?;
    let both = paper::settings(&["closed", "paper"]);
    let open = bench.evaluate_set("weights-open", "tosca", both, None)?;
    let tosca = bench.evaluate_set("weights-tosca", "tosca", paper::settings(&["paper"]), Some(paper::weights()))?;
    let lines =
        [("paper-open", "paper", &open), ("paper-tosca", "paper", &tosca), ("closed assembly", "closed", &open)];
    Ok(format!("{DEFAULT}{}{PAPER}{}", network_table(&rows), tosca_table(&lines)))
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
