//! Transforms of joints and skinned meshes.

use glam::DMat4;

use super::accessor::Data;
use super::schema::{GltfNode, Skin};
use crate::io::ReadError;

// Joints of a skin, with their inverse bind matrices (from mesh to joint coordinates).
pub(super) struct Bones {
    pub joints: Vec<usize>,
    pub inverse_bind: Vec<DMat4>,
}

impl Bones {
    pub fn read(data: &Data, skin: &Skin) -> Result<Self, ReadError> {
        let n = skin.joints.len();
        // There is one matrix per joint; the limit rejects more.
        let matrices = skin.inverse_bind_matrices.map(|index| data.floats(index, 16 * n.max(1)));
        let inverse_bind = match matrices.transpose()? {
            Some((16, values)) => {
                values.as_chunks::<16>().0.iter().map(|m| DMat4::from_cols_array(&m.map(f64::from))).collect()
            }
            _ => vec![DMat4::IDENTITY; n],
        };
        Ok(Self { joints: skin.joints.clone(), inverse_bind })
    }

    /// Returns the transform from the mesh, in its bind pose, to the scene.
    pub fn bind_transform(&self, world: &[DMat4]) -> Option<DMat4> {
        let joints = self.joints.iter().zip(&self.inverse_bind);
        // In the bind pose all joints agree, so the first with an invertible matrix decides.
        let mut transforms = joints.filter_map(|(&joint, inverse)| Some(*world.get(joint)? * *inverse));
        transforms.find(|transform| transform.is_finite() && transform.determinant() != 0.0)
    }
}

/// Returns the transform of each node to the scene.
pub(super) fn world_transforms(nodes: &[GltfNode], local: &[DMat4]) -> Vec<DMat4> {
    let mut parent = vec![None; nodes.len()];
    for (node, &child) in nodes.iter().enumerate().flat_map(|(at, node)| node.children.iter().map(move |it| (at, it))) {
        parent.get_mut(child).into_iter().for_each(|parent| *parent = Some(node));
    }
    let mut world = local.to_vec();
    // Parents come before their children. In a broken file, a node that is its own ancestor is under no root, and stays.
    let mut open: Vec<usize> = (0..nodes.len()).filter(|&node| parent[node].is_none()).collect();
    while let Some(node) = open.pop() {
        for &child in &nodes[node].children {
            // Each child is placed once, even if it is listed twice.
            if let Some(above) = parent.get_mut(child).filter(|above| **above == Some(node)) {
                *above = None;
                world[child] = world[node] * local[child];
                open.push(child);
            }
        }
    }
    world
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use serde_json::json;

    use super::*;

    #[test]
    fn transforms_add_up_from_roots_and_stay_in_circles() {
        // Node 3 is under 2, 1 and 0; 4 is listed twice; 5 and 6 are each other's parents.
        let children = json!([
            {"children": [1]}, {"children": [2, 4, 4]}, {"children": [3, 99]}, {}, {}, {"children": [6]}, {"children": [5]}
        ]);
        let nodes: Vec<GltfNode> = serde_json::from_value(children).unwrap();
        let local: Vec<DMat4> = (0..7).map(|at| DMat4::from_translation(DVec3::X * f64::from(1 << at))).collect();
        let found = world_transforms(&nodes, &local);
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(|at: usize| found[at].w_axis.x), [1.0, 3.0, 7.0, 15.0, 19.0, 32.0, 64.0]);
    }

    #[test]
    fn a_tree_as_deep_as_it_has_nodes_takes_no_square_of_time() {
        let n = 200_000;
        let nodes = (0..n).map(|at| json!({"children": if at + 1 < n { vec![at + 1] } else { vec![] }}));
        let nodes: Vec<GltfNode> = nodes.map(|node| serde_json::from_value(node).unwrap()).collect();
        let local = vec![DMat4::from_translation(DVec3::X); n];
        assert_eq!(world_transforms(&nodes, &local)[n - 1].w_axis.x, n as f64);
    }
}
