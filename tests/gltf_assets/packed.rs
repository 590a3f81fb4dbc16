//! Quantized and compressed glTF: values come back within one step.

use neural_mesh::io::{Asset, Format, PackOptions, SceneOptions, SimplifiedPart};
use neural_mesh::mesh::{RawMesh, Role};
use serde_json::json;

use super::builder::*;
use super::{morphed_square, skinned_squares};

// Builds a wave of 12 x 12 squares with all attributes, in a node that is turned and scaled.
fn wave() -> Builder {
    let mut asset = Builder::new();
    let grid_point = |i: usize| [(i % 13) as f32 / 12.0, (i / 13) as f32 / 12.0];
    let rows: Vec<[f32; 2]> = (0..169).map(grid_point).collect();
    let position = asset.positions(&rows.iter().map(|[u, v]| [*u, *v, 0.2 * (6.0 * u).sin()]).collect::<Vec<_>>());
    let unit = |x: f32, y: f32, z: f32| (glam::Vec3::new(x, y, z).normalize()).to_array();
    let normal = asset.floats(&rows.iter().map(|[u, v]| unit(u - 0.5, v - 0.3, 0.4)).collect::<Vec<_>>());
    let tangents = rows.iter().map(|[u, v]| glam::Vec3::from(unit(1.0, *u, -*v)).extend(-1.0).to_array());
    let tangent = asset.floats(&tangents.collect::<Vec<_>>());
    let uv = asset.floats(&rows.iter().map(|[u, v]| [3.0 * u - 1.0, 0.5 * v + 0.25]).collect::<Vec<_>>());
    let plain = asset.floats(&rows);
    let colour = asset.floats(&rows.iter().map(|[u, v]| [*u, *v, 1.0 - u]).collect::<Vec<_>>());
    let own = asset.floats(&rows.iter().map(|[u, v]| [u + 7.0 * v]).collect::<Vec<_>>());
    let corners = (0..144u16).flat_map(|i| {
        let a = i / 12 * 13 + i % 12;
        [a, a + 1, a + 14, a, a + 14, a + 13]
    });
    let indices = asset.indices(&corners.collect::<Vec<_>>());
    asset.mesh(json!([{"material": 0, "indices": indices, "attributes": {"POSITION": position, "NORMAL": normal,
        "TANGENT": tangent, "TEXCOORD_0": uv, "TEXCOORD_1": plain, "COLOR_0": colour, "_OWN": own}}]));
    let image = asset.view(b"\x89PNG, or nearly");
    asset.push("images", json!({"bufferView": image, "mimeType": "image/png"}));
    asset.push("textures", json!({"source": 0}));
    let moved = json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 1]}}});
    asset.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": moved}, "normalTexture": moved}));
    asset.document["extensionsUsed"] = json!(["KHR_texture_transform"]);
    asset.document["nodes"] = json!([{"mesh": 0, "name": "node", "rotation": [0, 0.6, 0, 0.8], "scale": [4, 5, 6], "translation": [1, 2, 3]}]);
    asset
}

// Returns the unchanged asset, packed and opened again.
fn pack_and_reopen(name: &str, asset: &Asset, compress: bool) -> Asset {
    let parts = unchanged_parts(asset);
    let (packing, notes) = asset.packing(&[&parts], &PackOptions { bits: 14, compress });
    assert!(notes.is_empty(), "{notes:?}");
    let file = if compress { "compressed.glb" } else { "quantized.glb" };
    let mut options = SceneOptions::new(Format::Glb, file);
    options.packing = Some(&packing);
    let files = asset.write_scene(&[&parts], &options).unwrap();
    keep(name, &files);
    reopen(&files)
}

fn ways() -> &'static [bool] {
    if cfg!(feature = "meshopt") { &[false, true] } else { &[false] }
}

// Returns the scene as one mesh.
fn scene(asset: &Asset) -> RawMesh {
    asset.scene_mesh(&asset.parts().iter().map(|part| part.mesh.clone()).collect::<Vec<_>>()).unwrap()
}

// Returns the position of each corner, with the corner's wedge.
fn corners(mesh: &RawMesh) -> Vec<([f64; 3], u32)> {
    let rows = mesh.faces.iter().flatten().zip(mesh.attributes.wedges.iter().flatten());
    rows.map(|(&v, &wedge)| (mesh.positions[v as usize], wedge)).collect()
}

