//! Quadric of the planes around a node as a function of positions.

use glam::{DMat3, DVec3};

use super::algebra::{QuadraticForm, area_normal_backward, outer, stiffen, stiffen_backward, trace};
use super::plane_sums::{line, line_backward, plane, plane_backward};
use crate::geometry::triangle::area_normal_f64;
use crate::simplify::closed::collapse::{PULL, Renewal};

pub(super) struct NodeStar {
    centre: usize,
    faces: Vec<[usize; 2]>,
    lines: Vec<usize>,
    importance: f64,
    growing_pull: f64,
}

impl NodeStar {
    /// Builds the star of a vertex with a recomputed quadric; `node_of` maps vertices to tree nodes.
    pub fn new(Renewal { vertex, ring, folds, importance, growing_pull }: &Renewal, node_of: &[usize]) -> Self {
        let nodes: Vec<Option<usize>> = ring.iter().map(|&w| node_of.get(w as usize).copied()).collect();
        let mut faces = Vec::with_capacity(nodes.len());
        let mut lines: Vec<usize> = folds.iter().map(|&w| node_of[w as usize]).collect();
        for (before, here) in nodes.iter().cycle().skip(nodes.len().saturating_sub(1)).zip(&nodes) {
            match (before, here) {
                (&Some(p), &Some(q)) => faces.push([p, q]),
                (&Some(end), None) | (None, &Some(end)) => lines.push(end),
                (None, None) => {}
            }
        }
        let [importance, growing_pull] = [*importance, *growing_pull].map(f64::from);
        Self { centre: node_of[*vertex as usize], faces, lines, importance, growing_pull }
    }

    fn planes(&self, places: &[DVec3]) -> DMat3 {
        let centre = places[self.centre];
        let of_face = |&[p, q]: &[usize; 2]| plane(area_normal_f64([centre, places[p], places[q]]));
        let of_edge = |&end: &usize| line(places[end] - centre);
        self.faces.iter().map(of_face).chain(self.lines.iter().map(of_edge)).sum::<DMat3>() * self.importance
    }

    fn matrix(&self, places: &[DVec3]) -> DMat3 {
        let planes = self.planes(places);
        stiffen(&planes, f64::from(PULL) + self.growing_pull * trace(&planes))
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
        // The pull depends on the trace, once linearly and once squared.
        let slope = f64::from(PULL) + 2.0 * self.growing_pull * trace(&self.planes(places));
        let to_matrix = stiffen_backward(&to_matrix, slope) * self.importance;
        for &[p, q] in &self.faces {
            let corners = [centre, places[p], places[q]];
            let to_normal = plane_backward(area_normal_f64(corners), &to_matrix);
            let to_corners = area_normal_backward(corners, to_normal);
            [self.centre, p, q].into_iter().zip(to_corners).for_each(|(node, to)| to_places[node] += to);
        }
        for &end in &self.lines {
            let to_edge = line_backward(places[end] - centre, &to_matrix);
            to_places[end] += to_edge;
            to_places[self.centre] -= to_edge;
        }
    }
}
