//! The last few folds: a face that looks away from the original gives its longest edge to the other diagonal, or,
//! where no flip helps, one of its corners another place.
//!
//! Collapse and fit turn no face far, but a face can end up where the original looks another way. Such a face
//! looks away from the mean of the faces around it, which is what is searched for; thin parts have such faces, too,
//! so that the original's normal nearby decides.

use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::geometry::triangle::{area_normal, nearest_point};
use crate::mesh::shares::add_faces;

use super::beneath::Beneath;
use super::corners::Corners;
use super::faces_around::FacesAround;
use super::half::OnPlane;
use super::nearest::{anchors, normal_near};
use super::surface::Surface;

/// How often what is still folded is looked through.
const ROUNDS: usize = 3;
/// How many times farther from the original than what was there what a mend leaves may lie.
const MOST_LOSS: f32 = 1.5;
/// Faces at a vertex up to which it is looked after: a hub of hundreds would take longer than all else.
const MOST_FACES: usize = 24;
/// Distances below which nothing is lost, in boxes of about unit size.
const ROUNDING: f32 = 1e-6;

/// The result as far as folds are mended.
pub(super) struct Folded<'a> {
    /// Normalised positions, n_vertices x 3.
    pub positions: &'a mut [Vec3],
    /// Faces, n_faces x 3.
    pub faces: &'a mut [[u32; 3]],
    /// What the corners carry: seams stay, and corners are flipped with their faces.
    pub corners: Option<&'a mut Corners>,
    /// Whether each vertex stays where it is; empty where all may move.
    pub fixed: &'a [bool],
    /// What stays on the plane, where this is one half of a mirrored mesh.
    pub on_plane: Option<&'a OnPlane>,
}

/// Mends folded faces by flips, and by moving a corner where no flip helps; returns how many edges it flipped.
pub(super) fn unfold(surface: &Surface, vertex_of: &[u32], result: &mut Folded) -> usize {
    let Folded { positions, faces, corners, fixed, on_plane } = result;
    let on_plane = *on_plane;
    let mut folded = folded_faces(positions, faces);
    if folded.is_empty() {
        return 0;
    }
    let first: Vec<u32> = folded.iter().map(|&f| faces[f as usize][0]).collect();
    let starts = anchors(surface, positions, vertex_of, &marked(positions.len(), &first));
    folded.retain(|&f| seems_against(surface, faces[f as usize], positions, &starts));
    if folded.is_empty() {
        return 0;
    }
    let mut around = FacesAround::new(positions.len(), faces);
    let beneath = Beneath::new(surface, vertex_of, &marked(positions.len(), &beside(&folded, faces, &around)));
    let mut n_flipped = 0;
    let mut due = folded.clone();
    for _ in 0..ROUNDS {
        let mut touched: FxHashSet<u32> = FxHashSet::default();
        for &f in &due {
            let mend = Mend { beneath: &beneath, positions, faces, around: &around };
            if let Some(diamond) = mend.find_flip(f, &touched, corners.as_deref(), on_plane) {
                corners.iter_mut().for_each(|corners| corners.flip(faces, diamond.faces, diamond.corners));
                diamond.flip(faces, &mut around);
                touched.extend(diamond.corners);
                n_flipped += 1;
            }
        }
        if touched.is_empty() {
            break;
        }
        folded = still_folded(positions, faces, &around, folded, &touched);
        // Only near what changed can anything be different.
        let is_near = |f: &&u32| beside(&[**f], faces, &around).iter().any(|v| touched.contains(v));
        due = folded.iter().filter(is_near).copied().collect();
    }
    let is_stuck = |&f: &u32| {
        Mend { beneath: &beneath, positions, faces, around: &around }.is_turned(f)
            && opposes_all(positions, faces, &around, f)
    };
    folded.retain(is_stuck);
    if !folded.is_empty() {
        let stays =
            |v: u32| fixed.get(v as usize).is_some_and(|&fixed| fixed) || on_plane.is_some_and(|plane| plane.has(v));
        let rings: Vec<u32> = folded.iter().flat_map(|&f| ring(faces, &around, &faces[f as usize])).collect();
        let beneath = Beneath::new(surface, vertex_of, &marked(positions.len(), &rings));
        folded.iter().for_each(|&f| move_corner(&beneath, positions, faces, &around, f, &stays));
    }
    n_flipped
}

