//! Comparisons of the networks with NumPy (`bench/tests/golden/pointtrinet.py`).

use super::*;
use crate::learned_baselines::LearnedBaseline;
use crate::learned_baselines::tests::{assert_near, tensors_by_formula};
use crate::linalg::test_values::random;
use neural_mesh::autodiff::{Tape, Value};
use neural_mesh::loss::Term;

const SHARE: f64 = 1.0 / 16.0;

const CLASSIFIED: [f64; 3] = [0.7521177934470711, 0.8348495684092294, 0.8431997013347341];
const PROPOSED: [[f64; 2]; 3] = [
    [0.681239962326045, 0.6970480908924621],
    [0.6590966021848127, 0.6407986630273015],
    [0.4723488727782771, 0.7111817436917909],
];

pub(super) fn vertices() -> Vec<[f32; 3]> {
    let point = |i: f64| [(1.3 * i).sin(), (0.7 * i).cos(), (0.4 * i * i).sin()].map(|x| x as f32);
    (0..20).map(|i| point(f64::from(i))).collect()
}

pub(super) fn triangles() -> Vec<[u32; 3]> {
    (0..12).flat_map(|i| [[i, i + 1, i + 2], [i, i + 1, i + 3]]).collect()
}

pub(super) fn probabilities() -> Vec<f32> {
    (0..24).map(|t| (0.5 + 0.4 * (1.1 * f64::from(t) + 0.3).sin()) as f32).collect()
}

pub(super) fn samples() -> Vec<TriangleSample> {
    let vertices = vertices();
    let of = |(t, triangle): (u32, [u32; 3])| {
        let [a, b, c] = triangle.map(|v| vertices[v as usize]);
        TriangleSample { triangle: t, point: std::array::from_fn(|axis| 0.5 * a[axis] + 0.3 * b[axis] + 0.2 * c[axis]) }
    };
    (0..).zip(triangles()).map(of).collect()
}

pub(super) fn surface() -> Vec<SurfacePoint> {
    let of = |(i, point): (usize, &[f32; 3])| {
        let i = i as f64;
        let normal = glam::DVec3::new(i.sin(), (2.0 * i).cos(), (3.0 * i + 1.0).sin()).normalize();
        SurfacePoint { point: point.map(|x| 0.9 * x), normal: normal.as_vec3().to_array() }
    };
    vertices()[..10].iter().enumerate().map(of).collect()
}

pub(super) fn assert_gradient(p: &[f32], loss: impl Fn(&[f32]) -> Term) {
    for (i, &found) in loss(p).gradient.iter().enumerate() {
        let at = |step: f32| {
            let mut p = p.to_vec();
            p[i] += step;
            (loss(&p).value, f64::from(p[i]))
        };
        let [(low, before), (high, after)] = [at(-0.01), at(0.01)];
        let expected = (high - low) / (after - before);
        assert!((f64::from(found) - expected).abs() < 1e-3 * expected.abs().max(0.1), "{i}: {found} {expected}");
    }
}

fn candidates() -> Candidates {
    Candidates { triangles: triangles(), probabilities: probabilities() }
}

fn tensors() -> Tensors<Arc<Matrix>> {
    tensors_by_formula(&shapes(SHARE), |number, [i, j], n_rows| {
        2.0 * (1.0 + 1.7 * number + 0.9 * i + 2.3 * j + 0.37 * i * j).sin() / n_rows.sqrt()
    })
}

fn run_both(tape: &mut Tape, tensors: &Tensors<Value>) -> [Value; 2] {
    let (vertices, candidates) = (vertices(), candidates());
    let neighbourhoods = CandidateNeighbourhoods::new(&vertices, &candidates);
    let p = classifier(tape, tensors, &neighbourhoods, &[0, 7, 23]);
    let of_points = point_probabilities(tape, tensors, &neighbourhoods, &[5]);
    [p, of_points]
}

#[test]
fn both_networks_agree_with_numpy() {
    let tape = &mut Tape::default();
    let [p, of_points] = run_both(tape, &tensors().constants());
    let first_two = |edge: usize| [0, 1].map(|place| of_points.matrix().data()[20 * edge + place]);
    let found: Vec<f32> = p.matrix().data().iter().copied().chain((0..3).flat_map(first_two)).collect();
    assert_near(&found, CLASSIFIED.iter().chain(PROPOSED.as_flattened()));
    assert_eq!(of_points.matrix().shape(), [60, 1]);
    assert!(tape.is_empty());
}

fn weighted_sum(outputs: &[Value; 2]) -> (f64, [Matrix; 2]) {
    let weights = outputs.each_ref().map(|output| random(output.matrix().n_rows(), 1, 7));
    let products = |(output, weights): (&Value, &Matrix)| {
        let pairs = output.matrix().data().iter().zip(weights.data());
        pairs.map(|(x, w)| f64::from(*x) * f64::from(*w)).sum::<f64>()
    };
    (outputs.iter().zip(&weights).map(products).sum(), weights)
}

// Steps along each gradient are short enough to cross few kinks; zero biases would be kinks.
#[test]
fn gradients_of_both_networks() {
    let tensors = tensors();
    let loss = |tensors: &Tensors<Arc<Matrix>>| weighted_sum(&run_both(&mut Tape::default(), &tensors.constants())).0;
    let mut tape = Tape::default();
    let parameters = tensors.parameters(&mut tape);
    let outputs = run_both(&mut tape, &parameters);
    let [to_p, to_points] = weighted_sum(&outputs).1;
    let gradients = parameters.gradients(&tape.backward(&[(&outputs[0], to_p), (&outputs[1], to_points)]));
    for (name, gradient) in gradients.iter() {
        let length = gradient.data().iter().map(|&g| f64::from(g).powi(2)).sum::<f64>().sqrt();
        let moved = |step: f64| {
            let mut moved = tensors.clone();
            let entry = |i: usize, j: usize, w: &Matrix| w.row(i)[j] + (step / length) as f32 * gradient.row(i)[j];
            let tensor = moved.get_mut(name).expect("a name of theirs");
            *tensor = Arc::new(Matrix::from_fn(gradient.n_rows(), gradient.n_cols(), |i, j| entry(i, j, tensor)));
            loss(&moved)
        };
        let step = (2e-4 / length).min(1e-3);
        let slope = (moved(step) - moved(-step)) / (2.0 * step);
        assert!(length > 1e-3 && (slope - length).abs() < 0.02 * length, "{name}: {slope} {length}");
    }
}

#[test]
fn moving_turning_and_scaling_the_points_changes_no_probability() {
    let tensors = LearnedBaseline::PointTriNet.initial_tensors(SHARE, 2).constants();
    let candidates = candidates();
    let of = |vertices: &[[f32; 3]]| {
        let neighbourhoods = CandidateNeighbourhoods::new(vertices, &candidates);
        let queries: Vec<u32> = (0..24).collect();
        classifier(&mut Tape::default(), &tensors, &neighbourhoods, &queries)
    };
    let here = vertices();
    let there: Vec<[f32; 3]> = here.iter().map(|[x, y, z]| [5.0 - 2.0 * y, 2.0 * x + 1.0, 2.0 * z - 2.0]).collect();
    let [here, there] = [of(&here), of(&there)];
    let pairs = here.matrix().data().iter().zip(there.matrix().data());
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-3));
    assert!(
        here.matrix().data().iter().any(|p| (p - here.matrix().data()[0]).abs() > 1e-3),
        "they are not all the same"
    );
}
