//! The step of the objective "bending": scores that say how much the surface bends, as a teacher from geometry has it.
//!
//! A start for the objective "closed", whose measured gradients are noisy: from here it has a short way to go.

use super::{Item, Settings, Step, gradients_of};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use crate::model::{Vertices, Weights, in_edge_lengths, point_sampler};
use crate::simplify::{edge_graph, vertex_areas, vertex_normals};
use glam::Vec3;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::Arc;

/// Times the logarithm of the bending that the scores are to be: importance goes with its square root.
const EXPONENT: f32 = 0.5;
/// Bending beyond this many times the mean, either way, counts as if it were not.
const MOST: f32 = 10.0;

/// One step: the mean squared difference, by area, of scores and the teacher's, each about its mean.
pub(super) fn bending_step(
    weights: &Weights,
    item: &Item,
    _: &Settings,
    _: &mut Xoshiro256PlusPlus,
) -> Result<Step, String> {
    let mesh = &item.mesh;
    let rings = Arc::new(edge_graph(mesh));
    let (positions, directions, areas) =
        (in_edge_lengths(mesh.positions(), &rings), vertex_normals(mesh), vertex_areas(mesh));
    let wanted = teacher(&positions, &directions, &areas, &rings).ok_or("is flat all over")?;
    let mut tape = Tape::default();
    let net = weights.parameters(&mut tape);
    let rows = |rows: &[[f32; 3]]| Value::constant(Matrix::from_points(rows));
    let (points, normals) = (rows(&positions), rows(&directions));
    let vertices = Vertices { points: &points, normals: Some(&normals) };
    let scores = point_sampler(&mut tape, &net.point_sampler, vertices, &rings);
    let (error, gradient) = squared_error(scores.matrix().data(), &wanted, &areas);
    let gradients = gradients_of(&net, &tape.backward(&[(&scores, Matrix::new(gradient.len(), 1, gradient))]));
    Ok(Step { terms: vec![("teacher", error)], gradients })
}

/// `ln(b / mean b) / 2`, b the largest turn of the normal per length along the edges of a vertex, averaged once over
/// them; `None` where nothing bends.
fn teacher(points: &[[f32; 3]], normals: &[[f32; 3]], areas: &[f64], rings: &Csr) -> Option<Vec<f32>> {
    let apart = |rows: &[[f32; 3]], v: usize, w: u32| Vec3::from(rows[v]).distance(rows[w as usize].into());
    let largest = |v: usize| {
        let along = |&w: &u32| apart(normals, v, w) / apart(points, v, w).max(1e-6);
        rings.row(v).iter().map(along).fold(0.0, f32::max)
    };
    let raw: Vec<f64> = (0..points.len()).map(|v| f64::from(largest(v))).collect();
    let averaged = |v: usize| {
        let around = std::iter::once(v).chain(rings.row(v).iter().map(|&w| w as usize));
        let (sum, area) = around.fold((0.0, 0.0), |(sum, area), w| (sum + areas[w] * raw[w], area + areas[w]));
        if area > 0.0 { sum / area } else { raw[v] }
    };
    let smooth: Vec<f64> = (0..points.len()).map(averaged).collect();
    let mean = smooth.iter().zip(areas).map(|(b, area)| b * area).sum::<f64>() / areas.iter().sum::<f64>();
    let log = |b: &f64| EXPONENT * ((b / mean) as f32).clamp(1.0 / MOST, MOST).ln();
    (mean > 0.0 && mean.is_finite()).then(|| smooth.iter().map(log).collect())
}

/// The error and its gradient to the scores.
fn squared_error(scores: &[f32], wanted: &[f32], areas: &[f64]) -> (f64, Vec<f32>) {
    let total: f64 = areas.iter().sum();
    let differences: Vec<f64> = scores.iter().zip(wanted).map(|(s, w)| f64::from(*s) - f64::from(*w)).collect();
    let mean = differences.iter().zip(areas).map(|(d, area)| d * area).sum::<f64>() / total;
    let error = differences.iter().zip(areas).map(|(d, area)| (d - mean).powi(2) * area).sum::<f64>() / total;
    let slope = |(d, area): (&f64, &f64)| (2.0 * (d - mean) * area / total) as f32;
    (error, differences.iter().zip(areas).map(slope).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_teacher_asks_for_edges_and_is_silent_on_planes() {
        let mesh = shapes::cuboid([1.0; 3], 8);
        let (normals, areas, rings) = (vertex_normals(&mesh), vertex_areas(&mesh), edge_graph(&mesh));
        let wanted = teacher(mesh.positions(), &normals, &areas, &rings).unwrap();
        let middle = mesh.positions().iter().position(|p| p[0] == 0.5 && p[1] == 0.5).unwrap();
        let corner = mesh.positions().iter().position(|p| *p == [0.0; 3]).unwrap();
        assert_eq!(wanted[middle], EXPONENT * (1.0 / MOST).ln());
        assert!(wanted[corner] > 0.2);
        let flat = shapes::grid(5, 5);
        let (normals, areas, rings) = (vertex_normals(&flat), vertex_areas(&flat), edge_graph(&flat));
        assert_eq!(teacher(flat.positions(), &normals, &areas, &rings), None);
    }

    #[test]
    fn the_error_has_its_golden_value_and_gradient() {
        // Differences 1 and 3 with areas 3 and 1: mean 1.5.
        let (error, gradient) = squared_error(&[2.0, 3.0], &[1.0, 0.0], &[3.0, 1.0]);
        assert_eq!((error, gradient), (0.75 * 0.25 + 0.25 * 2.25, vec![-0.75, 0.75]));
    }
}
