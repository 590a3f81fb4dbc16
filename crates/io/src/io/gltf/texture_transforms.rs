//! Application of texture transforms (`KHR_texture_transform`).

use std::borrow::Cow;
use std::collections::BTreeMap;

use rustc_hash::FxHashMap;
use serde_json::Value;

use super::asset::Asset;
use super::packed::{TRANSFORM, UvTransform, coordinates, for_each_texture_use};
use super::references::index;
use crate::mesh::{RawMesh, Role};

// Offset and scale by name of coordinates; the scale is applied first.
pub(super) type Transforms = BTreeMap<String, [[f64; 2]; 2]>;
// The same with the bits of the numbers, for a table.
type Bits<'a> = Vec<(&'a str, [[u64; 2]; 2])>;

/// Returns the transform of each texture coordinate set; `None` if one has several or a rotation.
pub(super) fn material_transforms(material: &Value) -> Option<Transforms> {
    let (mut found, mut is_plain) = (Transforms::new(), true);
    for_each_texture_use(&mut material.clone(), &mut |used| {
        let UvTransform { offset, scale, is_turned } = UvTransform::from_use(used);
        let own = [offset, scale];
        is_plain &= *found.entry(coordinates(used)).or_insert(own) == own && !is_turned;
    });
    is_plain.then_some(found)
}

impl Asset {
    pub(super) fn with_transforms<'a>(&self, part: usize, mesh: &'a RawMesh) -> Cow<'a, RawMesh> {
        if !self.container.root.extensions_used.iter().any(|name| name == TRANSFORM) {
            return Cow::Borrowed(mesh);
        }
        let primitives = self.meshes.get(part).and_then(|&mesh| self.document["meshes"][mesh]["primitives"].as_array());
        let of_primitive = |primitive: &Value| {
            let material = primitive.get("material").and_then(index);
            material.and_then(|at| material_transforms(self.document["materials"].get(at)?)).unwrap_or_default()
        };
        let of_groups: Vec<Transforms> = primitives.into_iter().flatten().map(of_primitive).collect();
        let mut moved = mesh.clone();
        move_coordinates(&mut moved, &of_groups);
        Cow::Owned(moved)
    }
}

// Wedges of groups with different transforms are duplicated.
fn move_coordinates(mesh: &mut RawMesh, of_groups: &[Transforms]) {
    let attributes = &mut mesh.attributes;
    let n_wedges = attributes.n_wedges();
    // Groups with equal transforms share wedges.
    let mut known: FxHashMap<Bits, usize> = FxHashMap::default();
    let first_alike = of_groups.iter().enumerate().map(|(at, own)| {
        let bits = own.iter().map(|(name, transform)| (name.as_str(), transform.map(|pair| pair.map(f64::to_bits))));
        *known.entry(bits.collect()).or_insert(at)
    });
    let first_alike: Vec<usize> = first_alike.collect();
    let mut taken: Vec<Option<usize>> = vec![None; n_wedges];
    let mut copies: FxHashMap<(u32, usize), u32> = FxHashMap::default();
    for face in 0..attributes.wedges.len() {
        let Some(&kind) = first_alike.get(attributes.group(face as u32) as usize) else { continue };
        for corner in 0..3 {
            let wedge = attributes.wedges[face][corner];
            match taken.get(wedge as usize).copied() {
                Some(None) => taken[wedge as usize] = Some(kind),
                // Another transform already uses the wedge, so it is copied once for this one.
                Some(Some(other)) if other != kind => {
                    let copy = *copies.entry((wedge, kind)).or_insert_with(|| {
                        taken.push(Some(kind));
                        for channel in &mut attributes.channels {
                            let row = wedge as usize * channel.width;
                            channel.values.extend_from_within(row..row + channel.width);
                        }
                        taken.len() as u32 - 1
                    });
                    attributes.wedges[face][corner] = copy;
                }
                _ => {}
            }
        }
    }
    for channel in attributes.channels.iter_mut().filter(|channel| channel.role == Role::Uv && channel.width == 2) {
        for (uv, kind) in channel.values.as_chunks_mut::<2>().0.iter_mut().zip(&taken) {
            if let Some([offset, scale]) = kind.and_then(|kind| of_groups[kind].get(&channel.name)) {
                *uv = std::array::from_fn(|axis| (offset[axis] + scale[axis] * f64::from(uv[axis])) as f32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::mesh::{Attributes, Channel};

    #[test]
    fn coordinates_are_those_that_textures_take() {
        let used = |scale: f64| json!({"index": 0, "extensions": {TRANSFORM: {"scale": [scale, 1], "offset": [0, 1]}}});
        let material = json!({"pbrMetallicRoughness": {"baseColorTexture": used(2.0)}});
        let of_first = material_transforms(&material).unwrap();
        assert_eq!(of_first["TEXCOORD_0"], [[0.0, 1.0], [2.0, 1.0]]);
        let several = json!({"normalTexture": used(3.0), "emissiveTexture": used(2.0)});
        assert_eq!(material_transforms(&several), None);
        let uv = Channel { name: "TEXCOORD_0".into(), role: Role::Uv, width: 2, values: vec![0.5, 0.25, 1.0, 0.0] };
        let attributes = Attributes { wedges: vec![[0, 0, 1], [0, 0, 0]], channels: vec![uv], groups: vec![0, 1] };
        let mut mesh = RawMesh { faces: vec![[0, 1, 2]; 2], attributes, ..RawMesh::default() };
        move_coordinates(&mut mesh, &[of_first, Transforms::new()]);
        let Attributes { wedges, channels, .. } = &mesh.attributes;
        assert_eq!(wedges, &[[0, 0, 1], [2, 2, 2]]);
        assert_eq!(channels[0].values, [1.0, 1.25, 2.0, 1.0, 0.5, 0.25]);
    }
}
