//! The original as its scene shows it, with which results are compared.

use std::borrow::Cow;

use crate::mesh::{TriMesh, UnitedMesh};
use crate::simplify::{Input, Simplified};

/// The original, placed in its scene.
pub(super) struct PlacedOriginal<'a> {
    pub view: Cow<'a, TriMesh>,
    scene: Option<&'a UnitedMesh>,
    /// Number of vertices of the simplifier's input.
    pub n_vertices: usize,
}

impl<'a> PlacedOriginal<'a> {
    pub fn from_input(input: &Input<'a>) -> Self {
        let view = match input.scene {
            None => Cow::Borrowed(input.mesh),
            Some(scene) => Cow::Owned(scene.view(input.mesh, input.attributes).mesh),
        };
        Self { view, scene: input.scene, n_vertices: input.mesh.positions().len() }
    }

    pub fn view_of<'b>(&self, result: &'b Simplified) -> Cow<'b, TriMesh> {
        match self.scene {
            Some(scene) => Cow::Owned(scene.view(&result.mesh, &result.attributes).mesh),
            None => Cow::Borrowed(&result.mesh),
        }
    }

    /// Returns the largest distance by which placement in the scene rounds a position.
    pub fn rounding(&self) -> f64 {
        let reach = self.view.positions().as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
        if self.scene.is_some() { 3f64.sqrt() * f64::from(f32::EPSILON) * f64::from(reach) } else { 0.0 }
    }
}