/// Whether a face looks away from the original where a walk from one of its corners finds that.
fn seems_against(surface: &Surface, face: [u32; 3], positions: &[Vec3], starts: &[u32]) -> bool {
    let corners = face.map(|v| positions[v as usize]);
    let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
    normal_near(surface, centroid, starts[face[0] as usize]).dot(area_normal(corners)) <= 0.0
}

/// Whether each of so many vertices is one of these.
fn marked(n_vertices: usize, vertices: &[u32]) -> Vec<bool> {
    let mut marked = vec![false; n_vertices];
    vertices.iter().for_each(|&v| marked[v as usize] = true);
    marked
}

/// The corners of some faces and of those beyond their edges.
fn beside(of: &[u32], faces: &[[u32; 3]], around: &FacesAround) -> Vec<u32> {
    let mut vertices = Vec::with_capacity(6 * of.len());
    for &f in of {
        let [a, b, c] = faces[f as usize];
        let beyond = [(b, a), (c, b), (a, c)].into_iter().filter_map(|(u, v)| around.along(u, v));
        let opposite = beyond.flat_map(|g| faces[g as usize]).filter(|v| ![a, b, c].contains(v));
        vertices.extend([a, b, c].into_iter().chain(opposite));
    }
    vertices
}

/// The corners of the faces at these vertices, each once, ascending.
fn ring(faces: &[[u32; 3]], around: &FacesAround, vertices: &[u32]) -> Vec<u32> {
    let mut ring: Vec<u32> = vertices.iter().flat_map(|&v| around.faces(v)).flat_map(|f| faces[f as usize]).collect();
    ring.sort_unstable();
    ring.dedup();
    ring
}

/// Moves a corner of a face that looks away to where fewer of the faces around it do, if that goes nowhere far.
fn move_corner(
    beneath: &Beneath,
    positions: &mut [Vec3],
    faces: &[[u32; 3]],
    around: &FacesAround,
    f: u32,
    stays: &dyn Fn(u32) -> bool,
) {
    let is_movable = |v: &u32| !stays(*v) && around.corners(*v).len() <= MOST_FACES / 2;
    for v in faces[f as usize].into_iter().filter(is_movable) {
        let before = positions[v as usize];
        let star = Star::new(&Mend { beneath, positions, faces, around }, v);
        let n_before = star.n_against(before);
        let mut better: Vec<(usize, Vec3)> =
            star.other_places(before).map(|place| (star.n_against(place), place)).into();
        better.retain(|(n, _)| *n < n_before);
        better.sort_by_key(|(n, _)| *n);
        if better.is_empty() {
            continue;
        }
        let points = star.points(&Mend { beneath, positions, faces, around }, v);
        if let Some((_, place)) = better.into_iter().find(|(_, place)| star.keeps_near(before, *place, &points)) {
            positions[v as usize] = place;
            return;
        }
    }
}

/// The faces at a vertex that may move, and the original near them.
struct Star<'a> {
    beneath: &'a Beneath,
    /// The vertices of the faces.
    ring: Vec<u32>,
    /// The other two corners of each face.
    sides: Vec<[Vec3; 2]>,
}

impl<'a> Star<'a> {
    fn new(mend: &Mend<'a>, v: u32) -> Self {
        let side = |f: u32| {
            let face = mend.faces[f as usize];
            let at = face.iter().position(|&w| w == v).unwrap_or(0);
            [face[(at + 1) % 3], face[(at + 2) % 3]].map(|w| mend.positions[w as usize])
        };
        let sides = mend.around.faces(v).map(side).collect();
        Self { beneath: mend.beneath, ring: ring(mend.faces, mend.around, &[v]), sides }
    }

