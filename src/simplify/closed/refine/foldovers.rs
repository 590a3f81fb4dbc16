//! Foldover repair: a face that looks away from the original gives its longest edge to the other diagonal, or,
//! where no flip helps, one of its corners another place. Where few faces stand for much, so do those that lean: an edge can
//! span a hollow, and nothing before looks at how far the middle of an edge lies off.
//!
//! Collapse and fit turn no face far, but a face can end up where the original looks another way. Such a face
//! looks away from the mean of the faces around it, which is what is searched for; thin parts have such faces, too,
//! so that the original's normal nearby decides.

use glam::Vec3;
use rustc_hash::FxHashSet;

use crate::geometry::triangle::{area_normal, nearest_point};
use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::{add_faces, indices_where};
use crate::simplify::closed::diamond::{Diamond, diamonds};
use crate::simplify::closed::original::{Original, Regions};
use crate::simplify::closed::output::Output;

/// How often what is still folded is looked through. Of 57 results of nineteen training meshes at ratios 0.01 to 0.05
/// the second and third round change 13, three more one.
const ROUNDS: usize = 3;
/// How many times farther from the original than what was there what a repair leaves may lie. Nineteen training meshes
/// at ratios 0.01 to 0.05: at 1 eight foldovers are left and not four, at 3 four again and the largest distance 0.4 %
/// farther. Without repair it is 16.
const MOST_LOSS: f32 = 1.5;
/// The same for a face that only leans: the repair has to be worth it. Nineteen training meshes at ratios 0.01 to 0.05:
/// the largest distance is 0.6 % farther at 0.35; at 1 and 1.4 the mean is 0.1 % farther.
const LEANING_LOSS: f32 = 0.7;
/// Cosine between a face and the original below which it leans. Nineteen training meshes at ratios 0.01 to 0.05: the
/// largest distance is 0.9 % farther at 0, where no face leans; at 0.6 it is 1.4 % nearer, the mean 0.1 % farther, and
/// more faces are looked at.
const LEANING: f32 = 0.3;
/// Share of its shortest edge that a corner may go: farther on it would stand for another place than the collapse
/// chose. Of 57 results of training meshes one differs at 0.4; at 1.5 four do, the mean distance 0.1 % farther.
const MOST_WAY: f32 = 0.75;
/// Faces at a vertex up to which it is looked after: a hub of hundreds would take longer than all else. Of 57 results
/// of training meshes two differ at 12, none at 48.
const MOST_FACES: usize = 24;
/// Distances below which nothing is lost, in boxes of about unit size: eight roundings of a coordinate. At 0 and 1e-5
/// no figure moves by more than 0.1 % (57 results of training meshes).
const ROUNDING: f32 = 1e-6;

/// Repairs foldovers by flips, and by moving a corner where no flip helps; returns how many edges it flipped. Where the result
/// is coarse (many vertices of the original share one of the result), faces that lean are repaired, too.
pub fn repair(original: &Original, output: &mut Output, is_coarse: bool) -> usize {
    let least = if is_coarse { LEANING } else { 0.0 };
    let folded = folded_faces(original, output, least);
    if folded.is_empty() {
        return 0;
    }
    let regions = original.regions(&output.vertex_of, &marked(output, &beside(&folded, output)));
    let (n_flipped, mut folded) = flip_folded(&regions, output, folded, least);
    // A corner is moved where a face looks away, and not for one that leans.
    let is_stuck =
        |&f: &u32| View { regions: &regions, output, least: 0.0 }.turned(f).is_some() && opposes_all(output, f);
    folded.retain(is_stuck);
    if !folded.is_empty() {
        move_corners(original, output, &folded);
    }
    n_flipped
}

/// The faces that look elsewhere than the faces around them, and than the original where a walk finds that.
fn folded_faces(original: &Original, output: &Output, least: f32) -> Vec<u32> {
    let mut folded = against_their_surroundings(original.surface.pulse, output, least);
    if folded.is_empty() {
        return folded;
    }
    let first: Vec<u32> = folded.iter().map(|&f| output.face(f)[0]).collect();
    let starts = original.anchors(&output.positions, &output.vertex_of, &marked(output, &first));
    folded.retain(|&f| {
        let corners = output.triangle(f);
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        let start = starts[output.face(f)[0] as usize];
        turns(original.closest_near(centroid, start).normal, area_normal(corners), least)
    });
    folded
}

