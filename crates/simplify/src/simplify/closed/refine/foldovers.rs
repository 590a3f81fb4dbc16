//! Foldover repair: flips the longest edge of a face turned against the original, or moves a corner.

use glam::Vec3;
use rustc_hash::FxHashSet;

use crate::geometry::triangle::{area_normal, nearest_point};
use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::{add_faces, indices_where};
use crate::simplify::closed::diamond::{Diamond, diamonds};
use crate::simplify::closed::original::{Original, Regions};
use crate::simplify::closed::output::Output;

// Rounds of flips over the remaining foldovers. The second and third round change 13 of 57 results, three further
// rounds one.
const ROUNDS: usize = 3;
/// Largest factor by which a repair may increase the local distance to the original.
// Of 16 foldovers 8 remain with 1, 4 with 1.5 and with 3.
const MOST_GROWTH: f32 = 1.5;
// `MOST_GROWTH` of a leaning face, which is no foldover: its repair must lower the distance. The largest distance is
// 0.6 % larger at 0.35.
const LEANING_GROWTH: f32 = 0.7;
/// Cosine between a face and the original below which the face leans.
// The largest distance is 0.9 % larger at 0.
const LEANING: f32 = 0.3;
/// Longest move of a corner over its shortest edge.
// At 0.4 one of 57 results differs, at 1.5 four do.
const LONGEST_MOVE: f32 = 0.75;
// Largest valence that is repaired: higher ones would dominate the time. Of 57 results two differ at 12.
const MOST_FACES: usize = 24;
/// Distance that counts as rounding at unit size.
const ROUNDING: f32 = 1e-6;

/// Repairs foldovers by flips, then by moving corners; returns the number of flips.
pub fn repair(original: &Original, output: &mut Output, is_coarse: bool) -> usize {
    // On coarse results leaning faces are repaired too: an edge may span a hollow that no earlier step saw.
    let least = if is_coarse { LEANING } else { 0.0 };
    let foldovers = find_foldovers(original, output, least);
    if foldovers.is_empty() {
        return 0;
    }
    // Regions are collected only around folded faces, since most results have few.
    let regions = original.collect_regions(&output.vertex_of, &mark(output, &neighbourhood(&foldovers, output)));
    let (n_flipped, mut foldovers) = flip_foldovers(&regions, output, foldovers, least);
    // Corners are moved only for faces that are turned, not for leaning ones.
    let is_stuck = |&f: &u32| {
        RepairView { regions: &regions, output, least: 0.0 }.surroundings_if_turned(f).is_some()
            && opposes_all_neighbors(output, f)
    };
    foldovers.retain(is_stuck);
    if !foldovers.is_empty() {
        move_corners(original, output, &foldovers);
    }
    n_flipped
}

/// Finds the faces that oppose their surroundings and the original beneath them.
fn find_foldovers(original: &Original, output: &Output, least: f32) -> Vec<u32> {
    // No merge and no step of the fit turns a face far, but turns add up. Opposing the mean normal is cheap to test.
    // Faces of thin sheets do so too, so the original decides.
    let mut foldovers = find_opposed_faces(original.surface.pulse, output, least);
    if foldovers.is_empty() {
        return foldovers;
    }
    // Each walk starts at the region vertex closest to the face's first corner.
    let first: Vec<u32> = foldovers.iter().map(|&f| output.face(f)[0]).collect();
    let starts = original.nearest_in_regions(&output.positions, &output.vertex_of, &mark(output, &first));
    foldovers.retain(|&f| {
        let corners = output.triangle(f);
        // The normal of the original beneath the centroid decides.
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        let start = starts[output.face(f)[0] as usize];
        are_opposed(original.closest_point_from(centroid, start).normal, area_normal(corners), least)
    });
    foldovers
}

