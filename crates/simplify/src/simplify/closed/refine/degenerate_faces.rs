//! Repair of faces that lose their area to the rounding of the file.

use glam::{DVec3, Vec3};
use rustc_hash::FxHashSet;

use super::duplicate_positions::{VisibleSteps, grid_offset, written_key};
use crate::geometry::triangle::{self, area_normal, area_normal_f64};
use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::indices_where;
use crate::mesh::{Frame, has_area};
use crate::simplify::closed::diamond::{Diamond, diamonds};
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;

/// Largest sum of the four valences at a flip; half of it is a moved vertex's largest valence.
// Vertices of high valence would dominate the time.
const MOST_CORNERS: usize = 64;
const MOST_POSITIONS: u32 = 125;

struct WrittenFaces<'a> {
    positions: &'a [[f32; 3]],
    frame: &'a Frame,
}

impl WrittenFaces<'_> {
    fn corners(&self, face: [u32; 3]) -> [[f64; 3]; 3] {
        face.map(|v| self.frame.to_file(self.positions[v as usize]))
    }

    fn has_area(&self, face: [u32; 3]) -> bool {
        has_area(self.corners(face))
    }

    fn normal(&self, face: [u32; 3]) -> DVec3 {
        area_normal_f64(self.corners(face).map(DVec3::from))
    }

    fn find_degenerate(&self, pulse: Pulse, faces: &[[u32; 3]]) -> Vec<u32> {
        // If the file is as fine as single precision about the origin, local coordinates prove the area of most faces.
        let is_fine = self.frame.double || self.frame.origin == [0.0; 3];
        let is_wide = |face: &[u32; 3]| {
            let corners = face.map(|v| Vec3::from(self.positions[v as usize]));
            is_fine && triangle::has_area(area_normal(corners), corners)
        };
        indices_where(pulse, faces, |_, face| !is_wide(face) && !self.has_area(*face))
    }
}

/// Flips edges of degenerate faces; returns the number of flips, and whether no degenerate face remains.
pub fn flip(pulse: Pulse, output: &mut Output, positions: &[[f32; 3]], frame: &Frame) -> (usize, bool) {
    let written = WrittenFaces { positions, frame };
    let degenerate = written.find_degenerate(pulse, output.faces());
    let mut n_flipped = 0;
    for &f in &degenerate {
        if let Some(diamond) = (!written.has_area(output.face(f))).then(|| find_flip(&written, output, f)).flatten() {
            output.flip(&diamond);
            n_flipped += 1;
        }
    }
    (n_flipped, degenerate.into_iter().all(|f| written.has_area(output.face(f))))
}

fn find_flip(written: &WrittenFaces, output: &Output, f: u32) -> Option<Diamond> {
    let around = output.faces_around();
    let length = |diamond: &Diamond| {
        let [a, b, _] = written.corners([diamond.corners[0], diamond.corners[1], diamond.corners[2]]);
        DVec3::from(a).distance_squared(DVec3::from(b))
    };
    let is_helpful = |diamond: &Diamond| {
        let [_, _, c, d] = diamond.corners;
        let n_corners: usize = diamond.corners.iter().map(|&v| around.corners(v).len()).sum();
        let across = written.normal(diamond.present_faces()[1]);
        let is_fine = |face: &[u32; 3]| written.has_area(*face) && written.normal(*face).dot(across) > 0.0;
        n_corners <= MOST_CORNERS
            && !around.has_edge(c, d)
            && !output.is_flip_forbidden(diamond)
            && diamond.flipped_faces().iter().all(is_fine)
    };
    let mut edges: Vec<Diamond> = diamonds(output.faces(), around, f).filter(is_helpful).collect();
    edges.sort_by(|x, y| length(y).total_cmp(&length(x)));
    edges.first().copied()
}

/// Moves corners of degenerate faces to the nearest free position that helps; returns the number of moves.
pub fn widen(original: &Original, output: &mut Output, positions: &mut [[f32; 3]], frame: &Frame) -> usize {
    let degenerate = WrittenFaces { positions, frame }.find_degenerate(original.surface.pulse, output.faces());
    if degenerate.is_empty() {
        return 0;
    }
    // A vertex must not move onto another one.
    let mut taken: FxHashSet<[u64; 3]> = positions.iter().map(|p| written_key(frame, *p)).collect();
    let (steps, mut n_moved) = (VisibleSteps::new(positions, frame), 0);
    for f in degenerate {
        let face = output.face(f);
        // An earlier move may have repaired this face.
        if (WrittenFaces { positions, frame }).has_area(face) {
            continue;
        }
        let is_free =
            |v: &u32| !output.pins.is_locked(*v) && output.faces_around().corners(*v).len() <= MOST_CORNERS / 2;
        let better = |v: u32| {
            let is_fine = |place: &FreePosition| {
                !taken.contains(&written_key(frame, place.0)) && keeps_directions(output, positions, frame, v, place.0)
            };
            // In a subset a vertex must move to another vertex of the mesh.
            let place = match output.pins.is_subset() {
                true => subset_positions(original, output.pins.origins()[v as usize]).find(is_fine),
                false => nearby_positions(positions[v as usize], steps.steps_at(positions[v as usize])).find(is_fine),
            };
            Some((v, place?))
        };
        if let Some((v, (place, origin))) = face.into_iter().filter(is_free).find_map(better) {
            taken.insert(written_key(frame, place));
            positions[v as usize] = place;
            origin.into_iter().for_each(|origin| output.move_to_surface_vertex(v, origin, &original.surface));
            n_moved += 1;
        }
    }
    n_moved
}

