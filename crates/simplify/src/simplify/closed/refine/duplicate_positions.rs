//! Separation of vertices whose rounded positions coincide, so that welding does not change the mesh.

use std::hash::BuildHasher;

use glam::Vec3;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

use crate::mesh::Frame;
use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::parallel;
use crate::simplify::closed::pins::Pins;
use crate::spatial::Bounds;

// Bits per vertex in the table of possible duplicates: at most one vertex in 16 collides by chance.
const BITS: usize = 16;
// Vertices hashed together: their bit numbers fill 128 KiB.
const BATCH: usize = 16_384;
/// Length of a visible step, in roundings at half the longest side; also the largest ratio of steps.
const SMALL: f32 = 64.0;

/// Separates vertices whose positions are equal in the file, by the smallest steps that change them; returns the number
/// moved.
pub fn separate(pulse: Pulse, positions: &mut [[f32; 3]], pins: &Pins, frame: &Frame) -> usize {
    // A subset has fixed positions. Without duplicates, the common case, one pass over a table of bits suffices.
    if pins.is_subset() || are_apart(pulse, positions, frame) {
        return 0;
    }
    let mut taken: FxHashSet<[u64; 3]> = FxHashSet::default();
    taken.reserve(positions.len());
    // Locked vertices claim their positions first, since they cannot give way.
    taken.extend(pins.locked_vertices().map(|v| written_key(frame, positions[v as usize])));
    let mut n_tried: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    let (steps, mut n_moved) = (VisibleSteps::new(positions, frame), 0);
    for (_, position) in (0..).zip(positions).filter(|(v, _)| !pins.is_locked(*v)) {
        // The first vertex at a position keeps it.
        let written = written_key(frame, *position);
        if !taken.insert(written) {
            *position = take_free_position(
                *position,
                steps.steps_at(*position),
                frame,
                &mut taken,
                n_tried.entry(written).or_default(),
            );
            n_moved += 1;
        }
    }
    n_moved
}

pub fn are_apart(pulse: Pulse, positions: &[[f32; 3]], frame: &Frame) -> bool {
    // Bits seen once, and bits seen twice. Only vertices at the latter are compared exactly.
    let n_bits = (BITS * positions.len()).next_power_of_two().max(64);
    let bit_of = |key: [u64; 3]| (FxBuildHasher.hash_one(key) >> 8) as usize & (n_bits - 1);
    let (mut once, mut twice) = (vec![0u64; n_bits / 64], vec![0u64; n_bits / 64]);
    let mut any = 0;
    for positions in positions.chunks(BATCH) {
        pulse.beat(positions.len());
        for bit in parallel::map(positions.len(), PARALLEL, |i| bit_of(written_key(frame, positions[i]))) {
            let mask = 1 << (bit % 64);
            any |= once[bit / 64] & mask;
            twice[bit / 64] |= once[bit / 64] & mask;
            once[bit / 64] |= mask;
        }
    }
    let mut taken: FxHashSet<[u64; 3]> = FxHashSet::default();
    let is_doubtful = |key: [u64; 3]| {
        let bit = bit_of(key);
        twice[bit / 64] >> (bit % 64) & 1 == 1
    };
    let mut keys = positions.iter().map(|&position| written_key(frame, position));
    any == 0 || keys.all(|key| !is_doubtful(key) || taken.insert(key))
}

pub(super) fn written_key(frame: &Frame, local: [f32; 3]) -> [u64; 3] {
    frame.to_file(local).map(|x| (x + 0.0).to_bits())
}

/// Takes the first free position on a grid around `position`, skipping the first `n_tried`.
fn take_free_position(
    position: [f32; 3],
    steps: [f32; 3],
    frame: &Frame,
    taken: &mut FxHashSet<[u64; 3]>,
    n_tried: &mut u32,
) -> [f32; 3] {
    loop {
        *n_tried += 1;
        let offset = grid_offset(*n_tried, steps);
        let candidate = std::array::from_fn(|axis| position[axis] + offset[axis]);
        if candidate.iter().all(|x| x.is_finite()) && taken.insert(written_key(frame, candidate)) {
            return candidate;
        }
    }
}

pub(super) struct VisibleSteps<'a> {
    frame: &'a Frame,
    visible: f32,
}

impl<'a> VisibleSteps<'a> {
    pub(super) fn new(positions: &[[f32; 3]], frame: &'a Frame) -> Self {
        let Bounds { low, high } = Bounds::from_points(positions);
        let [low, high] = [low, high].map(Vec3::from);
        Self { frame, visible: SMALL * f32::EPSILON * (high / 2.0 - low / 2.0).max_element() }
    }

    /// Returns the least step per axis that changes the position in the file, raised to the largest or to `visible`.
    pub(super) fn steps_at(&self, position: [f32; 3]) -> [f32; 3] {
        let of_file = if self.frame.double { f64::EPSILON } else { f64::from(f32::EPSILON) };
        let written = self.frame.to_file(position);
        let own: [f32; 3] = std::array::from_fn(|axis| {
            // The coarser of the file's step and that of the local coordinate.
            let rounded_by = (written[axis].abs() * of_file) as f32;
            rounded_by.max(position[axis].abs() * f32::EPSILON).max(f32::from_bits(1))
        });
        let largest = Vec3::from(own).max_element().max(f32::MIN_POSITIVE);
        own.map(|step| step.max(largest.min(self.visible)))
    }
}