    /// Points of the original, and how far they lie from the other faces around.
    fn points(&self, mend: &Mend, v: u32) -> Vec<(Vec3, f32)> {
        let own: Vec<u32> = mend.around.faces(v).collect();
        let others = mend.faces_at(&self.ring, &own);
        self.beneath.points(&self.ring).map(|p| (p, mend.distance(p, &others))).collect()
    }

    /// Where else the vertex could be: on the original near there, amid its neighbours, or on the original there.
    fn other_places(&self, here: Vec3) -> [Vec3; 3] {
        let amid = self.sides.iter().flatten().sum::<Vec3>() / (2 * self.sides.len()) as f32;
        let on_original = |p: Vec3| self.beneath.foot(p, &self.ring).point;
        [on_original(here), on_original(amid), amid]
    }

    /// How many of the faces look away from the original with their vertex there.
    fn n_against(&self, vertex: Vec3) -> usize {
        self.with(vertex).filter(|&corners| is_against(self.beneath, corners, &self.ring)).count()
    }

    /// Whether the faces lie not much farther from the original with their vertex at `then`, as far as that changes anything,
    /// than with it at `now`; the points of the original know how far they lie from other faces.
    fn keeps_near(&self, now: Vec3, then: Vec3, points: &[(Vec3, f32)]) -> bool {
        let [mut before, mut after] = [now, then].map(|vertex| {
            let inner = self.with(vertex).flat_map(|[v, p, q]| [(v + p + q) / 3.0, (v + p) * 0.5]);
            inner.map(|p| self.beneath.foot(p, &self.ring).distance).fold(0.0, f32::max)
        });
        for &(point, beside) in points {
            let to_faces = |corners| nearest_point(point, corners).distance(point);
            let [was, is] = [now, then].map(|vertex| self.with(vertex).map(to_faces).fold(beside, f32::min));
            if is > was + ROUNDING {
                (before, after) = (before.max(was), after.max(is));
            }
        }
        after <= MOST_LOSS * before + ROUNDING
    }

    fn with(&self, vertex: Vec3) -> impl Iterator<Item = [Vec3; 3]> {
        self.sides.iter().map(move |&[p, q]| [vertex, p, q])
    }
}

/// Whether a face looks against every face that it shares an edge with.
fn opposes_all(positions: &[Vec3], faces: &[[u32; 3]], around: &FacesAround, f: u32) -> bool {
    let face = faces[f as usize];
    let normal = |face: [u32; 3]| area_normal(face.map(|v| positions[v as usize]));
    let beside = |g: u32| g != f && faces[g as usize].iter().filter(|v| face.contains(v)).count() == 2;
    let mut neighbors = face.iter().flat_map(|&v| around.faces(v)).filter(|&g| beside(g));
    neighbors.all(|g| normal(faces[g as usize]).dot(normal(face)) < 0.0)
}

/// The faces that look away from the mean normal at one of their corners.
fn folded_faces(positions: &[Vec3], faces: &[[u32; 3]]) -> Vec<u32> {
    let normal = |f: usize| area_normal(faces[f].map(|v| positions[v as usize]));
    let mut means = vec![Vec3::ZERO; positions.len()];
    add_faces(&mut means, faces, normal, |mean, normal, _| *mean += normal);
    let is_folded = |f: &u32| {
        let normal = normal(*f as usize);
        faces[*f as usize].iter().any(|&v| normal.dot(means[v as usize]) < 0.0)
    };
    (0..faces.len() as u32).into_par_iter().filter(is_folded).collect()
}

/// Of the faces that were `folded` and those at `touched` vertices, the ones that are.
fn still_folded(
    positions: &[Vec3],
    faces: &[[u32; 3]],
    around: &FacesAround,
    mut folded: Vec<u32>,
    touched: &FxHashSet<u32>,
) -> Vec<u32> {
    if touched.is_empty() {
        return folded;
    }
    let normal = |f: u32| area_normal(faces[f as usize].map(|v| positions[v as usize]));
    let mean = |v: u32| around.faces(v).map(normal).sum::<Vec3>();
    folded.extend(touched.iter().flat_map(|&v| around.faces(v)));
    folded.sort_unstable();
    folded.dedup();
    folded.retain(|&f| faces[f as usize].iter().any(|&v| normal(f).dot(mean(v)) < 0.0));
    folded
}

