//! The last few folds: a face that looks away from the original gives its longest edge to the other diagonal, or,
//! where no flip helps, one of its corners another place. Where few faces stand for much, so do those that lean: an edge can
//! span a hollow, and nothing before looks at how far the middle of an edge lies off.
//!
//! Collapse and fit turn no face far, but a face can end up where the original looks another way. Such a face
//! looks away from the mean of the faces around it, which is what is searched for; thin parts have such faces, too,
//! so that the original's normal nearby decides.

use glam::Vec3;
use rustc_hash::FxHashSet;

use crate::geometry::triangle::{area_normal, nearest_point};
use crate::mesh::shares::{add_faces, indices_where};

use crate::simplify::closed::attributes::corners::Corners;
use crate::simplify::closed::beneath::Beneath;
use crate::simplify::closed::nearest::{anchors, normal_near};
use crate::simplify::closed::pins::OnPlane;
use crate::simplify::closed::prepare::surface::Surface;
use crate::simplify::closed::refine::diamond::{Diamond, diamonds};
use crate::simplify::closed::refine::faces_around::FacesAround;

/// How often what is still folded is looked through.
const ROUNDS: usize = 3;
/// How many times farther from the original than what was there what a mend leaves may lie.
const MOST_LOSS: f32 = 1.5;
/// The same for a face that only leans: the mend has to be worth it. By this the largest distances of the training meshes at a
/// twentieth of their vertices are 0.986 of what they were (geometric mean), the mean ones the same.
const LEANING_LOSS: f32 = 0.7;
/// Cosine between a face and the original below which it leans.
const LEANING: f32 = 0.3;
/// Share of its shortest edge that a corner may go: farther on it would stand for another place than the collapse chose.
const MOST_WAY: f32 = 0.75;
/// Faces at a vertex up to which it is looked after: a hub of hundreds would take longer than all else.
const MOST_FACES: usize = 24;
/// Distances below which nothing is lost, in boxes of about unit size.
const ROUNDING: f32 = 1e-6;

/// The result as far as folds are mended.
pub struct Folded<'a> {
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
    /// Whether many vertices of the original share one of the result, so that faces which lean are mended, too.
    pub is_coarse: bool,
}

/// Mends folded faces by flips, and by moving a corner where no flip helps; returns how many edges it flipped.
pub fn unfold(surface: &Surface, vertex_of: &[u32], result: &mut Folded) -> usize {
    let Folded { positions, faces, corners, fixed, on_plane, is_coarse } = result;
    let (on_plane, least) = (*on_plane, if *is_coarse { LEANING } else { 0.0 });
    let mut folded = folded_faces(positions, faces, least);
    if folded.is_empty() {
        return 0;
    }
    let first: Vec<u32> = folded.iter().map(|&f| faces[f as usize][0]).collect();
    let starts = anchors(surface, positions, vertex_of, &marked(positions.len(), &first));
    folded.retain(|&f| seems_turned(surface, faces[f as usize], positions, &starts, least));
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
            let mend = Mend { beneath: &beneath, positions, faces, around: &around, least };
            if let Some(diamond) = mend.find_flip(f, &touched, corners.as_deref(), on_plane) {
                corners.iter_mut().for_each(|corners| corners.flip(faces, diamond.faces, diamond.corners));
                for (f, now) in diamond.faces.into_iter().zip(diamond.flipped()) {
                    around.replace(f, std::mem::replace(&mut faces[f as usize], now), now);
                }
                touched.extend(diamond.corners);
                n_flipped += 1;
            }
        }
        if touched.is_empty() {
            break;
        }
        folded = still_folded((positions, faces), &around, folded, &touched, least);
        // Only near what changed can anything be different.
        let is_near = |f: &&u32| beside(&[**f], faces, &around).iter().any(|v| touched.contains(v));
        due = folded.iter().filter(is_near).copied().collect();
    }
    // A corner is moved where a face looks away, and not for one that leans.
    let is_stuck = |&f: &u32| {
        Mend { beneath: &beneath, positions, faces, around: &around, least: 0.0 }.turned(f).is_some()
            && opposes_all(positions, faces, &around, f)
    };
    folded.retain(is_stuck);
    if !folded.is_empty() {
        let stays =
            |v: u32| fixed.get(v as usize).is_some_and(|&fixed| fixed) || on_plane.is_some_and(|plane| plane.has(v));
        let rings: Vec<u32> = folded.iter().flat_map(|&f| ring(faces, &around, &faces[f as usize])).collect();
        let beneath = Beneath::new(surface, vertex_of, &marked(positions.len(), &rings));
        for &f in &folded {
            let mend = Mend { beneath: &beneath, positions, faces, around: &around, least: 0.0 };
            if let Some((v, place)) = better_corner(&mend, f, &stays) {
                positions[v as usize] = place;
            }
        }
    }
    n_flipped
}

