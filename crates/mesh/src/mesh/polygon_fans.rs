//! Polygons of a file, stored as fans until all positions are known.

use crate::geometry::polygon::triangulate;

/// Ranges of faces that came from one polygon each, to be triangulated later.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::Fans;
/// let positions = [[0.0; 3], [2.0, -1.0, 0.0], [0.5, 0.0, 0.0], [2.0, 1.0, 0.0]];
/// let (mut fans, mut faces) = (Fans::default(), Vec::new());
/// fans.push(&[1, 2, 3, 0], &mut faces);
/// fans.triangulate(&positions, &mut faces);
/// assert_eq!(faces, [[2, 3, 0], [2, 0, 1]]);
/// ```
#[derive(Debug, Default)]
pub struct Fans {
    runs: Vec<(usize, usize)>,
}

impl Fans {
    /// Appends a polygon to `faces` as a fan; returns false if it has fewer than three corners.
    pub fn push(&mut self, corners: &[u32], faces: &mut Vec<[u32; 3]>) -> bool {
        let &[first, ref rest @ ..] = corners else { return false };
        if corners.len() > 3 {
            self.runs.push((faces.len(), corners.len() - 2));
        }
        faces.extend(rest.windows(2).map(|edge| [first, edge[0], edge[1]]));
        corners.len() >= 3
    }

    /// Replaces each fan in `faces` by a triangulation that is correct for concave polygons.
    ///
    /// A polygon with a missing or non-finite corner becomes a fan around that corner.
    pub fn triangulate(self, positions: &[[f64; 3]], faces: &mut [[u32; 3]]) {
        self.triangulate_with(|vertex| positions.get(vertex as usize).copied(), faces);
    }

    /// Triangulates, as [`Self::triangulate`], corners that are not vertex indices; `position` locates a corner.
    pub fn triangulate_with(self, position: impl Fn(u32) -> Option<[f64; 3]>, faces: &mut [[u32; 3]]) {
        let (mut corners, mut points) = (Vec::new(), Vec::new());
        for (start, n_triangles) in self.runs {
            let Some(run) = faces.get_mut(start..start + n_triangles) else { continue };
            corners.clear();
            corners.extend(run.iter().take(1).flat_map(|&[a, b, _]| [a, b]));
            corners.extend(run.iter().map(|face| face[2]));
            points.clear();
            points.extend(corners.iter().map_while(|&corner| position(corner).filter(is_finite)));
            if points.len() == corners.len() {
                for (face, triangle) in run.iter_mut().zip(triangulate(&points)) {
                    *face = triangle.map(|corner| corners[corner as usize]);
                }
            } else {
                corners.rotate_left(points.len());
                for (face, edge) in run.iter_mut().zip(corners[1..].windows(2)) {
                    *face = [corners[0], edge[0], edge[1]];
                }
            }
        }
    }
}

fn is_finite(point: &[f64; 3]) -> bool {
    point.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::Fans;

    #[test]
    fn all_triangles_of_a_flawed_polygon_have_its_flawed_corner() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [f64::NAN; 3], [0.0, 1.0, 0.0]];
        for (polygon, flawed) in
            [([0, 1, 2, 3, 4], 3), ([0, 1, 2, 9, 4], 9), ([3, 0, 1, 2, 4], 3), ([0, 1, 2, 4, 7], 7)]
        {
            let (mut fans, mut faces) = (Fans::default(), Vec::new());
            assert!(fans.push(&polygon, &mut faces));
            fans.triangulate(&positions, &mut faces);
            assert!(faces.len() == 3 && faces.iter().all(|face| face.contains(&flawed)), "{polygon:?} {faces:?}");
        }
    }
}
