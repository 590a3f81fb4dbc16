//! Components that lie close within others: what would poke through stays inside.
//!
//! The fit knows of one surface at a time, and where two lie closer together than the error, the faces of one pass through the other.
//! On which side of the other component a face belongs is known: that on which the original has it. Where it is on the wrong one, it
//! goes back, half as far from there as it was. Of the two the one that shrinks its component moves: what shows stays where it is. No
//! move turns a face, and each leaves fewer faces that cross others.
//!
//! Most faces are far from other components, and most that cross some do so in the original, too. So all searches are among the faces
//! around those that cross, and later rounds look only at what lies near a move.

use std::sync::OnceLock;

use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::geometry::crossing::triangles_cross;
use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::geometry::triangle::unit_normal;
use crate::simplify::closed::dropping::components_of;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;
use crate::spatial::{Bounds, FaceTree, NearestOnTriangles, boxes_near, sets_of_several_kinds};

/// Least cosine between the way to another component and the normal there at which it is clear on which side a point is.
const CLEAR: f32 = 0.5;
/// Least cosine between two surfaces, whichever way they look, of which one lies within the other; components that pass through each
/// other meet at larger angles.
const ALONG: f32 = 0.8;
/// Distance on the surface of unit size up to which components touch: neither is within the other.
const TOUCHING: f32 = 1e-5;
/// How far a point goes back at most, over the longest edge of its face.
const FARTHEST: f32 = 0.1;
/// Distance of the other component in the original beyond which a point would go back too far, over the longest edge of its face: half
/// of its height goes into the step, and the height is at least [`CLEAR`] of it.
const GAP: f32 = 2.0 * FARTHEST / CLEAR;
/// Distance from a point to its own component in the original, and to where the other one now is, up to which they say where it
/// belongs, over the longest edge of its face: surfaces are that close unless a whole detail is gone.
const NEAR: f32 = 0.25;
/// How far around a face that crosses others the original is searched, over the face's longest edge: from a point to its own
/// component, and on to the other one.
const AROUND: f32 = NEAR + GAP;
/// How often faces go back: what moves changes what its neighbours cross.
const ROUNDS: usize = 20;
/// Pairs of faces looked at for whether they cross, however few the faces are, and for each of these: a few dozen are usual, and all
/// pairs where needles share a corner.
const LOOKS: [usize; 2] = [100_000, 200];
/// The same for finding out where a face that crosses belongs: five searches from each of seven points.
const LOOKS_OF_CROSSING: usize = 35;
/// Sets of faces that are looked at together.
const TOGETHER: usize = 256;
/// Where a face is asked on which side it is: weights of its corners.
const POINTS: [[f32; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [1.0 / 3.0; 3],
];

/// A face that crosses one of another component.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Crossing {
    face: u32,
    /// The other component, and a face of it.
    part: u32,
    other: u32,
}

/// Vertices of a face that move together, and by how much.
type Moves = [(u32, Vec3); 3];

/// Moves faces of components that poke through others back; `piece_of` says for the faces of the original which of them share a
/// space: those of other pieces of a scene stand elsewhere.
pub fn move_back(original: &Original, output: &mut Output, piece_of: impl Fn(u32) -> usize) {
    let (of_vertex, n) = components_of(output);
    if n < 2 || output.pins.is_subset() || output.pins.plane().is_some() {
        return;
    }
    let components = Components::new(original, output, (of_vertex, n), piece_of);
    let mut n_looks = LOOKS[0] + LOOKS[1] * output.faces().len();
    let mut asked: Vec<u32> = (0..output.faces().len() as u32).collect();
    let (mut near, mut known) = (asked.clone(), Vec::<Crossing>::new());
    for _ in 0..ROUNDS {
        let mut found = crossings(output, &components, &near, &mut n_looks);
        found.retain(|crossing| asked.binary_search(&crossing.face).is_ok());
        if found.is_empty() {
            break;
        }
        let vicinity = Vicinity::new(original, output, &components, &found);
        let moves = Nested::new(original, output, &components, &vicinity).moves_of_all(&found);
        let moved = make_moves(output, &moves, &mut n_looks);
        if moved.is_empty() {
            break;
        }
        // Where nothing moved, nothing changes.
        known.retain(|crossing| asked.binary_search(&crossing.face).is_err());
        known.extend(found);
        asked = faces_near_moved(output, &faces_around(output, &known), &moved);
        near = faces_near(output, boxes_around(output, asked.iter().copied(), 0.0));
    }
}

