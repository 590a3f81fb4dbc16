//! Faces with the same three vertices.

use rustc_hash::FxHashMap;

use super::components::components;
use super::faces::Faces;

/// Share of a component's area above which faces that are there both ways are its surface, stated for either side, and not walls.
const TWO_SIDED: f64 = 0.5;

/// The faces over three vertices.
#[derive(Clone, Copy, Default)]
struct Same {
    /// How many ascend, going around from some vertex.
    n_up: usize,
    n_down: usize,
    /// The first of them.
    first: u32,
}

/// Drops faces that repeat others. As many wound one way as the other, as a wall between two bodies has, all go: they enclose
/// nothing; but where this is most of a component, and always else, one stays. Returns how many went.
pub(super) fn drop_repeated(faces: &mut Faces) -> usize {
    let (same, all) = same_faces(faces);
    let is_pair = |face: u32| same[all[face as usize] as usize].is_balanced();
    let (component, n) = components(faces);
    let mut areas = vec![[0.0; 2]; n];
    for face in faces.numbers() {
        areas[component[face as usize] as usize][usize::from(is_pair(face))] += faces.area(face);
    }
    let is_two_sided = |[single, paired]: [f64; 2]| paired > TWO_SIDED * (single + paired);
    drop_where(faces, |face| {
        let same = same[all[face as usize] as usize];
        let stays = !same.is_balanced() || is_two_sided(areas[component[face as usize] as usize]);
        !(stays && same.first == face)
    })
}

/// Drops as many faces as are wound one way and the other over the same three vertices: what is left encloses the same.
pub(super) fn drop_opposite(faces: &mut Faces) -> usize {
    let (same, all) = same_faces(faces);
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

impl Same {
    fn is_balanced(self) -> bool {
        self.n_up == self.n_down
    }
}

fn is_up([a, b, c]: [u32; 3]) -> bool {
    [a < b, b < c, c < a].iter().filter(|rises| **rises).count() == 2
}

/// All sets of faces over the same vertices, and that of each face.
fn same_faces(faces: &Faces) -> (Vec<Same>, Vec<u32>) {
    let mut number: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    let mut same: Vec<Same> = Vec::new();
    let of = faces.numbers().zip(&faces.corners).map(|(face, &corners)| {
        let mut vertices = corners;
        vertices.sort_unstable();
        let at = *number.entry(vertices).or_insert_with(|| {
            same.push(Same { first: face, ..Same::default() });
            same.len() as u32 - 1
        });
        let count = &mut same[at as usize];
        *(if is_up(corners) { &mut count.n_up } else { &mut count.n_down }) += 1;
        at
    });
    let of = of.collect();
    (same, of)
}

/// Drops faces; returns how many.
fn drop_where(faces: &mut Faces, goes: impl Fn(u32) -> bool) -> usize {
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

    fn left(corners: &[[u32; 3]], drop: fn(&mut Faces) -> usize) -> Vec<[u32; 3]> {
        let mesh =
            TriMesh::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 0.0]], corners.to_vec())
                .unwrap();
        let mut faces = Faces::new(&mesh, &Attributes::default());
        assert_eq!(drop(&mut faces), corners.len() - faces.len());
        faces.corners
    }

    #[test]
    fn pairs_cancel_and_of_others_one_stays() {
        // Beside a larger face on the same edge, so that they are the smaller part.
        let [up, down, other] = [[0, 1, 2], [2, 1, 0], [1, 2, 3]];
        assert_eq!(left(&[up, other, down], drop_repeated), [other]);
        assert_eq!(left(&[up, other, up], drop_repeated), [up, other]);
        assert_eq!(left(&[other, up, down, [1, 0, 2]], drop_repeated), [other, up]);
        assert_eq!(left(&[up, other, down], drop_opposite), [other]);
        assert_eq!(left(&[up, up], drop_opposite), [up, up]);
        assert_eq!(left(&[up, down, [1, 2, 0]], drop_opposite), [[1, 2, 0]]);
    }

    #[test]
    fn a_surface_stated_for_both_sides_keeps_one() {
        assert_eq!(left(&[[0, 1, 2], [2, 1, 0], [1, 2, 3], [3, 2, 1]], drop_repeated), [[0, 1, 2], [1, 2, 3]]);
    }
}
