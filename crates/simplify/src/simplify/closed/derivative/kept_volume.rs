//! The way of a merged vertex from the least error toward the plane that keeps the volume of its star.

use glam::{DMat3, DVec3};
use neural_mesh_collapse::VOLUME_SHARE;

use super::algebra::{outer, solve};

/// The star of a merge inside the surface: its border of tree nodes in cyclic order.
pub(super) struct KeptVolume {
    border: Vec<usize>,
    n_of_kept: usize,
}

/// A place on the way: `least + length * direction`, all seen from the kept end.
struct PlacedVertex {
    normal: DVec3,
    direction: DVec3,
    /// `normal · direction`
    rise: f64,
    length: f64,
}

impl KeptVolume {
    pub fn new(border: &[u32], n_of_kept: usize, node_of: &[usize]) -> Self {
        Self { border: border.iter().map(|&v| node_of[v as usize]).collect(), n_of_kept }
    }

    /// Returns the edges of the border as ends, seen from the kept end, and whether they are of faces of the removed end.
    fn edges<'a>(
        &'a self,
        places: &'a [DVec3],
        kept: DVec3,
    ) -> impl Iterator<Item = ([usize; 2], [DVec3; 2], bool)> + 'a {
        let next = self.border.iter().cycle().skip(1);
        self.border
            .iter()
            .zip(next)
            .enumerate()
            .map(move |(i, (&a, &b))| ([a, b], [a, b].map(|node| places[node] - kept), i + 1 >= self.n_of_kept))
    }

    fn place(&self, places: &[DVec3], [kept, removed]: [DVec3; 2], a: &DMat3, least: DVec3) -> PlacedVertex {
        let (mut normal, mut offset) = (DVec3::ZERO, 0.0);
        for (_, [p, q], is_of_removed) in self.edges(places, kept) {
            let area = p.cross(q);
            normal += area;
            offset += if is_of_removed { area.dot(removed - kept) } else { 0.0 };
        }
        let direction = solve(a, normal);
        let rise = normal.dot(direction);
        let length = if rise > 0.0 { VOLUME_SHARE * (offset - normal.dot(least - kept)) / rise } else { 0.0 };
        PlacedVertex { normal, direction, rise, length }
    }

    /// Returns the place for the matrix `a` of the summed quadrics and their minimum.
    pub fn forward(&self, places: &[DVec3], ends: [DVec3; 2], a: &DMat3, least: DVec3) -> DVec3 {
        let placed = self.place(places, ends, a, least);
        least + placed.direction * placed.length
    }

    /// Converts the gradient by the place to those by the matrix and the minimum; adds those by the places of
    /// the nodes to `to_places`.
    pub fn backward(
        &self,
        places: &[DVec3],
        [kept, removed]: [usize; 2],
        a: &DMat3,
        least: DVec3,
        gradient: DVec3,
        to_places: &mut [DVec3],
    ) -> (DMat3, DVec3) {
        let ends = [kept, removed].map(|node| places[node]);
        let placed = self.place(places, ends, a, least);
        if placed.rise <= 0.0 {
            return (DMat3::ZERO, gradient);
        }
        let seen = least - ends[0];
        let to_length = gradient.dot(placed.direction);
        let share = to_length * VOLUME_SHARE / placed.rise;
        let to_rise = -to_length * placed.length / placed.rise;
        let to_direction = gradient * placed.length + placed.normal * to_rise;
        let through_solution = solve(a, to_direction);
        let to_normal = placed.direction * to_rise - seen * share + through_solution;
        let to_matrix = (outer(through_solution, placed.direction) + outer(placed.direction, through_solution)) * -0.5;
        let to_seen = placed.normal * -share;
        let (mut to_kept, d) = (-to_seen, ends[1] - ends[0]);
        for ([at_p, at_q], [p, q], is_of_removed) in self.edges(places, ends[0]) {
            let mut to_area = to_normal;
            if is_of_removed {
                to_area += d * share;
                let to_d = p.cross(q) * share;
                to_places[removed] += to_d;
                to_kept -= to_d;
            }
            let [to_p, to_q] = [q.cross(to_area), to_area.cross(p)];
            to_places[at_p] += to_p;
            to_places[at_q] += to_q;
            to_kept -= to_p + to_q;
        }
        to_places[kept] += to_kept;
        (to_matrix, gradient + to_seen)
    }
}
