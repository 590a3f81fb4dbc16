//! The quotient mesh: one vertex per region, one face where three regions meet, proved to be the same surface.
//!
//! If every region is a disc that touches one boundary at most, and the faces around every region form one fan, the
//! quotient is a manifold with the input's genus, boundaries and components: each region is contracted to a point,
//! each strip of faces between two regions to an edge. The conditions are checked; a region that breaks one is cut
//! in two, which ends at the latest with the input itself.

use std::borrow::Cow;
use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::mesh::OneRings;
use crate::mesh::pulse::Pulse;
use crate::mesh::shares::{add_faces, add_to_rows, indices_where, shares};

use super::assignment::Assignment;
use super::placement::Places;
use super::sums::Sum;
use crate::simplify::closed::prepare::feature_edges::FeatureEdges;
use crate::simplify::closed::prepare::surface::Surface;

/// How often broken regions are cut in half before they are taken apart, which always helps but costs samples. Twelve
/// large training meshes at ratios 0.03 to 0.15: without halving the largest distance is 3 % farther; six halvings
/// change no result.
const HALVINGS: usize = 3;
/// Share of the regions up to which broken ones are taken apart at once. Twelve large training meshes at ratios 0.03 to
/// 0.15: at 1e-4 half of the results differ, by 0.1 % in the mean distance.
const FEW: f64 = 1e-3;

/// How often the regions around pleats are taken apart. Eight training meshes at ratios 0.05 to 0.2: without, 40 faces of the
/// results are turned, after one round 6, after two 3, after four 2; the largest distance is 7 % nearer after two.
const SMOOTHINGS: usize = 2;

/// Regions that are cut between two beats.
const BETWEEN_BEATS: usize = 1024;

/// Most parts that the faces are looked through in: each makes counts for all regions, which are added up by one
/// thread. Results do not depend on it.
const MOST_SHARES: usize = 8;

/// The quotient's faces over region indices.
pub struct Quotient<'a> {
    /// Faces, n x 3, wound as in the input.
    pub faces: Cow<'a, [[u32; 3]]>,
    /// The rings over them.
    pub rings: Cow<'a, OneRings>,
    /// Where its vertices lie.
    pub places: Places,
    /// Regions that were cut to keep the surface a manifold.
    pub n_refined: usize,
}

/// Builds the quotient, cutting regions of `assignment` where they stand in the way; keeps the sums of the regions in step.
pub fn quotient<'a>(
    surface: &'a Surface<'a>,
    features: &FeatureEdges,
    assignment: &mut Assignment,
    sums: &mut Vec<Sum>,
) -> Quotient<'a> {
    let ghost_faces = surface.rings.ghost_faces();
    let n_before = assignment.n_regions;
    let mut n_smoothings = 0;
    for round in 0.. {
        if assignment.n_regions == surface.n_vertices() {
            // Every region is a vertex, but not necessarily that of its own number.
            *assignment = Assignment::identity(surface.n_vertices());
            break;
        }
        let attempt = Attempt::new(surface, features, assignment, &ghost_faces);
        let is_many = attempt.is_many();
        let parts = if round < HALVINGS && is_many { Parts::Halves } else { Parts::Vertices };
        let places = if is_many { Places::default() } else { attempt.places(surface, assignment, sums) };
        let mut to_cut = attempt.broken.clone();
        if !is_many && n_smoothings < SMOOTHINGS {
            n_smoothings += 1;
            places.turned.iter().for_each(|&r| to_cut[r as usize] = true);
        }
        if !refine(surface, assignment, sums, &to_cut, parts, &attempt.faces) {
            // What is broken and cannot be cut lies in regions of several parts, which no search makes.
            if let Some((faces, rings)) = attempt.into_rings(surface.pulse, assignment.n_regions) {
                let (faces, rings) = (Cow::Owned(faces), Cow::Owned(rings));
                return Quotient { faces, rings, places, n_refined: assignment.n_regions - n_before };
            }
            *assignment = Assignment::identity(surface.n_vertices());
        }
    }
    let (faces, rings) = (Cow::Borrowed(&*surface.faces), Cow::Borrowed(&surface.rings));
    let places = Places::new(surface, assignment, sums, &faces);
    Quotient { faces, rings, places, n_refined: surface.n_vertices() - n_before }
}

