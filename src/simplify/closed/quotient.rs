//! The quotient mesh: one vertex per region, one face where three regions meet, proved to be the same surface.
//!
//! If every region is a disc that touches one border at most, and the faces around every region form one fan, the
//! quotient is a manifold with the input's genus, borders and components: each region is contracted to a point,
//! each strip of faces between two regions to an edge. The conditions are checked; a region that breaks one is cut
//! in two, which ends at the latest with the input itself.

use std::collections::{BTreeMap, VecDeque};

use crate::mesh::OneRings;

use super::darts::Assignment;
use super::surface::Surface;

/// How often broken regions are cut in half before they are taken apart, which always helps but costs samples.
const HALVINGS: usize = 3;

/// The quotient's faces over region indices.
pub(super) struct Quotient {
    /// Faces, n x 3, wound as in the input.
    pub faces: Vec<[u32; 3]>,
    /// The rings over them.
    pub rings: OneRings,
    /// Regions that were cut to keep the surface a manifold.
    pub n_refined: usize,
}

/// Builds the quotient, cutting regions of `assignment` where they stand in the way.
pub(super) fn quotient(surface: &Surface, assignment: &mut Assignment) -> Quotient {
    let apex_faces = surface.rings.apex_faces();
    let n_before = assignment.n_regions;
    let mut rounds = 0;
    loop {
        if assignment.n_regions == surface.n_vertices() {
            // Every region is a vertex, but not necessarily that of its own number.
            *assignment = Assignment::identity(surface.n_vertices());
            let (faces, rings) = (surface.faces.clone(), surface.rings.clone());
            return Quotient { faces, rings, n_refined: surface.n_vertices() - n_before };
        }
        let (faces, mut broken) = meeting_faces(surface, assignment, &apex_faces);
        let n_inner = faces.inner.len();
        let closed = [faces.inner, faces.border].concat();
        let n_nodes = assignment.n_regions + surface.rings.n_apexes();
        mark_flat_pillows(&closed, assignment.n_regions, &mut broken);
        let parts = if rounds < HALVINGS { Parts::Halves } else { Parts::Vertices };
        rounds += 1;
        if broken.contains(&true) && refine(surface, assignment, &broken, &closed, parts) {
            continue;
        }
        let rings = OneRings::new(n_nodes, &closed);
        if let Err(error) = &rings {
            error.vertices.iter().for_each(|&r| broken[r as usize] = true);
        }
        if !refine(surface, assignment, &broken, &closed, parts) {
            let faces = closed[..n_inner].to_vec();
            let rings = if n_inner == closed.len() { rings } else { OneRings::new(assignment.n_regions, &faces) };
            // What is broken and cannot be cut lies in regions of several parts, which no search makes.
            if let (Ok(rings), false) = (rings, broken.contains(&true)) {
                return Quotient { faces, rings, n_refined: assignment.n_regions - n_before };
            }
            *assignment = Assignment::identity(surface.n_vertices());
        }
    }
}

/// The faces that join three labels: of the surface, and of the cones over its borders.
struct Meeting {
    inner: Vec<[u32; 3]>,
    border: Vec<[u32; 3]>,
}

/// Collects the faces whose corners lie in three regions and notes which regions are not discs.
///
/// With V vertices, F2 faces with exactly two corners and F3 with all three in it, a region's Euler
/// characteristic is V - (3 F3 + F2) / 2 + F3; it is 1 for a disc.
fn meeting_faces(surface: &Surface, assignment: &Assignment, apex_faces: &[[u32; 3]]) -> (Meeting, Vec<bool>) {
    let n_inner = surface.n_vertices() as u32;
    let n_regions = assignment.n_regions as u32;
    let label = |v: u32| if v < n_inner { assignment.region[v as usize] } else { n_regions + v - n_inner };
    let mut twice_euler = vec![0i32; assignment.n_regions];
    assignment.region.iter().for_each(|&r| twice_euler[r as usize] += 2);
    let mut collect = |faces: &[[u32; 3]]| {
        let mut meeting = Vec::new();
        for face in faces {
            let [a, b, c] = face.map(label);
            let twice = if a == b || a == c { a } else { b };
            if a != b && b != c && c != a {
                meeting.push([a, b, c]);
            } else if let Some(count) = twice_euler.get_mut(twice as usize) {
                *count -= 1;
            }
        }
        meeting
    };
    let meeting = Meeting { inner: collect(&surface.faces), border: collect(apex_faces) };
    let mut broken: Vec<bool> = twice_euler.iter().map(|&euler| euler != 2).collect();
    broken.resize(assignment.n_regions + surface.rings.n_apexes(), false);
    mark_bridges(&meeting.border, &mut broken);
    (meeting, broken)
}

