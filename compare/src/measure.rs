//! Every figure of one result against its original.

use anyhow::Result;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{RawMesh, TriMesh, topology};
use neural_mesh::metrics::{Surface, self_intersecting_faces, surface_distance, turned_faces};

use crate::methods::Done;
use crate::row::Row;

/// An input with what its results are measured against.
pub struct Original {
    pub raw: RawMesh,
    pub mesh: TriMesh,
    pub surface: Surface,
    n_samples: usize,
}

impl Original {
    pub fn new(raw: RawMesh, n_samples: usize) -> Result<Self> {
        let mesh = clean(raw.clone(), &CleanOptions::default())?.mesh;
        Ok(Self { surface: Surface::new(&mesh, n_samples, 0), raw, mesh, n_samples })
    }
}

/// The figures of a result; the case it belongs to is the caller's to fill in.
pub fn measure(original: &Original, done: &Done) -> Row {
    let surface = Surface::new(&done.mesh, original.n_samples, 1);
    let distance = surface_distance(&original.surface, &surface).unwrap_or_default();
    let share = 1.0 / original.surface.diagonal;
    Row {
        outcome: done.outcome.clone(),
        vertices_after_pass: done.vertices_after_pass,
        oversample: done.oversample,
        mean: distance.both.mean * share,
        rms: distance.both.rms * share,
        hausdorff: distance.both.max * share,
        normal_error: distance.both.normal_error,
        turned_faces: turned_faces(&original.surface, &done.mesh).len(),
        ..topology_row(&done.mesh)
    }
}

/// The figures that a mesh has by itself.
pub fn topology_row(mesh: &TriMesh) -> Row {
    let topology = topology(mesh);
    Row {
        vertices: topology.vertices,
        faces: topology.faces,
        closed: topology.closed,
        boundary_edges: topology.boundary_edges,
        boundary_loops: topology.boundary_loops,
        non_manifold_edges: topology.non_manifold_edges,
        non_manifold_vertices: topology.non_manifold_vertices,
        inconsistent_edges: topology.inconsistent_edges,
        components: topology.components,
        genus: topology.genus,
        self_intersecting_faces: self_intersecting_faces(mesh).len(),
        ..Row::default()
    }
}
