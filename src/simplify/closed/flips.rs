//! Flips: where the other diagonal of two faces lies nearer to the original surface, it takes the edge's place.
//!
//! The regions know which part of the original lies below an output vertex, so that the nearest point of the original
//! is found by walking there over its edges, without a search structure. Borders stay, and so does every edge whose
//! other diagonal exists already or would turn a face over: the surface stays what it is.

use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::geometry::triangle::{area_normal, nearest_point};

use super::collapse::Remains;
use super::surface::Surface;

/// Squared distance of the other diagonal over that of the edge below which a flip pays.
const GAIN: f32 = 0.6;
/// Least cosine between the faces' normals before and after.
const LEAST_COSINE: f32 = 0.5;
/// Cosine between the two faces above which their diagonals hardly differ.
const FLAT: f32 = 0.998;
/// Where on the diagonals distances are measured.
const PLACES: [f32; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// An edge over which two faces meet: their corners `a b c` and `b a d`.
struct Diamond {
    faces: [u32; 2],
    corners: [u32; 4],
    gain: f32,
}

/// Flips edges of `faces`, best gains first, each face once; returns how many were flipped.
///
/// `vertex_of` (one per input vertex) names the output vertex that its region became.
pub(super) fn flip(surface: &Surface, vertex_of: &[u32], remains: &mut Remains) -> usize {
    let Remains { positions, faces, normals, .. } = remains;
    let anchors = anchors(surface, positions, vertex_of);
    let diamonds = diamonds(faces);
    let all_edges = faces.iter().flat_map(|&[a, b, c]| [edge(a, b), edge(b, c), edge(c, a)]);
    let mut edges: FxHashSet<[u32; 2]> = all_edges.collect();
    let rate = |diamond: Diamond| {
        let meant = diamond.faces.map(|f| normals[f as usize]);
        let gain = gain(surface, positions, &anchors, diamond.corners, meant)?;
        Some(Diamond { gain, ..diamond })
    };
    let mut worthwhile: Vec<Diamond> = diamonds.into_par_iter().filter_map(rate).collect();
    worthwhile.sort_by(|x, y| y.gain.total_cmp(&x.gain).then(x.faces.cmp(&y.faces)));
    let mut touched = vec![false; faces.len()];
    let mut n_flipped = 0;
    for Diamond { faces: [f, g], corners: [a, b, c, d], .. } in worthwhile {
        let (f, g) = (f as usize, g as usize);
        if !touched[f] && !touched[g] && edges.insert(edge(c, d)) {
            (faces[f], faces[g]) = ([c, d, b], [d, c, a]);
            normals[f] = (normals[f] + normals[g]).normalize_or_zero();
            normals[g] = normals[f];
            (touched[f], touched[g]) = (true, true);
            n_flipped += 1;
        }
    }
    n_flipped
}

fn edge(u: u32, v: u32) -> [u32; 2] {
    [u.min(v), u.max(v)]
}

/// For each output vertex the input vertex of its region that lies nearest to it.
pub(super) fn anchors(surface: &Surface, positions: &[Vec3], vertex_of: &[u32]) -> Vec<u32> {
    let mut best = vec![(f32::INFINITY, 0); positions.len()];
    for (v, &output) in vertex_of.iter().enumerate() {
        let distance = surface.positions[v].distance_squared(positions[output as usize]);
        if distance < best[output as usize].0 {
            best[output as usize] = (distance, v as u32);
        }
    }
    best.into_iter().map(|(_, v)| v).collect()
}

/// The pairs of consistently wound faces that share an edge.
fn diamonds(faces: &[[u32; 3]]) -> Vec<Diamond> {
    let sides = |(f, &[a, b, c]): (usize, &[u32; 3])| [(a, b, c), (b, c, a), (c, a, b)].map(|side| (f as u32, side));
    let mut sides: Vec<(u32, (u32, u32, u32))> = faces.iter().enumerate().flat_map(sides).collect();
    sides.sort_unstable_by_key(|&(f, (a, b, _))| (edge(a, b), f));
    let pair = |w: &[(u32, (u32, u32, u32))]| {
        let [(f, (a, b, c)), (g, (p, q, d))] = [w[0], w[1]];
        (a == q && b == p).then_some(Diamond { faces: [f, g], corners: [a, b, c, d], gain: 0.0 })
    };
    sides.windows(2).filter_map(pair).collect()
}

/// How much nearer to the original the other diagonal lies (sum of squares), if that is enough.
fn gain(surface: &Surface, positions: &[Vec3], anchors: &[u32], corners: [u32; 4], meant: [Vec3; 2]) -> Option<f32> {
    let [a, b, c, d] = corners.map(|v| positions[v as usize]);
    let old = [area_normal([a, b, c]), area_normal([b, a, d])];
    let new = [area_normal([c, d, b]), area_normal([d, c, a])];
    if old[0].dot(old[1]) > FLAT * old[0].length() * old[1].length() {
        return None;
    }
    let like = |n: &Vec3, m: &Vec3| n.dot(*m) > LEAST_COSINE * n.length() * m.length();
    let allowed = new.iter().all(|n| old.iter().chain(&meant).all(|m| like(n, m)));
    if !allowed {
        return None;
    }
    let error = |p: Vec3, q: Vec3, starts: [u32; 2]| -> f32 {
        PLACES.iter().map(|&t| distance_squared(surface, p + (q - p) * t, starts[usize::from(t > 0.5)])).sum()
    };
    let before = error(a, b, [anchors[corners[0] as usize], anchors[corners[1] as usize]]);
    let after = error(c, d, [anchors[corners[2] as usize], anchors[corners[3] as usize]]);
    (after < GAIN * before).then_some(before - after)
}

/// The vertex of the original, and its squared distance, at which a walk toward `point` ends that begins at `start`.
pub(super) fn nearest_vertex(surface: &Surface, point: Vec3, start: u32) -> (u32, f32) {
    let mut v = start;
    let mut least = surface.positions[v as usize].distance_squared(point);
    loop {
        let before = v;
        for &w in surface.neighbors(v) {
            let distance = surface.positions[w as usize].distance_squared(point);
            if distance < least {
                (v, least) = (w, distance);
            }
        }
        if v == before {
            return (v, least);
        }
    }
}

/// Squared distance from `point` to the original, near where a walk from vertex `start` ends.
pub(super) fn distance_squared(surface: &Surface, point: Vec3, start: u32) -> f32 {
    let (v, mut least) = nearest_vertex(surface, point, start);
    let here = surface.positions[v as usize];
    let ring = surface.neighbors(v);
    let closing = if surface.rings.apex(v).is_none() { ring.len() } else { ring.len() - 1 };
    for i in 0..closing {
        let (p, q) = (surface.positions[ring[i] as usize], surface.positions[ring[(i + 1) % ring.len()] as usize]);
        least = least.min(nearest_point(point, [here, p, q]).distance_squared(point));
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};

    /// A gentle roof with its ridge along y, 16 x 16 quads: vertex 17 i + j at x = i / 16, y = j / 16.
    fn roof() -> Surface {
        let flat = shapes::grid(16, 16);
        let places = flat.positions().iter().map(|&[x, y, _]| [x, y, -0.5 * (x - 0.5).abs()]).collect();
        Surface::new(&TriMesh::new(places, flat.faces().to_vec()).unwrap())
    }

    /// Two faces over a diagonal: the corners are vertices of the roof.
    fn two_faces(surface: &Surface, corners: [u32; 4]) -> (Vec<u32>, Remains) {
        let positions = corners.map(|v| surface.positions[v as usize]).to_vec();
        let nearest = |p: &Vec3| {
            let distance = |&v: &usize| positions[v].distance_squared(*p);
            (0..4).min_by(|x, y| distance(x).total_cmp(&distance(y))).unwrap() as u32
        };
        let vertex_of: Vec<u32> = surface.positions.iter().map(nearest).collect();
        let faces = vec![[0, 1, 2], [1, 0, 3]];
        let normals = faces.iter().map(|f: &[u32; 3]| area_normal(f.map(|v| positions[v as usize])).normalize());
        let normals = normals.collect();
        (vertex_of.clone(), Remains { positions, faces, normals, vertex_of })
    }

    #[test]
    fn a_diagonal_across_the_ridge_turns_to_run_along_it() {
        let surface = roof();
        let [left, right, back, front] = [8, 17 * 16 + 8, 17 * 8 + 16, 17 * 8];
        let (vertex_of, mut remains) = two_faces(&surface, [left, right, back, front]);
        assert_eq!(flip(&surface, &vertex_of, &mut remains), 1);
        assert_eq!(remains.faces, [[2, 3, 1], [3, 2, 0]]);
        let mut again = two_faces(&surface, [front, back, left, right]);
        assert_eq!(flip(&surface, &again.0, &mut again.1), 0);
    }

    #[test]
    fn a_diagonal_that_exists_is_not_made_twice() {
        let surface = roof();
        let (vertex_of, mut remains) = two_faces(&surface, [8, 17 * 16 + 8, 17 * 8 + 16, 17 * 8]);
        remains.positions.push(surface.positions[17 * 4]);
        remains.faces.push([2, 3, 4]);
        remains.normals.push(Vec3::Z);
        assert_eq!(flip(&surface, &vertex_of, &mut remains), 0);
    }

    #[test]
    fn distances_are_those_of_the_naive_search() {
        let surface = Surface::new(&shapes::wavy_sphere(3, 4.0));
        for v in (0..surface.n_vertices() as u32).step_by(37) {
            let point = surface.positions[v as usize] + 0.002 * surface.normals[v as usize];
            let corners = surface.faces.iter().map(|f| f.map(|v| surface.positions[v as usize]));
            let naive = corners.map(|c| nearest_point(point, c).distance_squared(point)).fold(f32::INFINITY, f32::min);
            let start = surface.neighbors(v)[0];
            assert!((distance_squared(&surface, point, start) - naive).abs() <= 1e-3 * naive);
        }
    }
}
