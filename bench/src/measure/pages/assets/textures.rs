//! Textured models against meshoptimizer with attributes.

use std::path::PathBuf;
use std::process::Command;

use crate::evaluate::median;
use anyhow::{Context, Result, ensure};

use super::super::{RATIOS, write_csv};
use crate::measure::markdown::{number, table};
use crate::measure::meshes::name;
use crate::measure::root;
use crate::measure::textured::{HEIGHT, ModelComparison, SAMPLES, compare_model};
use crate::measure::workbench::Bench;

// Models made by `scripts/textured_models.py`.
const MADE: [&str; 4] = ["planet", "vase", "terrain", "statue"];

pub fn section(bench: &Bench) -> Result<String> {
    let mut rows: Vec<(String, ModelComparison)> = Vec::new();
    let given = ["spot_textured/spot.obj", "duck.glb"].map(|file| bench.set_folder("test").join(file));
    for path in given.into_iter().chain(MADE.map(|name| PathBuf::from(name).with_extension("obj"))) {
        let of = bench.measure_once(&format!("textured/{}", name(&path)), || {
            compare_model(&make_model(bench, &path)?, &RATIOS)
        })?;
        rows.extend(of.into_iter().map(|row| (name(&path), row)));
    }
    Ok(format!(
        "## Textured models\n\nneural-mesh is compared with meshoptimizer's `simplifyWithAttributes` at the same \
         number of faces, with two weightings of attributes: *normals* is that of gltfpack (0.5 per component of a normal, 1 of a colour, 0 of texture coordinates); *uv* \
         adds 1 per texture coordinate. The table takes the better result of the two. Vertices are split where attributes differ; seams are \
         kept. Distance is the two-sided mean from {SAMPLES} samples on each surface; PSNR is that of textured pictures, {HEIGHT} pixels \
         high, from six sides.\n\nSpot is by Keenan Crane (CC0), the duck is a glTF sample of Khronos, and `scripts/textured_models.py` \
         makes the others. Each model: {}.\n\n{}",
        write_cases(&rows)?,
        summary(&rows)
    ))
}

fn make_model(bench: &Bench, path: &std::path::Path) -> Result<PathBuf> {
    if path.is_absolute() || path.exists() {
        return Ok(path.into());
    }
    let folder = bench.scratch("models")?;
    if !folder.join(path).exists() {
        let mut python = Command::new("python3");
        python
            .arg(root().join("scripts/textured_models.py"))
            .arg(bench.set_folder("train").join("obj_caballito.ply"))
            .arg(&folder);
        ensure!(python.status().context("python3")?.success(), "scripts/textured_models.py failed: it needs numpy");
    }
    Ok(folder.join(path))
}

fn summary(rows: &[(String, ModelComparison)]) -> String {
    let line = |name: String, rows: Vec<&ModelComparison>| {
        let better = rows.iter().filter(|row| row.gain() > 0.0).count();
        let gain = median(rows.iter().map(|row| row.gain()).collect()).unwrap_or_default();
        let quotient = number(median(rows.iter().map(|row| row.quotient()).collect()));
        vec![name, quotient, format!("{gain:+.2}"), format!("{better} of {}", rows.len())]
    };
    let at = |ratio: f64| rows.iter().map(|row| &row.1).filter(|row| row.ratio == ratio).collect();
    let mut lines: Vec<Vec<String>> = RATIOS.iter().map(|&ratio| line(ratio.to_string(), at(ratio))).collect();
    lines.push(line("all".into(), rows.iter().map(|row| &row.1).collect()));
    let head = ["ratio", "distance, quotient: median", "PSNR, difference in dB: median", "PSNR better on"];
    table(&head, &lines)
}

/// Writes each case, with the figures of neural-mesh and of both weightings of meshoptimizer.
fn write_cases(rows: &[(String, ModelComparison)]) -> Result<String> {
    const METHODS: [&str; 3] = ["neural-mesh", "meshoptimizer normals", "meshoptimizer uv"];
    let line = |(name, row): &(String, ModelComparison)| {
        let mut cells = vec![name.clone(), row.ratio.to_string()];
        cells.extend(row.faces.map(|n| n.to_string()));
        cells.extend(row.distances.map(|distance| format!("{:.3}", 1e3 * distance)));
        cells.push(number(Some(row.quotient())));
        cells.extend(row.likeness.map(|decibels| format!("{decibels:.2}")));
        cells.push(format!("{:+.2}", row.gain()));
        cells
    };
    let of_methods = |figure: &str| METHODS.map(|method| format!("{figure}: {method}"));
    let mut head: Vec<String> = ["model", "ratio"].map(String::from).into();
    head.extend(of_methods("faces"));
    head.extend(of_methods("distance in 1/1000 of the diagonal"));
    head.push("distance: quotient".into());
    head.extend(of_methods("PSNR in dB"));
    head.push("PSNR: difference".into());
    write_csv("assets-textured", &head, &rows.iter().map(line).collect::<Vec<_>>())
}
