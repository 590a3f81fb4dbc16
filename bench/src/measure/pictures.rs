//! Pictures of meshes before and after, and the paper's Figure 6.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use neural_mesh::io::write_path;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::picture::{PictureOptions, encode_png, render};
use neural_mesh::simplify::{Options, Size};

use super::bench::{Bench, Blocks};
use super::figure6;
use super::meshes::load;
use crate::baselines::{Baseline, TargetCounts, simplify_by};
use crate::cells::count;
use crate::evaluate::simplify_ours;
use crate::rows::ResultRow;

// All licences allow pictures of these meshes.
const MESHES: [(&str, &str, f64); 6] = [
    ("test", "spot", 0.2),
    ("test", "nefertiti", 0.05),
    ("test", "suzanne", 0.5),
    ("train", "obj_deer", 0.1),
    ("train", "csg_engine_block", 0.1),
    ("train", "proc_gyroid_ball", 0.05),
];
const HEIGHT: usize = 440;
const SAMPLES: usize = 100_000;

pub fn measure(bench: &Bench) -> Result<Blocks> {
    let path = |set: &str, mesh: &str| bench.set_folder(set).join(mesh).with_extension("ply");
    let items = MESHES.map(|(set, mesh, ratio)| (mesh.to_owned(), (path(set, mesh), ratio)));
    let drawn = bench.measure("pictures", &["before", "after"], items, |name, item| draw_mesh(bench, name, item))?;
    let heading = |(_, mesh, _): (&str, &'static str, f64)| {
        let row = drawn.rows.iter().find(|row| row.mesh == mesh);
        let [before, after] = ["before", "after"]
            .map(|figure| count(row.and_then(|row| drawn.value(row, figure)).unwrap_or_default() as usize));
        (mesh, format!("## {mesh}, {after} faces of {before}\n"))
    };
    let cat = bench.set_folder("tosca").join("cat0.ply");
    let figure6 = figure6::draw(&cat, &bench.output("docs/measured/figure6.png"))?;
    Ok(MESHES.map(heading).into_iter().chain([("figure-6", figure6)]).collect())
}

fn draw_mesh(bench: &Bench, name: &str, (path, ratio): &(PathBuf, f64)) -> Result<Vec<ResultRow>> {
    let mesh = load(Path::new(path))?;
    let ours = simplify_ours(&mesh, None, Options::new(Size::Ratio(*ratio)))?;
    let size = TargetCounts { vertices: ours.positions().len(), faces: ours.faces().len() };
    let theirs = simplify_by(Baseline::Meshoptimizer, &mesh, size, 0)?;
    let original = Surface::new(&mesh, SAMPLES, 0);
    let caption = |method: &str, lighter: &TriMesh| {
        let found = surface_distance(&original, &Surface::new(lighter, SAMPLES, 1)).context("no faces")?;
        let (mean, normals) = (1e4 * found.both.mean / found.diagonal, found.both.normal_error);
        let n_faces = lighter.faces().len();
        Ok::<_, anyhow::Error>(format!("{method}: {n_faces} faces\ndistance {mean:.2}e-4, normals {normals:.4}"))
    };
    let captions = vec![
        format!("{} faces", mesh.faces().len()),
        caption("neural-mesh", &ours)?,
        caption("meshoptimizer", &theirs)?,
    ];
    let mut options = PictureOptions::default();
    (options.height, options.captions) = (HEIGHT, captions);
    let image = render(&[&mesh, &ours, &theirs], &options);
    write_path(&bench.output(&format!("docs/measured/{name}.png")), &encode_png(&image), true)?;
    Ok(vec![ResultRow::new(name, *ratio, "closed", &[mesh.faces().len() as f64, ours.faces().len() as f64])])
}