/// Returns the boxes of some faces, each larger by `around` times its longest edge.
fn boxes_around(output: &Output, faces: impl IntoIterator<Item = u32>, around: f32) -> Vec<Bounds> {
    let larger = |f: u32| box_around(output, f, around * longest_edge(output.triangle(f)));
    faces.into_iter().map(larger).collect()
}

/// Returns all faces whose boxes meet one of these.
fn faces_near(output: &Output, seeds: Vec<Bounds>) -> Vec<u32> {
    boxes_near(seeds, output.faces().len(), |f| box_around(output, f, 0.0))
}

/// Returns those of some faces that lie near one with a vertex that moved.
fn faces_near_moved(output: &Output, faces: &[u32], moved: &[u32]) -> Vec<u32> {
    let seeds = boxes_around(output, output.around().faces_of_all(moved.iter().copied()), 0.0);
    let larger = |i: u32| box_around(output, faces[i as usize], 2.0 * longest_edge(output.triangle(faces[i as usize])));
    boxes_near(seeds, faces.len(), larger).into_iter().map(|i| faces[i as usize]).collect()
}

/// Returns the faces around the corners of those that cross others.
fn faces_around(output: &Output, crossings: &[Crossing]) -> Vec<u32> {
    output.around().faces_of_all(crossings.iter().flat_map(|crossing| output.face(crossing.face)))
}

/// Returns the box of a face, larger by a length on each side.
fn box_around(output: &Output, f: u32, length: f32) -> Bounds {
    Bounds::of(&output.coordinates(f)).larger_by(length)
}

fn longest_edge([a, b, c]: [Vec3; 3]) -> f32 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// The components of an output.
struct Components {
    of_vertex: Vec<u32>,
    n: usize,
    /// Which of them share a space.
    piece: Vec<usize>,
    /// The middle of each component's box.
    middles: Vec<Vec3>,
}

impl Components {
    fn new(
        original: &Original,
        output: &Output,
        (of_vertex, n): (Vec<u32>, usize),
        piece_of: impl Fn(u32) -> usize,
    ) -> Self {
        let middles = middles(output, &of_vertex, n);
        let mut components = Self { of_vertex, n, piece: vec![0; n], middles };
        for (face, f) in original.surface.faces.iter().zip(0..) {
            let component = components.of_original(output, face);
            components.piece[component as usize] = piece_of(f);
        }
        components
    }

    /// Returns the component of a face of the output.
    fn of(&self, output: &Output, f: u32) -> u32 {
        self.of_vertex[output.face(f)[0] as usize]
    }

    /// Returns the component that a face of the original became part of.
    fn of_original(&self, output: &Output, face: &[u32; 3]) -> u32 {
        self.of_vertex[output.vertex_of[face[0] as usize] as usize]
    }
}

/// Some faces of the output, to be searched.
struct SomeFaces {
    faces: Vec<u32>,
    tree: NearestOnTriangles,
}

impl SomeFaces {
    fn new(output: &Output, faces: Vec<u32>) -> Self {
        let triangles: Vec<_> = faces.iter().map(|&f| output.coordinates(f)).collect();
        Self { faces, tree: NearestOnTriangles::new(&triangles) }
    }

    /// Calls `visit` with every face of these that meets a triangle, and with some near it, perhaps more than once.
    fn visit_met(&self, corners: &[[f32; 3]; 3], mut visit: impl FnMut(u32)) {
        self.tree.visit_met(corners, |i| visit(self.faces[i as usize]));
    }
}