/// Returns the offset of a point of a grid, numbered from the centre outward in cubes (Morton order).
pub(super) fn grid_offset(number: u32, steps: [f32; 3]) -> [f32; 3] {
    let least = steps.into_iter().fold(f32::INFINITY, f32::min);
    let is_fine = steps.map(|step| step <= SMALL * least);
    let n_fine = is_fine.iter().filter(|fine| **fine).count() as u32;
    let mut first_bit = 0;
    std::array::from_fn(|axis| {
        if !is_fine[axis] {
            return 0.0;
        }
        let bits = (first_bit..u32::BITS).step_by(n_fine as usize).filter(|bit| number >> bit & 1 == 1);
        // Of n axes each takes every n-th bit; odd numbers go up, even ones down.
        let folded: u32 = bits.map(|bit| 1 << (bit / n_fine)).sum();
        first_bit += 1;
        let size = folded.div_ceil(2) as f32 * steps[axis];
        if folded % 2 == 1 { size } else { -size }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_come_apart_by_little() {
        let mut positions = [[1.0, 2.0, 3.0]; 20];
        assert_eq!(separate(Pulse::NONE, &mut positions, &Pins::default(), &Frame::default()), 19);
        let distinct: FxHashSet<[u32; 3]> = positions.iter().map(|p| p.map(f32::to_bits)).collect();
        assert_eq!(distinct.len(), 20);
        assert!(positions.iter().all(|p| Vec3::from(*p).distance(Vec3::new(1.0, 2.0, 3.0)) < 1e-5));
    }

    #[test]
    fn duplicates_are_judged_by_the_rounding_of_the_file() {
        let far = Frame { origin: [5e6, 0.0, 0.0], double: false };
        let mut positions = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]];
        assert_eq!(separate(Pulse::NONE, &mut positions, &Pins::default(), &far), 1);
        let mut positions = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]];
        assert_eq!(separate(Pulse::NONE, &mut positions, &Pins::default(), &Frame { double: true, ..far }), 0);
    }

    #[test]
    fn thousands_in_one_place_stay_close() {
        for point in [[1.0f32, -2.0, 3.0], [0.0; 3], [1e-3, 5e5, 0.0]] {
            let mut positions = vec![point; 5000];
            assert_eq!(separate(Pulse::NONE, &mut positions, &Pins::default(), &Frame::default()), 4999);
            let distinct: FxHashSet<[u32; 3]> = positions.iter().map(|p| p.map(f32::to_bits)).collect();
            assert_eq!(distinct.len(), 5000);
            let reach = Vec3::from(point).abs().max_element().max(1e-30);
            assert!(positions.iter().all(|p| Vec3::from(*p).distance(Vec3::from(point)) < 1e-5 * reach));
        }
    }

    #[test]
    fn the_largest_coordinates_stay_finite() {
        let mut positions = vec![[f32::MAX, 0.0, -f32::MAX]; 50];
        assert_eq!(separate(Pulse::NONE, &mut positions, &Pins::default(), &Frame::default()), 49);
        assert!(positions.as_flattened().iter().all(|x| x.is_finite()));
    }

    #[test]
    fn distant_and_tiny_meshes_stay_in_place() {
        for (offset, size) in [([-2e5, -8e8, 0.0], 0.5), ([0.0; 3], 1e-42), ([3e-39, 0.0, 1e-41], 1e-41)] {
            let corners = [[0.0, 0.0, 0.0], [size, 0.0, size], [0.0, 0.0, size], [size, 0.0, 0.0f32]];
            let placed = |p: [f32; 3]| std::array::from_fn(|axis| p[axis] + offset[axis]);
            let before: Vec<[f32; 3]> = corners.into_iter().cycle().take(40).map(placed).collect();
            let mut positions = before.clone();
            assert_eq!(separate(Pulse::NONE, &mut positions, &Pins::default(), &Frame::default()), 36);
            for (old, new) in before.iter().zip(&positions) {
                let most = 8.0 * f32::from_bits(1) + 1e-4 * size;
                assert!((0..3).all(|axis| (new[axis] - old[axis]).abs() <= most), "{old:?} {new:?}");
            }
        }
    }

    #[test]
    fn doubles_far_from_the_origin_come_apart_in_the_file() {
        let frame = Frame { origin: [5e9, -3.0, 0.0], double: true };
        let mut positions = [[1e-12, 0.0, 0.0]; 9];
        separate(Pulse::NONE, &mut positions, &Pins::default(), &frame);
        let distinct: FxHashSet<[u64; 3]> = positions.iter().map(|p| written_key(&frame, *p)).collect();
        assert_eq!(distinct.len(), 9);
    }
}
