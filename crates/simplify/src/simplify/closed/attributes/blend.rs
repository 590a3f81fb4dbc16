//! Blending of corner values by role.

use crate::mesh::Role;

/// Length of a mean of unit vectors below which its direction is noise.
const LEAST_LENGTH: f32 = 1e-6;

pub fn blend(role: Role, corners: [&[f32]; 3], weights: [f32; 3], out: &mut [f32]) {
    match role {
        Role::Skin => blend_joints(corners, weights, out),
        Role::Label => out.copy_from_slice(corners[heaviest(weights)]),
        _ => blend_numbers(corners, weights, out),
    }
    match role {
        Role::Normal => normalise(out, corners, weights),
        Role::Tangent => {
            if let Some((direction, [sign, ..])) = out.split_at_mut_checked(3) {
                normalise(direction, corners.map(|corner| &corner[..3]), weights);
                *sign = if *sign < 0.0 { -1.0 } else { 1.0 };
            }
        }
        _ => {}
    }
}

fn blend_numbers(corners: [&[f32]; 3], weights: [f32; 3], out: &mut [f32]) {
    for (i, out) in out.iter_mut().enumerate() {
        // Values of weight 0 must not count, since they may not be numbers.
        let terms = (0..3).filter(|&k| weights[k] > 0.0).map(|k| weights[k] * corners[k][i]);
        *out = terms.sum();
    }
}

fn normalise(out: &mut [f32], corners: [&[f32]; 3], weights: [f32; 3]) {
    let length = out.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > LEAST_LENGTH {
        out.iter_mut().for_each(|x| *x /= length);
    } else {
        out.copy_from_slice(corners[heaviest(weights)]);
    }
}

fn heaviest(weights: [f32; 3]) -> usize {
    (0..3).max_by(|&i, &j| weights[i].total_cmp(&weights[j])).unwrap_or(0)
}

/// Sums a skin's weights per joint, keeps the largest that fit, and restores the total.
fn blend_joints(corners: [&[f32]; 3], weights: [f32; 3], out: &mut [f32]) {
    let n = out.len() / 2;
    let mut joints: Vec<(f32, f32)> = Vec::new();
    for (corner, weight) in corners.into_iter().zip(weights) {
        for (&joint, &share) in corner[..n].iter().zip(&corner[n..]).filter(|(_, share)| **share > 0.0) {
            match joints.iter_mut().find(|(other, _)| *other == joint) {
                Some((_, sum)) => *sum += weight * share,
                None => joints.push((joint, weight * share)),
            }
        }
    }
    let whole: f32 = joints.iter().map(|(_, weight)| weight).sum();
    joints.sort_by(|x, y| y.1.total_cmp(&x.1).then(x.0.total_cmp(&y.0)));
    joints.retain(|(_, weight)| *weight > 0.0);
    joints.truncate(n);
    let kept: f32 = joints.iter().map(|(_, weight)| weight).sum();
    out.fill(0.0);
    for (i, (joint, weight)) in joints.into_iter().enumerate() {
        (out[i], out[n + i]) = (joint, weight * whole / kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_keep_their_length_and_joints_their_sum() {
        let mut normal = [0.0; 3];
        blend(Role::Normal, [&[1.0, 0.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]], [0.5, 0.5, 0.0], &mut normal);
        assert!((normal[0] - 0.5f32.sqrt()).abs() < 1e-6 && normal[0] == normal[1] && normal[2] == 0.0);
        blend(Role::Normal, [&[1.0, 0.0, 0.0], &[-1.0, 0.0, 0.0], &[0.0; 3]], [0.5, 0.5, 0.0], &mut normal);
        assert_eq!(normal, [-1.0, 0.0, 0.0]);
        let mut skin = [0.0; 4];
        blend(Role::Skin, [&[3.0, 5.0, 0.5, 0.5], &[5.0, 7.0, 0.9, 0.1], &[0.0; 4]], [0.5, 0.5, 0.0], &mut skin);
        assert_eq!(skin[..2], [5.0, 3.0]);
        assert!((skin[2] + skin[3] - 1.0).abs() < 1e-6 && (skin[2] / skin[3] - 0.7 / 0.25).abs() < 1e-5);
    }

    #[test]
    fn a_tangent_without_a_sign_is_no_harm() {
        let mut tangent = [0.0; 3];
        blend(Role::Tangent, [&[1.0, 0.0, 0.0], &[0.0; 3], &[0.0; 3]], [1.0, 0.0, 0.0], &mut tangent);
        assert_eq!(tangent, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn values_of_weight_zero_do_not_count() {
        let mut uv = [0.0; 2];
        blend(Role::Uv, [&[1.0, 2.0], &[f32::NAN, 0.0], &[3.0, 4.0]], [0.5, 0.0, 0.5], &mut uv);
        assert_eq!(uv, [2.0, 3.0]);
    }
}
