//! One fit step as a function of input positions and output vertices, with derivative.
//!
//! Each point's face and barycentric weights, the weights of faces and the set of moved vertices are constant.

use glam::{DMat3, DVec3};

use super::algebra::{
    QuadraticForm, area_normal_backward, outer, solve, solve_backward, stiffen, stiffen_backward, unit_backward,
};
use crate::geometry::triangle::area_normal_f64;
use crate::simplify::closed::refine::sample_points::Match;
use crate::simplify::closed::trace::TracedStep;

pub(super) struct FitStep<'a> {
    pub step: &'a TracedStep,
    pub input_faces: &'a [[u32; 3]],
    pub output_faces: &'a [[u32; 3]],
    pub input: &'a [DVec3],
    pub output: &'a [DVec3],
}

struct MatchRow {
    corners: [(usize, f64); 3],
    area: f64,
    gap: DVec3,
    normal: DVec3,
    height: f64,
}

struct SolvedStep {
    systems: Vec<QuadraticForm>,
    directions: Vec<DVec3>,
    /// Sum of `area * height * rise` over all sample points; `curvature` is that of `area * rise^2`.
    slope: f64,
    curvature: f64,
    stay: f64,
}

impl SolvedStep {
    fn length(&self) -> f64 {
        self.slope / self.curvature.max(f64::MIN_POSITIVE)
    }
}

impl FitStep<'_> {
    pub fn forward(&self) -> Vec<DVec3> {
        let solved = self.solve(&self.normals());
        let length = solved.length();
        let moves = self.output.iter().zip(&solved.directions).zip(&self.step.moved);
        moves.map(|((&x, &d), &moved)| if moved { x + d * length } else { x }).collect()
    }

    /// Converts the gradient by vertices after the step to that by vertices before it; adds the input's share to
    /// `to_input`.
    pub fn backward(&self, gradient: &[DVec3], to_input: &mut [DVec3]) -> Vec<DVec3> {
        let normals = self.normals();
        let solved = self.solve(&normals);
        let length = solved.length();
        let moving = |v: usize| if self.step.moved[v] { gradient[v] } else { DVec3::ZERO };
        // In the reverse order of `forward`: step length, directions, systems, rows, positions.
        let to_length: f64 = (0..gradient.len()).map(|v| moving(v).dot(solved.directions[v])).sum();
        let curvature = solved.curvature.max(f64::MIN_POSITIVE);
        let to_slope = to_length / curvature;
        let to_curvature = -to_length * length / curvature;
        let mut to_directions: Vec<DVec3> = (0..gradient.len()).map(|v| moving(v) * length).collect();
        let rows: Vec<MatchRow> = self.step.matches.iter().map(|m| self.row(m, &normals)).collect();
        let mut to_rows: Vec<RowGradient> =
            rows.iter().map(|row| row.length_backward(&solved, [to_slope, to_curvature], &mut to_directions)).collect();
        let to_systems: Vec<QuadraticForm> =
            (0..gradient.len()).map(|v| solved.system_backward(v, to_directions[v])).collect();
        rows.iter().zip(&mut to_rows).for_each(|(row, to)| row.systems_backward(&to_systems, to));
        let mut to_output = gradient.to_vec();
        self.rows_backward(&rows, &to_rows, to_input, &mut to_output);
        to_output
    }

    fn normals(&self) -> Vec<DVec3> {
        let corners = |face: &[u32; 3]| face.map(|v| self.output[v as usize]);
        self.output_faces.iter().map(|face| area_normal_f64(corners(face))).collect()
    }

    fn share(&self, m: &Match) -> f64 {
        0.5 * f64::from(self.step.face_weights[m.projection.face as usize]) / f64::from(self.step.density.per_face())
    }

    fn row(&self, m: &Match, normals: &[DVec3]) -> MatchRow {
        let density = self.step.density;
        let corners_of_point = self.input_faces[density.face(m.point)].map(|v| self.input[v as usize]);
        let point: DVec3 = corners_of_point.iter().zip(density.weights(m.point)).map(|(p, weight)| *p * weight).sum();
        let face = self.output_faces[m.projection.face as usize];
        let corners = [0, 1, 2].map(|i| (face[i] as usize, f64::from(m.projection.weights[i])));
        let foot: DVec3 = corners.iter().map(|&(v, share)| self.output[v] * share).sum();
        let gap = point - foot;
        let normal = normals[m.projection.face as usize].normalize_or_zero();
        let area = self.share(m) * area_normal_f64(corners_of_point).length();
        MatchRow { corners, area, gap, normal, height: normal.dot(gap) }
    }

    fn solve(&self, normals: &[DVec3]) -> SolvedStep {
        let rows = || self.step.matches.iter().map(|m| self.row(m, normals));
        let mut systems = vec![QuadraticForm::ZERO; self.output.len()];
        for row in rows() {
            let whole = QuadraticForm { a: outer(row.normal, row.normal), b: row.normal * row.height };
            for (v, share) in row.corners {
                let weight = row.area * share;
                systems[v] += QuadraticForm { a: whole.a * weight, b: whole.b * weight };
            }
        }
        let stay = f64::from(self.step.stay);
        let direction = |system: &QuadraticForm| solve(&stiffen(&system.a, stay), system.b);
        let directions: Vec<DVec3> = systems.iter().map(direction).collect();
        let (mut slope, mut curvature) = (0.0, 0.0);
        for row in rows() {
            let rise = row.rise(&directions);
            slope += row.area * row.height * rise;
            curvature += row.area * rise * rise;
        }
        SolvedStep { systems, directions, slope, curvature, stay }
    }

    fn rows_backward(
        &self,
        rows: &[MatchRow],
        to_rows: &[RowGradient],
        to_input: &mut [DVec3],
        to_output: &mut [DVec3],
    ) {
        let mut to_units = vec![DVec3::ZERO; self.output_faces.len()];
        for ((m, row), to) in self.step.matches.iter().zip(rows).zip(to_rows) {
            // Heights depend on normals and gaps, areas on the input face.
            to_units[m.projection.face as usize] += to.normal + row.gap * to.height;
            let to_gap = row.normal * to.height;
            row.corners.iter().for_each(|&(v, share)| to_output[v] -= to_gap * share);
            let face = self.input_faces[self.step.density.face(m.point)];
            let corners = face.map(|v| self.input[v as usize]);
            let to_normal = area_normal_f64(corners).normalize_or_zero() * (self.share(m) * to.area);
            let to_corners = area_normal_backward(corners, to_normal);
            let weights = self.step.density.weights(m.point);
            for ((&v, to), weight) in face.iter().zip(to_corners).zip(weights) {
                to_input[v as usize] += to + to_gap * weight;
            }
        }
        for (face, to_unit) in self.output_faces.iter().zip(to_units) {
            let corners = face.map(|v| self.output[v as usize]);
            let to_corners = area_normal_backward(corners, unit_backward(area_normal_f64(corners), to_unit));
            face.iter().zip(to_corners).for_each(|(&v, to)| to_output[v as usize] += to);
        }
    }
}

