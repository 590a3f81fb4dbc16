//! Converts any set of triangles into an oriented manifold.
//!
//! Each vertex is split into its fans of faces joined over edges. At an edge with more than two faces, the pairs that
//! continue each other best stay joined; a single remaining face gets a boundary. No position changes and no face is
//! lost.

use std::borrow::Cow;

use rustc_hash::FxHashSet;

use super::OneRings;
use super::half_edges::{for_each_edge, next, spread_winding, start, twins};
use super::non_manifold_edges::{Partners, partners};
use super::one_rings::MeetingSheets;
use super::pulse::Pulse;
use super::surroundings::{Surroundings, corners_at};
use super::union_find::UnionFind;

/// Largest number of rounds that change pairs at non-manifold edges.
const MOST_ROUNDS: usize = 32;

/// A manifold made of the input's faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifold<'a> {
    /// Faces in the input's order, n_faces x 3, some reversed.
    pub faces: Cow<'a, [[u32; 3]]>,
    /// One-rings of all vertices.
    pub rings: OneRings,
    /// Input vertex of each added vertex.
    pub copies: Vec<u32>,
    /// Number of reversed faces.
    pub turned_faces: usize,
}

/// Separates `faces` (n_faces x 3, distinct corners) into a manifold.
///
/// A one-sided surface stays joined; `rings.is_oriented()` is then false.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// // Two triangles that touch in vertex 0 alone.
/// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
/// let manifold = neural_mesh::mesh::manifold(&positions, &[[0, 1, 2], [0, 3, 4]]);
/// assert_eq!(manifold.copies, [0]);
/// ```
pub fn manifold<'a>(positions: &[[f32; 3]], faces: &'a [[u32; 3]]) -> Manifold<'a> {
    manifold_with(Pulse::NONE, positions, faces)
}

#[doc(hidden)]
pub fn manifold_with<'a>(pulse: Pulse, positions: &[[f32; 3]], faces: &'a [[u32; 3]]) -> Manifold<'a> {
    let mut faces = Cow::Borrowed(faces);
    let mut copies = Vec::new();
    let mut turned_faces = None;
    loop {
        match OneRings::new_with_pulse(pulse, positions.len() + copies.len(), &faces) {
            Ok(rings) if rings.is_oriented() || turned_faces.is_some() => {
                return Manifold { faces, rings, copies, turned_faces: turned_faces.unwrap_or(0) };
            }
            Ok(rings) => turned_faces = Some(orient(rings.n_vertices(), faces.to_mut())),
            Err(meeting) => split_sheets(positions, faces.to_mut(), &meeting, &mut copies),
        }
    }
}

fn split_sheets(positions: &[[f32; 3]], faces: &mut [[u32; 3]], meeting: &MeetingSheets, copies: &mut Vec<u32>) {
    let n_vertices = positions.len();
    let first_new = (n_vertices + copies.len()) as u32;
    let mut around = Surroundings::new(first_new as usize, faces, meeting);
    // If a separation made sheets meet again, no faces stay joined at non-manifold edges.
    let mut joined = if copies.is_empty() { Some(partners(positions, &around)) } else { None };
    let mut vertices = meeting.vertices.clone();
    for round in 0.. {
        let n_before = copies.len();
        if let Some(partners) = joined.as_mut().filter(|_| round < MOST_ROUNDS) {
            if round > 0 {
                change_partners(&around.faces, &vertices, partners);
            }
            split_fans(n_vertices, &mut around.faces, &vertices, Some(partners), copies);
            if copies.len() == n_before {
                join_bodies(n_vertices + n_before, &around, &vertices, partners);
                split_fans(n_vertices, &mut around.faces, &vertices, Some(partners), copies);
            }
        }
        if copies.len() == n_before {
            split_fans(n_vertices, &mut around.faces, &vertices, None, copies);
        }
        vertices = around.find_meeting_sheets(first_new..(n_vertices + copies.len()) as u32);
        if vertices.is_empty() {
            break;
        }
    }
    around.numbers.iter().zip(&around.faces).for_each(|(&f, face)| faces[f as usize] = *face);
}