/// Whether the cosine between two directions is at most zero, or below this.
fn turns(a: Vec3, b: Vec3, least: f32) -> bool {
    let along = a.dot(b);
    along <= 0.0 || along * along < least * least * a.length_squared() * b.length_squared()
}

/// Whether a face looks elsewhere than the original where a walk from one of its corners finds that.
fn seems_turned(surface: &Surface, face: [u32; 3], positions: &[Vec3], starts: &[u32], least: f32) -> bool {
    let corners = face.map(|v| positions[v as usize]);
    let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
    turns(normal_near(surface, centroid, starts[face[0] as usize]), area_normal(corners), least)
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

/// Where a corner of a face that looks away would better be: fewer of the faces around it look elsewhere there, and it is nowhere
/// far.
fn better_corner(mend: &Mend, f: u32, stays: &dyn Fn(u32) -> bool) -> Option<(u32, Vec3)> {
    let is_movable = |v: &u32| !stays(*v) && mend.around.corners(*v).len() <= MOST_FACES / 2;
    mend.faces[f as usize].into_iter().filter(is_movable).find_map(|v| {
        let here = mend.positions[v as usize];
        let star = Star::new(mend, v);
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
    mend: &'a Mend<'a>,
    /// The faces.
    own: Vec<u32>,
    /// The vertices of the faces.
    ring: Vec<u32>,
    /// The other two corners of each face.
    sides: Vec<[Vec3; 2]>,
}

impl<'a> Star<'a> {
    fn new(mend: &'a Mend<'a>, v: u32) -> Self {
        let side = |f: u32| {
            let face = mend.faces[f as usize];
            let at = face.iter().position(|&w| w == v).unwrap_or(0);
            [face[(at + 1) % 3], face[(at + 2) % 3]].map(|w| mend.positions[w as usize])
        };
        let own: Vec<u32> = mend.around.faces(v).collect();
        let sides = own.iter().copied().map(side).collect();
        Self { mend, own, ring: ring(mend.faces, mend.around, &[v]), sides }
    }

    /// Where else the vertex could be: on the original near there, amid its neighbours, or on the original there.
    fn other_places(&self, here: Vec3) -> [Vec3; 3] {
        let amid = self.sides.iter().flatten().sum::<Vec3>() / (2 * self.sides.len()) as f32;
        let on_original = |p: Vec3| self.mend.beneath.foot(p, &self.ring).point;
        [on_original(here), on_original(amid), amid]
    }

    /// From the vertex to the nearest of its neighbours.
    fn shortest_edge(&self, here: Vec3) -> f32 {
        self.sides.iter().flatten().map(|p| p.distance(here)).fold(f32::INFINITY, f32::min)
    }

    /// How many of the faces look elsewhere than the original with their vertex there.
    fn n_turned(&self, vertex: Vec3) -> usize {
        self.with(vertex).filter(|&corners| self.mend.is_turned(corners, &self.ring)).count()
    }

    /// Whether the vertex may go from the first place to the second one.
    fn keeps_near(&self, from_to: [Vec3; 2]) -> bool {
        let inner = |[v, p, q]: [Vec3; 3]| [(v + p + q) / 3.0, (v + p) * 0.5];
        let patches = from_to.map(|vertex| Patch {
            faces: self.with(vertex).collect(),
            inner: self.with(vertex).flat_map(inner).collect(),
        });
        self.mend.keeps_near(&patches, [&self.ring, &self.ring], &self.own, MOST_LOSS)
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

/// The faces that look elsewhere than the mean normal at one of their corners.
fn folded_faces(positions: &[Vec3], faces: &[[u32; 3]], least: f32) -> Vec<u32> {
    let normal = |f: usize| area_normal(faces[f].map(|v| positions[v as usize]));
    let mut means = vec![Vec3::ZERO; positions.len()];
    add_faces(&mut means, faces, normal, |mean, normal, _| *mean += normal);
    indices_where(faces, |f, face| {
        let normal = normal(f as usize);
        face.iter().any(|&v| turns(normal, means[v as usize], least))
    })
}

/// Of the faces that were `folded` and those at `touched` vertices, the ones that are.
fn still_folded(
    (positions, faces): (&[Vec3], &[[u32; 3]]),
    around: &FacesAround,
    mut folded: Vec<u32>,
    touched: &FxHashSet<u32>,
    least: f32,
) -> Vec<u32> {
    let normal = |f: u32| area_normal(faces[f as usize].map(|v| positions[v as usize]));
    let mean = |v: u32| around.faces(v).map(normal).sum::<Vec3>();
    folded.extend(touched.iter().flat_map(|&v| around.faces(v)));
    folded.sort_unstable();
    folded.dedup();
    folded.retain(|&f| faces[f as usize].iter().any(|&v| turns(normal(f), mean(v), least)));
    folded
}

/// The result over the original.
struct Mend<'a> {
    beneath: &'a Beneath,
    positions: &'a [Vec3],
    faces: &'a [[u32; 3]],
    around: &'a FacesAround,
    /// Cosine between a face and the original below which it looks elsewhere.
    least: f32,
}

/// The surroundings of a face that looks elsewhere than the original.
struct Turned {
    /// Its corners and those of the faces beyond its edges.
    near: Vec<u32>,
    /// How many times farther from the original than what was there what a mend leaves may lie.
    most_loss: f32,
}

impl Mend<'_> {
    fn corners(&self, face: [u32; 3]) -> [Vec3; 3] {
        face.map(|v| self.positions[v as usize])
    }

    /// Normals of a face and of the original beneath its centroid, as far as that lies in the regions of these vertices.
    fn normals(&self, corners: [Vec3; 3], near: &[u32]) -> [Vec3; 2] {
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        [area_normal(corners), self.beneath.foot(centroid, near).normal]
    }

    /// Whether a face looks elsewhere than the original beneath it.
    fn is_turned(&self, corners: [Vec3; 3], near: &[u32]) -> bool {
        let [own, original] = self.normals(corners, near);
        turns(own, original, self.least)
    }

    /// What lies about face `f`, if it looks elsewhere than the original and all of that is known there.
    fn turned(&self, f: u32) -> Option<Turned> {
        let near = beside(&[f], self.faces, self.around);
        if !near.iter().all(|&v| self.beneath.has(v)) {
            return None;
        }
        let [own, original] = self.normals(self.corners(self.faces[f as usize]), &near);
        let most_loss = if own.dot(original) <= 0.0 { MOST_LOSS } else { LEANING_LOSS };
        turns(own, original, self.least).then_some(Turned { near, most_loss })
    }

    /// Of the edges of a face that looks elsewhere, the longest whose other diagonal is free and makes two faces that look
    /// right and lie not much farther from the original; no seam, and none at a vertex that was `touched`.
    fn find_flip(
        &self,
        f: u32,
        touched: &FxHashSet<u32>,
        seams: Option<&Corners>,
        on_plane: Option<&OnPlane>,
    ) -> Option<Diamond> {
        let turned = self.turned(f)?;
        let length = |diamond: &Diamond| {
            let [a, b, ..] = diamond.corners.map(|v| self.positions[v as usize]);
            a.distance_squared(b)
        };
        let mut edges: Vec<Diamond> = diamonds(self.faces, self.around, f).collect();
        edges.sort_by(|x, y| length(y).total_cmp(&length(x)));
        edges.into_iter().find(|diamond| {
            let [a, b, c, d] = diamond.corners;
            let n_faces: usize = diamond.corners.iter().map(|&v| self.around.corners(v).len()).sum();
            let is_seam = || seams.is_some_and(|seams| seams.is_seam(self.faces, diamond.faces, [a, b]));
            let bridges = || on_plane.is_some_and(|on_plane| on_plane.has(c) && on_plane.has(d));
            let is_free = n_faces <= 4 * MOST_FACES
                && !diamond.corners.iter().any(|v| touched.contains(v))
                && !self.around.joins(c, d)
                && !bridges()
                && !is_seam();
            let look_right = || !diamond.flipped().iter().any(|&face| self.is_turned(self.corners(face), &turned.near));
            is_free && look_right() && self.may_flip(diamond, &turned)
        })
    }

    /// Whether the other diagonal leaves the result as near to the original as a mend of the turned face has to.
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
            let distances = patches[i].inner.iter().map(|&p| self.beneath.foot(p, near).distance);
            distances.fold(0.0, f32::max)
        });
        let others = self.faces_at(about, own);
        for point in self.beneath.points(about) {
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
        let mut faces: Vec<u32> = vertices.iter().flat_map(|&v| self.around.faces(v)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces.into_iter().filter(|f| !without.contains(f)).map(|f| self.corners(self.faces[f as usize])).collect()
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

    /// These vertices of a surface, and which of them is nearest to each of its vertices.
    fn coarse(surface: &Surface, corners: [u32; 4]) -> ([Vec3; 4], Vec<u32>) {
        let positions = corners.map(|v| surface.positions[v as usize]);
        let nearest = |p: &Vec3| {
            let distance = |v: &usize| positions[*v].distance_squared(*p);
            (0..4).min_by(|v, w| distance(v).total_cmp(&distance(w))).unwrap() as u32
        };
        (positions, surface.positions.iter().map(nearest).collect())
    }

    #[test]
    fn a_ridge_keeps_its_edge() {
        let roof = roof(0.5);
        let surface = Surface::new(&roof);
        let may_flip = |corners: [u32; 4]| {
            let (positions, vertex_of) = coarse(&surface, corners);
            let beneath = Beneath::new(&surface, &vertex_of, &[true; 4]);
            let faces = [[0, 1, 2], [1, 0, 3]];
            let around = FacesAround::new(4, &faces);
            let mend = Mend { beneath: &beneath, positions: &positions, faces: &faces, around: &around, least: 0.0 };
            let turned = Turned { near: vec![0, 1, 2, 3], most_loss: MOST_LOSS };
            mend.may_flip(&Diamond { faces: [0, 1], corners: [0, 1, 2, 3] }, &turned)
        };
        assert!(!may_flip([FRONT, BACK, LEFT, RIGHT]));
        assert!(may_flip([LEFT, RIGHT, BACK, FRONT]));
    }

    #[test]
    fn an_edge_under_a_steep_roof_gives_way_where_the_result_is_coarse() {
        let roof = roof(4.0);
        let surface = Surface::new(&roof);
        let n_flipped = |corners: [u32; 4], is_coarse: bool| {
            let (mut positions, vertex_of) = coarse(&surface, corners);
            let (positions, faces) = (&mut positions, &mut [[0, 1, 2], [1, 0, 3]]);
            let mut folded = Folded { positions, faces, corners: None, fixed: &[], on_plane: None, is_coarse };
            unfold(&surface, &vertex_of, &mut folded)
        };
        let across = [LEFT, RIGHT, BACK, FRONT];
        assert_eq!([n_flipped(across, true), n_flipped(across, false)], [1, 0]);
        assert_eq!(n_flipped([FRONT, BACK, LEFT, RIGHT], true), 0);
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
        let is_coarse = false;
        let mut mend = || {
            let mut folded = Folded {
                positions: &mut positions,
                faces: &mut faces,
                corners: None,
                fixed: &[],
                on_plane: None,
                is_coarse,
            };
            unfold(&surface, &vertex_of, &mut folded)
        };
        assert_eq!([mend(), mend()], [1, 0]);
        assert!(faces.iter().all(|f| area_normal(f.map(|v| positions[v as usize])).z > 0.0), "{faces:?}");
    }
}
