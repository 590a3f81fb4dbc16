//! Feature edges: seams and creases.

use rustc_hash::FxHashMap;

use crate::mesh::FeatureEdge;

use super::surface::PreparedSurface;

#[derive(Default)]
pub struct FeatureEdges {
    pub edges: Vec<[u32; 2]>,
    /// Distance that each edge may move at a low price, at unit size; 0 if it is held.
    pub slack: Vec<f32>,
    is_hard: Vec<bool>,
}

impl FeatureEdges {
    pub fn new(surface: &PreparedSurface, kept: &[FeatureEdge]) -> Self {
        // Without copies surface and mesh have equal vertices.
        let has_copies = surface.n_split() > 0 && !kept.is_empty();
        let kept = if has_copies { map_to_copies(surface, kept) } else { kept.to_vec() };
        let edges: Vec<[u32; 2]> = kept.iter().map(|edge| edge.ends).collect();
        let slack = kept.iter().map(|edge| surface.length(edge.slack)).collect();
        let is_hard = kept.iter().map(|edge| edge.is_hard).collect();
        Self { edges, slack, is_hard }
    }

    pub fn has_held_edges(&self) -> bool {
        self.held_edges().next().is_some()
    }

    pub fn held_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.edges.iter().zip(&self.slack).filter(|(_, slack)| **slack == 0.0).map(|(edge, _)| *edge)
    }

    pub fn curve_ends(&self) -> Vec<u32> {
        let mut vertices = self.edges.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
    }

    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    pub fn hard_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.edges.iter().zip(&self.is_hard).filter(|(_, is_hard)| **is_hard).map(|(edge, _)| *edge)
    }

    pub fn edges_between(&self, vertex_of: &[u32]) -> Vec<[u32; 2]> {
        edges_between(self.edges.iter().copied(), vertex_of)
    }

    pub fn hard_edges_between(&self, vertex_of: &[u32]) -> Vec<[u32; 2]> {
        edges_between(self.hard_edges(), vertex_of)
    }
}

fn edges_between(edges: impl Iterator<Item = [u32; 2]>, vertex_of: &[u32]) -> Vec<[u32; 2]> {
    let ends = |edge: [u32; 2]| {
        let [a, b] = edge.map(|v| vertex_of[v as usize]);
        (a != b).then_some([a.min(b), a.max(b)])
    };
    let mut edges: Vec<[u32; 2]> = edges.filter_map(ends).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn map_to_copies(surface: &PreparedSurface, kept: &[FeatureEdge]) -> Vec<FeatureEdge> {
    let wanted: FxHashMap<[u32; 2], &FeatureEdge> = kept.iter().map(|edge| (edge.ends, edge)).collect();
    let mut touched = vec![false; surface.n_vertices()];
    kept.iter().flat_map(|edge| edge.ends).for_each(|v| touched[v as usize] = true);
    let kept = |[a, b]: [u32; 2]| {
        let [s, t] = [a, b].map(|v| surface.source(v));
        // The flag saves a lookup for most edges.
        let is_touched = touched[s as usize] && touched[t as usize];
        let edge = is_touched.then(|| wanted.get(&[s.min(t), s.max(t)])).flatten()?;
        Some(FeatureEdge { ends: [a.min(b), a.max(b)], ..**edge })
    };
    let sides = surface.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut found: Vec<FeatureEdge> = sides.filter_map(kept).collect();
    found.sort_unstable_by_key(|edge| edge.ends);
    // An edge that was cut open became a boundary: each copy has one side.
    let with_two_sides = found.chunk_by(|x, y| x.ends == y.ends).filter(|sides| sides.len() == 2);
    with_two_sides.map(|sides| sides[0]).collect()
}
