//! Faces turned against the original surface: foldovers.

use glam::DVec3;

use super::Surface;
use super::search_budget::run_within_budget;
use super::surface::triangles;
use crate::geometry::triangle::corners_f64;
use crate::mesh::TriMesh;

const TEST_POINTS: [[f64; 3]; 4] = [
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
];

/// Extra distance, as a share of a face's longest edge, up to which an original face of its orientation counts as
/// nearest.
const SLACK: f64 = 0.25;

/// Largest number of triangles and boxes visited: a fixed number, plus a number per face.
const MAX_VISITS: [u64; 2] = [5_000_000, 300];

/// Returns the faces of the simplified mesh that are turned against the original surface, ascending.
///
/// A face is turned if the nearest original face opposes it at four inner points. An agreeing original face at most a
/// quarter of the longest edge farther excludes that, as on thin sheets. Faces without area are not tested.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::{Surface, turned_faces}};
/// let sphere = shapes::icosphere(3);
/// assert!(turned_faces(&Surface::new(&sphere, 1, 0), &shapes::icosphere(1)).is_empty());
/// ```
pub fn turned_faces(original: &Surface, simplified: &TriMesh) -> Vec<u32> {
    find_turned(original, simplified, u64::MAX).unwrap_or_default()
}

pub(super) fn n_turned_faces(original: &Surface, simplified: &TriMesh) -> Option<usize> {
    let most = MAX_VISITS[0] + MAX_VISITS[1] * simplified.faces().len() as u64;
    find_turned(original, simplified, most).map(|faces| faces.len())
}

fn find_turned(original: &Surface, simplified: &TriMesh, most: u64) -> Option<Vec<u32>> {
    let triangles = triangles(simplified);
    let turned = |face: usize| is_turned(original, corners_f64(triangles[face]));
    let is_turned = run_within_budget(triangles.len(), most, turned)?;
    Some((0..).zip(is_turned).filter(|&(_, is_turned)| is_turned).map(|(face, _)| face).collect())
}

fn is_turned(original: &Surface, [a, b, c]: [DVec3; 3]) -> (bool, u64) {
    let normal = (b - a).cross(c - a);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let mut n_visits = 0;
    let mut is_opposed = |&[u, v, w]: &[f64; 3]| {
        let (is_wrong, n) = is_opposed(original, a * u + b * v + c * w, normal, SLACK * longest);
        n_visits += n;
        is_wrong
    };
    let is_turned = normal.length_squared() > 0.0 && TEST_POINTS.iter().all(&mut is_opposed);
    (is_turned, n_visits)
}

/// Returns whether the original face nearest to `p`, and all at most `slack` farther, oppose `normal`; also returns the
/// visits.
fn is_opposed(original: &Surface, p: DVec3, normal: DVec3, slack: f64) -> (bool, u64) {
    let agrees = |face: u32| original.normals[face as usize].dot(normal) > 0.0;
    let (nearest, n_visits) = original.nearest.nearest_with_cost(p);
    let Some(nearest) = nearest.filter(|nearest| !agrees(nearest.triangle)) else { return (false, n_visits.into()) };
    let reach = nearest.distance2.sqrt() + slack;
    let (is_any, n_more) = original.nearest.is_within_distance_with_cost(p, reach, agrees);
    (!is_any, u64::from(n_visits) + u64::from(n_more))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn find_turned_faces(original: &TriMesh, simplified: &TriMesh) -> Vec<u32> {
        turned_faces(&Surface::new(original, 1, 0), simplified)
    }

    fn flip_faces(mesh: &TriMesh, which: &[usize]) -> TriMesh {
        let turn = |(i, &[a, b, c]): (usize, &[u32; 3])| if which.contains(&i) { [a, c, b] } else { [a, b, c] };
        TriMesh::new(mesh.positions().to_vec(), mesh.faces().iter().enumerate().map(turn).collect()).unwrap()
    }

    #[test]
    fn faces_turned_over_are_found_and_no_others() {
        let sphere = shapes::icosphere(2);
        assert_eq!(find_turned_faces(&sphere, &flip_faces(&sphere, &[3, 17, 200])), [3, 17, 200]);
        assert_eq!(find_turned_faces(&shapes::icosphere(4), &shapes::icosphere(1)), [0u32; 0]);
        assert_eq!(find_turned_faces(&shapes::bolt(48), &shapes::bolt(48)), [0u32; 0]);
    }

    #[test]
    fn a_fold_in_a_flat_part_is_found() {
        let grid = shapes::grid(8, 8);
        let mut positions = grid.positions().to_vec();
        // A vertex moved past its neighbour turns the faces between them.
        let inner = positions.iter().position(|p| p[0] == 0.5 && p[1] == 0.5).unwrap();
        positions[inner][0] = 0.7;
        let folded = find_turned_faces(&grid, &TriMesh::new(positions, grid.faces().to_vec()).unwrap());
        assert!(!folded.is_empty() && folded.len() <= 3, "{folded:?}");
    }

    #[test]
    fn what_takes_too_long_to_find_is_not_known() {
        let sphere = shapes::icosphere(3);
        let all: Vec<usize> = (0..sphere.faces().len()).collect();
        let over = flip_faces(&sphere, &all);
        let original = Surface::new(&sphere, 1, 0);
        assert_eq!(n_turned_faces(&original, &over), Some(over.faces().len()));
        assert_eq!(find_turned(&original, &over, 10_000), None);
    }

    #[test]
    fn the_other_side_of_a_thin_sheet_is_no_alarm() {
        let sheet = shapes::thin_sheet(60, 1e-3);
        let mut lifted = shapes::thin_sheet(12, 1e-3).positions().to_vec();
        for (i, p) in lifted.iter_mut().enumerate() {
            p[2] += if i % 2 == 0 { 2e-3 } else { -2e-3 };
        }
        let coarse = TriMesh::new(lifted, shapes::thin_sheet(12, 1e-3).faces().to_vec()).unwrap();
        assert_eq!(find_turned_faces(&sheet, &coarse), [0u32; 0]);
    }
}
