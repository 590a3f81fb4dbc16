//! Results of the closed assembly.

use glam::Vec3;

use crate::mesh::{Attributes, TriMesh};
use crate::simplify::map;
use crate::simplify::options::{Map, Report, Simplified, SimplifyError};

use super::attributes::kept_faces::{KeptFace, find_kept, restore_values};
use super::attributes::result_corners::CornerMap;
use super::derivative::Derivative;
use super::original::Original;
use super::output::Output;

pub struct ClosedResult {
    pub simplified: Simplified,
    pub vertex_of: Vec<u32>,
    pub derivative: Option<Derivative>,
    pub pass_prices: Vec<(usize, f64)>,
    pub kept: Vec<KeptFace>,
}

impl ClosedResult {
    /// Builds the result from an output and its local positions.
    ///
    /// # Errors
    /// [`SimplifyError::Overflow`] if a position is not finite.
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
        // Copies of split vertices come last, and the caller does not know them.
        vertex_of.truncate(original.mesh.positions().len());
        pulse.beat(0);
        let mesh = TriMesh::new(positions, faces).map_err(|_| SimplifyError::Overflow)?;
        let sources = || pins.origins().iter().map(|&v| original.surface.source(v)).collect();
        let simplified = Simplified {
            attributes: Attributes::default(),
            report: Report::for_mesh(pulse, &mesh),
            map: None,
            source_vertices: pins.is_subset().then(sources),
            mesh,
        };
        Ok(Self { simplified, vertex_of, derivative: None, pass_prices: Vec::new(), kept })
    }

    /// Wraps the input where nothing is done; it has no vertices of its own.
    pub fn unchanged(simplified: Simplified) -> Self {
        Self { simplified, vertex_of: Vec::new(), derivative: None, pass_prices: Vec::new(), kept: Vec::new() }
    }

    pub fn with_prices(self, pass_prices: Vec<(usize, f64)>) -> Self {
        Self { pass_prices, ..self }
    }

    pub fn restore_kept(&mut self, input_attributes: &Attributes) {
        restore_values(&mut self.simplified.attributes, input_attributes, &self.kept);
    }

    pub fn build_map(&self, mesh: &TriMesh, corners: CornerMap) -> Map {
        let input_vertices = map::nearest_inputs(mesh, &self.simplified.mesh, &self.vertex_of);
        let output_vertices = self.vertex_of.clone();
        Map { output_vertices, input_vertices, corner_faces: corners.faces, corner_weights: corners.weights }
    }
}

/// Converts output positions to local coordinates; locked vertices, and all of a subset, keep every bit.
pub fn local_positions(original: &Original, output: &Output) -> Vec<[f32; 3]> {
    let Original { mesh, surface, .. } = original;
    let local = |p: &Vec3| surface.scale.restore(p.as_dvec3());
    let mut positions: Vec<[f32; 3]> = surface.pulse.map(&output.positions, local);
    let pins = &output.pins;
    // Conversion to unit size and back rounds, so pinned vertices take the mesh's own numbers.
    for (x, &v) in (0u32..).zip(pins.origins()).filter(|(x, _)| pins.is_subset() || pins.is_locked(*x)) {
        positions[x as usize] = mesh.positions()[surface.source(v) as usize];
    }
    positions
}
