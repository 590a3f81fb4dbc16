//! Building blocks of shapes.

use std::borrow::Borrow;

use crate::mesh::TriMesh;

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Join {
    /// Not joined: a boundary.
    Open,
    /// Joined in order.
    Round,
    /// Joined in reverse order.
    Twisted,
}

pub(super) fn build(positions: impl IntoIterator<Item = [f64; 3]>, faces: Vec<[u32; 3]>) -> TriMesh {
    let positions = positions.into_iter().map(|p| p.map(|x| x as f32)).collect();
    TriMesh::new(positions, faces).unwrap_or_default()
}

/// Builds a sheet of n_u x n_v quads; `point` maps u, v in 0..=1.
///
/// Only the u direction may be twisted. With u to the right and v up, faces are counter-clockwise.
pub(super) fn sheet(n: [u32; 2], joins: [Join; 2], point: impl Fn(f64, f64) -> [f64; 3]) -> TriMesh {
    let rows = n.map(|n| n.max(3));
    let kept = [rows[0] + u32::from(joins[0] == Join::Open), rows[1] + u32::from(joins[1] == Join::Open)];
    let vertex = |i: u32, j: u32| {
        let over = i == rows[0] && joins[0] != Join::Open;
        let j = if over && joins[0] == Join::Twisted { rows[1] - j } else { j };
        let j = if j == rows[1] && joins[1] != Join::Open { 0 } else { j };
        (if over { 0 } else { i }) * kept[1] + j
    };
    let divide = |i: u32, n: u32| f64::from(i) / f64::from(n);
    let places = (0..kept[0]).flat_map(|i| (0..kept[1]).map(move |j| (i, j)));
    let quads = (0..rows[0]).flat_map(|i| (0..rows[1]).map(move |j| (i, j)));
    let faces = quads.flat_map(|(i, j)| {
        quad([vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)], (i + j) % 2 == 0)
    });
    let faces = faces.collect();
    build(places.map(|(i, j)| point(divide(i, rows[0]), divide(j, rows[1]))), faces)
}

pub(super) fn quad([a, b, c, d]: [u32; 4], from_first: bool) -> [[u32; 3]; 2] {
    if from_first { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

/// Builds a closed tube through rings of equal length, counter-clockwise seen from the end.
pub(super) fn loft(rings: &[Vec<[f64; 3]>]) -> TriMesh {
    let n = rings.first().map_or(0, Vec::len) as u32;
    let mut faces = Vec::new();
    for ring in 0..(rings.len() as u32).saturating_sub(1) {
        for i in 0..n {
            let (a, b) = (ring * n + i, ring * n + (i + 1) % n);
            faces.extend(quad([a, b, b + n, a + n], (ring + i) % 2 == 0));
        }
    }
    let last = (rings.len() as u32).saturating_sub(1) * n;
    faces.extend(lid(n).map(|[a, b, c]| [a, c, b]));
    faces.extend(lid(n).map(|face| face.map(|v| v + last)));
    build(rings.iter().flatten().copied(), faces)
}

fn lid(n: u32) -> impl Iterator<Item = [u32; 3]> {
    (0..n.saturating_sub(2)).map(move |i| {
        let (low, high) = (i / 2, n - 1 - i / 2);
        if i % 2 == 0 { [low, low + 1, high] } else { [low + 1, high - 1, high] }
    })
}

/// Joins meshes, with all vertices and faces in order.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::shapes;
/// let ball = shapes::icosphere(0);
/// let both = shapes::unite([&ball, &shapes::place(&ball, |[x, y, z]| [x + 3.0, y, z])]);
/// assert_eq!((both.positions().len(), both.faces()[20]), (24, ball.faces()[0].map(|v| v + 12)));
/// ```
pub fn unite(meshes: impl IntoIterator<Item = impl Borrow<TriMesh>>) -> TriMesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for mesh in meshes {
        let mesh = mesh.borrow();
        let shift = positions.len() as u32;
        positions.extend_from_slice(mesh.positions());
        faces.extend(mesh.faces().iter().map(|face| face.map(|v| v + shift)));
    }
    TriMesh::new(positions, faces).unwrap_or_default()
}

/// Moves each vertex of a mesh.
pub fn place(mesh: &TriMesh, to: impl Fn([f32; 3]) -> [f32; 3]) -> TriMesh {
    TriMesh::new(mesh.positions().iter().map(|&p| to(p)).collect(), mesh.faces().to_vec()).unwrap_or_default()
}

pub(super) fn map_points(mesh: &TriMesh, mirrored: bool, to: impl Fn([f64; 3]) -> [f64; 3]) -> TriMesh {
    let turn = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    let faces = mesh.faces().iter().map(turn).collect();
    build(mesh.positions().iter().map(|p| to(p.map(f64::from))), faces)
}
