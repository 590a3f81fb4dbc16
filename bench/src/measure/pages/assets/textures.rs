//! Textured models against meshoptimizer with attributes.

use std::path::PathBuf;
use std::process::Command;

use crate::evaluate::median;
use anyhow::{Context, Result, ensure};

use super::super::RATIOS;
use crate::measure::markdown::{number, table};
use crate::measure::meshes::name;
use crate::measure::root;
use crate::measure::textured::{HEIGHT, Measured, SAMPLES, measured};
use crate::measure::workbench::Bench;

/// Models that the script makes, of formulas and of a training mesh.
const MADE: [&str; 4] = ["planet", "vase", "terrain", "statue"];

pub fn section(bench: &Bench) -> Result<String> {
    let mut rows: Vec<(String, Measured)> = Vec::new();
    let given = ["spot_textured/spot.obj", "duck.glb"].map(|file| bench.set("test").join(file));
    for path in given.into_iter().chain(MADE.map(|name| PathBuf::from(name).with_extension("obj"))) {
        let of = bench.kept(&format!("textured/{}", name(&path)), || measured(&made(bench, &path)?, &RATIOS))?;
        rows.extend(of.into_iter().map(|row| (name(&path), row)));
    }
    Ok(format!(
        "## Textured models\n\nAgainst meshoptimizer's `simplifyWithAttributes` at the same number of faces, by two weightings: *normals* \
         as in its own gltfpack (each number of a normal 0.5, of a colour 1, texture coordinates nothing), *uv* each texture coordinate 1 \
         beside that. Where one number stands for both, the better one counts. Vertices are split where attributes differ, seams are kept. \
         Distance is the two-sided mean from {SAMPLES} samples on each surface; PSNR that of textured pictures, {HEIGHT} pixels high, from \
         six sides.\n\nSpot is Keenan Crane's (CC0), the duck a glTF sample of Khronos; the others are made by \
         `scripts/textured_models.py`.\n\n{}\n{}",
        summary(&rows),
        every_case(&rows)
    ))
}

/// A model that the script makes is made if it is not there.
fn made(bench: &Bench, path: &std::path::Path) -> Result<PathBuf> {
    if path.is_absolute() || path.exists() {
        return Ok(path.into());
    }
    let folder = bench.scratch("models")?;
    if !folder.join(path).exists() {
        let mut python = Command::new("python3");
        python
            .arg(root().join("scripts/textured_models.py"))
            .arg(bench.set("train").join("obj_caballito.ply"))
            .arg(&folder);
        ensure!(python.status().context("python3")?.success(), "scripts/textured_models.py failed: it needs numpy");
    }
    Ok(folder.join(path))
}

fn summary(rows: &[(String, Measured)]) -> String {
    let line = |name: String, rows: Vec<&Measured>| {
        let better = rows.iter().filter(|row| row.gain() > 0.0).count();
        let gain = median(rows.iter().map(|row| row.gain()).collect()).unwrap_or_default();
        let quotient = number(median(rows.iter().map(|row| row.quotient()).collect()));
        vec![name, quotient, format!("{gain:+.2}"), format!("{better} of {}", rows.len())]
    };
    let at = |ratio: f64| rows.iter().map(|row| &row.1).filter(|row| row.ratio == ratio).collect();
    let mut lines: Vec<Vec<String>> = RATIOS.iter().map(|&ratio| line(ratio.to_string(), at(ratio))).collect();
    lines.push(line("all".into(), rows.iter().map(|row| &row.1).collect()));
    let head = ["ratio", "distance, ours / theirs: median", "PSNR, ours - theirs, dB: median", "PSNR better on"];
    table(&head, &lines)
}

fn every_case(rows: &[(String, Measured)]) -> String {
    let line = |(name, row): &(String, Measured)| {
        vec![
            name.clone(),
            row.ratio.to_string(),
            row.faces.map(|n| n.to_string()).join(" / "),
            row.distances.map(|distance| format!("{:.3}", 1e3 * distance)).join(" / "),
            number(Some(row.quotient())),
            row.likeness.map(|decibels| format!("{decibels:.2}")).join(" / "),
            format!("{:+.2}", row.gain()),
        ]
    };
    let head =
        ["model", "ratio", "faces", "distance, 1/1000 of the diagonal", "ours / theirs", "PSNR, dB", "ours - theirs"];
    format!("Ours / *normals* / *uv*:\n\n{}", table(&head, &rows.iter().map(line).collect::<Vec<_>>()))
}
