//! Quadric of the planes around a node as a function of positions.

use glam::{DMat3, DVec3};

use super::algebra::{QuadraticForm, area_normal_backward, outer, stiffen, stiffen_backward, trace};
use super::plane_sums::{line, line_backward, plane, plane_backward};
use crate::geometry::triangle::area_normal_f64;
use crate::simplify::closed::collapse::{PULL, Renewal};
use crate::simplify::closed::prepare::surface::BOUNDARY_WEIGHT;
use neural_mesh_collapse::{LEAST_BENDING, StartRing};

pub(super) struct NodeStar {
    centre: usize,
    faces: Vec<[usize; 2]>,
    lines: Vec<usize>,
    weighing: Weighing,
}

/// Way from planes, lines and pull to a matrix.
enum Weighing {
    /// Planes and lines by a factor, then pulls by the trace of both.
    Given { importance: f64, growing_pull: f64 },
    /// All by how much the planes bend, the pull by the planes alone: the kernel's.
    Bending,
}

impl NodeStar {
    /// Builds the star of a vertex with a recomputed quadric; `node_of` maps vertices to tree nodes.
    pub fn new(Renewal { vertex, ring, folds, importance, growing_pull }: &Renewal, node_of: &[usize]) -> Self {
        let nodes: Vec<Option<usize>> = ring.iter().map(|&w| node_of.get(w as usize).copied()).collect();
        let mut lines: Vec<usize> = folds.iter().map(|&w| node_of[w as usize]).collect();
        let faces = split_ring(&nodes, &mut lines);
        let [importance, growing_pull] = [*importance, *growing_pull].map(f64::from);
        let weighing = Weighing::Given { importance, growing_pull };
        Self { centre: node_of[*vertex as usize], faces, lines, weighing }
    }

    /// Builds the star of a vertex at the beginning of a pass of the kernel.
    pub fn of_pass(vertex: u32, ring: &StartRing, node_of: &[usize]) -> Self {
        let mut nodes: Vec<Option<usize>> = ring.neighbors.iter().map(|&w| Some(node_of[w as usize])).collect();
        nodes.extend(ring.is_open.then_some(None));
        let mut lines: Vec<usize> = ring.folds.iter().map(|&w| node_of[w as usize]).collect();
        let faces = split_ring(&nodes, &mut lines);
        Self { centre: node_of[vertex as usize], faces, lines, weighing: Weighing::Bending }
    }

    fn planes(&self, places: &[DVec3]) -> DMat3 {
        let centre = places[self.centre];
        self.faces.iter().map(|&[p, q]| plane(area_normal_f64([centre, places[p], places[q]]))).sum()
    }

    fn lines(&self, places: &[DVec3]) -> DMat3 {
        let centre = places[self.centre];
        self.lines.iter().map(|&end| line(places[end] - centre)).sum::<DMat3>() * self.line_share()
    }

    /// Returns the weight of lines over that of the collapse of this assembly.
    fn line_share(&self) -> f64 {
        match self.weighing {
            Weighing::Given { .. } => 1.0,
            Weighing::Bending => f64::from(neural_mesh_collapse::BOUNDARY_WEIGHT) / f64::from(BOUNDARY_WEIGHT),
        }
    }

    fn matrix(&self, places: &[DVec3]) -> DMat3 {
        let (planes, lines) = (self.planes(places), self.lines(places));
        match self.weighing {
            Weighing::Given { importance, growing_pull } => {
                let sum = (planes + lines) * importance;
                stiffen(&sum, f64::from(PULL) + growing_pull * trace(&sum))
            }
            Weighing::Bending => {
                let pull = f64::from(neural_mesh_collapse::PULL);
                (stiffen(&planes, pull) + lines) * Bending::new(&planes).factor()
            }
        }
    }

    pub fn quadric(&self, places: &[DVec3]) -> QuadraticForm {
        let a = self.matrix(places);
        QuadraticForm { a, b: a * places[self.centre] }
    }

