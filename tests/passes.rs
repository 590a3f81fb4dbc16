//! The network's stages forward and backward against golden values.
//!
//! `python/tests/test_torch_layer.py` tests the same values; `NEURAL_MESH_PASSES=write` writes new ones.

use neural_mesh::autodiff::{Gradients, Tape, Value};
use neural_mesh::linalg::{Csr, Matrix};
use neural_mesh::mesh::{shapes, vertex_normals};
use neural_mesh::model::{
    Architecture, PredictedEdges, Vertices, Weights, edge_predictor, face_classifier, in_edge_lengths, point_sampler,
    predict_edges, predict_faces, triangle_graph, vertex_scores,
};
use neural_mesh::simplify::edge_graph;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

const SIZES: Architecture = Architecture {
    point_sampler_inputs: 6,
    point_sampler_layers: 2,
    point_sampler_width: 8,
    point_sampler_hidden: 4,
    edge_predictor_width: 8,
    attention_width: 6,
    edge_knn: 6,
    face_classifier_layers: 2,
    face_classifier_width: 8,
    face_candidates: 0,
    face_knn: 5,
};

// Tensors by name: type, columns, and words of four bytes.
#[derive(Default)]
struct Tensors(BTreeMap<String, (Dtype, usize, Vec<u8>)>);

impl Tensors {
    fn numbers(&mut self, name: &str, n_columns: usize, numbers: &[f32]) {
        let bytes = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.0.insert(name.into(), (Dtype::F32, n_columns, bytes));
    }

    fn indices(&mut self, name: &str, n_columns: usize, indices: &[u32]) {
        let bytes = indices.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.0.insert(name.into(), (Dtype::I32, n_columns, bytes));
    }

    fn matrix(&mut self, name: &str, matrix: &Matrix) {
        self.numbers(name, matrix.n_cols(), matrix.data());
    }

    fn graph(&mut self, name: &str, graph: &Csr) {
        self.indices(name, 2, graph.entries().collect::<Vec<_>>().as_flattened());
    }

    fn bytes(&self) -> Vec<u8> {
        let view = |(dtype, n_columns, bytes): &(Dtype, usize, Vec<u8>)| {
            let shape = vec![bytes.len() / 4 / n_columns, *n_columns];
            (*dtype, shape, bytes.clone())
        };
        let parts: Vec<_> = self.0.iter().map(|(name, part)| (name, view(part))).collect();
        let views = parts
            .iter()
            .map(|(name, (dtype, shape, bytes))| (name, TensorView::new(*dtype, shape.clone(), bytes).unwrap()));
        safetensors::serialize(views, None).unwrap()
    }
}

// Returns gradients that are easy to reproduce, whole numbers from -5 to 5, from a number on.
fn input_gradient(value: &Value, first: usize) -> Matrix {
    let [n, n_columns] = value.matrix().shape();
    Matrix::new(n, n_columns, (first..first + n * n_columns).map(|i| (5 * i % 11) as f32 - 5.0).collect())
}

fn compute_tensors() -> Tensors {
    let mesh = shapes::wavy_sphere(1, 5.0);
    let rings = Arc::new(edge_graph(&mesh));
    let (points, normals) = (in_edge_lengths(mesh.positions(), &rings), vertex_normals(&mesh));
    let weights = Weights::random_of(SIZES, 7);
    let mut found = Tensors::default();
    weights.tensors().map(|name, matrix| found.matrix(&format!("weights.{name}"), matrix));
    found.numbers("vertices", 3, mesh.positions().as_flattened());
    found.indices("mesh", 3, mesh.faces().as_flattened());
    found.numbers("points", 3, points.as_flattened());
    found.numbers("normals", 3, normals.as_flattened());
    found.graph("edges", &rings);
    record_point_sampler(&mut found, &weights, &points, &normals, &rings);
    record_edges_and_faces(&mut found, &weights, &points, &rings);
    found
}

fn record_point_sampler(
    found: &mut Tensors,
    weights: &Weights,
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
    rings: &Arc<Csr>,
) {
    let mut tape = Tape::default();
    let net = weights.parameters(&mut tape).point_sampler;
    let [x, n] = [points, normals].map(|rows| tape.parameter(Matrix::from_points(rows)));
    let scores = point_sampler(&mut tape, &net, Vertices { points: &x, normals: Some(&n) }, rings);
    assert_eq!(scores.matrix().data(), vertex_scores(weights, points, Some(normals), rings));
    let gradients = tape.backward(&[(&scores, input_gradient(&scores, 0))]);
    found.matrix("scores", scores.matrix());
    found.matrix("gradient.point_sampler.points", &gradients.or_zero(&x));
    found.matrix("gradient.point_sampler.normals", &gradients.or_zero(&n));
    record_tensors(found, &gradients, |f| net.try_map("gradient.point_sampler", f).map(drop));
}

