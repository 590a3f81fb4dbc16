//! Simplifies a mesh and writes its metrics and samples for `scripts/agreement`.
//!
//! `cargo run --release -p neural-mesh-bench --example measure -- MESH OUT_DIR`

use std::error::Error;
use std::path::Path;

use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{Frame, TriMesh};
use neural_mesh::metrics::{CompareOptions, Surface, self_intersecting_faces, surface_distance};
use neural_mesh::simplify::{Options, Size, simplify};
use neural_mesh_bench::along_surface::{EIGENPAIRS, Eigenpairs, HeatMethod, Judge, Laplacian};

const SAMPLES: usize = 50_000;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, folder] = &arguments[..] else { return Err("usage: measure MESH OUT_DIR".into()) };
    let original = clean(read_path(Path::new(mesh), None)?, &CleanOptions::default())?.mesh;
    let options = Options::new(Size::Ratio(0.1));
    let simplified = simplify(&original, &options, &mut |_| std::ops::ControlFlow::Continue(()))?.mesh;
    let folder = Path::new(folder);
    std::fs::create_dir_all(folder)?;
    for (name, mesh) in [("original.ply", &original), ("simplified.ply", &simplified)] {
        write_path(&folder.join(name), &write(mesh, &Frame::default(), Format::Ply)?, true)?;
    }
    let mut fields = distances(&original, &simplified)?;
    fields.extend(along_surface(&original)?);
    fields.push(("crossing".into(), format!("{:?}", self_intersecting_faces(&original))));
    fields.push(("crossing_simplified".into(), format!("{:?}", self_intersecting_faces(&simplified))));
    let mut judging = CompareOptions::default();
    judging.samples = SAMPLES;
    let judge = Judge::new(&original, &judging, Some(EIGENPAIRS));
    let figures = judge.figures(&simplified, simplified.positions().len());
    fields.extend(figures.iter().map(|figure| (figure.name.into(), json(figure.value))));
    let lines: Vec<String> = fields.iter().map(|(name, value)| format!("\"{name}\": {value}")).collect();
    std::fs::write(folder.join("measured.json"), format!("{{\n{}\n}}\n", lines.join(",\n")))?;
    Ok(())
}

fn json(value: Option<f64>) -> String {
    value.map_or("null".into(), |value| format!("{value:?}"))
}

fn distances(original: &TriMesh, simplified: &TriMesh) -> Result<Vec<(String, String)>, Box<dyn Error>> {
    let [original, simplified] = [(original, 0), (simplified, 1)].map(|(mesh, seed)| Surface::new(mesh, SAMPLES, seed));
    let distance = surface_distance(&original, &simplified).ok_or("one of the meshes has no faces")?;
    let points = |surface: &Surface| format!("{:?}", surface.samples.iter().map(|p| p.to_array()).collect::<Vec<_>>());
    Ok(vec![
        ("samples".into(), points(&original)),
        ("samples_simplified".into(), points(&simplified)),
        ("forward".into(), format!("{:?}", [distance.forward.mean, distance.forward.rms, distance.forward.max])),
        ("backward".into(), format!("{:?}", [distance.backward.mean, distance.backward.rms, distance.backward.max])),
    ])
}

fn along_surface(mesh: &TriMesh) -> Result<Vec<(String, String)>, Box<dyn Error>> {
    let laplacian = Laplacian::new(mesh).ok_or("the mesh has no area")?;
    let heat = HeatMethod::new(&laplacian).ok_or("the Laplacian cannot be factored")?;
    let pairs = Eigenpairs::compute_lowest(&laplacian, EIGENPAIRS).ok_or("the eigenpairs were not found")?;
    let geodesic: Vec<Option<f64>> =
        heat.distances(&laplacian, 0).into_iter().map(|d| Some(d).filter(|d| d.is_finite())).collect();
    let geodesic: Vec<String> = geodesic.into_iter().map(json).collect();
    Ok(vec![
        ("vertices_in_use".into(), format!("{:?}", laplacian.vertices)),
        ("eigenvalues".into(), format!("{:?}", pairs.values)),
        ("geodesic".into(), format!("[{}]", geodesic.join(","))),
        ("biharmonic".into(), format!("{:?}", pairs.biharmonic_distances(0, EIGENPAIRS))),
    ])
}