/// Gradient by the area, height and normal of a row.
#[derive(Default)]
struct RowGradient {
    area: f64,
    height: f64,
    normal: DVec3,
}

impl MatchRow {
    fn rise(&self, directions: &[DVec3]) -> f64 {
        self.normal.dot(self.interpolate(directions))
    }

    fn interpolate(&self, directions: &[DVec3]) -> DVec3 {
        self.corners.iter().map(|&(v, share)| directions[v] * share).sum()
    }

    fn length_backward(
        &self,
        solved: &SolvedStep,
        [to_slope, to_curvature]: [f64; 2],
        to_directions: &mut [DVec3],
    ) -> RowGradient {
        let carried = self.interpolate(&solved.directions);
        let rise = self.normal.dot(carried);
        // Chain rule through slope and curvature, both sums over the rows.
        let to_rise = self.area * (to_slope * self.height + 2.0 * to_curvature * rise);
        self.corners.iter().for_each(|&(v, share)| to_directions[v] += self.normal * (to_rise * share));
        RowGradient {
            area: to_slope * self.height * rise + to_curvature * rise * rise,
            height: to_slope * self.area * rise,
            normal: carried * to_rise,
        }
    }

    fn systems_backward(&self, to_systems: &[QuadraticForm], to: &mut RowGradient) {
        let whole = self.corners.iter().fold(QuadraticForm::ZERO, |sum, &(v, share)| {
            sum + QuadraticForm { a: to_systems[v].a * share, b: to_systems[v].b * share }
        });
        let along = whole.a * self.normal;
        to.area += self.normal.dot(along) + self.height * whole.b.dot(self.normal);
        to.height += self.area * whole.b.dot(self.normal);
        to.normal += (along * 2.0 + whole.b * self.height) * self.area;
    }
}

impl SolvedStep {
    fn system_backward(&self, v: usize, gradient: DVec3) -> QuadraticForm {
        let matrix: DMat3 = stiffen(&self.systems[v].a, self.stay);
        let QuadraticForm { a, b } = solve_backward(&matrix, self.directions[v], gradient);
        QuadraticForm { a: stiffen_backward(&a, self.stay), b }
    }
}
