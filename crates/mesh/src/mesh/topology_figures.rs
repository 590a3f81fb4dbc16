//! Topology figures of a mesh, or counts of a part of it.

/// The topology figures of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Topology {
    /// Vertices, used or not.
    pub vertices: usize,
    /// Vertices without faces.
    pub unreferenced_vertices: usize,
    /// Edges.
    pub edges: usize,
    /// Faces.
    pub faces: usize,
    /// True if the mesh has faces and no boundary edge.
    pub closed: bool,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Loops of boundary edges.
    pub boundary_loops: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Vertices whose faces form several fans, joined over edges.
    pub non_manifold_vertices: usize,
    /// Two-face edges that both faces traverse in the same direction.
    pub inconsistent_edges: usize,
    /// True if reversing faces can make the winding consistent.
    pub orientable: bool,
    /// Components of faces joined over edges.
    pub components: usize,
    /// Euler characteristic: used vertices - edges + faces.
    pub euler: i64,
    /// Handles after boundaries are filled; only for orientable meshes without non-manifold edges.
    pub genus: Option<usize>,
}

impl Topology {
    pub(super) fn add(&mut self, other: &Self) {
        self.vertices += other.vertices;
        self.unreferenced_vertices += other.unreferenced_vertices;
        self.non_manifold_vertices += other.non_manifold_vertices;
        self.faces += other.faces;
        self.edges += other.edges;
        self.boundary_edges += other.boundary_edges;
        self.non_manifold_edges += other.non_manifold_edges;
        self.inconsistent_edges += other.inconsistent_edges;
        self.components += other.components;
        self.boundary_loops += other.boundary_loops;
    }

    /// Fills in what follows from the counts.
    pub(super) fn finish(self, n_fans: usize, orientable: bool) -> Self {
        let holes_filled = n_fans + self.faces + self.boundary_loops;
        let handles = (2 * self.components + self.edges).checked_sub(holes_filled).map(|twice| twice / 2);
        let used = self.vertices - self.unreferenced_vertices;
        Self {
            closed: self.faces > 0 && self.boundary_edges == 0,
            orientable,
            euler: used as i64 - self.edges as i64 + self.faces as i64,
            genus: handles.filter(|_| orientable && self.non_manifold_edges == 0),
            ..self
        }
    }

    /// Returns whether every edge has two consistently wound faces and every vertex one fan.
    pub fn is_closed_manifold(&self) -> bool {
        self.closed && self.non_manifold_edges + self.non_manifold_vertices + self.inconsistent_edges == 0
    }
}
