//! All integration tests in one program.

mod baselines;
#[path = "../../cli/tests/common/mod.rs"]
mod common;
#[cfg(unix)] // The tools are shell scripts.
mod evaluate;
mod train_baseline;

use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, TriMesh};

/// The program under test.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_neural-mesh-bench");

/// Makes a folder with a folder `data` of meshes.
fn data_folder(meshes: &[(&str, TriMesh)]) -> tempfile::TempDir {
    let folder = common::folder();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    for (name, mesh) in meshes {
        let bytes = write(mesh, &Frame::default(), Format::Ply).unwrap();
        std::fs::write(folder.path().join("data").join(name), bytes).unwrap();
    }
    folder
}
