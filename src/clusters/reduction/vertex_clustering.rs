//! Vertex clustering (Rossignac and Borrel 1993): reaches any size, but joins sheets and fills handles.
//!
//! Vertices of one grid cell become one. Faces that become equal go in pairs, so that a closed surface stays closed.

use glam::{DVec3, Vec3};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::clusters::vertices::ReducedPatch;
use crate::mesh::{PositionKey, TriMesh, compact, position_key};
use crate::spatial::Bounds;

/// Bisections of the cell size.
const STEPS: usize = 24;
/// Most cells along an axis.
const FINEST: f64 = 1024.0;

/// Joins unlocked vertices within the finest grid that leaves at most `n_faces`; locked vertices stay.
pub fn cluster_vertices(reduced: ReducedPatch, locked: &FxHashSet<PositionKey>, n_faces: usize) -> ReducedPatch {
    let is_locked: Vec<bool> = reduced.mesh.positions().iter().map(|&p| locked.contains(&position_key(p))).collect();
    let bounds = Bounds::from_points(reduced.mesh.positions());
    let join_in_grid = |n_cells: f64| joined_faces(&reduced.mesh, &is_locked, &bounds, bounds.diagonal() / n_cells);
    let (mut low, mut high) = (0.5, FINEST);
    let mut best = join_in_grid(low);
    for _ in 0..STEPS {
        let middle = f64::sqrt(low * high);
        let joined = join_in_grid(middle);
        if joined.faces.len() <= n_faces {
            (low, best) = (middle, joined);
        } else {
            high = middle;
        }
    }
    let is_smaller = !best.faces.is_empty() && best.faces.len() < reduced.mesh.faces().len();
    let made = is_smaller.then(|| best.into_patch(&reduced)).flatten();
    made.unwrap_or_else(|| reduced_to_largest_face(reduced, &is_locked))
}

/// Keeps one face of a patch that no cell size keeps from vanishing; patches with locked vertices stay whole.
fn reduced_to_largest_face(reduced: ReducedPatch, is_locked: &[bool]) -> ReducedPatch {
    let faces = reduced.mesh.faces();
    if is_locked.contains(&true) || faces.len() < 2 {
        return reduced;
    }
    let area2 = |face: &u32| {
        let [a, b, c] = faces[*face as usize].map(|v| point(&reduced.mesh, v));
        (b - a).cross(c - a).length_squared()
    };
    let largest = (0..faces.len() as u32).max_by(|x, y| area2(x).total_cmp(&area2(y))).unwrap_or(0);
    let joined = JoinedFaces {
        positions: reduced.mesh.positions().to_vec(),
        faces: vec![faces[largest as usize]],
        sources: vec![largest],
    };
    joined.into_patch(&reduced).unwrap_or(reduced)
}

struct JoinedFaces {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    /// Face of the patch from which each comes.
    sources: Vec<u32>,
}

impl JoinedFaces {
    fn into_patch(self, reduced: &ReducedPatch) -> Option<ReducedPatch> {
        let (mesh, _) = compact(&self.positions, self.faces).ok()?;
        let attributes = reduced.attributes.clone().select_faces(&self.sources)?;
        Some(ReducedPatch { mesh, attributes })
    }
}

fn point(mesh: &TriMesh, v: u32) -> DVec3 {
    DVec3::from(mesh.positions()[v as usize].map(f64::from))
}

/// Joins the vertices of each cell at their mean.
fn joined_faces(mesh: &TriMesh, is_locked: &[bool], bounds: &Bounds, size: f64) -> JoinedFaces {
    let low = Vec3::from(bounds.low).as_dvec3();
    let cell = |v: usize| ((point(mesh, v as u32) - low) / size).floor().to_array().map(|x| x as i64);
    let mut first: FxHashMap<[i64; 3], u32> = FxHashMap::default();
    let target: Vec<u32> = (0..is_locked.len())
        .map(|v| if is_locked[v] { v as u32 } else { *first.entry(cell(v)).or_insert(v as u32) })
        .collect();
    let mut sums = vec![(DVec3::ZERO, 0.0); is_locked.len()];
    for (v, &target) in target.iter().enumerate() {
        let (sum, n) = &mut sums[target as usize];
        (*sum, *n) = (*sum + point(mesh, v as u32), *n + 1.0);
    }
    let mut positions = mesh.positions().to_vec();
    for (v, (sum, n)) in sums.into_iter().enumerate().filter(|(v, (_, n))| *n > 1.0 && !is_locked[*v]) {
        positions[v] = (sum / n).as_vec3().to_array();
    }
    let (faces, sources) = distinct_faces(mesh.faces().iter().map(|face| face.map(|v| target[v as usize])));
    JoinedFaces { positions, faces, sources }
}

/// Drops faces with equal corners, and faces over the same three vertices in pairs.
pub fn distinct_faces(faces: impl Iterator<Item = [u32; 3]>) -> (Vec<[u32; 3]>, Vec<u32>) {
    let mut last: FxHashMap<[u32; 3], usize> = FxHashMap::default();
    let mut kept: Vec<Option<([u32; 3], u32)>> = Vec::new();
    for (source, face) in (0u32..).zip(faces).filter(|(_, [a, b, c])| a != b && b != c && c != a) {
        let mut key = face;
        key.sort_unstable();
        match last.remove(&key) {
            Some(other) => kept[other] = None,
            None => {
                last.insert(key, kept.len());
                kept.push(Some((face, source)));
            }
        }
    }
    kept.into_iter().flatten().unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, edges, shapes};

    #[test]
    fn any_size_is_reached_and_no_edge_is_opened() {
        for mesh in [shapes::torus(60, 30, 1.0, 0.3), shapes::wavy_sphere(4, 8.0)] {
            for n in [400, 100, 8, 2] {
                let patch = ReducedPatch { mesh: mesh.clone(), attributes: Attributes::default() };
                let made = cluster_vertices(patch, &FxHashSet::default(), n);
                assert!((1..=n).contains(&made.mesh.faces().len()), "{n}: {}", made.mesh.faces().len());
                let is_closed = edges(&made.mesh).iter().all(|edge| edge.n_faces() % 2 == 0);
                assert!(is_closed || made.mesh.faces().len() == 1, "{n}");
            }
        }
    }

    #[test]
    fn locked_vertices_stay() {
        let mesh = shapes::icosphere(3);
        let locked: FxHashSet<PositionKey> =
            mesh.positions().iter().filter(|p| p[2] > 0.5).map(|&p| position_key(p)).collect();
        let made = cluster_vertices(ReducedPatch { mesh, attributes: Attributes::default() }, &locked, 500);
        let left: FxHashSet<PositionKey> = made.mesh.positions().iter().map(|&p| position_key(p)).collect();
        assert!(locked.is_subset(&left) && made.mesh.faces().len() <= 500);
    }
}
