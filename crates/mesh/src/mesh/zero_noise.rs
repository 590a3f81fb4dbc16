//! Coordinates that would be 0 but for rounding errors of the program that computed them.
//!
//! Near 1, single precision joins numbers that differ by less than 6e-8; near 0 it tells 1e-17 from 0. So surfaces that were
//! computed face by face, such as those of CAD, would have cracks there.

use super::first_equal::join_positions;
use super::half_edges::for_each_edge;

/// Largest absolute value of such a coordinate, over the mesh's largest coordinate: 64 rounding errors of doubles.
const LARGEST: f32 = 1.0 / (1u64 << 46) as f32;
/// Least extent of a face at the vertex, over the largest noise: smaller faces are shapes.
const LEAST_EXTENT: f32 = 1024.0;

/// Returns the positions with 0 in place of noise at open edges of faces; `None` if there is none.
// Surfaces that cross each other there by chance stay apart.
pub fn without_zero_noise(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Option<Vec<[f32; 3]>> {
    let corners = || faces.as_flattened().iter().map(|&v| positions[v as usize]);
    let noise = LARGEST * corners().flatten().fold(0.0, |most: f32, x| most.max(x.abs()));
    let is_noise = |x: f32| x != 0.0 && x.abs() <= noise;
    if !corners().flatten().any(is_noise) {
        return None;
    }
    let (first, _) = join_positions(positions);
    let is_open = vertices_of_open_edges(&first, faces);
    let mut quiet = positions.to_vec();
    for face in faces {
        let corners = face.map(|v| positions[v as usize]);
        let extent = |axis: usize| {
            let [a, b, c] = corners.map(|corner| corner[axis]);
            a.max(b).max(c) - a.min(b).min(c)
        };
        if (0..3).any(|axis| extent(axis) > LEAST_EXTENT * noise) {
            let open = face.iter().map(|&v| v as usize).filter(|&v| is_open[first[v] as usize]);
            let coordinates = open.flat_map(|v| (0..3).map(move |axis| (v, axis)));
            coordinates.filter(|&(v, axis)| is_noise(positions[v][axis])).for_each(|(v, axis)| quiet[v][axis] = 0.0);
        }
    }
    Some(quiet)
}

/// Marks the first vertices at the ends of edges with an odd number of faces.
fn vertices_of_open_edges(first: &[u32], faces: &[[u32; 3]]) -> Vec<bool> {
    let joined: Vec<[u32; 3]> = faces.iter().map(|face| face.map(|v| first[v as usize])).collect();
    let mut is_open = vec![false; first.len()];
    for_each_edge(first.len(), &joined, |ends, sides| {
        if sides.len() % 2 == 1 {
            ends.iter().for_each(|&v| is_open[v as usize] = true);
        }
    });
    is_open
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::cleanup::{CleanOptions, clean};
    use crate::mesh::{RawMesh, shapes, topology};

    fn cube() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let (positions, faces) = shapes::cuboid([1.0; 3], 1).into_parts();
        let low = positions.iter().flatten().copied().fold(0.0, f32::min);
        (positions.iter().map(|p| p.map(|x| x - low)).collect(), faces)
    }

    /// A box of 12 separate triangles, whose zeros are noise of either sign.
    fn noisy_box(scale: f64, noise: f64) -> RawMesh {
        let (positions, faces) = cube();
        let corner = |(i, &v): (usize, &u32)| {
            let noisy = |axis: usize| noise * (((7 * i + 3 * axis) % 5) as f64 - 2.0);
            let place = positions[v as usize].map(|x| scale * f64::from(x));
            std::array::from_fn(|axis| if place[axis] == 0.0 { noisy(axis) } else { place[axis] })
        };
        let apart = (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        RawMesh::new(faces.as_flattened().iter().enumerate().map(corner).collect(), apart)
    }

    #[test]
    fn noise_about_zero_leaves_no_cracks() {
        for scale in [1e-20, 1.0, 1e20] {
            let cleaned = clean(noisy_box(scale, 3e-17 * scale), &CleanOptions::default()).unwrap();
            let found = topology(&cleaned.mesh);
            assert_eq!((found.boundary_edges, cleaned.mesh.positions().len()), (0, 8), "{scale}");
            let open = clean(noisy_box(scale, 1e-6 * scale), &CleanOptions::default()).unwrap();
            assert!(topology(&open.mesh).boundary_edges > 0);
        }
    }

    #[test]
    fn closed_surfaces_that_meet_but_for_noise_stay_apart() {
        let (mut positions, mut faces) = cube();
        let n = positions.len() as u32;
        positions.extend(cube().0.iter().map(|&[x, y, z]| [if x == 0.0 { 1e-17 } else { -x }, y, z]));
        faces.extend(cube().1.iter().map(|face| face.map(|v| v + n)));
        assert!(without_zero_noise(&positions, &faces).is_some_and(|quiet| quiet == positions));
    }

    #[test]
    fn shapes_as_small_as_noise_stay() {
        let (mut positions, mut faces) = cube();
        let small: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| 1e-17 * x)).collect();
        let n = positions.len() as u32;
        positions.extend(small);
        // Both are open.
        faces.pop();
        faces.extend(faces.clone().iter().map(|face| face.map(|v| v + n)));
        assert!(without_zero_noise(&positions, &faces).is_some_and(|quiet| quiet == positions));
        assert!(without_zero_noise(&positions[..8], &faces[..11]).is_none());
        assert!(without_zero_noise(&[], &[]).is_none());
    }
}
