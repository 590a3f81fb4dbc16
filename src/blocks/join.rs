//! Union of simplified blocks.

use rustc_hash::{FxHashMap, FxHashSet};

use super::block::Block;
use crate::mesh::{InvalidMesh, PositionKey, TriMesh, position_key};

/// Two vertices, the lesser first.
type VertexPair = [u32; 2];

/// Joins blocks to one mesh, in order.
///
/// If two blocks have created equal edges or faces between shared vertices, a new vertex splits one of them.
///
/// # Errors
/// [`InvalidMesh`] if there are more vertices than `u32` can count.
///
/// ```
/// use neural_mesh::{blocks::{cut, join}, mesh::shapes};
/// let torus = shapes::torus(20, 10, 1.0, 0.3);
/// assert_eq!(join(cut(&torus)).unwrap(), torus);
/// ```
pub fn join(blocks: impl IntoIterator<Item = Block>) -> Result<TriMesh, InvalidMesh> {
    let mut joined = JoinedMesh::default();
    let mut of_blocks = Vec::new();
    for Block { mesh, shared } in blocks {
        of_blocks.push(joined.add(mesh, &shared));
    }
    let borders: FxHashSet<VertexPair> = of_blocks.iter().flat_map(|block| block.borders.iter().copied()).collect();
    let (mut taken, mut faces_between) = (borders, FxHashSet::default());
    for block in &mut of_blocks {
        for &ends in &block.chords {
            if !taken.insert(ends) {
                joined.split_edge(&mut block.faces, ends);
            }
        }
        joined.split_repeated_faces(&mut block.faces, &mut faces_between);
    }
    let n_faces = of_blocks.iter().map(|block| block.faces.len()).sum();
    let mut faces = Vec::with_capacity(n_faces);
    of_blocks.into_iter().for_each(|block| faces.extend(block.faces));
    TriMesh::new(joined.positions, faces)
}

#[derive(Default)]
struct JoinedMesh {
    positions: Vec<[f32; 3]>,
    // Shared vertices by position.
    shared: FxHashMap<PositionKey, u32>,
    is_shared: Vec<bool>,
}

struct JoinedBlock {
    faces: Vec<[u32; 3]>,
    // Edges between shared vertices: `borders` have one face in the block, `chords` two.
    borders: Vec<VertexPair>,
    chords: Vec<VertexPair>,
}

