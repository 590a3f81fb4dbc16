//! Rejection of fit steps that lead far off the original.

use glam::Vec3;

use crate::mesh::pulse::Pulse;
use crate::simplify::closed::original::Original;

use super::facets::Facets;

/// Largest distance to the original after a step, over the root mean square height.
// Without this check the largest distance is 25 % larger.
const FARTHEST: f32 = 5.0;
/// Rise above an adjacent face, over the root mean square height, from which a vertex is tested.
// At 2 the largest distance is 1 % larger.
const LEAST_RISE: f32 = 1.5;

/// Cancels steps that lead far off the original; `start` are the positions before the fit.
pub fn cancel_stray_steps(original: &Original, facets: &Facets, start: &[Vec3], steps: &mut [Vec3], usual_height: f32) {
    let pulse: Pulse = original.surface.pulse.counting_if(false);
    let output = facets.output;
    let places: Vec<Vec3> = output.positions.iter().zip(&*steps).map(|(p, step)| *p + *step).collect();
    let is_suspect = |v: usize| {
        // A vertex that rose little above its faces cannot have left the surface.
        let rise = places[v] - start[v];
        steps[v] != Vec3::ZERO
            && output
                .faces_around()
                .faces(v as u32)
                .any(|f| facets.normal(f).dot(rise).abs() > LEAST_RISE * usual_height)
    };
    let suspects: Vec<bool> = pulse.map_numbers(steps.len(), is_suspect);
    if !suspects.contains(&true) {
        return;
    }
    // The search starts in the vertex's own region, not on another sheet.
    let nearest_in_regions = original.nearest_in_regions(&places, &output.vertex_of, &suspects);
    for v in (0..steps.len()).filter(|&v| suspects[v]) {
        if original.closest_point_from(places[v], nearest_in_regions[v]).distance > FARTHEST * usual_height {
            steps[v] = Vec3::ZERO;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::closed::output::Output;

    #[test]
    fn stray_steps_are_cancelled_and_steps_along_the_surface_are_kept() {
        let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(1));
        let original = Original::bare(&fine);
        // Subdivision appends vertices, so a finer sphere begins with those of the coarser one.
        let start = original.surface.positions[..coarse.positions().len()].to_vec();
        let output = Output::from_original(&original.surface.positions, start.clone(), coarse.faces().to_vec());
        let facets = Facets::new(Pulse::NONE, &output);
        let mut steps = vec![Vec3::ZERO; start.len()];
        steps[0] = start[0] * 0.5;
        steps[1] = start[1].any_orthogonal_vector() * 0.05;
        steps[2] = start[2] * 0.02;
        let before = steps.clone();
        cancel_stray_steps(&original, &facets, &start, &mut steps, 0.01 * start[0].length());
        assert_eq!(steps[0], Vec3::ZERO);
        assert_eq!(steps[1..], before[1..]);
    }
}
