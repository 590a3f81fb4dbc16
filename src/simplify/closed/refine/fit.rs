//! Least squares of the output vertices to the original surface.
//!
//! A vertex at the minimum of its tangent planes lies too far inside a curved surface for the triangles around it
//! to cut the surface. So points of input faces are sent to the output face that they lie over, and the output
//! vertices move toward where the weighted squared heights over the faces are smallest: each in the direction of
//! its own 3 x 3 system, all by the length that is best for them together. Points of faces that lie far from them count
//! less, so that a few do not decide for all. A step that turns a face, does not pay or goes far is not taken, and none at
//! a boundary: heights over the faces say nothing about where the surface ends.

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::triangle::area_normal;
use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::{add_faces, indices_where, split_rows, thread_ranges};
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;
use crate::simplify::closed::prepare::surface::outer;
use crate::simplify::closed::trace::{Step, Trace};

use super::facets::{Facets, Projection};
use super::far_points;
use super::points::{Match, Points};
use super::strays;

/// Weight of staying in place against the points, which say little along the surface. Sixteen training meshes, four
/// ratios: at 0.001 the largest distance is 2.5 % farther; at 0.004 it is 3 % nearer and the mean 0.4 % farther.
const STAY: f32 = 0.002;
/// The same where there are curves to keep, which vertices would leave along the surface. Twelve training meshes with
/// creases: at 0.002 the mean distance is 1.5 % nearer and the largest 13 % farther, at 0.02 the mean is 0.7 % farther.
const STAY_BY_CURVES: f32 = 0.01;
/// How far a vertex goes at most, over the root of a third of the area around it. Nineteen training meshes at ratios
/// 0.01 to 0.05: the largest distance is 10 % farther at 1.4 and 5 % nearer at 0.5, the mean 0.4 % farther and the
/// same.
const FARTHEST: f32 = 0.7;
/// Least cosine between a face's normal before and after a step. Nineteen training meshes at ratios 0.01 to 0.05: the
/// mean distance is 0.2 % nearer at 0.4 and 0.4 % farther at 0.9.
const LEAST_COSINE: f32 = 0.7;
/// Least cosine between a face's normal and where it is meant to look: what a collapse may turn a face by. It is a
/// guard: without it none of 121 results of training meshes differs.
const LEAST_MEANT: f32 = 0.2;

/// Moves the output vertices toward the points of the original, in as many steps as these are worth; writes the steps down
/// where that is wanted.
pub fn fit(original: &Original, points: &mut Points, output: &mut Output, trace: &mut Option<Trace>) {
    // Each step takes vertices of curves along the surface, off their curves.
    let n_steps = if !original.features.hold() { points.n_steps() } else { 1 };
    let start = output.positions.clone();
    for n_before in 0..n_steps {
        if n_before > 0 {
            points.multiply();
        }
        step(original, points, output, &start, trace.as_mut());
    }
    for _ in 0..points.aim().draws {
        let pulse = points.pulse().counting_if(false);
        let facets = Facets::new(pulse, output);
        let steps = far_points::draw(points, &facets);
        let boundary = boundary_vertices(pulse, points, output);
        output.positions = take_steps(pulse, &facets, &steps, &boundary);
    }
}