/// Local position; with the option `subset`, also the surface vertex there.
type FreePosition = ([f32; 3], Option<u32>);

fn nearby_positions(here: [f32; 3], steps: [f32; 3]) -> impl Iterator<Item = FreePosition> {
    let place = move |number: u32| {
        let offset = grid_offset(number, steps);
        (std::array::from_fn(|axis| here[axis] + offset[axis]), None)
    };
    (1..MOST_POSITIONS).map(place).filter(|(place, _): &FreePosition| place.iter().all(|x| x.is_finite()))
}

fn subset_positions(original: &Original, origin: u32) -> impl Iterator<Item = FreePosition> {
    let Original { mesh, surface, .. } = original;
    let neighbours = surface.neighbors(origin).iter();
    let all = neighbours.clone().chain(neighbours.flat_map(|&v| surface.neighbors(v))).take(MOST_POSITIONS as usize);
    all.map(|&v| (mesh.positions()[surface.source(v) as usize], Some(v)))
}

fn keeps_directions(output: &Output, positions: &[[f32; 3]], frame: &Frame, v: u32, place: [f32; 3]) -> bool {
    let normal = |corners: [[f64; 3]; 3]| area_normal_f64(corners.map(DVec3::from));
    let corners = |f: u32, place: [f32; 3]| {
        output.face(f).map(|w| frame.to_file(if w == v { place } else { positions[w as usize] }))
    };
    output.faces_around().faces(v).all(|f| {
        // Degenerate faces have no direction to keep.
        let (before, now) = (corners(f, positions[v as usize]), corners(f, place));
        has_area(now) && (!has_area(before) || normal(now).dot(normal(before)) > 0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::pins::Pins;

    fn with_a_thin_face() -> (Output, Vec<[f32; 3]>) {
        let positions = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.5, -1.0]];
        // 0 2 1 has no area.
        let faces = vec![[0, 2, 1], [0, 3, 2], [2, 3, 1], [0, 1, 4], [1, 3, 4], [3, 0, 4]];
        let places: Vec<Vec3> = positions.iter().map(|p| Vec3::from(*p)).collect();
        (Output::from_original(&places, places.clone(), faces), positions.to_vec())
    }

    #[test]
    fn a_face_on_a_line_gives_its_longest_edge() {
        let (mut output, positions) = with_a_thin_face();
        let (frame, pulse) = (Frame::default(), Pulse::NONE);
        assert_eq!(flip(pulse, &mut output, &positions, &frame), (1, true));
        assert!(
            WrittenFaces { positions: &positions, frame: &frame }.find_degenerate(pulse, output.faces()).is_empty()
        );
        assert!(output.faces_around().has_edge(2, 4) && !output.faces_around().has_edge(0, 1));
        assert_eq!(flip(pulse, &mut output, &positions, &frame), (0, true));
    }

    #[test]
    fn a_corner_moves_by_the_least_that_helps() {
        let (mut output, mut positions) = with_a_thin_face();
        let (frame, before) = (Frame::default(), positions.clone());
        let mesh = TriMesh::new(before.clone(), output.faces().to_vec()).unwrap();
        let original = Original::bare(&mesh);
        assert_eq!(widen(&original, &mut output, &mut positions, &frame), 1);
        assert!(
            WrittenFaces { positions: &positions, frame: &frame }
                .find_degenerate(Pulse::NONE, output.faces())
                .is_empty()
        );
        let moved = before.iter().zip(&positions).map(|(p, q)| Vec3::from(*p).distance(Vec3::from(*q)));
        assert!(moved.fold(0.0, f32::max) < 1e-6);
        assert_eq!(widen(&original, &mut output, &mut positions, &frame), 0);
    }

    #[test]
    fn a_corner_of_a_subset_moves_to_another_vertex() {
        let mesh = shapes::grid(4, 4);
        let original = Original { pins: Pins::new_subset(), ..Original::bare(&mesh) };
        // Three vertices of the mesh on a line, and one off it.
        let origins = vec![0, 1, 2, 6];
        let places = || origins.iter().map(|&v| original.surface.positions[v as usize]).collect::<Vec<_>>();
        let pins = original.pins.with_surface_origins(original.surface.n_vertices()).select(&origins);
        let mut output = Output::new(Pulse::NONE, places(), vec![[0, 1, 2], [0, 2, 3]], pins, Vec::new());
        let mut positions: Vec<[f32; 3]> = origins.iter().map(|&v| mesh.positions()[v as usize]).collect();
        assert_eq!(widen(&original, &mut output, &mut positions, &Frame::default()), 1);
        let written = WrittenFaces { positions: &positions, frame: &Frame::default() };
        assert!(written.find_degenerate(Pulse::NONE, output.faces()).is_empty());
        for (place, &origin) in positions.iter().zip(output.pins.origins()) {
            assert_eq!(*place, mesh.positions()[origin as usize]);
        }
    }
}
