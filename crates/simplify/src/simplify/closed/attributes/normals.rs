//! Least-squares fit of corner normals to the original's shading.
//!
//! Minimises `|b - |b| n|^2` over the faces, for the blend `b` of three unit normals and the original's normal `n`.

use glam::Vec3;

use crate::mesh::{Channel, Role};
use crate::parallel;

use super::values::{FitSystem, QUADRATURE, STEPS, ValueFit};

/// Length of a vector below which its direction is noise.
const LEAST_LENGTH: f32 = 1e-6;
const MOST_TURNS: usize = 8;
/// Largest cosine between a normal that was turned back and its face's normal.
const LEAST_COSINE: f32 = 0.02;

/// Fits corner normals to the original's, starting from `nearest`, those at the closest points.
pub fn fit_normals(fit: &ValueFit, nearest: Channel, original: &Channel, wedges: &[[u32; 3]]) -> Channel {
    let target = fit.target_values(original, wedges);
    if nearest.width != 3 || nearest.values.iter().chain(&target).any(|x| !x.is_finite()) {
        return nearest;
    }
    // Every normal is its own unknown: wedges that share one were joined before.
    let representative: Vec<u32> = (0..fit.wedges.vertices.len() as u32).collect();
    let mut system = FitSystem { diagonal: fit.diagonal(&representative), target: target.clone(), representative };
    let mut values = nearest.values.clone();
    for _ in 0..STEPS {
        // Target normals are scaled to the blend's length, so that they pull only the direction of the corner normals.
        scale_to_blends(&mut system.target, &target, &values, fit.wedges.face_wedges);
        fit.step(&mut values, &nearest, &system);
        normalise_rows(&mut values, &nearest.values);
    }
    turn_normals_back(&mut values, &nearest.values, fit.wedges.face_wedges, &fit.area_normals);
    Channel { values, ..nearest }
}

fn scale_to_blends(scaled: &mut [f32], target: &[f32], values: &[f32], face_wedges: &[[u32; 3]]) {
    let n = 3 * QUADRATURE.len();
    parallel::rows_mut(scaled, n, 256, |face, scaled| {
        let target = &target[face * n..][..n];
        let corners = face_wedges[face].map(|wedge| row(values, wedge));
        for ((at, _), (scaled, target)) in QUADRATURE.iter().zip(scaled.chunks_exact_mut(3).zip(target.chunks_exact(3)))
        {
            let length = (corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2]).length();
            scaled.iter_mut().zip(target).for_each(|(scaled, target)| *scaled = length * target);
        }
    });
}

fn normalise_rows(values: &mut [f32], nearest: &[f32]) {
    values.chunks_exact_mut(3).zip(nearest.chunks_exact(3)).for_each(|(normal, nearest)| {
        let length = Vec3::from_slice(normal).length();
        if length > LEAST_LENGTH {
            normal.iter_mut().for_each(|x| *x /= length);
        } else {
            normal.copy_from_slice(nearest);
        }
    });
}

/// Turns corner normals that oppose one of their faces back, by the smallest angle.
fn turn_normals_back(values: &mut [f32], nearest: &[f32], face_wedges: &[[u32; 3]], area_normals: &[Vec3]) {
    for _ in 0..MOST_TURNS {
        let mut is_turned = false;
        for_each_opposing(values, nearest, face_wedges, area_normals, |normal, wedge, face| {
            // The normal changes only along the face's normal, until it is a small angle above the face.
            let turned = normal + face * (row(nearest, wedge).dot(face).min(LEAST_COSINE) - normal.dot(face));
            is_turned = true;
            turned.try_normalize().unwrap_or(normal)
        });
        if !is_turned {
            return;
        }
    }
    // Normals that no small turn brings back become their nearest values.
    for_each_opposing(values, nearest, face_wedges, area_normals, |_, wedge, _| row(nearest, wedge));
}

fn for_each_opposing(
    values: &mut [f32],
    nearest: &[f32],
    face_wedges: &[[u32; 3]],
    area_normals: &[Vec3],
    mut replace: impl FnMut(Vec3, u32, Vec3) -> Vec3,
) {
    for (wedges, face) in face_wedges.iter().zip(area_normals) {
        let face = face.normalize_or_zero();
        for &wedge in wedges {
            let normal = row(values, wedge);
            // If the normal at the closest point opposes the face as well, the original is shaded so, and the normal
            // stays.
            if normal.dot(face) <= 0.0 && row(nearest, wedge).dot(face) > 0.0 {
                values[3 * wedge as usize..][..3].copy_from_slice(&replace(normal, wedge, face).to_array());
            }
        }
    }
}

