//! glTF assets in and out; `scripts/validate_gltf` checks the files that remain in the target folder.

mod any_bytes;
mod builder;
mod packed;

use builder::*;
use neural_mesh::io::{Asset, Format, OutputFile, SimplifiedPart};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{Channel, Role};
use serde_json::{Value, json};

fn channel<'a>(asset: &'a Asset, part: usize, name: &str) -> &'a Channel {
    asset.parts()[part].mesh.attributes.channels.iter().find(|channel| channel.name == name).unwrap()
}

// Builds two adjacent squares, bent by two joints, of which one turns.
fn skinned_squares() -> Builder {
    let mut asset = Builder::new();
    let positions: Vec<[f32; 3]> = (0..6).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
    let position = asset.positions(&positions);
    let normal = asset.floats(&[[0.0, 0.0, 1.0]; 6]);
    let joints: Vec<u8> = (0..6).flat_map(|_| [0, 1, 0, 0]).collect();
    let joints = asset.accessor(&joints, UNSIGNED_BYTE, "VEC4", 6);
    let weights = [[255, 0, 0, 0], [255, 0, 0, 0], [153, 102, 0, 0], [102, 153, 0, 0], [0, 255, 0, 0], [0, 255, 0, 0]];
    let weights = asset.accessor(weights.as_flattened(), UNSIGNED_BYTE, "VEC4", 6);
    asset.document["accessors"][weights]["normalized"] = true.into();
    let indices = asset.indices(&[0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5]);
    asset.mesh(json!([{
        "attributes": {"POSITION": position, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights},
        "indices": indices,
    }]));
    let bind: Vec<u8> = glam::Mat4::IDENTITY.to_cols_array().iter().flat_map(|x| x.to_le_bytes()).collect();
    let bind = asset.accessor(&bind.repeat(2), FLOAT, "MAT4", 2);
    let times = asset.floats(&[[0.0], [1.0]]);
    asset.bound(times, &[[0.0], [1.0]]);
    let turns = asset.floats(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.6, 0.8]]);
    asset.document["nodes"] = json!([
        {"mesh": 0, "skin": 0, "scale": [3, 3, 3]}, {"children": [2], "name": "hip"}, {"translation": [1, 0, 0], "name": "knee"}
    ]);
    asset.document["scenes"] = json!([{"nodes": [0, 1]}]);
    asset.push("skins", json!({"joints": [1, 2], "inverseBindMatrices": bind, "skeleton": 1}));
    asset.push(
        "animations",
        json!({"name": "kick", "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}],
            "samplers": [{"input": times, "output": turns}]}),
    );
    asset
}

#[test]
fn skins_and_animations() {
    let bytes = skinned_squares().glb();
    let asset = open(&bytes);
    assert_eq!(asset.parts()[0].scale, 1.0);
    let skin = channel(&asset, 0, "SKIN");
    assert_eq!((skin.role, skin.width, skin.value(2)), (Role::Skin, 8, &[0.0, 1.0, 0.0, 0.0, 0.6, 0.4, 0.0, 0.0][..]));
    let document = round_trip_mended("skinned", &bytes);
    let attributes = &document["meshes"][0]["primitives"][0]["attributes"];
    let component = |name: &str| &document["accessors"][attributes[name].as_u64().unwrap() as usize]["componentType"];
    assert_eq!((component("JOINTS_0"), component("WEIGHTS_0")), (&json!(UNSIGNED_BYTE), &json!(FLOAT)));
}

// Returns the edge from the fifth vertex to the sixth in each pose.
fn last_edges(asset: &Asset) -> Vec<[f32; 3]> {
    let poses = asset.poses().unwrap().remove(0);
    assert!(poses.iter().all(|pose| (pose.role, pose.width, pose.values.len()) == (Role::MorphPosition, 3, 18)));
    let edge = |pose: &Channel| std::array::from_fn(|i| [0.0, 1.0, 0.0][i] + pose.value(5)[i] - pose.value(4)[i]);
    poses.iter().map(edge).collect()
}