impl JoinedMesh {
    fn add(&mut self, mesh: TriMesh, shared: &[bool]) -> JoinedBlock {
        let (positions, mut faces) = mesh.into_parts();
        let number = |(p, &shared): ([f32; 3], &bool)| {
            let fresh = self.positions.len() as u32;
            let vertex = if shared { *self.shared.entry(position_key(p)).or_insert(fresh) } else { fresh };
            if vertex == fresh {
                self.positions.push(p);
                self.is_shared.push(shared);
            }
            vertex
        };
        let numbers: Vec<u32> = positions.into_iter().zip(shared).map(number).collect();
        faces.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
        let mut counts: FxHashMap<VertexPair, u32> = FxHashMap::default();
        for ends in faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]) {
            if ends.iter().all(|&v| self.is_shared[v as usize]) {
                *counts.entry([ends[0].min(ends[1]), ends[0].max(ends[1])]).or_default() += 1;
            }
        }
        let (mut borders, mut chords): (Vec<_>, Vec<_>) = counts.into_iter().partition(|(_, n)| *n == 1);
        borders.sort_unstable();
        chords.sort_unstable();
        let ends = |edges: Vec<(VertexPair, u32)>| edges.into_iter().map(|(ends, _)| ends).collect();
        JoinedBlock { faces, borders: ends(borders), chords: ends(chords) }
    }

    fn push(&mut self, corners: &[u32]) -> u32 {
        let place = |axis: usize| {
            let sum: f64 = corners.iter().map(|&v| f64::from(self.positions[v as usize][axis])).sum();
            (sum / corners.len() as f64) as f32
        };
        self.positions.push([0, 1, 2].map(place));
        self.is_shared.push(false);
        self.positions.len() as u32 - 1
    }

    fn split_edge(&mut self, faces: &mut Vec<[u32; 3]>, [u, v]: VertexPair) {
        let middle = self.push(&[u, v]);
        for at in 0..faces.len() {
            let face = faces[at];
            if face.contains(&u) && face.contains(&v) {
                let with = |end: u32| face.map(|corner| if corner == end { middle } else { corner });
                faces[at] = with(u);
                faces.push(with(v));
            }
        }
    }

    /// Splits each face between shared vertices that an earlier block has too, at its centroid.
    fn split_repeated_faces(&mut self, faces: &mut Vec<[u32; 3]>, known: &mut FxHashSet<[u32; 3]>) {
        for at in 0..faces.len() {
            let face @ [a, b, c] = faces[at];
            let mut key = face;
            key.sort_unstable();
            if face.iter().all(|&v| self.is_shared[v as usize]) && !known.insert(key) {
                let centre = self.push(&face);
                faces[at] = [a, b, centre];
                faces.extend([[b, c, centre], [c, a, centre]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::block::{cut_into_blocks, simplify_block};
    use crate::mesh::{shapes, topology};
    use crate::simplify::ClosedOptions;

    #[test]
    fn blocks_as_they_were_are_the_mesh_again() {
        for mesh in [shapes::torus(40, 20, 1.0, 0.3), shapes::open_cylinder(30, 20), shapes::icosphere(4)] {
            let blocks = cut_into_blocks(&mesh, 9);
            assert!(blocks.len() > 5);
            let joined = join(blocks).unwrap();
            let [before, after] = [&mesh, &joined].map(topology);
            assert_eq!((before, mesh.faces().len()), (after, joined.faces().len()));
        }
    }

    #[test]
    fn closed_stays_closed_at_any_price() {
        let options = ClosedOptions::default();
        for mesh in [shapes::torus(80, 40, 1.0, 0.3), shapes::wavy_sphere(4, 8.0), shapes::cuboid([1.0; 3], 20)] {
            for n_blocks in [3, 11, 40] {
                for price in [0.0, 1e-9, 1e-6, 1.0] {
                    let blocks = cut_into_blocks(&mesh, n_blocks);
                    let simplified_blocks =
                        blocks.iter().map(|block| simplify_block(block, 0.2, price, None, &options).unwrap());
                    let joined = join(simplified_blocks).unwrap();
                    let (before, after) = (topology(&mesh), topology(&joined));
                    assert!(after.is_closed_manifold(), "{n_blocks} {price}: {after:?}");
                    assert_eq!(before.euler, after.euler);
                    assert!(joined.faces().len() <= mesh.faces().len());
                }
            }
        }
    }

    #[test]
    fn repeated_faces_of_two_blocks_are_split() {
        // Two halves of a square's outline, both of two triangles with the same diagonal: a pillow once joined.
        let square = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let half =
            |faces: Vec<[u32; 3]>| Block { mesh: TriMesh::new(square.clone(), faces).unwrap(), shared: vec![true; 4] };
        let joined = join([half(vec![[0, 1, 2], [0, 2, 3]]), half(vec![[2, 1, 0], [3, 2, 0]])]).unwrap();
        let found = topology(&joined);
        assert!(found.is_closed_manifold() && joined.positions().len() == 5, "{found:?}");
        // A triangle from either side.
        let side = |face: [u32; 3]| Block {
            mesh: TriMesh::new(square[..3].to_vec(), vec![face]).unwrap(),
            shared: vec![true; 3],
        };
        let joined = join([side([0, 1, 2]), side([2, 1, 0])]).unwrap();
        assert!(topology(&joined).is_closed_manifold() && joined.faces().len() == 4);
    }
}
