//! Conversion between formats keeps attributes and materials.

use std::path::Path;

use glam::Vec3;
use neural_mesh::io::{
    self, Asset, Extra, Format, Model, ReadMesh, SimplifiedPart, WriteOptions, WrittenModel, read_attributed,
    read_attributed_path, write_attributed, write_gltf,
};
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{Attributes, Channel, Role, Wrap};
use neural_mesh::picture::{Image, encode_png};
use serde_json::Value;

// A roof of two quads: the first with texture and vertex colours, the second in one colour.
const ROOF: &str = "mtllib a.mtl\no roof\nv 0 0 0 1 0.5 0\nv 1 0 0 1 1 1\nv 1 1 1 0 0 0\nv 0 1 1 0.25 0.5 1\nv 0 2 0 1 1 1\n\
v 1 2 0 0 1 0\nvt 0 0\nvt 1 0\nvt 1 0.25\nvt 0 0.25\nvn 0 -0.6 0.8\nvn 0 0.6 0.8\nusemtl tiles\nf 1/1/1 2/2/1 3/3/1\n\
f 1/1/1 3/3/1 4/4/1\nusemtl tin\nf 4/1/2 3/2/2 6/3/2\nf 4/1/2 6/3/2 5/4/2\n";
const LIBRARY: &str = "newmtl tin\nKd 0.5 0.25 1\nnewmtl tiles\nKd 1 1 1\nmap_Kd -clamp on maps/tiles.png\n";

fn tiles() -> Vec<u8> {
    encode_png(&Image { width: 2, height: 2, rgba: [200, 80, 40, 255].repeat(4) })
}

fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

fn clean_read(read: ReadMesh) -> (Cleaned, Extra) {
    (clean(read.mesh, &CleanOptions::default()).unwrap(), read.extra)
}

fn write_model((cleaned, extra): &(Cleaned, Extra), format: Format) -> WrittenModel {
    let Cleaned { mesh, frame, attributes, .. } = cleaned;
    let model = Model::new(mesh, *frame, attributes, extra);
    write_attributed(&model, &WriteOptions::new(format, "out")).unwrap()
}

// Returns position and values in a role for each corner, sorted.
fn corner_values((cleaned, _): &(Cleaned, Extra), role: Role) -> Vec<Vec<f32>> {
    let Cleaned { mesh, attributes, .. } = cleaned;
    let channel = attributes.channel(role).unwrap();
    let corners = mesh.faces().as_flattened().iter().zip(attributes.wedges.as_flattened());
    let row = |(&v, &wedge): (&u32, &u32)| [&mesh.positions()[v as usize][..], channel.value(wedge)].concat();
    let mut rows: Vec<Vec<f32>> = corners.map(row).collect();
    rows.sort_by(|x, y| x.partial_cmp(y).unwrap());
    rows
}

#[track_caller]
fn assert_alike(x: &[Vec<f32>], y: &[Vec<f32>]) {
    assert_eq!(x.len(), y.len());
    let near = |(x, y): (&f32, &f32)| (x - y).abs() < 1e-5;
    assert!(x.iter().zip(y).all(|(x, y)| x.len() == y.len() && x.iter().zip(y).all(near)), "{x:?}\n{y:?}");
}