/// Joins the faces at one non-manifold edge per vertex so that those connected around the vertex become partners.
fn change_partners(faces: &[[u32; 3]], vertices: &[u32], partners: &mut Partners) {
    let mut is_chosen = FxHashSet::default();
    for corners in corners_at(faces, vertices).chunk_by(|a, b| a.0 == b.0) {
        let spokes = spokes(faces, corners);
        let halves = spokes.chunk_by(|a, b| a.0 == b.0).filter(|spoke| spoke.len() > 2);
        let mut halves = halves.map(|spoke| halves_over(faces, corners, spoke));
        // Changes one edge per vertex; the next round sees the effect on the others.
        let Some(halves) = halves.find(|halves| halves.iter().all(|(half, _)| !is_chosen.contains(half))) else {
            continue;
        };
        for (half, _) in &halves {
            partners.remove(half);
        }
        let mut fans = join_fans(faces, corners, partners);
        let mut by_fan: Vec<(u32, u32)> = halves.iter().map(|&(half, i)| (fans.find(i), half)).collect();
        by_fan.sort_unstable();
        for pair in by_fan.chunks_exact(2) {
            partners.extend([(pair[0].1, pair[1].1), (pair[1].1, pair[0].1)]);
        }
        is_chosen.extend(halves.into_iter().map(|(half, _)| half));
    }
}

/// Joins the faces at edges with more than two faces: first those of one body, then the rest.
fn join_bodies(n_vertices: usize, around: &Surroundings, vertices: &[u32], partners: &mut Partners) {
    let (faces, cluster) = (&around.faces, |face: u32| around.clusters[face as usize]);
    let mut bodies = UnionFind::new(around.n_clusters);
    for_each_edge(n_vertices, faces, |_, half_edges| {
        if let &[g, h] = half_edges {
            bodies.union(cluster(g.face()), cluster(h.face()));
        }
    });
    for corners in corners_at(faces, vertices).chunk_by(|a, b| a.0 == b.0) {
        for spoke in spokes(faces, corners).chunk_by(|a, b| a.0 == b.0).filter(|spoke| spoke.len() > 2) {
            let halves = halves_over(faces, corners, spoke);
            let body_of =
                |&(half, _): &(u32, u32)| (bodies.find(cluster(half / 3)), start(faces, half) == corners[0].0, half);
            let mut halves: Vec<(u32, bool, u32)> = halves.iter().map(body_of).collect();
            halves.sort_unstable();
            let mut pairs = Vec::new();
            let mut left = Vec::new();
            for body in halves.chunk_by(|a, b| a.0 == b.0) {
                let (here, there) = body.split_at(body.partition_point(|half| !half.1));
                pairs.extend(here.iter().zip(there).map(|(g, h)| [g.2, h.2]));
                let longer = if here.len() > there.len() { here } else { there };
                left.extend(longer[here.len().min(there.len())..].iter().map(|half| half.2));
            }
            pairs.extend(left.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
            for (_, _, half) in &halves {
                partners.remove(half);
            }
            partners.extend(pairs.into_iter().flat_map(|[g, h]| [(g, h), (h, g)]));
        }
    }
}

/// Gives every fan at a vertex, except the first, a copy of the vertex.
fn split_fans(
    n_vertices: usize,
    faces: &mut [[u32; 3]],
    vertices: &[u32],
    partners: Option<&Partners>,
    copies: &mut Vec<u32>,
) {
    let mut moved = Vec::new();
    for corners in corners_at(faces, vertices).chunk_by(|a, b| a.0 == b.0) {
        let mut fans = match partners {
            Some(partners) => join_fans(faces, corners, partners),
            None => separate_fans(faces, corners),
        };
        let mut vertex_of = vec![0; corners.len()];
        for (i, &(vertex, corner)) in corners.iter().enumerate() {
            let first = fans.find(i as u32) as usize;
            vertex_of[i] = if first < i { vertex_of[first] } else { vertex };
            if first == i && i > 0 {
                vertex_of[i] = (n_vertices + copies.len()) as u32;
                copies.push((vertex as usize).checked_sub(n_vertices).map_or(vertex, |copy| copies[copy]));
            }
            moved.push((corner, vertex_of[i]));
        }
    }
    for (corner, vertex) in moved {
        faces.as_flattened_mut()[corner as usize] = vertex;
    }
}

/// Joins a vertex's corners over edges with two faces; joins none if that would make one fan.
fn separate_fans(faces: &[[u32; 3]], corners: &[(u32, u32)]) -> UnionFind {
    let fans = join_fans(faces, corners, &Partners::default());
    if fans.n_sets() > 1 { fans } else { UnionFind::new(corners.len()) }
}

fn join_fans(faces: &[[u32; 3]], corners: &[(u32, u32)], partners: &Partners) -> UnionFind {
    let mut fans = UnionFind::new(corners.len());
    for spoke in spokes(faces, corners).chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, i), (_, j)] = spoke {
            fans.union(i, j);
            continue;
        }
        let halves = halves_over(faces, corners, spoke);
        for &(half, i) in &halves {
            let place =
                partners.get(&half).and_then(|partner| halves.binary_search_by_key(partner, |&(half, _)| half).ok());
            if let Some(place) = place {
                fans.union(i, halves[place].1);
            }
        }
    }
    fans
}

