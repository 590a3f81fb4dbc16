//! The longest shortest path along the edges of a surface.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use neural_mesh::linalg::Rows;

use crate::along_surface::laplacian::{GluedTriangles, Laplacian};

/// Estimates the longest shortest path by two sweeps, at least half of it (Dijkstra 1959).
pub fn longest_path(laplacian: &Laplacian) -> f64 {
    let links = VertexLinks::new(&laplacian.surface, laplacian.mass.len());
    let first: Vec<u32> =
        (0..laplacian.component.len() as u32).filter(|&v| laplacian.component[v as usize] == v).collect();
    let ways = links.path_lengths(&first);
    let mut farthest: Vec<u32> = (0..laplacian.component.len() as u32).collect();
    for v in 0..laplacian.component.len() {
        let best = &mut farthest[laplacian.component[v] as usize];
        if ways[v] > ways[*best as usize] {
            *best = v as u32;
        }
    }
    let starts: Vec<u32> = first.iter().map(|&component| farthest[component as usize]).collect();
    links.path_lengths(&starts).into_iter().filter(|way| way.is_finite()).fold(0.0, f64::max)
}

struct VertexLinks<'a> {
    surface: &'a GluedTriangles,
    half_edges: Rows<u32>,
}

impl<'a> VertexLinks<'a> {
    fn new(surface: &'a GluedTriangles, n_vertices: usize) -> Self {
        Self { surface, half_edges: Rows::new(n_vertices, surface.start.iter().copied().zip(0..)) }
    }

    fn path_lengths(&self, from: &[u32]) -> Vec<f64> {
        let mut ways = vec![f64::INFINITY; self.half_edges.n_rows()];
        from.iter().for_each(|&v| ways[v as usize] = 0.0);
        // Bits of non-negative numbers sort like the numbers.
        let mut front: BinaryHeap<Reverse<(u64, u32)>> = from.iter().map(|&v| Reverse((0, v))).collect();
        while let Some(Reverse((bits, v))) = front.pop() {
            let way = f64::from_bits(bits);
            if way > ways[v as usize] {
                continue;
            }
            for &half_edge in self.half_edges.row(v as usize) {
                let [_, w] = self.surface.ends(half_edge as usize);
                let longer = way + self.surface.length[half_edge as usize];
                if longer < ways[w as usize] {
                    ways[w as usize] = longer;
                    front.push(Reverse((longer.to_bits(), w)));
                }
            }
        }
        ways
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::{TriMesh, shapes};

    #[test]
    fn on_known_shapes() {
        let longest = |mesh: &TriMesh| longest_path(&Laplacian::new(mesh).unwrap());
        let sphere = longest(&shapes::icosphere(3));
        assert!((3.0..3.8).contains(&sphere), "{sphere}");
        let boxes = shapes::many_boxes(3);
        let one = TriMesh::new(boxes.positions()[..8].to_vec(), boxes.faces()[..12].to_vec()).unwrap();
        assert!(longest(&boxes) < 1.6 * longest(&one), "components are not joined");
    }
}