#[test]
fn from_obj_to_glb_and_back_with_materials_and_textures() {
    let tiles = tiles();
    let source = folder(&[("a.mtl", LIBRARY.as_bytes()), ("maps/tiles.png", &tiles), ("roof.obj", ROOF.as_bytes())]);
    let obj = clean_read(read_attributed_path(&source.path().join("roof.obj"), None).unwrap());
    let (before, _) = io::read_looks(&obj.1, false);
    let glb = write_model(&obj, Format::Glb);
    assert!(glb.companion_files.is_empty());
    let asset = Asset::from_bytes(&glb.bytes, &|_| panic!("all is inside")).unwrap();
    let of_parts = asset.looks().0;
    assert_eq!(&of_parts[0][0].texture.as_ref().unwrap().image[..], &tiles[..]);
    assert_eq!(of_parts[0][0].texture.as_ref().unwrap().wrap, [Wrap::Clamp; 2]);
    assert!((Vec3::from(of_parts[0][1].colour) - Vec3::from(before.of_groups[1].colour)).length() < 1e-6);

    let read = clean_read(read_attributed(&glb.bytes, None).unwrap());
    for role in [Role::Uv, Role::Normal, Role::Colour] {
        assert_alike(&corner_values(&read, role), &corner_values(&obj, role));
    }
    let again = write_model(&read, Format::Obj);
    let target = tempfile::tempdir().unwrap();
    io::write_files(target.path(), &again.companion_files, false).unwrap();
    std::fs::write(target.path().join("out.obj"), &again.bytes).unwrap();
    let names: Vec<_> = again.companion_files.iter().map(|file| file.path.to_str().unwrap()).collect();
    assert_eq!(names, ["out_0.png", "out.mtl"]);
    let back = clean_read(read_attributed_path(&target.path().join("out.obj"), None).unwrap());
    assert_eq!(back.1.materials(), ["tiles", "tin"]);
    let (after, notes) = io::read_looks(&back.1, false);
    assert!(notes.is_empty(), "{notes:?}");
    for (x, y) in before.of_groups.iter().zip(&after.of_groups) {
        assert_eq!(x.texture, y.texture);
        assert!((Vec3::from(x.colour) - Vec3::from(y.colour)).length() < 1e-5);
    }
    for role in [Role::Uv, Role::Normal, Role::Colour] {
        assert_alike(&corner_values(&back, role), &corner_values(&obj, role));
    }
}

#[test]
fn a_single_material_comes_along_with_its_texture() {
    let tiles = tiles();
    let one = ROOF.replace("usemtl tin\n", "");
    let source = folder(&[("a.mtl", LIBRARY.as_bytes()), ("maps/tiles.png", &tiles), ("roof.obj", one.as_bytes())]);
    let obj = clean_read(read_attributed_path(&source.path().join("roof.obj"), None).unwrap());
    let glb = write_model(&obj, Format::Glb);
    let asset = Asset::from_bytes(&glb.bytes, &|_| panic!("all is inside")).unwrap();
    assert_eq!(asset.parts()[0].materials, ["tiles"]);
    assert_eq!(&asset.looks().0[0][0].texture.as_ref().unwrap().image[..], &tiles[..]);
    // Without a material in the file, none is kept.
    let bare = folder(&[("roof.obj", one.replace("usemtl tiles\n", "").as_bytes())]);
    let bare = clean_read(read_attributed_path(&bare.path().join("roof.obj"), None).unwrap());
    let json = String::from_utf8(write_model(&bare, Format::Gltf).bytes).unwrap();
    assert!(serde_json::from_str::<Value>(&json).unwrap().get("materials").is_none());
}

#[test]
fn from_glb_to_ply_with_columns_and_textures() {
    let (tiles, library) = (tiles(), LIBRARY.replace("Kd 0.5 0.25 1", "map_Kd maps/tiles.png"));
    let source = folder(&[("a.mtl", library.as_bytes()), ("maps/tiles.png", &tiles), ("roof.obj", ROOF.as_bytes())]);
    let obj = clean_read(read_attributed_path(&source.path().join("roof.obj"), None).unwrap());
    let glb = clean_read(read_attributed(&write_model(&obj, Format::Glb).bytes, None).unwrap());
    let ply = write_model(&glb, Format::PlyAscii);
    let text = String::from_utf8(ply.bytes.clone()).unwrap();
    for line in ["comment TextureFile out_0.png", "property float nx", "property uchar red", "property int texnumber"] {
        assert!(text.lines().any(|found| found == line), "{line} is not in {text}");
    }
    assert_eq!((ply.companion_files.len(), &ply.companion_files[0].bytes), (1, &tiles));
    let back = clean_read(read_attributed(&ply.bytes, None).unwrap());
    assert_alike(&corner_values(&back, Role::Uv), &corner_values(&obj, Role::Uv));
    assert_alike(&corner_values(&back, Role::Normal), &corner_values(&obj, Role::Normal));
}