#[test]
fn poses_of_a_skin_are_those_of_its_animation_or_bent_at_random() {
    let mut asset = skinned_squares();
    let edges = last_edges(&open(&asset.glb()));
    assert_eq!(edges.len(), 12);
    for (k, [x, y, z]) in edges.into_iter().enumerate() {
        let share = (k as f32 + 0.5) / 12.0;
        // Halfway between two rotations, interpolation is along the chord.
        let turn = 2.0 * (0.6 * share).atan2(1.0 - share + 0.8 * share);
        assert!(((-x).atan2(y) - turn).abs() < 1e-4 && z.abs() < 1e-4, "{k}: {x} {y} {z}");
    }
    asset.document["animations"] = json!([]);
    let bent = open(&asset.glb());
    let edges = last_edges(&bent);
    assert!(edges.len() == 12 && edges.windows(2).all(|pair| pair[0] != pair[1]));
    assert_eq!(edges, last_edges(&bent));
    asset.document["skins"][0]["inverseBindMatrices"] = 99.into();
    let refused = open(&asset.glb()).poses().unwrap_err().to_string();
    assert!(refused.contains("accessor 99") && !refused.contains('\n'), "{refused}");
    // The nodes form a cycle.
    asset.document["nodes"][2]["children"] = json!([1]);
    asset.document["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    if let Ok(asset) = Asset::from_bytes(&asset.glb(), &refuse_uri) {
        assert_eq!(last_edges(&asset).len(), 12);
    }
}

// Writes an asset and its repaired form; the latter must come back as it is.
fn round_trip_mended(name: &str, bytes: &[u8]) -> Value {
    let asset = open(bytes);
    keep(name, &[OutputFile { path: "original.glb".into(), bytes: bytes.to_vec() }]);
    let files = asset.write(&unchanged_parts(&asset), Format::Glb, "mended.glb").unwrap();
    round_trip(name, &files[0].bytes)
}

#[test]
fn weights_are_mended() {
    let mut asset = skinned_squares();
    let weights =
        asset.floats(&[[0.0; 4], [0.2, 0.2, 0.0, 0.0], [2.0, 6.0, 0.0, 0.0], [f32::NAN; 4], [1.0; 4], [-1.0; 4]]);
    asset.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights.into();
    let bytes = asset.glb();
    assert!(open(&bytes).notes()[0].starts_with("4 values"));
    round_trip_mended("weights", &bytes);
    let asset = open(&bytes);
    let again = reopen(&asset.write(&unchanged_parts(&asset), Format::Glb, "mended.glb").unwrap());
    let skin = channel(&again, 0, "SKIN");
    for wedge in 0..6 {
        let weights = &skin.value(wedge)[4..];
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6 && weights.iter().all(|&w| w >= 0.0), "{weights:?}");
    }
}

