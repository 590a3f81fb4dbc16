//! Farthest points (Gonzalez 1985; Moenning and Dodgson 2003): each sample is the vertex farthest from those before.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Picks `n` vertices, `first` first, by distances along the edges (for each vertex: neighbour, length).
pub fn farthest_points(edges: &[Vec<(u32, f64)>], n: usize, first: u32) -> Vec<u32> {
    let mut distance = vec![f64::INFINITY; edges.len()];
    let mut samples = Vec::with_capacity(n);
    // Distances only fall, so an entry that is out of date stands too high and goes back to its place when met.
    let mut far: BinaryHeap<(u64, Reverse<u32>)> =
        (0..edges.len() as u32).map(|v| (f64::INFINITY.to_bits(), Reverse(v))).collect();
    let mut next = Some(first);
    while let Some(sample) = next.filter(|_| samples.len() < n) {
        samples.push(sample);
        grow(edges, &mut distance, sample);
        next = farthest(&mut far, &distance);
    }
    samples
}

/// Takes the farthest vertex out of the heap; none when all of them are samples.
fn farthest(far: &mut BinaryHeap<(u64, Reverse<u32>)>, distance: &[f64]) -> Option<u32> {
    while let Some((bits, Reverse(v))) = far.pop() {
        let now = distance[v as usize];
        if now.to_bits() == bits {
            return Some(v);
        }
        if now > 0.0 {
            far.push((now.to_bits(), Reverse(v)));
        }
    }
    None
}

/// Lets a new sample claim every vertex to which it is nearer than the samples before.
fn grow(edges: &[Vec<(u32, f64)>], distance: &mut [f64], sample: u32) {
    distance[sample as usize] = 0.0;
    let mut front = BinaryHeap::from([Reverse((0u64, sample))]);
    while let Some(Reverse((bits, v))) = front.pop() {
        if f64::from_bits(bits) > distance[v as usize] {
            continue;
        }
        for &(w, length) in &edges[v as usize] {
            let there = f64::from_bits(bits) + length;
            if there < distance[w as usize] {
                distance[w as usize] = there;
                front.push(Reverse((there.to_bits(), w)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_halved_again_and_again() {
        let step = |v: i64| (0..9).contains(&v).then_some((v as u32, 1.0));
        let path: Vec<Vec<(u32, f64)>> =
            (0..9).map(|v| [v - 1, v + 1].into_iter().filter_map(step).collect()).collect();
        assert_eq!(farthest_points(&path, 5, 0), [0, 8, 4, 2, 6]);
        let mut all = farthest_points(&path, 20, 3);
        all.sort_unstable();
        assert_eq!(all, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    }
}