fn record_edges_and_faces(found: &mut Tensors, weights: &Weights, points: &[[f32; 3]], original: &Arc<Csr>) {
    let predicted = predict_edges(weights, points, original);
    let PredictedEdges { graph, attention, adjacency } = &predicted;
    let mut tape = Tape::default();
    let net = weights.parameters(&mut tape).edge_predictor;
    let x = tape.parameter(Matrix::from_points(points));
    let edges = edge_predictor(&mut tape, &net, &x, graph, original);
    assert_eq!([edges.attention.matrix().data(), edges.adjacency.matrix().data()], [&attention[..], adjacency]);
    let given = [(&edges.attention, 0), (&edges.adjacency, graph.n_entries())];
    let gradients = tape.backward(&given.map(|(value, first)| (value, input_gradient(value, first))));
    found.graph("graph", graph);
    found.numbers("attention", 1, attention);
    found.numbers("adjacency", 1, adjacency);
    found.matrix("gradient.edge_predictor.points", &gradients.or_zero(&x));
    record_tensors(found, &gradients, |f| net.try_map("gradient.edge_predictor", f).map(drop));

    let faces = predict_faces(weights, points, &predicted, &[]);
    let triangles = &faces.candidates.triangles;
    let graph = triangle_graph(points, triangles, SIZES.face_knn).into();
    let mut tape = Tape::default();
    let net = weights.parameters(&mut tape).face_classifier;
    let x = tape.parameter(Matrix::from_points(points));
    let prior = tape.parameter(Matrix::new(triangles.len(), 1, faces.prior.clone()));
    let probabilities = face_classifier(&mut tape, &net, &x, triangles, &graph, &prior);
    assert_eq!(probabilities.matrix().data(), faces.probabilities);
    let gradients = tape.backward(&[(&probabilities, input_gradient(&probabilities, 0))]);
    found.indices("faces", 3, triangles.as_flattened());
    found.indices("entries", 3, faces.candidates.entries.as_flattened());
    found.graph("triangle_graph", &graph);
    found.numbers("prior", 1, &faces.prior);
    found.matrix("probabilities", probabilities.matrix());
    found.matrix("gradient.face_classifier.points", &gradients.or_zero(&x));
    found.matrix("gradient.face_classifier.prior", &gradients.or_zero(&prior));
    record_tensors(found, &gradients, |f| net.try_map("gradient.face_classifier", f).map(drop));
}

type Recorder<'a> = dyn FnMut(&str, &Value) -> Result<(), ()> + 'a;

fn record_tensors(found: &mut Tensors, gradients: &Gradients, walk: impl FnOnce(&mut &mut Recorder) -> Result<(), ()>) {
    let mut record = |name: &str, value: &Value| {
        found.matrix(name, &gradients.or_zero(value));
        Ok(())
    };
    walk(&mut (&mut record as &mut Recorder)).unwrap();
}

#[test]
fn passes_have_their_golden_values() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/passes.safetensors");
    let found = compute_tensors();
    if std::env::var("NEURAL_MESH_PASSES").is_ok_and(|wish| wish == "write") {
        std::fs::write(&path, found.bytes()).unwrap();
    }
    let bytes = std::fs::read(&path).unwrap();
    let golden = SafeTensors::deserialize(&bytes).unwrap();
    assert_eq!(golden.len(), found.0.len());
    for (name, (dtype, _, bytes)) in &found.0 {
        let known = golden.tensor(name).unwrap();
        assert_eq!((known.dtype(), known.data().len()), (*dtype, bytes.len()), "{name}");
        if *dtype == Dtype::I32 {
            assert_eq!(known.data(), bytes, "{name}");
            continue;
        }
        let numbers = |bytes: &[u8]| bytes.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)).collect();
        let (known, found): (Vec<f32>, Vec<f32>) = (numbers(known.data()), numbers(bytes));
        let scale = known.iter().fold(1.0f32, |most, x| most.max(x.abs()));
        assert!(known.iter().zip(&found).all(|(a, b)| (a - b).abs() <= 1e-5 * scale), "{name}");
    }
}