fn row(values: &[f32], wedge: u32) -> Vec3 {
    Vec3::from_slice(&values[3 * wedge as usize..][..3])
}

/// Makes tangents perpendicular to their normals, keeping unit length and sign.
pub fn straighten_tangents(channels: &mut [Channel], may_change: impl Fn(&usize) -> bool) {
    let is_normal = |channel: &&Channel| channel.role == Role::Normal && channel.width == 3;
    let Some(normals) = channels.iter().find(is_normal) else { return };
    let normals: Vec<Vec3> = normals.values.chunks_exact(3).map(Vec3::from_slice).collect();
    for channel in channels.iter_mut().filter(|channel| channel.role == Role::Tangent && channel.width >= 3) {
        let rows = channel.values.chunks_exact_mut(channel.width).zip(&normals).enumerate();
        for (_, (tangent, &normal)) in rows.filter(|(wedge, _)| may_change(wedge)) {
            let along = Vec3::from_slice(tangent);
            // Gram-Schmidt; the sign in the fourth component stays.
            let across = along - normal * along.dot(normal);
            if across.length() > LEAST_LENGTH && across.is_finite() {
                tangent[..3].copy_from_slice(&across.normalize().to_array());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_the_original_become_as_long_as_the_blends() {
        let values = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let target: Vec<f32> =
            (0..QUADRATURE.len()).flat_map(|k| if k < 3 { [0.0, 0.6, 0.8] } else { [1.0, 0.0, 0.0] }).collect();
        let mut scaled = target.clone();
        scale_to_blends(&mut scaled, &target, &values, &[[0, 1, 2]]);
        for (k, ([a, b, c], _)) in QUADRATURE.into_iter().enumerate() {
            let naive = (a * a + b * b + c * c).sqrt();
            assert!((row(&scaled, k as u32) - row(&target, k as u32) * naive).length() < 1e-6);
        }
    }

    #[test]
    fn a_normal_that_looks_away_from_a_face_is_turned_back_as_little_as_that_takes() {
        let nearest = [0.0, 0.0, 1.0].repeat(3);
        let mut values = [[0.0, 0.6, 0.8], [0.0, 1.0, -0.01], [0.6, 0.0, 0.8]].concat();
        turn_normals_back(&mut values, &nearest, &[[0, 1, 2]], &[3.0 * Vec3::Z]);
        assert_eq!([row(&values, 0), row(&values, 2)], [[0.0, 0.6, 0.8].into(), [0.6, 0.0, 0.8].into()]);
        let turned = row(&values, 1);
        assert!(
            (turned.length() - 1.0).abs() < 1e-6 && turned.dot(Vec3::Z) > 0.01 && turned.dot(Vec3::Y) > 0.999,
            "{turned}"
        );
    }

    #[test]
    fn a_normal_that_no_small_turn_brings_back_gets_its_nearest_value() {
        let (nearest, steep) = ([0.0, 0.0, 1.0].repeat(3), Vec3::new(0.0, 1.0, 0.001));
        let mut values = [0.0, 0.0, -1.0].repeat(3);
        turn_normals_back(&mut values, &nearest, &[[0, 1, 2], [0, 2, 1]], &[steep, Vec3::new(0.0, -1.0, 0.001)]);
        assert_eq!(values, nearest);
    }

    #[test]
    fn normals_are_of_unit_length_and_have_a_direction() {
        let mut values = vec![0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
        normalise_rows(&mut values, &[1.0, 0.0, 0.0].repeat(2));
        assert_eq!(values, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn tangents_lie_across_normals_and_keep_their_sign() {
        let channel = |role, width, values| Channel { name: String::new(), role, width, values };
        let tangents = vec![0.6, 0.0, 0.8, -1.0, 0.0, 0.0, 1.0, 1.0];
        let mut channels = [channel(Role::Tangent, 4, tangents), channel(Role::Normal, 3, [0.0, 0.0, 1.0].repeat(2))];
        straighten_tangents(&mut channels, |_| false);
        assert_eq!(channels[0].values[..4], [0.6, 0.0, 0.8, -1.0]);
        straighten_tangents(&mut channels, |_| true);
        assert_eq!(channels[0].values, [1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 1.0]);
    }
}
