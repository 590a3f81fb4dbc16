//! Edge lengths in the metric of the samples: position, and how the surface bends along the edge.
//!
//! With II the second fundamental form, an edge e has the squared length `|e|^2 + c |II(e, e)|`, estimated from the
//! vertex normals as `|e|^2 + c |dn| |e|`. For large c that is the metric in which cells of equal size have equal
//! error (Nadler 1986; Heckbert and Garland 1999), the identity keeps flat parts finite.

use super::surface::Surface;

/// The radius of curvature, in bounding-box diagonals, at which bending counts as much as length.
const BEND: f32 = 2.0;

/// A length for every ring entry, and each vertex's area in the same metric.
pub(super) struct EdgeLengths {
    lengths: Vec<f32>,
    /// Area of each vertex's cell, n_vertices.
    pub areas: Vec<f32>,
}

impl EdgeLengths {
    /// Measures all edges; `density` (n_vertices, positive) is how much closer than average samples should lie.
    pub fn new(surface: &Surface, density: Option<&[f32]>) -> Self {
        let mut lengths = Vec::with_capacity(surface.rings.n_entries());
        let vertices = 0..surface.n_vertices() as u32;
        let areas = vertices.map(|v| measure(surface, density, v, &mut lengths)).collect();
        Self { lengths, areas }
    }

    /// The lengths of the edges from `vertex` to its neighbours, in ring order.
    pub fn of(&self, surface: &Surface, vertex: u32) -> &[f32] {
        &self.lengths[surface.rings.range(vertex)]
    }
}

/// Appends the lengths of one vertex's edges and returns the area of its cell.
fn measure(surface: &Surface, density: Option<&[f32]>, v: u32, lengths: &mut Vec<f32>) -> f32 {
    let (p, n) = (surface.positions[v as usize], surface.normals[v as usize]);
    let (mut plain, mut bent) = (0.0, 0.0);
    for &w in surface.neighbors(v) {
        let squared = p.distance_squared(surface.positions[w as usize]);
        let turn = n.distance_squared(surface.normals[w as usize]);
        let scale = density.map_or(1.0, |d| (d[v as usize] * d[w as usize]).sqrt());
        let metric = (squared + BEND * (squared * turn).sqrt()) * scale;
        lengths.push(metric.sqrt());
        plain += squared;
        bent += metric;
    }
    if surface.rings.apex(v).is_some() {
        lengths.push(0.0);
    }
    surface.weight(v as usize) as f32 * if plain > 0.0 { bent / plain } else { 1.0 }
}
