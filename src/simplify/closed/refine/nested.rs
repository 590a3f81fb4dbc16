//! Nested components: faces that pass through another component are moved back.

use std::collections::BTreeMap;

use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::geometry::crossing::triangles_cross;
use crate::geometry::triangle::unit_normal;
use crate::simplify::closed::dropping::output_components;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;
use crate::spatial::{Bounds, NearestOnTriangles, boxes_near, sets_of_several_kinds};

/// Least cosine between another component's normal and the direction to a point whose side is clear.
const LEAST_SIDE_COSINE: f32 = 0.5;
/// Least absolute cosine between the normals of two nested surfaces.
// Components that pass through each other on purpose meet at larger angles.
const LEAST_NESTING_COSINE: f32 = 0.8;
/// Distance at unit size up to which two components count as touching.
const TOUCHING: f32 = 1e-5;
/// Longest step of a point, in longest edges of its face.
const LONGEST_STEP: f32 = 0.1;
/// Largest distance from a point to its original component and to the other component, in longest edges of its face.
// Only a lost detail is farther away.
const NEAR: f32 = 0.25;
/// Largest distance between two components of the original, in longest edges of a face.
// Half of the height, which is at least `LEAST_SIDE_COSINE` of the distance, is part of the step.
const LARGEST_GAP: f32 = 2.0 * LONGEST_STEP / LEAST_SIDE_COSINE;
/// Distance from a moved face within which crossings are searched again, in its longest edges.
// A move is judged by the faces around it, so that moves nearby may now be possible.
const AROUND_MOVES: f32 = 2.0;
const ROUNDS: usize = 20;
/// Largest number of face pairs tested: a base number, plus a number per face.
// Thousands of needles that share a corner would be tested in all pairs.
const MOST_TESTS: [usize; 2] = [100_000, 200];
/// Pairs of boxes compared in the time of one test.
const BOXES_PER_TEST: usize = 16;
/// Tests charged for a crossing face: five searches from seven points.
const TESTS_PER_CROSSING: usize = 35;
const POINTS: [[f32; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [1.0 / 3.0; 3],
];

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Crossing {
    face: u32,
    /// The other component.
    component: u32,
}

type Moves = [(u32, Vec3); 3];

/// Moves crossing faces of nested components back; `piece_of` returns the scene piece of an original face.
pub fn separate_nested(original: &Original, output: &mut Output, piece_of: impl Fn(u32) -> usize) {
    // The fit moves each surface by itself: where two surfaces are closer than its error, their faces cross.
    let (of_vertex, n_components) = output_components(output);
    if n_components < 2 || output.pins.is_subset() || output.pins.plane().is_some() {
        return;
    }
    let pulse = original.surface.pulse.counting_if(false);
    let middles = middles(output, &of_vertex, n_components);
    let mut components = OutputComponents { of_vertex, pieces: vec![0; n_components], middles };
    for f in 0..original.surface.faces.len() as u32 {
        let component = components.of_original_face(original, output, f);
        components.pieces[component as usize] = piece_of(f);
    }
    let mut n_tests_left = MOST_TESTS[0] + MOST_TESTS[1] * output.faces().len();
    let mut faces: Vec<u32> = (0..output.faces().len() as u32).collect();
    for _ in 0..ROUNDS {
        let crossings = find_crossings(output, &components, &faces, &mut n_tests_left);
        if crossings.is_empty() {
            break;
        }
        let nested = NestedComponents::new(original, output, &components, &crossings);
        let moves = pulse.map(&crossings, |crossing| nested.deepest_move(crossing)).into_iter().flatten().collect();
        let moved = make_moves(output, moves, &mut n_tests_left);
        if moved.is_empty() {
            break;
        }
        // In the next round only the neighbourhood of moved faces can differ.
        faces = faces_near(output, output.faces_around().faces_of_all(moved), AROUND_MOVES);
    }
}

struct OutputComponents {
    of_vertex: Vec<u32>,
    /// Scene piece of each component; components are compared only within a piece.
    pieces: Vec<usize>,
    middles: Vec<Vec3>,
}

impl OutputComponents {
    fn of_face(&self, output: &Output, f: u32) -> u32 {
        self.of_vertex[output.face(f)[0] as usize]
    }

    fn of_original_face(&self, original: &Original, output: &Output, f: u32) -> u32 {
        self.of_vertex[output.vertex_of[original.surface.faces[f as usize][0] as usize] as usize]
    }
}

fn longest_edge([a, b, c]: [Vec3; 3]) -> f32 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// Returns a face's bounding box, expanded by a distance.
fn box_around(output: &Output, f: u32, distance: f32) -> Bounds {
    let Bounds { low, high } = Bounds::from_points(&output.coordinates(f));
    Bounds { low: low.map(|x| x - distance), high: high.map(|x| x + distance) }
}

/// Returns the boxes of faces, each expanded by `reach` times its longest edge.
fn boxes_around(output: &Output, faces: impl IntoIterator<Item = u32>, reach: f32) -> Vec<Bounds> {
    faces.into_iter().map(|f| box_around(output, f, reach * longest_edge(output.triangle(f)))).collect()
}

/// Returns the faces whose boxes overlap one of [`boxes_around`].
fn faces_near(output: &Output, faces: impl IntoIterator<Item = u32>, reach: f32) -> Vec<u32> {
    boxes_near(boxes_around(output, faces, reach), output.faces().len(), |f| box_around(output, f, 0.0))
}

/// Finds the faces among `faces` that cross other components at small angles.
fn find_crossings(
    output: &Output,
    components: &OutputComponents,
    faces: &[u32],
    n_tests_left: &mut usize,
) -> Vec<Crossing> {
    let boxes: Vec<_> = faces.iter().map(|&f| (box_around(output, f, 0.0), components.of_face(output, f))).collect();
    // Crossings of different scene pieces are intended.
    let mut pieces: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for (i, (_, component)) in (0..).zip(&boxes) {
        pieces.entry(components.pieces[*component as usize]).or_default().push(i);
    }
    let mut sets: Vec<Vec<u32>> = pieces.into_values().flat_map(|piece| sets_of_several_kinds(&boxes, piece)).collect();
    // The budget is charged in order, before the parallel tests, so that it is deterministic.
    sets.retain(|set| {
        let n_tests = set.len() * set.len() / (2 * BOXES_PER_TEST);
        let is_affordable = n_tests <= *n_tests_left;
        *n_tests_left -= if is_affordable { n_tests } else { 0 };
        is_affordable
    });
    let normal = |f: u32| unit_normal(output.triangle(f));
    let crosses = |[i, j]: [u32; 2]| {
        let [(box_i, of_i), (box_j, of_j)] = [i, j].map(|i| &boxes[i as usize]);
        let [f, g] = [i, j].map(|i| faces[i as usize]);
        // Crossings of steep angles are intended.
        of_i != of_j
            && box_i.overlaps(box_j)
            && normal(f).dot(normal(g)).abs() > LEAST_NESTING_COSINE
            && triangles_cross(output.coordinates(f), output.coordinates(g))
    };
    let crossing = |[i, j]: [u32; 2]| Crossing { face: faces[i as usize], component: boxes[j as usize].1 };
    let find = |set: &Vec<u32>| -> Vec<Crossing> {
        let pairs = (0..set.len()).flat_map(|i| set[..i].iter().map(move |&j| [set[i], j]));
        pairs.filter(|&pair| crosses(pair)).flat_map(|[i, j]| [crossing([i, j]), crossing([j, i])]).collect()
    };
    // One crossing per component suffices: the search for the closest point finds the rest.
    let mut crossings: Vec<Crossing> = sets.par_iter().flat_map_iter(find).collect();
    crossings.sort_unstable();
    crossings.dedup();
    *n_tests_left = n_tests_left.saturating_sub(TESTS_PER_CROSSING * crossings.len());
    crossings
}

/// Some faces, prepared for closest-point queries.
struct FaceSubset {
    faces: Vec<u32>,
    triangles: Vec<[[f32; 3]; 3]>,
    tree: NearestOnTriangles,
}

impl FaceSubset {
    fn new(faces: Vec<u32>, triangle: impl Fn(u32) -> [[f32; 3]; 3]) -> Self {
        let triangles: Vec<_> = faces.iter().map(|&f| triangle(f)).collect();
        Self { faces, tree: NearestOnTriangles::new(&triangles), triangles }
    }
}

// Each component has its own tree: one tree over all would visit every component where they overlap.
type ComponentTrees = FxHashMap<u32, FaceSubset>;

struct ComponentPoint {
    face: u32,
    weights: [f32; 3],
    point: Vec3,
    normal: Vec3,
    distance: f32,
}

fn component_trees(
    faces: Vec<u32>,
    component: impl Fn(u32) -> u32,
    triangle: impl Fn(u32) -> [[f32; 3]; 3] + Sync,
) -> ComponentTrees {
    let mut by_component: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    faces.into_iter().for_each(|f| by_component.entry(component(f)).or_default().push(f));
    by_component.into_par_iter().map(|(component, faces)| (component, FaceSubset::new(faces, &triangle))).collect()
}

fn nearest(trees: &ComponentTrees, component: u32, point: Vec3, reach: f32) -> Option<ComponentPoint> {
    let FaceSubset { faces, triangles, tree } = trees.get(&component)?;
    let hit = tree.nearest_within(point.as_dvec3(), f64::from(reach), |_| true)?;
    Some(ComponentPoint {
        face: faces[hit.triangle as usize],
        weights: hit.weights.map(|weight| weight as f32),
        point: hit.point.as_vec3(),
        normal: unit_normal(triangles[hit.triangle as usize].map(Vec3::from)),
        distance: hit.distance2.sqrt() as f32,
    })
}

struct NestedComponents<'a> {
    output: &'a Output,
    components: &'a OutputComponents,
    /// Faces of the original, by the output's components.
    before: ComponentTrees,
    now: ComponentTrees,
}

