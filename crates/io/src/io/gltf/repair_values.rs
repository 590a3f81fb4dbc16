//! Repairs of vertex values to glTF's requirements.

use glam::Vec3;

use crate::mesh::sum_face_normals;

/// Accepted deviation from unit length; the Khronos validator allows ten times that.
const UNIT: f32 = 5e-4;

/// Makes normals (n x 3) unit vectors; zero ones take the normal of the surrounding faces.
pub(super) fn mend_normals(normals: &mut [f32], positions: &[[f32; 3]], faces: &[[u32; 3]]) {
    let mut around: Option<Vec<Vec3>> = None;
    for (vertex, row) in normals.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        let normal = Vec3::from(*row);
        // Good normals keep their bits.
        if (normal.length() - 1.0).abs() <= UNIT {
            continue;
        }
        let mut from_faces = || around.get_or_insert_with(|| sum_face_normals(positions, faces))[vertex];
        *row = normal.try_normalize().or_else(|| from_faces().try_normalize()).unwrap_or(Vec3::Z).to_array();
    }
}

/// Makes tangents (n x 4) unit vectors with a sign of 1 or -1.
pub(super) fn mend_tangents(tangents: &mut [f32], normals: Option<&[f32]>) {
    for (vertex, row) in tangents.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let [x, y, z, sign] = *row;
        let tangent = Vec3::new(x, y, z);
        let normal = normals.and_then(|normals| normals.get(3 * vertex..3 * vertex + 3)).map(Vec3::from_slice);
        let mended = if (tangent.length() - 1.0).abs() <= UNIT {
            tangent
        } else {
            let across = || normal.filter(|normal| normal.is_normalized()).unwrap_or(Vec3::Z).any_orthonormal_vector();
            tangent.try_normalize().unwrap_or_else(across)
        };
        *row = mended.extend(if sign < 0.0 { -1.0 } else { 1.0 }).to_array();
    }
}

pub(super) fn mend_colours(colours: &mut [f32]) {
    colours.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
}

/// Splits `rows` (n x width) into joints and weights that sum to one, n x 4 n_sets each.
pub(super) fn normalize_skin(rows: &[f32], width: usize, n_sets: usize) -> (Vec<f32>, Vec<f32>) {
    let n_slots = 4 * n_sets;
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for row in rows.chunks_exact(width) {
        let mut bound = bindings(row);
        // Only vertices with too many joints are sorted; other joints keep their order.
        if bound.len() > n_slots {
            bound.sort_by(|a, b| b.1.total_cmp(&a.1));
            bound.truncate(n_slots);
        }
        let sum: f64 = bound.iter().map(|binding| f64::from(binding.1)).sum();
        let slot = |at: usize| bound.get(at).copied().unwrap_or((0.0, 0.0));
        joints.extend((0..n_slots).map(|at| slot(at).0));
        weights.extend((0..n_slots).map(|at| (f64::from(slot(at).1) / sum) as f32));
    }
    (joints, weights)
}

fn bindings(row: &[f32]) -> Vec<(f32, f32)> {
    let (joints, weights) = row.split_at(row.len() / 2);
    let mut bound: Vec<(f32, f32)> = Vec::new();
    for (joint, &weight) in joints.iter().map(|joint| joint.round().max(0.0)).zip(weights) {
        match bound.iter_mut().find(|known| known.0 == joint) {
            _ if !(weight > 0.0 && weight.is_finite()) => {}
            Some(known) => known.1 += weight,
            None => bound.push((joint, weight)),
        }
    }
    // Without any weight, the first joint gets it all.
    if bound.is_empty() {
        bound.push((joints.first().map_or(0.0, |joint| joint.round().max(0.0)), 1.0));
    }
    bound
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn unit_normals_pass_as_they_are_and_others_are_mended() {
        let unit = [0.600_01, 0.8, 0.0];
        let mut normals = [unit, [0.0, 3.0, 0.0], [0.0; 3]].concat();
        mend_normals(&mut normals, &TRIANGLE, &[[0, 1, 2]]);
        assert_eq!(normals, [unit, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].concat());
        let mut alone = vec![0.0; 3];
        mend_normals(&mut alone, &[[5.0; 3]], &[[0, 0, 0]]);
        assert_eq!(alone, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn tangents_have_a_direction_and_a_sign() {
        let mut tangents = vec![1.0, 0.0, 0.0, -0.3, 0.0, 0.0, 0.0, 0.0];
        mend_tangents(&mut tangents, Some(&[0.0, 0.0, 1.0, 0.0, 1.0, 0.0]));
        assert_eq!(tangents[..4], [1.0, 0.0, 0.0, -1.0]);
        let mended = Vec3::from_slice(&tangents[4..]);
        assert!((mended.length() - 1.0).abs() < 1e-6 && mended.y.abs() < 1e-6 && tangents[7] == 1.0, "{tangents:?}");
    }

    #[test]
    fn weights_sum_to_one_over_distinct_joints() {
        let (joints, weights) = normalize_skin(&[3.0, 7.0, 3.0, 9.0, 0.5, 0.0, 0.5, 1.0], 8, 1);
        assert_eq!((joints, weights), (vec![3.0, 9.0, 0.0, 0.0], vec![0.5, 0.5, 0.0, 0.0]));
    }

    #[test]
    fn without_weights_the_first_joint_has_it_all() {
        let (joints, weights) = normalize_skin(&[2.0, 1.0, 1.0, 1.0, 0.0, 0.0, f32::NAN, -1.0], 8, 1);
        assert_eq!((joints, weights), (vec![2.0, 0.0, 0.0, 0.0], vec![1.0, 0.0, 0.0, 0.0]));
    }

    #[test]
    fn too_many_joints_give_way_to_the_heaviest() {
        let mut row: Vec<f32> = (0..8).map(|joint| joint as f32).collect();
        row.extend([0.1, 0.2, 0.3, 0.4, 0.0, 0.6, 0.0, 0.0]);
        let (joints, weights) = normalize_skin(&row, 16, 1);
        assert_eq!(joints, [5.0, 3.0, 2.0, 1.0]);
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6 && weights[0] == 0.4, "{weights:?}");
    }
}