/// The quotient over the regions as they are, and which of them break it.
struct Attempt {
    /// Faces over regions, those over the cones of the boundaries last.
    faces: Vec<[u32; 3]>,
    /// How many of them are the surface's.
    n_inner: usize,
    /// Number of regions.
    n_regions: usize,
    /// Whether each region, and each ghost vertex, breaks the quotient.
    broken: Vec<bool>,
    /// The rings over all faces; while many regions are broken, they would be made for nothing.
    rings: Option<OneRings>,
}

impl Attempt {
    fn new(surface: &Surface, features: &FeatureEdges, assignment: &Assignment, ghost_faces: &[[u32; 3]]) -> Self {
        let (meeting, mut broken) = meeting_faces(surface, assignment, ghost_faces);
        features.mark_broken(assignment, &mut broken);
        let (n_inner, n_regions) = (meeting.inner.len(), assignment.n_regions);
        let mut faces = meeting.inner;
        faces.extend(meeting.boundary);
        mark_flat_pillows(surface.pulse, &faces, n_regions, &mut broken);
        let mut attempt = Self { faces, n_inner, n_regions, broken, rings: None };
        if !attempt.is_many() {
            match OneRings::with(surface.pulse, n_regions + surface.rings.n_ghosts(), &attempt.faces) {
                Ok(rings) => attempt.rings = Some(rings),
                Err(error) => error.vertices.iter().for_each(|&r| attempt.broken[r as usize] = true),
            }
        }
        attempt
    }

    /// Whether many regions are broken.
    fn is_many(&self) -> bool {
        let n_broken = self.broken.iter().filter(|broken| **broken).count();
        n_broken as f64 > FEW * self.n_regions as f64
    }

    /// Where the vertices of its regions would lie.
    fn places(&self, surface: &Surface, assignment: &Assignment, sums: &[Sum]) -> Places {
        Places::new(surface, assignment, sums, &self.faces[..self.n_inner])
    }

    /// The faces of the surface and the rings over them; `None` where regions are broken.
    fn into_rings(mut self, pulse: Pulse, n_regions: usize) -> Option<(Vec<[u32; 3]>, OneRings)> {
        let is_closed = self.n_inner == self.faces.len();
        self.faces.truncate(self.n_inner);
        let rings = self.rings.filter(|_| is_closed).or_else(|| OneRings::with(pulse, n_regions, &self.faces).ok())?;
        (!self.broken.contains(&true)).then_some((self.faces, rings))
    }
}

/// The faces that join three labels: of the surface, and of the cones over its boundaries.
struct Meeting {
    inner: Vec<[u32; 3]>,
    boundary: Vec<[u32; 3]>,
}

/// Collects the faces whose corners lie in three regions and notes which regions are not discs.
///
/// With V vertices, F2 faces with exactly two corners and F3 with all three in it, a region's Euler
/// characteristic is V - (3 F3 + F2) / 2 + F3; it is 1 for a disc.
fn meeting_faces(surface: &Surface, assignment: &Assignment, ghost_faces: &[[u32; 3]]) -> (Meeting, Vec<bool>) {
    let n_inner = surface.n_vertices() as u32;
    let n_regions = assignment.n_regions as u32;
    let label = |v: u32| if v < n_inner { assignment.region[v as usize] } else { n_regions + v - n_inner };
    let mut twice_euler = vec![0i32; assignment.n_regions];
    add_to_rows(surface.pulse, &mut twice_euler, &assignment.region, |euler, _| *euler += 2);
    let mut collect = |faces: &[[u32; 3]]| {
        let chunk = faces.len().div_ceil(shares(faces.len()).len().min(MOST_SHARES)).max(1);
        let share = |faces: &[[u32; 3]]| share_of_meeting_faces(surface.pulse, faces, label, assignment.n_regions);
        let parts: Vec<(Vec<[u32; 3]>, Vec<i32>)> = faces.par_chunks(chunk).map(share).collect();
        let mut meeting = Vec::new();
        for (faces, with_two) in parts {
            twice_euler.iter_mut().zip(with_two).for_each(|(euler, n)| *euler -= n);
            if meeting.is_empty() { meeting = faces } else { meeting.extend(faces) }
        }
        meeting
    };
    let meeting = Meeting { inner: collect(&surface.faces), boundary: collect(ghost_faces) };
    let mut broken: Vec<bool> = twice_euler.iter().map(|&euler| euler != 2).collect();
    broken.resize(assignment.n_regions + surface.rings.n_ghosts(), false);
    mark_bridges(&meeting.boundary, &mut broken);
    (meeting, broken)
}