// Builds a square with a dense and a sparse morph target, and an animation of their weights.
fn morphed_square() -> Builder {
    let mut asset = Builder::new();
    let position = asset.positions(&SQUARE);
    let normal = asset.floats(&[[0.0, 0.0, 1.0]; 4]);
    let dense = asset.positions(&[[0.0; 3], [0.0, 0.0, 1.0], [0.5, 0.0, 0.0], [0.0; 3]]);
    let normals = asset.floats(&[[0.0; 3], [0.1, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
    let (place, value) = (asset.view(&[3, 0]), asset.view(&[0.25f32, 0.5, 1.0].map(f32::to_le_bytes).concat()));
    let sparse = asset.push(
        "accessors",
        json!({"componentType": FLOAT, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [0.25, 0.5, 1.0],
            "sparse": {"count": 1, "indices": {"bufferView": place, "componentType": UNSIGNED_SHORT}, "values": {"bufferView": value}}}),
    );
    let indices = asset.indices(&SQUARE_FACES);
    asset.mesh(json!([{"attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices,
        "targets": [{"POSITION": dense, "NORMAL": normals}, {"POSITION": sparse}]}]));
    asset.document["meshes"][0]["weights"] = json!([0.5, 0.25]);
    asset.document["meshes"][0]["extras"] = json!({"targetNames": ["smile", "frown"]});
    let times = asset.floats(&[[0.0], [1.0]]);
    asset.bound(times, &[[0.0], [1.0]]);
    let weights = asset.floats(&[[0.0], [0.0], [1.0], [0.5]]);
    asset.push(
        "animations",
        json!({"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}], "samplers": [{"input": times, "output": weights}]}),
    );
    asset
}

#[test]
fn morph_targets() {
    let bytes = morphed_square().glb();
    let opened = open(&bytes);
    assert_eq!(channel(&opened, 0, "TARGET_1/POSITION").value(3), [0.25, 0.5, 1.0]);
    assert_eq!(channel(&opened, 0, "TARGET_0/NORMAL").role, Role::MorphDirection);
    let document = round_trip("morph_targets", &bytes);
    let targets = document["meshes"][0]["primitives"][0]["targets"].as_array().unwrap();
    assert_eq!(targets.len(), 2);
    assert!(document["accessors"][targets[1]["POSITION"].as_u64().unwrap() as usize].get("max").is_some());
}

// Builds two primitives over one set of vertices, and an instance twice as large.
fn two_materials() -> Builder {
    let mut asset = Builder::new();
    let position = asset.positions(&SQUARE);
    let uv = asset.floats(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let rgb = asset.floats(&[[0.25, 0.5, 1.0]; 4]);
    let rgba = asset.accessor(&[10, 20, 30, 255].repeat(4), UNSIGNED_BYTE, "VEC4", 4);
    asset.document["accessors"][rgba]["normalized"] = true.into();
    let (first, second) = (asset.indices(&SQUARE_FACES[..3]), asset.indices(&SQUARE_FACES[3..]));
    asset.mesh(json!([
        {"attributes": {"POSITION": position, "TEXCOORD_0": uv, "COLOR_0": rgb}, "indices": first, "material": 0},
        {"attributes": {"POSITION": position, "COLOR_0": rgba}, "indices": second, "material": 1, "mode": 4, "extras": 7},
    ]));
    asset.document["materials"] =
        json!([{"name": "wood", "pbrMetallicRoughness": {"metallicFactor": 0.0}}, {"name": "steel"}]);
    asset.document["nodes"] =
        json!([{"mesh": 0, "children": [1]}, {"mesh": 0, "scale": [2, 2, 2], "translation": [4, 0, 0]}]);
    asset
}

#[test]
fn two_materials_and_instances() {
    let bytes = two_materials().glb();
    let asset = open(&bytes);
    let part = &asset.parts()[0];
    assert_eq!((asset.parts().len(), part.scale.to_bits()), (1, 2f64.to_bits()));
    assert_eq!((part.mesh.positions.len(), part.mesh.attributes.groups.as_slice()), (4, &[0, 1][..]));
    assert_eq!(part.materials, ["wood", "steel"]);
    let colour = channel(&asset, 0, "COLOR_0");
    assert_eq!((colour.width, colour.value(0)), (4, &[0.25, 0.5, 1.0, 1.0][..]));
    let document = round_trip("two_materials", &bytes);
    let primitives = &document["meshes"][0]["primitives"];
    let colour = |primitive: usize| {
        let accessor = primitives[primitive]["attributes"]["COLOR_0"].as_u64().unwrap();
        (
            document["accessors"][accessor as usize]["type"].clone(),
            document["accessors"][accessor as usize]["componentType"].clone(),
        )
    };
    assert_eq!((colour(0), colour(1)), ((json!("VEC3"), json!(FLOAT)), (json!("VEC4"), json!(UNSIGNED_BYTE))));
    assert_eq!(primitives[1]["attributes"].get("TEXCOORD_0"), None);
    assert_eq!((&primitives[1]["material"], &primitives[1]["extras"]), (&json!(1), &json!(7)));
}

#[test]
fn primitives_without_faces_go_and_an_empty_mesh_draws_nothing() {
    let bytes = two_materials().glb();
    let asset = open(&bytes);
    let mut part = SimplifiedPart::from_part(&asset.parts()[0]);
    part.faces.remove(0);
    part.attributes = part.attributes.select_faces(&[1]).unwrap();
    let files = asset.write(&[part.clone()], Format::Glb, "one.glb").unwrap();
    keep("two_materials", &files);
    let document = document(&files[0].bytes);
    assert_eq!(document["meshes"][0]["primitives"].as_array().unwrap().len(), 1);
    assert_eq!(document["meshes"][0]["primitives"][0]["material"], 1);
    let again = reopen(&files);
    assert_eq!((again.parts()[0].mesh.faces.len(), again.parts()[0].mesh.positions.len()), (1, 3));
    part.faces.clear();
    part.attributes = part.attributes.select_faces(&[]).unwrap();
    let files = asset.write(&[part], Format::Glb, "none.glb").unwrap();
    keep("two_materials", &files);
    let again = reopen(&files);
    let mesh = &again.parts()[0].mesh;
    assert_eq!((mesh.faces.as_slice(), mesh.positions.len()), (&[[0; 3]][..], 1));
}

#[test]
fn lines_points_strips_fans_and_empty_primitives() {
    let mut asset = Builder::new();
    let position = asset.positions(&SQUARE);
    let (strip, fan) = (asset.indices(&[0, 1, 3, 2]), asset.indices(&[0, 1, 2, 3]));
    let (line, empty) = (asset.indices(&[0, 2]), asset.indices(&[0, 1]));
    let primitive =
        |mode: u32, indices: usize| json!({"attributes": {"POSITION": position}, "mode": mode, "indices": indices});
    asset.mesh(json!([primitive(1, line), primitive(5, strip), primitive(4, empty), primitive(6, fan), {"attributes": {"POSITION": position}, "mode": 0}]));
    asset.mesh(json!([primitive(0, line)]));
    asset.document["nodes"] = json!([{"mesh": 0}, {"mesh": 1}]);
    asset.document["scenes"] = json!([{"nodes": [0, 1]}]);
    let opened = open(&asset.glb());
    assert_eq!(opened.parts().len(), 1);
    let mesh = &opened.parts()[0].mesh;
    assert_eq!(mesh.faces, [[0, 1, 3], [3, 1, 2], [1, 2, 0], [2, 3, 0]]);
    assert_eq!(mesh.attributes.groups, [1, 1, 3, 3]);
    let files = opened.write(&unchanged_parts(&opened), Format::Glb, "lists.glb").unwrap();
    let document = document(&files[0].bytes);
    let modes: Vec<_> = document["meshes"][0]["primitives"].as_array().unwrap().iter().map(|it| &it["mode"]).collect();
    assert_eq!(modes, [&json!(1), &json!(4), &json!(4), &json!(0)]);
    assert_eq!(document["meshes"][1]["primitives"].as_array().unwrap().len(), 1);
    round_trip("lines_and_points", &files[0].bytes);
}

#[test]
fn quantized_attributes_become_floats() {
    let mut asset = Builder::new();
    let shorts = |rows: &[[i16; 4]]| rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let corners = [[0, 0, 0, 0], [32767, 0, 0, 0], [32767, 16384, 0, 0], [0, 16384, 0, 0]];
    let position = asset.accessor(&shorts(&corners), SHORT, "VEC3", 4);
    let normal = asset.accessor(&[0, 0, 127, 0].repeat(4), BYTE, "VEC3", 4);
    for (accessor, stride) in [(position, 8), (normal, 4)] {
        asset.document["accessors"][accessor]["normalized"] = true.into();
        asset.document["bufferViews"][accessor]["byteStride"] = stride.into();
        asset.document["bufferViews"][accessor]["target"] = 34962.into();
    }
    asset.bound(position, &[[0.0, 0.0, 0.0], [32767.0, 16384.0, 0.0]]);
    let uv = asset.accessor(&[0u16, 0, 9, 0, 9, 7, 0, 7].map(u16::to_le_bytes).concat(), UNSIGNED_SHORT, "VEC2", 4);
    asset.document["bufferViews"][uv]["target"] = 34962.into();
    let indices = asset.indices(&SQUARE_FACES);
    asset.mesh(json!([{"attributes": {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv}, "indices": indices}]));
    asset.document["nodes"] = json!([{"mesh": 0, "scale": [4, 4, 4]}]);
    for list in ["extensionsUsed", "extensionsRequired"] {
        asset.document[list] = json!(["KHR_mesh_quantization"]);
    }
    let bytes = asset.glb();
    let opened = open(&bytes);
    assert_eq!((opened.parts()[0].mesh.positions[1], opened.parts()[0].scale.round()), ([1.0, 0.0, 0.0], 4.0));
    assert_eq!(channel(&opened, 0, "TEXCOORD_0").value(2), [9.0, 7.0]);
    let document = round_trip("quantized", &bytes);
    assert_eq!((document.get("extensionsUsed"), document.get("extensionsRequired")), (None, None));
    assert!(
        document["accessors"]
            .as_array()
            .unwrap()
            .iter()
            .all(|it| it["type"] == "SCALAR" || it["componentType"] == FLOAT)
    );
    // Points stay quantized and still need the extension.
    asset.document["meshes"][0]["primitives"]
        .as_array_mut()
        .unwrap()
        .push(json!({"attributes": {"POSITION": position}, "mode": 0}));
    let document = round_trip("quantized_points", &asset.glb());
    assert_eq!(document["extensionsRequired"], json!(["KHR_mesh_quantization"]));
}

// Builds a square with compressed positions and indices; a second buffer serves readers that cannot decompress.
#[cfg(feature = "meshopt")]
fn compressed_asset(name: &str) -> Vec<u8> {
    let mut asset = Builder::new();
    let vertices = meshopt::encode_vertex_buffer(&SQUARE).unwrap();
    let faces = meshopt::encode_index_buffer(&SQUARE_FACES.map(u32::from), 4).unwrap();
    for (bytes, stride, count, mode, target) in
        [(vertices, 12, 4, "ATTRIBUTES", 34962), (faces, 2, 6, "TRIANGLES", 34963)]
    {
        let view = asset.view(&bytes);
        let compressed = &mut asset.document["bufferViews"][view];
        let (offset, length) = (compressed["byteOffset"].take(), compressed["byteLength"].take());
        let fallback = if mode == "ATTRIBUTES" { 0 } else { 48 };
        *compressed = json!({"buffer": 1, "byteOffset": fallback, "byteLength": stride * count, "target": target,
            "extensions": {name: {"buffer": 0, "byteOffset": offset, "byteLength": length, "byteStride": stride,
                "count": count, "mode": mode}}});
    }
    let bounded = json!({"bufferView": 0, "componentType": FLOAT, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]});
    asset.push("accessors", bounded);
    asset.push("accessors", json!({"bufferView": 1, "componentType": UNSIGNED_SHORT, "count": 6, "type": "SCALAR"}));
    asset.mesh(json!([{"attributes": {"POSITION": 0}, "indices": 1}]));
    for list in ["extensionsUsed", "extensionsRequired"] {
        asset.document[list] = json!([name]);
    }
    let length = asset.buffer.len();
    let fallback = json!({"byteLength": 60, "extensions": {name: {"fallback": true}}});
    asset.document["buffers"] = json!([{"byteLength": length}, fallback]);
    with_document(&asset, &asset.document)
}

#[cfg(feature = "meshopt")]
#[test]
fn compressed_buffers() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let bytes = compressed_asset(name);
        let document = round_trip(name, &bytes);
        assert_eq!(document.get("extensionsRequired"), None);
        assert_eq!(document["buffers"].as_array().unwrap().len(), 1);
        assert!(!document.to_string().contains("meshopt"));
        // The plain reader reads the same mesh.
        let mesh = neural_mesh::io::read(&bytes, None).unwrap();
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (4, 2));
    }
}

// Returns a GLB of another document over the buffer of an asset.
#[cfg(feature = "meshopt")]
fn with_document(asset: &Builder, document: &Value) -> Vec<u8> {
    let mut json = serde_json::to_vec(document).unwrap();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut buffer = asset.buffer.clone();
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let length = (28 + json.len() + buffer.len()) as u32;
    let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    [&b"glTF\x02\0\0\0"[..], &length.to_le_bytes(), &chunk(b"JSON", &json), &chunk(b"BIN\0", &buffer)].concat()
}

#[test]
fn indices_have_sixteen_bits_as_long_as_they_fit() {
    for (n_vertices, component) in [(65_535u32, UNSIGNED_SHORT), (65_536, UNSIGNED_INT)] {
        let mut asset = Builder::new();
        let positions: Vec<[f32; 3]> =
            (0..n_vertices).map(|i| [(i / 256) as f32, (i % 256) as f32, (i % 7) as f32]).collect();
        let position = asset.positions(&positions);
        let faces: Vec<u32> = (0..n_vertices - 2).flat_map(|i| [i, i + 1, i + 2]).collect();
        let bytes: Vec<u8> = faces.iter().flat_map(|index| index.to_le_bytes()).collect();
        let indices = asset.accessor(&bytes, UNSIGNED_INT, "SCALAR", faces.len());
        asset.mesh(json!([{"attributes": {"POSITION": position}, "indices": indices}]));
        let document = round_trip(&format!("vertices_{n_vertices}"), &asset.glb());
        let indices = document["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap() as usize;
        assert_eq!(document["accessors"][indices]["componentType"], component);
    }
}

#[test]
fn values_that_are_no_numbers() {
    let mut asset = Builder::new();
    let position = asset.positions(&SQUARE);
    let uv = asset.floats(&[[0.0, f32::NAN], [1.0, 0.0], [f32::INFINITY, 1.0], [0.0, 1.0]]);
    let other = asset.floats(&[[0.5, 0.5], [1.0, 0.0], [1.0, 1.0], [f32::NAN, f32::NAN]]);
    let normal = asset.floats(&[[0.0, 0.0, 0.0], [0.0, 0.0, 5.0], [f32::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let tangent = asset.floats(&[[0.0; 4], [1.0, 0.0, 0.0, 1.0], [3.0, 0.0, 0.0, -0.5], [0.0, 1.0, 0.0, 1.0]]);
    let colour = asset.floats(&[[2.0, -1.0, 0.5, 1.0]; 4]);
    let odd = asset.accessor(&[1, 0, 2, 0, 3, 0, 4, 0], UNSIGNED_SHORT, "SCALAR", 4);
    let indices = asset.indices(&SQUARE_FACES);
    asset.mesh(json!([{"indices": indices, "attributes": {
        "POSITION": position, "TEXCOORD_0": uv, "TEXCOORD_1": other, "NORMAL": normal, "TANGENT": tangent, "COLOR_0": colour, "_ODD": odd}}]));
    let bytes = asset.glb();
    assert!(open(&bytes).notes()[0].starts_with("5 values"), "{:?}", open(&bytes).notes());
    assert_eq!(
        (channel(&open(&bytes), 0, "_ODD").role, channel(&open(&bytes), 0, "_ODD").value(2)),
        (Role::Label, &[3.0][..])
    );
    let document = round_trip_mended("no_numbers", &bytes);
    let odd = document["meshes"][0]["primitives"][0]["attributes"]["_ODD"].as_u64().unwrap() as usize;
    assert_eq!(document["accessors"][odd]["componentType"], UNSIGNED_SHORT);
}

#[test]
fn images_beside_missing_outside_and_inside() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("asset");
    std::fs::create_dir_all(inner.join("my textures")).unwrap();
    std::fs::write(inner.join("my textures/a.png"), b"a picture").unwrap();
    std::fs::write(folder.path().join("secret.png"), b"a secret").unwrap();
    let mut asset = two_materials();
    let view = asset.view(b"\x89PNG\r\n\x1a\n");
    asset.document["images"] = json!([
        {"uri": "my%20textures/a.png", "name": "beside"}, {"uri": "missing.png"}, {"uri": "../secret.png"},
        {"uri": "%2e%2e/secret.png"}, {"uri": "..\\secret.png"}, {"uri": "/etc/hostname"}, {"uri": "file:///etc/hostname"},
        {"bufferView": view, "mimeType": "image/png"},
    ]);
    let path = inner.join("scene.glb");
    std::fs::write(&path, asset.glb()).unwrap();
    let opened = Asset::read_path(&path).unwrap();
    assert_eq!(opened.notes().len(), 6, "{:?}", opened.notes());
    for format in [Format::Glb, Format::Gltf] {
        let files = opened.write(&unchanged_parts(&opened), format, "out.x").unwrap();
        let names: Vec<_> = files.iter().map(|file| file.path.to_str().unwrap()).collect();
        let expected: &[&str] = if format == Format::Glb {
            &["out.x", "my textures/a.png"]
        } else {
            &["out.x", "out.bin", "my textures/a.png"]
        };
        assert_eq!(names, expected);
        let written = document(&files[0].bytes);
        assert_eq!(
            (&written["images"][0], &written["images"][2]),
            (&json!({"uri": "my%20textures/a.png", "name": "beside"}), &json!({"uri": "../secret.png"}))
        );
        let out = folder.path().join("out").join(format.name());
        std::fs::create_dir_all(&out).unwrap();
        neural_mesh::io::write_files(&out, &files, false).unwrap();
        assert_eq!(std::fs::read(out.join("my textures/a.png")).unwrap(), b"a picture");
        assert_eq!(Asset::read_path(&out.join("out.x")).unwrap().parts().len(), 1);
        let image = &written["images"][7]["bufferView"];
        assert_eq!(written["bufferViews"][image.as_u64().unwrap() as usize]["byteLength"], 8);
    }
}

#[test]
fn buffers_outside_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("asset");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("x.bin"), [0; 64]).unwrap();
    let mut asset = two_materials();
    for uri in ["../x.bin", "%2E%2E/x.bin", "..%5Cx.bin", "C:\\x.bin"] {
        asset.document["buffers"] = json!([{"uri": uri, "byteLength": 64}]);
        std::fs::write(inner.join("a.gltf"), asset.document.to_string()).unwrap();
        let error = Asset::read_path(&inner.join("a.gltf")).unwrap_err().to_string();
        assert!(error.contains("is outside the folder") && !error.contains('\n'), "{error}");
    }
}

#[test]
fn instances_by_extension_pass_through_and_count_for_the_scale() {
    let mut asset = two_materials();
    let (places, scales) = (asset.floats(&[[0.0; 3], [5.0, 0.0, 0.0]]), asset.floats(&[[1.0; 3], [3.0; 3]]));
    for accessor in [places, scales] {
        let view = asset.document["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        asset.document["bufferViews"][view].as_object_mut().unwrap().remove("target");
    }
    asset.document["nodes"][1]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places, "SCALE": scales}}});
    for list in ["extensionsUsed", "extensionsRequired"] {
        asset.document[list] = json!(["EXT_mesh_gpu_instancing"]);
    }
    let bytes = asset.glb();
    assert!((open(&bytes).parts()[0].scale - 6.0).abs() < 1e-12);
    let document = round_trip("instancing", &bytes);
    let places = &document["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"];
    assert_eq!(document["accessors"][places.as_u64().unwrap() as usize]["count"], 2);
}