fn flip_foldovers(regions: &Regions, output: &mut Output, mut foldovers: Vec<u32>, least: f32) -> (usize, Vec<u32>) {
    let mut n_flipped = 0;
    let mut due = foldovers.clone();
    for _ in 0..ROUNDS {
        // Diamonds of one round must not touch, since each was judged without the others.
        let mut touched: FxHashSet<u32> = FxHashSet::default();
        for &f in &due {
            if let Some(diamond) = (RepairView { regions, output, least }).find_flip(f, &touched) {
                output.flip(&diamond);
                touched.extend(diamond.corners);
                n_flipped += 1;
            }
        }
        if touched.is_empty() {
            break;
        }
        foldovers = find_remaining_foldovers(output, foldovers, &touched, least);
        // Only faces near a change can behave differently.
        let is_near = |f: &&u32| neighbourhood(&[**f], output).iter().any(|v| touched.contains(v));
        due = foldovers.iter().filter(is_near).copied().collect();
    }
    (n_flipped, foldovers)
}

fn move_corners(original: &Original, output: &mut Output, foldovers: &[u32]) {
    let rings: Vec<u32> = foldovers.iter().flat_map(|&f| ring(output, &output.face(f))).collect();
    let regions = original.collect_regions(&output.vertex_of, &mark(output, &rings));
    for &f in foldovers {
        if let Some((v, place)) = better_corner(&RepairView { regions: &regions, output, least: 0.0 }, f) {
            output.move_vertex(v, place);
        }
    }
}

/// Returns whether the cosine between two vectors is not positive, or below `least`.
fn are_opposed(a: Vec3, b: Vec3, least: f32) -> bool {
    let along = a.dot(b);
    along <= 0.0 || along * along < least * least * a.length_squared() * b.length_squared()
}

fn mark(output: &Output, vertices: &[u32]) -> Vec<bool> {
    let mut marked = vec![false; output.positions.len()];
    vertices.iter().for_each(|&v| marked[v as usize] = true);
    marked
}

fn neighbourhood(of: &[u32], output: &Output) -> Vec<u32> {
    let mut vertices = Vec::with_capacity(6 * of.len());
    for &f in of {
        let [a, b, c] = output.face(f);
        let across = [(b, a), (c, b), (a, c)].into_iter().filter_map(|(u, v)| output.faces_around().face_along(u, v));
        let opposite = across.flat_map(|g| output.face(g)).filter(|v| ![a, b, c].contains(v));
        vertices.extend([a, b, c].into_iter().chain(opposite));
    }
    vertices
}

fn ring(output: &Output, vertices: &[u32]) -> Vec<u32> {
    let faces = vertices.iter().flat_map(|&v| output.faces_around().faces(v));
    let mut ring: Vec<u32> = faces.flat_map(|f| output.face(f)).collect();
    ring.sort_unstable();
    ring.dedup();
    ring
}

/// Finds a corner of a turned face and a position for it with fewer turned faces around.
fn better_corner(view: &RepairView, f: u32) -> Option<(u32, Vec3)> {
    let RepairView { output, .. } = view;
    // Pinned vertices stay, and vertices of high valence would take too long.
    let is_movable = |v: &u32| !output.pins.is_locked(*v) && output.faces_around().corners(*v).len() <= MOST_FACES / 2;
    output.face(f).into_iter().filter(is_movable).find_map(|v| {
        let here = output.positions[v as usize];
        let star = MovableStar::new(view, v);
        // A position must repair at least one face and be near.
        let n_here = star.n_turned(here);
        let mut better: Vec<(usize, Vec3)> =
            star.candidate_positions(here).map(|place| (star.n_turned(place), place)).into();
        let reach = LONGEST_MOVE * star.shortest_edge(here);
        better.retain(|(n, place)| *n < n_here && here.distance(*place) <= reach);
        // The distance test takes longest, so it comes last and in the order of benefit.
        better.sort_by_key(|(n, _)| *n);
        better.into_iter().find(|(_, place)| star.stays_near_original([here, *place])).map(|(_, place)| (v, place))
    })
}

struct MovableStar<'a> {
    view: &'a RepairView<'a>,
    own: Vec<u32>,
    ring: Vec<u32>,
    sides: Vec<[Vec3; 2]>,
}