/// Finds which of these faces cross other components, one face of each; looks at little more than are left.
fn crossings(output: &Output, components: &Components, faces: &[u32], n_looks: &mut usize) -> Vec<Crossing> {
    let labelled = |&f: &u32| (box_around(output, f, 0.0), components.of(output, f));
    let mut all = Vec::new();
    for sets in sets_of_several_kinds(faces.iter().map(labelled)).chunks(TOGETHER) {
        if *n_looks == 0 {
            break;
        }
        let found = |set: &Vec<u32>| {
            let faces: Vec<u32> = set.iter().map(|&i| faces[i as usize]).collect();
            crossings_within(output, components, &faces, *n_looks)
        };
        for (crossings, n) in sets.par_iter().map(found).collect::<Vec<_>>() {
            *n_looks = n_looks.saturating_sub(n + LOOKS_OF_CROSSING * crossings.len());
            all.extend(crossings);
        }
    }
    all.sort_unstable();
    all.dedup_by_key(|crossing| (crossing.face, crossing.part));
    all
}

/// Compares each of these faces with each, at most so many pairs; returns those that cross, either way around, and how many pairs were
/// looked at.
fn crossings_within(output: &Output, components: &Components, faces: &[u32], most: usize) -> (Vec<Crossing>, usize) {
    let part = |f: u32| components.of(output, f);
    let normal = |f: u32| unit_normal(output.triangle(f));
    let boxes: Vec<(u32, u32, Bounds)> = faces.iter().map(|&f| (f, part(f), box_around(output, f, 0.0))).collect();
    let (mut crossings, mut n) = (Vec::new(), 0);
    for (i, &(f, of_f, box_of_f)) in boxes.iter().enumerate().take_while(|(i, _)| i * i / 2 <= most) {
        n += i;
        for &(g, of_g, box_of_g) in &boxes[..i] {
            let are_beside = of_f != of_g && components.piece[of_f as usize] == components.piece[of_g as usize];
            let may_cross = are_beside && box_of_f.overlaps(&box_of_g) && normal(f).dot(normal(g)).abs() > ALONG;
            if may_cross && triangles_cross(output.coordinates(f), output.coordinates(g)) {
                crossings.push(Crossing { face: f, part: of_g, other: g });
                crossings.push(Crossing { face: g, part: of_f, other: f });
            }
        }
    }
    crossings.sort_unstable();
    crossings.dedup_by_key(|crossing| (crossing.face, crossing.part));
    (crossings, n)
}

/// What lies around faces that cross others, by component.
struct Vicinity {
    /// Faces of the original.
    before: Vec<ComponentFaces>,
    /// Faces of the output.
    now: Vec<ComponentFaces>,
}

impl Vicinity {
    fn new(original: &Original, output: &Output, components: &Components, crossings: &[Crossing]) -> Self {
        let surface = &original.surface;
        let seeds = |around| boxes_around(output, crossings.iter().map(|crossing| crossing.face), around);
        let corners = |f: u32| surface.faces[f as usize].map(|v| surface.positions[v as usize].to_array());
        let mut before = vec![ComponentFaces::default(); components.n];
        for f in boxes_near(seeds(AROUND), surface.faces.len(), |f| Bounds::of(&corners(f))) {
            before[components.of_original(output, &surface.faces[f as usize]) as usize].push(f, corners(f));
        }
        let mut now = vec![ComponentFaces::default(); components.n];
        for f in faces_near(output, seeds(NEAR)) {
            now[components.of(output, f) as usize].push(f, output.coordinates(f));
        }
        Self { before, now }
    }
}

/// Some faces of a component.
#[derive(Clone, Default)]
struct ComponentFaces {
    /// Which faces they are.
    numbers: Vec<u32>,
    /// Their corners, 3 n_faces.
    positions: Vec<[f32; 3]>,
    /// The same as indices, n_faces x 3.
    faces: Vec<[u32; 3]>,
}

impl ComponentFaces {
    fn push(&mut self, number: u32, corners: [[f32; 3]; 3]) {
        let first = self.positions.len() as u32;
        self.numbers.push(number);
        self.positions.extend(corners);
        self.faces.push([first, first + 1, first + 2]);
    }
}

/// Components, each to be searched by itself: where many lie in one place, a search of all would look at each. On long faces a walk
/// from a vertex nearby ends far from what is nearest, so that all faces are searched.
struct ComponentTrees<'a> {
    components: &'a [ComponentFaces],
    /// Made where they are asked for.
    trees: Vec<OnceLock<FaceTree<'a>>>,
}

/// A point of a face.
struct FacePoint {
    face: u32,
    /// What each corner counts in it.
    weights: [f32; 3],
    point: Vec3,
    /// Of the face, a unit vector.
    normal: Vec3,
    /// From where it was searched.
    distance: f32,
}