/// Of these faces those between three labels, and for each region how many have two or three corners in it.
fn share_of_meeting_faces(
    pulse: Pulse,
    faces: &[[u32; 3]],
    label: impl Fn(u32) -> u32,
    n_regions: usize,
) -> (Vec<[u32; 3]>, Vec<i32>) {
    let mut meeting = Vec::new();
    let mut with_two = vec![0i32; if faces.is_empty() { 0 } else { n_regions }];
    for faces in pulse.over(faces) {
        for &[a, b, c] in faces {
            let [a, b, c] = [label(a), label(b), label(c)];
            let twice = if a == b || a == c { a } else { b };
            if a != b && b != c && c != a {
                meeting.push([a, b, c]);
            } else if let Some(count) = with_two.get_mut(twice as usize) {
                *count += 1;
            }
        }
    }
    (meeting, with_two)
}

/// Marks the regions that touch two boundaries: contracted to a point, they would make one boundary of them.
fn mark_bridges(boundary: &[[u32; 3]], broken: &mut [bool]) {
    let mut ghost_of = vec![u32::MAX; if boundary.is_empty() { 0 } else { broken.len() }];
    for &[w, v, ghost] in boundary {
        for region in [w as usize, v as usize] {
            broken[region] |= ghost_of[region] != u32::MAX && ghost_of[region] != ghost;
            ghost_of[region] = ghost;
        }
    }
}

/// Marks the regions with fewer than three neighbours, and those: contracted, the faces between them would lie on each
/// other.
fn mark_flat_pillows(pulse: Pulse, faces: &[[u32; 3]], n_regions: usize, broken: &mut [bool]) {
    let mut n_faces = vec![0u32; broken.len()];
    add_faces(pulse, &mut n_faces, faces, |_| (), |n_faces, (), _| *n_faces += 1);
    let flat = indices_where(pulse, faces, |_, face| face.iter().any(|&r| n_faces[r as usize] < 3));
    flat.into_iter().flat_map(|f| faces[f as usize]).for_each(|r| broken[r as usize] = true);
    n_faces[..n_regions].iter().zip(broken).for_each(|(&n, broken)| *broken |= n == 0);
}

/// What a broken region is cut into.
#[derive(Clone, Copy)]
enum Parts {
    Halves,
    Vertices,
}

