//! Any set of triangles as an oriented manifold: sheets that touch are taken apart, windings made to agree.
//!
//! Each vertex becomes as many vertices as it has fans of faces joined over edges with two faces; edges with
//! more than two faces become borders. Nothing moves and no face is lost.

use rustc_hash::FxHashMap;

use super::OneRings;
use super::union_find::UnionFind;

/// A manifold with the same faces as the input, its rings, and where its vertices come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifold {
    /// Faces, n_faces x 3, in the input's order; some wound the other way.
    pub faces: Vec<[u32; 3]>,
    /// Neighbours in order.
    pub rings: OneRings,
    /// For the vertices beyond the input's, the vertex each is a copy of.
    pub copies: Vec<u32>,
    /// Faces wound against the majority of their component, which were turned.
    pub turned_faces: usize,
}

/// Takes `faces` (n_faces x 3, distinct corners, indices below `n_vertices`) apart into a manifold.
///
/// A surface that has no two sides (a Klein bottle) stays joined; `rings.is_oriented()` then says so.
///
/// ```
/// // Two triangles that touch in vertex 0 alone.
/// let manifold = neural_mesh::mesh::manifold(5, vec![[0, 1, 2], [0, 3, 4]]);
/// assert_eq!(manifold.copies, [0]);
/// ```
pub fn manifold(n_vertices: usize, faces: Vec<[u32; 3]>) -> Manifold {
    match OneRings::new(n_vertices, &faces) {
        Ok(rings) if rings.is_oriented() => Manifold { faces, rings, copies: Vec::new(), turned_faces: 0 },
        _ => take_apart(n_vertices, faces),
    }
}

fn take_apart(n_vertices: usize, mut faces: Vec<[u32; 3]>) -> Manifold {
    let as_wound = joints(&faces);
    let turned_faces = orient(&mut faces, &as_wound);
    let joints = joints(&faces);
    let mut copies = split_fans(n_vertices, &mut faces, &joints);
    loop {
        match OneRings::new(n_vertices + copies.len(), &faces) {
            Ok(rings) => return Manifold { faces, rings, copies, turned_faces },
            Err(error) => separate_corners(n_vertices, &mut faces, &error.vertices, &mut copies),
        }
    }
}

/// Pairs of half-edges (3 x face + corner) over the edges that have exactly two faces, both orders.
fn joints(faces: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let mut halves: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            halves.push((a.min(b), a.max(b), (3 * f + i) as u32));
        }
    }
    halves.sort_unstable();
    let same_edge = halves.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
    same_edge.filter(|edge| edge.len() == 2).map(|edge| (edge[0].2, edge[1].2)).collect()
}

