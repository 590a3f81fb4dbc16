//! Fins: sheets attached to a surface that end in a boundary.
//!
//! Edges with more than two faces divide a surface into patches. A fin is a patch at such an edge with less than half
//! of its component's area. The fin's open boundary meets such an edge, or a disc over the boundary would have more
//! than half of the fin's area.

use std::f64::consts::PI;

use rustc_hash::FxHashMap;

use crate::mesh::half_edges::for_each_edge;

use super::components::{components, components_over_edges};
use super::faces::RepairFaces;

const MOST_ROUNDS: usize = 64;

/// Drops all fins, the smallest first; returns the number of dropped faces.
pub(super) fn drop_fins(faces: &mut RepairFaces) -> usize {
    let n_before = faces.len();
    for _ in 0..MOST_ROUNDS {
        let (patch, fins) = fins(faces);
        if fins.is_empty() {
            break;
        }
        let mut is_fin = vec![false; patch.len()];
        fins.into_iter().for_each(|fin| is_fin[fin as usize] = true);
        faces.retain(|face| !is_fin[patch[face as usize] as usize]);
    }
    n_before - faces.len()
}

struct SheetPatches {
    of_face: Vec<u32>,
    areas: Vec<f64>,
    open: Vec<f64>,
    is_mixed: Vec<bool>,
    beside: FxHashMap<u32, Vec<u32>>,
}

impl SheetPatches {
    fn new(faces: &RepairFaces) -> Self {
        let (of_face, n) = components_over_edges(faces, |n_faces| n_faces == 2);
        let mut patches = Self {
            areas: vec![0.0; n],
            open: vec![0.0; n],
            is_mixed: vec![false; n],
            beside: FxHashMap::default(),
            of_face,
        };
        faces.numbers().for_each(|face| patches.areas[patches.of_face[face as usize] as usize] += faces.area(face));
        let (mut in_open, mut at_edges) = (Vec::new(), Vec::new());
        for_each_edge(faces.positions.len(), &faces.corners, |ends, around| {
            let here: Vec<u32> = around.iter().map(|half| patches.of_face[half.face() as usize]).collect();
            match here[..] {
                [one] => {
                    patches.open[one as usize] += faces.position(ends[0]).distance(faces.position(ends[1]));
                    in_open.extend(ends.map(|end| (end, one)));
                }
                [_, _] => {}
                _ => {
                    at_edges.extend(here.iter().flat_map(|&one| ends.map(|end| (end, one))));
                    here.iter().for_each(|&one| patches.beside.entry(one).or_default().extend(&here));
                }
            }
        });
        at_edges.sort_unstable();
        // Keeps vertices at which an open boundary meets an edge with more than two faces.
        in_open.retain(|place| at_edges.binary_search(place).is_ok());
        in_open.iter().for_each(|&(_, one)| patches.is_mixed[one as usize] = true);
        patches.beside.values_mut().for_each(|beside| {
            beside.sort_unstable();
            beside.dedup();
        });
        patches
    }

    fn is_fin(&self, patch: u32, area_of_component: f64) -> bool {
        let at = patch as usize;
        // Area of a disc with the open boundary as its circumference.
        let covered = self.open[at] * self.open[at] / (4.0 * PI);
        let ends = self.open[at] > 0.0 && (self.is_mixed[at] || covered > 0.5 * self.areas[at]);
        ends && self.beside.contains_key(&patch) && self.areas[at] < 0.5 * area_of_component
    }
}

fn fins(faces: &RepairFaces) -> (Vec<u32>, Vec<u32>) {
    let patches = SheetPatches::new(faces);
    let (component, n_components) = components(faces);
    let mut areas = vec![0.0; n_components];
    let mut component_of = vec![0; patches.areas.len()];
    for (face, &component) in faces.numbers().zip(&component) {
        areas[component as usize] += faces.area(face);
        component_of[patches.of_face[face as usize] as usize] = component as usize;
    }
    let mut found: Vec<u32> = (0..component_of.len() as u32)
        .filter(|&patch| patches.is_fin(patch, areas[component_of[patch as usize]]))
        .collect();
    // Small fins first: without them a larger neighbour may be part of a surface.
    found.sort_by(|&a, &b| patches.areas[a as usize].total_cmp(&patches.areas[b as usize]).then(a.cmp(&b)));
    let mut is_blocked = vec![false; component_of.len()];
    found.retain(|&fin| {
        // Neighbours wait for the next round, when patches have merged.
        let goes = !is_blocked[fin as usize];
        patches.beside.get(&fin).into_iter().flatten().filter(|_| goes).for_each(|&at| is_blocked[at as usize] = true);
        goes
    });
    (patches.of_face, found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes};

    #[test]
    fn fins_are_dropped_and_bodies_stay() {
        let sphere = shapes::icosphere(2);
        let mut positions = sphere.positions().to_vec();
        let mut faces = sphere.faces().to_vec();
        let [a, b, _] = faces[0];
        positions.push([2.0; 3]);
        faces.push([a, b, positions.len() as u32 - 1]);
        let mesh = TriMesh::new(positions, faces).unwrap();
        let mut faces = RepairFaces::new(&mesh, &Attributes::default());
        assert_eq!(drop_fins(&mut faces), 1);
        assert_eq!(faces.corners, sphere.faces());
    }

    #[test]
    fn walls_and_holes_are_no_fins() {
        // Two boxes with one wall between them, one with a hole away from the wall.
        let positions: Vec<[f32; 3]> =
            (0..12u32).map(|i| [(i % 3) as f32, (i / 3 % 2) as f32, (i / 6) as f32]).collect();
        let quads = [
            [0, 3, 4, 1],
            [1, 4, 5, 2],
            [6, 7, 10, 9],
            [7, 8, 11, 10],
            [0, 1, 7, 6],
            [1, 2, 8, 7],
            [3, 9, 10, 4],
            [4, 10, 11, 5],
            [0, 6, 9, 3],
            [2, 5, 11, 8],
            [1, 4, 10, 7],
        ];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = TriMesh::new(positions, triangles).unwrap();
        assert_eq!(drop_fins(&mut RepairFaces::new(&mesh, &Attributes::default())), 0);
        let plate = shapes::grid(4, 4);
        assert_eq!(drop_fins(&mut RepairFaces::new(&plate, &Attributes::default())), 0);
    }

    #[test]
    fn two_of_many_pages_at_an_edge_stay() {
        let tips = (0..5).map(|i| (i as f32).sin_cos()).map(|(y, x)| [x, y, 0.5]);
        let positions: Vec<[f32; 3]> = [[0.0; 3], [0.0, 0.0, 1.0]].into_iter().chain(tips).collect();
        let mesh = TriMesh::new(positions, (2..7).map(|tip| [0, 1, tip]).collect()).unwrap();
        let mut faces = RepairFaces::new(&mesh, &Attributes::default());
        assert_eq!((drop_fins(&mut faces), faces.len()), (3, 2));
    }
}
