//! Polygons of a file on their way to triangles: laid down as fans while reading, settled when all positions are known.

use crate::geometry::polygon::triangulate;

/// Remembers which runs of triangles stand for one polygon.
///
/// ```
/// use neural_mesh::mesh::Fans;
/// let positions = [[0.0; 3], [2.0, -1.0, 0.0], [0.5, 0.0, 0.0], [2.0, 1.0, 0.0]];
/// let (mut fans, mut faces) = (Fans::default(), Vec::new());
/// fans.push(&[1, 2, 3, 0], &mut faces);
/// fans.settle(&positions, &mut faces);
/// assert_eq!(faces, [[2, 3, 0], [2, 0, 1]]);
/// ```
#[derive(Debug, Default)]
pub struct Fans {
    /// First triangle and number of triangles of each polygon with more than three corners.
    runs: Vec<(usize, usize)>,
}

impl Fans {
    /// Appends the fan of the polygon `corners` (vertex indices) to `faces`; false where it has fewer than three corners.
    pub fn push(&mut self, corners: &[u32], faces: &mut Vec<[u32; 3]>) -> bool {
        let &[apex, ref rest @ ..] = corners else { return false };
        if corners.len() > 3 {
            self.runs.push((faces.len(), corners.len() - 2));
        }
        faces.extend(rest.windows(2).map(|edge| [apex, edge[0], edge[1]]));
        corners.len() >= 3
    }

    /// Replaces each fan in `faces` by a triangulation that is right for concave polygons too.
    ///
    /// A polygon with corners that do not exist or are not finite keeps its fan: cleanup has the say on its triangles.
    pub fn settle(self, positions: &[[f64; 3]], faces: &mut [[u32; 3]]) {
        let (mut corners, mut points) = (Vec::new(), Vec::new());
        for (start, n_triangles) in self.runs {
            let Some(run) = faces.get_mut(start..start + n_triangles) else { continue };
            corners.clear();
            corners.extend(run.iter().take(1).flat_map(|&[a, b, _]| [a, b]));
            corners.extend(run.iter().map(|face| face[2]));
            points.clear();
            points.extend(
                corners.iter().filter_map(|&v| positions.get(v as usize)).filter(|p| p.iter().all(|x| x.is_finite())),
            );
            if points.len() == corners.len() {
                for (face, triangle) in run.iter_mut().zip(triangulate(&points)) {
                    *face = triangle.map(|corner| corners[corner as usize]);
                }
            }
        }
    }
}
