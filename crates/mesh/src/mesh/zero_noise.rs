//! Closes cracks along coordinates that would be 0 but for rounding errors of the program that computed them.
//!
//! Near 1, single precision joins numbers that differ by less than 6e-8; near 0 it tells 1e-17 from 0. So surfaces that
//! were computed face by face, such as those of CAD, would have cracks there.
//!
//! Noise is a coordinate of at most `LARGEST_NOISE` of the mesh's largest. Two vertices are joined if they differ by noise
//! alone and end open edges that so close. Vertices of faces nearly as thin as noise stay, and so do those of faces that
//! would repeat another: no face is lost. Vertices that are joined take the place of the first; others keep their bits.

use super::compact::used_vertices;
use super::first_equal::{first_equal, position_key};
use super::half_edges::{HalfEdge, for_each_edge, next, start};
use super::repeated_faces::repeated_faces;
use super::union_find::UnionFind;
use crate::geometry::triangle::{area_normal_f64, corners_f64};

/// Largest noise, over the mesh's largest coordinate: 64 rounding errors of doubles.
const LARGEST_NOISE: f32 = 1.0 / (1u64 << 46) as f32;
/// Least height of the faces at a vertex that is joined, over the largest noise: joining bends thinner ones.
const LEAST_HEIGHT: f64 = 1024.0;

/// Least and largest absolute value of coordinates, by axis; 0 is left out.
// Bits of absolute values are in the order of these, and quick to compare; 0 less 1 is the largest number.
#[derive(Clone, Copy)]
pub(super) struct Magnitudes {
    least_bits_less_1: [u32; 3],
    largest_bits: [u32; 3],
}

impl Magnitudes {
    pub(super) fn of_used(positions: &[[f32; 3]], used: &[bool]) -> Self {
        let mut found = Self { least_bits_less_1: [u32::MAX; 3], largest_bits: [0; 3] };
        for (&position, &used) in positions.iter().zip(used) {
            let position = if used { position } else { [0.0; 3] };
            for (axis, x) in position.into_iter().enumerate() {
                let bits = x.abs().to_bits();
                found.least_bits_less_1[axis] = found.least_bits_less_1[axis].min(bits.wrapping_sub(1));
                found.largest_bits[axis] = found.largest_bits[axis].max(bits);
            }
        }
        found
    }

    pub(super) fn are_finite(self) -> bool {
        self.largest_bits.into_iter().all(|bits| f32::from_bits(bits).is_finite())
    }

    /// Returns whether any coordinate is noise.
    pub(super) fn has_noise(self) -> bool {
        let largest = self.largest_noise();
        self.least_bits_less_1.into_iter().any(|bits| bits < largest.to_bits())
    }

    fn largest_noise(self) -> f32 {
        LARGEST_NOISE * self.largest_bits.into_iter().map(f32::from_bits).fold(0.0, f32::max)
    }
}

/// Joins vertices of `faces` that only noise tells apart, and marks them as not used; returns their number.
pub(super) fn join_across_noise(positions: &[[f32; 3]], faces: &mut [[u32; 3]], used: &mut [bool]) -> usize {
    let noise = Magnitudes::of_used(positions, used).largest_noise();
    let Some(place) = places_without_noise(positions, used, noise) else { return 0 };
    let mut is_shared = vec![false; positions.len()];
    (0u32..).zip(&place).filter(|&(v, &first)| v != first).for_each(|(v, &first)| {
        (is_shared[v as usize], is_shared[first as usize]) = (true, true);
    });
    let near: Vec<[u32; 3]> =
        faces.iter().copied().filter(|face| face.iter().any(|&v| is_shared[v as usize])).collect();
    let mut sets = join_open_edges(positions, &near, &place, f64::from(noise));
    faces.as_flattened_mut().iter_mut().for_each(|v| *v = sets.find(*v));
    let n_before = used.iter().filter(|used| **used).count();
    used.copy_from_slice(&used_vertices(faces, positions.len()));
    n_before - used.iter().filter(|used| **used).count()
}

