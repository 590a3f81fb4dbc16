//! Times of the network's kernels on one thread: 25 thousand vertices, 30 thousand triangles, 64 channels.
//!
//! Names that end in `_both` are forward and backward passes together.

use divan::{Bencher, black_box};
use neural_mesh::autodiff::{Tape, Value};
use neural_mesh::linalg::{
    Csr, Matrix, concat_product, neighbour_max, neighbour_max_backward, neighbour_max_product_relu, neighbour_softmax,
    pair_relu, pair_relu_backward, pair_relu_product, product, sparse_product, sparse_product_backward,
};
use neural_mesh::model::{Affine, DevConv, SparseAttention, TriConv, dev_conv, sparse_attention, tri_conv};
use neural_mesh::spatial::nearest_neighbours;

const WIDTH: usize = 64;

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    divan::main();
}

fn values(n_rows: usize, n_cols: usize) -> Matrix {
    Matrix::from_fn(n_rows, n_cols, |row, col| ((row * 7919 + col * 104_729) % 2003) as f32 / 1001.5 - 1.0)
}

// Builds a jittered sheet of side x side points and its triangles.
fn sheet(side: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let jitter = |i: u32| (i * 7919 % 101) as f32 / 250.0;
    let point = |i: u32| [(i % side) as f32 + jitter(i), (i / side) as f32 + jitter(i + 1), jitter(i + 2)];
    let corner = (0..(side - 1) * (side - 1)).map(|i| i / (side - 1) * side + i % (side - 1));
    let faces = corner.flat_map(|a| [[a, a + 1, a + side], [a + 1, a + side + 1, a + side]]);
    ((0..side * side).map(point).collect(), faces.collect())
}

fn rings(n: usize, faces: &[[u32; 3]]) -> Csr {
    Csr::from_edges(n, faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]))
}

fn knn(points: &[[f32; 3]], k: usize) -> Csr {
    let neighbours = nearest_neighbours(points, k);
    let entries = neighbours.iter().enumerate().map(|(at, &j)| [(at / k) as u32, j]);
    Csr::from_entries(points.len(), points.len(), entries)
}

#[divan::bench]
fn product_25k_64_64(bencher: Bencher) {
    let (x, w) = (values(25_000, WIDTH), values(WIDTH, WIDTH));
    bencher.bench_local(|| product(black_box(&x), &w, &[]));
}

#[divan::bench]
fn neighbour_max_25k(bencher: Bencher) {
    let (points, faces) = sheet(158);
    let (u, graph) = (values(points.len(), WIDTH), rings(points.len(), &faces));
    bencher.bench_local(|| neighbour_max(black_box(&u), &graph));
}

#[divan::bench]
fn dev_conv_25k(bencher: Bencher) {
    let (points, faces) = sheet(158);
    let (x, graph) = (values(points.len(), WIDTH), rings(points.len(), &faces));
    let [theta, phi] = [values(WIDTH, WIDTH), values(WIDTH, WIDTH)];
    bencher.bench_local(|| neighbour_max_product_relu(&product(black_box(&x), &theta, &[]), &graph, &phi));
}

// Runs `f` over parameters, and the backward pass to all of them.
fn both(inputs: &[Matrix], f: impl Fn(&mut Tape, &[Value]) -> Value) -> Matrix {
    let mut tape = Tape::default();
    let parameters: Vec<Value> = inputs.iter().map(|m| tape.parameter(m.clone())).collect();
    let result = f(&mut tape, &parameters);
    let gradients = tape.backward(&[(&result, result.matrix().clone())]);
    gradients.get(&parameters[0]).expect("an input that counts").clone()
}

#[divan::bench]
fn neighbour_max_backward_25k(bencher: Bencher) {
    let (points, faces) = sheet(158);
    let (u, graph) = (values(points.len(), WIDTH), rings(points.len(), &faces));
    bencher.bench_local(|| neighbour_max_backward(black_box(&u), &graph, &u));
}

#[divan::bench]
fn dev_conv_25k_both(bencher: Bencher) {
    let (points, faces) = sheet(158);
    let graph = rings(points.len(), &faces).into();
    let inputs = [values(points.len(), WIDTH), values(WIDTH, WIDTH), values(WIDTH, WIDTH)];
    bencher.bench_local(|| {
        both(black_box(&inputs), |tape, v| {
            dev_conv(tape, &DevConv { theta: v[1].clone(), phi: v[2].clone() }, &v[0], &graph)
        })
    });
}

