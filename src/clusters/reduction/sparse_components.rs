//! Fewer components in place of smaller ones.
//!
//! Leaves and grass are components of a few faces, which no collapse makes smaller. Some are dropped, and those that
//! stay grow, so that the area stays (Karis, Stubbe and Wihlidal 2021).

use glam::DVec3;
use rustc_hash::FxHashSet;

use crate::clusters::vertices::ReducedPatch;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::union_find::join_vertices;
use crate::mesh::{PositionKey, TriMesh, compact, edges, position_key};

/// Most faces of a component that grows.
pub const MOST_LEAF_FACES: usize = 4;
/// Largest factor of a component's size at one level.
const MOST_GROWTH: f64 = 1.5;

struct LooseComponent {
    faces: Vec<u32>,
    area: f64,
    is_locked: bool,
}

/// Counts the faces of leaves: of components of few faces, without locked vertices, that are open.
pub fn count_leaf_faces(mesh: &TriMesh, locked: &FxHashSet<PositionKey>) -> usize {
    let mut is_at_boundary = vec![false; mesh.positions().len()];
    let boundary = edges(mesh).into_iter().filter(|edge| edge.n_faces() == 1);
    boundary.flat_map(|edge| edge.ends).for_each(|v| is_at_boundary[v as usize] = true);
    let is_open = |component: &&LooseComponent| {
        let mut corners = component.faces.iter().flat_map(|&face| mesh.faces()[face as usize]);
        corners.any(|v| is_at_boundary[v as usize])
    };
    let components = find_components(mesh, locked);
    components.iter().filter(|it| is_leaf(it)).filter(is_open).map(|it| it.faces.len()).sum()
}

/// Drops components without locked vertices, the smallest by area first, down to about `n_faces`; one is always kept.
pub fn drop_components(reduced: ReducedPatch, locked: &FxHashSet<PositionKey>, n_faces: usize) -> ReducedPatch {
    let mut components = find_components(&reduced.mesh, locked);
    // Equal ones alternate, so that those that go are spread over the surface.
    let chance = |number: usize| 1.0 + (number as f64 * 0.618_033_988_749_895).fract();
    let mut order: Vec<usize> = (0..components.len()).collect();
    order.sort_by(|&a, &b| (components[a].area * chance(a)).total_cmp(&(components[b].area * chance(b))));
    let mut n_left = reduced.mesh.faces().len();
    let mut is_dropped = vec![false; components.len()];
    for &number in order.iter().take(components.len() - 1) {
        if n_left <= n_faces {
            break;
        }
        if !components[number].is_locked {
            is_dropped[number] = true;
            n_left -= components[number].faces.len();
        }
    }
    let growth = leaf_growth(&components, &is_dropped);
    let mut kept = is_dropped.into_iter();
    components.retain(|_| kept.next() == Some(false));
    if n_left == reduced.mesh.faces().len() {
        return reduced;
    }
    keep_components(reduced, &components, growth)
}

fn find_components(mesh: &TriMesh, locked: &FxHashSet<PositionKey>) -> Vec<LooseComponent> {
    let mut sets = join_vertices(mesh.positions().len(), mesh.faces().iter().copied());
    let mut numbers = vec![u32::MAX; mesh.positions().len()];
    let mut components: Vec<LooseComponent> = Vec::new();
    for (number, face) in (0u32..).zip(mesh.faces()) {
        let set = sets.find(face[0]) as usize;
        if numbers[set] == u32::MAX {
            numbers[set] = components.len() as u32;
            components.push(LooseComponent { faces: Vec::new(), area: 0.0, is_locked: false });
        }
        let component = &mut components[numbers[set] as usize];
        component.faces.push(number);
        component.area += area(mesh, *face);
        component.is_locked |= face.iter().any(|&v| locked.contains(&position_key(mesh.positions()[v as usize])));
    }
    components
}

fn area(mesh: &TriMesh, face: [u32; 3]) -> f64 {
    0.5 * area_normal_f64(face.map(|v| point(mesh, v))).length()
}

fn point(mesh: &TriMesh, v: u32) -> DVec3 {
    DVec3::from(mesh.positions()[v as usize].map(f64::from))
}

fn is_leaf(component: &LooseComponent) -> bool {
    !component.is_locked && component.faces.len() <= MOST_LEAF_FACES
}