/// Flips edges of folded faces, in rounds while that changes something; returns how many, and which faces are still folded.
fn flip_folded(regions: &Regions, output: &mut Output, mut folded: Vec<u32>, least: f32) -> (usize, Vec<u32>) {
    let mut n_flipped = 0;
    let mut due = folded.clone();
    for _ in 0..ROUNDS {
        let mut touched: FxHashSet<u32> = FxHashSet::default();
        for &f in &due {
            if let Some(diamond) = (View { regions, output, least }).find_flip(f, &touched) {
                output.flip(&diamond);
                touched.extend(diamond.corners);
                n_flipped += 1;
            }
        }
        if touched.is_empty() {
            break;
        }
        folded = still_folded(output, folded, &touched, least);
        // Only near what changed can anything be different.
        let is_near = |f: &&u32| beside(&[**f], output).iter().any(|v| touched.contains(v));
        due = folded.iter().filter(is_near).copied().collect();
    }
    (n_flipped, folded)
}

/// Moves one corner of each of these faces, where that helps.
fn move_corners(original: &Original, output: &mut Output, folded: &[u32]) {
    let rings: Vec<u32> = folded.iter().flat_map(|&f| ring(output, &output.face(f))).collect();
    let regions = original.regions(&output.vertex_of, &marked(output, &rings));
    for &f in folded {
        if let Some((v, place)) = better_corner(&View { regions: &regions, output, least: 0.0 }, f) {
            output.positions[v as usize] = place;
        }
    }
}

/// Whether the cosine between two directions is at most zero, or below this.
fn turns(a: Vec3, b: Vec3, least: f32) -> bool {
    let along = a.dot(b);
    along <= 0.0 || along * along < least * least * a.length_squared() * b.length_squared()
}

/// Whether each vertex is one of these.
fn marked(output: &Output, vertices: &[u32]) -> Vec<bool> {
    let mut marked = vec![false; output.positions.len()];
    vertices.iter().for_each(|&v| marked[v as usize] = true);
    marked
}

/// The corners of some faces and of those beyond their edges.
fn beside(of: &[u32], output: &Output) -> Vec<u32> {
    let mut vertices = Vec::with_capacity(6 * of.len());
    for &f in of {
        let [a, b, c] = output.face(f);
        let beyond = [(b, a), (c, b), (a, c)].into_iter().filter_map(|(u, v)| output.around().along(u, v));
        let opposite = beyond.flat_map(|g| output.face(g)).filter(|v| ![a, b, c].contains(v));
        vertices.extend([a, b, c].into_iter().chain(opposite));
    }
    vertices
}

/// The corners of the faces at these vertices, each once, ascending.
fn ring(output: &Output, vertices: &[u32]) -> Vec<u32> {
    let faces = vertices.iter().flat_map(|&v| output.around().faces(v));
    let mut ring: Vec<u32> = faces.flat_map(|f| output.face(f)).collect();
    ring.sort_unstable();
    ring.dedup();
    ring
}

/// Where a corner of a face that looks away would better be: fewer of the faces around it look elsewhere there, and it is nowhere
/// far.
fn better_corner(view: &View, f: u32) -> Option<(u32, Vec3)> {
    let View { output, .. } = view;
    let is_movable = |v: &u32| !output.pins.has(*v) && output.around().corners(*v).len() <= MOST_FACES / 2;
    output.face(f).into_iter().filter(is_movable).find_map(|v| {
        let here = output.positions[v as usize];
        let star = Star::new(view, v);
        let n_here = star.n_turned(here);
        let mut better: Vec<(usize, Vec3)> = star.other_places(here).map(|place| (star.n_turned(place), place)).into();
        let reach = MOST_WAY * star.shortest_edge(here);
        better.retain(|(n, place)| *n < n_here && here.distance(*place) <= reach);
        better.sort_by_key(|(n, _)| *n);
        better.into_iter().find(|(_, place)| star.keeps_near([here, *place])).map(|(_, place)| (v, place))
    })
}

