//! Keeps the output's vertices apart after rounding: a file that is welded again must stay the same mesh.

use glam::Vec3;
use rustc_hash::FxHashSet;

use crate::mesh::Frame;

/// Moves vertices whose written positions coincide apart by the smallest steps that do; returns how many moved.
///
/// `positions` are local, n_vertices x 3; `frame` says how they will be written.
pub(super) fn separate(positions: &mut [[f32; 3]], frame: &Frame) -> usize {
    let mut taken: FxHashSet<[u64; 3]> = FxHashSet::default();
    taken.reserve(positions.len());
    let mut n_moved = 0;
    for position in positions {
        if !taken.insert(key(frame, *position)) {
            *position = free_place(*position, frame, &taken);
            taken.insert(key(frame, *position));
            n_moved += 1;
        }
    }
    n_moved
}

/// Whether no two vertices would be written at the same position.
pub(super) fn are_apart(positions: &[[f32; 3]], frame: &Frame) -> bool {
    let mut taken: FxHashSet<[u64; 3]> = FxHashSet::default();
    taken.reserve(positions.len());
    positions.iter().all(|&position| taken.insert(key(frame, position)))
}

fn key(frame: &Frame, local: [f32; 3]) -> [u64; 3] {
    frame.to_file(local).map(|x| (x + 0.0).to_bits())
}

/// The first free position on growing steps along the axes.
fn free_place(position: [f32; 3], frame: &Frame, taken: &FxHashSet<[u64; 3]>) -> [f32; 3] {
    let reach = frame.to_file(position).into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let unit = if frame.double { Vec3::from(position).abs().max_element() } else { reach as f32 };
    let mut step = (unit * f32::EPSILON).max(f32::MIN_POSITIVE);
    loop {
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let mut candidate = position;
            candidate[axis] += sign * step;
            if candidate[axis].is_finite() && !taken.contains(&key(frame, candidate)) {
                return candidate;
            }
        }
        step *= 2.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_come_apart_by_little() {
        let mut positions = [[1.0, 2.0, 3.0]; 20];
        assert_eq!(separate(&mut positions, &Frame::default()), 19);
        let distinct: FxHashSet<[u32; 3]> = positions.iter().map(|p| p.map(f32::to_bits)).collect();
        assert_eq!(distinct.len(), 20);
        assert!(positions.iter().all(|p| Vec3::from(*p).distance(Vec3::new(1.0, 2.0, 3.0)) < 1e-5));
    }

    #[test]
    fn what_counts_is_the_rounding_of_the_file() {
        let far = Frame { origin: [5e6, 0.0, 0.0], double: false };
        let mut positions = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]];
        assert_eq!(separate(&mut positions, &far), 1);
        let mut positions = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]];
        assert_eq!(separate(&mut positions, &Frame { double: true, ..far }), 0);
    }
}
