//! The paper's Figure 6: geodesic and biharmonic distances on a mesh and its simplified versions.
//!
//! `cargo run --release -p neural-mesh-bench --example figure6 -- MESH PAPER_WEIGHTS OUT.png`

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use glam::DVec3;
use neural_mesh::io::read_path;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::metrics::CompareOptions;
use neural_mesh::model::Weights;
use neural_mesh::picture::{Image, PictureOptions, Scale, encode_png, render_painted};
use neural_mesh::simplify::{Options, PaperOptions, Size, simplify};
use neural_mesh_bench::along_surface::{Eigenpairs, HeatMethod, IntrinsicOptions, Judge, Laplacian};
use neural_mesh_bench::baselines::{Baseline, TargetCounts, simplify_by};

const EIGENPAIRS: usize = 200;
// Lines of equal distance in a picture.
const LINES: usize = 20;

const RATIO: f64 = 0.1;
const HEIGHT: usize = 300;

type Failure = Box<dyn Error>;

const KINDS: [&str; 2] = ["geodesic", "biharmonic"];

// Distances are per kind, one number per vertex; not finite where unreachable.
struct MeshDistances {
    name: &'static str,
    mesh: TriMesh,
    distances: [Vec<f64>; 2],
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, weights, out] = &arguments[..] else { return Err("usage: figure6 MESH PAPER_WEIGHTS OUT.png".into()) };
    let original = upright(&clean(read_path(Path::new(mesh), None)?, &CleanOptions::default())?.mesh)?;
    let results = results(&original, &Weights::from_bytes(&std::fs::read(weights)?)?)?;
    let source = end_of(&original);
    let along = IntrinsicOptions { eigenpairs: EIGENPAIRS, source: Some(source), ..IntrinsicOptions::default() };
    let judge = Judge::new(&original, &CompareOptions::default(), &along);
    let errors: Vec<[f64; 2]> = results.iter().map(|(_, mesh)| errors(&judge, mesh)).collect::<Result<_, _>>()?;
    let place = original.positions()[source as usize];
    let meshes = [("original", original)].into_iter().chain(results);
    let meshes = meshes.map(|(name, mesh)| measure_distances(name, mesh, place)).collect::<Result<Vec<_>, _>>()?;
    let picture = stack_images(&row(&meshes, &errors, 0), &row(&meshes, &errors, 1));
    std::fs::write(out, encode_png(&picture))?;
    print_errors(&meshes, &errors);
    Ok(())
}

fn upright(mesh: &TriMesh) -> Result<TriMesh, Failure> {
    // The z axis is up in TOSCA, the y axis in pictures.
    let positions = mesh.positions().iter().map(|&[x, y, z]| [y, z, x]).collect();
    Ok(TriMesh::new(positions, mesh.faces().to_vec())?)
}

fn results(mesh: &TriMesh, weights: &Weights) -> Result<Vec<(&'static str, TriMesh)>, Failure> {
    let target = Size::Ratio(RATIO);
    let ours = simplify_with(mesh, &Options::new(target))?;
    let paper = PaperOptions { weights: Some(weights.clone().into()), ..PaperOptions::default() };
    let paper = simplify_with(mesh, &Options::with_paper(target, paper))?;
    let size = TargetCounts { vertices: ours.positions().len(), faces: ours.faces().len() };
    let qem = simplify_by(Baseline::Qem, mesh, size, 0)?;
    Ok(vec![("closed", ours), ("paper", paper), ("qem", qem)])
}

fn simplify_with(mesh: &TriMesh, options: &Options) -> Result<TriMesh, Failure> {
    Ok(simplify(mesh, options, &mut |_| ControlFlow::Continue(()))?.mesh)
}

fn errors(judge: &Judge, mesh: &TriMesh) -> Result<[f64; 2], Failure> {
    let figures = judge.figures(mesh, mesh.positions().len());
    let value = |name: &str| figures.iter().find(|figure| figure.name == name)?.value;
    let both = value("geodesic_error").zip(value("biharmonic_error"));
    let (geodesic, biharmonic) = both.ok_or("the distances cannot be measured")?;
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

fn measure_distances(name: &'static str, mesh: TriMesh, place: [f32; 3]) -> Result<MeshDistances, Failure> {
    let laplacian = Laplacian::new(&mesh).ok_or("the mesh has no area")?;
    let to_place = |&at: &usize| {
        let vertex = laplacian.vertices[at] as usize;
        point(&mesh.positions()[vertex]).distance(point(&place))
    };
    let nearest = (0..laplacian.vertices.len()).min_by(|a, b| to_place(a).total_cmp(&to_place(b)));
    let source = nearest.ok_or("the mesh has no faces")? as u32;
    let heat = HeatMethod::new(&laplacian).ok_or("the Laplacian cannot be factored")?;
    let n_pairs = EIGENPAIRS.min(laplacian.vertices.len() / 4);
    let pairs = Eigenpairs::compute_lowest(&laplacian, n_pairs).ok_or("the eigenpairs were not found")?;
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

fn print_errors(meshes: &[MeshDistances], errors: &[[f64; 2]]) {
    println!("| mesh | vertices | faces | geodesic error, % | biharmonic error, % |\n|---|---|---|---|---|");
    for (MeshDistances { name, mesh, .. }, [geodesic, biharmonic]) in meshes[1..].iter().zip(errors) {
        let [vertices, faces] = [mesh.positions().len(), mesh.faces().len()];
        println!("| {name} | {vertices} | {faces} | {geodesic:.3} | {biharmonic:.3} |");
    }
}