fn spokes(faces: &[[u32; 3]], corners: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let others = |&(vertex, corner): &(u32, u32)| faces[corner as usize / 3].into_iter().filter(move |&w| w != vertex);
    let mut spokes: Vec<(u32, u32)> =
        corners.iter().zip(0..).flat_map(|(corner, i)| others(corner).map(move |w| (w, i))).collect();
    spokes.sort_unstable();
    spokes
}

fn halves_over(faces: &[[u32; 3]], corners: &[(u32, u32)], spoke: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let half = |&(neighbour, i): &(u32, u32)| (half_edge(faces, corners[i as usize].1, neighbour), i);
    let mut halves: Vec<(u32, u32)> = spoke.iter().map(half).collect();
    halves.sort_unstable();
    halves
}

fn half_edge(faces: &[[u32; 3]], corner: u32, other: u32) -> u32 {
    if start(faces, next(corner)) == other { corner } else { next(next(corner)) }
}

/// Reverses the minority of faces in each component; returns the number reversed.
fn orient(n_vertices: usize, faces: &mut [[u32; 3]]) -> usize {
    let twins = twins(n_vertices, faces);
    let mut side = vec![None; faces.len()];
    let mut turned = 0;
    for seed in 0..faces.len() {
        if side[seed].is_some() {
            continue;
        }
        side[seed] = Some(false);
        let component = spread_winding(vec![seed as u32], faces, &twins, &mut side);
        let opposed = component.iter().filter(|&&f| side[f as usize] == Some(true)).count();
        let minority = 2 * opposed <= component.len();
        for &f in &component {
            if side[f as usize] == Some(minority) {
                faces[f as usize].swap(1, 2);
                turned += 1;
            }
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};
    use std::collections::BTreeSet;

    #[test]
    fn tetrahedra_that_share_an_edge_come_apart_closed() {
        let a = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let b = a.map(|f| f.map(|v| if v < 2 { v } else { v + 2 }));
        let faces = [a, b].concat();
        let manifold = manifold(&[[0.0; 3]; 6], &faces);
        assert_eq!(manifold.copies.len(), 2);
        assert_eq!(manifold.rings.n_ghosts(), 0);
        assert!(manifold.rings.is_oriented());
    }

    #[test]
    fn a_single_turned_face_is_turned_back() {
        let faces = vec![[0, 2, 1], [0, 3, 1], [1, 2, 3], [2, 0, 3]];
        let manifold = manifold(&[[0.0; 3]; 4], &faces);
        assert_eq!(manifold.turned_faces, 1);
        assert!(manifold.rings.is_oriented());
        assert_eq!(manifold.faces[0], [0, 2, 1]);
    }

    #[test]
    fn of_three_sheets_on_an_edge_the_two_that_go_on_stay_joined() {
        let positions = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
        let faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        let manifold = manifold(&positions, &faces);
        assert_eq!((manifold.copies.as_slice(), manifold.rings.n_ghosts()), (&[0, 1][..], 2));
        assert_eq!(manifold.faces[1], [6, 5, 3]);
    }

    #[test]
    fn a_book_of_thousands_of_pages_comes_apart() {
        let n = 40_000;
        let tips = (0..n).map(|i| (i as f32).sin_cos()).map(|(y, x)| [x, y, 0.5]);
        let positions: Vec<[f32; 3]> = [[0.0; 3], [0.0, 0.0, 1.0]].into_iter().chain(tips).collect();
        let faces: Vec<[u32; 3]> = (2..n + 2).map(|tip| [0, 1, tip]).collect();
        let manifold = manifold(&positions, &faces);
        assert_eq!((manifold.rings.n_ghosts(), manifold.faces.len()), (n as usize / 2, n as usize));
    }

    #[test]
    fn boxes_that_share_an_edge_come_apart_closed() {
        let (positions, faces) = voxels(&std::array::from_fn::<bool, 64, _>(|at| [0, 5].contains(&at)));
        assert_eq!(faces.iter().flatten().collect::<BTreeSet<_>>().len(), 14);
        let manifold = manifold(&positions, &faces);
        assert_eq!((manifold.copies.len(), manifold.rings.n_ghosts(), manifold.turned_faces), (2, 0, 0));
    }

    #[test]
    fn random_voxels_come_apart_closed() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
        for round in 0..200 {
            let is_full: Vec<bool> = (0..64).map(|_| rng.next_u32() % 5 < 1 + round % 4).collect();
            let (positions, faces) = voxels(&is_full);
            let manifold = manifold(&positions, &faces);
            assert_eq!((manifold.rings.n_ghosts(), manifold.turned_faces), (0, 0), "round {round}");
            assert!(manifold.rings.is_oriented());
        }
    }

    #[test]
    fn flat_bodies_in_a_row_come_apart_closed() {
        let positions: Vec<[f32; 3]> = [[0, -1], [0, 0], [1, -1], [1, 0], [0, 1], [1, 1], [2, 0], [2, 1]]
            .map(|p| [p[0] as f32, p[1] as f32, 0.0])
            .into();
        let faces = [
            [[1, 3, 2], [1, 2, 0], [0, 2, 3], [0, 3, 1]],
            [[4, 5, 3], [4, 3, 1], [1, 3, 5], [1, 5, 4]],
            [[5, 7, 6], [5, 6, 3], [3, 6, 7], [3, 7, 5]],
        ];
        let manifold = manifold(&positions, faces.as_flattened());
        assert_eq!((manifold.rings.n_ghosts(), manifold.turned_faces, manifold.copies.len()), (0, 0, 4));
    }

    fn voxels(is_full: &[bool]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let full =
            |at: [i32; 3]| at.iter().all(|x| (0..4).contains(x)) && is_full[(at[0] + 4 * at[1] + 16 * at[2]) as usize];
        let vertex = |at: [i32; 3]| (at[0] + 5 * at[1] + 25 * at[2]) as u32;
        let mut faces = Vec::new();
        for at in (0..64).map(|i| [i % 4, i / 4 % 4, i / 16]).filter(|&at| full(at)) {
            for (axis, up) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
                let mut beside = at;
                beside[axis] += 2 * up - 1;
                if full(beside) {
                    continue;
                }
                let corner = |[u, v]: [i32; 2]| {
                    let mut corner = at;
                    corner[axis] += up;
                    corner[(axis + 1) % 3] += u;
                    corner[(axis + 2) % 3] += v;
                    vertex(corner)
                };
                let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(corner);
                if up == 0 {
                    quad.reverse();
                }
                faces.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
            }
        }
        let positions = (0..125).map(|i| [i % 5, i / 5 % 5, i / 25].map(|x| x as f32)).collect();
        (positions, faces)
    }

    #[test]
    fn a_moebius_strip_stays_joined_and_is_said_to_have_one_side() {
        let faces: Vec<[u32; 3]> = (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
        let manifold = manifold(&[[0.0; 3]; 5], &faces);
        assert!(manifold.copies.is_empty());
        assert!(!manifold.rings.is_oriented());
    }

    #[test]
    fn a_manifold_is_borrowed_unchanged() {
        let mesh = shapes::torus(9, 7, 3.0, 1.0);
        assert!(matches!(manifold(mesh.positions(), mesh.faces()).faces, Cow::Borrowed(_)));
    }

    #[test]
    fn the_smaller_part_of_each_component_is_turned() {
        let mesh = shapes::many_boxes(3);
        let mut faces = mesh.faces().to_vec();
        let per_box = faces.len() / 3;
        (0..per_box / 3).for_each(|f| faces[f].swap(1, 2));
        (per_box..2 * per_box).for_each(|f| faces[f].swap(1, 2));
        (2 * per_box..3 * per_box - 2).for_each(|f| faces[f].swap(1, 2));
        let manifold = manifold(mesh.positions(), &faces);
        assert_eq!(manifold.turned_faces, per_box / 3 + 2);
        assert_eq!(manifold.faces[..per_box], mesh.faces()[..per_box]);
        assert!(manifold.rings.is_oriented() && manifold.copies.is_empty());
    }

    #[test]
    fn two_faces_back_to_back_come_apart() {
        let manifold = manifold(&[[0.0; 3]; 3], &[[0, 1, 2], [0, 2, 1]]);
        assert_eq!((manifold.copies.len(), manifold.rings.n_ghosts()), (3, 2));
    }

    #[test]
    fn any_soup_comes_apart_with_every_face_and_no_idle_vertex() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let positions: Vec<[f32; 3]> = (0..10).map(|i| [i % 2, i / 2 % 3, i / 6].map(|x| x as f32)).collect();
        for round in 0..200 {
            let n = 4 + round % 6;
            let mut vertex = || rng.next_u32() % n;
            let soup = (0..4 + round % 30).map(|_| [vertex(), vertex(), vertex()]);
            let soup: Vec<[u32; 3]> = soup.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
            let apart = manifold(&positions[..n as usize], &soup);
            let source = |v: u32| if v < n { v } else { apart.copies[(v - n) as usize] };
            for (face, original) in apart.faces.iter().zip(&soup) {
                let [mut sources, mut original] = [face.map(source), *original];
                sources.sort_unstable();
                original.sort_unstable();
                assert_eq!(sources, original);
            }
            let is_used = |faces: &[[u32; 3]], v: u32| faces.as_flattened().contains(&v);
            for v in 0..n + apart.copies.len() as u32 {
                assert_eq!(is_used(&apart.faces, v), is_used(&soup, source(v)), "vertex {v} of {soup:?}");
            }
        }
    }
}
