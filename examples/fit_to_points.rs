//! Fits a simplified surface to points by gradient descent on the vertices of the fine mesh.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::simplify::{Options, Record, Simplified, SimplifyError, Size, simplify_recorded};
use neural_mesh::spatial::NearestOnTriangles;

/// Descents between two simplifications; the connectivity is constant between them.
const STEPS: usize = 10;
/// Number of simplifications.
const ROUNDS: usize = 12;
/// Length of a step relative to the gradient.
const RATE: f32 = 0.5;
/// Number of times that a gradient is averaged over neighbours.
const SPREAD: usize = 8;

/// Returns points on an ellipsoid with waves, about as large as the initial sphere.
pub fn target() -> Vec<Vec3> {
    let shape = |p: Vec3| p * Vec3::new(1.4, 1.0, 0.7) * (1.0 + 0.1 * (5.0 * p.x).sin());
    shapes::icosphere(4).positions().iter().map(|p| shape((*p).into())).collect()
}

/// Returns the mean squared distance of the points from the surface, and the gradient of half its sum to the vertices.
fn loss(vertices: &[[f32; 3]], faces: &[[u32; 3]], points: &[Vec3]) -> (f64, Vec<Vec3>) {
    let triangles: Vec<_> = faces.iter().map(|face| face.map(|v| vertices[v as usize])).collect();
    let surface = NearestOnTriangles::new(&triangles);
    let (mut sum, mut gradient) = (0.0, vec![Vec3::ZERO; vertices.len()]);
    for point in points {
        let Some(hit) = surface.nearest(point.as_dvec3()) else { continue };
        sum += hit.distance2;
        let away: DVec3 = hit.point - point.as_dvec3();
        for (&v, weight) in faces[hit.triangle as usize].iter().zip(hit.weights) {
            gradient[v as usize] += (away * weight).as_vec3();
        }
    }
    (sum / points.len() as f64, gradient)
}

/// Simplifies `mesh` to 300 vertices, with the record of the run.
fn simplified(mesh: &TriMesh) -> Result<(Simplified, Record), SimplifyError> {
    simplify_recorded(mesh, &Options::new(Size::Vertices(300)), &mut |_| ControlFlow::Continue(()))
}

/// Smooths a gradient: each vertex gets the mean over the faces around it.
fn smoothed(mut gradient: Vec<Vec3>, faces: &[[u32; 3]]) -> Vec<Vec3> {
    for _ in 0..SPREAD {
        let mut sums = vec![(Vec3::ZERO, 0.0); gradient.len()];
        for face in faces {
            let mean = face.iter().map(|&v| gradient[v as usize]).sum::<Vec3>() / 3.0;
            face.iter().for_each(|&v| sums[v as usize] = (sums[v as usize].0 + mean, sums[v as usize].1 + 1.0));
        }
        gradient = sums.iter().map(|(sum, n)| *sum / f32::max(*n, 1.0)).collect();
    }
    gradient
}

/// Moves the vertices of `mesh` until its simplified surface fits the points; returns the loss at each round.
pub fn fit(mut mesh: TriMesh, points: &[Vec3]) -> Result<Vec<f64>, Box<dyn std::error::Error>> {
    let mut losses = Vec::new();
    for _ in 0..ROUNDS {
        let (result, record) = simplified(&mesh)?;
        losses.push(loss(result.mesh.positions(), result.mesh.faces(), points).0);
        let (mut positions, faces) = mesh.into_parts();
        for _ in 0..STEPS {
            let vertices = record.positions(&positions);
            let (_, gradient) = loss(&vertices, result.mesh.faces(), points);
            let gradient: Vec<[f32; 3]> = gradient.iter().map(|g| g.to_array()).collect();
            let to_input = record.backward(&positions, &gradient).into_iter().map(Vec3::from).collect();
            for (p, g) in positions.iter_mut().zip(smoothed(to_input, &faces)) {
                *p = (Vec3::from(*p) - RATE * g).to_array();
            }
        }
        mesh = TriMesh::new(positions, faces)?;
    }
    let (result, _) = simplified(&mesh)?;
    losses.push(loss(result.mesh.positions(), result.mesh.faces(), points).0);
    Ok(losses)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (round, loss) in fit(shapes::icosphere(4), &target())?.iter().enumerate() {
        println!("after {:3} steps: mean squared distance {loss:.3e}", round * STEPS);
    }
    Ok(())
}
