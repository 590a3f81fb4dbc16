//! Least squares of the output vertices to the original surface.
//!
//! A vertex at the minimum of its tangent planes lies too far inside a curved surface for the triangles around it
//! to cut the surface. So centroids of input faces are sent to the nearest output face, and the output vertices
//! move toward where the weighted squared distances along the faces' normals are smallest: each in the direction of
//! its own 3 x 3 system, all by the length that is best for them together. A step that turns a face or does not pay
//! is not taken.

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::triangle::{area_normal, nearest_weights};

use super::faces_around::FacesAround;
use super::surface::Surface;

/// Input faces looked at per output vertex, at most.
const POINTS_PER_VERTEX: usize = 14;
/// Points that are matched by one thread in a row.
const CHUNK: usize = 1024;
/// Weight of staying in place against the points.
pub(super) const STAY: f32 = 0.01;
/// Least cosine between a face's normal before and after a step.
const LEAST_COSINE: f32 = 0.7;

/// Least cosine between a face's normal and where it is meant to look.
const LEAST_MEANT: f32 = 0.2;
/// Cosine between normals above which a guess where a point belongs is believed.
const AGREES: f32 = 0.8;

/// The output mesh as the fit moves it.
pub(super) struct Output<'a> {
    /// Normalised positions, n_vertices x 3.
    pub positions: &'a mut [Vec3],
    /// Faces, n_faces x 3.
    pub faces: &'a [[u32; 3]],
    /// Which way the faces are meant to look, n_faces x 3: no step turns one away from it.
    pub meant: &'a [Vec3],
    /// For each input vertex the output vertex that its region became.
    pub vertex_of: &'a [u32],
}

/// A point of the original over the output face nearest to it.
pub(super) struct Match {
    /// The input face whose centroid the point is.
    pub point: u32,
    /// The output face.
    pub face: u32,
    /// Barycentric weights of the nearest point, scaled with the square root of the point's area.
    pub weights: [f32; 3],
    /// Height over the face, scaled likewise.
    height: f32,
}

/// A step as it was taken.
pub(super) struct Step {
    /// The points and where they belonged.
    pub matches: Vec<Match>,
    /// For each output vertex whether it moved.
    pub moved: Vec<bool>,
}

/// Moves the output vertices toward the original surface `n_steps` times; appends the steps to `history`, if any.
pub(super) fn fit(surface: &Surface, output: &mut Output, n_steps: usize, mut history: Option<&mut Vec<Step>>) {
    let around = FacesAround::new(output.positions.len(), output.faces);
    let n_faces = surface.faces.len();
    let n_points = n_faces.min(POINTS_PER_VERTEX * output.positions.len());
    let mut guesses = vec![u32::MAX; n_points];
    for _ in 0..n_steps {
        let target = Target::new(output, &around);
        let chunks = guesses.par_chunks_mut(CHUNK).enumerate();
        let matches: Vec<Vec<Match>> = chunks
            .map(|(chunk, guesses)| {
                let point = |i: usize| ((chunk * CHUNK + i) as u64 * n_faces as u64 / n_points as u64) as u32;
                guesses
                    .iter_mut()
                    .enumerate()
                    .filter_map(|(i, guess)| target.match_face(surface, point(i), guess))
                    .collect()
            })
            .collect();
        let steps = solve(output, &target.normals, &matches);
        let before = history.as_ref().map(|_| output.positions.to_vec());
        take_steps(output, &around, &steps);
        if let (Some(history), Some(before)) = (&mut history, before) {
            let moved = before.iter().zip(&*output.positions).map(|(p, q)| p != q).collect();
            history.push(Step { matches: matches.into_iter().flatten().collect(), moved });
        }
    }
}

/// A point of the original and which way the surface looks there.
struct Point {
    at: Vec3,
    normal: Vec3,
}

/// The surface on which points look for their place.
struct Target<'a> {
    positions: &'a [Vec3],
    faces: &'a [[u32; 3]],
    vertex_of: &'a [u32],
    around: &'a FacesAround,
    /// Unit normals of the faces.
    normals: Vec<Vec3>,
    /// Centroids of the faces.
    centroids: Vec<Vec3>,
}

