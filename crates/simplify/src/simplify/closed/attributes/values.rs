//! Least-squares fit of corner values to the original, at quadrature points on each face's side of the seams.

use glam::Vec3;

use crate::geometry::triangle::area_normal;
use crate::mesh::{Channel, same_values};
use crate::parallel;
use crate::simplify::closed::original::{SeamBoundedSearch, SurfacePoint};
use crate::simplify::closed::pins::Pins;

use super::blend::blend;

/// Quadrature points as barycentric weights, with their weights.
///
/// Exact for degree four (Dunavant 1985, "High degree efficient symmetrical Gaussian quadrature rules for the
/// triangle").
pub(super) const QUADRATURE: [([f32; 3], f32); 6] = [
    ([0.108_103, 0.445_948_5, 0.445_948_5], 0.223_382),
    ([0.445_948_5, 0.108_103, 0.445_948_5], 0.223_382),
    ([0.445_948_5, 0.445_948_5, 0.108_103], 0.223_382),
    ([0.816_848, 0.091_576, 0.091_576], 0.109_952),
    ([0.091_576, 0.816_848, 0.091_576], 0.109_952),
    ([0.091_576, 0.091_576, 0.816_848], 0.109_952),
];
/// Weight of the value at the closest point, over that of the quadrature points.
// Twelve textured meshes: at 0.08 texture coordinates are 0.6 % farther from the original's.
const NEAREST_WEIGHT: f32 = 0.02;
// Steps toward the minimum: together they leave 0.6 % of the error. 6 steps are 0.05 % worse, 24 no better.
pub(super) const STEPS: usize = 12;
// Least weight of a wedge that is fitted: its inverse times any value must be finite.
const LEAST_WEIGHT: f32 = 1e-30;
// Damping of Jacobi's step. Eigenvalues over the diagonal are between 1/2 and 2 (Wathen 1987), so a step leaves at most
// 0.65 of any error.
const DAMPING: f32 = 0.7;

/// Wedges of the result with their closest points on the original.
#[derive(Clone, Copy)]
pub struct ResultWedges<'a> {
    pub face_wedges: &'a [[u32; 3]],
    pub vertices: &'a [u32],
    pub surface_points: &'a [SurfacePoint],
}

pub struct ValueFit<'a> {
    pub(super) wedges: ResultWedges<'a>,
    points: Vec<[SurfacePoint; QUADRATURE.len()]>,
    pub(super) area_normals: Vec<Vec3>,
    areas: Vec<f32>,
    pins: &'a Pins,
}

impl<'a> ValueFit<'a> {
    pub fn new(original: &SeamBoundedSearch, wedges: ResultWedges<'a>, positions: &[Vec3], pins: &'a Pins) -> Self {
        let corners = |of: &[u32; 3]| of.map(|wedge| positions[wedges.vertices[wedge as usize] as usize]);
        let look_up = |face: usize| {
            let of = &wedges.face_wedges[face];
            // The search starts at the faces of the corners, and so on their side of the seams.
            let starts = of.map(|wedge| wedges.surface_points[wedge as usize].face);
            let [a, b, c] = corners(of);
            QUADRATURE.map(|(at, _)| original.closest_point(a * at[0] + b * at[1] + c * at[2], &starts))
        };
        let points = parallel::map(wedges.face_wedges.len(), 16, look_up);
        let area_normals: Vec<Vec3> = wedges.face_wedges.iter().map(|of| area_normal(corners(of))).collect();
        let areas = area_normals.iter().map(|normal| normal.length()).collect();
        Self { wedges, points, area_normals, areas, pins }
    }

    /// Fits a channel, starting from `nearest`, its values at closest points; returns `nearest` if a value is not
    /// finite.
    pub fn values(&self, nearest: Channel, original: &Channel, wedges: &[[u32; 3]]) -> Channel {
        let target = self.target_values(original, wedges);
        if nearest.values.iter().chain(&target).any(|x| !x.is_finite()) {
            return nearest;
        }
        let representative = self.shared_wedges(&nearest);
        let mut values = nearest.values.clone();
        let system = FitSystem { diagonal: self.diagonal(&representative), target, representative };
        for _ in 0..STEPS {
            self.step(&mut values, &nearest, &system);
        }
        clamp_to_range(&mut values, original);
        Channel { values, ..nearest }
    }

