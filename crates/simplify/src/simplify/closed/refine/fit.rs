//! Least-squares fit of the output vertices to the original surface.

use glam::Vec3;

use crate::geometry::triangle::area_normal;
use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::thread_ranges::{add_faces, indices_where, split_rows, thread_ranges};
use crate::parallel;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;
use crate::simplify::closed::prepare::surface::outer;
use crate::simplify::closed::trace::{Trace, TracedStep};

use super::facets::{Facets, Projection};
use super::far_points;
use super::sample_points::{Match, SamplePoints};
use super::strays;

/// Weight of a vertex's present position, over the trace of its 3 x 3 system.
// Points say little along the surface. Sixteen meshes: at 0.001 the largest distance is 2.5 % larger; at 0.004 the mean
// is 0.4 % larger.
const POSITION_WEIGHT: f32 = 0.002;
// `POSITION_WEIGHT` with held curves, which vertices would leave along the surface. Twelve meshes with creases: at 0.002
// the largest distance is 13 % larger, at 0.02 the mean 0.7 %.
const POSITION_WEIGHT_BY_CURVES: f32 = 0.01;
/// Longest step of a vertex, over the square root of a third of its faces' area.
// Nineteen meshes: at 1.4 the largest distance is 10 % larger.
const LONGEST_STEP: f32 = 0.7;
/// Least cosine between a face's normals before and after a step.
// The mean distance is 0.4 % larger at 0.9.
const LEAST_COSINE: f32 = 0.7;
/// Least cosine between a face's normal and its intended one.
// A guard, which changes no result of 121.
const LEAST_INTENDED: f32 = 0.2;

pub fn fit(original: &Original, points: &mut SamplePoints, output: &mut Output, trace: &mut Option<Trace>) {
    // With held curves one step only: every step moves vertices off their curves.
    let n_steps = if !original.features.has_held_edges() { points.n_steps() } else { 1 };
    let start = output.positions.clone();
    for n_before in 0..n_steps {
        // Three points per face pay only after the first, largest step.
        if n_before > 0 {
            points.use_three_per_face();
        }
        step(original, points, output, &start, trace.as_mut());
    }
    // Where a tip was cut off, points can be far from all faces and yet at hardly any height above their planes. So far
    // points attract faces.
    for _ in 0..points.settings().far_rounds {
        let pulse = points.pulse().counting_if(false);
        let facets = Facets::new(pulse, output);
        let steps = far_points::attraction_steps(points, &facets);
        let boundary = boundary_vertices(pulse, points, output);
        output.positions = take_steps(pulse, &facets, &steps, &boundary);
    }
}

fn step(
    original: &Original,
    points: &mut SamplePoints,
    output: &mut Output,
    start: &[Vec3],
    trace: Option<&mut Trace>,
) {
    // Sample points of the original are assigned to output faces. Then vertices move to minimise the weighted squared
    // heights of the points: each along the solution of its own 3 x 3 system, all by one common step length.
    let pulse = points.pulse().counting_if(false);
    let facets = Facets::new(pulse, output);
    // Matches are kept only for the derivative.
    let mut matches = trace.as_ref().map(|_| Vec::new());
    // The sums grow in chunks, since clearing millions of them at once would delay the progress.
    let mut sums = Vec::with_capacity(output.faces().len());
    pulse.ranges(0..output.faces().len()).for_each(|faces| sums.resize(faces.end, FaceSums::default()));
    points.assign(&facets, |found| {
        add_all(&mut sums, found);
        matches.iter_mut().for_each(|matches| matches.extend(found.iter().flatten()));
    });
    pulse.beat(0);
    let square = mean_square(&sums);
    pulse.beat(0);
    // Weights follow from the heights of this step, so outliers are found again in each step.
    let face_weights = face_weights(pulse, &sums, points.settings().full_weight, square);
    pulse.beat(0);
    let stay = if !original.features.has_held_edges() { POSITION_WEIGHT } else { POSITION_WEIGHT_BY_CURVES };
    let weighed = WeightedSums { sums: &sums, face_weights: &face_weights, thinning: points.thinning(), stay };
    let mut steps = solve(pulse, &facets, &weighed);
    // Above a spike there are no points, so heights do not stop its vertex; its distance to the original does.
    strays::cancel_stray_steps(original, &facets, start, &mut steps, square.sqrt());
    let boundary = boundary_vertices(pulse, points, output);
    let after = take_steps(pulse, &facets, &steps, &boundary);
    // The memory is freed in two steps, since freeing millions of faces takes a while.
    drop(facets);
    pulse.beat(0);
    drop(sums);
    pulse.beat(0);
    if let (Some(trace), Some(matches)) = (trace, matches) {
        // The derivative needs to know which vertices moved, but not why others stayed.
        let moved = after.iter().zip(&output.positions).map(|(p, q)| p != q).collect();
        trace.steps.push(TracedStep { density: points.density(), matches, face_weights, moved, stay });
    }
    output.positions.copy_from_slice(&after);
}

