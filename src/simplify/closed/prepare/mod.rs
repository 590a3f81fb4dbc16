//! The input as the assembly works on it: a surface of unit size, the edges that stay, the vertices that may not move.

pub mod feature_edges;
mod half;
pub mod surface;
pub mod uneven;

use crate::mesh::TriMesh;
use crate::mesh::pulse::Pulse;

use super::original::Original;
use super::pins::Pins;
use super::request::Keep;
use feature_edges::FeatureEdges;
use surface::Surface;

/// Makes a mesh and what of it has to stay the original of an assembly, to whose work `pulse` listens.
pub fn prepare<'a>(mesh: &'a TriMesh, keep: &Keep, pulse: Pulse<'a>) -> Original<'a> {
    let mut surface = Surface::new(mesh, pulse);
    let features = FeatureEdges::on(&surface, keep.edges);
    let pins = Pins::on(&surface, keep);
    surface.support_edges(features.held());
    pins.plane().into_iter().for_each(|plane| half::complete(&mut surface, plane));
    Original { mesh, surface, features, pins }
}
