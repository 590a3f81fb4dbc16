//! Nested surfaces: faces that pass through another component, or through the other side of a thin shell, are moved back.

use std::sync::OnceLock;

use glam::Vec3;

use crate::geometry::crossing::triangles_cross;
use crate::geometry::triangle::{area_normal, unit_normal};
use crate::linalg::Rows;
use crate::parallel;
use crate::simplify::closed::dropping::{output_components, vertex_components};
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;
use crate::spatial::{Hit, NearestOnTriangles};

/// Least cosine between another component's normal and the direction to a point whose side is clear.
const LEAST_SIDE_COSINE: f32 = 0.5;
/// Least absolute cosine between the normals of two nested surfaces.
// Components that pass through each other on purpose meet at larger angles.
const LEAST_NESTING_COSINE: f32 = 0.8;
/// Distance at unit size up to which two components count as touching.
const TOUCHING: f32 = 1e-5;
const LONGEST_STEP: f32 = 0.1;
const ROUNDS: usize = 20;
/// Rounds go on while one crossing in this many is moved back.
// On a skull and a chair, two rounds of three to five make 92 to 99 % of the moves.
const LEAST_MOVED: usize = 10;
/// Largest number of face pairs tested: a base number, plus a number per face.
// Thousands of needles that share a corner would be tested in all pairs.
const MOST_TESTS: [usize; 2] = [100_000, 200];
/// Tests charged for a crossing face: five searches from seven points.
const TESTS_PER_CROSSING: usize = 35;
const CHUNK: usize = 256;
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
    component: u32,
    other: u32,
    /// True if both faces are of one component, on the two sides of a thin shell.
    is_shell: bool,
}

type Moves = [(u32, Vec3); 3];

/// Moves crossing faces of nested components back, and of thin shells with `has_shells`.
///
/// `piece_of` returns the first scene piece placed as that of an original face.
pub fn separate_nested(original: &Original, output: &mut Output, piece_of: impl Fn(u32) -> usize, has_shells: bool) {
    // The fit moves each surface by itself: where two surfaces are closer than its error, their faces cross.
    let (mut component_of, n_components) = output_components(output);
    if n_components < 2 && !has_shells || output.pins.is_subset() {
        return;
    }
    component_of.resize(output.positions.len(), 0);
    let pulse = original.surface.pulse.counting_if(false);
    // Components are compared only where the pieces of the scene have one system of coordinates.
    let middles = middles(output, &component_of, n_components);
    let mut piece = vec![0; n_components];
    for (face, f) in original.surface.faces.iter().zip(0..) {
        piece[component_of[output.vertex_of[face[0] as usize] as usize] as usize] = piece_of(f);
    }
    let mut n_tests_left = MOST_TESTS[0] + MOST_TESTS[1] * output.faces().len();
    let mut faces: Vec<u32> = (0..output.faces().len() as u32).collect();
    let mut before = None;
    for _ in 0..ROUNDS {
        let tree = output.tree();
        let parts = OutputParts { component_of: &component_of, piece: &piece, has_shells };
        let crossings = find_crossings(output, &tree, &parts, &faces, &mut n_tests_left);
        if crossings.is_empty() {
            break;
        }
        // The trees over the original are built only once something crosses.
        let before = before.get_or_insert_with(|| OriginalComponents::new(original, output));
        let of_faces = output.faces().iter().map(|face| component_of[face[0] as usize]);
        let now = ComponentTrees::new(of_faces, n_components);
        let nested = NestedComponents { before, output, now: &now, component_of: &component_of, middles: &middles };
        // All moves of a round are found for the same positions, so each is made only if it still reduces the
        // crossings.
        let moves: Vec<Option<Moves>> = pulse.map(&crossings, |crossing| nested.deepest_move(crossing));
        let n_moved = moves.iter().flatten().filter(|moves| try_moves(output, &tree, moves, &mut n_tests_left)).count();
        if n_moved * LEAST_MOVED < crossings.len() {
            break;
        }
        // In the next round only the neighbourhood of moved faces can differ.
        let corners = crossings.iter().flat_map(|crossing| output.face(crossing.face));
        faces = output.faces_around().faces_of_all(corners);
    }
}

struct OutputParts<'a> {
    component_of: &'a [u32],
    /// Scene piece of each component.
    piece: &'a [usize],
    has_shells: bool,
}

