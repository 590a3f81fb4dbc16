//! Little named meshes.

use crate::collapse::build::{Built, build_rings};
use crate::collapse::rings::{Rings, Vertex};
use crate::collapse::team::Team;

#[derive(Clone, Debug, Default)]
pub(crate) struct TestMesh {
    pub positions: Vec<[f32; 3]>,
    pub faces: Vec<[u32; 3]>,
}

impl TestMesh {
    pub fn to_rings(&self) -> Rings {
        let vertices = self.positions.iter().enumerate().map(|(i, &p)| Vertex::new(p, i as u32)).collect();
        let ranks: Vec<u32> = (0..self.positions.len() as u32).collect();
        match build_rings(vertices, &self.faces, &ranks, Team::alone()) {
            Built::Rings(rings) => rings,
            Built::NoDisks(no_disks, _) => panic!("no disks: {no_disks:?}"),
        }
    }

    /// Adds another mesh to this one.
    pub fn join(mut self, other: TestMesh) -> TestMesh {
        let n = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.faces.extend(other.faces.iter().map(|face| face.map(|v| v + n)));
        self
    }

    pub fn move_by(mut self, by: [f32; 3]) -> TestMesh {
        self.positions.iter_mut().for_each(|p| *p = [p[0] + by[0], p[1] + by[1], p[2] + by[2]]);
        self
    }

    /// Makes vertices at equal positions one.
    pub fn weld(&self) -> TestMesh {
        let mut numbers = std::collections::HashMap::new();
        let mut out = TestMesh::default();
        for face in &self.faces {
            let face = face.map(|v| {
                let p = self.positions[v as usize];
                *numbers.entry(p.map(f32::to_bits)).or_insert_with(|| {
                    out.positions.push(p);
                    out.positions.len() as u32 - 1
                })
            });
            if face[0] != face[1] && face[1] != face[2] && face[2] != face[0] {
                out.faces.push(face);
            }
        }
        out
    }
}

/// A torus of `n` times `m` squares with waves on it; closed.
pub(crate) fn bumpy_torus(n: u32, m: u32) -> TestMesh {
    let mut mesh = TestMesh::default();
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (i as f32 / n as f32 * std::f32::consts::TAU, j as f32 / m as f32 * std::f32::consts::TAU);
            let r = 0.35 + 0.05 * (3.0 * a).sin() * (2.0 * b).cos();
            mesh.positions.push([(1.0 + r * b.cos()) * a.cos(), (1.0 + r * b.cos()) * a.sin(), r * b.sin()]);
            let number = |i: u32, j: u32| i % n * m + j % m;
            let [p, q, r, s] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            mesh.faces.extend([[p, q, r], [p, r, s]]);
        }
    }
    mesh
}

/// A height field of `n` times `n` squares; one boundary.
pub(crate) fn terrain(n: u32) -> TestMesh {
    let mut mesh = TestMesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (i as f32 / n as f32, j as f32 / n as f32);
            mesh.positions.push([x, y, 0.1 * (7.0 * x + 2.0).sin() * (5.0 * y).cos()]);
            if i < n && j < n {
                let p = i * (n + 1) + j;
                mesh.faces.extend([[p, p + n + 1, p + n + 2], [p, p + n + 2, p + 1]]);
            }
        }
    }
    mesh
}

/// An open cone: one vertex with `n` neighbours inside, and a boundary.
pub(crate) fn cone(n: u32) -> TestMesh {
    let mut mesh = TestMesh { positions: vec![[0.0, 0.0, 1.0]], faces: Vec::new() };
    for i in 0..n {
        let angle = i as f32 / n as f32 * std::f32::consts::TAU;
        mesh.positions.push([angle.cos(), angle.sin(), 0.0]);
        mesh.faces.push([0, 1 + i, 1 + (i + 1) % n]);
    }
    mesh
}

/// Two cones of `n` faces base to base: two vertices of any degree; closed.
pub(crate) fn double_cone(n: u32) -> TestMesh {
    let mut mesh = cone(n);
    mesh.positions.push([0.0, 0.0, -1.0]);
    mesh.faces.extend((0..n).map(|i| [n + 1, 1 + (i + 1) % n, 1 + i]));
    mesh
}

/// A box with `n` times `n` squares on each side; closed, with vertices of one position made one.
pub(crate) fn box_of_squares(n: u32) -> TestMesh {
    let mut mesh = TestMesh::default();
    for side in 0..6 {
        let (axis, is_high) = (side / 2, side % 2 == 1);
        let start = mesh.positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let mut p = [0.0; 3];
                p[axis] = f32::from(u8::from(is_high));
                p[(axis + 1) % 3] = i as f32 / n as f32;
                p[(axis + 2) % 3] = j as f32 / n as f32;
                mesh.positions.push(p);
                if i < n && j < n {
                    let p = start + i * (n + 1) + j;
                    let (q, r, s) = (p + n + 1, p + n + 2, p + 1);
                    let faces = if is_high { [[p, q, r], [p, r, s]] } else { [[p, r, q], [p, s, r]] };
                    mesh.faces.extend(faces);
                }
            }
        }
    }
    mesh.weld()
}

/// Both sides of a flat L of `n` times `n` squares without thickness, joined along the outline; closed.
pub(crate) fn sheet(n: u32) -> TestMesh {
    let is_inside = |i: u32, j: u32| i < n && j < n && (i < n / 2 || j < n / 2);
    let cells = |i: u32, j: u32| {
        [(i.wrapping_sub(1), j.wrapping_sub(1)), (i, j.wrapping_sub(1)), (i.wrapping_sub(1), j), (i, j)]
    };
    let mut mesh = TestMesh::default();
    let mut numbers = std::collections::HashMap::new();
    for is_top in [true, false] {
        let mut number = |i: u32, j: u32| {
            let is_rim = cells(i, j).into_iter().any(|(i, j)| !is_inside(i, j));
            let next = mesh.positions.len() as u32;
            *numbers.entry((i, j, is_top || is_rim)).or_insert_with(|| {
                mesh.positions.push([i as f32 / n as f32, j as f32 / n as f32, 0.0]);
                next
            })
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|&(i, j)| is_inside(i, j)) {
            let [p, q, r, s] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            // No face has all corners on the outline: both sides would have it.
            let faces = if i.abs_diff(j) + 1 == n { [[p, q, s], [q, r, s]] } else { [[p, q, r], [p, r, s]] };
            mesh.faces.extend(faces.map(|[a, b, c]| if is_top { [a, b, c] } else { [a, c, b] }));
        }
    }
    mesh
}
