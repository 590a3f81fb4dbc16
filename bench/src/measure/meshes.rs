//! Mesh files, and a test mesh of any size.

use std::path::{Path, PathBuf};

use crate::evaluate::mesh_files;
use anyhow::{Context, Result};
use neural_mesh::io::read_path;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{TriMesh, compact, shapes};
use neural_mesh::metrics::largest_distance;

pub fn load(path: &Path) -> Result<TriMesh> {
    let raw = read_path(path, None).with_context(|| path.display().to_string())?;
    let mesh = clean(raw, &CleanOptions::default()).with_context(|| path.display().to_string())?.mesh;
    let (positions, faces) = mesh.into_parts();
    Ok(compact(&positions, faces)?.0)
}

/// Returns names and paths of the mesh files of a folder, ordered by name.
pub fn mesh_paths(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let files = mesh_files(folder, &[]).with_context(|| format!("{}: unpack the meshes there", folder.display()))?;
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(files.into_iter().map(|path| (name(&path), path)).collect())
}

/// Returns the Hausdorff distance in the mesh's unit: an upper bound, at most 1 % too large.
pub fn hausdorff_distance(original: &TriMesh, simplified: &TriMesh) -> Result<f64> {
    largest_distance(original, simplified).context("no faces, or too many that lie across each other")
}

/// Makes a bumpy torus of about `n_faces` faces.
pub fn bumpy_torus(n_faces: usize) -> TriMesh {
    // The torus has three times as many steps around as through its tube.
    let n_tube = (n_faces as f64 / 6.0).sqrt().round().max(3.0);
    let torus = shapes::torus((3.0 * n_tube) as u32, n_tube as u32, 1.0, 1.0 / 3.0);
    let (positions, faces) = torus.into_parts();
    TriMesh::new(positions.into_iter().map(displace_point).collect(), faces).unwrap_or_default()
}

fn displace_point([x, y, z]: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [x, y, z].map(f64::from);
    let around = y.atan2(x);
    let outward = x.hypot(y) - 1.0;
    let through = z.atan2(outward);
    let wave = |n: f64, m: f64| (n * around).sin() * (m * through).cos();
    let tube = outward.hypot(z) * (1.0 + 0.1 * wave(9.0, 3.0) + 0.03 * wave(31.0, 11.0) + 0.01 * wave(97.0, 29.0));
    let (radius, z) = (1.0 + tube * through.cos(), tube * through.sin());
    [radius * around.cos(), radius * around.sin(), z].map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::topology;

    #[test]
    fn the_torus_has_about_as_many_faces_as_asked_for() {
        let mesh = bumpy_torus(10_000);
        assert!((9_000..=11_000).contains(&mesh.faces().len()));
        assert!(topology(&mesh).is_closed_manifold());
    }
}