/// Whether a face looks away from the original beneath its centroid, as far as that lies in the regions of these vertices.
fn is_against(beneath: &Beneath, corners: [Vec3; 3], near: &[u32]) -> bool {
    let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
    area_normal(corners).dot(beneath.foot(centroid, near).normal) <= 0.0
}

/// The result over the original.
struct Mend<'a> {
    beneath: &'a Beneath,
    positions: &'a [Vec3],
    faces: &'a [[u32; 3]],
    around: &'a FacesAround,
}

impl Mend<'_> {
    fn corners(&self, face: [u32; 3]) -> [Vec3; 3] {
        face.map(|v| self.positions[v as usize])
    }

    /// Whether face `f` looks away from the original, all of which is known there.
    fn is_turned(&self, f: u32) -> bool {
        let near = beside(&[f], self.faces, self.around);
        near.iter().all(|&v| self.beneath.has(v))
            && is_against(self.beneath, self.corners(self.faces[f as usize]), &near)
    }

    /// Of the edges of a face that looks away, the longest whose other diagonal is free and makes two faces that look
    /// right and lie not much farther from the original; no seam, and none at a vertex that was `touched`.
    fn find_flip(
        &self,
        f: u32,
        touched: &FxHashSet<u32>,
        seams: Option<&Corners>,
        on_plane: Option<&OnPlane>,
    ) -> Option<Diamond> {
        if !self.is_turned(f) {
            return None;
        }
        let near = beside(&[f], self.faces, self.around);
        let [a, b, c] = self.faces[f as usize];
        let length = |u: u32, v: u32| self.positions[u as usize].distance_squared(self.positions[v as usize]);
        let mut edges = [(a, b, c), (b, c, a), (c, a, b)];
        edges.sort_by(|x, y| length(y.0, y.1).total_cmp(&length(x.0, x.1)));
        edges.into_iter().find_map(|(a, b, c)| {
            let g = self.around.along(b, a)?;
            let d = *self.faces[g as usize].iter().find(|&&v| v != a && v != b)?;
            let diamond = Diamond { faces: [f, g], corners: [a, b, c, d] };
            let n_faces: usize = diamond.corners.iter().map(|&v| self.around.corners(v).len()).sum();
            let is_seam = || seams.is_some_and(|seams| seams.is_seam(self.faces, diamond.faces, [a, b]));
            let bridges = || on_plane.is_some_and(|on_plane| on_plane.has(c) && on_plane.has(d));
            let is_free = c != d
                && n_faces <= 4 * MOST_FACES
                && !diamond.corners.iter().any(|v| touched.contains(v))
                && !self.around.joins(c, d)
                && !bridges()
                && !is_seam();
            let look_right =
                || diamond.flipped().iter().all(|&face| !is_against(self.beneath, self.corners(face), &near));
            (is_free && look_right() && self.keeps_near(&diamond, &near)).then_some(diamond)
        })
    }

    /// Whether the other diagonal leaves the largest distance between the original and the result about it nearly what
    /// it was.
    fn keeps_near(&self, diamond: &Diamond, near: &[u32]) -> bool {
        let [old, new] = [diamond.faces.map(|f| self.faces[f as usize]), diamond.flipped()];
        let [a, b, c, d] = diamond.corners.map(|v| self.positions[v as usize]);
        let [mut before, mut after] = [[a, b, c, d], [c, d, b, a]].map(|[u, v, p, q]| {
            let inner = [(u + v + p) / 3.0, (u + v + q) / 3.0, (u + v) * 0.5];
            inner.iter().map(|&p| self.beneath.foot(p, near).distance).fold(0.0, f32::max)
        });
        let others = self.faces_at(&diamond.corners, &diamond.faces);
        for point in self.beneath.points(&diamond.corners) {
            let [there, then] = [old, new].map(|pair| self.distance(point, &pair));
            if then > there + ROUNDING {
                let beside = self.distance(point, &others);
                before = before.max(there.min(beside));
                after = after.max(then.min(beside));
            }
        }
        after <= MOST_LOSS * before + ROUNDING
    }

    /// The faces at these vertices, each once, without some.
    fn faces_at(&self, vertices: &[u32], without: &[u32]) -> Vec<[u32; 3]> {
        let mut faces: Vec<u32> = vertices.iter().flat_map(|&v| self.around.faces(v)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces.into_iter().filter(|f| !without.contains(f)).map(|f| self.faces[f as usize]).collect()
    }

    /// Distance from a point to the nearest of these faces.
    fn distance(&self, point: Vec3, faces: &[[u32; 3]]) -> f32 {
        let to = |&face: &[u32; 3]| nearest_point(point, self.corners(face)).distance_squared(point);
        faces.iter().map(to).fold(f32::INFINITY, f32::min).sqrt()
    }
}

