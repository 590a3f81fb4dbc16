//! Where the nodes of the default scene place meshes.

use glam::{DMat4, DQuat};

use super::schema::{Node, Root};
use super::{REMEDY, missing};
use crate::io::ReadError;

/// A mesh at one place.
pub(super) struct Placed {
    /// Index of the mesh, unchecked.
    pub mesh: usize,
    /// From the mesh's coordinates to the scene's.
    pub transform: DMat4,
    /// Whether a skin moves it, so that the transform does not count.
    pub skinned: bool,
    /// The accessor of further scales at which the node repeats it, if there is one.
    pub instance_scales: Option<usize>,
}

/// All meshes that nodes below the roots place, parents before children.
pub(super) fn placements(root: &Root) -> Result<Vec<Placed>, ReadError> {
    let mut placed = Vec::new();
    let mut visited = vec![false; root.nodes.len()];
    let mut open: Vec<(usize, DMat4)> = roots(root)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, outer)) = open.pop() {
        let node = root.nodes.get(index).ok_or_else(|| missing("node", index))?;
        if std::mem::replace(&mut visited[index], true) {
            return Err(ReadError::file(format!("node {index} has two parents"), REMEDY));
        }
        let transform = outer * local_transform(node);
        let (skinned, instance_scales) = (node.skin.is_some(), node.instance_scales());
        placed.extend(node.mesh.map(|mesh| Placed { mesh, transform, skinned, instance_scales }));
        open.extend(node.children.iter().rev().map(|&child| (child, transform)));
    }
    Ok(placed)
}

/// The nodes to start from: those of the default or first scene, else all that are nobody's child.
fn roots(root: &Root) -> Result<Vec<usize>, ReadError> {
    if !root.scenes.is_empty() {
        let index = root.scene.unwrap_or(0);
        return Ok(root.scenes.get(index).ok_or_else(|| missing("scene", index))?.nodes.clone());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for &child in root.nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(child) {
            *mark = true;
        }
    }
    Ok((0..root.nodes.len()).filter(|&node| !is_child[node]).collect())
}

/// The matrix of a node, given as such or as translation, rotation and scale.
fn local_transform(node: &Node) -> DMat4 {
    if let Some(columns) = node.matrix {
        return DMat4::from_cols_array(&columns);
    }
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    let scale = node.scale.unwrap_or([1.0; 3]);
    DMat4::from_scale_rotation_translation(scale.into(), rotation, node.translation.unwrap_or([0.0; 3]).into())
}
