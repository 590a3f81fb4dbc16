//! Finite differences and random inputs for the tests of the losses.

use super::Term;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

pub fn assert_gradient(x: &[f32], tolerance: f64, f: impl Fn(&[f32]) -> Term) {
    let term = f(x);
    assert_eq!(term.gradient.len(), x.len());
    let scale = term.gradient.iter().fold(0.0f64, |most, &g| most.max(f64::from(g).abs()));
    for (i, &found) in term.gradient.iter().enumerate() {
        let step = 1.0 / 1024.0;
        let moved = |by: f32| {
            let mut x = x.to_vec();
            x[i] += by;
            (f(&x).value, f64::from(x[i]))
        };
        let ((high, right), (low, left)) = (moved(step), moved(-step));
        let expected = (high - low) / (right - left);
        let error = (expected - f64::from(found)).abs();
        assert!(error <= tolerance * scale.max(1e-9), "entry {i}: differences {expected}, gradient {found}");
    }
}

pub fn uniform(n: usize, seed: u64) -> Vec<f32> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..n).map(|_| (random.next_u64() >> 40) as f32 / (1u64 << 24) as f32).collect()
}

pub fn points(n: usize, seed: u64) -> Vec<[f32; 3]> {
    uniform(3 * n, seed).as_chunks().0.to_vec()
}

pub fn triangles(n_triangles: usize, n_points: u32, seed: u64) -> Vec<[u32; 3]> {
    let corner = |x: f32| ((x * n_points as f32) as u32).min(n_points - 1);
    let rows = uniform(9 * n_triangles, seed);
    let mut found: Vec<[u32; 3]> = rows.as_chunks::<3>().0.iter().map(|row| row.map(corner)).collect();
    found.iter_mut().for_each(|row| row.sort_unstable());
    found.retain(|[a, b, c]| a < b && b < c);
    found.truncate(n_triangles);
    found
}
