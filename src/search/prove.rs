//! Proved distances of a progression's levels.

use crate::metrics::{DistanceTolerance, MeasuredOriginal};
use crate::simplify::{Event, Input, Listener, Progression, ProvedLevel, SimplifyError};

use super::placed_original::PlacedOriginal;

/// Ratio of neighbouring sizes of proved levels.
const STEP: f64 = 2.0;
/// Number of vertices below which no level is proved.
const LEAST_SIZE: usize = 4;
/// Budget of visited triangles and boxes for each proof: the first per face of the original, plus the second.
const MOST_VISITS: [u64; 2] = [200, 4_000_000];

/// Proves the distances of levels at halving sizes, for [`Progression::at_error`]; `input` is that of the progression.
///
/// # Errors
/// [`SimplifyError::BadInput`] if the progression is of another mesh; [`SimplifyError::Interrupted`] if `progress` stops.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{mesh::shapes, search::prove_progression, simplify::{ClosedOptions, Input, Progression}};
/// let (mesh, go_on) = (shapes::icosphere(4), &mut |_| ControlFlow::Continue(()));
/// let mut progression = Progression::new(&mesh, &ClosedOptions::default(), go_on).unwrap();
/// prove_progression(&mut progression, &Input::bare(&mesh), go_on).unwrap();
/// assert!(progression.at_error(0.05).unwrap().mesh.faces().len() < 2000);
/// ```
pub fn prove_progression(
    progression: &mut Progression,
    input: &Input,
    progress: &mut Listener,
) -> Result<(), SimplifyError> {
    if !progression.is_of(input.mesh) {
        return Err(SimplifyError::BadInput);
    }
    let original = PlacedOriginal::from_input(input);
    let most = MOST_VISITS[0] * original.view.faces().len() as u64 + MOST_VISITS[1];
    // Placing both meshes in the scene rounds positions to single precision.
    let (rounding, measured) = (2.0 * original.rounding(), MeasuredOriginal::new(&original.view));
    let (mut levels, mut n_vertices, mut distance) = (Vec::new(), progression.n_vertices(), 0.0f64);
    let n_levels = (n_vertices as f64 / LEAST_SIZE as f64).log(STEP).max(1.0);
    loop {
        n_vertices = (n_vertices as f64 / STEP) as usize;
        if n_vertices < LEAST_SIZE {
            break;
        }
        let total = (levels.len() as f32 / n_levels as f32).min(1.0);
        if progress(Event { stage: "proof", done: total, total }).is_break() {
            return Err(SimplifyError::Interrupted);
        }
        let level = progression.at_vertices(n_vertices, false)?;
        // A level that stops short of its size is the smallest.
        let is_smallest = level.mesh.positions().len() > n_vertices;
        let tolerance = DistanceTolerance { enough: distance, ..DistanceTolerance::default() };
        let (proved, _) = measured.certified_distance(&original.view_of(&level), (&tolerance, 0.0), most);
        // Without a proof, no smaller level has one that counts.
        let Some(proved) = proved.filter(|proved| proved.upper.is_finite()) else { break };
        distance = distance.max(proved.upper + rounding);
        levels.push(ProvedLevel::new(n_vertices, distance));
        if is_smallest {
            break;
        }
    }
    progression.set_proved_levels(levels);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::shapes;
    use crate::metrics::{Surface, surface_distance};
    use crate::simplify::ClosedOptions;

    #[test]
    fn no_sample_is_farther_than_proved_and_distances_rise() {
        let (mesh, go_on) = (shapes::wavy_sphere(4, 6.0), &mut |_| ControlFlow::Continue(()));
        let mut progression = Progression::new(&mesh, &ClosedOptions::default(), go_on).unwrap();
        assert_eq!(progression.at_error(0.1), Err(SimplifyError::NotProved));
        prove_progression(&mut progression, &Input::bare(&mesh), go_on).unwrap();
        let levels = progression.proved_levels().to_vec();
        assert!(levels.len() > 5 && levels.is_sorted_by(|x, y| x.distance <= y.distance));
        for level in &levels {
            let found = progression.at_error(level.distance * (1.0 + 1e-12)).unwrap().mesh;
            assert!(found.positions().len() <= level.n_vertices);
            let surfaces = [&mesh, &found].map(|mesh| Surface::new(mesh, 5000, 0));
            assert!(surface_distance(&surfaces[0], &surfaces[1]).unwrap().both.max <= level.distance);
        }
        assert_eq!(progression.at_error(0.0).unwrap().mesh, mesh);
        assert_eq!(progression.at_error(-1.0), Err(SimplifyError::BadError(-1.0)));
        let other = shapes::icosphere(2);
        let refused = prove_progression(&mut progression, &Input::bare(&other), go_on);
        assert_eq!(refused, Err(SimplifyError::BadInput));
    }
}