/// The faces at a vertex that may move, and the original near them.
struct Star<'a> {
    view: &'a View<'a>,
    /// The faces.
    own: Vec<u32>,
    /// The vertices of the faces.
    ring: Vec<u32>,
    /// The other two corners of each face.
    sides: Vec<[Vec3; 2]>,
}

impl<'a> Star<'a> {
    fn new(view: &'a View<'a>, v: u32) -> Self {
        let side = |f: u32| {
            let corners = view.output.triangle(f);
            let at = view.output.face(f).iter().position(|&w| w == v).unwrap_or(0);
            [corners[(at + 1) % 3], corners[(at + 2) % 3]]
        };
        let own: Vec<u32> = view.output.around().faces(v).collect();
        let sides = own.iter().copied().map(side).collect();
        Self { view, own, ring: ring(view.output, &[v]), sides }
    }

    /// Where else the vertex could be: on the original near there, amid its neighbours, or on the original there.
    fn other_places(&self, here: Vec3) -> [Vec3; 3] {
        let amid = self.sides.iter().flatten().sum::<Vec3>() / (2 * self.sides.len()) as f32;
        let on_original = |p: Vec3| self.view.regions.closest_point(p, &self.ring).point;
        [on_original(here), on_original(amid), amid]
    }

    /// From the vertex to the nearest of its neighbours.
    fn shortest_edge(&self, here: Vec3) -> f32 {
        self.sides.iter().flatten().map(|p| p.distance(here)).fold(f32::INFINITY, f32::min)
    }

    /// How many of the faces look elsewhere than the original with their vertex there.
    fn n_turned(&self, vertex: Vec3) -> usize {
        self.with(vertex).filter(|&corners| self.view.is_turned(corners, &self.ring)).count()
    }

    /// Whether the vertex may go from the first place to the second one.
    fn keeps_near(&self, from_to: [Vec3; 2]) -> bool {
        let inner = |[v, p, q]: [Vec3; 3]| [(v + p + q) / 3.0, (v + p) * 0.5];
        let patches = from_to.map(|vertex| Patch {
            faces: self.with(vertex).collect(),
            inner: self.with(vertex).flat_map(inner).collect(),
        });
        self.view.keeps_near(&patches, [&self.ring, &self.ring], &self.own, MOST_LOSS)
    }

    fn with(&self, vertex: Vec3) -> impl Iterator<Item = [Vec3; 3]> {
        self.sides.iter().map(move |&[p, q]| [vertex, p, q])
    }
}

/// Whether a face looks against every face that it shares an edge with.
fn opposes_all(output: &Output, f: u32) -> bool {
    let face = output.face(f);
    let normal = |f: u32| area_normal(output.triangle(f));
    let beside = |g: u32| g != f && output.face(g).iter().filter(|v| face.contains(v)).count() == 2;
    let mut neighbors = face.iter().flat_map(|&v| output.around().faces(v)).filter(|&g| beside(g));
    neighbors.all(|g| normal(g).dot(normal(f)) < 0.0)
}

/// The faces that look elsewhere than the mean normal at one of their corners.
fn against_their_surroundings(pulse: Pulse, output: &Output, least: f32) -> Vec<u32> {
    let normal = |f: usize| area_normal(output.triangle(f as u32));
    let mut means = vec![Vec3::ZERO; output.positions.len()];
    add_faces(pulse, &mut means, output.faces(), normal, |mean, normal, _| *mean += normal);
    indices_where(pulse, output.faces(), |f, face| {
        let normal = normal(f as usize);
        face.iter().any(|&v| turns(normal, means[v as usize], least))
    })
}

/// Of the faces that were `folded` and those at `touched` vertices, the ones that are.
fn still_folded(output: &Output, mut folded: Vec<u32>, touched: &FxHashSet<u32>, least: f32) -> Vec<u32> {
    let normal = |f: u32| area_normal(output.triangle(f));
    let mean = |v: u32| output.around().faces(v).map(normal).sum::<Vec3>();
    folded.extend(touched.iter().flat_map(|&v| output.around().faces(v)));
    folded.sort_unstable();
    folded.dedup();
    folded.retain(|&f| output.face(f).iter().any(|&v| turns(normal(f), mean(v), least)));
    folded
}

