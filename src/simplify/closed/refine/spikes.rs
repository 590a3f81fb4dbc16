//! Spikes: vertices much farther from the original than their neighbours are moved back toward it.

use glam::Vec3;

use crate::geometry::triangle::unit_normal;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;

/// Distance of a vertex from the original, over the mean distance of its neighbours, from which it is a spike.
const SPIKE: f32 = 5.0;
/// Distance that remains, over that from which the vertex is a spike.
const REMAINING: f32 = 0.9;
// A vertex that moves back can make spikes of its neighbours.
const ROUNDS: usize = 4;

/// Moves spikes of at least the distance `least` back until they are none; returns the number of vertices moved.
pub fn shorten(original: &Original, output: &mut Output, least: f32) -> usize {
    let pulse = original.surface.pulse.counting_if(false);
    let all = vec![true; output.positions.len()];
    let starts = original.nearest_in_regions(&output.positions, &output.vertex_of, &all);
    let closest = |output: &Output, v: u32, start: u32| {
        let at = original.closest_point_from(output.positions[v as usize], starts[start as usize]);
        Some(at).filter(|at| at.distance.is_finite())
    };
    let distance = |v: usize| closest(output, v as u32, v as u32).map_or(0.0, |at| at.distance);
    let mut distances: Vec<f32> = pulse.map_numbers(all.len(), distance);
    let mut is_moved = vec![false; distances.len()];
    for _ in 0..ROUNDS {
        let mut n_moved = 0;
        for v in 0..distances.len() as u32 {
            let at = v as usize;
            if distances[at] <= least || output.pins.is_pinned(v) {
                continue;
            }
            let most = most_distance(output, &distances, v).max(least);
            if distances[at] <= most {
                continue;
            }
            // A walk may end too early, so the neighbours' walks are asked as well.
            let starts = std::iter::once(v).chain(neighbours(output, v));
            let found = starts.filter_map(|start| closest(output, v, start));
            let Some(foot) = found.min_by(|a, b| a.distance.total_cmp(&b.distance)) else { continue };
            distances[at] = foot.distance;
            let share = REMAINING * most / foot.distance;
            let place = foot.point + (output.positions[at] - foot.point) * share;
            if foot.distance > most && try_move(output, v, place) {
                distances[at] = REMAINING * most;
                is_moved[at] = true;
                n_moved += 1;
            }
        }
        if n_moved == 0 {
            break;
        }
    }
    is_moved.into_iter().filter(|moved| *moved).count()
}

fn neighbours(output: &Output, v: u32) -> impl Iterator<Item = u32> {
    output.faces_around().faces(v).flat_map(|f| output.face(f)).filter(move |w| *w != v)
}

/// Returns the distance from which a vertex is a spike among its neighbours.
fn most_distance(output: &Output, distances: &[f32], v: u32) -> f32 {
    let (mut sum, mut n) = (0.0, 0);
    for w in neighbours(output, v) {
        (sum, n) = (sum + distances[w as usize], n + 1);
    }
    SPIKE * sum / n.max(1) as f32
}

/// Moves a vertex unless this turns a face over.
fn try_move(output: &mut Output, v: u32, place: Vec3) -> bool {
    let normals = |output: &Output| -> Vec<Vec3> {
        output.faces_around().faces(v).map(|f| unit_normal(output.triangle(f))).collect()
    };
    let before = normals(output);
    let place_before = std::mem::replace(&mut output.positions[v as usize], place);
    let is_moved = before.iter().zip(normals(output)).all(|(before, now)| before.dot(now) > 0.0);
    if !is_moved {
        output.positions[v as usize] = place_before;
    }
    is_moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    const LEAST: f32 = 1e-3;

    #[test]
    fn spikes_move_back_until_they_are_none() {
        let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(2));
        let original = Original::bare(&fine);
        // Subdivision appends vertices, so a finer sphere begins with those of the coarser one.
        let start = original.surface.positions[..coarse.positions().len()].to_vec();
        let mut places = start.clone();
        places.iter_mut().for_each(|p| *p *= 1.001);
        places[7] = start[7] * 1.3;
        let mut output = Output::from_original(&original.surface.positions, places.clone(), coarse.faces().to_vec());
        assert_eq!(shorten(&original, &mut output, LEAST), 1);
        let height = |v: usize| output.positions[v].distance(start[v]) / start[v].length();
        assert!((0.0005..0.0055).contains(&height(7)), "{}", height(7));
        let others = || (0..places.len()).filter(|v| *v != 7);
        assert!(others().all(|v| output.positions[v] == places[v]));
        assert_eq!(shorten(&original, &mut output, LEAST), 0);
    }

    #[test]
    fn vertices_alike_and_invisible_spikes_stay() {
        let fine = shapes::icosphere(3);
        let original = Original::bare(&fine);
        let mut places: Vec<Vec3> = original.surface.positions.iter().map(|p| *p * 1.1).collect();
        let faces = fine.faces().to_vec();
        let mut output = Output::from_original(&original.surface.positions, places.clone(), faces.clone());
        assert_eq!(shorten(&original, &mut output, LEAST), 0);
        places.clone_from(&original.surface.positions);
        places[3] *= 1.0 + 0.5 * LEAST;
        let mut output = Output::from_original(&original.surface.positions, places, faces);
        assert_eq!(shorten(&original, &mut output, LEAST), 0);
    }
}