/// Returns the first used vertex at each vertex's position with 0 for noise; `None` if it is the vertex itself everywhere.
fn places_without_noise(positions: &[[f32; 3]], used: &[bool], noise: f32) -> Option<Vec<u32>> {
    let is_zero = |x: f32| x.abs() <= noise;
    let at_zero: Vec<u32> = (0..positions.len() as u32)
        .filter(|&v| used[v as usize] && positions[v as usize].into_iter().any(is_zero))
        .collect();
    let quiet = |v: u32| positions[v as usize].map(|x| if is_zero(x) { 0.0 } else { x });
    let (first, is_repeated) = first_equal(at_zero.len(), |i| position_key(quiet(at_zero[i])));
    if !is_repeated {
        return None;
    }
    let mut place: Vec<u32> = (0..positions.len() as u32).collect();
    at_zero.iter().zip(first).for_each(|(&v, first)| place[v as usize] = at_zero[first as usize]);
    Some(place)
}

/// Joins the ends of open edges between the same places, where an even number of faces meet.
fn join_open_edges(positions: &[[f32; 3]], faces: &[[u32; 3]], place: &[u32], noise: f64) -> UnionFind {
    let placed: Vec<[u32; 3]> = faces.iter().map(|face| face.map(|v| place[v as usize])).collect();
    let mut stays = vec![false; positions.len()];
    let repeated = repeated_faces(&placed, positions.len()).into_iter().map(|face| &faces[face as usize]);
    let thin = faces.iter().filter(|face| is_thin(face.map(|v| positions[v as usize]), LEAST_HEIGHT * noise));
    repeated.chain(thin).flatten().for_each(|&v| stays[v as usize] = true);
    let mut sets = UnionFind::new(positions.len());
    for_each_edge(positions.len(), &placed, |_, sides| {
        let ends = |side: &HalfEdge| {
            let [a, b] = [side.half_edge, next(side.half_edge)].map(|corner| start(faces, corner));
            if side.runs_up(&placed) { [a, b] } else { [b, a] }
        };
        let mut edges: Vec<[u32; 2]> = sides.iter().map(ends).collect();
        if edges.len() % 2 == 1 || edges.as_flattened().iter().any(|&v| stays[v as usize]) {
            return;
        }
        edges.sort_unstable();
        let open = edges.chunk_by(|x, y| x == y).filter(|same| same.len() % 2 == 1).map(|same| same[0]);
        open.reduce(|[a, b], [c, d]| {
            sets.union(a, c);
            sets.union(b, d);
            [a, b]
        });
    });
    sets
}

