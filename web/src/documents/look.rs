//! A file as a viewer draws it: all meshes of a scene as one surface.

use neural_mesh::io::{self, Asset, Folder};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{
    Attributes, BaseTexture, Channel, Finish, Look, Looks, RawMesh, Role, TriMesh, Wrap, linear_light,
};
use neural_mesh::picture::toward_eye;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::arrays::SplitVertices;
use super::file::File;
use crate::message::{Answer, Message};
use crate::refusal::Refusal;

#[derive(Deserialize)]
struct LookRequest {
    file: File,
}

/// Answers with the arrays to draw, and notes on what cannot be drawn.
pub fn describe_surface(message: &Message, json: Value, answer: &mut Answer) -> Result<Value, Refusal> {
    let LookRequest { file } = serde_json::from_value(json)?;
    let (bytes, folder) = file.open(message)?;
    let (raw, looks, notes) = read_scene(bytes, &file.name, &folder).map_err(|error| file.refusal(error))?;
    let cleaned = clean(raw, &CleanOptions::default()).map_err(|error| file.refusal(error))?;
    let (mesh, attributes) = sort_by_group(cleaned.mesh, cleaned.attributes);
    let mut arrays = add_arrays(&mesh, &attributes, &looks, answer);
    arrays.insert("origin".into(), json!(cleaned.frame.origin));
    arrays.insert("eye".into(), json!(toward_eye(&mesh)));
    Ok(json!({ "mesh": arrays, "notes": notes }))
}

/// Reads a mesh, or the scene of a glTF, and the looks of its groups.
pub fn read_scene(bytes: &[u8], name: &str, folder: &Folder) -> Result<(RawMesh, Looks, Vec<String>), io::ReadError> {
    if io::is_gltf(bytes) {
        let asset = Asset::from_bytes_in(bytes, folder)?;
        let meshes: Vec<RawMesh> = asset.parts().iter().map(|part| part.mesh.clone()).collect();
        let scene = asset.scene_mesh(&meshes)?;
        let (looks, missing) = asset.scene_looks();
        return Ok((scene, looks, missing));
    }
    let read = io::read_attributed_in(bytes, name, folder)?;
    let (looks, missing) = io::read_looks(&read.extra, false);
    Ok((read.mesh, looks, missing))
}

fn sort_by_group(mesh: TriMesh, attributes: Attributes) -> (TriMesh, Attributes) {
    let mut order: Vec<u32> = (0..mesh.faces().len() as u32).collect();
    order.sort_by_key(|&face| attributes.group(face));
    let faces = order.iter().map(|&face| mesh.faces()[face as usize]).collect();
    let ordered = TriMesh::new(mesh.positions().to_vec(), faces).ok().zip(attributes.clone().select_faces(&order));
    ordered.unwrap_or((mesh, attributes))
}

fn add_arrays(mesh: &TriMesh, attributes: &Attributes, looks: &Looks, answer: &mut Answer) -> Map<String, Value> {
    let split = SplitVertices::new(mesh, attributes);
    let mut arrays = Map::new();
    let positions = split.of_vertices(mesh.positions()).copied().flatten();
    arrays.insert("positions".into(), json!(answer.add_numbers(positions, f32::to_le_bytes)));
    if let Some(normals) = attributes.channel(Role::Normal) {
        arrays.insert("normals".into(), json!(answer.add_numbers(split.of_wedges(normals), f32::to_le_bytes)));
    }
    if let Some(uv) = attributes.channel(Role::Uv).filter(|uv| uv.width == 2) {
        // Texture coordinates count v upwards, images count it downwards.
        let values: Vec<f32> = split.of_wedges(uv).collect();
        let down = |(at, v): (usize, f32)| if looks.v_is_up && at % 2 == 1 { 1.0 - v } else { v };
        let values = values.into_iter().enumerate().map(down);
        arrays.insert("uv".into(), json!(answer.add_numbers(values, f32::to_le_bytes)));
    }
    if let Some(colors) = attributes.channel(Role::Colour) {
        let linear = |x: f32| if looks.linear_colours { x } else { linear_light(x) };
        let colors = colors_of(&split, colors).flat_map(|[r, g, b, a]| [linear(r), linear(g), linear(b), a]);
        arrays.insert("colors".into(), json!(answer.add_numbers(colors, f32::to_le_bytes)));
    }
    arrays.insert("faces".into(), json!(answer.add_numbers(split.faces.iter().copied().flatten(), u32::to_le_bytes)));
    arrays.insert("groups".into(), add_groups(mesh, attributes, looks, answer));
    arrays
}

fn colors_of(split: &SplitVertices, channel: &Channel) -> impl Iterator<Item = [f32; 4]> {
    let values: Vec<f32> = split.of_wedges(channel).collect();
    let component = |values: &[f32], k: usize| values.get(k).copied().unwrap_or(1.0);
    let colors: Vec<[f32; 4]> =
        values.chunks(channel.width.max(1)).map(|it| [0, 1, 2, 3].map(|k| component(it, k))).collect();
    colors.into_iter()
}

fn wrap_name(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "repeat",
        Wrap::Mirror => "mirror",
        Wrap::Clamp => "clamp",
    }
}

/// Describes each group: first face, number of faces, colour, texture and finish.
fn add_groups(mesh: &TriMesh, attributes: &Attributes, looks: &Looks, answer: &mut Answer) -> Value {
    let mut known: Vec<(*const u8, usize)> = Vec::new();
    let mut add_image = |texture: &BaseTexture| {
        let from = texture.image.as_ptr();
        known.iter().find(|(bytes, _)| *bytes == from).map(|(_, part)| *part).unwrap_or_else(|| {
            let part = answer.add(texture.image.to_vec());
            known.push((from, part));
            part
        })
    };
    let mut from = 0;
    let numbers: Vec<u32> = (0..mesh.faces().len() as u32).map(|face| attributes.group(face)).collect();
    let runs: Vec<(u32, usize)> = numbers.chunk_by(|x, y| x == y).map(|run| (run[0], run.len())).collect();
    let mut group = |(number, n_faces): (u32, usize)| {
        let white = Look::default();
        let look = looks.of_groups.get(number as usize).unwrap_or(&white);
        let image = look.texture.as_ref().map(&mut add_image);
        let [r, g, b] = look.colour;
        let wrap = look.main_texture().map(|texture| texture.wrap.map(wrap_name));
        let mut group =
            json!({ "from": from, "faces": n_faces, "color": [r, g, b, 1.0], "image": image, "wrap": wrap });
        if let Some(finish) = describe_finish(look, &mut add_image) {
            group["finish"] = finish;
        }
        from += n_faces;
        group
    };
    runs.into_iter().map(&mut group).collect()
}

/// Describes the factors and maps of a material; `None` if it is only a colour.
fn describe_finish(look: &Look, add_image: &mut impl FnMut(&BaseTexture) -> usize) -> Option<Value> {
    let Finish { emission, roughness, metal, normal_scale, occlusion, .. } = &look.finish;
    if look.finish.is_matte() {
        return None;
    }
    let maps: Map<String, Value> = look.drawn_maps().map(|(name, map)| (name.into(), add_image(map).into())).collect();
    Some(json!({ "emission": emission, "roughness": roughness, "metal": metal, "normalScale": normal_scale,
        "occlusion": occlusion, "maps": maps }))
}
