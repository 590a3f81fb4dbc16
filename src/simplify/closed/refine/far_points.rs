//! Points of the original that lie far from the faces even after the fit draw the nearest face towards themselves.
//!
//! The fit sees heights over planes. A point beyond the end of a face, where a tip was cut off, has hardly any; what counts for
//! the largest distance is how far it lies from the face itself.

use glam::Vec3;

use crate::geometry::triangle::nearest_weights;
use crate::simplify::closed::output::Output;

use super::facets::{Facets, Projection};
use super::points::Points;

/// Distance from the faces, over the root mean square of the points' heights, beyond which a point draws. Eleven training
/// meshes, four ratios: at 5 the largest distance is 2 % farther.
const FAR: f32 = 4.0;
/// Share of that distance at which it is left alone, so that what happens beside it does not bring it back.
const LEFT: f32 = 0.9;

/// A point that lies far from all faces nearby.
struct FarPoint {
    distance: f32,
    /// From the nearest point of a face to the point.
    way: Vec3,
    /// Where on that face.
    foot: Projection,
}

/// How far the vertices are drawn, the farthest points first; of vertices that share a face with a farther point none is drawn
/// twice.
pub fn draw(points: &mut Points, facets: &Facets) -> Vec<Vec3> {
    let output = facets.output;
    let mut matches = Vec::new();
    points.place(facets, |found| matches.extend(found.iter().flatten().copied()));
    let [squares, area] = matches.iter().fold([0.0f64; 2], |[squares, area], m| {
        let height = f64::from(m.projection.height);
        [squares + f64::from(m.area) * height * height, area + f64::from(m.area)]
    });
    let far = FAR * (squares / area.max(f64::MIN_POSITIVE)).sqrt() as f32;
    let may_be_far = |foot: &Projection| foot.height.abs() > far || foot.weights.contains(&0.0);
    let suspects = matches.iter().filter(|m| may_be_far(&m.projection));
    let mut found: Vec<FarPoint> =
        suspects.map(|m| nearest(output, points.position(m.point), m.projection.face)).collect();
    found.retain(|point| point.distance > far);
    found.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    let mut steps = vec![Vec3::ZERO; output.positions.len()];
    for FarPoint { distance, way, foot } in found {
        let corners = output.face(foot.face);
        if corners.iter().any(|&v| steps[v as usize] != Vec3::ZERO) {
            continue;
        }
        // The least moves of the corners that take the foot so far.
        let squared: f32 = foot.weights.iter().map(|w| w * w).sum();
        let share = (1.0 - LEFT * far / distance) / squared;
        corners.iter().zip(foot.weights).for_each(|(&v, weight)| steps[v as usize] = way * (share * weight));
    }
    steps
}

/// A point as it lies from the nearest of the faces around the corners of one.
fn nearest(output: &Output, point: Vec3, face: u32) -> FarPoint {
    let mut nearest = FarPoint { distance: f32::INFINITY, way: Vec3::ZERO, foot: Projection::default() };
    for face in output.face(face).into_iter().flat_map(|v| output.around().faces(v)) {
        let corners = output.triangle(face);
        let weights = nearest_weights(point, corners);
        let way = point - (corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]);
        if way.length() < nearest.distance {
            nearest = FarPoint { distance: way.length(), way, foot: Projection { face, weights, height: 0.0 } };
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::aim::Aim;
    use crate::simplify::closed::prepare::surface::Surface;

    #[test]
    fn a_tip_that_was_cut_off_draws_the_vertex_below_it() {
        let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(2));
        let tipped = |v: usize, p: &[f32; 3]| if v == 0 { p.map(|x| 1.4 * x) } else { *p };
        let positions = fine.positions().iter().enumerate().map(|(v, p)| tipped(v, p)).collect();
        let tipped = TriMesh::new(positions, fine.faces().to_vec()).unwrap();
        let surface = Surface::new(&tipped, Pulse::NONE);
        // The first vertices of a sphere that is divided further are those of the coarser one.
        let mut positions = surface.positions[..coarse.positions().len()].to_vec();
        positions[0] /= 1.4;
        let tip = surface.positions[0] - positions[0];
        let output = Output::over(&surface.positions, positions, coarse.faces().to_vec());
        let aim = Aim { points_per_vertex: 200, ..Aim::default() };
        let steps = draw(&mut Points::new(&surface, coarse.positions().len(), aim), &Facets::new(Pulse::NONE, &output));
        let along = steps[0].dot(tip) / tip.length_squared();
        assert!((0.1..1.0).contains(&along), "{along}");
        assert!(steps[1..].iter().all(|step| step.length() < 0.3 * steps[0].length()));
    }
}
