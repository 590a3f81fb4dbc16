//! Helpers for whole-mesh tests.
#![allow(dead_code, reason = "not every set of features uses all")]

use std::collections::HashSet;
use std::ops::ControlFlow;

use neural_mesh::mesh::{TriMesh, shapes, topology};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{Input, Options, Simplified, simplify};
use proptest::prelude::*;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

// Simplifies without weights; the run must succeed.
#[track_caller]
pub fn simplify_valid<'a>(input: impl Into<Input<'a>>, options: &Options) -> Simplified {
    simplify(input, options, &mut |_| ControlFlow::Continue(())).expect("a result")
}

// Expects a closed, manifold, consistently oriented mesh without unused vertices or repeated positions.
#[track_caller]
pub fn assert_closed_manifold(mesh: &TriMesh) {
    let topology = topology(mesh);
    assert!(topology.is_closed_manifold(), "{topology:?}");
    assert_eq!(topology.unreferenced_vertices, 0, "unused vertices");
    assert_eq!(repeated_positions(mesh), 0, "positions that more than one vertex has");
}

// Expects a manifold, consistently oriented mesh, with or without boundaries.
#[track_caller]
pub fn assert_manifold(mesh: &TriMesh) {
    let topology = topology(mesh);
    let trouble = topology.non_manifold_edges + topology.non_manifold_vertices + topology.inconsistent_edges;
    assert_eq!(trouble + topology.unreferenced_vertices, 0, "{topology:?}");
    assert_eq!(repeated_positions(mesh), 0, "positions that more than one vertex has");
}

// Returns a value with some fields changed.
pub fn with_changes<T>(mut it: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut it);
    it
}

// Expects equal numbers of components, holes and handles.
#[track_caller]
pub fn assert_same_topology(original: &TriMesh, simplified: &TriMesh) {
    let figures = |mesh| {
        let topology = topology(mesh);
        (topology.closed, topology.components, topology.genus, topology.boundary_loops)
    };
    assert_eq!(figures(original), figures(simplified), "closed, components, genus, boundary loops");
}

// Expects a Hausdorff distance of at most a share of the original's diagonal.
#[track_caller]
pub fn assert_close(original: &TriMesh, simplified: &TriMesh, fraction: f64) {
    let surfaces = [original, simplified].map(|mesh| Surface::new(mesh, 2000, 0));
    let distance = surface_distance(&surfaces[0], &surfaces[1]).expect("two meshes with faces");
    let share = distance.both.max / distance.diagonal;
    assert!(share <= fraction, "{share} of the diagonal apart, {fraction} allowed");
}

// Counts vertices at the position of an earlier vertex.
pub fn repeated_positions(mesh: &TriMesh) -> usize {
    let bits = |p: &[f32; 3]| p.map(|x| (x + 0.0).to_bits());
    mesh.positions().len() - mesh.positions().iter().map(bits).collect::<HashSet<_>>().len()
}

// Generates closed manifold meshes of genus 0 and 1 with up to about a thousand faces and very uneven sampling.
pub fn uneven_closed_mesh() -> impl Strategy<Value = TriMesh> {
    let stretch = prop::array::uniform3(-1.5f64..1.5);
    (0..6usize, any::<u64>(), 0..400usize, 0.0..0.3f64, stretch).prop_map(|(base, seed, splits, shake, stretch)| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let split = split_around(&base_mesh(base), splits, &mut rng);
        stretch_axes(&shake_vertices(&split, shake, &mut rng), stretch)
    })
}

fn base_mesh(which: usize) -> TriMesh {
    match which {
        0 => shapes::tetrahedron(),
        1 => shapes::icosphere(1),
        2 => shapes::cuboid([1.0, 1.0, 1.0], 2),
        3 => shapes::torus(12, 6, 1.0, 0.3),
        4 => shapes::wavy_sphere(2, 20.0),
        _ => shapes::many_boxes(3),
    }
}

// Halves longest edges of random faces, mostly of faces that were just split.
fn split_around(mesh: &TriMesh, splits: usize, rng: &mut Xoshiro256PlusPlus) -> TriMesh {
    let mut positions = mesh.positions().to_vec();
    let mut faces = mesh.faces().to_vec();
    for _ in 0..splits {
        let recent = faces.len().min(if unit(rng) < 0.8 { 8 } else { faces.len() });
        let face = faces[faces.len() - 1 - (unit(rng) * recent as f64) as usize];
        let [a, b] = longest_edge(&positions, face);
        let middle: [f32; 3] = std::array::from_fn(|k| 0.5 * (positions[a as usize][k] + positions[b as usize][k]));
        if middle == positions[a as usize] || middle == positions[b as usize] {
            continue;
        }
        split_edge(&mut faces, [a, b], positions.len() as u32);
        positions.push(middle);
    }
    TriMesh::new(positions, faces).expect("splits keep a mesh valid")
}

fn longest_edge(positions: &[[f32; 3]], [a, b, c]: [u32; 3]) -> [u32; 2] {
    let length2 = |[a, b]: [u32; 2]| -> f32 {
        (0..3).map(|k| (positions[a as usize][k] - positions[b as usize][k]).powi(2)).sum()
    };
    let longer = |x: [u32; 2], y: [u32; 2]| if length2(y) > length2(x) { y } else { x };
    longer(longer([a, b], [b, c]), [c, a])
}

fn split_edge(faces: &mut Vec<[u32; 3]>, [a, b]: [u32; 2], middle: u32) {
    let (over, mut kept): (Vec<[u32; 3]>, Vec<_>) =
        faces.iter().copied().partition(|face| face.contains(&a) && face.contains(&b));
    for face in over {
        kept.push(face.map(|v| if v == a { middle } else { v }));
        kept.push(face.map(|v| if v == b { middle } else { v }));
    }
    *faces = kept;
}

// Moves each vertex by up to a share of its shortest edge.
fn shake_vertices(mesh: &TriMesh, share: f64, rng: &mut Xoshiro256PlusPlus) -> TriMesh {
    let mut shortest = vec![f32::INFINITY; mesh.positions().len()];
    for &[a, b, c] in mesh.faces() {
        for [a, b] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(|v| v as usize)) {
            let [p, q] = [mesh.positions()[a], mesh.positions()[b]];
            let length = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f32>().sqrt();
            (shortest[a], shortest[b]) = (shortest[a].min(length), shortest[b].min(length));
        }
    }
    let mut shake = |(p, &edge): (&[f32; 3], &f32)| p.map(|x| x + edge * (share * (unit(rng) - 0.5)) as f32);
    let positions = mesh.positions().iter().zip(&shortest).map(&mut shake).collect();
    TriMesh::new(positions, mesh.faces().to_vec()).expect("finite positions")
}

fn stretch_axes(mesh: &TriMesh, exponents: [f64; 3]) -> TriMesh {
    let factors = exponents.map(|e| 10f64.powf(e) as f32);
    let positions = mesh.positions().iter().map(|p| std::array::from_fn(|k| p[k] * factors[k])).collect();
    TriMesh::new(positions, mesh.faces().to_vec()).expect("finite positions")
}

fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    f64::from(rng.next_u32()) / 2f64.powi(32)
}
