//! Independent judgements of meshes, by brute force: distances, boundaries, manifoldness, turned faces.

use std::collections::HashMap;

use super::meshes::TestMesh;
use crate::collapse::vector::Point64;

fn minus(a: Point64, b: Point64) -> Point64 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point64, b: Point64) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point64, b: Point64) -> Point64 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the squared distance between a point and a triangle, by its plane and its three sides.
pub(crate) fn squared_distance_to_triangle(p: Point64, t: [Point64; 3]) -> f64 {
    let n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    let side = |i: usize| {
        let (a, b) = (t[i], t[(i + 1) % 3]);
        let (e, d) = (minus(b, a), minus(p, a));
        let s = (dot(e, d) / dot(e, e).max(1e-300)).clamp(0.0, 1.0);
        let rest = minus(d, e.map(|x| x * s));
        dot(rest, rest)
    };
    let nearest_side = side(0).min(side(1)).min(side(2));
    let is_inside = (0..3).all(|i| dot(cross(minus(t[(i + 1) % 3], t[i]), minus(p, t[i])), n) >= 0.0);
    if is_inside && dot(n, n) > 0.0 { dot(n, minus(p, t[0])).powi(2) / dot(n, n) } else { nearest_side }
}

fn corners(mesh: &TestMesh, face: [u32; 3]) -> [Point64; 3] {
    face.map(|v| mesh.positions[v as usize].map(f64::from))
}

/// Returns the mean and largest distance of each mesh's vertices and face centers from the other mesh, the larger way.
pub(crate) fn distance(a: &TestMesh, b: &TestMesh) -> (f64, f64) {
    let (one, other) = (one_way(a, b), one_way(b, a));
    (one.0.max(other.0), one.1.max(other.1))
}

fn one_way(from: &TestMesh, to: &TestMesh) -> (f64, f64) {
    let triangles: Vec<[Point64; 3]> = to.faces.iter().map(|&face| corners(to, face)).collect();
    let centers = from.faces.iter().map(|&face| {
        let t = corners(from, face);
        [0, 1, 2].map(|k| (t[0][k] + t[1][k] + t[2][k]) / 3.0)
    });
    let points = from.positions.iter().map(|p| p.map(f64::from)).chain(centers);
    let (mut sum, mut most, mut n) = (0.0, 0.0f64, 0.0);
    for p in points {
        let squared = triangles.iter().map(|&t| squared_distance_to_triangle(p, t)).fold(f64::INFINITY, f64::min);
        sum += squared.sqrt();
        most = most.max(squared.sqrt());
        n += 1.0;
    }
    (sum / n, most)
}

/// How often each directed edge is used.
fn edges(mesh: &TestMesh) -> HashMap<(u32, u32), usize> {
    let mut edges = HashMap::new();
    for face in &mesh.faces {
        for i in 0..3 {
            *edges.entry((face[i], face[(i + 1) % 3])).or_default() += 1;
        }
    }
    edges
}

/// Returns how many edges have no partner in the other direction.
pub(crate) fn count_boundary_edges(mesh: &TestMesh) -> usize {
    let edges = edges(mesh);
    edges.iter().map(|(&(a, b), &n)| n.saturating_sub(edges.get(&(b, a)).copied().unwrap_or(0))).sum()
}

/// Returns whether every edge has at most one face per direction, and every vertex one chain of faces.
pub(crate) fn is_manifold(mesh: &TestMesh) -> bool {
    if edges(mesh).values().any(|&n| n > 1) {
        return false;
    }
    let mut wedges = vec![Vec::new(); mesh.positions.len()];
    for face in &mesh.faces {
        for i in 0..3 {
            wedges[face[i] as usize].push((face[(i + 1) % 3], face[(i + 2) % 3]));
        }
    }
    wedges.into_iter().all(|mut wedges| {
        let Some(start) =
            wedges.iter().position(|w| !wedges.iter().any(|x| x.1 == w.0)).or((!wedges.is_empty()).then_some(0))
        else {
            return true;
        };
        let mut end = wedges.swap_remove(start).1;
        while let Some(next) = wedges.iter().position(|w| w.0 == end) {
            end = wedges.swap_remove(next).1;
        }
        wedges.is_empty()
    })
}

/// Returns the volume between the faces and the origin.
pub(crate) fn volume(mesh: &TestMesh) -> f64 {
    mesh.faces.iter().map(|&face| corners(mesh, face)).map(|t| dot(t[0], cross(t[1], t[2])) / 6.0).sum()
}

/// Returns how many faces point against the nearest face of the original.
pub(crate) fn count_turned(mesh: &TestMesh, original: &TestMesh) -> usize {
    let normal = |t: [Point64; 3]| cross(minus(t[1], t[0]), minus(t[2], t[0]));
    let triangles: Vec<[Point64; 3]> = original.faces.iter().map(|&face| corners(original, face)).collect();
    let is_turned = |t: [Point64; 3]| {
        let center = [0, 1, 2].map(|k| (t[0][k] + t[1][k] + t[2][k]) / 3.0);
        let nearest = triangles.iter().min_by(|&&a, &&b| {
            squared_distance_to_triangle(center, a).total_cmp(&squared_distance_to_triangle(center, b))
        });
        nearest.is_some_and(|&nearest| dot(normal(t), normal(nearest)) < 0.0)
    };
    mesh.faces.iter().filter(|&&face| is_turned(corners(mesh, face))).count()
}
