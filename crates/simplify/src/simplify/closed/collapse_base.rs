//! Surface under a collapse: the whole mesh, or what remains of it after components were dropped.

use crate::simplify::limits::Limit;
use crate::simplify::options::Report;

use super::collapse::{Collapse, CollapseEnd};
use super::original::Original;
use super::output::Output;
use super::request::ClosedRequest;

/// Surface under a collapse, and the vertices of the collapse that remain on it.
pub struct CollapseBase<'a> {
    pub original: Original<'a>,
    /// Vertex of the collapse at each vertex of the surface; empty if they are the same.
    pub collapse_vertices: Vec<u32>,
}

impl CollapseBase<'_> {
    pub fn output(&self, collapse: &Collapse) -> Output {
        let mut output = collapse.output();
        if !self.collapse_vertices.is_empty() {
            // The collapse numbers the vertices of all components, this surface only those that remain.
            let mut of_surface = vec![0; output.vertex_of.len()];
            (0u32..).zip(&self.collapse_vertices).for_each(|(own, &v)| of_surface[v as usize] = own);
            output.pins.renumber_origins(|v| of_surface[v as usize]);
            output.vertex_of = self.collapse_vertices.iter().map(|&v| output.vertex_of[v as usize]).collect();
        }
        output
    }

    pub fn complete_report(&self, report: &mut Report, request: &ClosedRequest, end: CollapseEnd) {
        report.scores = request.scores;
        report.outcome = end.outcome();
        report.split_vertices = self.original.surface.n_split();
        report.kept_edges = request.edges.len();
        report.locked_vertices = request.locked.iter().filter(|&&locked| locked).count();
    }

    fn unit_of_prices(&self) -> f64 {
        f64::from(self.original.surface.length(1.0)).powi(4)
    }

    /// Converts prices of a collapse at unit size to the mesh's units.
    pub fn pass_prices(&self, at_unit_size: &[(usize, f32)]) -> Vec<(usize, f64)> {
        let unit = self.unit_of_prices();
        at_unit_size.iter().map(|&(n, price)| (n, f64::from(price) / unit)).collect()
    }

    /// Converts distances at unit size to the mesh's unit.
    pub fn pass_distances(&self, at_unit_size: &[(usize, f64)]) -> Vec<(usize, f64)> {
        let unit = f64::from(self.original.surface.length(1.0));
        at_unit_size.iter().map(|&(n, distance)| (n, distance / unit)).collect()
    }

    pub fn limit(&self, price: Option<f64>, limit: Limit) -> Limit {
        let with_price = |price| Limit { price: (price * self.unit_of_prices()) as f32, ..Limit::from_vertices(0) };
        price.map_or(limit, with_price)
    }
}
