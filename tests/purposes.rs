//! Each `Purpose` is better by its own measure than a result for shape alone.

use std::ops::ControlFlow;

use crate::common::{assert_closed_manifold, assert_same_topology};
use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::simplify::{ClosedOptions, Options, Purpose, ScoreSource, Target, simplify, vertex_areas};

fn simplify_for_purpose(mesh: &TriMesh, n: usize, purpose: Purpose) -> TriMesh {
    let options = Options::with_closed(Target::Vertices(n), ClosedOptions { purpose, ..ClosedOptions::default() });
    let result = simplify(mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    let is_shape = purpose == Purpose::Shape;
    assert_eq!(result.report.scores, if is_shape { ScoreSource::Bending } else { ScoreSource::Geometry });
    assert_eq!(result.mesh.positions().len(), n);
    result.mesh
}

#[test]
fn faces_for_the_spectrum_are_of_like_areas() {
    let mesh = shapes::wavy_sphere(5, 6.0);
    let spread = |purpose| {
        let result = simplify_for_purpose(&mesh, 300, purpose);
        assert_closed_manifold(&result);
        assert_same_topology(&mesh, &result);
        let areas = vertex_areas(&result);
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        (areas.iter().map(|area| (area / mean - 1.0).powi(2)).sum::<f64>() / areas.len() as f64).sqrt()
    };
    let [shape, spectrum] = [Purpose::Shape, Purpose::Spectrum].map(spread);
    assert!(spectrum < 0.7 * shape, "{spectrum} {shape}");
}
