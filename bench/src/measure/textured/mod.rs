//! Textured models: distance and likeness of textured pictures, ours and meshoptimizer's with attributes at the same number
//! of faces. Of meshoptimizer there are two weightings.

mod attributed;
mod model;

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result};
use neural_mesh::appearance::VIEWS;
use neural_mesh::mesh::{Attributes, TriMesh};
use neural_mesh::metrics::{Surface, psnr, surface_distance};
use neural_mesh::picture::{Coat, CornerNormals, ShadedMesh, view_shaded};
use neural_mesh::simplify::{Input, Options, Target, simplify_input};
use serde::{Deserialize, Serialize};

use attributed::{Weighting, simplified};
use model::Model;

/// Surface samples per side for the distance.
pub const SAMPLES: usize = 50_000;
/// Height of the pictures that are compared, in pixels.
pub const HEIGHT: usize = 384;

/// A mesh with what it carries.
struct Carrier {
    mesh: TriMesh,
    attributes: Attributes,
}

/// One model at one ratio; ours first, then meshoptimizer by each weighting.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Measured {
    pub ratio: f64,
    pub faces: [usize; 3],
    /// Two-sided mean distances, in shares of the diagonal.
    pub distances: [f64; 3],
    /// PSNR against the original's pictures, in decibels.
    pub likeness: [f64; 3],
}

impl Measured {
    /// Our distance over the better one of theirs.
    pub fn quotient(&self) -> f64 {
        self.distances[0] / self.distances[1].min(self.distances[2])
    }

    /// Our PSNR less the better one of theirs.
    pub fn gain(&self) -> f64 {
        self.likeness[0] - self.likeness[1].max(self.likeness[2])
    }
}

/// The model of a file at these shares of its vertices.
pub fn measured(path: &Path, ratios: &[f64]) -> Result<Vec<Measured>> {
    let model = Model::read(path).with_context(|| path.display().to_string())?;
    model.notes.iter().for_each(|note| eprintln!("{}: {note}", path.display()));
    ratios.iter().map(|&ratio| at_ratio(&model, ratio)).collect()
}

fn at_ratio(model: &Model, ratio: f64) -> Result<Measured> {
    let ours = ours(&model.carrier, ratio)?;
    let [first, second] =
        Weighting::ALL.map(|weighting| simplified(&model.carrier, ours.mesh.faces().len(), weighting));
    let contestants = [ours, first?, second?];
    let original = Surface::new(&model.carrier.mesh, SAMPLES, 0);
    let mut distances = [0.0; 3];
    for (distance, carrier) in distances.iter_mut().zip(&contestants) {
        let found = surface_distance(&original, &Surface::new(&carrier.mesh, SAMPLES, 1)).context("no faces")?;
        *distance = found.both.mean / found.diagonal;
    }
    let faces = contestants.each_ref().map(|carrier| carrier.mesh.faces().len());
    Ok(Measured { ratio, faces, distances, likeness: likeness(model, &contestants)? })
}

/// The default of the library, with all attributes.
fn ours(original: &Carrier, ratio: f64) -> Result<Carrier> {
    let mut input = Input::bare(&original.mesh);
    input.attributes = &original.attributes;
    let options = Options::new(Target::Ratio(ratio));
    let result = simplify_input(&input, None, &options, &mut |_| ControlFlow::Continue(()))?;
    Ok(Carrier { mesh: result.mesh, attributes: result.attributes })
}

/// Peak signal-to-noise ratio of each contestant's pictures against the original's, all views together, in decibels.
fn likeness(model: &Model, contestants: &[Carrier; 3]) -> Result<[f64; 3]> {
    let carriers = || std::iter::once(&model.carrier).chain(contestants);
    let coats: Vec<Option<Coat>> = carriers().map(|carrier| Coat::new(&carrier.attributes, &model.looks).0).collect();
    let normals: Vec<Option<CornerNormals>> =
        carriers().map(|carrier| CornerNormals::new(&carrier.attributes)).collect();
    let meshes: Vec<ShadedMesh> = carriers()
        .zip(coats.iter().zip(&normals))
        .map(|(carrier, (coat, normals))| {
            let mut shaded = ShadedMesh::bare(&carrier.mesh);
            (shaded.coat, shaded.normals) = (coat.as_ref(), normals.as_ref());
            shaded
        })
        .collect();
    let mut pixels = vec![Vec::new(); meshes.len()];
    for direction in VIEWS {
        for (all, view) in pixels.iter_mut().zip(&view_shaded(&meshes, direction, HEIGHT)) {
            all.extend(view.shaded.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]));
        }
    }
    let mut likeness = [0.0; 3];
    for (likeness, pixels_of) in likeness.iter_mut().zip(&pixels[1..]) {
        *likeness = psnr(&pixels[0], pixels_of).context("pictures differ in size")?;
    }
    Ok(likeness)
}
