//! Measurements of asset features.

mod certain;
mod levels;
mod mirrored;
mod textures;

use crate::evaluate::{Settings, median};
use anyhow::Result;

use super::{RATIOS, write_csv};
use crate::measure::markdown::{number, table};
use crate::measure::quotients::{Figure, Quotients};
use crate::measure::workbench::Bench;

const PARTS: [&str; 6] = ["csg_", "jaco_", "so101_", "soarm_", "wingnut", "hammer"];

pub fn page(bench: &Bench) -> Result<String> {
    let sections = [
        textures::section(bench)?,
        parts_of_machines(bench)?,
        certain::section(bench)?,
        levels::section(bench)?,
        mirrored::section(bench)?,
    ];
    Ok(format!("The options are described in [assets.md](../assets.md).\n\n{}", sections.join("\n")))
}

fn parts_of_machines(bench: &Bench) -> Result<String> {
    let settings = Settings {
        methods: ["closed", "meshopt"].map(String::from).into(),
        ratios: RATIOS.into(),
        repeats: 1,
        only: PARTS.map(String::from).into(),
        ..Settings::default()
    };
    let rows = bench.evaluate_set("parts-of-machines", "train", settings, None)?;
    let quotients = Quotients { table: &rows, over: "meshopt" };
    let figures = [Figure::Distance, Figure::Largest, Figure::Normals];
    let mut head = vec!["part".to_owned()];
    figures.iter().for_each(|figure| head.extend([figure.title().to_owned(), "worst ratio".into()]));
    let line = |mesh: String| {
        let mut cells = vec![mesh.trim_end_matches(".ply").to_owned()];
        for figure in figures {
            let each = RATIOS.map(|ratio| quotients.median_of_mesh(&mesh, "closed", figure, &[ratio]));
            let worst = each.into_iter().flatten().reduce(f64::max);
            cells.extend([number(quotients.median_of_mesh(&mesh, "closed", figure, &RATIOS)), number(worst)]);
        }
        cells
    };
    let lines: Vec<Vec<String>> = quotients.meshes().into_iter().map(line).collect();
    let link = write_csv("assets-machine-parts", &head, &lines)?;
    let head = ["", "mean distance", "largest distance", "normal error"];
    let row = |name: &str, value: &dyn Fn(Figure) -> Option<f64>| {
        [name.to_owned()].into_iter().chain(figures.map(|figure| number(value(figure)))).collect::<Vec<String>>()
    };
    let rows = [
        row("median", &|figure| quotients.median("closed", figure, &RATIOS)),
        row("worst", &|figure| quotients.worst("closed", figure, &RATIOS).map(|worst| worst.quotient)),
    ];
    Ok(format!(
        "## Machine parts\n\nQuotients over meshoptimizer's `simplify` at the same number of faces, for the {} training meshes that are \
         machine parts and the ratios 0.05, 0.1, 0.2 and 0.5. Each part: {link}.\n\n{}",
        lines.len(),
        table(&head, &rows)
    ))
}

/// Formats one row each for the median, least and largest value of every column.
fn spread_rows(columns: &[Vec<f64>]) -> [Vec<String>; 3] {
    let row = |name: &str, of: &dyn Fn(&[f64]) -> Option<f64>| {
        [name.to_owned()].into_iter().chain(columns.iter().map(|column| number(of(column)))).collect()
    };
    [
        row("median", &|column| median(column.to_vec())),
        row("least", &|column| column.iter().copied().reduce(f64::min)),
        row("largest", &|column| column.iter().copied().reduce(f64::max)),
    ]
}