impl<'a> NestedComponents<'a> {
    fn new(original: &Original, output: &'a Output, components: &'a OutputComponents, crossings: &[Crossing]) -> Self {
        let surface = &original.surface;
        let corners = |f: u32| surface.faces[f as usize].map(|v| surface.positions[v as usize].to_array());
        let crossing_faces = || crossings.iter().map(|crossing| crossing.face);
        let seeds = boxes_around(output, crossing_faces(), NEAR + LARGEST_GAP);
        let before = boxes_near(seeds, surface.faces.len(), |f| Bounds::from_points(&corners(f)));
        let now = faces_near(output, crossing_faces(), NEAR);
        Self {
            output,
            components,
            before: component_trees(before, |f| components.of_original_face(original, output, f), corners),
            now: component_trees(now, |f| components.of_face(output, f), |f| output.coordinates(f)),
        }
    }

    /// Finds the corner moves that bring back a face's point deepest on the wrong side of another component.
    fn deepest_move(&self, crossing: &Crossing) -> Option<Moves> {
        let moves = POINTS.iter().filter_map(|&weights| self.moves(crossing, weights));
        moves.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, moves)| moves)
    }

    /// Returns a point's depth on the wrong side of the other component, and the corner moves that bring it back.
    fn moves(&self, crossing: &Crossing, weights: [f32; 3]) -> Option<(f32, Moves)> {
        let here = self.output.triangle(crossing.face);
        let place = here[0] * weights[0] + here[1] * weights[1] + here[2] * weights[2];
        let reach = longest_edge(here);
        let longest_step = LONGEST_STEP * reach;
        // Side and gap are measured along the other component's normal at the closest point.
        let hit = nearest(&self.now, crossing.component, place, NEAR * reach)?;
        let height = (place - hit.point).dot(hit.normal);
        // The step is no shorter than the height; the original need not be searched.
        if height.abs() > longest_step {
            return None;
        }
        // The correct side comes from the original, the present side from the output.
        let before = nearest(&self.before, self.component(crossing.face), place, NEAR * reach)?;
        let (side, gap) = self.side(crossing, &before, LARGEST_GAP * reach)?;
        // The side is right if it is that of the original.
        if height * side > 0.0 {
            return None;
        }
        // Half the original gap is the target: a full one would move faces that are fine.
        let step = hit.normal * (side * 0.5 * gap - height);
        // A step longer than both distances to the original together would spoil what is right.
        let other_before = nearest(&self.before, self.component(hit.face), hit.point, longest_step);
        let both_off = before.distance + other_before.map_or(longest_step, |point| point.distance);
        if step.length() > longest_step.min(both_off) {
            return None;
        }
        // The face moves whose step leads toward the middle of its component: the inner one, so that the visible one
        // stays.
        let shrinks = |f: u32, step: Vec3| step.dot(self.components.middles[self.component(f) as usize] - place) > 0.0;
        let moves = if shrinks(crossing.face, step) {
            self.corner_moves(crossing.face, weights, step)
        } else if shrinks(hit.face, -step) {
            self.corner_moves(hit.face, hit.weights, -step)
        } else {
            None
        };
        moves.map(|moves| (height.abs(), moves))
    }

    fn component(&self, f: u32) -> u32 {
        self.components.of_face(self.output, f)
    }

    /// Returns the other component's side, 1 or -1, on which the original has a point, and their distance; `None` if
    /// unclear or farther than `reach`.
    fn side(&self, crossing: &Crossing, here: &ComponentPoint, reach: f32) -> Option<(f32, f32)> {
        let there = nearest(&self.before, crossing.component, here.point, reach)?;
        let height = (here.point - there.point).dot(there.normal);
        // Only nearly parallel surfaces are nested; others intersect on purpose.
        let are_parallel = here.normal.dot(there.normal).abs() > LEAST_NESTING_COSINE;
        let is_clear = are_parallel && there.distance > TOUCHING && height.abs() > LEAST_SIDE_COSINE * there.distance;
        is_clear.then(|| (height.signum(), height.abs()))
    }

    /// Computes the least-squares moves of a face's corners that move its point by `step`.
    fn corner_moves(&self, face: u32, weights: [f32; 3], step: Vec3) -> Option<Moves> {
        let corners = self.output.face(face);
        // The minimum-norm moves of the corners that give the point this step.
        let step = step / Vec3::from(weights).length_squared();
        let is_free = |v: &u32| !self.output.pins.is_pinned(*v);
        corners.iter().all(is_free).then(|| [0, 1, 2].map(|i| (corners[i], step * weights[i])))
    }
}