#[divan::bench]
fn attention_25k_both(bencher: Bencher) {
    let (points, _) = sheet(158);
    let graph = knn(&points, 15).into();
    let inputs = [values(points.len(), WIDTH), values(WIDTH, WIDTH), values(WIDTH, WIDTH)];
    bencher.bench_local(|| {
        both(black_box(&inputs), |tape, v| {
            let layer = SparseAttention { query: v[1].clone(), key: v[2].clone() };
            sparse_attention(tape, &layer, &v[0], &graph)
        })
    });
}

fn triangle_graph() -> Csr {
    let (points, faces) = sheet(123);
    let barycenter = |face: &[u32; 3]| {
        let corners = face.map(|v| points[v as usize]);
        [0, 1, 2].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f32>() / 3.0)
    };
    let barycenters: Vec<[f32; 3]> = faces.iter().map(barycenter).collect();
    knn(&barycenters, 20)
}

#[divan::bench(args = [64, 128])]
fn tri_conv_30k(bencher: Bencher, width: usize) {
    let graph = triangle_graph();
    let [positions, x] = [9, width].map(|n_cols| values(graph.n_rows(), n_cols));
    let [hidden, output] = [values(9 + width, width), values(width, width)];
    let bias = vec![0.1; width];
    bencher.bench_local(|| {
        let mapped = concat_product(&positions, black_box(&x), &hidden);
        pair_relu_product(&mapped, &bias, &graph, &output, &bias)
    });
}

#[divan::bench(args = [64, 128])]
fn pair_relu_30k(bencher: Bencher, width: usize) {
    let (graph, bias) = (triangle_graph(), vec![0.1; width]);
    let u = values(graph.n_rows(), width);
    bencher.bench_local(|| pair_relu(black_box(&u), &bias, &graph));
}

#[divan::bench(args = [64, 128])]
fn pair_relu_backward_30k(bencher: Bencher, width: usize) {
    let (graph, bias) = (triangle_graph(), vec![0.1; width]);
    let u = values(graph.n_rows(), width);
    bencher.bench_local(|| pair_relu_backward(black_box(&u), &bias, &graph, &u));
}

#[divan::bench]
fn transposed_graph_30k(bencher: Bencher) {
    let graph = triangle_graph();
    bencher.bench_local(|| black_box(&graph).transpose());
}

#[divan::bench(args = [64, 128])]
fn tri_conv_30k_both(bencher: Bencher, width: usize) {
    let graph = std::sync::Arc::new(triangle_graph());
    let n = graph.n_rows();
    let (rows, square) = (values(n, width), values(width, width));
    let inputs = [rows, values(n, 9), values(9 + width, width), values(1, width), square, values(1, width)];
    bencher.bench_local(|| {
        both(black_box(&inputs), |tape, v| {
            let affine = |at: usize| Affine { weights: v[at].clone(), bias: v[at + 1].clone() };
            tri_conv(tape, &TriConv { hidden: affine(2), output: affine(4) }, &v[1], v[0].clone(), &graph)
        })
    });
}

#[divan::bench]
fn attention_softmax_25k(bencher: Bencher) {
    let (points, _) = sheet(158);
    let graph = knn(&points, 15);
    let logits = values(1, graph.n_entries());
    bencher.bench_local(|| neighbour_softmax(black_box(logits.data()), &graph));
}

#[divan::bench(args = [6, 15])]
fn sparse_product_25k(bencher: Bencher, k: usize) {
    let (points, faces) = sheet(158);
    let directed = knn(&points, k);
    let graph = Csr::from_edges(points.len(), directed.entries());
    let adjacency = rings(points.len(), &faces);
    let s = values(1, graph.n_entries());
    bencher.bench_local(|| sparse_product(black_box(s.data()), &graph, &adjacency));
}

#[divan::bench(args = [6, 15])]
fn sparse_product_25k_both(bencher: Bencher, k: usize) {
    let (points, faces) = sheet(158);
    let graph = Csr::from_edges(points.len(), knn(&points, k).entries());
    let adjacency = rings(points.len(), &faces);
    let s = values(1, graph.n_entries()).into_data();
    bencher.bench_local(|| {
        let result = sparse_product(black_box(&s), &graph, &adjacency);
        sparse_product_backward(&s, &graph, &adjacency, &result)
    });
}

#[divan::bench(args = [15, 20])]
fn nearest_neighbours_25k(bencher: Bencher, k: usize) {
    let (points, _) = sheet(158);
    bencher.bench_local(|| nearest_neighbours(black_box(&points), k));
}
