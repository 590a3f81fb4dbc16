//! Skins as matrices: where the joints stand, and where a skin puts its mesh in the pose that it was bound in.

use glam::DMat4;

use super::accessor::Data;
use super::schema::{Node, Skin};
use crate::io::ReadError;

/// The joints of a skin, with the matrices from the mesh's coordinates to theirs.
pub(super) struct Bones {
    pub joints: Vec<usize>,
    pub inverse_bind: Vec<DMat4>,
}

impl Bones {
    /// Reads the matrices of a skin; those that are missing are the identity.
    pub fn of(data: &Data, skin: &Skin) -> Result<Self, ReadError> {
        let n = skin.joints.len();
        let matrices = skin.inverse_bind_matrices.map(|index| data.floats(index, 16 * n.max(1)));
        let inverse_bind = match matrices.transpose()? {
            Some((16, values)) => {
                values.as_chunks::<16>().0.iter().map(|m| DMat4::from_cols_array(&m.map(f64::from))).collect()
            }
            _ => vec![DMat4::IDENTITY; n],
        };
        Ok(Self { joints: skin.joints.clone(), inverse_bind })
    }

    /// Returns the transform from the mesh's coordinates to the scene's in the pose that the skin was bound in: that of the
    /// first joint whose matrices have an inverse. All joints agree on it where the nodes stand in that pose.
    pub fn bind_transform(&self, world: &[DMat4]) -> Option<DMat4> {
        let joints = self.joints.iter().zip(&self.inverse_bind);
        let mut transforms = joints.filter_map(|(&joint, inverse)| Some(*world.get(joint)? * *inverse));
        transforms.find(|transform| transform.is_finite() && transform.determinant() != 0.0)
    }
}

/// Returns the transforms of all nodes to the scene, from those of each to its parent, n_nodes.
pub(super) fn world_transforms(nodes: &[Node], local: &[DMat4]) -> Vec<DMat4> {
    let mut parent = vec![None; nodes.len()];
    let of = |(i, node): (usize, &Node)| node.children.iter().map(move |&child| (child, i)).collect::<Vec<_>>();
    for (child, i) in nodes.iter().enumerate().flat_map(of) {
        parent.get_mut(child).into_iter().for_each(|parent| *parent = Some(i));
    }
    let world = |mut node: usize| {
        let mut world = local[node];
        // No node is its own ancestor but in a broken file.
        for _ in 0..nodes.len() {
            let Some(above) = parent[node] else { break };
            world = local[above] * world;
            node = above;
        }
        world
    };
    (0..nodes.len()).map(world).collect()
}