/// The output over the original.
struct View<'a> {
    regions: &'a Regions,
    output: &'a Output,
    /// Cosine between a face and the original below which it looks elsewhere.
    least: f32,
}

/// The surroundings of a face that looks elsewhere than the original.
struct Turned {
    /// Its corners and those of the faces beyond its edges.
    near: Vec<u32>,
    /// How many times farther from the original than what was there what a repair leaves may lie.
    most_loss: f32,
}

impl View<'_> {
    fn corners(&self, face: [u32; 3]) -> [Vec3; 3] {
        face.map(|v| self.output.positions[v as usize])
    }

    /// Normals of a face and of the original beneath its centroid, as far as that lies in the regions of these vertices.
    fn normals(&self, corners: [Vec3; 3], near: &[u32]) -> [Vec3; 2] {
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        [area_normal(corners), self.regions.closest_point(centroid, near).normal]
    }

    /// Whether a face looks elsewhere than the original beneath it.
    fn is_turned(&self, corners: [Vec3; 3], near: &[u32]) -> bool {
        let [own, original] = self.normals(corners, near);
        turns(own, original, self.least)
    }

    /// What lies about face `f`, if it looks elsewhere than the original and all of that is known there.
    fn turned(&self, f: u32) -> Option<Turned> {
        let near = beside(&[f], self.output);
        if !near.iter().all(|&v| self.regions.has(v)) {
            return None;
        }
        let [own, original] = self.normals(self.output.triangle(f), &near);
        let most_loss = if own.dot(original) <= 0.0 { MOST_LOSS } else { LEANING_LOSS };
        turns(own, original, self.least).then_some(Turned { near, most_loss })
    }

    /// Of the edges of a face that looks elsewhere, the longest whose other diagonal is free and makes two faces that look
    /// right and lie not much farther from the original; no seam, and none at a vertex that was `touched`.
    fn find_flip(&self, f: u32, touched: &FxHashSet<u32>) -> Option<Diamond> {
        let turned = self.turned(f)?;
        let length = |diamond: &Diamond| {
            let [a, b, ..] = diamond.corners.map(|v| self.output.positions[v as usize]);
            a.distance_squared(b)
        };
        let mut edges: Vec<Diamond> = diamonds(self.output.faces(), self.output.around(), f).collect();
        edges.sort_by(|x, y| length(y).total_cmp(&length(x)));
        edges.into_iter().find(|diamond| {
            let is_free = self.is_free(diamond) && !diamond.corners.iter().any(|v| touched.contains(v));
            let look_right = || !diamond.flipped().iter().any(|&face| self.is_turned(self.corners(face), &turned.near));
            is_free && look_right() && self.may_flip(diamond, &turned)
        })
    }

    /// Whether nothing but the original forbids a diamond its other diagonal.
    fn is_free(&self, diamond: &Diamond) -> bool {
        let around = self.output.around();
        let [_, _, c, d] = diamond.corners;
        let n_faces: usize = diamond.corners.iter().map(|&v| around.corners(v).len()).sum();
        n_faces <= 4 * MOST_FACES && !around.joins(c, d) && !self.output.is_held(diamond)
    }

    /// Whether the other diagonal leaves the result as near to the original as a repair of the turned face has to.
    fn may_flip(&self, diamond: &Diamond, turned: &Turned) -> bool {
        let patches = [diamond.pair(), diamond.flipped()].map(|pair| {
            let [[u, v, p], [_, _, q]] = pair.map(|face| self.corners(face));
            Patch {
                faces: vec![[u, v, p], [v, u, q]],
                inner: vec![(u + v + p) / 3.0, (u + v + q) / 3.0, (u + v) * 0.5],
            }
        });
        self.keeps_near(&patches, [&turned.near, &diamond.corners], &diamond.faces, turned.most_loss)
    }

    /// Whether the second patch in place of the first one, made of these `own` faces, leaves the largest distance between the
    /// original and the result about it at `most_loss` times what it was or less. Distances of the result are to the regions
    /// `near`, those of the original from points in the regions `about`.
    fn keeps_near(&self, patches: &[Patch; 2], [near, about]: [&[u32]; 2], own: &[u32], most_loss: f32) -> bool {
        let [mut before, mut after] = [0, 1].map(|i| {
            let distances = patches[i].inner.iter().map(|&p| self.regions.closest_point(p, near).distance);
            distances.fold(0.0, f32::max)
        });
        let others = self.faces_at(about, own);
        for point in self.regions.points(about) {
            let [was, is] = [0, 1].map(|i| distance(point, &patches[i].faces));
            if is > was + ROUNDING {
                let beside = distance(point, &others);
                before = before.max(was.min(beside));
                after = after.max(is.min(beside));
            }
        }
        after <= most_loss * before + ROUNDING
    }

    /// The faces at these vertices, each once, without some.
    fn faces_at(&self, vertices: &[u32], without: &[u32]) -> Vec<[Vec3; 3]> {
        let faces = self.output.around().faces_of_all(vertices.iter().copied());
        faces.into_iter().filter(|f| !without.contains(f)).map(|f| self.output.triangle(f)).collect()
    }
}