/// Returns whether any height of a triangle is at most `height`.
fn is_thin(corners: [[f32; 3]; 3], height: f64) -> bool {
    let [a, b, c] = corners_f64(corners);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    area_normal_f64([a, b, c]).length() <= height * longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::cleanup::{CleanOptions, Cleaned, clean};
    use crate::mesh::first_equal::join_positions;
    use crate::mesh::{RawMesh, has_area, shapes, topology};
    use proptest::prelude::*;

    const NOISE: f64 = 3e-17;

    /// A cube from 0 to 1.
    fn cube() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let (positions, faces) = shapes::cuboid([1.0; 3], 1).into_parts();
        let low = positions.iter().flatten().copied().fold(0.0, f32::min);
        (positions.iter().map(|p| p.map(|x| f64::from(x - low))).collect(), faces)
    }

    /// Separate triangles whose zeros are noise of either sign.
    fn noisy((positions, faces): &(Vec<[f64; 3]>, Vec<[u32; 3]>), scale: f64, noise: f64) -> RawMesh {
        let corner = |(i, &v): (usize, &u32)| {
            let noisy = |axis: usize| noise * (((7 * i + 3 * axis) % 5) as f64 - 2.0);
            let place = positions[v as usize].map(|x| scale * x);
            std::array::from_fn(|axis| if place[axis] == 0.0 { noisy(axis) } else { place[axis] })
        };
        let apart = (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        RawMesh::new(faces.as_flattened().iter().enumerate().map(corner).collect(), apart)
    }

    fn cleaned(raw: &RawMesh) -> Cleaned {
        clean(raw.clone(), &CleanOptions::default()).unwrap()
    }

    /// Returns the places of the corners, bit by bit.
    fn corners(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<[[u32; 3]; 3]> {
        faces.iter().map(|face| face.map(|v| position_key(positions[v as usize]))).collect()
    }

    /// Asserts that cleaning keeps all faces, with every bit of their corners.
    fn assert_stays(positions: &[[f64; 3]], faces: &[[u32; 3]]) {
        let found = cleaned(&RawMesh::new(positions.to_vec(), faces.to_vec())).mesh;
        let singles: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x as f32)).collect();
        assert_eq!(corners(found.positions(), found.faces()), corners(&singles, faces));
    }

    #[test]
    fn noise_about_zero_leaves_no_cracks() {
        for scale in [1e-20, 1.0, 1e20] {
            let raw = noisy(&cube(), scale, NOISE * scale);
            let Cleaned { mesh, counts, source, .. } = cleaned(&raw);
            assert_eq!(
                (topology(&mesh).boundary_edges, mesh.positions().len(), mesh.faces().len()),
                (0, 8, 12),
                "{scale}"
            );
            assert_eq!(counts.welded_vertices, 36 - 8);
            for (position, &source) in mesh.positions().iter().zip(&source) {
                assert_eq!(*position, raw.positions[source as usize].map(|x| x as f32));
            }
            let open = cleaned(&noisy(&cube(), scale, 1e-6 * scale));
            assert!(topology(&open.mesh).boundary_edges > 0);
        }
    }

    #[test]
    fn a_crack_along_an_axis_closes_and_the_rest_keeps_its_bits() {
        // A square of two triangles along the x axis; noise at the outer corners, too.
        let n = NOISE;
        let positions =
            [[0.0, 0.0, n], [1.0, 0.0, 0.0], [0.5, 1.0, -n], [0.0, n, 0.0], [1.0, -n, 2.0 * n], [0.5, -1.0, n]];
        let faces = [[0, 1, 2], [4, 3, 5]];
        let found = cleaned(&RawMesh::new(positions.to_vec(), faces.to_vec()));
        assert_eq!((found.mesh.faces(), &found.source[..]), (&[[0, 1, 2], [1, 0, 3]][..], &[0, 1, 2, 5][..]));
        let expected: Vec<_> = [0, 1, 2, 5].map(|v: usize| positions[v].map(|x: f64| x as f32)).to_vec();
        assert_eq!(found.mesh.positions(), expected);
        // Vertices that close no edge stay.
        let apart = [positions[0], positions[1], positions[2], positions[3], [1.0, -1e-3, 0.0], positions[5]];
        assert_stays(&apart, &faces);
    }

    #[test]
    fn without_welding_cracks_stay() {
        let found = clean(noisy(&cube(), 1.0, NOISE), &CleanOptions { weld: false }).unwrap();
        assert_eq!(found.mesh.positions().len(), 36);
    }

    #[test]
    fn closed_surfaces_that_meet_but_for_noise_stay_apart() {
        let (mut positions, mut faces) = cube();
        let n = positions.len() as u32;
        positions.extend(cube().0.iter().map(|&[x, y, z]| [if x == 0.0 { 1e-17 } else { -x }, y, z]));
        faces.extend(cube().1.iter().map(|&[a, b, c]| [a + n, c + n, b + n]));
        assert_stays(&positions, &faces);
    }

    #[test]
    fn shapes_as_small_as_noise_stay() {
        let (mut positions, mut faces) = cube();
        let n = positions.len() as u32;
        positions.extend(cube().0.iter().map(|p| p.map(|x| 1e-17 * x)));
        // Both are open.
        faces.pop();
        faces.extend(faces.clone().iter().map(|face| face.map(|v| v + n)));
        assert_stays(&positions, &faces);
        assert_stays(&positions[..8], &faces[..11]);
    }

    #[test]
    fn faces_of_mixed_scales_stay() {
        // Open edges with equal ends but for noise; faces with a corner, an edge or a height as small as noise.
        let positions = [
            [0.0, 1e-20, 0.0],
            [1.0, 0.0, 1e-25],
            [1e-18, 0.0, 1e-22],
            [1.0, 1e-21, 0.0],
            [0.5, 0.0, 1e-17],
            [2.0, 1.0, 0.0],
        ];
        for faces in [[[0, 1, 2], [2, 3, 5]], [[0, 1, 4], [2, 3, 5]], [[0, 2, 5], [2, 1, 5]], [[0, 1, 5], [2, 3, 4]]] {
            assert_stays(&positions, &faces);
        }
    }

    #[test]
    fn faces_that_would_repeat_another_stay() {
        let n = NOISE;
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, n], [1.0, 0.0, n], [0.0, 1.0, n]];
        assert_stays(&positions, &[[0, 1, 2], [3, 5, 4]]);
        assert_stays(&positions, &[[0, 1, 2], [3, 4, 5]]);
    }

    #[test]
    fn coordinates_without_noise_need_no_search() {
        let has_noise =
            |positions: &[[f32; 3]]| Magnitudes::of_used(positions, &vec![true; positions.len()]).has_noise();
        assert!(!has_noise(&[]) && !has_noise(&[[0.0, -0.0, 0.0]]) && !has_noise(&[[0.0, 1.0, -1e-13]]));
        assert!(has_noise(&[[0.0, 1.0, 0.0], [-1e-17, 0.0, 0.0]]));
        let (noise, next) = (LARGEST_NOISE, LARGEST_NOISE.next_up());
        assert!(has_noise(&[[0.0, 1.0, noise]]) && !has_noise(&[[0.0, 1.0, next]]));
        assert!(!Magnitudes::of_used(&[[0.0, 1.0, noise], [1.0; 3]], &[false, true]).has_noise());
        let finite = |x: f32| Magnitudes::of_used(&[[1.0, x, 0.0]], &[true]).are_finite();
        assert!(finite(f32::MAX) && !finite(-f32::INFINITY) && !finite(f32::NAN));
    }

    /// Returns the edges with an odd number of faces.
    fn open_edges(n_vertices: usize, faces: &[[u32; 3]]) -> usize {
        let mut n_open = 0;
        for_each_edge(n_vertices, faces, |_, sides| n_open += sides.len() % 2);
        n_open
    }

    /// Returns the faces between first vertices of each position, without repeated faces or corners.
    fn welded(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let (first, _) = join_positions(positions);
        let mut faces: Vec<[u32; 3]> = faces.iter().map(|face| face.map(|v| first[v as usize])).collect();
        faces.retain(|&[a, b, c]| a != b && b != c && c != a);
        let repeated = repeated_faces(&faces, positions.len());
        (0..).zip(faces).filter(|(i, _)| !repeated.contains(i)).map(|(_, face)| face).collect()
    }

    proptest! {
        #[test]
        fn joins_close_edges_and_lose_no_face(
            zeros in prop::collection::vec(prop::sample::select(vec![0.0, 0.0, 1e-17, -1e-17, 0.0, 1e-12, 1e-7]), 3 * 36),
            more in prop::collection::vec(prop::array::uniform3(0u32..36), 0..8),
        ) {
            let (places, faces) = cube();
            let corner = |(i, &v): (usize, &u32)| {
                let place = places[v as usize].map(|x| x as f32);
                std::array::from_fn(|axis| if place[axis] == 0.0 { zeros[3 * i + axis] } else { place[axis] })
            };
            let positions: Vec<[f32; 3]> = faces.as_flattened().iter().enumerate().map(corner).collect();
            let n = positions.len();
            let apart = (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
            let faces = welded(&positions, &apart.chain(more).collect::<Vec<_>>());
            let (mut joined, mut used) = (faces.clone(), used_vertices(&faces, n));
            let n_used = used.iter().filter(|used| **used).count();
            let n_joined = join_across_noise(&positions, &mut joined, &mut used);
            prop_assert_eq!(&used, &used_vertices(&joined, n));
            prop_assert_eq!(n_joined, n_used - used.iter().filter(|used| **used).count());
            prop_assert_eq!(n_joined > 0, open_edges(n, &joined) < open_edges(n, &faces));
            prop_assert!(repeated_faces(&joined, n).is_empty());
            for (after, before) in joined.iter().zip(&faces).filter(|(after, before)| after != before) {
                let [after, before] = [after, before].map(|face| face.map(|v| positions[v as usize].map(f64::from)));
                prop_assert!(has_area(before) && has_area(after));
                let moved = after.as_flattened().iter().zip(before.as_flattened()).map(|(x, y)| (x - y).abs());
                prop_assert!(moved.fold(0.0, f64::max) <= 2e-17);
            }
            let again = joined.clone();
            prop_assert_eq!(join_across_noise(&positions, &mut joined, &mut used), 0);
            prop_assert_eq!(joined, again);
        }
    }
}
