//! A page of pictures: each mesh before, by neural-mesh, and by meshoptimizer at the same number of faces.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use neural_mesh::picture::{PictureOptions, encode_png, render};

use crate::load::{load_raw, name};
use crate::measure::{Original, measure};
use crate::methods::{Done, Ours, Scores, meshoptimizer, ours};
use crate::row::Row;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files, each followed by a colon and the share of its vertices that stays.
    #[arg(long, num_args = 1.., required = true)]
    mesh: Vec<String>,
    /// Folder for the pictures, which the page names by its last part.
    #[arg(long)]
    folder: PathBuf,
    /// Page to write, beside that folder.
    #[arg(long)]
    page: PathBuf,
    /// Where our scores come from.
    #[arg(long, value_enum, default_value = "network")]
    scores: Scores,
    /// Height of a picture in pixels.
    #[arg(long, default_value_t = 560)]
    height: usize,
}

/// Draws every mesh and writes the page.
pub fn pictures(args: &Args) -> Result<()> {
    std::fs::create_dir_all(&args.folder)?;
    let mut page = "# Pictures\n\nLeft the input, in the middle neural-mesh, right meshoptimizer's `simplify` at the same number of \
                    faces. Distances are two-sided means, in shares of the diagonal of the bounding box. Made by \
                    `scripts/pictures`.\n"
        .to_owned();
    for case in &args.mesh {
        let (path, ratio) = case.rsplit_once(':').context("a mesh needs a colon and a ratio")?;
        let ratio: f64 = ratio.parse().with_context(|| format!("the ratio of {path}"))?;
        page += &draw(args, Path::new(path), ratio)?;
    }
    Ok(std::fs::write(&args.page, page)?)
}

/// Draws one mesh; returns its part of the page.
fn draw(args: &Args, path: &Path, ratio: f64) -> Result<String> {
    let original = Original::new(load_raw(path)?, 100_000)?;
    let our = ours(&original.raw, ratio, Ours { scores: args.scores, ..Ours::default() })?;
    let their = meshoptimizer(&original.mesh, our.mesh.faces().len())?;
    let (our_row, their_row) = (measure(&original, &our), measure(&original, &their));
    let captions = vec![
        format!("{} faces", original.mesh.faces().len()),
        caption("neural-mesh", &our, &our_row),
        caption("meshoptimizer", &their, &their_row),
    ];
    let options = PictureOptions { height: args.height, captions, ..PictureOptions::default() };
    let image = render(&[&original.mesh, &our.mesh, &their.mesh], &options);
    let name = name(path);
    let file = format!("{name}-compared.png");
    std::fs::write(args.folder.join(&file), encode_png(&image))?;
    let folder = args.folder.file_name().unwrap_or_default().to_string_lossy();
    Ok(format!(
        "\n## {name}, {} faces of {}\n\n![{name}]({folder}/{file})\n",
        our_row.faces,
        original.mesh.faces().len()
    ))
}

fn caption(method: &str, done: &Done, row: &Row) -> String {
    format!(
        "{method}: {} faces\ndistance {:.2}e-4, normals {:.4}",
        done.mesh.faces().len(),
        1e4 * row.mean,
        row.normal_error
    )
}
