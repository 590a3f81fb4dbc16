//! Preparation of the input: surface, feature edges and pins.

pub mod area_weights;
pub mod feature_edges;
mod half_quadrics;
pub mod surface;

use crate::mesh::TriMesh;
use crate::mesh::pulse::Pulse;
use crate::simplify::options::Purpose;

use super::original::Original;
use super::pins::Pins;
use super::request::Requirements;
use feature_edges::FeatureEdges;
use surface::{Normalisation, PreparedSurface};

pub fn prepare<'a>(mesh: &'a TriMesh, requirements: &Requirements<'a>, pulse: Pulse<'a>) -> Original<'a> {
    prepare_surface(mesh, PreparedSurface::new(mesh, pulse), requirements)
}

/// Prepares a mesh without features or attributes for a collapse that sums quadrics of its own.
pub fn prepare_bare<'a>(mesh: &'a TriMesh, requirements: &Requirements<'a>, pulse: Pulse<'a>) -> Original<'a> {
    let surface = PreparedSurface::without_sums(mesh, pulse);
    let pins = Pins::new(&surface, requirements);
    Original { mesh, surface, features: FeatureEdges::default(), pins, attributes: None }
}

pub fn prepare_at_scale<'a>(
    mesh: &'a TriMesh,
    scale: Normalisation,
    requirements: &Requirements<'a>,
    pulse: Pulse<'a>,
) -> Original<'a> {
    prepare_surface(mesh, PreparedSurface::at_scale(mesh, scale, pulse), requirements)
}

pub fn prepare_surface<'a>(
    mesh: &'a TriMesh,
    mut surface: PreparedSurface<'a>,
    requirements: &Requirements<'a>,
) -> Original<'a> {
    let features = FeatureEdges::new(&surface, &requirements.edges);
    let pins = Pins::new(&surface, requirements);
    // Normals show what happens to bevels. Poses have planes of their own.
    if requirements.has_normals() && requirements.purpose == Purpose::Shape {
        surface.weigh_small_faces();
    }
    surface.support_edges(features.held_edges());
    pins.plane().into_iter().for_each(|plane| half_quadrics::complete(&mut surface, plane));
    let original = Original { mesh, surface, features, pins, attributes: None };
    let attributes = requirements.attributes.map(|attributes| original.turn_normals(attributes));
    Original { attributes, ..original }
}