fn farthest(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn everything_comes_back_within_its_step() {
    let bytes = wave().glb();
    let before = open(&bytes);
    let plain = scene(&before);
    keep("packed_wave", &[neural_mesh::io::OutputFile { path: "input.glb".into(), bytes: bytes.clone() }]);
    for &compress in ways() {
        let after = pack_and_reopen("packed_wave", &before, compress);
        let mesh = scene(&after);
        assert_eq!(mesh.faces.len(), plain.faces.len());
        let step = 6.0 / 16_383.0;
        let (old, new) = (corners(&plain), corners(&mesh));
        for (position, wedge) in new {
            let distance = |at: &[f64; 3]| glam::DVec3::from(*at).distance(position.into());
            let (at, from) = old.iter().min_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0))).unwrap();
            assert!(distance(at) <= 0.87 * step, "{}", distance(at) / step);
            for channel in &plain.attributes.channels {
                let other = mesh.attributes.channels.iter().find(|other| other.name == channel.name).unwrap();
                let most = match (channel.role, channel.name.as_str()) {
                    (Role::Normal | Role::Tangent, _) => 0.02,
                    // The texture coordinates are three wide and drawn twice as large: 14 bits.
                    (_, "TEXCOORD_0") => 6.0 / 16_383.0,
                    (_, "TEXCOORD_1") => 1.0 / 65_535.0,
                    (Role::Colour, _) => 0.5001 / 255.0,
                    _ => 0.0,
                };
                let off = farthest(channel.value(*from), other.value(wedge));
                assert!(off <= most, "{}: {off}", channel.name);
            }
        }
    }
}

#[test]
fn nodes_and_materials_undo_the_grids_and_say_so() {
    let after = pack_and_reopen("packed_wave", &open(&wave().glb()), false);
    let files = after.write(&unchanged_parts(&after), Format::Glb, "again.glb").unwrap();
    let said = document(&files[0].bytes);
    assert_eq!((&said["nodes"][0]["name"], &said["nodes"][0]["scale"]), (&"node".into(), &json!([4, 5, 6])));
    assert_eq!(said["nodes"][0]["children"], json!([1]));
    assert_eq!(said["extensionsRequired"], json!(["KHR_texture_transform"]));
}

#[test]
fn poses_of_a_packed_skin_are_those_of_the_skin() {
    for &compress in ways() {
        let before = open(&skinned_squares().glb());
        let after = pack_and_reopen("packed_skin", &before, compress);
        let size = |asset: &Asset| asset.parts()[0].mesh.diagonal();
        let unit = size(&before) / size(&after);
        let (old, new) = (before.poses().unwrap(), after.poses().unwrap());
        for (old, new) in old[0].iter().zip(&new[0]) {
            // Vertices may be in another order.
            for row in new.values.chunks_exact(3) {
                let row: Vec<f32> = row.iter().map(|x| (f64::from(*x) * unit) as f32).collect();
                assert!(old.values.chunks_exact(3).any(|old| farthest(old, &row) < 0.01), "{row:?} {:?}", old.values);
            }
        }
        assert_eq!((new.len(), new[0].len()), (1, 12));
    }
}

#[test]
fn targets_move_as_they_did() {
    for &compress in ways() {
        let before = open(&morphed_square().glb());
        let after = pack_and_reopen("packed_morph", &before, compress);
        let moves = |asset: &Asset| {
            let mesh = &asset.parts()[0].mesh;
            let unit = mesh.diagonal();
            let channels = mesh.attributes.channels.iter().filter(|channel| channel.role == Role::MorphPosition);
            channels
                .map(|it| it.values.iter().map(|x| f64::from(x.abs()) / unit).fold(0.0, f64::max))
                .collect::<Vec<_>>()
        };
        let (old, new) = (moves(&before), moves(&after));
        assert!(!old.is_empty() && old.len() == new.len());
        old.iter().zip(&new).for_each(|(old, new)| assert!((old - new).abs() < 1e-4, "{old} {new}"));
    }
}

#[test]
fn grids_are_as_fine_as_meshes_need_and_no_finer() {
    let bits_of = |apart: f32| {
        let mut asset = Builder::new();
        let position = asset.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0 - apart, apart]]);
        let indices = asset.indices(&[0, 1, 2, 0, 3, 1]);
        asset.mesh(json!([{"attributes": {"POSITION": position}, "indices": indices}]));
        let asset = open(&asset.glb());
        let parts: Vec<SimplifiedPart> = unchanged_parts(&asset);
        let (packing, notes) = asset.packing(&[&parts], &PackOptions { bits: 14, compress: false });
        (packing.grid(0).map(|grid| (1.0 / grid.step).round() as u32), notes.len())
    };
    assert_eq!(bits_of(0.1), (Some(16_383), 0));
    assert_eq!(bits_of(1e-5), (Some(65_535), 0));
    assert_eq!(bits_of(1e-6), (None, 1));
}