#[derive(Clone, Copy, Default)]
struct FaceSums {
    weights: [f32; 3],
    heights: [f32; 3],
    products: [f32; 6],
    squares: f32,
}

struct WeightedSums<'a> {
    sums: &'a [FaceSums],
    face_weights: &'a [f32],
    thinning: f32,
    stay: f32,
}

fn add_all(sums: &mut [FaceSums], found: &[Option<Match>]) {
    // Each thread owns a range of faces and scans all matches, so every sum has one order.
    let shares = thread_ranges(sums.len());
    parallel::each(shares.iter().zip(split_rows(&shares, sums, |f| f + 1)), |(share, sums)| {
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

    fn area(&self) -> f32 {
        self.weights.iter().sum()
    }

    /// Returns how the summed squared heights change if the corners rise by `t * rises`: the factors of `-2 t` and
    /// `t^2`.
    fn slope_and_curvature(&self, rises: [f32; 3]) -> [f32; 2] {
        // The rise of a point is the weighted mean of its corners' rises.
        let next = |i: usize| rises[(i + 1) % 3];
        let slope = (0..3).map(|i| self.heights[i] * rises[i]).sum();
        let square = |i: usize| rises[i] * (self.products[i] * rises[i] + 2.0 * self.products[3 + i] * next(i));
        [slope, (0..3).map(square).sum()]
    }
}

fn mean_square(sums: &[FaceSums]) -> f32 {
    // In single precision millions of small terms would be lost.
    let [squares, area] = sums
        .iter()
        .fold([0.0f64; 2], |[squares, area], sum| [squares + f64::from(sum.squares), area + f64::from(sum.area())]);
    (squares / area.max(f64::MIN_POSITIVE)) as f32
}

/// Returns the weight of each face's points, about the inverse of their root mean square height.
fn face_weights(pulse: Pulse, sums: &[FaceSums], full_weight: f32, mean: f32) -> Vec<f32> {
    let count = |sum: &FaceSums| {
        // Iteratively reweighted least squares: with weights from the last heights, heights and not their squares are
        // minimised.
        let count = 1.0 / (sum.squares / (sum.area() * mean) + full_weight).sqrt();
        // A face without points or heights has no effect.
        if count.is_finite() { count } else { 1.0 }
    };
    pulse.map(sums, count)
}

/// Computes one step toward the solution of `(J'J + S) x = J'h`, preconditioned with lumped blocks of J'J.
///
/// J holds weights times normals, h heights, S the weights of positions.
fn solve(pulse: Pulse, facets: &Facets, weighed: &WeightedSums) -> Vec<Vec3> {
    let WeightedSums { sums, face_weights, thinning, .. } = *weighed;
    let faces = facets.output.faces();
    let directions = directions(pulse, facets, weighed);
    // One length for all vertices: separate lengths would interfere at shared faces.
    let change = |f: usize| {
        let normal = facets.normal(f as u32);
        let rises = faces[f].map(|v| normal.dot(directions[v as usize]));
        sums[f].slope_and_curvature(rises).map(|change| face_weights[f] * change)
    };
    let changes: Vec<[f32; 2]> = pulse.map_numbers(sums.len(), change);
    pulse.beat(0);
    let total = |k: usize| changes.iter().map(|change| f64::from(change[k])).sum::<f64>();
    // The best length is where the sum of all parabolas is lowest.
    let total = [total(0), total(1)];
    // Per vertex: slope, curvature and area of its share of the points.
    let mut gains = vec![[0.0f32; 3]; directions.len()];
    // A face's gain is divided among its corners by their share of its points.
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
    let step = |v: usize| {
        let (step, [slope, curvature, area]) = (directions[v] * length, gains[v]);
        // Long steps would leave the region in which heights were measured.
        let is_near = step.length_squared() <= LONGEST_STEP * LONGEST_STEP * thinning * area;
        if is_near && 2.0 * slope > length * curvature { step } else { Vec3::ZERO }
    };
    parallel::map(directions.len(), PARALLEL, step)
}

fn directions(
    pulse: Pulse,
    facets: &Facets,
    WeightedSums { sums, face_weights, stay, .. }: &WeightedSums,
) -> Vec<Vec3> {
    let output = facets.output;
    let mut systems = vec![[0.0f32; 9]; output.positions.len()];
    // The weight of a face multiplies matrix and right side.
    let planes = |f: usize| {
        let normal = facets.normal(f as u32);
        (normal * face_weights[f], outer(normal, face_weights[f]), &sums[f])
    };
    add_faces(pulse, &mut systems, output.faces(), planes, |system, (normal, outer, sum), corner| {
        system[..6].iter_mut().zip(outer).for_each(|(entry, x)| *entry += sum.weights[corner] * x);
        system[6..].iter_mut().zip(normal.to_array()).for_each(|(entry, x)| *entry += sum.heights[corner] * x);
    });
    parallel::map(systems.len(), PARALLEL, |v| solve_block(&systems[v], *stay))
}

/// Solves `(A + stay tr(A) I) x = b`, A as an upper triangle; zero without a solution.
fn solve_block(system: &[f32; 9], stay: f32) -> Vec3 {
    let [xx, xy, xz, yy, yz, zz, bx, by, bz] = *system;
    // Relative to the trace, the weight of the position does not depend on scale. `L D L'` is used since cofactors
    // would lose that weight.
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

fn take_steps(pulse: Pulse, facets: &Facets, steps: &[Vec3], boundary: &[u32]) -> Vec<Vec3> {
    let output = facets.output;
    let mut after: Vec<Vec3> = output.positions.iter().zip(steps).map(|(p, step)| *p + *step).collect();
    // Heights do not show where the surface ends, so boundary vertices stay, like locked ones.
    let stay = output.pins.locked_vertices().chain(boundary.iter().copied());
    stay.for_each(|v| after[v as usize] = output.positions[v as usize]);
    // A corner that returns can turn other faces, so this repeats until no face is turned.
    let mut turned = indices_where(pulse, output.faces(), |f, _| is_turned_too_far(facets, f, &after));
    while !turned.is_empty() {
        let mut back = Vec::new();
        for v in turned.iter().flat_map(|&f| output.face(f)) {
            // All three corners return, since it is not known which of them turned the face.
            let (now, before) = (&mut after[v as usize], output.positions[v as usize]);
            if *now != before {
                *now = before;
                back.push(v);
            }
        }
        turned = back
            .iter()
            .flat_map(|&v| output.faces_around().faces(v))
            .filter(|&f| is_turned_too_far(facets, f, &after))
            .collect();
    }
    after
}

fn boundary_vertices(pulse: Pulse, points: &SamplePoints, output: &Output) -> Vec<u32> {
    if !points.have_boundary() {
        return Vec::new();
    }
    // A directed edge without its opposite is a boundary.
    let is_open = |&[a, b]: &[u32; 2]| output.faces_around().face_along(b, a).is_none();
    let open_sides = |face: usize| {
        let [a, b, c] = output.faces()[face];
        [[a, b], [b, c], [c, a]].into_iter().filter(is_open).flatten()
    };
    let mut vertices = Vec::new();
    for faces in pulse.ranges(0..output.faces().len()) {
        vertices.extend(parallel::flat_map(faces, PARALLEL, open_sides));
    }
    vertices
}

/// Returns whether a face would turn too far from its present or intended normal.
fn is_turned_too_far(facets: &Facets, f: u32, after: &[Vec3]) -> bool {
    let normal = area_normal(facets.output.face(f).map(|v| after[v as usize]));
    let below = |unit: Vec3, least: f32| {
        let along = unit.dot(normal);
        along < 0.0 || along * along < least * least * normal.length_squared()
    };
    below(facets.normal(f), LEAST_COSINE) || below(facets.output.intended_normal(f), LEAST_INTENDED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::stage_settings::StageSettings;

    fn fit_coarse(fine: &TriMesh, coarse: &TriMesh, n_steps: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        let original = Original::bare(fine);
        let surface = &original.surface;
        let of =
            |p: &[f32; 3]| fine.positions().iter().position(|q| Vec3::from(*q).distance((*p).into()) < 1e-5).unwrap();
        let before: Vec<Vec3> = coarse.positions().iter().map(|p| surface.positions[of(p)]).collect();
        let mut output = Output::from_original(&surface.positions, before.clone(), coarse.faces().to_vec());
        let mut points = SamplePoints::new(surface, before.len(), StageSettings::default());
        for _ in 0..n_steps {
            step(&original, &mut points, &mut output, &before, None);
        }
        (before, output.positions)
    }

    #[test]
    fn an_inscribed_sphere_grows_until_its_faces_cut_the_surface() {
        let coarse = shapes::icosphere(1);
        let (before, after) = fit_coarse(&shapes::icosphere(4), &coarse, 3);
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
        let (before, after) = fit_coarse(&shapes::grid(12, 12), &shapes::grid(3, 4), 2);
        assert!(before.iter().zip(&after).all(|(p, q)| p.distance(*q) < 1e-6));
    }

    #[test]
    fn a_block_is_solved_and_an_empty_one_gives_no_step() {
        let x = solve_block(&[2.0, 0.5, 0.0, 1.0, 0.0, 1.0, 4.516, 2.008, -2.016], 0.002);
        assert!(x.distance(Vec3::new(2.0, 1.0, -2.0)) < 1e-5, "{x}");
        assert_eq!(solve_block(&[0.0; 9], 0.002), Vec3::ZERO);
    }
}
