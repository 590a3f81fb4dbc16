//! How small a mesh gets that certainly lies within a distance, ours and meshoptimizer's.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use neural_mesh::io::{Format, write, write_path};
use neural_mesh::mesh::{Frame, TriMesh};
use neural_mesh::metrics::{Sharpness, certified_distance};
use neural_mesh::search::simplify_to_error;
use neural_mesh::simplify::{Input, Options, Target};

use crate::load::{load, name};
use crate::methods::meshoptimizer;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    #[arg(required = true)]
    meshes: Vec<PathBuf>,
    /// Largest distances, in percent of the diagonal.
    #[arg(long, value_delimiter = ',', default_value = "2,1,0.5,0.25")]
    errors: Vec<f64>,
    /// Folder for our results, as MESH-ERROR.ply, for other tools to measure.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Prints a row for each mesh and distance: faces of both, what ours is proved to hold, and the quotient of the faces.
pub fn certain(args: &Args) -> Result<()> {
    println!(
        "| mesh | asked, % | proved, % | faces, ours | faces, meshoptimizer | ours / meshoptimizer | tries | time, s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let mut quotients = Vec::new();
    for path in &args.meshes {
        let mesh = load(path)?;
        let diagonal = mesh.diagonal();
        for &percent in &args.errors {
            let error = 0.01 * percent * diagonal;
            let began = Instant::now();
            let options = Options::new(Target::Ratio(1.0));
            let ours =
                simplify_to_error(&Input::bare(&mesh), None, &options, error, &mut |_| ControlFlow::Continue(()))?;
            let seconds = began.elapsed().as_secs_f64();
            let n_ours = ours.simplified.mesh.faces().len();
            let n_theirs = fewest_faces(&mesh, error)?;
            let (proved, quotient) = (100.0 * ours.distance.upper / diagonal, n_ours as f64 / n_theirs as f64);
            let (mesh_name, tries) = (name(path), ours.n_tries);
            println!(
                "| {mesh_name} | {percent} | {proved:.4} | {n_ours} | {n_theirs} | {quotient:.3} | {tries} | {seconds:.1} |"
            );
            quotients.push(quotient);
            args.out.iter().try_for_each(|out| keep(out, &format!("{mesh_name}-{percent}"), &ours.simplified.mesh))?;
        }
    }
    quotients.sort_by(f64::total_cmp);
    println!("\nmedian {:.3}, largest {:.3}", quotients[quotients.len() / 2], quotients[quotients.len() - 1]);
    Ok(())
}

/// The fewest faces at which a search by halves finds meshoptimizer's result certainly within the distance.
fn fewest_faces(mesh: &TriMesh, error: f64) -> Result<usize> {
    let asked = Sharpness { enough: error, too_much: error, gap: 0.0 };
    let (mut too_few, mut enough) = (0usize, mesh.faces().len());
    let mut fewest = enough;
    while enough as f64 > (too_few as f64 * 1.02).max(too_few as f64 + 2.0) {
        let middle = if too_few == 0 { enough / 4 } else { too_few.midpoint(enough) };
        let result = meshoptimizer(mesh, middle)?.mesh;
        let holds = certified_distance(mesh, &result, &asked).is_some_and(|distance| distance.upper <= error);
        if holds {
            (enough, fewest) = (middle, fewest.min(result.faces().len()));
        } else {
            too_few = middle;
        }
        if holds && result.faces().len() > middle {
            break;
        }
    }
    Ok(fewest)
}

fn keep(folder: &Path, name: &str, mesh: &TriMesh) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let path = folder.join(format!("{name}.ply"));
    write_path(&path, &write(mesh, &Frame::default(), Format::Ply)?, true).with_context(|| path.display().to_string())
}
