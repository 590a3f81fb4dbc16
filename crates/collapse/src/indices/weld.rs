//! Vertices at one position, and vertices in use.

use super::buffers::{IndexBuffers, IndexResult};

/// Returns for each point the first at the same position; zeros of both signs are equal.
pub fn weld(positions: &[[f32; 3]]) -> Vec<u32> {
    const EMPTY: u32 = u32::MAX;
    let n_slots = (positions.len() + positions.len() / 4 + 1).next_power_of_two();
    let mut slots = vec![EMPTY; n_slots];
    let bits = |v: usize| positions[v].map(|x| if x == 0.0 { 0 } else { x.to_bits() });
    let find = |v: usize| {
        let own = bits(v);
        let mut slot = hash(own) & (n_slots - 1);
        loop {
            let first = slots[slot];
            if first == EMPTY {
                slots[slot] = v as u32;
                return v as u32;
            }
            if bits(first as usize) == own {
                return first;
            }
            slot = (slot + 1) & (n_slots - 1);
        }
    };
    (0..positions.len()).map(find).collect()
}

fn hash(bits: [u32; 3]) -> usize {
    let mut h = 0u64;
    for x in bits {
        h = (h ^ u64::from(x)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        h ^= h >> 32;
    }
    h as usize
}

/// Buffers of the vertices in use, and what the caller calls them.
pub(super) struct Compact {
    used: Vec<u32>,
    indices: Vec<[u32; 3]>,
    positions: Vec<[f32; 3]>,
    attributes: Vec<f32>,
    locks: Vec<bool>,
}

impl Compact {
    /// Costs time by the number of triangles, not by that of vertices.
    pub(super) fn new(buffers: &IndexBuffers) -> Compact {
        let mut used = buffers.indices.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap_or(0) as u32;
        let width = buffers.weights.len();
        let row = |&v: &u32| &buffers.attributes[v as usize * width..][..width];
        Compact {
            indices: buffers.indices.iter().map(|face| face.map(number)).collect(),
            positions: used.iter().map(|&v| buffers.positions[v as usize]).collect(),
            attributes: used.iter().flat_map(row).copied().collect(),
            locks: used.iter().filter_map(|&v| buffers.locks.get(v as usize).copied()).collect(),
            used,
        }
    }

    pub(super) fn buffers<'a>(&'a self, of: &IndexBuffers<'a>) -> IndexBuffers<'a> {
        let Compact { indices, positions, attributes, locks, .. } = self;
        IndexBuffers { indices, positions, attributes, weights: of.weights, groups: of.groups, locks }
    }

    pub(super) fn name_caller(&self, result: &mut IndexResult) {
        for v in result.indices.as_flattened_mut().iter_mut().chain(result.moved.iter_mut().map(|(v, _)| v)) {
            *v = self.used[*v as usize];
        }
    }
}
