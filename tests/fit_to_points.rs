//! The example `fit_to_points`: a sphere takes the shape of a point cloud.

#[path = "../examples/fit_to_points.rs"]
#[allow(dead_code, reason = "its `main` is for those who run it")]
mod example;

use neural_mesh::mesh::shapes;

#[test]
fn the_simplified_surface_comes_to_lie_on_the_points() {
    let losses = example::fit(shapes::icosphere(4), &example::target()).unwrap();
    let (first, last) = (losses[0], losses[losses.len() - 1]);
    assert!(losses[1] < 0.1 * first && last < 1e-3 * first, "{losses:?}");
}
