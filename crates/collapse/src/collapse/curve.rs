//! The order of vertices along a space-filling curve (Morton's), so that neighbours are near in memory.

use crate::collapse::frame::UnitFrame;

/// Bits per axis of a place on the curve.
const BITS: u32 = 10;

// Puts two zeros behind each of ten bits.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Returns the vertices along the curve through the unit frame; equal places by index.
pub(crate) fn order_along_curve(positions: &[[f32; 3]], frame: UnitFrame) -> Vec<u32> {
    let n_cells = (1 << BITS) as f32;
    let cell = |x: f32| spread((((x + 0.5) * n_cells) as u32).min((1 << BITS) - 1));
    let mut keys = Vec::with_capacity(positions.len());
    for (i, &p) in positions.iter().enumerate() {
        let [x, y, z] = frame.to_unit(p);
        keys.push(u64::from(cell(x) | cell(y) << 1 | cell(z) << 2) << 32 | i as u64);
    }
    sort_by_place(&mut keys);
    keys.into_iter().map(|key| key as u32).collect()
}

// Sorts by the upper half: a radix sort, which keeps the order of indices; three rounds of ten bits.
fn sort_by_place(keys: &mut Vec<u64>) {
    if keys.len() < 2048 {
        return keys.sort_unstable();
    }
    let digit = |key: u64, round: u32| (key >> (32 + BITS * round)) as usize & ((1 << BITS) - 1);
    let mut counts = [[0u32; 1 << BITS]; 3];
    for &key in keys.iter() {
        for round in 0..3 {
            counts[round as usize][digit(key, round)] += 1;
        }
    }
    let mut sorted = vec![0; keys.len()];
    for round in 0..3 {
        let ends = &mut counts[round as usize];
        let mut sum = 0;
        for end in ends.iter_mut() {
            sum += std::mem::replace(end, sum);
        }
        for &key in keys.iter() {
            let place = &mut ends[digit(key, round)];
            sorted[*place as usize] = key;
            *place += 1;
        }
        std::mem::swap(keys, &mut sorted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_radix_sort_is_a_sort() {
        let place = |i: u64| i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 34;
        let mut keys: Vec<u64> = (0..5000).map(|i| place(i % 4000) << 32 | i).collect();
        let mut expected = keys.clone();
        expected.sort_unstable();
        sort_by_place(&mut keys);
        assert_eq!(keys, expected);
    }

    #[test]
    fn eight_corners_come_as_the_curve_visits_them() {
        let corners: Vec<[f32; 3]> = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect();
        assert_eq!(order_along_curve(&corners, UnitFrame::new(&corners).unwrap()), [0, 1, 2, 3, 4, 5, 6, 7]);
    }
}