/// Moves the output vertices, which were at `start` before the fit, by one step.
fn step(original: &Original, points: &mut Points, output: &mut Output, start: &[Vec3], trace: Option<&mut Trace>) {
    let pulse = points.pulse().counting_if(false);
    let facets = Facets::new(pulse, output);
    let mut matches = trace.as_ref().map(|_| Vec::new());
    let mut sums = Vec::with_capacity(output.faces().len());
    pulse.ranges(0..output.faces().len()).for_each(|faces| sums.resize(faces.end, FaceSums::default()));
    points.place(&facets, |found| {
        add_all(&mut sums, found);
        matches.iter_mut().for_each(|matches| matches.extend(found.iter().flatten()));
    });
    pulse.beat(0);
    let square = mean_square(&sums);
    pulse.beat(0);
    let counts = counts(pulse, &sums, points.aim().usual, square);
    pulse.beat(0);
    let stay = if !original.features.hold() { STAY } else { STAY_BY_CURVES };
    let weighed = Weighed { sums: &sums, counts: &counts, thinning: points.thinning(), stay };
    let mut steps = solve(pulse, &facets, &weighed);
    strays::take_back(original, &facets, start, &mut steps, square.sqrt());
    let boundary = boundary_vertices(pulse, points, output);
    let after = take_steps(pulse, &facets, &steps, &boundary);
    // Memory goes back in two parts: that of millions of faces takes a while.
    drop(facets);
    pulse.beat(0);
    drop(sums);
    pulse.beat(0);
    if let (Some(trace), Some(matches)) = (trace, matches) {
        let moved = after.iter().zip(&output.positions).map(|(p, q)| p != q).collect();
        trace.steps.push(Step { density: points.density(), matches, counts, moved, stay });
    }
    output.positions.copy_from_slice(&after);
}

/// Sums over the points of a face, weighted with their areas.
#[derive(Clone, Copy, Default)]
struct FaceSums {
    /// The barycentric weights.
    weights: [f32; 3],
    /// Weights times heights.
    heights: [f32; 3],
    /// Products of weights: 00, 11, 22, 01, 12, 20.
    products: [f32; 6],
    /// The squared heights.
    squares: f32,
}

/// The sums over all faces, and how much each face counts.
struct Weighed<'a> {
    sums: &'a [FaceSums],
    counts: &'a [f32],
    /// By how much fewer points there are than on all faces of the original.
    thinning: f32,
    /// Weight of staying in place against the points.
    stay: f32,
}

/// Adds matches to the sums of their faces, in their order whatever the number of threads.
fn add_all(sums: &mut [FaceSums], found: &[Option<Match>]) {
    let shares = thread_ranges(sums.len());
    let parts: Vec<_> = shares.iter().zip(split_rows(&shares, sums, |f| f + 1)).collect();
    parts.into_par_iter().for_each(|(share, sums)| {
        for found in found.iter().flatten() {
            if let Some(sum) = sums.get_mut((found.projection.face as usize).wrapping_sub(share.start)) {
                sum.add(found);
            }
        }
    });
}

impl FaceSums {
    fn add(&mut self, Match { area, projection: Projection { weights, height, .. }, .. }: &Match) {
        let weighted = weights.map(|w| w * area);
        self.squares += area * height * height;
        for i in 0..3 {
            self.weights[i] += weighted[i];
            self.heights[i] += weighted[i] * height;
            self.products[i] += weighted[i] * weights[i];
            self.products[3 + i] += weighted[i] * weights[(i + 1) % 3];
        }
    }

    /// Area of the points.
    fn area(&self) -> f32 {
        self.weights.iter().sum()
    }

    /// By how much the squared heights change when the corners rise by as much as this times t: the factors of
    /// `-2 t` and of `t^2`.
    fn slope_and_curvature(&self, rises: [f32; 3]) -> [f32; 2] {
        let next = |i: usize| rises[(i + 1) % 3];
        let slope = (0..3).map(|i| self.heights[i] * rises[i]).sum();
        let square = |i: usize| rises[i] * (self.products[i] * rises[i] + 2.0 * self.products[3 + i] * next(i));
        [slope, (0..3).map(square).sum()]
    }
}

/// The mean squared height of the points.
fn mean_square(sums: &[FaceSums]) -> f32 {
    let [squares, area] = sums
        .iter()
        .fold([0.0f64; 2], |[squares, area], sum| [squares + f64::from(sum.squares), area + f64::from(sum.area())]);
    (squares / area.max(f64::MIN_POSITIVE)) as f32
}

