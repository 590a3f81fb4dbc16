//! Attraction of faces by points that remain far from them after the fit.

use glam::Vec3;

use crate::geometry::triangle::nearest_weights;
use crate::simplify::closed::output::Output;

use super::facets::{Facets, Projection};
use super::sample_points::SamplePoints;

/// Least distance at which a point attracts its face, over the root mean square height of all.
// At 5 the largest distance is 2 % larger.
const FAR: f32 = 4.0;
/// Distance that remains after the attraction, over the least distance at which a point attracts.
// Below 1, so that small changes do not make the point far again.
const REMAINING: f32 = 0.9;

struct FarPoint {
    distance: f32,
    offset: Vec3,
    foot: Projection,
}

/// Computes the steps of the vertices toward far points; each vertex follows at most one point.
pub fn attraction_steps(points: &mut SamplePoints, facets: &Facets) -> Vec<Vec3> {
    let output = facets.output;
    let mut matches = Vec::new();
    points.assign(facets, |found| matches.extend(found.iter().flatten().copied()));
    // A distance is far in relation to the usual height.
    let [squares, area] = matches.iter().fold([0.0f64; 2], |[squares, area], m| {
        let height = f64::from(m.projection.height);
        [squares + f64::from(m.area) * height * height, area + f64::from(m.area)]
    });
    let far = FAR * (squares / area.max(f64::MIN_POSITIVE)).sqrt() as f32;
    // Only points high above their face, or projected to its border, can be far.
    let may_be_far = |foot: &Projection| foot.height.abs() > far || foot.weights.contains(&0.0);
    let suspects = matches.iter().filter(|m| may_be_far(&m.projection));
    let mut found: Vec<FarPoint> =
        suspects.map(|m| nearest_foot(output, points.position(m.point), m.projection.face)).collect();
    found.retain(|point| point.distance > far);
    // The farthest points choose their faces first.
    found.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    let mut steps = vec![Vec3::ZERO; output.positions.len()];
    for FarPoint { distance, offset, foot } in found {
        let corners = output.face(foot.face);
        if corners.iter().any(|&v| steps[v as usize] != Vec3::ZERO) {
            continue;
        }
        // Least-squares moves of the corners that carry the closest point this far.
        let squared: f32 = foot.weights.iter().map(|w| w * w).sum();
        let share = (1.0 - REMAINING * far / distance) / squared;
        corners.iter().zip(foot.weights).for_each(|(&v, weight)| steps[v as usize] = offset * (share * weight));
    }
    steps
}

fn nearest_foot(output: &Output, point: Vec3, face: u32) -> FarPoint {
    let mut nearest = FarPoint { distance: f32::INFINITY, offset: Vec3::ZERO, foot: Projection::default() };
    // A walk ends at some face near the point; an adjacent one may be nearer.
    for face in output.face(face).into_iter().flat_map(|v| output.faces_around().faces(v)) {
        let corners = output.triangle(face);
        let weights = nearest_weights(point, corners);
        let offset = point - (corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]);
        if offset.length() < nearest.distance {
            nearest = FarPoint { distance: offset.length(), offset, foot: Projection { face, weights, height: 0.0 } };
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::prepare::surface::PreparedSurface;
    use crate::simplify::closed::stage_settings::StageSettings;

    #[test]
    fn a_cut_off_tip_attracts_the_vertex_below_it() {
        let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(2));
        let tipped = |v: usize, p: &[f32; 3]| if v == 0 { p.map(|x| 1.4 * x) } else { *p };
        let positions = fine.positions().iter().enumerate().map(|(v, p)| tipped(v, p)).collect();
        let tipped = TriMesh::new(positions, fine.faces().to_vec()).unwrap();
        let surface = PreparedSurface::new(&tipped, Pulse::NONE);
        // Subdivision appends vertices, so a finer sphere begins with those of the coarser one.
        let mut positions = surface.positions[..coarse.positions().len()].to_vec();
        positions[0] /= 1.4;
        let tip = surface.positions[0] - positions[0];
        let output = Output::from_original(&surface.positions, positions, coarse.faces().to_vec());
        let settings = StageSettings { points_per_vertex: 200, ..StageSettings::default() };
        let steps = attraction_steps(
            &mut SamplePoints::new(&surface, coarse.positions().len(), settings),
            &Facets::new(Pulse::NONE, &output),
        );
        let along = steps[0].dot(tip) / tip.length_squared();
        assert!((0.1..1.0).contains(&along), "{along}");
        assert!(steps[1..].iter().all(|step| step.length() < 0.3 * steps[0].length()));
    }
}
