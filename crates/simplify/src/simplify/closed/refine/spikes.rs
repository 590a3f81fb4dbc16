//! Spikes: vertices much farther from the original than their neighbours are moved back toward it.

use glam::Vec3;

use crate::geometry::triangle::unit_normal;
use crate::simplify::closed::original::{ClosestPoint, Original};
use crate::simplify::closed::output::Output;

/// Distance of a vertex from the original, over the mean distance of its neighbours, from which it is a spike.
const SPIKE: f32 = 5.0;
/// Distance that remains, over that from which the vertex is a spike.
const REMAINING: f32 = 0.9;
/// Distance of a vertex, over that from which it is a spike, from which distances around it are searched for more.
const SUSPECT: f32 = 0.7;
/// Distance by the collapse, over the least of a spike, up to which a vertex is none.
// Twenty-four meshes, ratios 0.05 to 0.5: the same spikes as without it.
const SURE: f32 = 0.5;
// A vertex that moves back can make spikes of its neighbours.
const ROUNDS: usize = 4;

/// Moves spikes of at least the distance `least` back until they are none; returns the number of vertices moved.
pub fn shorten(original: &Original, output: &mut Output, least: f32) -> usize {
    let mut spikes = Spikes::new(original, output, least);
    let n = spikes.distances.len();
    let mut is_moved = vec![false; n];
    for _ in 0..ROUNDS {
        let moved: Vec<u32> = (0..n as u32).filter(|&v| spikes.shorten(v)).collect();
        if moved.is_empty() {
            break;
        }
        moved.into_iter().for_each(|v| is_moved[v as usize] = true);
    }
    is_moved.into_iter().filter(|moved| *moved).count()
}

/// Marks the vertices that may be spikes, and those within two edges, whose distances and starts these are judged by.
fn find_wanted(output: &Output, least: f32) -> Vec<bool> {
    let mut is_wanted: Vec<bool> =
        (0..output.positions.len() as u32).map(|v| output.may_be_beyond(v, SURE * least)).collect();
    if is_wanted.contains(&false) && is_wanted.contains(&true) {
        for _ in 0..2 {
            let inner = is_wanted.clone();
            for face in output.faces().iter().filter(|face| face.iter().any(|&v| inner[v as usize])) {
                face.iter().for_each(|&v| is_wanted[v as usize] = true);
            }
        }
    }
    is_wanted
}

struct Spikes<'a> {
    original: &'a Original<'a>,
    output: &'a mut Output,
    /// Original vertex near each vertex, from which walks to its closest point start.
    starts: Vec<u32>,
    /// Distance of each vertex from the original.
    distances: Vec<f32>,
    is_searched: Vec<bool>,
    least: f32,
}

impl<'a> Spikes<'a> {
    fn new(original: &'a Original, output: &'a mut Output, least: f32) -> Self {
        let n = output.positions.len();
        let is_wanted = find_wanted(output, least);
        // Without suspects nothing is searched.
        let starts = if is_wanted.contains(&true) {
            original.nearest_in_regions(&output.positions, &output.vertex_of, &is_wanted)
        } else {
            vec![0; n]
        };
        let mut spikes = Self { original, output, starts, distances: Vec::new(), is_searched: vec![false; n], least };
        let distance = |v: usize| if is_wanted[v] { spikes.distance(v as u32) } else { 0.0 };
        spikes.distances = original.surface.pulse.counting_if(false).map_numbers(n, distance);
        spikes
    }

    /// Returns the distance of a vertex from the original.
    fn distance(&self, v: u32) -> f32 {
        let (point, start) = (self.output.positions[v as usize], self.starts[v as usize]);
        // Smaller distances make no spike, neither of the vertex nor of its neighbours.
        let distance = self.original.closest_point_over_faces(point, start, self.least / SPIKE).distance;
        if distance.is_finite() { distance } else { 0.0 }
    }