#[test]
fn normals_turn_with_their_node_and_a_mirrored_one_turns_its_faces() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::new(0.2, 1.0, 0.5)];
    let normal = corners[1].cross(corners[2]).normalize();
    let values = normal.to_array().repeat(3);
    let channels = vec![Channel { name: "n".into(), role: Role::Normal, width: 3, values }];
    let attributes = Attributes { wedges: vec![[0, 1, 2]], channels, groups: Vec::new() };
    let part = SimplifiedPart::new(corners.map(|p| p.to_array()).to_vec(), vec![[0, 1, 2]], attributes);
    let (bytes, _) = write_gltf(part, [0.0; 3], &[], Format::Gltf).unwrap();
    for scale in [[1.0, 3.0, 0.5], [-1.0, 2.0, 1.0]] {
        let mut document: Value = serde_json::from_slice(&bytes).unwrap();
        document["nodes"][0]["scale"] = scale.to_vec().into();
        document["nodes"][0]["rotation"] = vec![0.5, 0.5, -0.5, 0.5].into();
        let (cleaned, _) = clean_read(read_attributed(document.to_string().as_bytes(), Some(Format::Gltf)).unwrap());
        let [a, b, c] = cleaned.mesh.faces()[0].map(|v| Vec3::from(cleaned.mesh.positions()[v as usize]));
        let found = Vec3::from_slice(cleaned.attributes.channels[0].value(0));
        assert!(found.dot((b - a).cross(c - a).normalize()) > 0.9999, "{scale:?} {found}");
    }
}

#[test]
fn what_belongs_to_a_scene_is_said_to_stay_behind() {
    let channel =
        |name: &str, role, width: usize| Channel { name: name.into(), role, width, values: vec![0.5; 3 * width] };
    let channels = vec![channel("t", Role::Tangent, 4), channel("uv", Role::Uv, 2)];
    let attributes = Attributes { wedges: vec![[0, 1, 2]], channels, groups: Vec::new() };
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let part = SimplifiedPart::new(positions, vec![[0, 1, 2]], attributes);
    let (bytes, _) = write_gltf(part, [0.0; 3], &[], Format::Glb).unwrap();
    let read = read_attributed(&bytes, None).unwrap();
    assert_eq!(read.mesh.attributes.channels.len(), 1);
    assert!(read.notes.iter().any(|note| note.starts_with("tangents")), "{:?}", read.notes);
}

#[test]
fn a_texture_that_gltf_does_not_hold_is_said() {
    let source =
        folder(&[("a.mtl", LIBRARY.as_bytes()), ("maps/tiles.png", b"not a picture"), ("roof.obj", ROOF.as_bytes())]);
    let obj = clean_read(read_attributed_path(&source.path().join("roof.obj"), None).unwrap());
    let glb = write_model(&obj, Format::Glb);
    assert!(
        glb.notes.iter().any(|note| note.contains("PNG, JPEG, WebP or KTX2: a texture of tiles")),
        "{:?}",
        glb.notes
    );
    assert!(Asset::from_bytes(&glb.bytes, &|_| panic!()).unwrap().looks().0[0][0].texture.is_none());
}

#[test]
fn textures_beside_the_mesh_are_found_from_a_library_in_a_folder() {
    let source = folder(&[
        ("materials/a.mtl", b"newmtl tiles\nmap_Kd maps/tiles.png\nmap_Ks ../../secret.png\n"),
        ("maps/tiles.png", &tiles()),
        ("roof.obj", ROOF.replace("a.mtl", "materials/a.mtl").as_bytes()),
    ]);
    let obj = clean_read(read_attributed_path(&source.path().join("roof.obj"), None).unwrap());
    assert!(io::read_looks(&obj.1, false).0.of_groups[0].texture.is_some());
    let out = write_model(&obj, Format::Obj);
    let places: Vec<&Path> = out.companion_files.iter().map(|file| file.path.as_path()).collect();
    assert_eq!(places, [Path::new("maps/tiles.png"), Path::new("materials/a.mtl")]);
    assert!(out.notes.iter().any(|note| note.contains("secret.png") && note.contains("outside")), "{:?}", out.notes);
}

#[test]
fn a_packed_asset_is_opened() {
    let bytes = std::fs::read("tests/meshes/tiny/tetrahedron.glb").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb.gz");
    io::write_path(&path, &bytes, false).unwrap();
    assert_eq!(std::fs::read(&path).unwrap()[..2], [0x1f, 0x8b]);
    let asset = Asset::read_path(&path).unwrap();
    assert_eq!(asset.parts()[0].mesh.faces.len(), 4);
}