impl<'a> ComponentTrees<'a> {
    fn new(components: &'a [ComponentFaces]) -> Self {
        Self { components, trees: components.iter().map(|_| OnceLock::new()).collect() }
    }

    /// Finds the nearest point of a component within a distance.
    fn nearest(&self, component: u32, point: Vec3, within: f32) -> Option<FacePoint> {
        let ComponentFaces { numbers, positions, faces } = &self.components[component as usize];
        let tree = self.trees[component as usize].get_or_init(|| FaceTree::new(positions, faces));
        let (i, distance2) = tree.nearest_of(point.as_dvec3(), f64::from(within), |_| true)?;
        let corners = faces[i as usize].map(|v| Vec3::from(positions[v as usize]));
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let weights = nearest_weights_f64(point.as_dvec3(), [a, b, c]);
        Some(FacePoint {
            face: numbers[i as usize],
            weights: weights.map(|weight| weight as f32),
            point: (a * weights[0] + b * weights[1] + c * weights[2]).as_vec3(),
            normal: unit_normal(corners),
            distance: distance2.sqrt() as f32,
        })
    }
}

/// Components as they lay and as they lie now.
struct Nested<'a> {
    original: &'a Original<'a>,
    output: &'a Output,
    components: &'a Components,
    before: ComponentTrees<'a>,
    now: ComponentTrees<'a>,
}

impl<'a> Nested<'a> {
    fn new(
        original: &'a Original,
        output: &'a Output,
        components: &'a Components,
        Vicinity { before, now }: &'a Vicinity,
    ) -> Self {
        let [before, now] = [before, now].map(|faces| ComponentTrees::new(faces));
        Self { original, output, components, before, now }
    }

    /// Finds what takes each face that crosses another back, where that is known.
    fn moves_of_all(&self, crossings: &[Crossing]) -> Vec<Moves> {
        let pulse = self.original.surface.pulse.counting_if(false);
        pulse.map(crossings, |crossing| self.deepest(crossing)).into_iter().flatten().collect()
    }

    /// Finds what takes a face that crosses back where it is deepest on the wrong side.
    fn deepest(&self, crossing: &Crossing) -> Option<Moves> {
        let moves = POINTS.iter().filter_map(|&weights| self.moves(crossing, weights));
        moves.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, moves)| moves)
    }

    /// Finds how deep a point of a face is on the wrong side of the other component, and what takes it back; `None` where it is on its
    /// side.
    fn moves(&self, crossing: &Crossing, weights: [f32; 3]) -> Option<(f32, Moves)> {
        let output = self.output;
        let here = output.triangle(crossing.face);
        let place = here[0] * weights[0] + here[1] * weights[1] + here[2] * weights[2];
        let reach = longest_edge(here);
        let hit = self.now.nearest(crossing.part, place, NEAR * reach)?;
        let height = (place - hit.point).dot(hit.normal);
        let most = FARTHEST * reach;
        // Too far for a step, whatever the original says, which takes longer to search.
        if height.abs() > most {
            return None;
        }
        let before = self.before.nearest(self.component(crossing.face), place, NEAR * reach)?;
        let (side, gap) = self.side(crossing, &before, GAP * reach)?;
        if height * side > 0.0 {
            return None;
        }
        let step = hit.normal * (side * 0.5 * gap.min(reach) - height);
        // By more than both surfaces are off the original there, a step would spoil what is right.
        if step.length() > most || step.length() > before.distance + self.off(&hit, most) {
            return None;
        }
        let shrinks = |f: u32, step: Vec3| step.dot(self.components.middles[self.component(f) as usize] - place) > 0.0;
        let moves = if shrinks(crossing.face, step) {
            self.along(crossing.face, weights, step)
        } else if shrinks(hit.face, -step) {
            self.along(hit.face, hit.weights, -step)
        } else {
            None
        };
        moves.map(|moves| (height.abs(), moves))
    }

    /// Measures how far a point of the output is from the original, no farther than `most`.
    fn off(&self, at: &FacePoint, most: f32) -> f32 {
        self.before.nearest(self.component(at.face), at.point, most).map_or(most, |nearest| nearest.distance)
    }

    fn component(&self, f: u32) -> u32 {
        self.components.of(self.output, f)
    }

    /// Tells on which side of the other component a place of the original is, 1 or -1, and how far from it; `None` where that is not
    /// clear, or farther than `most`.
    fn side(&self, crossing: &Crossing, here: &FacePoint, most: f32) -> Option<(f32, f32)> {
        let there = self.before.nearest(crossing.part, here.point, most)?;
        let height = (here.point - there.point).dot(there.normal);
        let are_along = here.normal.dot(there.normal).abs() > ALONG;
        let is_clear = are_along && there.distance > TOUCHING && height.abs() > CLEAR * there.distance;
        is_clear.then(|| (height.signum(), height.abs()))
    }

    /// Returns the least moves of a face's corners that take a point of it along; `None` where one of them may not move.
    fn along(&self, face: u32, weights: [f32; 3], step: Vec3) -> Option<Moves> {
        let corners = self.output.face(face);
        let step = step / Vec3::from(weights).length_squared();
        let is_free = |v: &u32| !self.output.pins.has(*v);
        corners.iter().all(is_free).then(|| [0, 1, 2].map(|i| (corners[i], step * weights[i])))
    }
}

