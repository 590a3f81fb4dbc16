//! Placements of meshes in the default scene.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};

use super::accessor::Data;
use super::bones::{Bones, world_transforms};
use super::refusals::{REMEDY, missing_error};
use super::schema::{GltfNode, Root};
use crate::io::ReadError;

pub(super) struct MeshPlacement<'a> {
    pub mesh: usize,
    // Transform from the mesh to the scene; for a skinned mesh, in its bind pose.
    pub transform: DMat4,
    pub skinned: bool,
    // Accessors of instances by name, if the node repeats its mesh.
    pub instances: Option<&'a BTreeMap<String, usize>>,
}

pub(super) fn placements<'a>(data: &Data<'a>) -> Result<Vec<MeshPlacement<'a>>, ReadError> {
    let root = data.root;
    let bound = bind_transforms(data);
    let mut placed = Vec::new();
    let mut visited = vec![false; root.nodes.len()];
    // A stack replaces recursion, since the file decides the nesting depth.
    let mut open: Vec<(usize, DMat4)> = roots(root)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, outer)) = open.pop() {
        let node = root.nodes.get(index).ok_or_else(|| missing_error("node", index))?;
        if std::mem::replace(&mut visited[index], true) {
            return Err(ReadError::file(format!("node {index} has two parents"), REMEDY));
        }
        let transform = outer * local_transform(node);
        let (skinned, instances) = (node.skin.is_some(), node.instances());
        // The transform of a skinned mesh's node has no effect, by the specification.
        let of_skin = node.skin.and_then(|skin| *bound.get(skin)?);
        placed.extend(node.mesh.map(|mesh| MeshPlacement {
            mesh,
            transform: of_skin.unwrap_or(transform),
            skinned,
            instances,
        }));
        open.extend(node.children.iter().rev().map(|&child| (child, transform)));
    }
    Ok(placed)
}

fn bind_transforms(data: &Data) -> Vec<Option<DMat4>> {
    let root = data.root;
    if root.skins.is_empty() {
        return Vec::new();
    }
    let local: Vec<DMat4> = root.nodes.iter().map(local_transform).collect();
    let world = world_transforms(&root.nodes, &local);
    root.skins.iter().map(|skin| Bones::read(data, skin).ok()?.bind_transform(&world)).collect()
}

fn roots(root: &Root) -> Result<Vec<usize>, ReadError> {
    // A file without scenes still has nodes that viewers show.
    if !root.scenes.is_empty() {
        let index = root.scene.unwrap_or(0);
        return Ok(root.scenes.get(index).ok_or_else(|| missing_error("scene", index))?.nodes.clone());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for &child in root.nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(child) {
            *mark = true;
        }
    }
    Ok((0..root.nodes.len()).filter(|&node| !is_child[node]).collect())
}

pub(super) fn local_transform(node: &GltfNode) -> DMat4 {
    if let Some(columns) = node.matrix {
        return DMat4::from_cols_array(&columns);
    }
    transform_of(node.scale, node.rotation, node.translation)
}

fn transform_of(scale: Option<[f64; 3]>, rotation: Option<[f64; 4]>, translation: Option<[f64; 3]>) -> DMat4 {
    let rotation = DQuat::from_array(rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    // Broken files have zero quaternions.
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    let scale = scale.map_or(DVec3::ONE, DVec3::from);
    DMat4::from_scale_rotation_translation(scale, rotation, translation.unwrap_or_default().into())
}

impl MeshPlacement<'_> {
    // Tables of rotations and translations may differ in length.
    pub fn n_instances(&self, data: &Data) -> Result<usize, ReadError> {
        let mut counts = self.instances.iter().flat_map(|names| names.values()).map(|&accessor| data.count(accessor));
        let most = counts.try_fold(0, |most: usize, count| Ok(most.max(count?)))?;
        Ok(if self.instances.is_some() { most } else { 1 })
    }

    /// Returns the transform from the mesh to the scene for each instance.
    pub fn transforms(&self, data: &Data, limit: usize) -> Result<Vec<DMat4>, ReadError> {
        let Some(names) = self.instances else { return Ok(vec![self.transform]) };
        let rows = |name: &str| names.get(name).map(|&accessor| data.floats(accessor, limit)).transpose();
        let [scales, rotations, translations] = [rows("SCALE")?, rows("ROTATION")?, rows("TRANSLATION")?];
        let lengths = [&scales, &rotations, &translations].map(|rows| Some(rows.as_ref()?.1.len() / rows.as_ref()?.0));
        // The shortest table decides: the specification demands equal lengths.
        let n = lengths.into_iter().flatten().min().unwrap_or(0);
        let instance = |i| transform_of(row(&scales, i), row(&rotations, i), row(&translations, i));
        Ok((0..n).map(|i| self.transform * instance(i)).collect())
    }
}

fn row<const N: usize>(rows: &Option<(usize, Vec<f32>)>, i: usize) -> Option<[f64; N]> {
    let (width, values) = rows.as_ref()?;
    let row = values.get(i * width..)?.first_chunk::<N>().filter(|_| *width == N)?;
    Some(row.map(f64::from))
}
