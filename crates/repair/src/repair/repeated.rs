//! Faces with the same three vertices.

use rustc_hash::FxHashMap;

use super::components::components;
use super::faces::RepairFaces;

/// Share of a component's area above which faces present in both directions are its surface, not walls.
const TWO_SIDED: f64 = 0.5;

#[derive(Clone, Copy, Default)]
struct SameFaces {
    n_up: usize,
    n_down: usize,
    first: u32,
}

/// Drops faces that repeat others; returns the number dropped.
///
/// Faces in equal number in both directions are walls and all dropped, unless they are most of a component.
pub(super) fn drop_repeated(faces: &mut RepairFaces) -> usize {
    let (same, all) = same_faces(faces);
    let is_pair = |face: u32| same[all[face as usize] as usize].is_balanced();
    let (component, n) = components(faces);
    let mut areas = vec![[0.0; 2]; n];
    for face in faces.numbers() {
        areas[component[face as usize] as usize][usize::from(is_pair(face))] += faces.area(face);
    }
    // A surface given in both directions is kept once; a wall is not.
    let is_two_sided = |[single, paired]: [f64; 2]| paired > TWO_SIDED * (single + paired);
    drop_where(faces, |face| {
        let same = same[all[face as usize] as usize];
        let stays = !same.is_balanced() || is_two_sided(areas[component[face as usize] as usize]);
        !(stays && same.first == face)
    })
}

/// Drops pairs of opposite faces over the same vertices; returns the number of faces dropped.
pub(super) fn drop_opposite(faces: &mut RepairFaces) -> usize {
    let (same, all) = same_faces(faces);
    // The number of faces of each direction that cancel out.
    let mut left: Vec<[usize; 2]> = same.iter().map(|same| [same.n_up.min(same.n_down); 2]).collect();
    let goes = |face: u32| {
        let left = &mut left[all[face as usize] as usize][usize::from(is_up(faces.corners[face as usize]))];
        let goes = *left > 0;
        *left -= usize::from(goes);
        goes
    };
    let gone: Vec<bool> = faces.numbers().map(goes).collect();
    drop_where(faces, |face| gone[face as usize])
}

impl SameFaces {
    fn is_balanced(self) -> bool {
        self.n_up == self.n_down
    }
}

fn is_up([a, b, c]: [u32; 3]) -> bool {
    [a < b, b < c, c < a].iter().filter(|rises| **rises).count() == 2
}

fn same_faces(faces: &RepairFaces) -> (Vec<SameFaces>, Vec<u32>) {
    let mut number: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    let mut same: Vec<SameFaces> = Vec::new();
    let of = faces.numbers().zip(&faces.corners).map(|(face, &corners)| {
        let mut vertices = corners;
        vertices.sort_unstable();
        let at = *number.entry(vertices).or_insert_with(|| {
            same.push(SameFaces { first: face, ..SameFaces::default() });
            same.len() as u32 - 1
        });
        let count = &mut same[at as usize];
        *(if is_up(corners) { &mut count.n_up } else { &mut count.n_down }) += 1;
        at
    });
    let of = of.collect();
    (same, of)
}

fn drop_where(faces: &mut RepairFaces, goes: impl Fn(u32) -> bool) -> usize {
    let gone: Vec<bool> = faces.numbers().map(goes).collect();
    let n_gone = gone.iter().filter(|gone| **gone).count();
    if n_gone > 0 {
        faces.retain(|face| !gone[face as usize]);
    }
    n_gone
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh};

    fn faces_left(corners: &[[u32; 3]], drop: fn(&mut RepairFaces) -> usize) -> Vec<[u32; 3]> {
        let mesh =
            TriMesh::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 0.0]], corners.to_vec())
                .unwrap();
        let mut faces = RepairFaces::new(&mesh, &Attributes::default());
        assert_eq!(drop(&mut faces), corners.len() - faces.len());
        faces.corners
    }

    #[test]
    fn pairs_cancel_and_of_others_one_stays() {
        // A larger face keeps the pair below half of the area.
        let [up, down, other] = [[0, 1, 2], [2, 1, 0], [1, 2, 3]];
        assert_eq!(faces_left(&[up, other, down], drop_repeated), [other]);
        assert_eq!(faces_left(&[up, other, up], drop_repeated), [up, other]);
        assert_eq!(faces_left(&[other, up, down, [1, 0, 2]], drop_repeated), [other, up]);
        assert_eq!(faces_left(&[up, other, down], drop_opposite), [other]);
        assert_eq!(faces_left(&[up, up], drop_opposite), [up, up]);
        assert_eq!(faces_left(&[up, down, [1, 2, 0]], drop_opposite), [[1, 2, 0]]);
    }

    #[test]
    fn a_surface_stated_for_both_sides_keeps_one() {
        assert_eq!(faces_left(&[[0, 1, 2], [2, 1, 0], [1, 2, 3], [3, 2, 1]], drop_repeated), [[0, 1, 2], [1, 2, 3]]);
    }
}
