//! Mirrored results against plain ones of the same size.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{ClosedOptions, Options, Symmetry, Target, simplify};
use serde::{Deserialize, Serialize};

use super::super::write_csv;
use super::spread_rows;
use crate::measure::hausdorff::hausdorff_distance;
use crate::measure::markdown::{count, number, table};
use crate::measure::meshes::{load, name};
use crate::measure::workbench::Bench;

const RATIOS: [f64; 3] = [0.3, 0.1, 0.05];
const SAMPLES: usize = 50_000;

#[derive(Serialize, Deserialize)]
struct MirroredCase {
    mesh: String,
    vertices: usize,
    plane: String,
    // Mean and largest distance of the mirrored result, divided by the plain result's, at each ratio.
    quotients: [[f64; 2]; 3],
}

pub fn section(bench: &Bench) -> Result<String> {
    let mut meshes = bench.meshes("train")?;
    // Poses of a class share their connectivity; the first pose, number 0, is symmetric.
    meshes.extend(bench.meshes("tosca")?.into_iter().filter(|path| name(path).ends_with('0')));
    let mut rows: Vec<MirroredCase> = Vec::new();
    for path in meshes {
        rows.extend(
            bench.measure_once::<Option<MirroredCase>>(&format!("mirrored/{}", name(&path)), || measure(&path))?,
        );
    }
    let line = |row: &MirroredCase| {
        let mut cells = vec![row.mesh.clone(), row.vertices.to_string(), row.plane.clone()];
        cells.extend((0..2).flat_map(|figure| row.quotients.map(|of| number(Some(of[figure])))));
        cells
    };
    let lines: Vec<Vec<String>> = rows.iter().map(line).collect();
    let mut head: Vec<String> = ["mesh", "vertices", "plane"].map(String::from).into();
    head.extend(["mean", "largest"].iter().flat_map(|figure| RATIOS.map(|ratio| format!("{figure} at {ratio}"))));
    let link = write_csv("assets-mirrored", &head, &lines)?;
    let places = (0..2).flat_map(|figure| (0..RATIOS.len()).map(move |ratio| (ratio, figure)));
    let column = |(ratio, figure): (usize, usize)| rows.iter().map(|row| row.quotients[ratio][figure]).collect();
    let columns: Vec<Vec<f64>> = places.map(column).collect();
    head.drain(1..3);
    head[0].clear();
    Ok(format!(
        "## Mirrored\n\nQuotients of `--symmetric` over results without this option with the same number of \
         vertices: mean distances from {} samples on \
         each surface, and largest distances. The {} meshes are those of the training set and of TOSCA's first poses that have a mirror \
         plane across an axis. Each mesh: {link}.\n\n{}",
        count(SAMPLES),
        rows.len(),
        table(&head, &spread_rows(&columns))
    ))
}

fn measure(path: &Path) -> Result<Option<MirroredCase>> {
    let mesh = load(path)?;
    let original = Surface::new(&mesh, SAMPLES, 0);
    let mut row = MirroredCase {
        mesh: name(path),
        vertices: mesh.positions().len(),
        plane: String::new(),
        quotients: [[0.0; 2]; 3],
    };
    for (ratio, quotients) in RATIOS.into_iter().zip(&mut row.quotients) {
        let plain = Options::new(Target::Ratio(ratio));
        let mirrored = ClosedOptions { symmetric: Some(Symmetry::Best), ..ClosedOptions::default() };
        let mirrored = Options::with_closed(plain.target, mirrored);
        // Most meshes have no mirror plane.
        let Ok(ours) = simplify(&mesh, None, &mirrored, &mut |_| ControlFlow::Continue(())) else { return Ok(None) };
        let Some(plane) = ours.report.mirror else { return Ok(None) };
        row.plane = format!("{} = {:.4}", plane.axis, plane.at).trim_end_matches('0').trim_end_matches('.').to_owned();
        let other = simplify(&mesh, None, &plain, &mut |_| ControlFlow::Continue(()))?;
        let distances = |result: &TriMesh| -> Result<[f64; 2]> {
            let found = surface_distance(&original, &Surface::new(result, SAMPLES, 1)).context("no faces")?;
            Ok([found.both.mean, hausdorff_distance(&mesh, result)?])
        };
        let (ours, other) = (distances(&ours.mesh)?, distances(&other.mesh)?);
        *quotients = [ours[0] / other[0], ours[1] / other[1]];
    }
    Ok(Some(row))
}