/// Makes those of these moves that do good, one after the other; returns the vertices that moved.
fn make_moves(output: &mut Output, moves: &[Moves], n_looks: &mut usize) -> Vec<u32> {
    if moves.is_empty() {
        return Vec::new();
    }
    let mut farthest: FxHashMap<u32, f32> = FxHashMap::default();
    moves.iter().flatten().for_each(|(v, step)| *farthest.entry(*v).or_default() += step.length());
    let faces = output.around().faces_of_all(farthest.keys().copied());
    let step = |v: u32| farthest.get(&v).copied().unwrap_or(0.0);
    let seed = |&f: &u32| box_around(output, f, output.face(f).map(step).into_iter().fold(0.0, f32::max));
    let seeds: Vec<Bounds> = faces.iter().map(seed).collect();
    let tree = SomeFaces::new(output, faces_near(output, seeds));
    let made = moves.iter().filter(|moves| go(output, &tree, moves, n_looks));
    made.flatten().map(|(v, _)| *v).collect()
}

/// Makes moves if they turn no face and leave fewer faces that cross others; returns whether they were made.
fn go(output: &mut Output, tree: &SomeFaces, moves: &Moves, n_looks: &mut usize) -> bool {
    let moved = moves.iter().filter(|(_, step)| *step != Vec3::ZERO).map(|(v, _)| *v);
    let faces = output.around().faces_of_all(moved);
    let [before, after] =
        [0.0, 1.0].map(|share| moves.map(|(v, step)| (v, output.positions[v as usize] + share * step)));
    let put = |output: &mut Output, places: &[(u32, Vec3); 3]| {
        places.iter().for_each(|(v, place)| output.positions[*v as usize] = *place);
    };
    put(output, &after);
    let turns = faces.iter().any(|&f| unit_normal(output.triangle(f)).dot(output.meant(f)) <= 0.0);
    put(output, &before);
    if turns {
        return false;
    }
    let most = n_crossed(output, tree, &faces, usize::MAX, n_looks);
    put(output, &after);
    let is_made = most > 0 && n_crossed(output, tree, &faces, most, n_looks) < most && *n_looks > 0;
    if !is_made {
        put(output, &before);
    }
    is_made
}

/// Counts how often faces cross others, up to about `most`; looks at little more than are left.
fn n_crossed(output: &Output, tree: &SomeFaces, faces: &[u32], most: usize, n_looks: &mut usize) -> usize {
    let mut n = 0;
    for &f in faces {
        if *n_looks == 0 || n >= most {
            break;
        }
        let here = output.coordinates(f);
        tree.visit_met(&here, |other| {
            *n_looks = n_looks.saturating_sub(1);
            n += usize::from(other != f && triangles_cross(here, output.coordinates(other)));
        });
    }
    n
}

