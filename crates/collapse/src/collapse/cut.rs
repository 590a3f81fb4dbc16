//! Vertices that are no disk, cut into copies: one per chain of faces, so that all rings are disks.
//!
//! ```text
//!    \ | /                  \ | /         two fans meet at one vertex,
//!     \|/                    \|/          or more than two faces at one edge:
//!      v        cut          v0
//!     /|\      ---->         v1           each chain of faces gets its own copy;
//!    / | \                   /|\          copies keep the position
//! ```
//!
//! At an edge of more than two faces each face is joined to the one opposite in direction that comes first when turning
//! around the edge through its inner side. What that cannot make a disk is cut along all such edges, and its copies are
//! one vertex again in the result, which is then as closed as the input.

use std::collections::HashMap;

use crate::collapse::build::is_face;
use crate::collapse::roots::find_root;
use crate::collapse::vector::{Point, cross, dot, subtract};

/// The faces of a mesh whose bad vertices are cut, and whose copies they are.
#[derive(Clone)]
pub(crate) struct Cuts {
    pub faces: Vec<[u32; 3]>,
    /// The input vertex of each vertex; longer than the input by the copies.
    pub originals: Vec<u32>,
    /// The vertex of each in the result: itself, or that of the first copy.
    pub joined: Vec<u32>,
    /// All vertices that were cut, and their copies.
    pub touched: Vec<u32>,
    n_rounds: usize,
}

/// A corner of a face at a bad vertex.
#[derive(Clone, Copy)]
struct Corner {
    face: usize,
    place: usize,
    next: u32,
    previous: u32,
}

impl Cuts {
    pub(crate) fn new(faces: &[[u32; 3]], n_vertices: usize) -> Cuts {
        let all = || (0..n_vertices as u32).collect();
        Cuts { faces: faces.to_vec(), originals: all(), joined: all(), touched: Vec::new(), n_rounds: 0 }
    }

    /// Cuts the given vertices; in the first round faces at crowded edges are joined in pairs.
    pub(crate) fn cut(&mut self, no_disks: &[u32], positions: &[Point]) {
        let corners = self.gather_corners(no_disks);
        let is_paired = self.n_rounds == 0;
        self.n_rounds += 1;
        let pairs = if is_paired { self.pair_faces(&corners, positions) } else { HashMap::new() };
        self.touched.extend(no_disks);
        for (&vertex, corners) in no_disks.iter().zip(&corners) {
            let groups = group_corners(vertex, corners, &pairs);
            let mut names = HashMap::new();
            for (corner, group) in corners.iter().zip(groups) {
                let n_named = names.len();
                let name = *names
                    .entry(group)
                    .or_insert_with(|| if n_named == 0 { vertex } else { self.add_copy(vertex, is_paired) });
                self.faces[corner.face][corner.place] = name;
            }
        }
    }

    fn add_copy(&mut self, vertex: u32, is_apart: bool) -> u32 {
        let copy = self.originals.len() as u32;
        self.originals.push(self.originals[vertex as usize]);
        self.joined.push(if is_apart { copy } else { self.joined[vertex as usize] });
        self.touched.push(copy);
        copy
    }

    fn gather_corners(&self, no_disks: &[u32]) -> Vec<Vec<Corner>> {
        let rows: HashMap<u32, usize> = no_disks.iter().enumerate().map(|(row, &vertex)| (vertex, row)).collect();
        let mut corners = vec![Vec::new(); no_disks.len()];
        for (face, ends) in self.faces.iter().enumerate().filter(|(_, face)| is_face(face)) {
            for place in 0..3 {
                if let Some(&row) = rows.get(&ends[place]) {
                    let (next, previous) = (ends[(place + 1) % 3], ends[(place + 2) % 3]);
                    corners[row].push(Corner { face, place, next, previous });
                }
            }
        }
        corners
    }

