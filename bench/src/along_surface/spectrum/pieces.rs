//! The connected pieces of a surface, each with masses and weights of its own: their eigenpairs together are the surface's.

use rustc_hash::FxHashMap;

use crate::along_surface::laplacian::Laplacian;

/// A connected piece of a surface.
#[derive(Default)]
pub struct Piece {
    /// Places of its vertices in [`Laplacian::vertices`], ascending: n.
    pub places: Vec<u32>,
    /// Area around each vertex: n.
    pub mass: Vec<f64>,
    /// Pairs of its vertices and the weight between them.
    pub edges: Vec<([u32; 2], f64)>,
}

impl Piece {
    /// Area of the piece.
    pub fn area(&self) -> f64 {
        self.mass.iter().sum()
    }
}

/// The pieces, the largest area first.
pub fn pieces(laplacian: &Laplacian) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut at: FxHashMap<u32, usize> = FxHashMap::default();
    let mut within = Vec::with_capacity(laplacian.mass.len());
    for (place, (&name, &mass)) in laplacian.piece.iter().zip(&laplacian.mass).enumerate() {
        let index = *at.entry(name).or_insert(pieces.len());
        if index == pieces.len() {
            pieces.push(Piece::default());
        }
        within.push(pieces[index].places.len() as u32);
        pieces[index].places.push(place as u32);
        pieces[index].mass.push(mass);
    }
    for &(ends, weight) in &laplacian.edges {
        let piece = &mut pieces[at[&laplacian.piece[ends[0] as usize]]];
        piece.edges.push((ends.map(|end| within[end as usize]), weight));
    }
    // Stable: pieces of the same area stay in the order of their vertices.
    pieces.sort_by(|a, b| b.area().total_cmp(&a.area()));
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::{TriMesh, shapes};

    #[test]
    fn pieces_share_out_vertices_and_edges() {
        let small = shapes::icosphere(0);
        let large = shapes::grid(5, 4);
        let away = large.positions().iter().map(|p| [20.0 * p[0], 20.0 * p[1], 9.0]);
        let positions = small.positions().iter().copied().chain(away).collect();
        let faces = small.faces().iter().copied().chain(large.faces().iter().map(|face| face.map(|v| v + 12)));
        let laplacian = Laplacian::new(&TriMesh::new(positions, faces.collect()).unwrap()).unwrap();
        let pieces = pieces(&laplacian);
        assert_eq!(pieces.iter().map(|piece| piece.places.len()).collect::<Vec<_>>(), [30, 12]);
        assert!((pieces[0].area() - 400.0).abs() < 0.1 && pieces[1].places == (0..12).collect::<Vec<u32>>());
        assert_eq!(pieces.iter().map(|piece| piece.edges.len()).sum::<usize>(), laplacian.edges.len());
        for piece in pieces {
            for ([i, j], weight) in piece.edges {
                let ends = [i, j].map(|end| piece.places[end as usize]);
                assert!(laplacian.edges.contains(&(ends, weight)));
            }
        }
    }
}