/// Makes the moves that reduce the crossings; returns the moved vertices.
// All moves of a round are found for the same positions, so each is made only if it still reduces the crossings.
fn make_moves(output: &mut Output, moves: Vec<Moves>, n_tests_left: &mut usize) -> Vec<u32> {
    let mut lengths: FxHashMap<u32, f32> = FxHashMap::default();
    moves.iter().flatten().for_each(|(v, step)| *lengths.entry(*v).or_default() += step.length());
    let length = |v: u32| lengths.get(&v).copied().unwrap_or(0.0);
    let reach = |f: u32| output.face(f).map(length).into_iter().fold(0.0, f32::max);
    let movable = output.faces_around().faces_of_all(lengths.keys().copied());
    let seeds = movable.into_iter().map(|f| box_around(output, f, reach(f))).collect();
    let faces = boxes_near(seeds, output.faces().len(), |f| box_around(output, f, 0.0));
    let near = FaceSubset::new(faces, |f| output.coordinates(f));
    moves.iter().filter(|moves| try_moves(output, &near, moves, n_tests_left)).flatten().map(|(v, _)| *v).collect()
}

fn try_moves(output: &mut Output, near: &FaceSubset, moves: &Moves, n_tests_left: &mut usize) -> bool {
    let moved = moves.iter().filter(|(_, step)| *step != Vec3::ZERO).map(|(v, _)| *v);
    let faces = output.faces_around().faces_of_all(moved);
    let before = moves.map(|(v, _)| output.positions[v as usize]);
    let after = moves.map(|(v, step)| output.positions[v as usize] + step);
    let place = |output: &mut Output, corners: [Vec3; 3]| {
        moves.iter().zip(corners).for_each(|((v, _), corner)| output.positions[*v as usize] = corner);
    };
    // Turned faces are found first: to count crossings takes longer.
    place(output, after);
    let turns = faces.iter().any(|&f| unit_normal(output.triangle(f)).dot(output.intended_normal(f)) <= 0.0);
    place(output, before);
    if turns {
        return false;
    }
    let most = count_crossings(output, near, &faces, usize::MAX, n_tests_left);
    place(output, after);
    let is_made = most > 0 && count_crossings(output, near, &faces, most, n_tests_left) < most && *n_tests_left > 0;
    if !is_made {
        place(output, before);
    }
    is_made
}

