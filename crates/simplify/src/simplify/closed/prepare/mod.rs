//! Preparation of the input: surface, feature edges and pins.

pub mod area_weights;
pub mod feature_edges;
pub mod surface;

use crate::mesh::pulse::Pulse;
use crate::simplify::options::Purpose;

use super::original::Original;
use super::pins::Pins;
use super::request::ClosedRequest;
use feature_edges::FeatureEdges;
use surface::{Normalisation, PreparedSurface};

pub fn prepare<'a>(request: &ClosedRequest<'a>, pulse: Pulse<'a>) -> Original<'a> {
    prepare_surface(PreparedSurface::new(request.task.input.mesh, pulse), request)
}

/// Prepares a mesh without features or attributes for a collapse that sums quadrics of its own.
pub fn prepare_bare<'a>(request: &ClosedRequest<'a>, pulse: Pulse<'a>) -> Original<'a> {
    let mesh = request.task.input.mesh;
    let surface = PreparedSurface::without_sums(mesh, pulse);
    let pins = Pins::new(&surface, request);
    Original { mesh, surface, features: FeatureEdges::default(), pins, attributes: None }
}

pub fn prepare_at_scale<'a>(scale: Normalisation, request: &ClosedRequest<'a>, pulse: Pulse<'a>) -> Original<'a> {
    prepare_surface(PreparedSurface::at_scale(request.task.input.mesh, scale, pulse), request)
}

pub fn prepare_surface<'a>(mut surface: PreparedSurface<'a>, request: &ClosedRequest<'a>) -> Original<'a> {
    let task = &request.task;
    let features = FeatureEdges::new(&surface, &request.edges);
    let pins = Pins::new(&surface, request);
    // Normals show what happens to bevels. Poses have planes of their own.
    if task.input.attributes.normals().is_some() && task.options.purpose == Purpose::Shape {
        surface.weigh_small_faces();
    }
    surface.support_edges(features.held_edges());
    let original = Original { mesh: task.input.mesh, surface, features, pins, attributes: None };
    let attributes = task.attributes().map(|attributes| original.turn_normals(attributes));
    Original { attributes, ..original }
}
