//! Random changes of a mesh before a step: rotation and stretching.

use super::Settings;
use super::random::{normal_pair, uniform};
use crate::mesh::{InvalidMesh, TriMesh};
use crate::model::normalize_points;
use glam::{DMat3, DQuat, DVec3, Vec3};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Rotates and stretches a mesh as the settings say; the result has mean 0 and bounding box diagonal 1.
pub(super) fn augment_mesh(
    mesh: &TriMesh,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<TriMesh, InvalidMesh> {
    let turn = if settings.rotation { DMat3::from_quat(random_rotation(random)) } else { DMat3::IDENTITY };
    let stretch = DVec3::from_array([0; 3].map(|_| (settings.scale * (2.0 * uniform(random) - 1.0)).exp()));
    let change = DMat3::from_diagonal(stretch) * turn;
    let moved = mesh.positions().iter().map(|&p| change * Vec3::from(p).as_dvec3());
    let positions: Vec<[f32; 3]> = moved.map(|p| p.to_array().map(|x| x as f32)).collect();
    TriMesh::new(normalize_points(&positions), mesh.faces().to_vec())
}

/// Draws a uniform point on the sphere of unit quaternions.
fn random_rotation(random: &mut Xoshiro256PlusPlus) -> DQuat {
    let ([x, y], [z, w]) = (normal_pair(random), normal_pair(random));
    let length = (x * x + y * y + z * z + w * w).sqrt();
    if length > 0.0 { DQuat::from_xyzw(x / length, y / length, z / length, w / length) } else { DQuat::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::super::roughen::mean_edge_length;
    use super::*;
    use crate::mesh::shapes;
    use rand_xoshiro::rand_core::SeedableRng;

    fn change_mesh(mesh: &TriMesh, text: &str, seed: u64) -> TriMesh {
        let settings = Settings::from_toml(text).unwrap();
        augment_mesh(mesh, &settings, &mut Xoshiro256PlusPlus::seed_from_u64(seed)).unwrap()
    }

    fn proportions(mesh: &TriMesh) -> Vec<f64> {
        let lengths = |faces: &[[u32; 3]]| mean_edge_length(mesh.positions(), faces);
        mesh.faces().chunks(1).map(|face| lengths(face) / lengths(&mesh.faces()[..1])).collect()
    }

    fn largest_change(a: &TriMesh, b: &TriMesh) -> f64 {
        let pairs = proportions(a).into_iter().zip(proportions(b));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn without_changes_only_the_frame_changes() {
        let mesh = shapes::torus(12, 8, 2.0, 0.5);
        let same = change_mesh(&mesh, "rotation = false\nscale = 0", 1);
        assert_eq!(same.positions(), normalize_points(mesh.positions()));
        assert_eq!(same.faces(), mesh.faces());
    }

    #[test]
    fn rotation_keeps_lengths_and_scale_does_not() {
        let mesh = shapes::torus(12, 8, 2.0, 0.5);
        let turned = change_mesh(&mesh, "rotation = true\nscale = 0", 2);
        assert!(largest_change(&mesh, &turned) < 1e-4);
        assert!((normalize_points(mesh.positions())[0][2] - turned.positions()[0][2]).abs() > 1e-3);
        assert!(largest_change(&mesh, &change_mesh(&mesh, "rotation = false\nscale = 0.3", 3)) > 0.02);
    }

    #[test]
    fn the_same_state_gives_the_same_mesh() {
        let mesh = shapes::icosphere(1);
        let text = "scale = 0.2";
        assert_eq!(change_mesh(&mesh, text, 4), change_mesh(&mesh, text, 4));
        assert_ne!(change_mesh(&mesh, text, 4), change_mesh(&mesh, text, 5));
    }
}
