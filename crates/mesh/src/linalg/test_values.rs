//! Random matrices, graphs, comparisons and pools of threads for tests.

use super::{Csr, Matrix};
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

#[doc(hidden)]
pub fn random(n_rows: usize, n_cols: usize, seed: u64) -> Matrix {
    let mut rng = SplitMix64::seed_from_u64(seed);
    Matrix::from_fn(n_rows, n_cols, |_, _| (rng.next_u64() >> 40) as f32 / (1u64 << 23) as f32 - 1.0)
}

#[doc(hidden)]
pub fn ragged_graph(n: usize) -> Csr {
    let entries = (0..n as u32).flat_map(|i| (0..i % 5).map(move |k| [i, (i * 7 + k * k * 3 + 1) % n as u32]));
    Csr::from_entries(n, n, entries.filter(|[i, j]| i != j))
}

/// Runs `work` on a pool of its own.
#[doc(hidden)]
pub fn run_on_threads<T: Send>(n: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads can be started").install(work)
}

pub fn naive_product(x: &Matrix, weights: &Matrix, bias: &[f32]) -> Matrix {
    Matrix::from_fn(x.n_rows(), weights.n_cols(), |i, c| {
        let dot: f32 = (0..x.n_cols()).map(|k| x.row(i)[k] * weights.row(k)[c]).sum();
        dot + bias.get(c).unwrap_or(&0.0)
    })
}

/// Panics unless entries agree to `tolerance`, relative to the larger of them and 1.
#[doc(hidden)]
pub fn assert_close(a: &[f32], b: &[f32], tolerance: f32) {
    assert_eq!(a.len(), b.len());
    for (i, (x, y)) in a.iter().zip(b).enumerate() {
        let scale = x.abs().max(y.abs()).max(1.0);
        assert!((x - y).abs() <= tolerance * scale, "entry {i}: {x} and {y}");
    }
}

/// Panics unless `gradient` holds the slopes of `loss` at `x`.
pub fn assert_slopes(gradient: &[f32], x: &[f32], loss: impl Fn(&[f64]) -> f64) {
    let x: Vec<f64> = x.iter().map(|&x| f64::from(x)).collect();
    let slope = |at: usize| {
        let moved = |step: f64| {
            let mut x = x.clone();
            x[at] += step;
            loss(&x)
        };
        ((moved(1e-6) - moved(-1e-6)) / 2e-6) as f32
    };
    assert_close(gradient, &(0..x.len()).map(slope).collect::<Vec<f32>>(), 1e-5);
}