/// An edge over which two faces meet: their corners `a b c` and `b a d`.
struct Diamond {
    faces: [u32; 2],
    corners: [u32; 4],
}

impl Diamond {
    /// The faces with the other diagonal.
    fn flipped(&self) -> [[u32; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[c, d, b], [d, c, a]]
    }

    fn flip(&self, faces: &mut [[u32; 3]], around: &mut FacesAround) {
        for (f, now) in self.faces.into_iter().zip(self.flipped()) {
            around.replace(f, std::mem::replace(&mut faces[f as usize], now), now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};

    #[test]
    fn a_ridge_keeps_its_edge() {
        // A roof with its ridge along y over 16 x 16 quads: vertex 17 i + j at x = i / 16, y = j / 16.
        let flat = shapes::grid(16, 16);
        let places = flat.positions().iter().map(|&[x, y, _]| [x, y, -0.5 * (x - 0.5).abs()]).collect();
        let mesh = TriMesh::new(places, flat.faces().to_vec()).unwrap();
        let surface = Surface::new(&mesh);
        let [left, right, back, front] = [8, 17 * 16 + 8, 17 * 8 + 16, 17 * 8];
        let keeps_near = |corners: [u32; 4]| {
            let positions = corners.map(|v| surface.positions[v as usize]);
            let nearest = |p: &Vec3| {
                let distance = |v: &usize| positions[*v].distance_squared(*p);
                (0..4).min_by(|v, w| distance(v).total_cmp(&distance(w))).unwrap() as u32
            };
            let vertex_of: Vec<u32> = surface.positions.iter().map(nearest).collect();
            let beneath = Beneath::new(&surface, &vertex_of, &[true; 4]);
            let faces = [[0, 1, 2], [1, 0, 3]];
            let around = FacesAround::new(4, &faces);
            let mend = Mend { beneath: &beneath, positions: &positions, faces: &faces, around: &around };
            mend.keeps_near(&Diamond { faces: [0, 1], corners: [0, 1, 2, 3] }, &[0, 1, 2, 3])
        };
        assert!(!keeps_near([front, back, left, right]));
        assert!(keeps_near([left, right, back, front]));
    }

    #[test]
    fn a_fold_in_a_plane_is_mended() {
        let mesh = shapes::grid(8, 8);
        let surface = Surface::new(&mesh);
        // Vertex 3 lies within the first face, so that the second one looks down.
        let corners = [[0u32, 4], [8, 4], [4, 8], [4, 6], [4, 0]].map(|[i, j]| 9 * i + j);
        let mut positions = corners.map(|v| surface.positions[v as usize]);
        let vertex_of: Vec<u32> = (0..surface.n_vertices() as u32)
            .map(|v| corners.iter().position(|&c| c == v).unwrap_or(0) as u32)
            .collect();
        let mut faces = vec![[0, 1, 2], [1, 0, 3], [3, 0, 4], [1, 3, 4]];
        let mut mend = || {
            let mut folded =
                Folded { positions: &mut positions, faces: &mut faces, corners: None, fixed: &[], on_plane: None };
            unfold(&surface, &vertex_of, &mut folded)
        };
        assert_eq!([mend(), mend()], [1, 0]);
        assert!(faces.iter().all(|f| area_normal(f.map(|v| positions[v as usize])).z > 0.0), "{faces:?}");
    }
}