/// How much the points of each face count: about as the inverse of their height, so that the heights themselves get small and
/// not their squares. Squared heights up to about `usual` times their mean count alike.
fn counts(pulse: Pulse, sums: &[FaceSums], usual: f32, mean: f32) -> Vec<f32> {
    let count = |sum: &FaceSums| {
        let count = 1.0 / (sum.squares / (sum.area() * mean) + usual).sqrt();
        // Without points or heights there is nothing to weigh.
        if count.is_finite() { count } else { 1.0 }
    };
    pulse.map(sums, count)
}

/// One step toward the solution of `(J'J + S) x = J'h`: J holds weights times normals, h heights, S the weight of
/// staying; preconditioned with lumped blocks of J'J. A vertex whose own faces would not gain stays, and one that would go far.
fn solve(pulse: Pulse, facets: &Facets, weighed: &Weighed) -> Vec<Vec3> {
    let Weighed { sums, counts, thinning, .. } = *weighed;
    let faces = facets.output.faces();
    let directions = directions(pulse, facets, weighed);
    let change = |f: usize| {
        let normal = facets.normal(f as u32);
        let rises = faces[f].map(|v| normal.dot(directions[v as usize]));
        sums[f].slope_and_curvature(rises).map(|change| counts[f] * change)
    };
    let changes: Vec<[f32; 2]> = pulse.map_numbers(sums.len(), change);
    pulse.beat(0);
    let total = |k: usize| changes.iter().map(|change| f64::from(change[k])).sum::<f64>();
    let total = [total(0), total(1)];
    // Slope, curvature and the area of the points.
    let mut gains = vec![[0.0f32; 3]; directions.len()];
    let shares = |f: usize| {
        let whole = sums[f].area();
        let share = if whole > 0.0 { 1.0 / whole } else { 0.0 };
        let [slope, curvature] = changes[f];
        sums[f].weights.map(|weight| [weight * share * slope, weight * share * curvature, weight])
    };
    add_faces(pulse, &mut gains, faces, shares, |gain, shares, corner| {
        gain.iter_mut().zip(shares[corner]).for_each(|(gain, share)| *gain += share);
    });
    pulse.beat(0);
    let length = (total[0] / total[1].max(f64::MIN_POSITIVE)) as f32;
    let step = |(d, [slope, curvature, area]): (&Vec3, [f32; 3])| {
        let step = *d * length;
        let is_near = step.length_squared() <= FARTHEST * FARTHEST * thinning * area;
        if is_near && 2.0 * slope > length * curvature { step } else { Vec3::ZERO }
    };
    directions.par_iter().zip(gains).map(step).collect()
}

/// Each vertex's solution of its own lumped 3 x 3 system.
fn directions(pulse: Pulse, facets: &Facets, Weighed { sums, counts, stay, .. }: &Weighed) -> Vec<Vec3> {
    let output = facets.output;
    let mut systems = vec![[0.0f32; 9]; output.positions.len()];
    let planes = |f: usize| {
        let normal = facets.normal(f as u32);
        (normal * counts[f], outer(normal, counts[f]), &sums[f])
    };
    add_faces(pulse, &mut systems, output.faces(), planes, |system, (normal, outer, sum), corner| {
        system[..6].iter_mut().zip(outer).for_each(|(entry, x)| *entry += sum.weights[corner] * x);
        system[6..].iter_mut().zip(normal.to_array()).for_each(|(entry, x)| *entry += sum.heights[corner] * x);
    });
    output.pins.plane().into_iter().for_each(|plane| plane.confine(&mut systems));
    systems.par_iter().map(|system| solve_block(system, *stay)).collect()
}