impl<'a> MovableStar<'a> {
    fn new(view: &'a RepairView<'a>, v: u32) -> Self {
        let side = |f: u32| {
            let corners = view.output.triangle(f);
            let at = view.output.face(f).iter().position(|&w| w == v).unwrap_or(0);
            [corners[(at + 1) % 3], corners[(at + 2) % 3]]
        };
        let own: Vec<u32> = view.output.faces_around().faces(v).collect();
        let sides = own.iter().copied().map(side).collect();
        Self { view, own, ring: ring(view.output, &[v]), sides }
    }

    fn candidate_positions(&self, here: Vec3) -> [Vec3; 3] {
        // Each neighbour occurs twice among the sides, once per adjacent face.
        let centroid = self.sides.iter().flatten().sum::<Vec3>() / (2 * self.sides.len()) as f32;
        let on_original = |p: Vec3| self.view.regions.closest_point(p, &self.ring).point;
        [on_original(here), on_original(centroid), centroid]
    }

    fn shortest_edge(&self, here: Vec3) -> f32 {
        self.sides.iter().flatten().map(|p| p.distance(here)).fold(f32::INFINITY, f32::min)
    }

    fn n_turned(&self, vertex: Vec3) -> usize {
        self.faces_with(vertex).filter(|&corners| self.view.is_turned(corners, &self.ring)).count()
    }

    fn stays_near_original(&self, from_to: [Vec3; 2]) -> bool {
        let inner = |[v, p, q]: [Vec3; 3]| [(v + p + q) / 3.0, (v + p) * 0.5];
        let patches = from_to.map(|vertex| FacePatch {
            faces: self.faces_with(vertex).collect(),
            inner: self.faces_with(vertex).flat_map(inner).collect(),
        });
        self.view.stays_near_original(&patches, [&self.ring, &self.ring], &self.own, MOST_GROWTH)
    }

    fn faces_with(&self, vertex: Vec3) -> impl Iterator<Item = [Vec3; 3]> {
        self.sides.iter().map(move |&[p, q]| [vertex, p, q])
    }
}

fn opposes_all_neighbors(output: &Output, f: u32) -> bool {
    let face = output.face(f);
    let normal = |f: u32| area_normal(output.triangle(f));
    let is_adjacent = |g: u32| g != f && output.face(g).iter().filter(|v| face.contains(v)).count() == 2;
    let mut neighbors = face.iter().flat_map(|&v| output.faces_around().faces(v)).filter(|&g| is_adjacent(g));
    neighbors.all(|g| normal(g).dot(normal(f)) < 0.0)
}

fn find_opposed_faces(pulse: Pulse, output: &Output, least: f32) -> Vec<u32> {
    let normal = |f: usize| area_normal(output.triangle(f as u32));
    let mut means = vec![Vec3::ZERO; output.positions.len()];
    // Area normals weight the mean by area.
    add_faces(pulse, &mut means, output.faces(), normal, |mean, normal, _| *mean += normal);
    indices_where(pulse, output.faces(), |f, face| {
        let normal = normal(f as usize);
        face.iter().any(|&v| are_opposed(normal, means[v as usize], least))
    })
}

/// Returns which former foldovers and faces at touched vertices oppose the faces around a corner now.
fn find_remaining_foldovers(
    output: &Output,
    mut foldovers: Vec<u32>,
    touched: &FxHashSet<u32>,
    least: f32,
) -> Vec<u32> {
    let normal = |f: u32| area_normal(output.triangle(f));
    let mean = |v: u32| output.faces_around().faces(v).map(normal).sum::<Vec3>();
    // A flip may have folded other faces.
    foldovers.extend(touched.iter().flat_map(|&v| output.faces_around().faces(v)));
    foldovers.sort_unstable();
    foldovers.dedup();
    foldovers.retain(|&f| output.face(f).iter().any(|&v| are_opposed(normal(f), mean(v), least)));
    foldovers
}

struct RepairView<'a> {
    regions: &'a Regions,
    output: &'a Output,
    least: f32,
}

struct TurnedFace {
    near: Vec<u32>,
    most_growth: f32,
}

