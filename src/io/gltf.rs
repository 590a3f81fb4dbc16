//! glTF 2.0, as JSON or as GLB, read only: the triangles of the default scene with the transforms of their nodes.
//!
//! Materials, cameras, skins, morph targets and animations are passed over; compressed geometry is refused by name.

mod accessor;
mod container;
mod schema;

use std::collections::BTreeMap;

use accessor::Data;
use container::Container;
use glam::{DMat4, DQuat, DVec3};
use schema::{Node, Primitive, Root};

use super::ReadError;
use crate::mesh::RawMesh;

const REMEDY: &str = "export the asset again";

/// Extensions without which the geometry is not what the file shows.
const REFUSED: [&str; 4] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_mesh_gpu_instancing"];

/// How often instances may repeat the bytes of a file, and how many vertices and faces are always granted.
const REPEATS: (usize, usize) = (16, 1 << 22);

/// Reads a glTF asset; `fetch` gives the bytes of a buffer that is a file of its own, by its URI.
pub(super) fn read(bytes: &[u8], fetch: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>) -> Result<RawMesh, ReadError> {
    let Container { root, buffers } = Container::open(bytes, fetch)?;
    if let Some(name) = root.extensions_required.iter().find(|name| REFUSED.contains(&name.as_str())) {
        return Err(ReadError::file(format!("needs the extension {name}"), "export the asset without it"));
    }
    let n_bytes = bytes.len() + buffers.iter().map(|buffer| buffer.len()).sum::<usize>();
    let budget = REPEATS.0 * n_bytes + REPEATS.1;
    let mut scene = Scene { data: Data { root: &root, buffers: &buffers }, mesh: RawMesh::default(), budget };
    scene.add_nodes()?;
    let mut mesh = scene.mesh;
    mesh.double = is_far_out(&mesh.positions);
    Ok(mesh)
}

/// Whether transforms put the mesh so far from the origin that single precision would blur it.
fn is_far_out(positions: &[[f64; 3]]) -> bool {
    let points = || positions.iter().map(|&p| DVec3::from(p)).filter(|p| p.is_finite());
    let low = points().fold(DVec3::INFINITY, DVec3::min);
    let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    low.abs().max(high.abs()).max_element() > 16.0 * (high - low).max_element()
}

/// The asset and what was collected of it.
struct Scene<'a> {
    data: Data<'a>,
    mesh: RawMesh,
    /// Vertices and faces that may still be added.
    budget: usize,
}

impl Scene<'_> {
    /// Adds the meshes of all nodes below the roots.
    fn add_nodes(&mut self) -> Result<(), ReadError> {
        let root = self.data.root;
        let mut visited = vec![false; root.nodes.len()];
        let mut open: Vec<(usize, DMat4)> =
            roots(root)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
        while let Some((index, outer)) = open.pop() {
            let node = root.nodes.get(index).ok_or_else(|| missing("node", index))?;
            if std::mem::replace(&mut visited[index], true) {
                return Err(ReadError::file(format!("node {index} has two parents"), REMEDY));
            }
            let transform = outer * local_transform(node);
            if let Some(mesh) = node.mesh {
                self.add_mesh(mesh, transform)?;
            }
            open.extend(node.children.iter().rev().map(|&child| (child, transform)));
        }
        Ok(())
    }

    /// Adds the triangles of all primitives of a mesh.
    fn add_mesh(&mut self, index: usize, transform: DMat4) -> Result<(), ReadError> {
        let root = self.data.root;
        let mesh = root.meshes.get(index).ok_or_else(|| missing("mesh", index))?;
        // Primitives that differ in material only often share their positions.
        let mut known = BTreeMap::new();
        for primitive in &mesh.primitives {
            let Some(&accessor) = primitive.attributes.get("POSITION").filter(|_| (4..=6).contains(&primitive.mode))
            else {
                continue;
            };
            let (first, count) = match known.get(&accessor) {
                Some(&place) => place,
                None => *known.entry(accessor).or_insert(self.add_positions(accessor, transform)?),
            };
            self.add_faces(primitive, first, count, transform.determinant() < 0.0)?;
        }
        Ok(())
    }

    /// Adds the transformed positions of an accessor; gives the index of the first and their number.
    fn add_positions(&mut self, accessor: usize, transform: DMat4) -> Result<(usize, usize), ReadError> {
        let first = self.mesh.positions.len();
        let local = self.data.positions(accessor, self.budget)?;
        self.spend(local.len())?;
        self.mesh.positions.extend(local.iter().map(|&p| transform.transform_point3(p.into()).to_array()));
        Ok((first, local.len()))
    }

    /// Adds the triangles of a primitive over positions `first..first + count`.
    fn add_faces(
        &mut self,
        primitive: &Primitive,
        first: usize,
        count: usize,
        mirrored: bool,
    ) -> Result<(), ReadError> {
        let n_corners = primitive.indices.map_or(Ok(count), |accessor| self.data.count(accessor))?;
        self.spend(n_corners)?;
        let indices = match primitive.indices {
            Some(accessor) => self.data.indices(accessor, n_corners)?,
            None => (0..count as u32).collect(),
        };
        // An index beyond this primitive's positions must not reach another's.
        let place = |index: u32| if (index as usize) < count { (first + index as usize) as u32 } else { u32::MAX };
        let triangles = triangles(&indices, primitive.mode);
        let turn = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        self.mesh.faces.extend(triangles.into_iter().map(|triangle| turn(triangle.map(place))));
        Ok(())
    }

    /// Takes from the budget, so that a small file cannot fill the memory.
    fn spend(&mut self, n: usize) -> Result<(), ReadError> {
        self.budget = self.budget.checked_sub(n).ok_or_else(|| {
            ReadError::file("the nodes repeat the meshes to an extreme size", "export fewer instances")
        })?;
        Ok(())
    }
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

/// Corner indices as triangles; mode 4 is a list, 5 a strip, 6 a fan.
fn triangles(indices: &[u32], mode: u32) -> Vec<[u32; 3]> {
    match mode {
        4 => indices.as_chunks::<3>().0.to_vec(),
        5 => {
            let turn = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
            indices.windows(3).enumerate().map(turn).collect()
        }
        _ => indices.get(1..).unwrap_or_default().windows(2).map(|edge| [edge[0], edge[1], indices[0]]).collect(),
    }
}

/// The error for an index that leads nowhere.
fn missing(what: &str, index: usize) -> ReadError {
    ReadError::file(format!("there is no {what} {index}"), REMEDY)
}