    fn closest_point(&self, v: u32) -> Option<ClosestPoint> {
        // A walk may end too early, so walks from the neighbours' starts are made as well.
        let starts = std::iter::once(v).chain(self.next_corners(v)).map(|w| self.starts[w as usize]);
        let point = self.output.positions[v as usize];
        let found = starts.map(|start| self.original.closest_point_over_faces(point, start, 0.0));
        found.filter(|at| at.distance.is_finite()).min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Corrects the distance of a vertex, once, by walks from the starts of its neighbours as well.
    fn search_more(&mut self, v: u32) {
        let is_new = !std::mem::replace(&mut self.is_searched[v as usize], true);
        if is_new
            && self.distances[v as usize] > self.least / SPIKE
            && let Some(at) = self.closest_point(v)
        {
            self.distances[v as usize] = at.distance;
        }
    }

    fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> {
        self.output.faces_around().faces(v).flat_map(|f| self.output.face(f)).filter(move |w| *w != v)
    }

    /// Returns the next corner of each face around a vertex: all neighbours, except one at a boundary.
    fn next_corners(&self, v: u32) -> impl Iterator<Item = u32> {
        let next = move |face: [u32; 3]| face.iter().position(|w| *w == v).map(|k| face[(k + 1) % 3]);
        self.output.faces_around().faces(v).filter_map(move |f| next(self.output.face(f)))
    }

    /// Returns the distance from which a vertex is a spike.
    fn most_distance(&self, v: u32) -> f32 {
        let (mut sum, mut n) = (0.0, 0);
        for w in self.neighbours(v) {
            (sum, n) = (sum + self.distances[w as usize], n + 1);
        }
        (SPIKE * sum / n.max(1) as f32).max(self.least)
    }

    /// Moves a vertex back if it is a spike; returns whether it moved.
    fn shorten(&mut self, v: u32) -> bool {
        let at = v as usize;
        let is_suspect = self.distances[at] > self.least && self.distances[at] > SUSPECT * self.most_distance(v);
        if !is_suspect || self.output.pins.is_locked(v) {
            return false;
        }
        let around: Vec<u32> = std::iter::once(v).chain(self.neighbours(v)).collect();
        around.into_iter().for_each(|w| self.search_more(w));
        let most = self.most_distance(v);
        if self.distances[at] <= most {
            return false;
        }
        let Some(foot) = self.closest_point(v) else { return false };
        let step = (foot.point - self.output.positions[at]) * (1.0 - REMAINING * most / foot.distance);
        let is_moved = self.try_move(v, step);
        self.distances[at] = if is_moved { REMAINING * most } else { foot.distance };
        is_moved
    }

    /// Moves a vertex unless this turns a face over.
    fn try_move(&mut self, v: u32, step: Vec3) -> bool {
        let (before, place) = (self.normals(v), self.output.positions[v as usize]);
        self.output.positions[v as usize] = place + step;
        let is_moved = before.iter().zip(self.normals(v)).all(|(before, now)| before.dot(now) > 0.0);
        if !is_moved {
            self.output.positions[v as usize] = place;
        }
        is_moved
    }

    fn normals(&self, v: u32) -> Vec<Vec3> {
        self.output.faces_around().faces(v).map(|f| unit_normal(self.output.triangle(f))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    const LEAST: f32 = 1e-3;

    #[test]
    fn spikes_move_back_until_they_are_none() {
        let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(2));
        let original = Original::bare(&fine);
        // Subdivision appends vertices, so a finer sphere begins with those of the coarser one.
        let start = original.surface.positions[..coarse.positions().len()].to_vec();
        let mut places = start.clone();
        places.iter_mut().for_each(|p| *p *= 1.001);
        places[7] = start[7] * 1.3;
        let mut output = Output::from_original(&original.surface.positions, places.clone(), coarse.faces().to_vec());
        assert_eq!(shorten(&original, &mut output, LEAST), 1);
        let height = |v: usize| output.positions[v].distance(start[v]) / start[v].length();
        assert!((0.0005..0.0055).contains(&height(7)), "{}", height(7));
        let others = || (0..places.len()).filter(|v| *v != 7);
        assert!(others().all(|v| output.positions[v] == places[v]));
        assert_eq!(shorten(&original, &mut output, LEAST), 0);
    }

    #[test]
    fn vertices_alike_and_invisible_spikes_stay() {
        let fine = shapes::icosphere(3);
        let original = Original::bare(&fine);
        let mut places: Vec<Vec3> = original.surface.positions.iter().map(|p| *p * 1.1).collect();
        let faces = fine.faces().to_vec();
        let mut output = Output::from_original(&original.surface.positions, places.clone(), faces.clone());
        assert_eq!(shorten(&original, &mut output, LEAST), 0);
        places.clone_from(&original.surface.positions);
        places[3] *= 1.0 + 0.5 * LEAST;
        let mut output = Output::from_original(&original.surface.positions, places, faces);
        assert_eq!(shorten(&original, &mut output, LEAST), 0);
    }
}
