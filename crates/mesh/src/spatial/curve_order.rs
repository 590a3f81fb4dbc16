//! Sorts points and triangles along Morton's space-filling curve.

use super::Bounds;
use crate::parallel;

const BITS: u32 = 10;
const CROWD: usize = 256;
const CELLS: f32 = (1 << BITS) as f32;
const CHUNK: usize = 4096;
const BETWEEN_BEATS: usize = 1 << 18;
const DEPTH: usize = 12;

/// Sorts the indices `0..n` of finite points along the curve.
#[doc(hidden)]
pub fn curve_order(n: usize, point: impl Fn(u32) -> [f32; 3] + Sync, beat: impl Fn() + Sync) -> Vec<u32> {
    let mut order: Vec<u32> = (0..n as u32).collect();
    arrange(&mut order, &point, &beat, 0);
    order
}

/// Returns the indices of the triangles, sorted by centroid along the curve.
pub(super) fn curve_order_of_faces(positions: &[[f32; 3]], faces: &[[u32; 3]], bounds: &Bounds) -> Vec<u32> {
    let extent = extent(bounds);
    if extent.is_nan() || extent <= 0.0 {
        return (0..faces.len() as u32).collect();
    }
    // An overflow of this sum only spoils the order.
    let per_sum = CELLS / 3.0 / extent;
    let start = bounds.low.map(|low| low * (CELLS / extent));
    let mut keys = vec![0; faces.len()];
    parallel::fill(&mut keys, CHUNK, |i| {
        let [a, b, c] = faces[i].map(|v| positions[v as usize]);
        let cell = |k: usize| nearest_cell((a[k] + b[k] + c[k]) * per_sum - start[k]);
        cell_key([cell(0), cell(1), cell(2)], i as u32)
    });
    let middle = |face: u32| {
        let [a, b, c] = faces[face as usize].map(|v| positions[v as usize]);
        // Thirds first: the sum of large coordinates would overflow.
        std::array::from_fn(|k| a[k] / 3.0 + b[k] / 3.0 + c[k] / 3.0)
    };
    let mut order = vec![0; faces.len()];
    sort_by_keys(&mut order, keys, &middle, &|| (), 0);
    order
}

fn arrange(order: &mut [u32], middle: &(impl Fn(u32) -> [f32; 3] + Sync), beat: &(impl Fn() + Sync), depth: usize) {
    let bounds = bounds(order, middle);
    let extent = extent(&bounds);
    if extent.is_nan() || extent <= 0.0 || depth > DEPTH {
        return;
    }
    let key = |&face: &u32| {
        let cell = |(x, low): (f32, f32)| (((x - low) / extent * CELLS) as u32).min((1 << BITS) - 1);
        let [x, y, z] = middle(face);
        cell_key([(x, bounds.low[0]), (y, bounds.low[1]), (z, bounds.low[2])].map(cell), face)
    };
    let mut keys = Vec::with_capacity(order.len());
    for order in order.chunks(BETWEEN_BEATS) {
        beat_if(order.len() == BETWEEN_BEATS, beat);
        keys.extend(parallel::map(order.len(), CHUNK, |i| key(&order[i])));
    }
    sort_by_keys(order, keys, middle, beat, depth);
}

fn sort_by_keys(
    order: &mut [u32],
    keys: Vec<u64>,
    middle: &(impl Fn(u32) -> [f32; 3] + Sync),
    beat: &(impl Fn() + Sync),
    depth: usize,
) {
    let keys = sort_by_cell(keys, beat);
    order.iter_mut().zip(&keys).for_each(|(item, &key)| *item = key as u32);
    let mut start = 0;
    for run in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
        if run.len() > CROWD && run.len() < keys.len() {
            arrange(&mut order[start..start + run.len()], middle, beat, depth + 1);
        }
        beat_if(start / BETWEEN_BEATS < (start + run.len()) / BETWEEN_BEATS, beat);
        start += run.len();
    }
}

fn beat_if(is_due: bool, beat: &impl Fn()) {
    if is_due {
        beat();
    }
}

#[inline(always)]
fn cell_key([x, y, z]: [u32; 3], item: u32) -> u64 {
    u64::from(spread(x) | spread(y) << 1 | spread(z) << 2) << 32 | u64::from(item)
}

/// Rounds to a cell by adding 2^23, after which the float's lowest bits are the whole number.
#[inline(always)]
fn nearest_cell(x: f32) -> u32 {
    const LAST: f32 = CELLS - 1.0;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < LAST { x } else { LAST };
    (x + 8_388_608.0).to_bits() & ((1 << BITS) - 1)
}

fn extent(Bounds { low, high }: &Bounds) -> f32 {
    (0..3).map(|k| high[k] / 2.0 - low[k] / 2.0).fold(0.0, f32::max) * 2.0
}

fn bounds(order: &[u32], middle: &(impl Fn(u32) -> [f32; 3] + Sync)) -> Bounds {
    let point = |all: Bounds, &face: &u32| all.union(&Bounds::from_points(&[middle(face)]));
    let of_chunk = |_, order: &[u32]| order.iter().fold(Bounds::EMPTY, point);
    parallel::chunks(order, CHUNK, of_chunk).into_iter().fold(Bounds::EMPTY, |a, b| a.union(&b))
}

fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

fn sort_by_cell(mut keys: Vec<u64>, beat: &impl Fn()) -> Vec<u64> {
    let mut sorted = vec![0; keys.len()];
    for shift in [32, 32 + BITS, 32 + 2 * BITS] {
        let digit = |key: u64| (key >> shift) as usize & ((1 << BITS) - 1);
        let mut starts = [0u32; 1 << BITS];
        keys.iter().for_each(|&key| starts[digit(key)] += 1);
        let mut sum = 0;
        for start in &mut starts {
            sum += std::mem::replace(start, sum);
        }
        for keys in keys.chunks(BETWEEN_BEATS) {
            beat_if(keys.len() == BETWEEN_BEATS, beat);
            for &key in keys {
                let start = &mut starts[digit(key)];
                sorted[*start as usize] = key;
                *start += 1;
            }
        }
        std::mem::swap(&mut keys, &mut sorted);
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreading_leaves_room_for_two() {
        for x in 0..1u32 << BITS {
            let naive = (0..BITS).map(|bit| (x >> bit & 1) << (3 * bit)).sum::<u32>();
            assert_eq!(spread(x), naive);
        }
    }

    #[test]
    fn keys_are_sorted_by_their_place() {
        let keys: Vec<u64> = (0..5000u64).map(|i| (i * i * 2_654_435_761 % (1 << 30)) << 32 | i).collect();
        let mut expected = keys.clone();
        expected.sort_unstable();
        assert_eq!(sort_by_cell(keys, &|| ()), expected);
    }

    #[test]
    fn every_triangle_is_there_once_and_neighbours_are_near() {
        let n = 64u32;
        let positions: Vec<[f32; 3]> = (0..n * n).map(|i| [(i * 37 % n) as f32, (i / n) as f32, 0.0]).collect();
        let faces: Vec<[u32; 3]> = (0..n * n).map(|i| [i, i, i]).collect();
        let order = curve_order_of_faces(&positions, &faces, &Bounds::from_points(&positions));
        let mut once = order.clone();
        once.sort_unstable();
        assert!(once.iter().copied().eq(0..n * n));
        let point = |i: u32| glam::Vec3::from(positions[i as usize]);
        let steps: f32 = order.windows(2).map(|pair| point(pair[0]).distance(point(pair[1]))).sum();
        assert!(steps / ((n * n) as f32) < 2.0, "{steps}");
    }
}
