//! The paper's Figure 6: geodesic and biharmonic distances on a mesh and its simplified versions.

use std::path::Path;

use anyhow::{Context, Result};
use glam::DVec3;
use neural_mesh::io::write_path;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::CompareOptions;
use neural_mesh::model::Weights;
use neural_mesh::picture::{Image, PictureOptions, Scale, encode_png, render_painted};
use neural_mesh::simplify::{Options, PaperOptions, Size};

use super::bench::tosca_weights;
use super::meshes::load;
use crate::along_surface::{EIGENPAIRS, Eigenpairs, HeatMethod, Judge, Laplacian};
use crate::baselines::{Baseline, TargetCounts, simplify_by};
use crate::evaluate::simplify_ours;

// Lines of equal distance in a picture.
const LINES: usize = 20;

const RATIO: f64 = 0.1;
const HEIGHT: usize = 300;

const KINDS: [&str; 2] = ["geodesic", "biharmonic"];

// Distances are per kind, one number per vertex; not finite where unreachable.
struct MeshDistances {
    name: &'static str,
    mesh: TriMesh,
    distances: [Vec<f64>; 2],
}

/// Draws a mesh of TOSCA and its results, and returns the table of their errors.
pub fn draw(mesh: &Path, out: &Path) -> Result<String> {
    let original = upright(&load(mesh)?)?;
    let results = results(&original, &Weights::from_bytes(&std::fs::read(tosca_weights())?)?)?;
    let source = end_of(&original);
    let judge = Judge::new(&original, &CompareOptions::default(), Some(EIGENPAIRS));
    let errors: Vec<[f64; 2]> = results.iter().map(|(_, mesh)| errors(&judge, mesh)).collect::<Result<_>>()?;
    let place = original.positions()[source as usize];
    let meshes = [("original", original)].into_iter().chain(results);
    let meshes = meshes.map(|(name, mesh)| measure_distances(name, mesh, place)).collect::<Result<Vec<_>>>()?;
    let picture = stack_images(&row(&meshes, &errors, 0), &row(&meshes, &errors, 1));
    write_path(out, &encode_png(&picture), true)?;
    Ok(error_table(&meshes, &errors))
}

fn upright(mesh: &TriMesh) -> Result<TriMesh> {
    // The z axis is up in TOSCA, the y axis in pictures.
    let positions = mesh.positions().iter().map(|&[x, y, z]| [y, z, x]).collect();
    Ok(TriMesh::new(positions, mesh.faces().to_vec())?)
}

fn results(mesh: &TriMesh, weights: &Weights) -> Result<Vec<(&'static str, TriMesh)>> {
    let target = Size::Ratio(RATIO);
    let ours = simplify_ours(mesh, None, Options::new(target))?;
    let paper = simplify_ours(mesh, Some(weights), Options::with_paper(target, PaperOptions::default()))?;
    let size = TargetCounts { vertices: ours.positions().len(), faces: ours.faces().len() };
    let qem = simplify_by(Baseline::Qem, mesh, size, 0)?;
    Ok(vec![("closed", ours), ("paper", paper), ("qem", qem)])
}

fn errors(judge: &Judge, mesh: &TriMesh) -> Result<[f64; 2]> {
    let figures = judge.figures(mesh, mesh.positions().len());
    let value = |name: &str| figures.iter().find(|figure| figure.name == name)?.value;
    let both = value("geodesic_error").zip(value("biharmonic_error"));
    let (geodesic, biharmonic) = both.context("the distances cannot be measured")?;
    Ok([geodesic, biharmonic])
}

fn point(p: &[f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

fn end_of(mesh: &TriMesh) -> u32 {
    let points: Vec<DVec3> = mesh.positions().iter().map(point).collect();
    let [low, high] = [DVec3::min, DVec3::max].map(|end| points.iter().copied().reduce(end).unwrap_or_default());
    let distance = |&v: &usize| points[v].distance(low.midpoint(high));
    let end = (0..points.len()).max_by(|a, b| distance(a).total_cmp(&distance(b)));
    end.unwrap_or_default() as u32
}

fn measure_distances(name: &'static str, mesh: TriMesh, place: [f32; 3]) -> Result<MeshDistances> {
    let laplacian = Laplacian::new(&mesh).context("the mesh has no area")?;
    let to_place = |&at: &usize| {
        let vertex = laplacian.vertices[at] as usize;
        point(&mesh.positions()[vertex]).distance(point(&place))
    };
    let nearest = (0..laplacian.vertices.len()).min_by(|a, b| to_place(a).total_cmp(&to_place(b)));
    let source = nearest.context("the mesh has no faces")? as u32;
    let heat = HeatMethod::new(&laplacian).context("the Laplacian cannot be factored")?;
    let n_pairs = EIGENPAIRS.min(laplacian.vertices.len() / 4);
    let pairs = Eigenpairs::compute_lowest(&laplacian, n_pairs).context("the eigenpairs were not found")?;
    let geodesic = heat.distances(&laplacian, source);
    let mut biharmonic = pairs.biharmonic_distances(source, n_pairs);
    for (distance, along) in biharmonic.iter_mut().zip(&geodesic).filter(|(_, along)| !along.is_finite()) {
        *distance = *along;
    }
    let at_vertices = |at_places: Vec<f64>| {
        let mut values = vec![f64::NAN; mesh.positions().len()];
        laplacian.vertices.iter().zip(at_places).for_each(|(&v, value)| values[v as usize] = value);
        values
    };
    Ok(MeshDistances { name, distances: [geodesic, biharmonic].map(at_vertices), mesh })
}

fn row(meshes: &[MeshDistances], errors: &[[f64; 2]], kind: usize) -> Image {
    // Colours end at the original's largest distance.
    let on_original = meshes[0].distances[kind].iter().copied();
    let end = on_original.filter(|distance| distance.is_finite()).fold(f64::MIN_POSITIVE, f64::max);
    let error = |at: usize| match at {
        0 => KINDS[kind].to_owned(),
        _ => format!("{}, error {:.2} %", KINDS[kind], errors[at - 1][kind]),
    };
    let caption = |(at, MeshDistances { name, mesh, .. }): (usize, &MeshDistances)| {
        format!("{name}\n{} vertices\n{}", mesh.positions().len(), error(at))
    };
    let captions = meshes.iter().enumerate().map(caption).collect();
    let mut options = PictureOptions::default();
    (options.height, options.captions, options.edges) = (HEIGHT, captions, false);
    let painted: Vec<(&TriMesh, &[f64])> =
        meshes.iter().map(|measured| (&measured.mesh, measured.distances[kind].as_slice())).collect();
    render_painted(&painted, &Scale { end, lines: LINES }, &options)
}

fn stack_images(upper: &Image, lower: &Image) -> Image {
    let rgba = [upper.rgba.as_slice(), &lower.rgba].concat();
    Image { width: upper.width, height: upper.height + lower.height, rgba }
}

fn error_table(meshes: &[MeshDistances], errors: &[[f64; 2]]) -> String {
    let head = "| mesh | vertices | faces | geodesic error, % | biharmonic error, % |\n|---|---|---|---|---|\n";
    let line = |(MeshDistances { name, mesh, .. }, [geodesic, biharmonic]): (&MeshDistances, &[f64; 2])| {
        let [vertices, faces] = [mesh.positions().len(), mesh.faces().len()];
        format!("| {name} | {vertices} | {faces} | {geodesic:.3} | {biharmonic:.3} |\n")
    };
    head.to_owned() + &meshes[1..].iter().zip(errors).map(line).collect::<String>()
}
