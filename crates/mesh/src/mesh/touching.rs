//! Pieces of a scene that continue each other: their common boundary becomes one.

use rustc_hash::FxHashMap;

use super::half_edges::for_each_edge;
use super::union_find::UnionFind;
use super::{PositionKey, position_key};

/// Boundary edge of a piece, with its vertices in the order of its face.
#[derive(Clone, Copy)]
struct OpenSide {
    piece: u32,
    vertices: [u32; 2],
}

/// Returns for each vertex the one that it becomes, and the number of vertices that go.
///
/// Two pieces of one `class` (a number per piece) are joined along an edge at which each of them ends, and nothing else does,
/// if their faces wind alike there. `piece_of` numbers the piece of each face. Edges where whole bodies touch stay apart.
pub fn join_touching(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    piece_of: &[u32],
    class: &[usize],
) -> (Vec<u32>, usize) {
    let mut sides: FxHashMap<(usize, [PositionKey; 2]), Vec<OpenSide>> = FxHashMap::default();
    for_each_edge(positions.len(), faces, |_, half_edges| {
        let &[half] = half_edges else { return };
        let (face, side) = (half.half_edge as usize / 3, half.half_edge as usize % 3);
        let vertices = [faces[face][side], faces[face][(side + 1) % 3]];
        let mut keys = vertices.map(|v| position_key(positions[v as usize]));
        keys.sort_unstable();
        let piece = piece_of[face];
        sides.entry((class[piece as usize], keys)).or_default().push(OpenSide { piece, vertices });
    });
    let mut sets = UnionFind::new(positions.len());
    for pair in sides.values() {
        let &[one, other] = pair.as_slice() else { continue };
        let [a, b] = one.vertices;
        let [c, d] = other.vertices;
        let is_same = |u: u32, v: u32| position_key(positions[u as usize]) == position_key(positions[v as usize]);
        if one.piece != other.piece && is_same(a, d) && is_same(b, c) {
            sets.union(a, d);
            sets.union(b, c);
        }
    }
    let n_joined = positions.len() - sets.n_sets();
    ((0..positions.len() as u32).map(|v| sets.find(v)).collect(), n_joined)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};

    /// Faces of a mesh in pieces with vertices of their own.
    fn in_pieces(mesh: &TriMesh, piece: impl Fn(usize) -> u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<u32>) {
        let (mut positions, mut numbers) = (Vec::new(), FxHashMap::default());
        let piece_of: Vec<u32> = (0..mesh.faces().len()).map(piece).collect();
        let mut number = |v: u32, piece: u32| {
            *numbers.entry((v, piece)).or_insert_with(|| {
                positions.push(mesh.positions()[v as usize]);
                positions.len() as u32 - 1
            })
        };
        let faces = mesh.faces().iter().zip(&piece_of).map(|(face, &piece)| face.map(|v| number(v, piece))).collect();
        (positions, faces, piece_of)
    }

    fn join_mesh(positions: &[[f32; 3]], faces: &[[u32; 3]], piece_of: &[u32], class: &[usize]) -> TriMesh {
        let (vertex, _) = join_touching(positions, faces, piece_of, class);
        TriMesh::new(positions.to_vec(), faces.iter().map(|face| face.map(|v| vertex[v as usize])).collect()).unwrap()
    }

    #[test]
    fn parts_of_one_sphere_are_closed_again() {
        let sphere = shapes::icosphere(3);
        let (positions, faces, piece_of) = in_pieces(&sphere, |face| (face as u32 / 100) % 3);
        assert!(!topology(&join_mesh(&positions, &faces, &piece_of, &[0, 1, 2])).is_closed_manifold());
        let whole = join_mesh(&positions, &faces, &piece_of, &[5; 3]);
        assert!(topology(&whole).is_closed_manifold());
        let (_, n_joined) = join_touching(&positions, &faces, &piece_of, &[5; 3]);
        assert_eq!(positions.len() - n_joined, sphere.positions().len());
    }

    #[test]
    fn whole_bodies_and_faces_that_wind_against_each_other_stay_apart() {
        let cube = shapes::cuboid([1.0; 3], 2);
        let n = cube.positions().len() as u32;
        let beside = cube.positions().iter().map(|p| [p[0] + 1.0, p[1], p[2]]);
        let positions: Vec<_> = cube.positions().iter().copied().chain(beside).collect();
        let faces: Vec<_> = cube.faces().iter().copied().chain(cube.faces().iter().map(|f| f.map(|v| v + n))).collect();
        let piece_of: Vec<u32> = (0..faces.len()).map(|face| u32::from(face >= cube.faces().len())).collect();
        assert_eq!(join_touching(&positions, &faces, &piece_of, &[0; 2]).1, 0);
        // One half of a sphere inside out.
        let (positions, mut faces, piece_of) = in_pieces(&shapes::icosphere(2), |face| u32::from(face > 100));
        faces.iter_mut().zip(&piece_of).filter(|it| *it.1 == 1).for_each(|(face, _)| face.swap(1, 2));
        assert_eq!(join_touching(&positions, &faces, &piece_of, &[0; 2]).1, 0);
    }
}
