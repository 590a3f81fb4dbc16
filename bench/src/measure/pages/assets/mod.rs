//! Measurements of asset features.

mod certain;
mod levels;
mod mirrored;
mod textures;

use crate::evaluate::Settings;
use anyhow::Result;

use super::RATIOS;
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
    let mut lines: Vec<Vec<String>> = quotients.meshes().into_iter().map(line).collect();
    let mut all = vec!["median of all".to_owned()];
    figures.iter().for_each(|&figure| all.extend([number(quotients.median("closed", figure, &RATIOS)), String::new()]));
    lines.push(all);
    Ok(format!(
        "## Machine parts\n\nQuotients over meshoptimizer's `simplify` at the same number of faces, for the {} training meshes that are \
         machine parts: the median over the ratios 0.05, 0.1, 0.2 and 0.5, and the worst of the four.\n\n{}",
        lines.len() - 1,
        table(&head, &lines)
    ))
}