#[test]
fn strange_extensions_keep_their_numbers() {
    let mut asset = two_materials();
    asset.document["extensionsUsed"] = json!(["ACME_physics"]);
    let shape = asset.floats(&[[1.0, 2.0, 3.0]]);
    asset.document["extensions"] = json!({"ACME_physics": {"hull": shape}});
    let bytes = asset.glb();
    let document = round_trip("strange", &bytes);
    assert_eq!(document["accessors"].as_array().unwrap()[..=shape].len(), shape + 1);
    let view = document["accessors"][shape]["bufferView"].as_u64().unwrap() as usize;
    assert_eq!(document["bufferViews"][view]["byteLength"], 12);
    // With known extensions only, views without use are removed.
    asset.document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    asset.document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    let lean = round_trip("known", &asset.glb());
    assert!(lean["bufferViews"].as_array().unwrap().len() < document["bufferViews"].as_array().unwrap().len());
}

#[test]
fn compressed_by_draco_is_read_from_a_plain_copy_or_refused_by_name() {
    let mut asset = two_materials();
    asset.document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    match Asset::from_bytes(&asset.glb(), &refuse_uri) {
        Ok(asset) => assert!(cfg!(feature = "draco") && asset.parts().len() == 1),
        Err(error) => assert!(
            error.to_string().contains("uses KHR_draco_mesh_compression, which this build cannot read"),
            "{error}"
        ),
    }
    // The asset is also rejected if the list is wrong and nothing else holds the positions.
    let mut alone = two_materials();
    alone.document["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    alone.document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let error = Asset::from_bytes(&alone.glb(), &refuse_uri).unwrap_err().to_string();
    assert!(error.contains("KHR_draco") || error.contains("compressed by Draco"), "{error}");
    // If Draco is only optional, its copy of the geometry is removed with the geometry.
    asset.document["extensionsRequired"] = json!([]);
    asset.document["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    let view = asset.view(b"draco");
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": view, "attributes": {"POSITION": 0}}});
    asset.document["meshes"][0]["primitives"][0]["extensions"] = draco;
    let opened = open(&asset.glb());
    let files = opened.write(&unchanged_parts(&opened), Format::Glb, "plain.glb").unwrap();
    assert!(!document(&files[0].bytes).to_string().contains("draco"));
}

#[test]
fn a_seam_is_welded_and_comes_back() {
    let mut asset = Builder::new();
    let corners = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[0], SQUARE[2], SQUARE[3]];
    let position = asset.positions(&corners);
    let uv = asset.floats(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 1.0], [0.0, 1.0]]);
    asset.mesh(json!([{"attributes": {"POSITION": position, "TEXCOORD_0": uv}}]));
    let opened = open(&asset.glb());
    let cleaned = clean(opened.parts()[0].mesh.clone(), &CleanOptions::default()).unwrap();
    assert_eq!(cleaned.mesh.positions().len(), 4);
    let (positions, faces) = cleaned.mesh.into_parts();
    let part = SimplifiedPart::new(positions, faces, cleaned.attributes);
    let files = opened.write(&[part], Format::Glb, "welded.glb").unwrap();
    keep("seam", &files);
    let again = reopen(&files);
    assert_eq!(corners_by_primitive(&again.parts()[0]), corners_by_primitive(&opened.parts()[0]));
    assert_eq!(again.parts()[0].mesh.positions.len(), 6);
}