fn find_crossings(
    output: &Output,
    tree: &NearestOnTriangles,
    &OutputParts { component_of, piece, has_shells }: &OutputParts,
    faces: &[u32],
    n_tests_left: &mut usize,
) -> Vec<Crossing> {
    let component = |f: u32| component_of[output.face(f)[0] as usize];
    let normal = |f: u32| unit_normal(output.triangle(f));
    let crossed = |&face: &u32| {
        let (mut crossed, mut n) = (Vec::new(), 0);
        let (own, along, here) = (component(face), normal(face), output.coordinates(face));
        tree.visit_touching(&here, |other| {
            n += 1;
            // Crossings of steep angles are intended, as are those of other scene pieces.
            let is_shell = component(other) == own;
            let cosine = || along.dot(normal(other));
            let may_cross = if is_shell {
                has_shells && cosine() < -LEAST_NESTING_COSINE
            } else {
                piece[component(other) as usize] == piece[own as usize] && cosine().abs() > LEAST_NESTING_COSINE
            };
            if may_cross && triangles_cross(here, output.coordinates(other)) {
                crossed.push(Crossing { face, component: component(other), other, is_shell });
            }
        });
        crossed.sort_unstable();
        // One crossing per component suffices: the search for the closest point finds the rest.
        crossed.dedup_by_key(|crossing| crossing.component);
        (crossed, n)
    };
    let mut all = Vec::new();
    for faces in faces.chunks(CHUNK) {
        if *n_tests_left == 0 {
            break;
        }
        for (crossed, n) in parallel::map(faces.len(), 16, |i| crossed(&faces[i])) {
            // The budget is charged in order, after the parallel tests, so that it is deterministic.
            *n_tests_left = n_tests_left.saturating_sub(n + TESTS_PER_CROSSING * crossed.len());
            all.extend(crossed);
        }
    }
    all
}

// Points are found by trees over all faces: with long faces a walk can end far from the closest point.
struct OriginalComponents<'a> {
    original: &'a Original<'a>,
    trees: ComponentTrees,
    component_before: Vec<u32>,
}

struct OriginalPoint {
    point: Vec3,
    normal: Vec3,
    distance: f32,
}

impl<'a> OriginalComponents<'a> {
    fn new(original: &'a Original, output: &Output) -> Self {
        let surface = &original.surface;
        let (of_vertex, n) = vertex_components(surface.positions.len(), &surface.faces);
        let component = |v: u32| of_vertex.get(v as usize).copied().unwrap_or_default();
        let all = vec![true; output.positions.len()];
        let nearest_in_regions = original.nearest_in_regions(&output.positions, &output.vertex_of, &all);
        Self {
            original,
            trees: ComponentTrees::new(surface.faces.iter().map(|face| component(face[0])), n),
            component_before: nearest_in_regions.into_iter().map(component).collect(),
        }
    }

    /// Finds the nearest point of a vertex' component, on faces toward a direction if there is one.
    fn nearest(&self, point: Vec3, vertex: u32, toward: Option<Vec3>) -> Option<OriginalPoint> {
        let surface = &self.original.surface;
        let corners = |f: u32| surface.faces[f as usize].map(|v| surface.positions[v as usize]);
        let triangle = |f: u32| corners(f).map(|corner| corner.to_array());
        let accept = |f: u32| toward.is_none_or(|toward| area_normal(corners(f)).dot(toward) > 0.0);
        let component = self.component_before[vertex as usize];
        let hit = self.trees.nearest(component, (point, f64::INFINITY), &triangle, &accept)?;
        let normal = unit_normal(corners(hit.triangle));
        Some(OriginalPoint { point: hit.point.as_vec3(), normal, distance: hit.distance2.sqrt() as f32 })
    }
}

// Each component has its own tree: one tree over all would visit every component where they overlap.
struct ComponentTrees {
    faces: Rows<u32>,
    trees: Vec<OnceLock<NearestOnTriangles>>,
}

impl ComponentTrees {
    fn new(of_faces: impl Iterator<Item = u32> + Clone, n: usize) -> Self {
        Self { faces: Rows::new(n, of_faces.zip(0..)), trees: (0..n).map(|_| OnceLock::new()).collect() }
    }

    fn nearest(
        &self,
        component: u32,
        (point, within): (Vec3, f64),
        triangle: &dyn Fn(u32) -> [[f32; 3]; 3],
        accept: &dyn Fn(u32) -> bool,
    ) -> Option<Hit> {
        let faces = self.faces.row(component as usize);
        let tree = self.trees[component as usize]
            .get_or_init(|| NearestOnTriangles::new(&faces.iter().map(|&f| triangle(f)).collect::<Vec<_>>()));
        let hit = tree.nearest_within(point.as_dvec3(), within, |i| accept(faces[i as usize]))?;
        Some(Hit { triangle: faces[hit.triangle as usize], ..hit })
    }
}

