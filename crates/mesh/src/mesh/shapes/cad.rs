//! Machine shapes.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::assemble::{build, loft, quad};
use crate::mesh::TriMesh;

/// Builds a plate of 2 x 1 x 0.1 with fillets of `radius` (below 0.05), in `n` segments per quarter turn.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// let mesh = neural_mesh::mesh::shapes::plate(8, 0.01);
/// assert!(mesh.faces().len() > 1000);
/// ```
pub fn plate(n: u32, radius: f64) -> TriMesh {
    let half = 0.05 - radius;
    let angle = |i: u32| FRAC_PI_2 * f64::from(i) / f64::from(n.max(1));
    let lower = (0..=n.max(1)).map(|i| (angle(i).sin(), -half - radius * angle(i).cos()));
    let upper = (0..=n.max(1)).rev().map(|i| (angle(i).sin(), half + radius * angle(i).cos()));
    let rings: Vec<_> = lower.chain(upper).map(|(out, z)| outline(n, radius * out, z, radius)).collect();
    loft(&rings)
}

fn outline(n: u32, out: f64, z: f64, radius: f64) -> Vec<[f64; 3]> {
    let corners = [(1.0, 0.5, 0.0), (-1.0, 0.5, 1.0), (-1.0, -0.5, 2.0), (1.0, -0.5, 3.0)];
    let turn = 3.0 * radius;
    let arc = |(x, y, quarter): (f64, f64, f64)| {
        (0..=n.max(1)).map(move |i| {
            let angle = FRAC_PI_2 * (quarter + f64::from(i) / f64::from(n.max(1)));
            let inset = |side: f64| side - side.signum() * (turn + radius);
            [inset(x) + (turn + out) * angle.cos(), inset(y) + (turn + out) * angle.sin(), z]
        })
    };
    corners.into_iter().flat_map(arc).collect()
}

/// Builds a bolt with a thread of `n` segments per turn.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// let mesh = neural_mesh::mesh::shapes::bolt(24);
/// assert!(mesh.faces().len() > 1000);
/// ```
pub fn bolt(n: u32) -> TriMesh {
    let n = n.max(6);
    let ring = |z: f64, radius: &dyn Fn(f64) -> f64| -> Vec<[f64; 3]> {
        let circle_point = |u: f64| [radius(u) * (TAU * u).cos(), radius(u) * (TAU * u).sin(), z];
        (0..n).map(|i| circle_point(f64::from(i) / f64::from(n))).collect()
    };
    let thread = (0..=96).map(|i| {
        let turns = f64::from(i) / 12.0;
        let fade = (turns.min(8.0 - turns)).min(1.0);
        ring(0.2 + 0.25 * turns, &move |u| 0.7 - 0.1 * fade * ridge(turns - u))
    });
    let shank = [ring(3.0, &|_| 0.7)];
    let head = [ring(3.0, &hexagon), ring(3.6, &hexagon)];
    let rings: Vec<_> = [ring(0.0, &|_| 0.6)].into_iter().chain(thread).chain(shank).chain(head).collect();
    loft(&rings)
}

fn ridge(phase: f64) -> f64 {
    let triangle = 2.0 * (phase - phase.floor() - 0.5).abs();
    ((triangle - 0.2) / 0.6).clamp(0.0, 1.0)
}

fn hexagon(u: f64) -> f64 {
    let within = (u * 6.0).fract() - 0.5;
    1.3 * (TAU / 12.0).cos() / (within * TAU / 6.0).cos()
}

/// Builds a wavy closed sheet: two sides of n x n quads, `thickness` apart.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// let mesh = neural_mesh::mesh::shapes::thin_sheet(10, 0.001);
/// assert_eq!(mesh.positions().len(), 242);
/// ```
pub fn thin_sheet(n: u32, thickness: f64) -> TriMesh {
    let n = n.max(1);
    let wave = |x: f64, y: f64| 0.05 * (TAU * x).sin() * (TAU * y).cos();
    let sheet_point = |i: u32, j: u32, lift: f64| {
        let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
        [x, y, wave(x, y) + lift]
    };
    let places = || (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
    let top = (n + 1) * (n + 1);
    let vertex = |i: u32, j: u32| i * (n + 1) + j;
    let mut faces = Vec::new();
    for (i, j) in places().filter(|&(i, j)| i < n && j < n) {
        let corners = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        let cut = quad(corners, (i + j) % 2 == 0);
        faces.extend(cut.map(|[a, b, c]| [a, c, b]));
        faces.extend(cut.map(|face| face.map(|v| v + top)));
    }
    for i in 0..n {
        let rims = [[(i, 0), (i + 1, 0)], [(n, i), (n, i + 1)], [(i + 1, n), (i, n)], [(0, i + 1), (0, i)]];
        for [a, b] in rims.map(|rim| rim.map(|(i, j)| vertex(i, j))) {
            faces.extend(quad([a, b, b + top, a + top], true));
        }
    }
    let both = places().map(|(i, j)| sheet_point(i, j, 0.0)).chain(places().map(|(i, j)| sheet_point(i, j, thickness)));
    build(both, faces)
}
