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
use crate::geometry::triangle::unit_normal;
use crate::simplify::closed::dropping::components_of;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;
use crate::spatial::{Bounds, Hit, NearestOnTriangles, boxes_near, boxes_near_other_kinds};

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
const NEAR: f32 = 0.5;
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
/// Faces that are looked at together.
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
    let mut asked = faces_near_other_components(output, &of_vertex);
    if asked.is_empty() {
        return;
    }
    let components = Components::new(original, output, (of_vertex, n), piece_of);
    let mut n_looks = LOOKS[0] + LOOKS[1] * output.faces().len();
    let (mut near, mut known, mut before) = (asked.clone(), Vec::<Crossing>::new(), None::<Before>);
    for _ in 0..ROUNDS {
        let found = crossings(output, &SomeFaces::new(output, near), &components, &asked, &mut n_looks);
        if found.is_empty() {
            break;
        }
        let known_before = before.take().filter(|before| before.covers(&found));
        let before = before.insert(known_before.unwrap_or_else(|| Before::new(original, output, &components, &found)));
        let moves = Nested::new(output, before, &components, &found).moves_of_all(&found);
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

/// Returns the faces whose boxes meet that of a face of another component.
fn faces_near_other_components(output: &Output, of_vertex: &[u32]) -> Vec<u32> {
    let labelled = |f: u32| (box_around(output, f, 0.0), of_vertex[output.face(f)[0] as usize]);
    boxes_near_other_kinds((0..output.faces().len() as u32).map(labelled))
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
fn crossings(
    output: &Output,
    tree: &SomeFaces,
    components: &Components,
    faces: &[u32],
    n_looks: &mut usize,
) -> Vec<Crossing> {
    let part = |f: u32| components.of(output, f);
    let piece = |part: u32| components.piece[part as usize];
    let normal = |f: u32| unit_normal(output.triangle(f));
    let crossed = |&face: &u32| {
        let (mut crossed, mut n) = (Vec::new(), 0);
        let (own, along, here) = (part(face), normal(face), output.coordinates(face));
        tree.visit_met(&here, |other| {
            n += 1;
            let is_beside = part(other) != own && piece(part(other)) == piece(own);
            let may = is_beside && along.dot(normal(other)).abs() > ALONG;
            if may && triangles_cross(here, output.coordinates(other)) {
                crossed.push(Crossing { face, part: part(other), other });
            }
        });
        crossed.sort_unstable();
        crossed.dedup_by_key(|crossing| crossing.part);
        (crossed, n)
    };
    let mut all = Vec::new();
    for faces in faces.chunks(TOGETHER) {
        if *n_looks == 0 {
            break;
        }
        for (crossed, n) in faces.par_iter().map(crossed).collect::<Vec<_>>() {
            *n_looks = n_looks.saturating_sub(n + LOOKS_OF_CROSSING * crossed.len());
            all.extend(crossed);
        }
    }
    all
}

/// The original's components as they lay around faces that cross others. On components with long faces a walk from a vertex nearby
/// ends far from what is nearest, so that all faces there are searched.
struct Before<'a> {
    original: &'a Original<'a>,
    trees: ComponentTrees,
    /// Whether the original was gathered around each face of the output.
    is_covered: Vec<bool>,
}

/// A place on the original.
struct Place {
    point: Vec3,
    normal: Vec3,
    distance: f32,
}

impl<'a> Before<'a> {
    /// Gathers the original around faces that cross others.
    fn new(original: &'a Original, output: &Output, components: &Components, crossings: &[Crossing]) -> Self {
        let surface = &original.surface;
        let mut is_covered = vec![false; output.faces().len()];
        crossings.iter().for_each(|crossing| is_covered[crossing.face as usize] = true);
        let seeds = boxes_around(output, crossings.iter().map(|crossing| crossing.face), AROUND);
        let corners = |f: u32| surface.faces[f as usize].map(|v| surface.positions[v as usize].to_array());
        let near = boxes_near(seeds, surface.faces.len(), |f| Bounds::of(&corners(f)));
        let labelled = near.into_iter().map(|f| (f, components.of_original(output, &surface.faces[f as usize])));
        Self { original, trees: ComponentTrees::new(labelled, components.n), is_covered }
    }

    /// Whether the original was gathered around all of these.
    fn covers(&self, crossings: &[Crossing]) -> bool {
        crossings.iter().all(|crossing| self.is_covered[crossing.face as usize])
    }

    /// Finds the place nearest to a point on what became a component, within a distance.
    fn nearest(&self, point: Vec3, component: u32, within: f32) -> Option<Place> {
        let surface = &self.original.surface;
        let corners = |f: u32| surface.faces[f as usize].map(|v| surface.positions[v as usize]);
        let triangle = |f: u32| corners(f).map(|corner| corner.to_array());
        let hit = self.trees.nearest(component, point, f64::from(within), &triangle)?;
        let normal = unit_normal(corners(hit.triangle));
        Some(Place { point: hit.point.as_vec3(), normal, distance: hit.distance2.sqrt() as f32 })
    }
}

/// Faces, each component to be searched by itself: where many lie in one place, a search of all would look at each.
struct ComponentTrees {
    /// The faces of each component.
    faces: Vec<Vec<u32>>,
    /// Made where they are asked for.
    trees: Vec<OnceLock<NearestOnTriangles>>,
}

impl ComponentTrees {
    /// Sorts faces by their components, `n` of them.
    fn new(labelled: impl Iterator<Item = (u32, u32)>, n: usize) -> Self {
        let mut faces = vec![Vec::new(); n];
        labelled.for_each(|(f, component)| faces[component as usize].push(f));
        Self { faces, trees: (0..n).map(|_| OnceLock::new()).collect() }
    }

    /// Finds the nearest point of a component within a distance; `triangle` gives the corners of a face.
    fn nearest(
        &self,
        component: u32,
        point: Vec3,
        within: f64,
        triangle: &dyn Fn(u32) -> [[f32; 3]; 3],
    ) -> Option<Hit> {
        let faces = &self.faces[component as usize];
        let tree = self.trees[component as usize]
            .get_or_init(|| NearestOnTriangles::new(&faces.iter().map(|&f| triangle(f)).collect::<Vec<_>>()));
        let hit = tree.nearest_within(point.as_dvec3(), within, |_| true)?;
        Some(Hit { triangle: faces[hit.triangle as usize], ..hit })
    }
}

/// Components as they lie now.
struct Nested<'a> {
    before: &'a Before<'a>,
    output: &'a Output,
    /// The output's faces near those that cross others, to be searched.
    now: ComponentTrees,
    components: &'a Components,
}