/// A few faces that others may stand in for.
struct Patch {
    faces: Vec<[Vec3; 3]>,
    /// Places within them whose distance from the original counts.
    inner: Vec<Vec3>,
}

/// Distance from a point to the nearest of these faces.
fn distance(point: Vec3, faces: &[[Vec3; 3]]) -> f32 {
    let to = |&corners: &[Vec3; 3]| nearest_point(point, corners).distance_squared(point);
    faces.iter().map(to).fold(f32::INFINITY, f32::min).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::prepare::surface::Surface;

    /// A roof with its ridge along y over 16 x 16 quads: vertex 17 i + j at x = i / 16, y = j / 16.
    fn roof(slope: f32) -> TriMesh {
        let flat = shapes::grid(16, 16);
        let places = flat.positions().iter().map(|&[x, y, _]| [x, y, -slope * (x - 0.5).abs()]).collect();
        TriMesh::new(places, flat.faces().to_vec()).unwrap()
    }

    const LEFT: u32 = 8;
    const RIGHT: u32 = 17 * 16 + 8;
    const BACK: u32 = 17 * 8 + 16;
    const FRONT: u32 = 17 * 8;

    /// Faces over four vertices of a roof.
    fn coarse(surface: &Surface, corners: [u32; 4]) -> Output {
        let positions = corners.map(|v| surface.positions[v as usize]).to_vec();
        Output::over(&surface.positions, positions, vec![[0, 1, 2], [1, 0, 3]])
    }

    #[test]
    fn a_ridge_keeps_its_edge() {
        let roof = roof(0.5);
        let original = Original::bare(&roof);
        let may_flip = |corners: [u32; 4]| {
            let output = coarse(&original.surface, corners);
            let regions = original.regions(&output.vertex_of, &[true; 4]);
            let view = View { regions: &regions, output: &output, least: 0.0 };
            let turned = Turned { near: vec![0, 1, 2, 3], most_loss: MOST_LOSS };
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
        // Vertex 3 lies within the first face, so that the second one looks down.
        let corners = [[0u32, 4], [8, 4], [4, 8], [4, 6], [4, 0]].map(|[i, j]| 9 * i + j);
        let positions = corners.map(|v| original.surface.positions[v as usize]).to_vec();
        let faces = vec![[0, 1, 2], [1, 0, 3], [3, 0, 4], [1, 3, 4]];
        let mut output = Output::over(&original.surface.positions, positions, faces);
        // All but the corners belong to the first region.
        let region = |v: u32| corners.iter().position(|&c| c == v).unwrap_or(0) as u32;
        output.vertex_of = (0..original.surface.n_vertices() as u32).map(region).collect();
        assert_eq!([0; 2].map(|_| repair(&original, &mut output, false)), [1, 0]);
        assert!((0..4).all(|f| area_normal(output.triangle(f)).z > 0.0), "{:?}", output.faces());
    }
}
