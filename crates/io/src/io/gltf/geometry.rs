//! Geometry of the default scene, without attributes.

use crate::io::far_from_origin::is_far_from_origin;
use crate::io::{FileFetcher, ReadError};
use crate::mesh::{Attributes, PlacedMesh, RawMesh, merge_placed_meshes};

use super::asset_part::read_geometry;
use super::container::Container;
use super::placements::{MeshPlacement, placements};
use super::refusals::{missing_error, refuse_instancing};

/// Reads the geometry of a glTF; `fetch` returns the bytes of a buffer file by its URI.
pub(in crate::io) fn read(bytes: &[u8], fetch: &FileFetcher) -> Result<RawMesh, ReadError> {
    // All bytes are at hand from here on, and every access to them is checked.
    let container = Container::open(bytes, fetch)?;
    refuse_instancing(&container.root.extensions_required)?;
    let (data, mut budget) = (container.data(), container.budget(bytes.len()));
    let mut meshes = Vec::new();
    for MeshPlacement { mesh: index, transform, .. } in placements(&data)? {
        let mesh = data.root.meshes.get(index).ok_or_else(|| missing_error("mesh", index))?;
        meshes.push((read_geometry(&data, mesh, &mut budget)?, transform));
    }
    let placed = meshes.iter().map(|&(ref mesh, transform)| PlacedMesh { mesh, transform, first_group: 0 });
    let placed: Vec<PlacedMesh> = placed.collect();
    let mut mesh = RawMesh { attributes: Attributes::default(), ..merge_placed_meshes(&placed, |_| false) };
    mesh.double = is_far_from_origin(&mesh.positions);
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use base64::Engine;

    use super::*;

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
    fn what_comes_before_gltf_2_is_refused_by_its_version() {
        for version in ["\"1.0\"", "\"0.8\"", "1.0", "\"1\""] {
            let old = format!(r#"{{"asset": {{"version": {version}}}, "meshes": {{"a": {{"primitives": []}}}}}}"#);
            let error = parse(&old).unwrap_err().to_string();
            assert!(error.starts_with(&format!("glTF {} cannot be read", version.replace('"', ""))), "{error}");
        }
        let refused = |bytes: &[u8]| read(bytes, &|_| Err(ReadError::file("fetched", ""))).unwrap_err().to_string();
        assert!(refused(b"glTF\x01\0\0\0\0\0\0\0").starts_with("glTF 1.0 cannot be read"));
        assert!(refused(b"glTF\x07\0\0\0\0\0\0\0").contains("version 7 of glTF"));
    }

    #[cfg(feature = "meshopt")]
    #[test]
    fn a_buffer_that_compressed_views_alone_name_needs_no_bytes() {
        let positions = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|p| p.map(f32::to_bits));
        let bytes = meshopt::encode_vertex_buffer(&positions).unwrap();
        let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
        for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
            let view = format!(
                r#"{{"buffer": 1, "byteLength": 36, "extensions": {{"{name}": {{"buffer": 0, "byteLength": {}, "byteStride": 12,
                "count": 3, "mode": "ATTRIBUTES"}}}}}}"#,
                bytes.len()
            );
            let text = |more: &str| {
                format!(
                    r#"{{"buffers": [{{"byteLength": {}, "uri": "data:application/octet-stream;base64,{data}"}}, {{"byteLength": 36}}],
                    "bufferViews": [{view}{more}], "extensionsRequired": ["{name}"], "nodes": [{{"mesh": 0}}],
                    "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
                    "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}]}}"#,
                    bytes.len()
                )
            };
            assert_eq!(parse(&text("")).unwrap().positions[1], [1.0, 0.0, 0.0]);
            let plain = parse(&text(r#", {"buffer": 1, "byteLength": 36}"#)).unwrap_err();
            assert_eq!(plain.what, "a buffer without bytes");
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
                format!(r#"{MESH}"nodes": [{{"mesh": 0}}], "extensionsRequired": ["EXT_mesh_gpu_instancing"]"#),
                "needs the extension EXT_mesh_gpu_instancing",
            ),
            (
                ACCESSORS.replace("\"count\": 3", "\"count\": 4000000000") + MESH + r#""nodes": [{"mesh": 0}]"#,
                "accessor 0 with 4000000000 VEC3 of type 5126 cannot be used here",
            ),
            (
                ACCESSORS.replace("\"count\": 3", "\"count\": 4") + MESH + r#""nodes": [{"mesh": 0}]"#,
                "buffer view 0 has no room for 4 elements",
            ),
            ("\"nodes\": 7".into(), "the JSON is malformed or not glTF"),
        ] {
            let error = parse(&asset(&rest)).unwrap_err().to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
        let error = parse(r#"{"buffers": [{"uri": "../x.bin"}]}"#).unwrap_err();
        assert_eq!(error.what, "asked for ../x.bin");
        for other in ["", "gl", "<html>", "version https://git-lfs.github.com/spec/v1"] {
            let error = parse(other).unwrap_err().to_string();
            assert!(error.contains("neither glTF nor GLB"), "{error}");
        }
    }

    #[test]
    fn instances_cannot_fill_the_memory() {
        let nodes = (0..3_000).map(|_| r#"{"mesh": 0}"#).collect::<Vec<_>>().join(",");
        let zeros = r#""accessors": [{"componentType": 5126, "count": 100000, "type": "VEC3"}],"#;
        let mesh = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],"#;
        let error = parse(&asset(&format!(r#"{zeros}{mesh}"nodes": [{nodes}]"#))).unwrap_err();
        assert!(
            error.to_string().contains("cannot be used here")
                || error.to_string().contains("repeats its meshes too often"),
            "{error}"
        );
    }
}
