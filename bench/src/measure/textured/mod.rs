//! Textured models against meshoptimizer.

mod attributed;

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result};
use neural_mesh::appearance::VIEWS;
use neural_mesh::io::{Asset, Format, read_attributed_path};
use neural_mesh::job::{Arguments, Document, RatioOf};
use neural_mesh::mesh::Looks;
use neural_mesh::metrics::{Surface, psnr, surface_distance};
use neural_mesh::picture::{CornerNormals, DecodedMaterials, ShadedMesh, view_shaded};
use neural_mesh::simplify::{Input, Options, Size, simplify};

use crate::rows::ResultRow;

use attributed::{AttributedMesh, Weighting, simplify_weighted};

struct Model {
    attributed: AttributedMesh,
    looks: Looks,
}

impl Model {
    /// Reads a model as the program does, and prints what it lacks.
    fn read(path: &Path) -> Result<Self> {
        let job = Arguments { ratio: vec![RatioOf { name: None, share: 0.5 }], ..Arguments::default() };
        let job = job.job_as(Format::Glb)?;
        let document = match Format::from_path(path) {
            Some(Format::Gltf | Format::Glb) => Document::from_asset(Asset::read_path(path)?, &job)?,
            _ => Document::from_mesh(read_attributed_path(path, None)?, &job)?,
        };
        let (looks, notes) = document.looks(false);
        notes.iter().for_each(|note| eprintln!("{}: {note}", path.display()));
        let attributed = AttributedMesh { mesh: document.mesh().clone(), attributes: document.attributes().clone() };
        Ok(Self { attributed, looks })
    }
}

const SAMPLES: usize = 50_000;
const HEIGHT: usize = 384;

/// Simplifies a model by neural-mesh and by meshoptimizer with each weighting; rows have faces, distance and likeness.
///
/// Distances are two-sided means as fractions of the diagonal, likenesses are PSNR against the original's pictures, in
/// decibels. Our row also has its distance over the better one of meshoptimizer, and its gain over the better likeness.
pub fn compare_model(name: &str, path: &Path, ratios: &[f64]) -> Result<Vec<ResultRow>> {
    let model = Model::read(path).with_context(|| path.display().to_string())?;
    Ok(ratios.iter().map(|&ratio| compare_at_ratio(name, &model, ratio)).collect::<Result<Vec<_>>>()?.concat())
}

fn compare_at_ratio(name: &str, model: &Model, ratio: f64) -> Result<Vec<ResultRow>> {
    let ours = simplify_ours(&model.attributed, ratio)?;
    let [first, second] =
        Weighting::ALL.map(|weighting| simplify_weighted(&model.attributed, ours.mesh.faces().len(), weighting));
    let contestants = [ours, first?, second?];
    let original = Surface::new(&model.attributed.mesh, SAMPLES, 0);
    let mut distances = [0.0; 3];
    for (distance, attributed) in distances.iter_mut().zip(&contestants) {
        let found = surface_distance(&original, &Surface::new(&attributed.mesh, SAMPLES, 1)).context("no faces")?;
        *distance = found.both.mean / found.diagonal;
    }
    let likeness = picture_likeness(model, &contestants)?;
    let quotient = distances[0] / distances[1].min(distances[2]);
    let gain = likeness[0] - likeness[1].max(likeness[2]);
    let row = |at: usize, method: &str, [quotient, gain]: [f64; 2]| {
        let n_faces = contestants[at].mesh.faces().len() as f64;
        ResultRow::new(name, ratio, method, &[n_faces, distances[at], likeness[at], quotient, gain])
    };
    Ok(vec![row(0, "ours", [quotient, gain]), row(1, "normals", [f64::NAN; 2]), row(2, "uv", [f64::NAN; 2])])
}

fn simplify_ours(original: &AttributedMesh, ratio: f64) -> Result<AttributedMesh> {
    let mut input = Input::bare(&original.mesh);
    input.attributes = &original.attributes;
    let options = Options::new(Size::Ratio(ratio));
    let result = simplify(input, &options, &mut |_| ControlFlow::Continue(()))?;
    Ok(AttributedMesh { mesh: result.mesh, attributes: result.attributes })
}

fn picture_likeness(model: &Model, contestants: &[AttributedMesh; 3]) -> Result<[f64; 3]> {
    let meshes_in_order = || std::iter::once(&model.attributed).chain(contestants);
    let coats: Vec<Option<DecodedMaterials>> =
        meshes_in_order().map(|attributed| DecodedMaterials::new(&attributed.attributes, &model.looks).0).collect();
    let normals: Vec<Option<CornerNormals>> =
        meshes_in_order().map(|attributed| CornerNormals::new(&attributed.attributes)).collect();
    let meshes: Vec<ShadedMesh> = meshes_in_order()
        .zip(coats.iter().zip(&normals))
        .map(|(attributed, (materials, normals))| {
            let mut shaded = ShadedMesh::bare(&attributed.mesh);
            (shaded.materials, shaded.normals) = (materials.as_ref(), normals.as_ref());
            shaded
        })
        .collect();
    let mut pixels = vec![Vec::new(); meshes.len()];
    for direction in VIEWS {
        for (all, view) in pixels.iter_mut().zip(&view_shaded(&meshes, direction, HEIGHT)) {
            all.extend(view.shaded.colours().into_flattened());
        }
    }
    let mut likeness = [0.0; 3];
    for (likeness, pixels_of) in likeness.iter_mut().zip(&pixels[1..]) {
        *likeness = psnr(&pixels[0], pixels_of).context("pictures differ in size")?;
    }
    Ok(likeness)
}
