//! Triangles without area.

use robust::{Coord, orient2d};

/// Returns whether three finite points are not collinear, exactly.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::has_area;
/// let line = [[0.0, 0.0, 1.0], [1.0, 2.0, 1.0], [3.0, 6.0, 1.0]];
/// assert!(!has_area(line));
/// assert!(has_area([line[0], line[1], [3.0, 6.000000000000001, 1.0]]));
/// ```
pub fn has_area(corners: [[f64; 3]; 3]) -> bool {
    [[0, 1], [1, 2], [2, 0]].into_iter().any(|[x, y]| {
        let [a, b, c] = corners.map(|corner| Coord { x: corner[x], y: corner[y] });
        orient2d(a, b, c) != 0.0
    })
}
