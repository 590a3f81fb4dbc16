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

#[cfg(test)]
mod tests {
    use base64::Engine;

    use super::*;

    /// A triangle at z = 0 as positions (view 0), indices 0 1 2 (view 1), and one more position (view 2).
    fn asset(rest: &str) -> String {
        let mut bytes = Vec::new();
        for float in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(float.to_le_bytes());
        }
        bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
        bytes.extend([5.0f32, 6.0, 7.0].iter().flat_map(|float| float.to_le_bytes()));
        let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 56, "uri": "data:application/octet-stream;base64,{data}"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 6}}, {{"buffer": 0, "byteOffset": 44, "byteLength": 12}}],
            {rest}}}"#
        )
    }

    const ACCESSORS: &str = r#""accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],"#;
    const MESH: &str = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],"#;

    fn parse(text: &str) -> Result<RawMesh, ReadError> {
        read(text.as_bytes(), &|uri| Err(ReadError::file(format!("asked for {uri}"), "")))
    }

    fn scene(nodes: &str) -> Result<RawMesh, ReadError> {
        parse(&asset(&format!(r#"{ACCESSORS}{MESH}"nodes": [{nodes}]"#)))
    }

    #[test]
    fn transforms_nest() {
        let mesh = scene(
            r#"{"children": [1], "translation": [10, 0, 0], "scale": [2, 2, 2]},
            {"children": [2], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
            {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,3,1]}"#,
        )
        .unwrap();
        for (found, expected) in mesh.positions.iter().zip([[10.0, 0.0, 6.0], [10.0, 2.0, 6.0], [8.0, 0.0, 6.0]]) {
            assert!((0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-12), "{found:?}");
        }
        assert_eq!(mesh.faces, [[0, 1, 2]]);
    }

    #[test]
    fn mirrors_turn_the_faces_back() {
        let mesh = scene(r#"{"mesh": 0, "scale": [1, 1, -1]}, {"mesh": 0, "scale": [-1, -1, 1]}"#).unwrap();
        assert_eq!(mesh.faces, [[0, 2, 1], [3, 4, 5]]);
    }

    #[test]
    fn only_the_default_scene_counts() {
        let nodes = r#""nodes": [{"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0]}], "scenes": [{"nodes": [0]}, {"nodes": [1]}]"#;
        let first = parse(&asset(&format!("{ACCESSORS}{MESH}{nodes}"))).unwrap();
        assert_eq!(first.positions[0], [0.0; 3]);
        let second = parse(&asset(&format!("{ACCESSORS}{MESH}{nodes}, \"scene\": 1"))).unwrap();
        assert_eq!((second.positions[0], second.faces.len()), ([1.0, 0.0, 0.0], 1));
    }

    #[test]
    fn sparse_accessors_replace_elements() {
        let accessors = r#""accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "sparse":
            {"count": 1, "indices": {"bufferView": 1, "byteOffset": 4, "componentType": 5123}, "values": {"bufferView": 2}}}],"#;
        let mesh = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}]"#;
        assert_eq!(parse(&asset(&format!("{accessors}{mesh}"))).unwrap().positions[2], [5.0, 6.0, 7.0]);
    }

    #[test]
    fn strips_and_fans_keep_their_winding() {
        assert_eq!(triangles(&[0, 1, 2, 3, 4], 5), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(triangles(&[0, 1, 2, 3], 6), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(triangles(&[0, 1, 2, 3], 4), [[0, 1, 2]]);
        for mode in 4..=6 {
            assert!(triangles(&[], mode).is_empty() && triangles(&[0], mode).is_empty());
        }
    }

    #[test]
    fn containers_hold_the_same() {
        let json = asset(&format!(r#"{ACCESSORS}{MESH}"nodes": [{{"mesh": 0}}]"#));
        let mut glb = [&b"glTF\x02\0\0\0\0\0\0\0"[..], &(json.len() as u32).to_le_bytes(), b"JSON"].concat();
        glb.extend(json.as_bytes());
        let no_fetch = |_: &str| Err(ReadError::file("fetched", ""));
        assert_eq!(read(&glb, &no_fetch).unwrap(), parse(&json).unwrap());
        for length in 0..glb.len() {
            assert!(read(&glb[..length], &no_fetch).is_err());
        }
    }

    #[test]
    fn flawed_assets_are_refused() {
        for (rest, expected) in [
            (format!(r#"{ACCESSORS}{MESH}"nodes": [{{"mesh": 1}}]"#), "there is no mesh 1"),
            (
                format!(r#"{ACCESSORS}{MESH}"nodes": [{{"children": [0]}}], "scenes": [{{"nodes": [0]}}]"#),
                "node 0 has two parents",
            ),
            (format!(r#"{MESH}"nodes": [{{"mesh": 0}}]"#), "there is no accessor 0"),
            (
                format!(r#"{MESH}"nodes": [{{"mesh": 0}}], "extensionsRequired": ["KHR_draco_mesh_compression"]"#),
                "needs the extension KHR_draco",
            ),
            (
                ACCESSORS.replace("\"count\": 3", "\"count\": 4000000000") + MESH + r#""nodes": [{"mesh": 0}]"#,
                "accessor 0 with 4000000000 VEC3 of type 5126 cannot be used here",
            ),
            (
                ACCESSORS.replace("\"count\": 3", "\"count\": 4") + MESH + r#""nodes": [{"mesh": 0}]"#,
                "buffer view 0 has no room for 4 elements",
            ),
            ("\"nodes\": 7".into(), "not the JSON of glTF"),
        ] {
            let error = parse(&asset(&rest)).unwrap_err().to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
        let error = parse(r#"{"buffers": [{"uri": "../x.bin"}]}"#).unwrap_err();
        assert_eq!(error.what, "asked for ../x.bin");
    }

    #[test]
    fn instances_cannot_fill_the_memory() {
        let nodes = (0..3_000).map(|_| r#"{"mesh": 0}"#).collect::<Vec<_>>().join(",");
        let zeros = r#""accessors": [{"componentType": 5126, "count": 100000, "type": "VEC3"}],"#;
        let mesh = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],"#;
        let error = parse(&asset(&format!(r#"{zeros}{mesh}"nodes": [{nodes}]"#))).unwrap_err();
        assert!(
            error.to_string().contains("cannot be used here") || error.to_string().contains("extreme size"),
            "{error}"
        );
    }
}
