//! Consistent, outward winding.

use glam::{DVec3, Vec3};

use super::half_edges::{spread_winding, twins};

/// Share of the largest possible volume below which a volume is rounding.
const FLAT: f64 = 1e-9;

/// Reverses faces so that neighbours agree where possible and every component faces outward.
///
/// A component is reversed if its faces span a negative volume with the mean of their corners. `faces`: n_faces x 3,
/// three different corners each.
///
/// # Panics
/// If an index is out of range.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::orient_outward;
/// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let faces = orient_outward(&corners, &[[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]]);
/// assert_eq!(faces, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]);
/// ```
pub fn orient_outward(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut wound = faces.to_vec();
    wind(positions, &mut wound, &vec![true; faces.len()]);
    wound
}

/// Reverses faces of `may_turn` as [`orient_outward`] does; those next to others agree with these.
pub(super) fn wind(positions: &[[f32; 3]], faces: &mut [[u32; 3]], may_turn: &[bool]) {
    let twins = twins(positions.len(), faces);
    // Faces that may not turn are wound as they should be.
    let mut is_against: Vec<Option<bool>> = may_turn.iter().map(|may_turn| (!may_turn).then_some(false)).collect();
    let fixed = (0..faces.len() as u32).filter(|&face| !may_turn[face as usize]).collect();
    wind_component(fixed, &twins, faces, &mut is_against);
    for first in 0..faces.len() {
        if is_against[first].is_none() {
            is_against[first] = Some(false);
            let component = wind_component(vec![first as u32], &twins, faces, &mut is_against);
            if faces_inward(positions, faces, &component) {
                component.iter().for_each(|&face| turn(&mut faces[face as usize]));
            }
        }
    }
}

fn wind_component(seeds: Vec<u32>, twins: &[u32], faces: &mut [[u32; 3]], is_against: &mut [Option<bool>]) -> Vec<u32> {
    let component = spread_winding(seeds, faces, twins, is_against);
    let turned = component.iter().filter(|&&face| is_against[face as usize] == Some(true));
    turned.for_each(|&face| turn(&mut faces[face as usize]));
    component
}

fn turn(face: &mut [u32; 3]) {
    face.swap(1, 2);
}

/// Returns whether faces span a negative volume with the mean of their corners; flat sheets do not.
fn faces_inward(positions: &[[f32; 3]], faces: &[[u32; 3]], component: &[u32]) -> bool {
    let corners = |face: u32| faces[face as usize].map(|v| Vec3::from(positions[v as usize]).as_dvec3());
    let sum: DVec3 = component.iter().flat_map(|&face| corners(face)).sum();
    let middle = sum / (3 * component.len()) as f64;
    let (mut volume, mut largest) = (0.0, 0.0);
    for &face in component {
        let [a, b, c] = corners(face).map(|corner| corner - middle);
        volume += a.dot(b.cross(c));
        largest += a.length() * b.length() * c.length();
    }
    volume < -FLAT * largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};
    use proptest::prelude::*;

    fn is_turned(face: [u32; 3], original: [u32; 3]) -> bool {
        let [a, b, c] = original;
        ![[a, b], [b, c], [c, a]].contains(&[face[0], face[1]])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn faces_turned_at_random_come_back_outward(turned in prop::collection::vec(any::<bool>(), 80)) {
            for mesh in [shapes::icosphere(2), shapes::chain_of_tori(2), shapes::touching_spheres(2)] {
                let faces: Vec<[u32; 3]> = mesh.faces().iter().zip(turned.iter().cycle()).map(|(&face, &turned)| {
                    let [a, b, c] = face;
                    if turned { [a, c, b] } else { face }
                }).collect();
                let wound = orient_outward(mesh.positions(), &faces);
                prop_assert!(wound.iter().zip(mesh.faces()).all(|(&face, &original)| !is_turned(face, original)));
            }
        }
    }

    #[test]
    fn one_sided_surfaces_keep_a_seam_and_nothing_worse() {
        let bottle = shapes::klein_bottle(16, 8);
        let wound = orient_outward(bottle.positions(), bottle.faces());
        let seam = topology(&TriMesh::new(bottle.positions().to_vec(), wound).unwrap()).inconsistent_edges;
        assert!((1..200).contains(&seam), "{seam}");
    }

    #[test]
    fn edges_with_three_faces_bind_nothing() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        let fan = [[0, 1, 2], [0, 1, 3], [0, 1, 4]];
        assert_eq!(orient_outward(&positions, &fan), fan);
        assert!(orient_outward(&[], &[]).is_empty());
    }
}
