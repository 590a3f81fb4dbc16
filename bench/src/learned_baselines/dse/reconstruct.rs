//! Surface from the maps of patches.

use super::{Patch, align_maps, count_votes, select_triangles};
use neural_mesh::mesh::orient_outward;

/// Meshes points by their patches: aligns maps, counts votes and selects triangles.
///
/// # Shapes
/// - `points`: n x 3, finite; `patches`: one per point, in order
pub fn reconstruct(points: &[[f32; 3]], patches: &[Patch]) -> Vec<[u32; 3]> {
    orient_outward(points, &select_triangles(points, &count_votes(&align_maps(patches))))
}

#[cfg(test)]
mod tests {
    use super::super::exact_patches;
    use super::*;
    use neural_mesh::mesh::{TriMesh, edges, shapes};
    use neural_mesh::spatial::farthest_points;

    fn open_edges(mesh: &TriMesh, n: usize) -> [usize; 2] {
        let samples = farthest_points(mesh.positions(), n, 0);
        let points: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
        let faces = reconstruct(&points, &exact_patches(mesh, &samples, 24));
        let all = edges(&TriMesh::new(points, faces).unwrap());
        assert!(all.iter().all(|edge| edge.n_faces() <= 2));
        [all.iter().filter(|edge| edge.n_faces() == 1).count(), all.len()]
    }

    #[test]
    fn a_plane_is_covered_once() {
        let grid = shapes::grid(20, 20);
        let samples: Vec<u32> = (0..441).collect();
        let faces = reconstruct(grid.positions(), &exact_patches(&grid, &samples, 24));
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| glam::Vec3::from(grid.positions()[v as usize]));
            0.5 * (b - a).cross(c - a).length()
        };
        let [all, original] = [&faces[..], grid.faces()].map(|faces| faces.iter().map(area).sum::<f32>());
        assert!(all <= 1.0001 * original && all > 0.98 * original, "{all} {original}");
    }

    #[test]
    fn round_surfaces_are_nearly_closed() {
        let sphere = shapes::icosphere(3);
        let patches = exact_patches(&sphere, &(0..642).collect::<Vec<u32>>(), 24);
        assert_eq!(reconstruct(sphere.positions(), &patches).len(), 1280);
        for (mesh, n) in
            [(shapes::icosphere(4), 400), (shapes::wavy_sphere(4, 5.0), 600), (shapes::torus(80, 40, 1.0, 0.4), 500)]
        {
            let [open, all] = open_edges(&mesh, n);
            assert!(50 * open < all, "{open} of {all}");
        }
    }

    #[test]
    fn nothing_of_nothing() {
        assert!(reconstruct(&[], &[]).is_empty());
        let two = [
            Patch { points: vec![0, 1], map: vec![[0.0; 2], [1.0, 0.0]] },
            Patch { points: vec![1, 0], map: vec![[0.0; 2]; 2] },
        ];
        assert!(reconstruct(&[[0.0; 3], [1.0; 3]], &two).is_empty());
    }
}