impl<'a> Nested<'a> {
    fn new(output: &'a Output, before: &'a Before, components: &'a Components, crossings: &[Crossing]) -> Self {
        let near = faces_near(output, boxes_around(output, crossings.iter().map(|crossing| crossing.face), NEAR));
        let labelled = near.into_iter().map(|f| (f, components.of(output, f)));
        let now = ComponentTrees::new(labelled, components.n);
        Self { before, output, now, components }
    }

    /// Finds what takes each face that crosses another back, where that is known.
    fn moves_of_all(&self, crossings: &[Crossing]) -> Vec<Moves> {
        let pulse = self.before.original.surface.pulse.counting_if(false);
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
        let before = self.before.nearest(place, self.component(crossing.face), NEAR * reach)?;
        let (side, gap) = self.side(crossing, &before, GAP * reach)?;
        let hit = self.now.nearest(crossing.part, place, f64::from(NEAR * reach), &|f| output.coordinates(f))?;
        let foot = hit.point.as_vec3();
        let normal = unit_normal(output.triangle(hit.triangle));
        let height = (place - foot).dot(normal);
        if height * side > 0.0 {
            return None;
        }
        let step = normal * (side * 0.5 * gap.min(reach) - height);
        // By more than both surfaces are off the original there, a step would spoil what is right.
        let most = FARTHEST * reach;
        if step.length() > most || step.length() > before.distance + self.off(foot, hit.triangle, most) {
            return None;
        }
        let shrinks = |f: u32, step: Vec3| step.dot(self.components.middles[self.component(f) as usize] - place) > 0.0;
        let moves = if shrinks(crossing.face, step) {
            self.along(crossing.face, weights, step)
        } else if shrinks(hit.triangle, -step) {
            self.along(hit.triangle, hit.weights.map(|w| w as f32), -step)
        } else {
            None
        };
        moves.map(|moves| (height.abs(), moves))
    }

    /// Measures how far a point of a face is from the original, no farther than `most`.
    fn off(&self, point: Vec3, face: u32, most: f32) -> f32 {
        self.before.nearest(point, self.component(face), most).map_or(most, |nearest| nearest.distance)
    }

    fn component(&self, f: u32) -> u32 {
        self.components.of(self.output, f)
    }

    /// Tells on which side of the other component a place of the original is, 1 or -1, and how far from it; `None` where that is not
    /// clear, or farther than `most`.
    fn side(&self, crossing: &Crossing, here: &Place, most: f32) -> Option<(f32, f32)> {
        let there = self.before.nearest(here.point, crossing.part, most)?;
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
    let before = n_crossed(output, tree, &faces, n_looks);
    let places = moves.map(|(v, _)| output.positions[v as usize]);
    moves.iter().for_each(|(v, step)| output.positions[*v as usize] += *step);
    let turns = |f: &u32| unit_normal(output.triangle(*f)).dot(output.meant(*f)) <= 0.0;
    let pays = before > 0 && !faces.iter().any(turns) && n_crossed(output, tree, &faces, n_looks) < before;
    let is_made = pays && *n_looks > 0;
    if !is_made {
        moves.iter().zip(places).for_each(|((v, _), place)| output.positions[*v as usize] = place);
    }
    is_made
}

/// Counts how often faces cross others; looks at little more than are left.
fn n_crossed(output: &Output, tree: &SomeFaces, faces: &[u32], n_looks: &mut usize) -> usize {
    let mut n = 0;
    for &f in faces {
        if *n_looks == 0 {
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
    use crate::mesh::{TriMesh, shapes};

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
            let mut output = Output::over(&original.surface.positions, places.clone(), faces);
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