    pub fn backward(&self, places: &[DVec3], &QuadraticForm { a, b }: &QuadraticForm, to_places: &mut [DVec3]) {
        let centre = places[self.centre];
        to_places[self.centre] += self.matrix(places) * b;
        // `b = A c`; only the symmetric part of the matrix counts.
        let to_matrix = a + (outer(b, centre) + outer(centre, b)) * 0.5;
        let [to_planes, to_lines] = self.matrix_backward(places, &to_matrix);
        for &[p, q] in &self.faces {
            let corners = [centre, places[p], places[q]];
            let to_normal = plane_backward(area_normal_f64(corners), &to_planes);
            let to_corners = area_normal_backward(corners, to_normal);
            [self.centre, p, q].into_iter().zip(to_corners).for_each(|(node, to)| to_places[node] += to);
        }
        for &end in &self.lines {
            let to_edge = line_backward(places[end] - centre, &to_lines);
            to_places[end] += to_edge;
            to_places[self.centre] -= to_edge;
        }
    }

    /// Converts the gradient by the matrix to those by the sums of planes and of lines.
    fn matrix_backward(&self, places: &[DVec3], to_matrix: &DMat3) -> [DMat3; 2] {
        let (planes, lines) = (self.planes(places), self.lines(places));
        match self.weighing {
            Weighing::Given { importance, growing_pull } => {
                // The pull depends on the trace, once linearly and once squared.
                let slope = f64::from(PULL) + 2.0 * growing_pull * importance * trace(&(planes + lines));
                [stiffen_backward(to_matrix, slope) * importance; 2]
            }
            Weighing::Bending => {
                let (bending, pull) = (Bending::new(&planes), f64::from(neural_mesh_collapse::PULL));
                let to_factor = inner(to_matrix, &(stiffen(&planes, pull) + lines));
                let to_sum = *to_matrix * bending.factor();
                let to_planes = stiffen_backward(&to_sum, pull) + bending.backward(&planes) * to_factor;
                [to_planes, to_sum * self.line_share()]
            }
        }
    }
}

/// Returns the faces between neighbours in a row; the ends at a gap go to `lines`.
fn split_ring(nodes: &[Option<usize>], lines: &mut Vec<usize>) -> Vec<[usize; 2]> {
    let mut faces = Vec::with_capacity(nodes.len());
    for (before, here) in nodes.iter().cycle().skip(nodes.len().saturating_sub(1)).zip(nodes) {
        match (before, here) {
            (&Some(p), &Some(q)) => faces.push([p, q]),
            (&Some(end), None) | (None, &Some(end)) => lines.push(end),
            (None, None) => {}
        }
    }
    faces
}

/// Bending of planes: the mean squared sine between two normals, `1 - |A|^2 / tr(A)^2`.
struct Bending {
    trace: f64,
    squares: f64,
}

impl Bending {
    fn new(planes: &DMat3) -> Self {
        Self { trace: trace(planes), squares: inner(planes, planes) }
    }

    /// Returns the factor on the quadric.
    fn factor(&self) -> f64 {
        if self.trace > 0.0 { self.bound_bending().powf(0.25) } else { 1.0 }
    }

    fn bound_bending(&self) -> f64 {
        let bending = (1.0 - self.squares / (self.trace * self.trace)).max(0.0);
        (bending + f64::from(LEAST_BENDING)).min(1.0)
    }

    /// Returns the gradient of the factor by the planes.
    fn backward(&self, planes: &DMat3) -> DMat3 {
        let bounded = self.bound_bending();
        if self.trace <= 0.0 || bounded >= 1.0 {
            return DMat3::ZERO;
        }
        let by_bending = 0.25 * bounded.powf(-0.75);
        let (trace, squares) = (self.trace, self.squares);
        (*planes * (-1.0 / trace) + DMat3::IDENTITY * (squares / (trace * trace))) * (2.0 * by_bending / trace)
    }
}

/// Returns the sum of products of the entries.
fn inner(a: &DMat3, b: &DMat3) -> f64 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}