#[test]
fn levels_of_detail_in_one_file() {
    for (name, asset) in [("levels_skinned", skinned_squares()), ("levels", two_materials())] {
        let opened = open(&asset.glb());
        let fine = unchanged_parts(&opened);
        let mut coarse = fine.clone();
        coarse[0].faces.truncate(1);
        coarse[0].attributes = coarse[0].attributes.clone().select_faces(&[0]).unwrap();
        let files = opened.write_levels(&[&fine, &coarse], &[0.5, 0.1], Format::Glb, "levels.glb").unwrap();
        keep(name, &files);
        let again = reopen(&files);
        let counts: Vec<usize> = again.parts().iter().map(|part| part.mesh.faces.len()).collect();
        assert_eq!(counts, [fine[0].faces.len(), 1], "{name}");
        // Readers without levels of detail draw only the finest level.
        let whole = neural_mesh::io::read(&files[0].bytes, None).unwrap();
        assert_eq!(whole.faces.len(), neural_mesh::io::read(&asset.glb(), None).unwrap().faces.len());
    }
    let opened = open(&two_materials().glb());
    let parts = unchanged_parts(&opened);
    for (levels, coverage) in
        [(&[][..], &[][..]), (&[&parts[..]][..], &[0.5, 0.1][..]), (&[&parts[..]][..], &[7.0][..])]
    {
        assert!(opened.write_levels(levels, coverage, Format::Glb, "x.glb").is_err());
    }
}