/// Counts crossings of faces until `most` are found.
fn count_crossings(output: &Output, near: &FaceSubset, faces: &[u32], most: usize, n_tests_left: &mut usize) -> usize {
    let mut n = 0;
    for &f in faces {
        if *n_tests_left == 0 || n >= most {
            break;
        }
        let here = output.coordinates(f);
        near.tree.visit_touching(&here, |i| {
            let other = near.faces[i as usize];
            *n_tests_left = n_tests_left.saturating_sub(1);
            n += usize::from(other != f && triangles_cross(here, output.coordinates(other)));
        });
    }
    n
}

fn middles(output: &Output, component_of: &[u32], n_components: usize) -> Vec<Vec3> {
    let mut boxes = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); n_components];
    for (&p, &component) in output.positions.iter().zip(component_of) {
        let (low, high) = &mut boxes[component as usize];
        (*low, *high) = (low.min(p), high.max(p));
    }
    boxes.into_iter().map(|(low, high)| 0.5 * (low + high)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};

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
    fn crossing_components_move_back_inside_in_any_winding() {
        for inward in [false, true] {
            let (positions, faces) = spheres(&[1.0, 0.99], 4, inward);
            let mesh = TriMesh::new(positions.iter().map(|p| p.to_array()).collect(), faces).unwrap();
            let original = Original::bare(&mesh);
            let scale = original.surface.length(1.0);
            // Coarse spheres over the same vertices: inner vertices protrude from the outer faces between outer
            // vertices.
            let (coarse, faces) = spheres(&[1.0, 0.99], 1, inward);
            let turn = glam::Quat::from_rotation_x(0.31) * glam::Quat::from_rotation_y(0.2);
            let n = coarse.len() / 2;
            let place = |(v, p): (usize, &Vec3)| scale * if v < n { *p } else { turn * *p };
            let places: Vec<Vec3> = coarse.iter().enumerate().map(place).collect();
            let mut output = Output::from_original(&original.surface.positions, places.clone(), faces);
            // Only the component counts; the nearest vertex may be of the other one.
            let n_original = output.vertex_of.len();
            output.vertex_of = (0..n_original).map(|v| if v < n_original / 2 { 0 } else { n as u32 }).collect();
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
            separate_nested(&original, &mut output, |_| 0);
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
            let mut output = Output::from_original(&places, places.clone(), faces.clone());
            separate_nested(&original, &mut output, |_| 0);
            assert_eq!(output.positions, places);
        }
    }
}
