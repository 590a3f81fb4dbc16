//! The network's stages forward and backward against golden values.
//!
//! `python/tests/test_torch_layer.py` tests the same values; `NEURAL_MESH_PASSES=write` writes new ones.

use neural_mesh::linalg::{Csr, Matrix};
use neural_mesh::mesh::{shapes, vertex_normals};
use neural_mesh::model::{
    Architecture, PredictedEdges, Weights, edge_predictor_backward, edge_predictor_forward, face_classifier_backward,
    face_classifier_forward, in_edge_lengths, point_sampler_backward, point_sampler_forward, predict_edges,
    predict_faces, triangle_graph,
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

// Returns input gradients that are easy to reproduce: whole numbers from -5 to 5.
fn input_gradients(n: usize) -> Vec<f32> {
    (0..n).map(|i| (5 * i % 11) as f32 - 5.0).collect()
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
    let pass = point_sampler_forward(weights, points, Some(normals), rings);
    let gradients = point_sampler_backward(&pass, &input_gradients(points.len()));
    found.numbers("scores", 1, &pass.scores);
    found.numbers("gradient.point_sampler.points", 3, gradients.points.as_flattened());
    found.numbers("gradient.point_sampler.normals", 3, gradients.normals.as_flattened());
    record_tensors(found, |f| gradients.tensors.try_map("gradient.point_sampler", f).map(drop));
}

fn record_edges_and_faces(found: &mut Tensors, weights: &Weights, points: &[[f32; 3]], original: &Arc<Csr>) {
    let edges = predict_edges(weights, points, original);
    let PredictedEdges { graph, attention, adjacency } = &edges;
    let pass = edge_predictor_forward(weights, points, graph, original);
    let both = input_gradients(2 * graph.n_entries());
    let gradients = edge_predictor_backward(&pass, &both[..graph.n_entries()], &both[graph.n_entries()..]);
    found.graph("graph", graph);
    found.numbers("attention", 1, attention);
    found.numbers("adjacency", 1, adjacency);
    found.numbers("gradient.edge_predictor.points", 3, gradients.points.as_flattened());
    record_tensors(found, |f| gradients.tensors.try_map("gradient.edge_predictor", f).map(drop));

    let faces = predict_faces(weights, points, &edges, &[]);
    let triangles = &faces.candidates.triangles;
    let graph = triangle_graph(points, triangles, SIZES.face_knn).into();
    let pass = face_classifier_forward(weights, points, triangles, &graph, &faces.prior);
    let gradients = face_classifier_backward(&pass, &input_gradients(triangles.len()));
    found.indices("faces", 3, triangles.as_flattened());
    found.indices("entries", 3, faces.candidates.entries.as_flattened());
    found.graph("triangle_graph", &graph);
    found.numbers("prior", 1, &faces.prior);
    found.numbers("probabilities", 1, &pass.probabilities);
    found.numbers("gradient.face_classifier.points", 3, gradients.points.as_flattened());
    found.numbers("gradient.face_classifier.prior", 1, &gradients.prior);
    record_tensors(found, |f| gradients.tensors.try_map("gradient.face_classifier", f).map(drop));
}

type Found<'a> = dyn FnMut(&str, &Matrix) -> Result<(), ()> + 'a;

fn record_tensors(found: &mut Tensors, walk: impl FnOnce(&mut &mut Found) -> Result<(), ()>) {
    let mut noted = |name: &str, matrix: &Matrix| {
        found.matrix(name, matrix);
        Ok(())
    };
    walk(&mut (&mut noted as &mut Found)).unwrap();
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
