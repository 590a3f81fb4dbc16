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

pub(super) fn world_transforms(nodes: &[GltfNode], local: &[DMat4]) -> Vec<DMat4> {
    let mut parent = vec![None; nodes.len()];
    let of = |(i, node): (usize, &GltfNode)| node.children.iter().map(move |&child| (child, i)).collect::<Vec<_>>();
    for (child, i) in nodes.iter().enumerate().flat_map(of) {
        parent.get_mut(child).into_iter().for_each(|parent| *parent = Some(i));
    }
    let world = |mut node: usize| {
        let mut world = local[node];
        // The loop is bounded, as in a broken file a node may be its own ancestor.
        for _ in 0..nodes.len() {
            let Some(above) = parent[node] else { break };
            world = local[above] * world;
            node = above;
        }
        world
    };
    (0..nodes.len()).map(world).collect()
}
