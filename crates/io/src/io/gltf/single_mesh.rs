//! Reading of the default scene as one mesh.
//!
//! Texture coordinates get v upwards and colours sRGB, as in OBJ and PLY.

use std::collections::{BTreeMap, HashSet};

use super::asset::Asset;
use super::asset_part::AssetPart;
use super::geometry;
use super::placements::{MeshPlacement, placements};
use super::refusals::{refuse_instancing, spend};
use crate::io::extra::{Extra, Group, ReadMesh};
use crate::io::far_from_origin::is_far_from_origin;
use crate::io::{FileFetcher, ReadError};
use crate::mesh::{Channel, PlacedMesh, RawMesh, Role, merge_placed_meshes, srgb};

const LEFT: &str = "tangents, skins and morph targets are left out: only a scene keeps them";

/// Reads a glTF as one mesh, or its geometry alone if the rest is broken.
pub(in crate::io) fn read_attributed(bytes: &[u8], fetch: &FileFetcher) -> Result<ReadMesh, ReadError> {
    // Images and materials may be broken while the geometry is fine.
    let asset = match Asset::from_bytes(bytes, fetch) {
        Ok(asset) => asset,
        Err(error) => {
            let mesh = geometry::read(bytes, fetch)?;
            let notes = vec![format!("only the geometry is read: {}", ReadError { format: None, ..error })];
            return Ok(ReadMesh { mesh, notes, ..ReadMesh::default() });
        }
    };
    refuse_instancing(&asset.container.root.extensions_required)?;
    let (extra, first_groups, notes) = describe_groups(&asset);
    let mut mesh = join_parts(&asset, &first_groups, asset.container.budget(bytes.len()))?;
    mesh.attributes.channels.iter_mut().for_each(to_sceneless_values);
    mesh.double = is_far_from_origin(&mesh.positions);
    Ok(ReadMesh { mesh, extra, notes, format: None })
}

fn describe_groups(asset: &Asset) -> (Extra, Vec<u32>, Vec<String>) {
    let (looks, notes) = asset.looks();
    let names = material_names(asset);
    let (mut extra, mut first_groups, mut known) = (Extra::default(), Vec::new(), HashSet::new());
    for ((part, &mesh), looks) in asset.parts().iter().zip(&asset.meshes).zip(looks) {
        first_groups.push(extra.groups.len() as u32);
        let Some(mesh) = asset.container.root.meshes.get(mesh) else { continue };
        for (primitive, look) in mesh.primitives.iter().zip(looks) {
            let material = primitive.material.and_then(|index| names.get(index)).cloned();
            let new = material.as_ref().filter(|name| known.insert((*name).clone()));
            extra.looks.extend(new.map(|name| (name.clone(), look)));
            extra.groups.push(Group { object: Some(part.name.clone()), material, ..Group::default() });
        }
    }
    let bends = |role| matches!(role, Role::Skin | Role::MorphPosition);
    // glTF prescribes metres.
    extra.unit = Some("meter".into());
    extra.is_bent = asset.parts().iter().flat_map(|part| &part.mesh.attributes.channels).any(|it| bends(it.role));
    let mut channels = asset.parts().iter().flat_map(|part| &part.mesh.attributes.channels);
    let left = channels.any(|channel| !is_carried(channel.role)).then(|| LEFT.to_string());
    (extra, first_groups, [asset.notes(), &notes, left.as_slice()].concat())
}

fn join_parts(asset: &Asset, first_groups: &[u32], mut budget: usize) -> Result<RawMesh, ReadError> {
    let n_numbers = n_numbers(asset.parts());
    let meshes: Vec<_> =
        asset.parts().iter().enumerate().map(|(at, part)| asset.with_transforms(at, &part.mesh)).collect();
    let mut placed = Vec::new();
    for MeshPlacement { mesh, transform, .. } in placements(&asset.container.data())? {
        let Ok(part) = asset.meshes.binary_search(&mesh) else { continue };
        let (mesh, first_group): (&RawMesh, u32) = (&meshes[part], first_groups[part]);
        let n_wedges = mesh.attributes.n_wedges().max(1);
        // Each instance repeats vertices and faces, and has values for the channels of all parts.
        spend(&mut budget, mesh.positions.len() + mesh.faces.len() + n_wedges * n_numbers)?;
        placed.push(PlacedMesh { mesh, transform, first_group });
    }
    Ok(merge_placed_meshes(&placed, is_carried))
}

fn n_numbers(parts: &[AssetPart]) -> usize {
    let mut widths: BTreeMap<&str, usize> = BTreeMap::new();
    for channel in parts.iter().flat_map(|part| &part.mesh.attributes.channels).filter(|it| is_carried(it.role)) {
        let widest = widths.entry(&channel.name).or_default();
        *widest = channel.width.max(*widest);
    }
    widths.values().sum()
}

fn material_names(asset: &Asset) -> Vec<String> {
    let (mut names, mut known): (Vec<String>, _) = (Vec::new(), HashSet::new());
    for (index, material) in asset.container.root.materials.iter().enumerate() {
        let name = material.name.as_deref().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join("_");
        // Other formats identify materials by name, and many MTL readers end a name at a blank.
        let is_own = !name.is_empty() && !known.contains(&name);
        let name = if is_own { name } else { format!("{}_{index}", if name.is_empty() { "material" } else { &name }) };
        known.insert(name.clone());
        names.push(name);
    }
    names
}

fn is_carried(role: Role) -> bool {
    matches!(role, Role::Normal | Role::Uv | Role::Colour | Role::Other | Role::Label)
}

fn to_sceneless_values(channel: &mut Channel) {
    for row in channel.values.chunks_exact_mut(channel.width) {
        match channel.role {
            Role::Uv => row.iter_mut().skip(1).step_by(2).for_each(|v| *v = 1.0 - *v),
            Role::Colour => row.iter_mut().take(3).for_each(|x| *x = srgb(*x)),
            _ => {}
        }
    }
}