/// The nearest point of one face.
struct Reach {
    face: u32,
    weights: [f32; 3],
    gap: Vec3,
    distance: f32,
}

impl<'a> Target<'a> {
    fn new(output: &'a Output, around: &'a FacesAround) -> Self {
        let corners = |face: &[u32; 3]| face.map(|v| output.positions[v as usize]);
        let normals = output.faces.par_iter().map(|face| area_normal(corners(face)).normalize_or_zero()).collect();
        let centroids = output.faces.par_iter().map(|face| corners(face).iter().sum::<Vec3>() / 3.0).collect();
        let Output { positions, faces, vertex_of, .. } = output;
        Self { positions, faces, vertex_of, around, normals, centroids }
    }

    /// Matches the centroid of an input face; `guess` says where to start, and remembers where the walk ended.
    fn match_face(&self, surface: &Surface, point: u32, guess: &mut u32) -> Option<Match> {
        let face = surface.faces[point as usize];
        let corners = face.map(|v| surface.positions[v as usize]);
        let normal = area_normal(corners);
        let centroid = Point { at: (corners[0] + corners[1] + corners[2]) / 3.0, normal };
        let reach = self.nearest(&centroid, *guess, self.vertex_of[face[0] as usize])?;
        *guess = reach.face;
        let scale = (0.5 * normal.length()).sqrt();
        let height = scale * self.normals[reach.face as usize].dot(reach.gap);
        Some(Match { point, face: reach.face, weights: reach.weights.map(|w| w * scale), height })
    }

    /// The nearest point to which a walk leads, from face `guess` or else from around `vertex`.
    fn nearest(&self, point: &Point, guess: u32, vertex: u32) -> Option<Reach> {
        let start = if guess == u32::MAX { self.nearest_centroid(point, vertex) } else { guess };
        let reach = self.reach(point, start, f32::INFINITY).map(|start| self.walk(point, start));
        reach.filter(|reach| self.agrees(point, reach)).or_else(|| {
            let mut best: Option<Reach> = None;
            for &f in self.around.faces(vertex) {
                let limit = best.as_ref().map_or(f32::INFINITY, |b| b.distance);
                best = self.reach(point, f, limit).or(best);
            }
            best.map(|start| self.walk(point, start))
        })
    }

    /// The face around `vertex` whose centroid lies nearest.
    fn nearest_centroid(&self, point: &Point, vertex: u32) -> u32 {
        let mut best = (f32::INFINITY, u32::MAX);
        for &f in self.around.faces(vertex) {
            let distance = self.centroids[f as usize].distance_squared(point.at);
            if distance < best.0 && self.normals[f as usize].dot(point.normal) > 0.0 {
                best = (distance, f);
            }
        }
        best.1
    }

    fn walk(&self, point: &Point, start: Reach) -> Reach {
        let mut best = start;
        while let Some(closer) = self.step(point, &best) {
            best = closer;
        }
        best
    }

    /// Whether the face reached looks the same way well enough for a walk not to have strayed over a crease.
    fn agrees(&self, point: &Point, reach: &Reach) -> bool {
        self.normals[reach.face as usize].dot(point.normal) >= AGREES * point.normal.length()
    }

    /// The nearest point of `face` if it looks the same way and is nearer than `limit` (squared).
    fn reach(&self, point: &Point, face: u32, limit: f32) -> Option<Reach> {
        if self.normals.get(face as usize)?.dot(point.normal) <= 0.0 {
            return None;
        }
        let triangle = self.faces[face as usize].map(|v| self.positions[v as usize]);
        let weights = nearest_weights(point.at, triangle);
        let gap = point.at - (triangle[0] * weights[0] + triangle[1] * weights[1] + triangle[2] * weights[2]);
        let distance = gap.length_squared();
        (distance < limit).then_some(Reach { face, weights, gap, distance })
    }