#[test]
fn parts_that_do_not_fit_are_refused_in_one_line() {
    let skinned = open(&skinned_squares().glb());
    let two = open(&two_materials().glb());
    let spoilt = |asset: &Asset, spoil: fn(&mut SimplifiedPart)| {
        let mut parts = unchanged_parts(asset);
        spoil(&mut parts[0]);
        asset.write(&parts, Format::Glb, "x.glb").unwrap_err().to_string()
    };
    for error in [
        skinned.write(&[], Format::Glb, "x.glb").unwrap_err().to_string(),
        skinned.write(&unchanged_parts(&skinned), Format::Ply, "x.ply").unwrap_err().to_string(),
        spoilt(&skinned, |part| part.faces[0][0] = 99),
        spoilt(&skinned, |part| part.positions[0][0] = f32::NAN),
        spoilt(&skinned, |part| part.attributes.wedges.truncate(1)),
        spoilt(&skinned, |part| part.attributes.channels.retain(|channel| channel.role != Role::Skin)),
        spoilt(&two, |part| part.attributes.groups[0] = 2),
        spoilt(&two, |part| part.attributes.groups.truncate(1)),
    ] {
        assert!(!error.is_empty() && !error.contains('\n'), "{error}");
    }
    let mut bare = unchanged_parts(&two);
    bare[0].attributes.channels.clear();
    bare[0].attributes.wedges.clear();
    let files = two.write(&bare, Format::Glb, "bare.glb").unwrap();
    assert!(reopen(&files).parts()[0].mesh.attributes.channels.is_empty());
}

#[test]
fn json_stays_one_file_where_it_was_one() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes/tiny/");
    for (name, n_files) in [("tetrahedron.gltf", 1), ("tetrahedron_apart.gltf", 2), ("tetrahedron.glb", 2)] {
        let asset = Asset::read_path(format!("{folder}{name}").as_ref()).unwrap();
        let files = asset.write(&unchanged_parts(&asset), Format::Gltf, "again.gltf").unwrap();
        keep(name, &files);
        assert_eq!(files.len(), n_files, "{name}");
        assert_eq!(corners_by_primitive(&reopen(&files).parts()[0]), corners_by_primitive(&asset.parts()[0]), "{name}");
    }
}
