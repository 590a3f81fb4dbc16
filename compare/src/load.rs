//! Reads binary PLY meshes of the usual layout and welds equal positions: what both methods start from.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, bail};
use neural_mesh::mesh::TriMesh;

/// Reads one mesh, in `f32` around the middle of its bounding box where the file has doubles.
pub fn load(path: &Path) -> Result<TriMesh> {
    let bytes = std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
    let end = bytes.windows(11).position(|w| w == b"end_header\n").context("no PLY header")?;
    let header = String::from_utf8_lossy(&bytes[..end]);
    let count = |name: &str| -> Result<usize> {
        let line = header.lines().find_map(|line| line.strip_prefix(&format!("element {name} ")));
        Ok(line.context("missing element")?.trim().parse()?)
    };
    if !header.contains("binary_little_endian") {
        bail!("{} is not a little-endian binary PLY", path.display());
    }
    let width = if header.contains("property double x") { 8 } else { 4 };
    let (vertices, faces) = bytes[end + 11..].split_at(count("vertex")? * 3 * width);
    let coordinates: Vec<f64> = match width {
        8 => vertices.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        _ => vertices.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
    };
    let faces = faces.as_chunks::<13>().0.iter().take(count("face")?).map(corner_indices);
    Ok(weld(coordinates.as_chunks().0, faces)?)
}

fn corner_indices(record: &[u8; 13]) -> [u32; 3] {
    let index = |at: usize| u32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]);
    [index(1), index(5), index(9)]
}

/// Joins vertices at the same position; faces that lose a corner by it are dropped, unused vertices too.
fn weld(points: &[[f64; 3]], faces: impl Iterator<Item = [u32; 3]>) -> Result<TriMesh, neural_mesh::mesh::InvalidMesh> {
    let mut vertex_at = HashMap::new();
    let mut positions = Vec::new();
    let mut vertex = |i: u32| {
        let point = points[i as usize].map(|x| x as f32 + 0.0);
        *vertex_at.entry(point.map(f32::to_bits)).or_insert_with(|| {
            positions.push(point);
            positions.len() as u32 - 1
        })
    };
    let welded = faces.filter(|&[a, b, c]| a != b && b != c && c != a).map(|face| face.map(&mut vertex));
    let welded = welded.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
    TriMesh::new(positions, welded)
}

/// The mesh's name in the tables: its file name without extension, after its folder's where that has a name of its own.
pub fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
    if folder.contains('_') { format!("{stem} ({folder})") } else { stem }
}