    /// A face beyond the edge or vertex on which `from` lies that is nearer; `None` inside a face.
    fn step(&self, point: &Point, from: &Reach) -> Option<Reach> {
        let on: [bool; 3] = from.weights.map(|w| w > 0.0);
        let n_on = on.iter().filter(|&&on| on).count();
        if n_on == 3 {
            return None;
        }
        let face = self.faces[from.face as usize];
        let pivot = on.iter().position(|&on| on)?;
        let mut best: Option<Reach> = None;
        for &f in self.around.faces(face[pivot]) {
            let other = self.faces[f as usize];
            let beyond = f != from.face && (n_on == 1 || (0..3).all(|i| !on[i] || other.contains(&face[i])));
            if beyond {
                let limit = best.as_ref().map_or(from.distance * (1.0 - 1e-6), |b| b.distance);
                best = self.reach(point, f, limit).or(best);
            }
        }
        best
    }
}

/// One step toward the solution of `(J'J + S) x = J'h`: J holds weights times normals, h heights, S the weight of
/// staying; preconditioned with lumped blocks of J'J. A vertex whose own points would not gain stays.
fn solve(output: &Output, normals: &[Vec3], matches: &[Vec<Match>]) -> Vec<Vec3> {
    let directions = directions(output, normals, matches);
    // Along its direction, a vertex's points change their sum of squares by -2 t slope + t^2 curvature.
    let mut slope = vec![0.0f32; directions.len()];
    let mut curvature = vec![0.0f32; directions.len()];
    for m in matches.iter().flatten() {
        let face = output.faces[m.face as usize];
        let normal = normals[m.face as usize];
        let rise: f32 = (0..3).map(|i| m.weights[i] * normal.dot(directions[face[i] as usize])).sum();
        let total: f32 = m.weights.iter().sum();
        for i in 0..3 {
            let share = if total > 0.0 { m.weights[i] / total } else { 0.0 };
            slope[face[i] as usize] += share * m.height * rise;
            curvature[face[i] as usize] += share * rise * rise;
        }
    }
    let sum = |values: &[f32]| values.iter().map(|&x| f64::from(x)).sum::<f64>();
    let length = (sum(&slope) / sum(&curvature).max(f64::MIN_POSITIVE)) as f32;
    let pays = |v: usize| 2.0 * slope[v] > length * curvature[v];
    (0..directions.len()).map(|v| if pays(v) { directions[v] * length } else { Vec3::ZERO }).collect()
}

/// Each vertex's solution of its own lumped 3 x 3 system.
fn directions(output: &Output, normals: &[Vec3], matches: &[Vec<Match>]) -> Vec<Vec3> {
    let mut systems = vec![[0.0f32; 9]; output.positions.len()];
    for m in matches.iter().flatten() {
        let n = normals[m.face as usize];
        let total: f32 = m.weights.iter().sum();
        for (v, weight) in output.faces[m.face as usize].into_iter().zip(m.weights) {
            let (w, h) = (weight * total, weight * m.height);
            let row = [w * n.x * n.x, w * n.x * n.y, w * n.x * n.z, w * n.y * n.y, w * n.y * n.z, w * n.z * n.z];
            let system = &mut systems[v as usize];
            system[..6].iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
            system[6..].iter_mut().zip((n * h).to_array()).for_each(|(sum, x)| *sum += x);
        }
    }
    systems.iter().map(solve_block).collect()
}

/// Solution of `(A + STAY tr(A) I) x = b` for the upper triangle of A and b in one row; zero where there is none.
fn solve_block(system: &[f32; 9]) -> Vec3 {
    let [xx, xy, xz, yy, yz, zz, ..] = *system;
    let stay = STAY * (xx + yy + zz);
    let (xx, yy, zz) = (xx + stay, yy + stay, zz + stay);
    let b = Vec3::new(system[6], system[7], system[8]);
    let rows = [
        Vec3::new(yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy),
        Vec3::new(xz * yz - xy * zz, xx * zz - xz * xz, xy * xz - xx * yz),
        Vec3::new(xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy),
    ];
    let determinant = xx * rows[0].x + xy * rows[0].y + xz * rows[0].z;
    let x = Vec3::new(rows[0].dot(b), rows[1].dot(b), rows[2].dot(b)) / determinant;
    if x.is_finite() { x } else { Vec3::ZERO }
}