/// Marks the regions that touch two borders: contracted to a point, they would make one border of them.
fn mark_bridges(border: &[[u32; 3]], broken: &mut [bool]) {
    let mut apex_of = vec![u32::MAX; if border.is_empty() { 0 } else { broken.len() }];
    for &[w, v, apex] in border {
        for region in [w as usize, v as usize] {
            broken[region] |= apex_of[region] != u32::MAX && apex_of[region] != apex;
            apex_of[region] = apex;
        }
    }
}

/// Marks the regions with fewer than three neighbours, and those: contracted, the faces between them would lie on each
/// other.
fn mark_flat_pillows(faces: &[[u32; 3]], n_regions: usize, broken: &mut [bool]) {
    let mut n_faces = vec![0u32; broken.len()];
    faces.as_flattened().iter().for_each(|&r| n_faces[r as usize] += 1);
    for face in faces {
        if face.iter().any(|&r| n_faces[r as usize] < 3) {
            face.iter().for_each(|&r| broken[r as usize] = true);
        }
    }
    n_faces[..n_regions].iter().zip(broken).for_each(|(&n, broken)| *broken |= n == 0);
}

/// What a broken region is cut into.
#[derive(Clone, Copy)]
enum Parts {
    Halves,
    Vertices,
}

/// Cuts every broken region, or the regions around it where it is a single vertex; false if none was cut.
fn refine(surface: &Surface, assignment: &mut Assignment, broken: &[bool], faces: &[[u32; 3]], parts: Parts) -> bool {
    if !broken.contains(&true) {
        return false;
    }
    let mut sizes = vec![0u32; assignment.n_regions];
    assignment.region.iter().for_each(|&r| sizes[r as usize] += 1);
    let single = |r: u32| sizes.get(r as usize).is_none_or(|&size| size < 2);
    let mut cut: Vec<bool> = broken.iter().enumerate().map(|(r, &b)| b && !single(r as u32)).collect();
    for face in faces {
        if face.iter().any(|&r| broken[r as usize] && single(r)) {
            face.iter().for_each(|&r| cut[r as usize] = !single(r));
        }
    }
    let members = members(assignment, &cut);
    for vertices in members.values() {
        match parts {
            Parts::Halves => cut_region(surface, assignment, vertices),
            Parts::Vertices => dissolve(assignment, vertices),
        }
    }
    !members.is_empty()
}

/// Gives every vertex of a region but the first a label of its own.
fn dissolve(assignment: &mut Assignment, vertices: &[u32]) {
    for &v in &vertices[1..] {
        assignment.region[v as usize] = assignment.n_regions as u32;
        assignment.n_regions += 1;
    }
}

/// The vertices of the regions that are wanted, n_regions or more.
pub(super) fn members(assignment: &Assignment, wanted: &[bool]) -> BTreeMap<u32, Vec<u32>> {
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    if wanted.contains(&true) {
        for (v, &r) in assignment.region.iter().enumerate().filter(|(_, r)| wanted[**r as usize]) {
            members.entry(r).or_default().push(v as u32);
        }
    }
    members
}

/// Gives the half of a region that is nearer to its far end a label of its own, and so each part that is cut off.
pub(super) fn cut_region(surface: &Surface, assignment: &mut Assignment, vertices: &[u32]) {
    let own = assignment.region[vertices[0] as usize];
    let reached = spread(surface, assignment, &[vertices[0]], own);
    let fresh = assignment.n_regions as u32;
    assignment.n_regions += 1;
    if reached.len() < vertices.len() {
        let mut inside = reached;
        inside.sort_unstable();
        for v in vertices.iter().filter(|v| inside.binary_search(v).is_err()) {
            assignment.region[*v as usize] = fresh;
        }
        return;
    }
    let far = reached[reached.len() - 1];
    let both = spread_two(surface, assignment, [vertices[0], far], own);
    both.into_iter().for_each(|v| assignment.region[v as usize] = fresh);
}

