//! The fit: vertices move to least squared distances from samples of the input, one point of each input face.
//!
//! No search: the record says which vertex the nearest corner of a sample's face became, and the nearest face of the
//! result is in that vertex' star, or a few stars on.

use crate::collapse::lanes::dispatch;
use crate::collapse::rings::{Rings, state};
use crate::collapse::samples::{Sample, SampleMoments, SumSamples};
use crate::collapse::team::{STRETCH, Team};
use crate::collapse::vector::{Point, cross, dot, subtract};

/// Factor of each step; at 1.5 the mean distance is 0.5 % smaller, the largest 3 % larger.
const RELAXATION: f32 = 1.2;

/// Pull to the present position, over the trace of the system; keeps directions that no sample tells.
const PULL: f32 = 0.002;

/// Largest squared step, over twice the area of a vertex.
///
/// At 0.1 the largest distance is 12 to 15 % larger at ratios of 0.005 and 0.01, 1 to 2 % at 0.05 and 0.1.
const LONGEST_STEP: f32 = 0.01;

/// Mean squared distance of samples before the first step, over that from which on they are of another part.
const USUAL: f32 = 0.02;

/// Samples per face of the result; more are thinned out.
const SAMPLES_PER_FACE: usize = 14;

/// Least cosine, squared, between the normals of a face before and after the fit: 45 degrees.
const LEAST_COSINE_SQUARED: f32 = 0.5;

/// Rounds in which vertices of turned faces go back, before all do.
const N_ROUNDS_BACK: usize = 4;

/// The input as the fit needs it.
#[derive(Clone, Copy)]
pub(crate) struct FitInput<'a> {
    pub faces: &'a [[u32; 3]],
    /// The vertex of the result that each input vertex became.
    pub numbers: &'a [u32],
    /// Squared distance from which on a sample is of another part of the surface.
    pub farthest: f32,
}

/// Moves the vertices inside the surface in `n_steps` steps; `position` gives the input's, in the mesh's units.
pub(crate) fn fit(rings: &mut Rings, input: FitInput, position: impl Fn(u32) -> Point, n_steps: usize, team: Team) {
    let n = rings.vertices.len();
    let (starts, samples) = take_samples(n, rings.n_faces, input, position);
    let mut sums = vec![SampleMoments::default(); n];
    let old: Vec<Point> = rings.vertices.iter().map(|vertex| vertex.position).collect();
    let mut usual = USUAL * input.farthest;
    for _ in 0..n_steps {
        sums.fill(SampleMoments::default());
        let mut elsewhere = vec![Vec::new(); n.div_ceil(STRETCH)];
        team.run(sums.chunks_mut(STRETCH).zip(&mut elsewhere).enumerate().collect(), |(i, (out, elsewhere))| {
            let (rings, starts, samples) = (&*rings, &starts, &samples);
            let farthest = input.farthest;
            dispatch(SumSamples { rings, starts, samples, farthest, usual, first: i * STRETCH, out, elsewhere });
        });
        for (v, moments) in elsewhere.into_iter().flatten() {
            sums[v as usize].add(&moments);
        }
        let [squares, areas] = sums
            .iter()
            .fold([0.0; 2], |[squares, areas], sum| [squares + f64::from(sum.squares), areas + f64::from(sum.area)]);
        usual = (squares / areas.max(f64::MIN_POSITIVE)) as f32;
        for (v, vertex) in rings.vertices.iter_mut().enumerate() {
            if rings.states[v] & (state::BOUNDARY | state::LOCKED) == 0 {
                let step = bounded_step(&sums[v]);
                for (x, step) in vertex.position.iter_mut().zip(step) {
                    *x += step;
                }
            }
        }
        take_back_turns(rings, &old);
    }
}

// Samples by the vertex that their corner became, and where each vertex' samples start.
fn take_samples(n: usize, n_faces: usize, input: FitInput, position: impl Fn(u32) -> Point) -> (Vec<u32>, Vec<Sample>) {
    let thinning = (input.faces.len() / (n_faces.max(1) * SAMPLES_PER_FACE)).max(1);
    let chosen = || input.faces.iter().enumerate().step_by(thinning);
    // Corners take turns.
    let place = |i: usize, face: &[u32; 3]| input.numbers[face[i % 3] as usize] as usize;
    let mut starts = vec![0u32; n + 1];
    for (i, face) in chosen() {
        starts[place(i, face) + 1] += 1;
    }
    for v in 0..n {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut samples = vec![Sample::default(); starts[n] as usize];
    for (i, face) in chosen() {
        let [a, b, c] = [0, 1, 2].map(|k| position(face[(i + k) % 3]));
        let (x, y) = (subtract(b, a), subtract(c, a));
        let normal = cross(x, y);
        let sixth = 1.0 / 6.0;
        let point = [0, 1, 2].map(|k| a[k] + sixth * (x[k] + y[k]));
        let place = &mut next[place(i, face)];
        // Samples that were left out count with the next, so that sums of areas are those of the surface.
        samples[*place as usize] = Sample { point, weight: thinning as f32 * dot(normal, normal).sqrt() };
        *place += 1;
    }
    (starts, samples)
}

// The relaxed step, no longer than samples are far.
fn bounded_step(moments: &SampleMoments) -> Point {
    let step = moments.solve(PULL);
    let squared = dot(step, step);
    let longest = LONGEST_STEP * moments.area;
    let scale = if squared > longest { (longest / squared).sqrt() } else { 1.0 };
    step.map(|x| RELAXATION * scale * x)
}

// Vertices of faces that turned go back.
fn take_back_turns(rings: &mut Rings, old: &[Point]) {
    for round in 1..=N_ROUNDS_BACK {
        let turned = find_turned(rings, old);
        if turned.is_empty() {
            return;
        }
        if round == N_ROUNDS_BACK {
            for (vertex, &position) in rings.vertices.iter_mut().zip(old) {
                vertex.position = position;
            }
        }
        for v in turned {
            rings.vertices[v as usize].position = old[v as usize];
        }
    }
}

// The vertices of faces that are not within the angle of what they were.
fn find_turned(rings: &Rings, old: &[Point]) -> Vec<u32> {
    let mut turned = Vec::new();
    for u in 0..rings.vertices.len() {
        let ring = rings.ring(u);
        let Some(&last) = ring.last() else { continue };
        let mut a = if rings.is_boundary(u) { 0 } else { last };
        for &b in ring {
            if (u as u32) < a && (u as u32) < b {
                let now = |v: u32| rings.vertices[v as usize].position;
                let x = face_normal(old[u], old[a as usize], old[b as usize]);
                let y = face_normal(now(u as u32), now(a), now(b));
                let along = dot(x, y);
                if !(along > 0.0 && along * along > LEAST_COSINE_SQUARED * dot(x, x) * dot(y, y)) {
                    turned.extend([u as u32, a, b]);
                }
            }
            a = b;
        }
    }
    turned
}

fn face_normal(a: Point, b: Point, c: Point) -> Point {
    cross(subtract(b, a), subtract(c, a))
}
