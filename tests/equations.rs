//! Each numbered equation against golden values of `tests/golden/equations.py`.

use neural_mesh::autodiff::{Tape, Value};
use neural_mesh::linalg::{Csr, Matrix};
use neural_mesh::model::{
    Affine, DevConv, SparseAttention, TriConv, candidate_faces, dev_conv, extended_graph, prior, sparse_attention,
    tri_conv, triangle_graph, triangle_positions,
};
use safetensors::{Dtype, SafeTensors};
use std::sync::Arc;

struct Golden(SafeTensors<'static>);

impl Golden {
    fn load() -> Self {
        Self(SafeTensors::deserialize(include_bytes!("golden/equations.safetensors")).unwrap())
    }

    fn words(&self, name: &str, dtype: Dtype) -> Vec<[u8; 4]> {
        let tensor = self.0.tensor(name).unwrap();
        assert_eq!(tensor.dtype(), dtype);
        tensor.data().as_chunks().0.to_vec()
    }

    fn numbers(&self, name: &str) -> Vec<f32> {
        self.words(name, Dtype::F32).into_iter().map(f32::from_le_bytes).collect()
    }

    fn indices<const N: usize>(&self, name: &str) -> Vec<[u32; N]> {
        let words: Vec<u32> = self.words(name, Dtype::I32).into_iter().map(u32::from_le_bytes).collect();
        words.as_chunks().0.to_vec()
    }

    fn matrix(&self, name: &str) -> Value {
        let shape = self.0.tensor(name).unwrap().shape().to_vec();
        Value::constant(Matrix::new(shape[0], shape[1], self.numbers(name)))
    }

    // Returns weights transposed: the paper prints a row per output, the program stores a row per input.
    fn weights(&self, name: &str) -> Value {
        Value::constant(self.matrix(name).matrix().transpose())
    }

    fn bias(&self, name: &str) -> Value {
        let numbers = self.numbers(name);
        Value::constant(Matrix::new(1, numbers.len(), numbers))
    }

    fn points(&self) -> Vec<[f32; 3]> {
        self.numbers("x").as_chunks().0.to_vec()
    }

    fn graph(&self, edges: &str) -> Arc<Csr> {
        Csr::from_edges(self.points().len(), self.indices::<2>(edges)).into()
    }

    fn tri_conv_layer(&self, [w1, b1, w2, b2]: [&str; 4]) -> TriConv<Value> {
        TriConv {
            hidden: Affine { weights: self.weights(w1), bias: self.bias(b1) },
            output: Affine { weights: self.weights(w2), bias: self.bias(b2) },
        }
    }

    // Expects the golden gradient, relative to its largest entry.
    fn assert_slope(&self, name: &str, found: &[f32]) {
        let expected = self.numbers(name);
        assert_eq!(expected.len(), found.len(), "{name}");
        let scale = expected.iter().fold(0.0f32, |most, x| most.max(x.abs()));
        for (at, (a, b)) in expected.iter().zip(found).enumerate() {
            assert!((a - b).abs() <= 1e-4 * scale, "{name}[{at}]: golden {a}, found {b}, largest {scale}");
        }
    }

    fn assert_equal(&self, name: &str, found: &[f32]) {
        let expected = self.numbers(name);
        assert_eq!(expected.len(), found.len(), "{name}");
        for (at, (a, b)) in expected.iter().zip(found).enumerate() {
            assert!((a - b).abs() <= 2e-5 * a.abs().max(1.0), "{name}[{at}]: golden {a}, found {b}");
        }
    }
}

#[test]
fn equation_1_dev_conv() {
    let golden = Golden::load();
    let rings = golden.graph("edges");
    let tape = &mut Tape::default();
    let layer = |theta, phi| DevConv { theta: golden.weights(theta), phi: golden.weights(phi) };
    let first = dev_conv(tape, &layer("theta_0", "phi_0"), &golden.matrix("x"), &rings);
    golden.assert_equal("f_0", first.matrix().data());
    let second = dev_conv(tape, &layer("theta_1", "phi_1"), &first, &rings);
    golden.assert_equal("f_1", second.matrix().data());
}

#[test]
fn the_extended_graph() {
    let golden = Golden::load();
    let graph = extended_graph(&golden.points(), &golden.graph("a_edges"), 4);
    assert_eq!(graph.entries().collect::<Vec<_>>(), golden.indices::<2>("extended"));
}

#[test]
fn equation_2_sparse_attention() {
    let golden = Golden::load();
    let layer = SparseAttention { query: golden.weights("query"), key: golden.weights("key") };
    let s = sparse_attention(&mut Tape::default(), &layer, &golden.matrix("f_1"), &golden.graph("extended"));
    golden.assert_equal("s", s.matrix().data());
}

#[test]
fn equation_3_predicted_adjacency_and_the_prior() {
    let golden = Golden::load();
    let (graph, original) = (golden.graph("extended"), golden.graph("a_edges"));
    let s = golden.numbers("s");
    let tape = &mut Tape::default();
    let adjacency = tape.sparse_product(&Value::constant(Matrix::new(s.len(), 1, s)), &graph, &original);
    golden.assert_equal("a_s", adjacency.matrix().data());
    let candidates = candidate_faces(&graph, adjacency.matrix().data(), &[]);
    assert_eq!(candidates.triangles, golden.indices::<3>("candidates"));
    golden.assert_equal("prior", prior(tape, &adjacency, &candidates).matrix().data());
}

#[test]
fn equation_4_relative_positions() {
    let golden = Golden::load();
    let rows = triangle_positions(&mut Tape::default(), &golden.matrix("x"), &golden.indices::<3>("candidates"));
    let pairs = golden.indices::<5>("around").into_iter().enumerate();
    let differences = pairs.flat_map(|(n, around)| {
        let rows = rows.matrix();
        around.into_iter().flat_map(move |k| rows.row(n).iter().zip(rows.row(k as usize)).map(|(n, k)| n - k))
    });
    golden.assert_equal("r", &differences.collect::<Vec<_>>());
}

#[test]
fn equation_5_tri_conv() {
    let golden = Golden::load();
    let (points, triangles) = (golden.points(), golden.indices::<3>("candidates"));
    let graph = Arc::new(triangle_graph(&points, &triangles, 5));
    let tape = &mut Tape::default();
    let positions = triangle_positions(tape, &golden.matrix("x"), &triangles);
    let first = golden.tri_conv_layer(["w1", "b1", "w2", "b2"]);
    let features = tri_conv(tape, &first, &positions, golden.matrix("prior"), &graph);
    golden.assert_equal("g_0", features.matrix().data());
    let second = golden.tri_conv_layer(["w3", "b3", "w4", "b4"]);
    let features = tri_conv(tape, &second, &positions, features, &graph);
    golden.assert_equal("g_1", features.matrix().data());
}

#[test]
fn gradients_through_all_equations() {
    let golden = Golden::load();
    let tape = &mut Tape::default();
    let [x, theta, w1] = [golden.matrix("x"), golden.weights("theta_0"), golden.weights("w1")]
        .map(|value| tape.parameter(value.matrix().clone()));
    let (rings, graph, original) = (golden.graph("edges"), golden.graph("extended"), golden.graph("a_edges"));
    let features = dev_conv(tape, &DevConv { theta: theta.clone(), phi: golden.weights("phi_0") }, &x, &rings);
    let second = DevConv { theta: golden.weights("theta_1"), phi: golden.weights("phi_1") };
    let features = dev_conv(tape, &second, &features, &rings);
    let layer = SparseAttention { query: golden.weights("query"), key: golden.weights("key") };
    let s = sparse_attention(tape, &layer, &features, &graph);
    let adjacency = tape.sparse_product(&s, &graph, &original);
    let candidates = candidate_faces(&graph, adjacency.matrix().data(), &[]);
    let triangle_graph = Arc::new(triangle_graph(&golden.points(), &candidates.triangles, 5));
    let positions = triangle_positions(tape, &x, &candidates.triangles);
    let prior = prior(tape, &adjacency, &candidates);
    let mut first = golden.tri_conv_layer(["w1", "b1", "w2", "b2"]);
    first.hidden.weights = w1.clone();
    let features = tri_conv(tape, &first, &positions, prior, &triangle_graph);
    let last = golden.tri_conv_layer(["w3", "b3", "w4", "b4"]);
    let result = tri_conv(tape, &last, &positions, features, &triangle_graph);
    let gradients = tape.backward(&[(&result, golden.matrix("loss_weights").matrix().clone())]);
    let gradient_by = |value: &Value| gradients.get(value).unwrap().clone();
    golden.assert_slope("slope_x", gradient_by(&x).data());
    golden.assert_slope("slope_theta_0", gradient_by(&theta).transpose().data());
    golden.assert_slope("slope_w1", gradient_by(&w1).transpose().data());
}
