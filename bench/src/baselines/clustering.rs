//! Vertex clustering in a uniform grid (Rossignac and Borrel 1993), with quadrics in the cells (Lindstrom 2000).

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::BaselineError;
use super::planes::{face_plane, to_double};
use neural_mesh::geometry::Quadric;
use neural_mesh::mesh::{TriMesh, compact};

// Binary logarithm of the largest number of cells along the longest side.
const FINEST: f64 = 20.0;
const TRIES: usize = 24;
// Weight of the distance to the mean of a cell's vertices, as a fraction of the quadric's trace.
const PULL: f64 = 1e-4;

pub(super) fn cluster_vertices(mesh: &TriMesh, n_vertices: usize) -> Result<TriMesh, BaselineError> {
    let positions = to_double(mesh.positions());
    let (clusters, faces) = best_clusters(&positions, mesh.faces(), n_vertices).ok_or(BaselineError::NothingLeft)?;
    let places = representatives(&positions, mesh.faces(), &clusters);
    Ok(compact(&places, faces)?.0)
}

struct Clusters {
    cells: Vec<DVec3>,
    side: f64,
    of_vertex: Vec<u32>,
}

fn best_clusters(positions: &[DVec3], faces: &[[u32; 3]], n_vertices: usize) -> Option<(Clusters, Vec<[u32; 3]>)> {
    let mut best: Option<(usize, Clusters, Vec<[u32; 3]>)> = None;
    let [mut coarse, mut fine] = [0.0, FINEST];
    for tried in 0..TRIES {
        let resolution = if tried == 0 { fine } else { 0.5 * (coarse + fine) };
        let clusters = assign_cells(positions, resolution.exp2());
        let left = clustered_faces(faces, &clusters);
        let n = n_used(&left);
        let miss = n.abs_diff(n_vertices);
        if n > 0 && best.as_ref().is_none_or(|best| miss < best.0) {
            best = Some((miss, clusters, left));
        }
        // The first try is the finest grid; if it leaves too few vertices, coarser grids leave even fewer.
        if miss == 0 || (tried == 0 && n < n_vertices) {
            break;
        }
        *(if n > n_vertices { &mut fine } else { &mut coarse }) = resolution;
    }
    best.map(|(_, clusters, left)| (clusters, left))
}

fn assign_cells(positions: &[DVec3], resolution: f64) -> Clusters {
    let low = positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = positions.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let side = ((high - low).max_element() / resolution).max(f64::MIN_POSITIVE);
    let mut numbers: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    let mut cells = Vec::new();
    let cell_of = |p: &DVec3| {
        let at = ((*p - low) / side).floor();
        let next = numbers.len() as u32;
        *numbers.entry(at.to_array().map(|x| x as u32)).or_insert_with(|| {
            cells.push(low + at * side);
            next
        })
    };
    let of_vertex = positions.iter().map(cell_of).collect();
    Clusters { cells, side, of_vertex }
}

fn clustered_faces(faces: &[[u32; 3]], clusters: &Clusters) -> Vec<[u32; 3]> {
    let mut seen = FxHashSet::default();
    let clustered = faces.iter().map(|face| face.map(|v| clusters.of_vertex[v as usize]));
    clustered.filter(|&[a, b, c]| a != b && b != c && c != a && seen.insert(rotate_lowest_first([a, b, c]))).collect()
}

fn rotate_lowest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        low if low == a => [a, b, c],
        low if low == b => [b, c, a],
        _ => [c, a, b],
    }
}

fn n_used(faces: &[[u32; 3]]) -> usize {
    faces.as_flattened().iter().collect::<FxHashSet<_>>().len()
}

fn representatives(positions: &[DVec3], faces: &[[u32; 3]], clusters: &Clusters) -> Vec<[f32; 3]> {
    let n_cells = clusters.cells.len();
    let mut quadrics = vec![Quadric::default(); n_cells];
    for face in faces {
        let plane = face_plane(face.map(|v| positions[v as usize]));
        face.iter().for_each(|&v| quadrics[clusters.of_vertex[v as usize] as usize] += plane);
    }
    let mut sums = vec![(DVec3::ZERO, 0.0); n_cells];
    for (p, &cell) in positions.iter().zip(&clusters.of_vertex) {
        let (sum, count) = &mut sums[cell as usize];
        (*sum, *count) = (*sum + *p, *count + 1.0);
    }
    let place = |((quadric, (sum, count)), low): ((&Quadric, &(DVec3, f64)), &DVec3)| {
        let mean = sum / count;
        let best = quadric.with_point(mean, PULL * quadric.trace()).minimum().map_or(mean, |(best, _)| best);
        best.clamp(*low, low + clusters.side).as_vec3().to_array()
    };
    quadrics.iter().zip(&sums).zip(&clusters.cells).map(place).collect()
}