impl RepairView<'_> {
    fn corners(&self, face: [u32; 3]) -> [Vec3; 3] {
        face.map(|v| self.output.positions[v as usize])
    }

    fn normals(&self, corners: [Vec3; 3], near: &[u32]) -> [Vec3; 2] {
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        [area_normal(corners), self.regions.closest_point(centroid, near).normal]
    }

    fn is_turned(&self, corners: [Vec3; 3], near: &[u32]) -> bool {
        let [own, original] = self.normals(corners, near);
        are_opposed(own, original, self.least)
    }

    fn surroundings_if_turned(&self, f: u32) -> Option<TurnedFace> {
        let near = neighbourhood(&[f], self.output);
        if !near.iter().all(|&v| self.regions.contains(v)) {
            return None;
        }
        let [own, original] = self.normals(self.output.triangle(f), &near);
        // The repair of a foldover may cost more than that of a leaning face.
        let most_growth = if own.dot(original) <= 0.0 { MOST_GROWTH } else { LEANING_GROWTH };
        are_opposed(own, original, self.least).then_some(TurnedFace { near, most_growth })
    }

    /// Finds the longest edge whose flip repairs a turned face and uses no vertex of `touched`.
    fn find_flip(&self, f: u32, touched: &FxHashSet<u32>) -> Option<Diamond> {
        let turned = self.surroundings_if_turned(f)?;
        let length = |diamond: &Diamond| {
            let [a, b, ..] = diamond.corners.map(|v| self.output.positions[v as usize]);
            a.distance_squared(b)
        };
        let mut edges: Vec<Diamond> = diamonds(self.output.faces(), self.output.faces_around(), f).collect();
        // The longest edge is the most likely one to span a part of the original that the face misses.
        edges.sort_by(|x, y| length(y).total_cmp(&length(x)));
        edges.into_iter().find(|diamond| {
            let is_free = self.is_free(diamond) && !diamond.corners.iter().any(|v| touched.contains(v));
            let are_unturned =
                || !diamond.flipped_faces().iter().any(|&face| self.is_turned(self.corners(face), &turned.near));
            is_free && are_unturned() && self.may_flip(diamond, &turned)
        })
    }

    fn is_free(&self, diamond: &Diamond) -> bool {
        let around = self.output.faces_around();
        let [_, _, c, d] = diamond.corners;
        let n_faces: usize = diamond.corners.iter().map(|&v| around.corners(v).len()).sum();
        n_faces <= 4 * MOST_FACES && !around.has_edge(c, d) && !self.output.is_flip_forbidden(diamond)
    }

    fn may_flip(&self, diamond: &Diamond, turned: &TurnedFace) -> bool {
        let patches = [diamond.present_faces(), diamond.flipped_faces()].map(|pair| {
            let [[u, v, p], [_, _, q]] = pair.map(|face| self.corners(face));
            FacePatch {
                faces: vec![[u, v, p], [v, u, q]],
                inner: vec![(u + v + p) / 3.0, (u + v + q) / 3.0, (u + v) * 0.5],
            }
        });
        self.stays_near_original(&patches, [&turned.near, &diamond.corners], &diamond.faces, turned.most_growth)
    }

    /// Returns whether replacing the first patch by the second multiplies the local distance by at most `most_growth`.
    ///
    /// `own` are the first patch's faces. Distances are from a patch to the regions of `near`, and from points in the
    /// regions of `about` to the patch.
    fn stays_near_original(
        &self,
        patches: &[FacePatch; 2],
        [near, about]: [&[u32]; 2],
        own: &[u32],
        most_growth: f32,
    ) -> bool {
        let [mut before, mut after] = [0, 1].map(|i| {
            // From the patch to the original.
            let distances = patches[i].inner.iter().map(|&p| self.regions.closest_point(p, near).distance);
            distances.fold(0.0, f32::max)
        });
        // And from the original to the patch, unless another face is closer.
        let others = self.faces_at(about, own);
        // Only points of the original from which the second patch is farther count, unless another face is nearer.
        for point in self.regions.points(about) {
            let [was, is] = [0, 1].map(|i| distance(point, &patches[i].faces));
            if is > was + ROUNDING {
                let other_distance = distance(point, &others);
                before = before.max(was.min(other_distance));
                after = after.max(is.min(other_distance));
            }
        }
        after <= most_growth * before + ROUNDING
    }

    fn faces_at(&self, vertices: &[u32], without: &[u32]) -> Vec<[Vec3; 3]> {
        let faces = self.output.faces_around().faces_of_all(vertices.iter().copied());
        faces.into_iter().filter(|f| !without.contains(f)).map(|f| self.output.triangle(f)).collect()
    }
}