    /// Interpolates the original channel at the quadrature points; returns n_faces x 6 x width values.
    pub(super) fn target_values(&self, original: &Channel, wedges: &[[u32; 3]]) -> Vec<f32> {
        let mut target = vec![0.0; self.points.len() * QUADRATURE.len() * original.width];
        let surface_points = self.points.as_flattened();
        parallel::rows_mut(&mut target, original.width, 1024, |number, out| {
            let place = &surface_points[number];
            let corners = wedges[place.face as usize].map(|wedge| original.value(wedge));
            blend(original.role, corners, place.weights, out);
        });
        target
    }

    /// Maps each wedge to the first wedge of its vertex that has equal values.
    fn shared_wedges(&self, channel: &Channel) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.wedges.vertices.len() as u32).collect();
        // Wedges are grouped by vertex; in a group the first wedge of equal values represents them.
        order.sort_by_key(|&wedge| self.wedges.vertices[wedge as usize]);
        let mut representative = vec![0; order.len()];
        for around in order.chunk_by(|&w, &x| self.wedges.vertices[w as usize] == self.wedges.vertices[x as usize]) {
            for (n_before, &wedge) in around.iter().enumerate() {
                let is_same = |other: u32| same_values(channel.role, channel.value(wedge), channel.value(other));
                let mut before = around[..n_before].iter().copied();
                representative[wedge as usize] =
                    before.find(|&w| representative[w as usize] == w && is_same(w)).unwrap_or(wedge);
            }
        }
        representative
    }

    pub(super) fn diagonal(&self, representative: &[u32]) -> Vec<f32> {
        let mut diagonal = vec![0.0; representative.len()];
        for (wedges, area) in self.wedges.face_wedges.iter().zip(&self.areas) {
            for (at, weight) in QUADRATURE {
                (0..3).for_each(|k| {
                    diagonal[representative[wedges[k] as usize] as usize] += area * weight * at[k] * at[k]
                });
            }
        }
        diagonal
    }

    pub(super) fn step(
        &self,
        values: &mut [f32],
        nearest: &Channel,
        FitSystem { target, representative, diagonal }: &FitSystem,
    ) {
        let width = nearest.width;
        // The residual sums the pull to the values at closest points, and the deviation at every quadrature point.
        let mut residual: Vec<f32> = values.iter().zip(&nearest.values).map(|(now, before)| before - now).collect();
        residual
            .chunks_exact_mut(width)
            .zip(diagonal)
            .for_each(|(row, weight)| row.iter_mut().for_each(|x| *x *= NEAREST_WEIGHT * weight));
        let target = target.chunks_exact(QUADRATURE.len() * width);
        for ((wedges, area), target) in self.wedges.face_wedges.iter().zip(&self.areas).zip(target) {
            let rows = wedges.map(|wedge| representative[wedge as usize] as usize * width);
            for ((at, weight), target) in QUADRATURE.into_iter().zip(target.chunks_exact(width)) {
                for (i, target) in target.iter().enumerate() {
                    let now: f32 = (0..3).map(|k| at[k] * values[rows[k] + i]).sum();
                    let missing = area * weight * (target - now);
                    (0..3).for_each(|k| residual[rows[k] + i] += at[k] * missing);
                }
            }
        }
        // Shared values are updated at their first wedge and copied to the others.
        for wedge in 0..representative.len() {
            let first = representative[wedge] as usize;
            if !self.pins.is_locked(self.wedges.vertices[wedge]) && diagonal[first] > LEAST_WEIGHT && first == wedge {
                let length = DAMPING / (diagonal[first] * (1.0 + NEAREST_WEIGHT));
                (0..width).for_each(|i| values[wedge * width + i] += length * residual[wedge * width + i]);
            }
        }
        (0..representative.len()).filter(|&wedge| representative[wedge] as usize != wedge).for_each(|wedge| {
            let first = representative[wedge] as usize * width;
            values.copy_within(first..first + width, wedge * width);
        });
    }
}

pub(super) struct FitSystem {
    pub target: Vec<f32>,
    pub representative: Vec<u32>,
    pub diagonal: Vec<f32>,
}

fn clamp_to_range(values: &mut [f32], original: &Channel) {
    let width = original.width;
    for i in 0..width {
        // Least squares overshoots, and colours must stay in their range.
        let of_original = original.values.iter().skip(i).step_by(width).filter(|x| x.is_finite());
        let (low, high) =
            of_original.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
        values.iter_mut().skip(i).step_by(width).for_each(|x| *x = x.max(low).min(high));
    }
}