/// Solution of `(A + stay tr(A) I) x = b` for the upper triangle of A and b in one row; zero where there is none.
///
/// By `L D L'`: cofactors in single precision would lose what the small weight of staying says.
fn solve_block(system: &[f32; 9], stay: f32) -> Vec3 {
    let [xx, xy, xz, yy, yz, zz, bx, by, bz] = *system;
    let stay = stay * (xx + yy + zz);
    let (d0, yy, zz) = (xx + stay, yy + stay, zz + stay);
    let (l10, l20) = (xy / d0, xz / d0);
    let d1 = yy - l10 * xy;
    let off = yz - l20 * xy;
    let l21 = off / d1;
    let d2 = zz - l20 * xz - l21 * off;
    let y1 = by - l10 * bx;
    let z = (bz - l20 * bx - l21 * y1) / d2;
    let y = y1 / d1 - l21 * z;
    let x = Vec3::new(bx / d0 - l10 * y - l20 * z, y, z);
    if x.is_finite() { x } else { Vec3::ZERO }
}

/// The positions after the steps, those left out that would turn a face: they and the other two corners' stay.
fn take_steps(pulse: Pulse, facets: &Facets, steps: &[Vec3], boundary: &[u32]) -> Vec<Vec3> {
    let output = facets.output;
    let mut after: Vec<Vec3> = output.positions.par_iter().zip(steps).map(|(p, step)| *p + *step).collect();
    let stay = output.pins.locked_vertices().chain(boundary.iter().copied());
    stay.for_each(|v| after[v as usize] = output.positions[v as usize]);
    let mut turned = indices_where(pulse, output.faces(), |f, _| turns(facets, f, &after));
    while !turned.is_empty() {
        let mut back = Vec::new();
        for v in turned.iter().flat_map(|&f| output.face(f)) {
            let (now, before) = (&mut after[v as usize], output.positions[v as usize]);
            if *now != before {
                *now = before;
                back.push(v);
            }
        }
        turned = back.iter().flat_map(|&v| output.around().faces(v)).filter(|&f| turns(facets, f, &after)).collect();
    }
    after
}

/// The vertices of the boundaries, but for those of the cut of a half.
fn boundary_vertices(pulse: Pulse, points: &Points, output: &Output) -> Vec<u32> {
    if !points.have_boundary() {
        return Vec::new();
    }
    let is_open = |&[a, b]: &[u32; 2]| output.around().along(b, a).is_none() && !output.pins.are_on_cut(a, b);
    let mut vertices = Vec::new();
    for faces in pulse.chunks(output.faces()) {
        let sides = faces.par_iter().flat_map_iter(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        vertices.par_extend(sides.filter(is_open).flatten_iter());
    }
    vertices
}

/// Whether a face turns too far when its corners go to where they are `after`.
fn turns(facets: &Facets, f: u32, after: &[Vec3]) -> bool {
    let normal = area_normal(facets.output.face(f).map(|v| after[v as usize]));
    let below = |unit: Vec3, least: f32| {
        let along = unit.dot(normal);
        along < 0.0 || along * along < least * least * normal.length_squared()
    };
    below(facets.normal(f), LEAST_COSINE) || below(facets.output.meant(f), LEAST_MEANT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::aim::Aim;

    /// Fits the vertices of `coarse`, which lie on `fine`, and returns where they were and where they are.
    fn fitted(fine: &TriMesh, coarse: &TriMesh, n_steps: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        let original = Original::bare(fine);
        let surface = &original.surface;
        let of =
            |p: &[f32; 3]| fine.positions().iter().position(|q| Vec3::from(*q).distance((*p).into()) < 1e-5).unwrap();
        let before: Vec<Vec3> = coarse.positions().iter().map(|p| surface.positions[of(p)]).collect();
        let mut output = Output::over(&surface.positions, before.clone(), coarse.faces().to_vec());
        let mut points = Points::new(surface, before.len(), Aim::default());
        for _ in 0..n_steps {
            step(&original, &mut points, &mut output, &before, None);
        }
        (before, output.positions)
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
        let x = solve_block(&[2.0, 0.5, 0.0, 1.0, 0.0, 1.0, 4.516, 2.008, -2.016], 0.002);
        assert!(x.distance(Vec3::new(2.0, 1.0, -2.0)) < 1e-5, "{x}");
        assert_eq!(solve_block(&[0.0; 9], 0.002), Vec3::ZERO);
    }
}