/// Returns the middle of each component's box.
fn middles(output: &Output, part_of: &[u32], n_parts: usize) -> Vec<Vec3> {
    let mut boxes = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); n_parts];
    for (&p, &part) in output.positions.iter().zip(part_of) {
        let (low, high) = &mut boxes[part as usize];
        (*low, *high) = (low.min(p), high.max(p));
    }
    boxes.into_iter().map(|(low, high)| 0.5 * (low + high)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::pins::Pins;

    /// Spheres about one point, the faces of each after those of the one before; the smaller ones looking inward, if so wanted.
    fn spheres(radii: &[f32], level: u32, inward: bool) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let sphere = shapes::icosphere(level);
        let n = sphere.positions().len() as u32;
        let positions =
            radii.iter().flat_map(|r| sphere.positions().iter().map(move |p| Vec3::from(*p) * *r)).collect();
        let faces = (0..radii.len() as u32).flat_map(|i| {
            let wound = move |&[a, b, c]: &[u32; 3]| if inward && i > 0 { [a, c, b] } else { [a, b, c] };
            sphere.faces().iter().map(move |face| wound(face).map(|v| v + i * n))
        });
        (positions, faces.collect())
    }

    /// Two coarse spheres, the closest of whose vertices stand for each of the same fine sphere.
    fn coarse_output(fine: &[Vec3], coarse: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Output {
        let n = coarse.len() / 2;
        let closest = |(v, p): (usize, &Vec3)| {
            let first = if v < fine.len() / 2 { 0 } else { n };
            let distance = |w: &usize| coarse[*w].distance_squared(*p);
            (first..first + n).min_by(|v, w| distance(v).total_cmp(&distance(w))).unwrap() as u32
        };
        let vertex_of = fine.iter().enumerate().map(closest).collect();
        Output::new(Pulse::NONE, coarse, faces, Pins::default(), vertex_of)
    }

    #[test]
    fn what_pokes_through_goes_back_inside_whichever_way_it_looks() {
        for inward in [false, true] {
            let (positions, faces) = spheres(&[1.0, 0.99], 4, inward);
            let mesh = TriMesh::new(positions.iter().map(|p| p.to_array()).collect(), faces).unwrap();
            let original = Original::bare(&mesh);
            let scale = original.surface.length(1.0);
            // Coarse spheres of the same vertices: those of the inner one stand out of the faces of the outer one between its vertices.
            let (coarse, faces) = spheres(&[1.0, 0.99], 1, inward);
            let turn = glam::Quat::from_rotation_x(0.31) * glam::Quat::from_rotation_y(0.2);
            let n = coarse.len() / 2;
            let place = |(v, p): (usize, &Vec3)| scale * if v < n { *p } else { turn * *p };
            let places: Vec<Vec3> = coarse.iter().enumerate().map(place).collect();
            let mut output = coarse_output(&original.surface.positions, places.clone(), faces);
            let outside = |output: &Output| {
                let tree = output.tree();
                let is_out = |v: &usize| {
                    let p = output.positions[*v];
                    let hit = tree.nearest_of(p.as_dvec3(), |f| (output.face(f)[0] as usize) < n).unwrap();
                    (p - hit.point.as_vec3()).dot(unit_normal(output.triangle(hit.triangle))) > 0.0
                };
                (n..2 * n).filter(is_out).count()
            };
            let before = outside(&output);
            move_back(&original, &mut output, |_| 0);
            assert!(before > n / 2 && outside(&output) == 0, "{before} {}", outside(&output));
            assert_eq!(output.positions[..n], places[..n]);
        }
    }

    #[test]
    fn parts_that_touch_or_cross_stay_where_they_are() {
        let sphere = shapes::icosphere(3);
        let n = sphere.positions().len() as u32;
        let moved = |x: f32| sphere.positions().iter().map(move |p| [p[0] + x, p[1], p[2]]);
        let faces: Vec<[u32; 3]> =
            (0..2).flat_map(|i| sphere.faces().iter().map(move |f| f.map(|v| v + i * n))).collect();
        for x in [0.7, 2.0, 3.0] {
            let mesh = TriMesh::new(moved(0.0).chain(moved(x)).collect(), faces.clone()).unwrap();
            let original = Original::bare(&mesh);
            let places = original.surface.positions.clone();
            let mut output = Output::over(&places, places.clone(), faces.clone());
            move_back(&original, &mut output, |_| 0);
            assert_eq!(output.positions, places);
        }
    }
}