struct FacePatch {
    faces: Vec<[Vec3; 3]>,
    inner: Vec<Vec3>,
}

fn distance(point: Vec3, faces: &[[Vec3; 3]]) -> f32 {
    let to = |&corners: &[Vec3; 3]| nearest_point(point, corners).distance_squared(point);
    faces.iter().map(to).fold(f32::INFINITY, f32::min).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::prepare::surface::PreparedSurface;

    fn roof(slope: f32) -> TriMesh {
        let flat = shapes::grid(16, 16);
        let places = flat.positions().iter().map(|&[x, y, _]| [x, y, -slope * (x - 0.5).abs()]).collect();
        TriMesh::new(places, flat.faces().to_vec()).unwrap()
    }

    const LEFT: u32 = 8;
    const RIGHT: u32 = 17 * 16 + 8;
    const BACK: u32 = 17 * 8 + 16;
    const FRONT: u32 = 17 * 8;

    fn coarse(surface: &PreparedSurface, corners: [u32; 4]) -> Output {
        let positions = corners.map(|v| surface.positions[v as usize]).to_vec();
        Output::from_original(&surface.positions, positions, vec![[0, 1, 2], [1, 0, 3]])
    }

    #[test]
    fn a_ridge_keeps_its_edge() {
        let roof = roof(0.5);
        let original = Original::bare(&roof);
        let may_flip = |corners: [u32; 4]| {
            let output = coarse(&original.surface, corners);
            let regions = original.collect_regions(&output.vertex_of, &[true; 4]);
            let view = RepairView { regions: &regions, output: &output, least: 0.0 };
            let turned = TurnedFace { near: vec![0, 1, 2, 3], most_growth: MOST_GROWTH };
            view.may_flip(&Diamond { faces: [0, 1], corners: [0, 1, 2, 3] }, &turned)
        };
        assert!(!may_flip([FRONT, BACK, LEFT, RIGHT]));
        assert!(may_flip([LEFT, RIGHT, BACK, FRONT]));
    }

    #[test]
    fn an_edge_under_a_steep_roof_gives_way_where_the_result_is_coarse() {
        let roof = roof(4.0);
        let original = Original::bare(&roof);
        let n_flipped =
            |corners: [u32; 4], is_coarse: bool| repair(&original, &mut coarse(&original.surface, corners), is_coarse);
        let across = [LEFT, RIGHT, BACK, FRONT];
        assert_eq!([n_flipped(across, true), n_flipped(across, false)], [1, 0]);
        assert_eq!(n_flipped([FRONT, BACK, LEFT, RIGHT], true), 0);
    }

    #[test]
    fn a_foldover_in_a_plane_is_repaired() {
        let mesh = shapes::grid(8, 8);
        let original = Original::bare(&mesh);
        // Vertex 3 is inside the first face, so the second one is turned down.
        let corners = [[0u32, 4], [8, 4], [4, 8], [4, 6], [4, 0]].map(|[i, j]| 9 * i + j);
        let positions = corners.map(|v| original.surface.positions[v as usize]).to_vec();
        let faces = vec![[0, 1, 2], [1, 0, 3], [3, 0, 4], [1, 3, 4]];
        let mut output = Output::from_original(&original.surface.positions, positions, faces);
        // All other vertices belong to the first region.
        let region = |v: u32| corners.iter().position(|&c| c == v).unwrap_or(0) as u32;
        output.vertex_of = (0..original.surface.n_vertices() as u32).map(region).collect();
        assert_eq!([0; 2].map(|_| repair(&original, &mut output, false)), [1, 0]);
        assert!((0..4).all(|f| area_normal(output.triangle(f)).z > 0.0), "{:?}", output.faces());
    }
}