/// Turns faces so that neighbours over joints agree wherever they can, most faces staying; returns how many turned.
fn orient(faces: &mut [[u32; 3]], joints: &[(u32, u32)]) -> usize {
    let mut starts = vec![0u32; faces.len() + 2];
    for &(h, g) in joints {
        starts[h as usize / 3 + 2] += 1;
        starts[g as usize / 3 + 2] += 1;
    }
    for f in 2..starts.len() {
        starts[f] += starts[f - 1];
    }
    let mut neighbors = vec![(0u32, false); 2 * joints.len()];
    for &(h, g) in joints {
        let agree = faces[h as usize / 3][h as usize % 3] != faces[g as usize / 3][g as usize % 3];
        for (from, to) in [(h / 3, g / 3), (g / 3, h / 3)] {
            let slot = &mut starts[from as usize + 1];
            neighbors[*slot as usize] = (to, !agree);
            *slot += 1;
        }
    }
    let mut side = vec![None; faces.len()];
    let mut turned = 0;
    for seed in 0..faces.len() {
        if side[seed].is_some() {
            continue;
        }
        let component = spread_side(seed, &starts, &neighbors, &mut side);
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

/// Visits the faces joined to `seed` and notes for each whether it is wound against it.
fn spread_side(seed: usize, starts: &[u32], neighbors: &[(u32, bool)], side: &mut [Option<bool>]) -> Vec<u32> {
    side[seed] = Some(false);
    let mut component = vec![seed as u32];
    let mut next = 0;
    while next < component.len() {
        let f = component[next] as usize;
        next += 1;
        for &(g, opposed) in &neighbors[starts[f] as usize..starts[f + 1] as usize] {
            if side[g as usize].is_none() {
                side[g as usize] = side[f].map(|s| s != opposed);
                component.push(g);
            }
        }
    }
    component
}

/// Gives each fan of faces around a vertex a vertex of its own; returns what the new ones are copies of.
fn split_fans(n_vertices: usize, faces: &mut [[u32; 3]], joints: &[(u32, u32)]) -> Vec<u32> {
    let mut fans = UnionFind::new(3 * faces.len());
    for &(h, g) in joints {
        let (face_h, face_g) = (faces[h as usize / 3], faces[g as usize / 3]);
        let ends = [face_h[h as usize % 3], face_h[(h as usize + 1) % 3]];
        for end in ends {
            let corner = |f: u32, face: [u32; 3]| 3 * f + u32::from(face[1] == end) + 2 * u32::from(face[2] == end);
            fans.union(corner(h / 3, face_h), corner(g / 3, face_g));
        }
    }
    let mut first_fan = vec![u32::MAX; n_vertices];
    let mut copy_of_fan: FxHashMap<u32, u32> = FxHashMap::default();
    let mut copies = Vec::new();
    for corner in 0..3 * faces.len() as u32 {
        let root = fans.find(corner);
        let vertex = &mut faces[corner as usize / 3][corner as usize % 3];
        let owner = &mut first_fan[*vertex as usize];
        if *owner == u32::MAX {
            *owner = root;
        }
        if *owner != root {
            *vertex = *copy_of_fan.entry(root).or_insert_with(|| {
                copies.push(*vertex);
                (n_vertices + copies.len() - 1) as u32
            });
        }
    }
    copies
}

/// The last resort: every face at these vertices gets a corner of its own, the first one the vertex itself.
fn separate_corners(n_vertices: usize, faces: &mut [[u32; 3]], vertices: &[u32], copies: &mut Vec<u32>) {
    let mut is_taken = vec![false; vertices.len()];
    for corner in faces.as_flattened_mut() {
        let Ok(place) = vertices.binary_search(corner) else { continue };
        if std::mem::replace(&mut is_taken[place], true) {
            let source = if (*corner as usize) < n_vertices { *corner } else { copies[*corner as usize - n_vertices] };
            copies.push(source);
            *corner = (n_vertices + copies.len() - 1) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    #[test]
    fn tetrahedra_that_share_an_edge_come_apart_closed() {
        let a = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let b = a.map(|f| f.map(|v| if v < 2 { v } else { v + 2 }));
        let manifold = manifold(6, [a, b].concat());
        assert_eq!(manifold.copies.len(), 2);
        assert_eq!(manifold.rings.n_apexes(), 0);
        assert!(manifold.rings.is_oriented());
    }

    #[test]
    fn a_single_turned_face_is_turned_back() {
        let faces = vec![[0, 2, 1], [0, 3, 1], [1, 2, 3], [2, 0, 3]];
        let manifold = manifold(4, faces);
        assert_eq!(manifold.turned_faces, 1);
        assert!(manifold.rings.is_oriented());
        assert_eq!(manifold.faces[0], [0, 2, 1]);
    }

    #[test]
    fn three_sheets_on_an_edge_become_borders() {
        let manifold = manifold(5, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert_eq!(manifold.copies.len(), 4);
        assert_eq!(manifold.rings.n_apexes(), 3);
    }

    #[test]
    fn a_moebius_strip_stays_joined_and_is_said_to_have_one_side() {
        let faces: Vec<[u32; 3]> = (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
        let manifold = manifold(5, faces);
        assert!(manifold.copies.is_empty());
        assert!(!manifold.rings.is_oriented());
    }

    #[test]
    fn any_soup_comes_apart_with_every_face_and_no_idle_vertex() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for round in 0..200 {
            let n = 4 + round % 6;
            let mut vertex = || rng.next_u32() % n;
            let soup = (0..4 + round % 30).map(|_| [vertex(), vertex(), vertex()]);
            let soup: Vec<[u32; 3]> = soup.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
            let apart = manifold(n as usize, soup.clone());
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
