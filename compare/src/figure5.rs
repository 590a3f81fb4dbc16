//! The paper's Figure 5: a mesh, simplified by one set of weights and by the same after fine-tuning for curvature.

use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::curvature_error;
use neural_mesh::model::Weights;
use neural_mesh::picture::{PictureOptions, encode_png, render};
use neural_mesh::simplify::{Assembly, Options, Target, simplify};

use crate::load::load;
use crate::paper::read_weights;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh file.
    #[arg(long)]
    mesh: PathBuf,
    /// Weights before the fine-tuning.
    #[arg(long)]
    weights: PathBuf,
    /// Weights after it.
    #[arg(long)]
    finetuned: PathBuf,
    /// Share of the vertices that stay.
    #[arg(long, default_value_t = 0.1)]
    ratio: f64,
    /// Seed of the sampling.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Use the closed assembly instead of the paper's.
    #[arg(long)]
    closed: bool,
    /// Height of the picture in pixels.
    #[arg(long, default_value_t = 560)]
    height: usize,
    /// Picture to write, PNG.
    #[arg(short, long)]
    out: PathBuf,
}

/// Draws the three meshes side by side and says both curvature errors.
pub fn figure5(args: &Args) -> Result<()> {
    let original = load(&args.mesh)?;
    let plain = simplified(args, &original, &read_weights(&args.weights)?)?;
    let tuned = simplified(args, &original, &read_weights(&args.finetuned)?)?;
    let error =
        |mesh: &TriMesh| curvature_error(original.positions(), mesh.positions()).context("no vertices are left");
    let errors = [error(&plain)?, error(&tuned)?];
    let caption = |name: &str, mesh: &TriMesh, error: f64| {
        format!("{name}: {} vertices\ncurvature error {:.2}e-4", mesh.positions().len(), 1e4 * error)
    };
    let captions = vec![
        format!("original: {} vertices", original.positions().len()),
        caption("plain", &plain, errors[0]),
        caption("fine-tuned", &tuned, errors[1]),
    ];
    let options = PictureOptions { height: args.height, captions, ..PictureOptions::default() };
    std::fs::write(&args.out, encode_png(&render(&[&original, &plain, &tuned], &options)))?;
    println!("curvature error, plain       {:.4e}, {} vertices", errors[0], plain.positions().len());
    println!("curvature error, fine-tuned  {:.4e}, {} vertices", errors[1], tuned.positions().len());
    println!("fine-tuned / plain           {:.3}", errors[1] / errors[0]);
    Ok(())
}

fn simplified(args: &Args, mesh: &TriMesh, weights: &Weights) -> Result<TriMesh> {
    let assembly = if args.closed { Assembly::Closed } else { Assembly::Paper };
    let options = Options { assembly, seed: args.seed, ..Options::new(Target::Ratio(args.ratio)) };
    Ok(simplify(mesh, Some(weights), &options, &mut |_| ControlFlow::Continue(()))?.mesh)
}