/// Cuts every broken region, or the regions around it where it is a single vertex; false if none was cut.
fn refine(
    surface: &Surface,
    assignment: &mut Assignment,
    sums: &mut Vec<Sum>,
    broken: &[bool],
    parts: Parts,
    faces: &[[u32; 3]],
) -> bool {
    if !broken.contains(&true) {
        return false;
    }
    let mut sizes = vec![0u32; assignment.n_regions];
    add_to_rows(surface.pulse, &mut sizes, &assignment.region, |size, _| *size += 1);
    let single = |r: u32| sizes.get(r as usize).is_none_or(|&size| size < 2);
    let mut cut: Vec<bool> = broken.iter().enumerate().map(|(r, &b)| b && !single(r as u32)).collect();
    for faces in surface.pulse.counting_if(false).over(faces) {
        for face in faces {
            if face.iter().any(|&r| broken[r as usize] && single(r)) {
                face.iter().for_each(|&r| cut[r as usize] = !single(r));
            }
        }
    }
    let members = members(surface.pulse, assignment, &cut);
    for (n_before, (&r, vertices)) in members.iter().enumerate() {
        if n_before % BETWEEN_BEATS == 0 {
            surface.pulse.beat(0);
        }
        match parts {
            Parts::Halves => cut_region(surface, assignment, vertices),
            Parts::Vertices => dissolve(assignment, vertices),
        }
        move_sums(surface, assignment, sums, (r, vertices));
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

/// Takes the vertices of region `r` that were given other labels over to the sums of those.
fn move_sums(surface: &Surface, assignment: &Assignment, sums: &mut Vec<Sum>, (r, whole): (u32, &[u32])) {
    sums[r as usize] = Sum::default();
    sums.resize(assignment.n_regions, Sum::default());
    whole.iter().for_each(|&v| sums[assignment.region[v as usize] as usize] += Sum::of(surface, v as usize));
}

/// The vertices of the regions that are wanted, n_regions or more, each list ascending.
pub fn members(pulse: Pulse, assignment: &Assignment, wanted: &[bool]) -> BTreeMap<u32, Vec<u32>> {
    if !wanted.contains(&true) {
        return BTreeMap::new();
    }
    let inside = |r: u32| wanted[r as usize];
    let members = indices_where(pulse, &assignment.region, |_, &r| inside(r));
    let mut pairs: Vec<(u32, u32)> = members.into_iter().map(|v| (assignment.region[v as usize], v)).collect();
    pulse.beat(0);
    pairs.sort_unstable();
    let lists = pairs.chunk_by(|x, y| x.0 == y.0).enumerate();
    let vertices = lists.map(|(n_before, list)| {
        if n_before % BETWEEN_BEATS == 0 {
            pulse.beat(0);
        }
        (list[0].0, list.iter().map(|pair| pair.1).collect())
    });
    vertices.collect()
}

/// Gives the half of a region that is nearer to its far end a label of its own, and so each part that is cut off.
fn cut_region(surface: &Surface, assignment: &mut Assignment, vertices: &[u32]) {
    let fresh = assignment.n_regions as u32;
    assignment.n_regions += 1;
    far_half(surface, vertices).into_iter().for_each(|v| assignment.region[v as usize] = fresh);
}

/// Of a region's vertices (ascending) those nearer to its far end, or those that are cut off from the first one.
pub fn far_half(surface: &Surface, vertices: &[u32]) -> Vec<u32> {
    let whole = Region::of(vertices);
    let reached = whole.spread(surface, &[vertices[0]]);
    let with_side = |side: &[u32], wanted: u32| -> Vec<u32> {
        vertices.iter().zip(side).filter(|(_, side)| **side == wanted).map(|(&v, _)| v).collect()
    };
    let order = &reached.order;
    if order.len() < vertices.len() {
        return with_side(&reached.side, UNREACHED);
    }
    let far = order[order.len() - 1];
    with_side(&whole.spread(surface, &[vertices[0], far]).side, 1)
}

/// Not met by a search.
const UNREACHED: u32 = u32::MAX;

/// The vertices of a region in ascending order.
struct Region<'a> {
    vertices: &'a [u32],
}

/// What a search met.
struct Reached {
    /// The vertices in the order in which they were met.
    order: Vec<u32>,
    /// For each vertex of the region the number of the seed that it was met from.
    side: Vec<u32>,
}

impl<'a> Region<'a> {
    fn of(vertices: &'a [u32]) -> Self {
        debug_assert!(vertices.is_sorted());
        Self { vertices }
    }

    /// Searches the region from the seeds, all of them at once, in edges.
    fn spread(&self, surface: &Surface, seeds: &[u32]) -> Reached {
        let mut reached = Reached { order: seeds.to_vec(), side: vec![UNREACHED; self.vertices.len()] };
        let place = |v: u32| self.vertices.binary_search(&v).ok();
        for (number, &seed) in seeds.iter().enumerate() {
            place(seed).into_iter().for_each(|i| reached.side[i] = number as u32);
        }
        let mut next = 0;
        while next < reached.order.len() {
            let v = reached.order[next];
            let side = place(v).map_or(UNREACHED, |i| reached.side[i]);
            for &w in surface.neighbors(v) {
                if let Some(i) = place(w).filter(|&i| reached.side[i] == UNREACHED) {
                    reached.side[i] = side;
                    reached.order.push(w);
                }
            }
            next += 1;
        }
        reached
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};
    use crate::simplify::closed::cluster::darts::assign_to;
    use crate::simplify::closed::cluster::edge_lengths::EdgeLengths;
    use crate::simplify::closed::cluster::sums::sums;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    /// The quotient judged by the naive figures: the same surface as the mesh.
    fn assert_same_surface(mesh: &TriMesh, surface: &Surface, mut assignment: Assignment) {
        let mut sums = sums(surface, &assignment);
        let quotient = quotient(surface, &FeatureEdges::default(), &mut assignment, &mut sums);
        let places = (0..assignment.n_regions).map(|r| [r as f32, 0.0, 0.0]).collect();
        let (before, after) = (topology(mesh), topology(&TriMesh::new(places, quotient.faces.to_vec()).unwrap()));
        assert_eq!(after.non_manifold_edges + after.non_manifold_vertices + after.unreferenced_vertices, 0);
        assert_eq!((after.euler, after.genus, after.components), (before.euler, before.genus, before.components));
        assert_eq!((after.boundary_loops, after.orientable), (before.boundary_loops, before.orientable));
        assert_eq!(quotient.rings.n_ghosts(), after.boundary_loops);
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
            let surface = Surface::new(mesh, Pulse::NONE);
            let lengths = EdgeLengths::new(&surface);
            for n_regions in [1, 3, 8, 40, 90] {
                let mut samples: Vec<u32> = (0..n_regions).map(|_| below(surface.n_vertices())).collect();
                samples.sort_unstable();
                samples.dedup();
                assert_same_surface(mesh, &surface, assign_to(&surface, &lengths, &samples));
                let region = (0..surface.n_vertices()).map(|v| if v < n_regions { v as u32 } else { below(n_regions) });
                assert_same_surface(
                    mesh,
                    &surface,
                    Assignment { region: region.collect(), n_regions, samples: Vec::new() },
                );
            }
        }
    }

    #[test]
    fn good_regions_are_left_alone() {
        let mesh = shapes::icosphere(3);
        let surface = Surface::new(&mesh, Pulse::NONE);
        let lengths = EdgeLengths::new(&surface);
        let corners: Vec<u32> = (0..12).collect();
        let mut assignment = assign_to(&surface, &lengths, &corners);
        let mut sums = sums(&surface, &assignment);
        let quotient = quotient(&surface, &FeatureEdges::default(), &mut assignment, &mut sums);
        assert_eq!((quotient.n_refined, quotient.faces.len(), assignment.n_regions), (0, 20, 12));
    }

    #[test]
    fn regions_of_one_vertex_each_are_numbered_like_the_vertices() {
        let mesh = shapes::icosphere(1);
        let surface = Surface::new(&mesh, Pulse::NONE);
        let n_regions = surface.n_vertices();
        let mut assignment =
            Assignment { region: (0..n_regions as u32).rev().collect(), n_regions, samples: Vec::new() };
        let mut sums = sums(&surface, &assignment);
        let quotient = quotient(&surface, &FeatureEdges::default(), &mut assignment, &mut sums);
        assert_eq!(*quotient.faces, *surface.faces);
        assert_eq!(assignment.region, Assignment::identity(n_regions).region);
    }

    #[test]
    fn pleats_are_taken_apart() {
        let mesh = shapes::wavy_sphere(4, 10.0);
        let surface = Surface::new(&mesh, Pulse::NONE);
        let lengths = EdgeLengths::new(&surface);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let (mut before, mut after) = (0, 0);
        for _ in 0..20 {
            let mut samples: Vec<u32> =
                (0..400).map(|_| (random.next_u64() % surface.n_vertices() as u64) as u32).collect();
            samples.sort_unstable();
            samples.dedup();
            let mut assignment = assign_to(&surface, &lengths, &samples);
            let mut sums = sums(&surface, &assignment);
            let (meeting, _) = meeting_faces(&surface, &assignment, &[]);
            before += Places::new(&surface, &assignment, &sums, &meeting.inner).turned.len();
            after += quotient(&surface, &FeatureEdges::default(), &mut assignment, &mut sums).places.turned.len();
        }
        assert!(before > 0 && 10 * after < before, "{before} {after}");
    }
}
