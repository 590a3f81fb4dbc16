//! What the closed assembly hands out, on its way to the caller.

use glam::Vec3;

use crate::mesh::{Attributes, TriMesh};
use crate::simplify::components::Pruned;
use crate::simplify::map;
use crate::simplify::options::{Map, Report, Simplified, SimplifyError};

use super::attributes::corners::CornerMap;
use super::attributes::kept::{KeptFace, find_kept, restore};
use super::derivative::Derivative;
use super::original::Original;
use super::output::Output;

/// A result of the closed assembly.
pub struct Closed {
    /// The lighter mesh.
    pub mesh: TriMesh,
    /// What its corners and faces carry.
    pub attributes: Attributes,
    /// What was done.
    pub report: Report,
    /// Where it comes from, if that was to be known.
    pub map: Option<Map>,
    /// For each vertex of the mesh that was simplified the output vertex that its region became.
    pub vertex_of: Vec<u32>,
    /// The vertex of that mesh that each output vertex is, where they were to be such.
    pub source_vertices: Option<Vec<u32>>,
    /// The result as a function of the positions, where that was asked for.
    pub derivative: Option<Derivative>,
    /// How many vertices rounds of merges left, falling, and up to which price each went: squared distances times area, in the unit
    /// of the mesh.
    pub paid: Vec<(usize, f64)>,
    /// Whether each output vertex lies on the plane, where the mesh is one half of a mirrored one; else empty.
    pub on_plane: Vec<bool>,
    /// The faces that came back as they were.
    pub kept: Vec<KeptFace>,
}

impl Closed {
    /// Hands an output out whose vertices go to `positions`, local coordinates, n_vertices x 3; `is_kept` says of each face of the mesh
    /// whether it came back as it was, or is empty.
    ///
    /// # Errors
    /// [`SimplifyError::Overflow`] where a position is not finite.
    pub fn new(
        original: &Original,
        output: Output,
        positions: Vec<[f32; 3]>,
        is_kept: &[bool],
    ) -> Result<Self, SimplifyError> {
        let pulse = original.surface.pulse;
        pulse.beat(0);
        let kept = find_kept(original, &output, is_kept);
        let (faces, pins, mut vertex_of) = output.into_parts();
        vertex_of.truncate(original.mesh.positions().len());
        pulse.beat(0);
        let mesh = TriMesh::new(positions, faces).map_err(|_| SimplifyError::Overflow)?;
        let sources = || pins.origins().iter().map(|&v| original.surface.source(v)).collect();
        Ok(Self {
            attributes: Attributes::default(),
            report: Report::of(pulse, &mesh),
            map: None,
            vertex_of,
            source_vertices: pins.is_subset().then(sources),
            derivative: None,
            paid: Vec::new(),
            on_plane: pins.into_plane_flags(),
            kept,
            mesh,
        })
    }

    /// The same, of which it is known what its merges cost.
    pub fn having_paid(self, paid: Vec<(usize, f64)>) -> Self {
        Self { paid, ..self }
    }

    /// Gives the corners of kept faces the very values that they carried in the mesh.
    pub fn restore_kept(&mut self, own: &Attributes) {
        restore(&mut self.attributes, own, &self.kept);
    }

    /// Where the result comes from, by where its corners stand.
    pub fn map_by(&self, mesh: &TriMesh, corners: CornerMap) -> Map {
        let input_vertices = map::nearest_inputs(mesh, &self.mesh, &self.vertex_of);
        let output_vertices = self.vertex_of.clone();
        Map { output_vertices, input_vertices, corner_faces: corners.faces, corner_weights: corners.weights }
    }

    /// Takes the result over to the vertices and faces of `mesh`, of which some components had been dropped.
    pub fn widen(&mut self, mesh: &TriMesh, pruned: &Pruned) {
        pruned.note(&mut self.report);
        self.map.iter_mut().for_each(|map| map::widen_pruned(map, mesh, pruned));
        self.source_vertices.iter_mut().flatten().for_each(|v| *v = pruned.sources[*v as usize]);
        self.derivative = self.derivative.take().map(|derivative| derivative.within(&pruned.sources));
    }

    /// The result as the caller gets it, and how it depends on the positions, if that was asked for.
    pub fn into_result(self) -> (Simplified, Option<Derivative>) {
        let Self { mesh, attributes, report, map, source_vertices, derivative, .. } = self;
        (Simplified { mesh, attributes, source_vertices, map, report }, derivative)
    }
}

/// Where the vertices of an output go in local coordinates, n_vertices x 3; what may not move keeps every bit.
pub fn local_positions(original: &Original, output: &Output) -> Vec<[f32; 3]> {
    let Original { mesh, surface, .. } = original;
    let local = |p: &Vec3| surface.scale.restore(p.as_dvec3());
    let mut positions: Vec<[f32; 3]> = surface.pulse.map(&output.positions, local);
    let pins = &output.pins;
    for (x, &v) in (0u32..).zip(pins.origins()).filter(|(x, _)| pins.is_subset() || pins.is_locked(*x)) {
        positions[x as usize] = mesh.positions()[surface.source(v) as usize];
    }
    positions
}