/// Returns the factor by which leaves grow to make up for the area of dropped ones.
fn leaf_growth(components: &[LooseComponent], is_dropped: &[bool]) -> f64 {
    let sum = |dropped: bool| {
        let leaves =
            components.iter().zip(is_dropped).filter(|(it, is_dropped)| is_leaf(it) && **is_dropped == dropped);
        leaves.map(|(component, _)| component.area).sum::<f64>()
    };
    let (lost, left) = (sum(true), sum(false));
    if left > 0.0 { ((lost + left) / left).sqrt().min(MOST_GROWTH) } else { 1.0 }
}

fn keep_components(reduced: ReducedPatch, components: &[LooseComponent], growth: f64) -> ReducedPatch {
    let mut positions = reduced.mesh.positions().to_vec();
    for component in components.iter().filter(|component| is_leaf(component)) {
        let mut vertices: Vec<u32> =
            component.faces.iter().flat_map(|&face| reduced.mesh.faces()[face as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let center = vertices.iter().map(|&v| point(&reduced.mesh, v)).sum::<DVec3>() / vertices.len() as f64;
        for v in vertices {
            let grown = center + growth * (point(&reduced.mesh, v) - center);
            positions[v as usize] = grown.as_vec3().to_array();
        }
    }
    let mut faces: Vec<u32> = components.iter().flat_map(|component| component.faces.iter().copied()).collect();
    faces.sort_unstable();
    let corners = faces.iter().map(|&face| reduced.mesh.faces()[face as usize]).collect();
    let mesh = compact(&positions, corners).map(|(mesh, _)| mesh);
    match (mesh, reduced.attributes.clone().select_faces(&faces)) {
        (Ok(mesh), Some(attributes)) => ReducedPatch { mesh, attributes },
        // Growth beyond single precision: all components stay.
        _ => reduced,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, shapes};

    fn leaves(n: u32) -> ReducedPatch {
        let square = |i: u32| {
            let (x, y) = ((i % 20) as f32 * 3.0, (i / 20) as f32 * 3.0);
            [[x, y, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0], [x, y + 1.0, 0.0]]
        };
        let faces = (0..n).flat_map(|i| [[0, 1, 2], [0, 2, 3]].map(|face| face.map(|v| 4 * i + v))).collect();
        let mesh = TriMesh::new((0..n).flat_map(square).collect(), faces).unwrap();
        ReducedPatch { mesh, attributes: Attributes::default() }
    }

    fn total_area(mesh: &TriMesh) -> f64 {
        mesh.faces().iter().map(|&face| area(mesh, face)).sum()
    }

    #[test]
    fn half_of_the_leaves_keep_the_area() {
        let thinned = drop_components(leaves(200), &FxHashSet::default(), 200);
        assert_eq!(thinned.mesh.faces().len(), 200);
        assert!((total_area(&thinned.mesh) - 200.0).abs() < 1e-3);
        // Those left are spread: each quarter of the field has some.
        let quarter = |p: &[f32; 3]| usize::from(p[0] > 30.0) + 2 * usize::from(p[1] > 15.0);
        let mut counts = [0; 4];
        thinned.mesh.positions().iter().for_each(|p| counts[quarter(p)] += 1);
        assert!(counts.into_iter().all(|n| n > 40), "{counts:?}");
    }

    #[test]
    fn locked_components_stay_as_they_are() {
        let before = leaves(10);
        let locked: FxHashSet<PositionKey> = before.mesh.positions()[..20].iter().map(|&p| position_key(p)).collect();
        let after = drop_components(leaves(10), &locked, 1);
        assert_eq!(after.mesh.faces().len(), 10 + 2 * usize::from(after.mesh.faces().len() > 10));
        let stays = |p: &[f32; 3]| after.mesh.positions().contains(p);
        assert!(before.mesh.positions()[..20].iter().all(stays));
    }

    #[test]
    fn closed_and_locked_components_are_no_leaves() {
        let (squares, none) = (leaves(10).mesh, FxHashSet::default());
        assert_eq!(count_leaf_faces(&squares, &none), 20);
        assert_eq!(count_leaf_faces(&shapes::unite([&squares, &shapes::tetrahedron()]), &none), 20);
        let locked: FxHashSet<PositionKey> = squares.positions()[..5].iter().map(|&p| position_key(p)).collect();
        assert_eq!(count_leaf_faces(&squares, &locked), 16);
    }
}
