//! Two faces over an edge, which a flip replaces.

use super::faces_around::FacesAround;

/// Edge with its two consistently wound faces: corners `a b c` and `b a d`.
#[derive(Clone, Copy)]
pub struct Diamond {
    pub faces: [u32; 2],
    pub corners: [u32; 4],
}

impl Diamond {
    pub fn present_faces(&self) -> [[u32; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[a, b, c], [b, a, d]]
    }

    pub fn flipped_faces(&self) -> [[u32; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[c, d, b], [d, c, a]]
    }
}

/// Finds the diamonds over the edges of a face; `a b c` is that face.
pub fn diamonds(faces: &[[u32; 3]], around: &FacesAround, f: u32) -> impl Iterator<Item = Diamond> {
    let [a, b, c] = faces[f as usize];
    [(a, b, c), (b, c, a), (c, a, b)].into_iter().filter_map(move |(a, b, c)| {
        let g = around.face_along(b, a)?;
        let d = *faces[g as usize].iter().find(|&&v| v != a && v != b)?;
        (c != d).then_some(Diamond { faces: [f, g], corners: [a, b, c, d] })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;

    #[test]
    fn a_diamond_flipped_twice_is_the_same_turned_round() {
        let faces = [[0, 1, 2], [3, 1, 0], [2, 1, 4]];
        let around = FacesAround::new(Pulse::NONE, 5, &faces);
        let found: Vec<Diamond> = diamonds(&faces, &around, 0).collect();
        assert_eq!(found.iter().map(|diamond| diamond.corners).collect::<Vec<_>>(), [[0, 1, 2, 3], [1, 2, 0, 4]]);
        assert_eq!(
            (found[0].present_faces(), found[0].flipped_faces()),
            ([[0, 1, 2], [1, 0, 3]], [[2, 3, 1], [3, 2, 0]])
        );
        let flipped = found[0].flipped_faces();
        let twice = diamonds(&flipped, &FacesAround::new(Pulse::NONE, 4, &flipped), 0)
            .next()
            .map(|diamond| diamond.flipped_faces());
        assert_eq!(twice, Some([[1, 0, 3], [0, 1, 2]]));
    }
}
