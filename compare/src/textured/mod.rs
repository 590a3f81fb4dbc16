//! Textured models: distance and likeness of textured pictures, against meshoptimizer with attributes at the same number of
//! faces. Of meshoptimizer the better of two weightings counts, figure by figure.

mod attributed;
mod model;
mod page;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use neural_mesh::appearance::VIEWS;
use neural_mesh::mesh::{Attributes, TriMesh};
use neural_mesh::metrics::{Surface, psnr, surface_distance};
use neural_mesh::picture::{Coat, PictureOptions, View, encode_png, render_coated, view_coated};
use neural_mesh::simplify::{Input, Options, Target, simplify_input};

use attributed::{Weighting, simplified};
use model::Model;
use page::Row;

#[derive(clap::Args)]
pub struct Args {
    /// Models: OBJ with its library of materials, glTF, GLB.
    models: Vec<PathBuf>,
    /// Shares of the vertices that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.5,0.2,0.1,0.05")]
    ratios: Vec<f64>,
    /// Surface samples per side for the distance.
    #[arg(long, default_value_t = 100_000)]
    samples: usize,
    /// Height of the pictures that are compared, in pixels.
    #[arg(long, default_value_t = 512)]
    height: usize,
    /// Folder for a picture of each model and ratio: original, ours, meshoptimizer's.
    #[arg(long)]
    pictures: Option<PathBuf>,
}

/// A mesh with what it carries.
struct Carrier {
    mesh: TriMesh,
    attributes: Attributes,
}

/// Prints the table.
pub fn textured(args: &Args) -> Result<()> {
    let mut rows = Vec::new();
    for path in &args.models {
        let model = Model::read(path).with_context(|| path.display().to_string())?;
        model.notes.iter().for_each(|note| eprintln!("{}: {note}", path.display()));
        for &ratio in &args.ratios {
            let row = measured(&model, path, ratio, args)?;
            eprintln!("{row:?}");
            rows.push(row);
        }
    }
    print!("{}", page::page(&rows, &args.ratios));
    Ok(())
}

/// One model at one ratio, by all contestants.
fn measured(model: &Model, path: &Path, ratio: f64, args: &Args) -> Result<Row> {
    let ours = ours(&model.carrier, ratio)?;
    let theirs = Weighting::ALL.map(|weighting| simplified(&model.carrier, ours.mesh.faces().len(), weighting));
    let [first, second] = theirs;
    let contestants = [ours, first?, second?];
    let original = Surface::new(&model.carrier.mesh, args.samples, 0);
    let distance = |carrier: &Carrier| {
        let found = surface_distance(&original, &Surface::new(&carrier.mesh, args.samples, 1));
        Some(found?.both.mean / model.carrier.mesh.diagonal())
    };
    let distances: Option<Vec<f64>> = contestants.iter().map(distance).collect();
    let likeness = likeness(model, &contestants, args.height)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(folder) = &args.pictures {
        let place = folder.join(format!("{name}-{ratio}.png"));
        std::fs::write(place, picture(model, &contestants, ratio))?;
    }
    let distances = distances.context("a result has no faces")?;
    Ok(Row {
        name,
        ratio,
        faces: contestants.iter().map(|carrier| carrier.mesh.faces().len()).collect(),
        distances,
        likeness,
    })
}

/// The default of the library, with all attributes.
fn ours(original: &Carrier, ratio: f64) -> Result<Carrier> {
    let input = Input { mesh: &original.mesh, attributes: &original.attributes, importance: &[] };
    let options = Options::new(Target::Ratio(ratio));
    let result = simplify_input(&input, None, &options, &mut |_| ControlFlow::Continue(()))?;
    Ok(Carrier { mesh: result.mesh, attributes: result.attributes })
}

/// Peak signal-to-noise ratio of each contestant's pictures against the original's, all views together, in decibels.
fn likeness(model: &Model, contestants: &[Carrier], height: usize) -> Result<Vec<f64>> {
    let coats: Vec<Option<Coat>> = worn(model, contestants);
    let meshes: Vec<(&TriMesh, Option<&Coat>)> = meshes(model, contestants, &coats);
    let mut pixels = vec![Vec::new(); meshes.len()];
    for direction in VIEWS {
        let views = view_coated(&meshes, direction, height);
        pixels.iter_mut().zip(&views).for_each(|(all, view)| all.extend(colours(view)));
    }
    let of = |other: &Vec<u8>| psnr(&pixels[0], other).context("pictures differ in size");
    pixels[1..].iter().map(of).collect()
}

/// Original and results beside each other.
fn picture(model: &Model, contestants: &[Carrier], ratio: f64) -> Vec<u8> {
    let coats = worn(model, contestants);
    let names = ["original", "neural-mesh", "meshoptimizer", "meshoptimizer, uv weighed"];
    let meshes = meshes(model, contestants, &coats);
    let caption = |(name, (mesh, _)): (&str, &(&TriMesh, _))| format!("{name}\n{} faces", mesh.faces().len());
    let mut captions: Vec<String> = names.into_iter().zip(&meshes).map(caption).collect();
    captions[1].push_str(&format!(", ratio {ratio}"));
    encode_png(&render_coated(&meshes, &PictureOptions { captions, edges: false, ..PictureOptions::default() }))
}

/// The coats of the original and all results.
fn worn(model: &Model, contestants: &[Carrier]) -> Vec<Option<Coat>> {
    let carriers = std::iter::once(&model.carrier).chain(contestants);
    carriers.map(|carrier| Coat::new(&carrier.attributes, &model.looks).0).collect()
}

fn meshes<'a>(
    model: &'a Model,
    contestants: &'a [Carrier],
    coats: &'a [Option<Coat>],
) -> Vec<(&'a TriMesh, Option<&'a Coat>)> {
    let carriers = std::iter::once(&model.carrier).chain(contestants);
    carriers.zip(coats).map(|(carrier, coat)| (&carrier.mesh, coat.as_ref())).collect()
}

/// Red, green and blue of all pixels.
fn colours(view: &View) -> impl Iterator<Item = u8> {
    view.shaded.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
}
