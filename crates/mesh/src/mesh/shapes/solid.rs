//! Closed shapes of one component.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::assemble::{Join, build, map_points, sheet};
use crate::mesh::{DistinctKeys, TriMesh};

/// Builds the corner of the unit cube.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::tetrahedron().faces().len(), 4);
/// ```
pub fn tetrahedron() -> TriMesh {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    build(corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
}

/// Builds a box from the origin to `size`, with n x n quads per side.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// let mesh = neural_mesh::mesh::shapes::cuboid([1.0, 1.0, 1.0], 2);
/// assert_eq!((mesh.positions().len(), mesh.faces().len()), (26, 48));
/// ```
pub fn cuboid(size: [f64; 3], n: u32) -> TriMesh {
    let n = n.max(1);
    let mut places = DistinctKeys::default();
    let mut vertex = |place: [u32; 3]| places.number(place);
    let mut faces = Vec::new();
    for (axis, far) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)] {
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let corner = |[i, j]: [u32; 2]| {
                let mut place = [if far { n } else { 0 }; 3];
                place[(axis + 1) % 3] = i;
                place[(axis + 2) % 3] = j;
                place
            };
            let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(corner).map(&mut vertex);
            faces.extend(if far { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    let point = |place: [u32; 3]| std::array::from_fn(|k| size[k] * f64::from(place[k]) / f64::from(n));
    build(places.keys.into_iter().map(point), faces)
}

/// Builds the unit sphere with 20 x 4^level faces.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::icosphere(2).faces().len(), 320);
/// ```
pub fn icosphere(level: u32) -> TriMesh {
    let phi = (1.0 + 5f64.sqrt()) / 2.0;
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let corner = |(s, t): (f64, f64)| DVec3::new(0.0, s, t * phi).normalize();
    let cycled = |axis: usize| {
        signs.map(|st| corner(st).to_array()).map(|p| [p[(3 - axis) % 3], p[(4 - axis) % 3], p[(5 - axis) % 3]])
    };
    let mut points: Vec<DVec3> = (0..3).flat_map(cycled).map(DVec3::from_array).collect();
    let mut faces = triangles_of_neighbours(&points);
    for _ in 0..level {
        faces = cut_in_four(&mut points, &faces);
    }
    build(points.into_iter().map(|p| p.to_array()), faces)
}

fn triangles_of_neighbours(points: &[DVec3]) -> Vec<[u32; 3]> {
    let n = points.len();
    let near = |i: usize, j: usize| points[i].dot(points[j]) > 0.4;
    let mut faces = Vec::new();
    for (i, j, k) in (0..n).flat_map(|i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| (i, j, k)))) {
        if near(i, j) && near(j, k) && near(k, i) {
            let outward = points[i].cross(points[j]).dot(points[k]) > 0.0;
            faces.push((if outward { [i, j, k] } else { [i, k, j] }).map(|v| v as u32));
        }
    }
    faces
}

fn cut_in_four(points: &mut Vec<DVec3>, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middle_of = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middle_of.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let mut cut = |&[a, b, c]: &[u32; 3]| {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    };
    faces.iter().flat_map(&mut cut).collect()
}

/// Builds a torus around the z axis of n_around x n_tube quads.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::mesh::shapes::torus(16, 8, 1.0, 0.3).positions().len(), 128);
/// ```
pub fn torus(n_around: u32, n_tube: u32, radius: f64, tube: f64) -> TriMesh {
    sheet([n_around, n_tube], [Join::Round, Join::Round], |u, v| {
        let r = radius + tube * (TAU * v).cos();
        [r * (TAU * u).cos(), r * (TAU * u).sin(), tube * (TAU * v).sin()]
    })
}

/// Builds a wavy sphere whose edges grow by the factor `unevenness` between the poles.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// let mesh = neural_mesh::mesh::shapes::wavy_sphere(3, 10.0);
/// assert_eq!(mesh.faces().len(), 1280);
/// ```
pub fn wavy_sphere(level: u32, unevenness: f64) -> TriMesh {
    map_points(&icosphere(level), false, |p| {
        let p = toward_pole(DVec3::from_array(p), unevenness);
        let wave = (5.0 * p.x).sin() * (4.0 * p.y + 1.0).cos() * (3.0 * p.z).sin();
        (p * (1.0 + 0.1 * wave)).to_array()
    })
}

fn toward_pole(p: DVec3, factor: f64) -> DVec3 {
    let (up, down) = ((1.0 + p.z) / factor, 1.0 - p.z);
    DVec3::new(2.0 * p.x / factor.sqrt(), 2.0 * p.y / factor.sqrt(), up - down) / (up + down)
}