/// Moves each vertex where no face around it turns.
fn take_steps(output: &mut Output, around: &FacesAround, steps: &[Vec3]) {
    for (v, step) in steps.iter().enumerate() {
        let target = output.positions[v] + *step;
        if !turns_a_face(output, around, v as u32, target) {
            output.positions[v] = target;
        }
    }
}

fn turns_a_face(output: &Output, around: &FacesAround, v: u32, target: Vec3) -> bool {
    around.faces(v).iter().any(|&f| {
        let face = output.faces[f as usize];
        let before = face.map(|w| output.positions[w as usize]);
        let after = face.map(|w| if w == v { target } else { output.positions[w as usize] });
        let (n, m) = (area_normal(before), area_normal(after));
        n.dot(m) < LEAST_COSINE * (n.length_squared() * m.length_squared()).sqrt()
            || m.dot(output.meant[f as usize]) < LEAST_MEANT * m.length()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// For each input vertex the nearest of these.
    fn nearest_of(surface: &Surface, positions: &[Vec3]) -> Vec<u32> {
        let nearest = |p: &Vec3| {
            let by_distance = |&x: &u32, &y: &u32| {
                let distance = |v: u32| positions[v as usize].distance_squared(*p);
                distance(x).total_cmp(&distance(y))
            };
            (0..positions.len() as u32).min_by(by_distance).unwrap()
        };
        surface.positions.iter().map(nearest).collect()
    }

    /// Fits the vertices of `coarse`, which lie on `fine`, and returns where they were and where they are.
    fn fitted(fine: &crate::mesh::TriMesh, coarse: &crate::mesh::TriMesh, n_steps: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        let surface = Surface::new(fine);
        let of =
            |p: &[f32; 3]| fine.positions().iter().position(|q| Vec3::from(*q).distance((*p).into()) < 1e-5).unwrap();
        let before: Vec<Vec3> = coarse.positions().iter().map(|p| surface.positions[of(p)]).collect();
        let mut positions = before.clone();
        let normal = |face: &[u32; 3]| area_normal(face.map(|v| before[v as usize])).normalize();
        let meant: Vec<Vec3> = coarse.faces().iter().map(normal).collect();
        let vertex_of = nearest_of(&surface, &before);
        let mut output =
            Output { positions: &mut positions, faces: coarse.faces(), meant: &meant, vertex_of: &vertex_of };
        fit(&surface, &mut output, n_steps, None);
        (before, positions)
    }

    #[test]
    fn an_inscribed_sphere_grows_until_its_faces_cut_the_surface() {
        let coarse = shapes::icosphere(1);
        let (before, after) = fitted(&shapes::icosphere(4), &coarse, 3);
        let radius = before[0].length();
        assert!(after.iter().all(|p| p.length() > 1.01 * radius && p.length() < 1.2 * radius));
        let inside = |positions: &[Vec3]| -> f32 {
            let centroid = |f: &[u32; 3]| f.iter().map(|&v| positions[v as usize]).sum::<Vec3>() / 3.0;
            coarse.faces().iter().map(|f| radius - centroid(f).length()).sum::<f32>() / coarse.faces().len() as f32
        };
        assert!(inside(&after) < 0.5 * inside(&before), "{} {}", inside(&after), inside(&before));
    }

    #[test]
    fn a_plane_that_fits_stays_where_it_is() {
        let (before, after) = fitted(&shapes::grid(12, 12), &shapes::grid(3, 4), 2);
        assert!(before.iter().zip(&after).all(|(p, q)| p.distance(*q) < 1e-6));
    }

    #[test]
    fn a_block_is_solved_and_an_empty_one_gives_no_step() {
        let x = solve_block(&[2.0, 0.0, 0.0, 1.0, 0.0, 1.0, 4.08, 1.04, -2.08]);
        assert!(x.distance(Vec3::new(2.0, 1.0, -2.0)) < 1e-5, "{x}");
        assert_eq!(solve_block(&[0.0; 9]), Vec3::ZERO);
    }
}
