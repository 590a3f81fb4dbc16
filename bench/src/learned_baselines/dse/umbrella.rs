//! Delaunay triangles around the patches' own points, and their votes.

use super::Patch;
use neural_mesh::parallel;
use rustc_hash::FxHashMap;
use spade::{DelaunayTriangulation, Point2, Triangulation};

/// Returns the Delaunay triangles at the patch's own point, corners ascending.
fn umbrella(patch: &Patch) -> Vec<[u32; 3]> {
    let radius = patch.radius();
    let unit = if radius > 0.0 { radius } else { 1.0 };
    let mut triangulation: DelaunayTriangulation<Point2<f64>> = DelaunayTriangulation::new();
    let mut points = Vec::with_capacity(patch.points.len());
    for (&point, at) in patch.points.iter().zip(&patch.map) {
        // Invalid and nearly coincident points are no corners.
        let placed = triangulation.insert(Point2::new(at[0] / unit, at[1] / unit));
        if placed.is_ok_and(|vertex| vertex.index() == points.len()) {
            points.push(point);
        }
    }
    let Some(&own) = patch.points.first() else { return Vec::new() };
    let corners = triangulation.inner_faces().map(|face| face.vertices().map(|vertex| points[vertex.fix().index()]));
    let mut triangles: Vec<[u32; 3]> = corners.filter(|corners| corners.contains(&own)).collect();
    triangles.iter_mut().for_each(|corners| corners.sort_unstable());
    triangles.sort_unstable();
    triangles
}

/// Returns each triangle with its votes: the corners whose umbrella contains it, 1 to 3; sorted by
/// corners.
pub fn count_votes(patches: &[Patch]) -> Vec<([u32; 3], u8)> {
    let umbrellas = parallel::map(patches.len(), 16, |i| umbrella(&patches[i]));
    let mut counts: FxHashMap<[u32; 3], u8> = FxHashMap::default();
    umbrellas.into_iter().flatten().for_each(|corners| *counts.entry(corners).or_default() += 1);
    let mut counted: Vec<([u32; 3], u8)> = counts.into_iter().collect();
    counted.sort_unstable();
    counted
}

#[cfg(test)]
mod tests {
    use super::super::exact_patches;
    use super::*;
    use neural_mesh::mesh::shapes;

    fn patch(map: &[[f64; 2]]) -> Patch {
        Patch { points: (0..map.len() as u32).collect(), map: map.to_vec() }
    }

    #[test]
    fn no_circle_around_a_triangle_holds_a_point() {
        let map: Vec<[f64; 2]> =
            std::iter::once([0.0; 2]).chain((1..25).map(|i| [f64::from(i).sin(), f64::from(i * i).cos()])).collect();
        let corners = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [-1.0, -1.0], [5.0, 5.0]];
        let small = Patch { points: vec![7, 3, 4, 9, 1], map: corners };
        assert_eq!(umbrella(&small), [[3, 4, 7], [3, 7, 9], [4, 7, 9]]);
        let triangles = umbrella(&patch(&map));
        assert!(triangles.len() > 3);
        for corners in &triangles {
            let [a, b, c] = corners.map(|v| map[v as usize]);
            let cross =
                |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            let area = 2.0 * cross(a, b, c);
            let squared = |p: [f64; 2]| p[0] * p[0] + p[1] * p[1];
            let centre = [
                (squared(a) * (b[1] - c[1]) + squared(b) * (c[1] - a[1]) + squared(c) * (a[1] - b[1])) / area,
                (squared(a) * (c[0] - b[0]) + squared(b) * (a[0] - c[0]) + squared(c) * (b[0] - a[0])) / area,
            ];
            let distance = |p: [f64; 2]| (p[0] - centre[0]).hypot(p[1] - centre[1]);
            assert!(map.iter().all(|&p| distance(p) > distance(a) - 1e-9));
        }
    }

    #[test]
    fn degenerate_patches_have_no_triangles() {
        assert!(umbrella(&Patch::default()).is_empty());
        assert!(umbrella(&patch(&[[0.0; 2]; 4])).is_empty());
        assert!(umbrella(&patch(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])).is_empty());
        assert!(umbrella(&patch(&[[0.0, 0.0], [f64::NAN, 1.0], [1.0, 0.0]])).is_empty());
    }

    #[test]
    fn on_a_round_surface_all_agree() {
        let sphere = shapes::icosphere(3);
        let samples: Vec<u32> = (0..sphere.positions().len() as u32).collect();
        let counted = count_votes(&exact_patches(&sphere, &samples, 24));
        let unanimous = counted.iter().filter(|(_, votes)| *votes == 3).count();
        assert_eq!((unanimous, counted.len()), (1280, 1280));
    }
}
