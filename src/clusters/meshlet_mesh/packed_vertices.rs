//! Vertices as Bevy stores them: positions on a grid with as many bits as a cluster needs, octahedral normals.

use glam::Vec3;

use crate::clusters::Clusters;
use crate::geometry::triangle::area_normal;
use crate::mesh::value_bytes::Stored;
use crate::mesh::{Role, join_positions};

/// Steps of the grid per unit at factor 0: a hundredth of Bevy's unit.
const STEPS_PER_UNIT: f32 = 100.0;
/// Largest coordinate in steps: numbers of steps are stored in single precision.
const MOST_STEPS: f32 = (1 << 22) as f32;
const FINEST: u8 = 24;

/// Positions on a grid, bit after bit.
pub struct PackedPositions {
    factor: u8,
    words: Vec<u32>,
    n_bits: u64,
}

impl PackedPositions {
    /// Chooses the finest grid on which all positions have exact numbers; `None` if there is none.
    pub fn new(positions: &[[f32; 3]]) -> Option<Self> {
        let reach = positions.as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
        let factor = (0..=FINEST).rev().find(|&factor| reach * scale(factor) <= MOST_STEPS)?;
        Some(Self { factor, words: Vec::new(), n_bits: 0 })
    }

    /// Returns the binary logarithm of the grid's steps per hundredth of a unit.
    pub fn factor(&self) -> u8 {
        self.factor
    }

    pub fn n_bits(&self) -> u64 {
        self.n_bits
    }

    /// Adds the positions of a cluster; returns the bits of each channel and its least number of steps.
    pub fn push(&mut self, positions: impl Iterator<Item = [f32; 3]>) -> [(u8, i32); 3] {
        let scale = scale(self.factor);
        let steps: Vec<[i32; 3]> = positions.map(|p| p.map(|x| (x * scale + 0.5) as i32)).collect();
        let channel = |k: usize| {
            let least = steps.iter().map(|p| p[k]).min().unwrap_or(0);
            let most = steps.iter().map(|p| p[k]).max().unwrap_or(0);
            ((32 - ((most - least) as u32).leading_zeros()) as u8, least)
        };
        let channels = [channel(0), channel(1), channel(2)];
        for p in steps {
            for (x, (bits, least)) in p.into_iter().zip(channels) {
                self.push_bits((x - least) as u32, bits);
            }
        }
        channels
    }

    fn push_bits(&mut self, value: u32, n_bits: u8) {
        let (word, shift) = ((self.n_bits / 32) as usize, self.n_bits % 32);
        self.words.resize(word + 2, 0);
        let shifted = u64::from(value) << shift;
        self.words[word] |= shifted as u32;
        self.words[word + 1] |= (shifted >> 32) as u32;
        self.n_bits += u64::from(n_bits);
    }

    pub fn write(&self, content: &mut Vec<u8>) {
        let n_words = (self.n_bits.div_ceil(32) as usize).max(1);
        n_words.write(content);
        let words = self.words.iter().copied().chain([0]).take(n_words);
        words.for_each(|word| word.write(content));
    }
}

fn scale(factor: u8) -> f32 {
    (1u32 << factor) as f32 * STEPS_PER_UNIT
}

/// Returns the normals of the mesh, or the mean normals of all faces at a position.
pub fn vertex_normals(clusters: &Clusters) -> Vec<Vec3> {
    if let Some(normals) = clusters.channels.iter().find(|channel| channel.role == Role::Normal) {
        let n = clusters.positions.len() as u32;
        return (0..n).map(|v| Vec3::from_slice(normals.value(v)).normalize_or(Vec3::Z)).collect();
    }
    let positions = &clusters.positions;
    let (first, _) = join_positions(positions);
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for face in (0..clusters.clusters.len() as u32).flat_map(|cluster| clusters.faces_of(cluster)) {
        let normal = area_normal(face.map(|v| Vec3::from(positions[v as usize])));
        face.into_iter().for_each(|v| sums[first[v as usize] as usize] += normal);
    }
    first.iter().map(|&v| sums[v as usize].normalize_or(Vec3::Z)).collect()
}

/// Packs a unit normal into two signed 16-bit numbers (octahedral encoding, Meyer et al. 2010).
pub fn octahedral(normal: Vec3) -> u32 {
    let Vec3 { x, y, z } = normal / normal.abs().element_sum().max(f32::MIN_POSITIVE);
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let [u, v] = if z >= 0.0 { [x, y] } else { [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)] };
    let number = |c: f32| u32::from(((c.clamp(-1.0, 1.0) * 32767.0 + 0.5).floor() as i16) as u16);
    number(u) | number(v) << 16
}