/// The vertices of region `own` in the order in which a search from `seeds` meets them.
fn spread(surface: &Surface, assignment: &Assignment, seeds: &[u32], own: u32) -> Vec<u32> {
    let mut seen: rustc_hash::FxHashSet<u32> = seeds.iter().copied().collect();
    let mut order = seeds.to_vec();
    let mut next = 0;
    while next < order.len() {
        for &w in surface.neighbors(order[next]) {
            if assignment.region[w as usize] == own && seen.insert(w) {
                order.push(w);
            }
        }
        next += 1;
    }
    order
}

/// The vertices of region `own` that are nearer, in edges, to the second seed than to the first.
fn spread_two(surface: &Surface, assignment: &Assignment, seeds: [u32; 2], own: u32) -> Vec<u32> {
    let mut side: rustc_hash::FxHashMap<u32, bool> = seeds.into_iter().zip([false, true]).collect();
    let mut front: VecDeque<u32> = seeds.into();
    while let Some(v) = front.pop_front() {
        let second = side[&v];
        for &w in surface.neighbors(v) {
            if assignment.region[w as usize] == own && !side.contains_key(&w) {
                side.insert(w, second);
                front.push_back(w);
            }
        }
    }
    let mut second: Vec<u32> = side.into_iter().filter(|&(_, second)| second).map(|(v, _)| v).collect();
    second.sort_unstable();
    second
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};
    use crate::simplify::closed::darts::assign_to;
    use crate::simplify::closed::edge_lengths::EdgeLengths;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    /// The quotient judged by the naive figures: the same surface as the mesh.
    fn assert_same_surface(mesh: &TriMesh, surface: &Surface, mut assignment: Assignment) {
        let quotient = quotient(surface, &mut assignment);
        let places = (0..assignment.n_regions).map(|r| [r as f32, 0.0, 0.0]).collect();
        let (before, after) = (topology(mesh), topology(&TriMesh::new(places, quotient.faces).unwrap()));
        assert_eq!(after.non_manifold_edges + after.non_manifold_vertices + after.unreferenced_vertices, 0);
        assert_eq!((after.euler, after.genus, after.components), (before.euler, before.genus, before.components));
        assert_eq!((after.boundary_loops, after.orientable), (before.boundary_loops, before.orientable));
        assert_eq!(quotient.rings.n_apexes(), after.boundary_loops);
        assert_eq!(after.inconsistent_edges == 0, before.orientable);
    }

    #[test]
    fn any_regions_give_the_same_surface() {
        let meshes = [
            shapes::torus(24, 8, 1.0, 0.3),
            shapes::chain_of_tori(2),
            shapes::plate(3, 0.01),
            shapes::thin_sheet(10, 1e-3),
            shapes::many_boxes(12),
            shapes::open_cylinder(16, 8),
            shapes::grid(12, 7),
            shapes::klein_bottle(20, 8),
            shapes::moebius_strip(20, 4),
        ];
        let mut random = Xoshiro256PlusPlus::seed_from_u64(9);
        let mut below = |n: usize| (random.next_u64() % n as u64) as u32;
        for mesh in &meshes {
            let surface = Surface::new(mesh);
            let lengths = EdgeLengths::new(&surface);
            for n_regions in [1, 3, 8, 40, 90] {
                let mut samples: Vec<u32> = (0..n_regions).map(|_| below(surface.n_vertices())).collect();
                samples.sort_unstable();
                samples.dedup();
                assert_same_surface(mesh, &surface, assign_to(&surface, &lengths, &samples));
                let region = (0..surface.n_vertices()).map(|v| if v < n_regions { v as u32 } else { below(n_regions) });
                assert_same_surface(mesh, &surface, Assignment { region: region.collect(), n_regions });
            }
        }
    }

    #[test]
    fn good_regions_are_left_alone() {
        let surface = Surface::new(&shapes::icosphere(3));
        let lengths = EdgeLengths::new(&surface);
        let corners: Vec<u32> = (0..12).collect();
        let mut assignment = assign_to(&surface, &lengths, &corners);
        let quotient = quotient(&surface, &mut assignment);
        assert_eq!((quotient.n_refined, quotient.faces.len(), assignment.n_regions), (0, 20, 12));
    }

    #[test]
    fn regions_of_one_vertex_each_are_numbered_like_the_vertices() {
        let surface = Surface::new(&shapes::icosphere(1));
        let n_regions = surface.n_vertices();
        let mut assignment = Assignment { region: (0..n_regions as u32).rev().collect(), n_regions };
        let quotient = quotient(&surface, &mut assignment);
        assert_eq!(quotient.faces, surface.faces);
        assert_eq!(assignment.region, Assignment::identity(n_regions).region);
    }
}