/// A point of a crossing face and the closest one of the other component.
struct FacePoint {
    weights: [f32; 3],
    place: Vec3,
    /// Largest distance between the two.
    reach: f32,
    /// The face's direction if both faces are of one component.
    along: Option<Vec3>,
    hit: Hit,
    /// Normal at the closest point.
    normal: Vec3,
    /// Distance along that normal.
    height: f32,
}

struct NestedComponents<'a> {
    before: &'a OriginalComponents<'a>,
    output: &'a Output,
    now: &'a ComponentTrees,
    component_of: &'a [u32],
    middles: &'a [Vec3],
}

impl NestedComponents<'_> {
    /// Finds the corner moves that bring back a face's point deepest on the wrong side of another component.
    fn deepest_move(&self, crossing: &Crossing) -> Option<Moves> {
        let mut points: Vec<FacePoint> = POINTS.iter().filter_map(|&w| self.find_point(crossing, w)).collect();
        points.sort_by(|p, q| q.height.abs().total_cmp(&p.height.abs()));
        points.iter().find_map(|point| self.find_moves(crossing, point))
    }

    fn find_point(&self, crossing: &Crossing, weights: [f32; 3]) -> Option<FacePoint> {
        let output = self.output;
        let here = output.triangle(crossing.face);
        let place = here[0] * weights[0] + here[1] * weights[1] + here[2] * weights[2];
        let reach = here[0].distance(here[1]).max(here[1].distance(here[2])).max(here[2].distance(here[0]));
        // Side and gap are measured along the other component's normal at the closest point.
        let along = crossing.is_shell.then(|| area_normal(here));
        // The sides of a shell look against each other.
        let accept = |f: u32| along.is_none_or(|along| area_normal(output.triangle(f)).dot(along) < 0.0);
        let triangle = |f: u32| output.coordinates(f);
        let hit = self.now.nearest(crossing.component, (place, f64::from(reach)), &triangle, &accept)?;
        let normal = unit_normal(output.triangle(hit.triangle));
        let height = (place - hit.point.as_vec3()).dot(normal);
        Some(FacePoint { weights, place, reach, along, hit, normal, height })
    }

    /// Returns the corner moves that bring a point back if it is on the wrong side of the other component.
    fn find_moves(&self, crossing: &Crossing, point: &FacePoint) -> Option<Moves> {
        let output = self.output;
        let &FacePoint { weights, place, reach, along, hit, normal, height } = point;
        let foot = hit.point.as_vec3();
        // The correct side comes from the original, the present side from the output.
        let (side, gap) = self.find_side(crossing, place, along)?;
        // The side is right if it is that of the original.
        if height * side > 0.0 {
            return None;
        }
        // Half the original gap is the target: a full one would move faces that are fine.
        let step = normal * (side * 0.5 * gap.min(reach) - height);
        // A step longer than both distances to the original together would spoil what is right.
        let distance = |point: Vec3, f: u32| {
            let toward = along.map(|_| area_normal(output.triangle(f)));
            self.before.nearest(point, output.face(f)[0], toward).map(|nearest| nearest.distance)
        };
        let both_off = || Some(distance(place, crossing.face)? + distance(foot, hit.triangle)?);
        if step.length() > LONGEST_STEP * reach || step.length() > both_off()? {
            return None;
        }
        // The face moves whose step leads toward the middle of its component: the inner one, so that the visible one
        // stays.
        let shrinks = |f: u32, step: Vec3| step.dot(self.middles[self.component(f) as usize] - place) > 0.0;
        if shrinks(crossing.face, step) {
            self.corner_moves(crossing.face, weights, step)
        } else if shrinks(hit.triangle, -step) {
            self.corner_moves(hit.triangle, hit.weights.map(|w| w as f32), -step)
        } else {
            None
        }
    }

    fn component(&self, f: u32) -> u32 {
        self.component_of[self.output.face(f)[0] as usize]
    }

    /// Returns the other component's side, 1 or -1, on which the original has a point, and their distance; `None` if
    /// unclear.
    fn find_side(&self, crossing: &Crossing, place: Vec3, along: Option<Vec3>) -> Option<(f32, f32)> {
        // From the point to its own component of the original, and from there to the other component.
        let here = self.before.nearest(place, self.output.face(crossing.face)[0], along)?;
        let there = self.before.nearest(here.point, self.output.face(crossing.other)[0], along.map(|along| -along))?;
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
        let is_free = |v: &u32| !self.output.pins.is_locked(*v);
        corners.iter().all(is_free).then(|| [0, 1, 2].map(|i| (corners[i], step * weights[i])))
    }
}

