//! One mesh of the paper's table, and every figure of one result of it.

use std::path::Path;

use anyhow::Result;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, chamfer, open_edges, surface_distance};
use rayon::ThreadPool;

use super::PaperRow;
use super::contestant::{Contestant, asked};
use crate::load::{load, name};
use crate::methods::{Done, compact};

/// An input with what its results are measured against.
pub struct Original {
    name: String,
    /// Without vertices that no face uses.
    mesh: TriMesh,
    surface: Surface,
    n_samples: usize,
}

impl Original {
    pub fn load(path: &Path, n_samples: usize) -> Result<Self> {
        let read = load(path)?;
        let mesh = compact(&read, read.faces())?;
        Ok(Self { name: name(path), surface: Surface::new(&mesh, n_samples, 0), mesh, n_samples })
    }

    /// Lets one contestant run and measures what it made.
    pub fn row(&self, timed: &ThreadPool, contestant: &Contestant, ratio: f64, seed: u64) -> PaperRow {
        let done = timed.install(|| contestant.simplify(&self.mesh, &self.name, ratio, seed));
        let done = done.unwrap_or_else(|error| Done::failed(&error.to_string()));
        PaperRow {
            mesh: self.name.clone(),
            ratio,
            seed,
            method: contestant.name().to_owned(),
            asked: asked(&self.mesh, ratio),
            ..self.measured(&done)
        }
    }

    fn measured(&self, done: &Done) -> PaperRow {
        let surface = Surface::new(&done.mesh, self.n_samples, 1);
        let distance = surface_distance(&self.surface, &surface).unwrap_or_default();
        let chamfer = chamfer(&self.surface.samples, &surface.samples).unwrap_or_default();
        let edges = open_edges(&self.mesh, &done.mesh);
        let share = 1.0 / self.surface.diagonal;
        PaperRow {
            outcome: done.outcome.clone(),
            vertices: done.mesh.positions().len(),
            faces: done.mesh.faces().len(),
            chamfer: chamfer.sum() * share * share,
            mean_square: (distance.forward.rms.powi(2) + distance.backward.rms.powi(2)) * share * share,
            hausdorff: distance.both.max * share,
            normal_error: distance.both.unsigned_normal_error,
            normal_error_of_result: distance.backward.unsigned_normal_error,
            normal_angle: distance.both.normal_angle,
            wa_percent: edges.wa_percent(),
            open_percent: edges.open_percent(),
            seconds: Some(done.seconds).filter(|seconds| seconds.is_finite()),
            ..PaperRow::default()
        }
    }
}
