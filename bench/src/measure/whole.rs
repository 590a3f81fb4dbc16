//! A small program around meshoptimizer: the reference for the time of the whole program.

use std::path::PathBuf;

use anyhow::Result;
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::{Frame, RawMesh, TriMesh, compact};

use crate::baselines::meshoptimizer_faces;

/// Arguments of the program around meshoptimizer.
#[derive(clap::Args)]
pub struct MeshoptimizerArgs {
    input: PathBuf,
    output: PathBuf,
    faces: usize,
}

pub fn run_meshoptimizer(args: &MeshoptimizerArgs) -> Result<()> {
    let RawMesh { positions, faces, .. } = read_path(&args.input, None)?;
    let positions = positions.into_iter().map(|p| p.map(|x| x as f32)).collect();
    let mesh = TriMesh::new(positions, faces)?;
    let faces = meshoptimizer_faces(&mesh, args.faces);
    let simplified = compact(mesh.positions(), faces)?.0;
    Ok(write_path(&args.output, &write(&simplified, &Frame::default(), Format::Ply)?, true)?)
}