fn try_moves(output: &mut Output, tree: &NearestOnTriangles, moves: &Moves, n_tests_left: &mut usize) -> bool {
    let moved = moves.iter().filter(|(_, step)| *step != Vec3::ZERO).map(|(v, _)| *v);
    let faces = output.faces_around().faces_of_all(moved);
    let before = n_crossed(output, tree, &faces, n_tests_left);
    let places = moves.map(|(v, _)| output.positions[v as usize]);
    // The moves are made, tested, and taken back if they turn a face or do not reduce the crossings.
    moves.iter().for_each(|(v, step)| output.positions[*v as usize] += *step);
    let turns = |f: &u32| unit_normal(output.triangle(*f)).dot(output.intended_normal(*f)) <= 0.0;
    let reduces_crossings =
        before > 0 && !faces.iter().any(turns) && n_crossed(output, tree, &faces, n_tests_left) < before;
    let is_made = reduces_crossings && *n_tests_left > 0;
    if !is_made {
        moves.iter().zip(places).for_each(|((v, _), place)| output.positions[*v as usize] = place);
    }
    is_made
}

fn n_crossed(output: &Output, tree: &NearestOnTriangles, faces: &[u32], n_tests_left: &mut usize) -> usize {
    let mut n = 0;
    for &f in faces {
        if *n_tests_left == 0 {
            break;
        }
        let here = output.coordinates(f);
        tree.visit_touching(&here, |other| {
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
            separate_nested(&original, &mut output, |_| 0, false);
            assert!(before > n / 2 && outside(&output) == 0, "{before} {}", outside(&output));
            assert_eq!(output.positions[..n], places[..n]);
        }
    }

    /// Returns a dome of two sides, joined along its rim and around a hole at the top; the outer side comes first.
    fn dome(n_around: usize, n_across: usize, inner: f32, turn: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let torus = shapes::torus(n_around as u32, 2 * n_across as u32, 1.0, 0.4);
        let place = |i: usize| {
            let (around, across) = ((i / (2 * n_across)) as f32, i % (2 * n_across));
            let is_outer = across < n_across;
            let up = (if is_outer { across } else { 2 * n_across - 1 - across }) as f32 / (n_across - 1) as f32;
            let radius = if is_outer { 1.0 } else { inner };
            let angle = (around + if is_outer { 0.0 } else { turn }) * std::f32::consts::TAU / n_around as f32;
            let height = (0.1 + 0.8 * up) * std::f32::consts::FRAC_PI_2;
            radius * Vec3::new(angle.cos() * height.cos(), angle.sin() * height.cos(), height.sin())
        };
        ((0..torus.positions().len()).map(place).collect(), torus.faces().to_vec())
    }

    #[test]
    fn the_inner_side_of_a_thin_shell_moves_back_inside() {
        let (positions, faces) = dome(96, 24, 0.985, 0.0);
        let mesh = TriMesh::new(positions.iter().map(|p| p.to_array()).collect(), faces).unwrap();
        let original = Original::bare(&mesh);
        let scale = original.surface.length(1.0);
        let centre =
            original.surface.positions.iter().zip(&positions).map(|(unit, p)| *unit - *p * scale).next().unwrap();
        // The sides are cut into faces of different places, so that the inner one protrudes.
        let (coarse, faces) = dome(8, 3, 0.985, 0.5);
        let places: Vec<Vec3> = coarse.iter().map(|p| centre + *p * scale).collect();
        let mut output = Output::from_original(&original.surface.positions, places, faces);
        let n_crossing = |output: &Output| {
            let crosses = |f: u32, g: u32| {
                let shares = output.face(f).iter().any(|v| output.face(g).contains(v));
                !shares && triangles_cross(output.coordinates(f), output.coordinates(g))
            };
            let n = output.faces().len() as u32;
            (0..n).map(|f| (f + 1..n).filter(|&g| crosses(f, g)).count()).sum::<usize>()
        };
        let before = n_crossing(&output);
        let as_they_were = output.positions.clone();
        separate_nested(&original, &mut output, |_| 0, false);
        assert_eq!(output.positions, as_they_were);
        separate_nested(&original, &mut output, |_| 0, true);
        assert!(before > 50 && n_crossing(&output) * 20 < before, "{before} {}", n_crossing(&output));
        let is_outer = |p: &Vec3| ((*p - centre) / scale).length() > 0.999;
        assert!(as_they_were.iter().zip(&output.positions).all(|(was, now)| !is_outer(was) || was == now));
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
            separate_nested(&original, &mut output, |_| 0, false);
            assert_eq!(output.positions, places);
        }
    }
}
