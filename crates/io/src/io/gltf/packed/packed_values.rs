//! Vertex values in small integers.

use serde_json::{Value, json};

use super::compress::{self, encode_octahedral};
use super::compressed_views::{COMPRESSION, OCTAHEDRAL};
use super::uv_grids::UvGrids;
use crate::io::gltf::accessor::{BYTE, SHORT, UNSIGNED_BYTE, UNSIGNED_SHORT};
use crate::io::gltf::draft::{Draft, NumberStorage, VERTICES, vector_shape};
use crate::mesh::{PositionGrid, Role};

#[derive(Clone, Copy)]
pub(in crate::io::gltf) struct PrimitivePacking<'a> {
    pub grid: Option<&'a PositionGrid>,
    pub uvs: &'a UvGrids,
    // Index of the material, by which `uvs` lists its grids.
    pub surface: Option<usize>,
    pub compress: bool,
}

impl PrimitivePacking<'_> {
    pub fn pack_positions(&self, positions: &[[f32; 3]]) -> Option<(Vec<f32>, NumberStorage)> {
        let grid = self.grid?;
        let numbers: Vec<[i64; 3]> = positions.iter().map(|p| grid.round(p.map(f64::from))).collect();
        // Positions beyond the grid's range stay in single precision.
        let stored = whole_number_storage(numbers.as_flattened().iter().copied(), "VEC3")?;
        Some((numbers.into_iter().flatten().map(|x| x as f32).collect(), stored))
    }

    /// Converts a morph target's displacements (n x 3) to grid steps; `None` without a grid.
    pub fn pack_displacements(&self, values: &[f32], stored: &NumberStorage) -> Option<(Vec<f32>, NumberStorage)> {
        let step = self.grid?.step;
        let sparse = stored.sparse && !self.compress;
        let numbers: Vec<i64> = values.iter().map(|&x| (f64::from(x) / step).round() as i64).collect();
        // The -1 forces a signed type.
        match whole_number_storage(numbers.iter().copied().chain([-1]), "VEC3") {
            Some(stored) => Some((numbers.into_iter().map(|x| x as f32).collect(), NumberStorage { sparse, ..stored })),
            None => {
                let exact = values.iter().map(|&x| (f64::from(x) / step) as f32).collect();
                Some((exact, NumberStorage { sparse, ..NumberStorage::floats("VEC3") }))
            }
        }
    }

    pub fn direction_storage(&self, values: &[f32], stored: &NumberStorage) -> NumberStorage {
        let sparse = stored.sparse && !self.compress;
        let is_small = values.iter().all(|x| x.abs() <= 1.0);
        if is_small {
            NumberStorage { sparse, ..fraction_storage(BYTE, "VEC3") }
        } else {
            NumberStorage { sparse, ..stored.clone() }
        }
    }

    pub fn is_filtered(&self, kind: (Role, usize)) -> bool {
        self.compress && compress::CAN_COMPRESS && matches!(kind, (Role::Normal, 3) | (Role::Tangent, 4))
    }

    /// Returns the number type for an attribute's values; rounds texture coordinates to their grid.
    pub fn pack_attribute(
        &self,
        name: &str,
        (role, width): (Role, usize),
        values: &mut [f32],
        stored: &NumberStorage,
    ) -> NumberStorage {
        match (role, width) {
            (Role::Normal, 3) => fraction_storage(BYTE, "VEC3"),
            (Role::Tangent, 4) => fraction_storage(BYTE, "VEC4"),
            (Role::Colour, 3 | 4) => fraction_storage(UNSIGNED_BYTE, &stored.shape),
            (Role::Uv, 2) => self.pack_uvs(name, values).unwrap_or_else(|| stored.clone()),
            _ => stored.clone(),
        }
    }

    fn pack_uvs(&self, name: &str, values: &mut [f32]) -> Option<NumberStorage> {
        match self.surface.and_then(|surface| self.uvs.grid(surface, name)) {
            Some(grid) => values.as_chunks_mut::<2>().0.iter_mut().for_each(|uv| *uv = grid.share(*uv)),
            // Without a grid, coordinates from 0 to 1 can still be stored as fractions of an integer's range.
            None if values.iter().all(|x| (0.0..=1.0).contains(x)) => {}
            None => return None,
        }
        Some(NumberStorage { component: UNSIGNED_SHORT, normalized: true, ..NumberStorage::floats("VEC2") })
    }

    /// Sorts each vertex's joints by weight; rounds weights to 255ths that sum to one (n x `n_slots`).
    pub fn pack_skin(&self, joints: &mut [f32], weights: &mut [f32], n_slots: usize) -> NumberStorage {
        for (joints, weights) in joints.chunks_exact_mut(n_slots).zip(weights.chunks_exact_mut(n_slots)) {
            let mut bound: Vec<(f32, f32)> = joints.iter().copied().zip(weights.iter().copied()).collect();
            bound.sort_by(|a, b| b.1.total_cmp(&a.1));
            let mut shares: Vec<i32> = bound.iter().map(|(_, weight)| (weight * 255.0).round() as i32).collect();
            // The largest weight takes the rounding error: at most half a 255th per slot.
            shares[0] += 255 - shares.iter().sum::<i32>();
            for (slot, ((joint, _), share)) in bound.into_iter().zip(shares).enumerate() {
                (joints[slot], weights[slot]) = (if share > 0 { joint } else { 0.0 }, share as f32 / 255.0);
            }
        }
        fraction_storage(UNSIGNED_BYTE, "VEC4")
    }
}

pub(in crate::io::gltf) fn push_directions(draft: &mut Draft, values: &[f32], width: usize) -> Value {
    let four = |row: &[f32]| [row[0], row[1], row[2], row.get(3).copied().unwrap_or(0.0)];
    let rows: Vec<[f32; 4]> = values.chunks_exact(width).map(four).collect();
    let bytes = encode_octahedral(&rows);
    let mut view = json!({"buffer": 0, "byteLength": bytes.len(), "byteStride": 4, "target": VERTICES});
    view["extensions"][COMPRESSION]["filter"] = OCTAHEDRAL.into();
    let view = draft.push_view(view, bytes);
    let accessor = json!({"bufferView": view, "componentType": BYTE, "normalized": true, "count": rows.len(),
        "type": vector_shape(width)});
    draft.push("accessors", accessor)
}

fn fraction_storage(component: u32, shape: &str) -> NumberStorage {
    NumberStorage { component, normalized: true, ..NumberStorage::floats(shape) }
}

fn whole_number_storage(numbers: impl Iterator<Item = i64>, shape: &str) -> Option<NumberStorage> {
    let (low, high) = numbers.fold((0, 0), |(low, high), x| (x.min(low), x.max(high)));
    let component = match (low, high) {
        (0, ..=65_535) => UNSIGNED_SHORT,
        (-32_767.., ..=32_767) => SHORT,
        _ => return None,
    };
    Some(NumberStorage { component, ..NumberStorage::floats(shape) })
}