    // The partner of each face at each crowded edge, by the edge's ends in the face's direction.
    fn pair_faces(&self, corners: &[Vec<Corner>], positions: &[Point]) -> HashMap<(u32, u32, usize), usize> {
        // Both directions of each edge at a bad vertex, once per face.
        let mut edges: HashMap<(u32, u32), [Vec<usize>; 2]> = HashMap::new();
        let mut faces: Vec<usize> = corners.iter().flatten().map(|corner| corner.face).collect();
        faces.sort_unstable();
        faces.dedup();
        for face in faces {
            let ends = self.faces[face];
            for i in 0..3 {
                let (a, b) = (ends[i], ends[(i + 1) % 3]);
                edges.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)].push(face);
            }
        }
        let mut pairs = HashMap::new();
        for ((a, b), [forward, backward]) in edges {
            if forward.len() < 2 || forward.len() != backward.len() {
                continue;
            }
            for (one, other) in self.match_around(a, b, &forward, &backward, positions) {
                pairs.insert((a, b, one), other);
                pairs.insert((b, a, other), one);
            }
        }
        pairs
    }

    // Matches faces along a to b with those along b to a: each with the first one behind it, on its inner side.
    fn match_around(
        &self,
        a: u32,
        b: u32,
        forward: &[usize],
        backward: &[usize],
        positions: &[Point],
    ) -> Vec<(usize, usize)> {
        let point = |v: u32| positions[self.originals[v as usize] as usize];
        let axis = subtract(point(b), point(a));
        let tip = |face: usize| self.faces[face].into_iter().find(|&v| v != a && v != b).unwrap_or(a);
        let across = subtract(point(tip(forward[0])), point(a));
        let side = cross(axis, across);
        let up = cross(side, axis);
        let length = dot(axis, axis).sqrt();
        let angle = |face: usize| {
            let d = subtract(point(tip(face)), point(a));
            f64::from(dot(d, side) * length).atan2(f64::from(dot(d, up)))
        };
        let mut all: Vec<(f64, bool, usize)> = forward.iter().map(|&face| (angle(face), true, face)).collect();
        all.extend(backward.iter().map(|&face| (angle(face), false, face)));
        all.sort_by(|x, y| x.partial_cmp(y).unwrap_or(std::cmp::Ordering::Equal));
        // A face along the axis has its inner side towards smaller angles: brackets, matched twice around.
        let (mut open, mut matched) = (Vec::new(), Vec::new());
        for &(_, is_forward, face) in all.iter().rev().chain(all.iter().rev()) {
            if is_forward {
                open.push(face);
            } else if let Some(one) = open.pop() {
                matched.push((one, face));
            }
        }
        // Keep the first match of each face, both ways.
        let (mut ones, mut others) = (std::collections::HashSet::new(), std::collections::HashSet::new());
        matched.retain(|&(one, other)| {
            !ones.contains(&one) && !others.contains(&other) && ones.insert(one) && others.insert(other)
        });
        matched
    }
}

// A number per corner, equal for corners in one chain of faces around the vertex.
fn group_corners(vertex: u32, corners: &[Corner], pairs: &HashMap<(u32, u32, usize), usize>) -> Vec<u32> {
    let mut groups: Vec<u32> = (0..corners.len() as u32).collect();
    let mut by_next: HashMap<u32, Vec<usize>> = HashMap::new();
    let mut n_previous: HashMap<u32, usize> = HashMap::new();
    for (i, corner) in corners.iter().enumerate() {
        by_next.entry(corner.next).or_default().push(i);
        *n_previous.entry(corner.previous).or_default() += 1;
    }
    for a in 0..corners.len() {
        let end = corners[a].previous;
        let Some(others) = by_next.get(&end) else { continue };
        let is_plain = others.len() == 1 && n_previous[&end] == 1;
        // The face of `a` runs along end to vertex.
        let partner = pairs.get(&(end, vertex, corners[a].face));
        let next = others.iter().find(|&&b| is_plain || partner == Some(&corners[b].face));
        if let Some(&b) = next {
            let (one, other) = (find_root(&mut groups, a as u32), find_root(&mut groups, b as u32));
            groups[one.max(other) as usize] = one.min(other);
        }
    }
    (0..corners.len() as u32).map(|i| find_root(&mut groups, i)).collect()
}
