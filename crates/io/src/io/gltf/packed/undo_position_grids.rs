//! Transforms that undo the grids of positions.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};
use serde_json::{Map, Value, json};

use crate::io::gltf::asset::Asset;
use crate::io::gltf::draft::Draft;
use crate::io::gltf::levels::move_mesh_to_child;
use crate::io::gltf::references::{index, list};
use crate::io::gltf::vrm::is_vrm;
use crate::mesh::PositionGrid;

pub(in crate::io::gltf) fn undo_position_grids(
    asset: &Asset,
    draft: &mut Draft,
    grids: &BTreeMap<usize, PositionGrid>,
) {
    let n_nodes = list(&draft.document, "nodes").len();
    let is_held = fixed_nodes(&draft.document, n_nodes);
    let mut of_skins = BTreeMap::new();
    for (node, is_held) in is_held.into_iter().enumerate() {
        let held = &draft.document["nodes"][node];
        let Some(grid) = held.get("mesh").and_then(index).and_then(|mesh| grids.get(&mesh)) else { continue };
        match held.get("skin").and_then(index) {
            Some(skin) => drop(of_skins.insert(skin, *grid)),
            None => {
                // A node that must not move passes its mesh to a child, which takes the grid.
                let node = if is_held { move_mesh_to_child(draft, node) } else { node };
                place_node(&mut draft.document["nodes"][node], grid);
            }
        }
    }
    // Broken files name skins that do not exist.
    of_skins.retain(|&skin, _| draft.document["skins"].get(skin).is_some_and(Value::is_object));
    of_skins.into_iter().for_each(|(skin, grid)| place_skin(asset, draft, skin, &grid));
}

// Names, children, extensions and references of a node rely on its transform.
fn fixed_nodes(document: &Value, n_nodes: usize) -> Vec<bool> {
    // The nodes of an avatar are bones even if unnamed.
    let mut is_held: Vec<bool> = vec![is_vrm(document); n_nodes];
    let holds = ["name", "children", "camera", "extensions", "extras"];
    for (node, mark) in list(document, "nodes").iter().zip(&mut is_held) {
        *mark |= holds.iter().any(|name| node.get(*name).is_some());
    }
    let lists = |name: &str| list(document, name).iter();
    let joints = lists("skins").flat_map(|skin| list(skin, "joints").iter());
    let channels = lists("animations").flat_map(|animation| list(animation, "channels").iter());
    let moved = channels.filter(|channel| channel["target"]["path"] != "weights").map(|it| &it["target"]["node"]);
    for node in joints.chain(moved).filter_map(index) {
        is_held.get_mut(node).into_iter().for_each(|mark| *mark = true);
    }
    is_held
}

fn place_node(node: &mut Value, grid: &PositionGrid) {
    let Some(node) = node.as_object_mut() else { return };
    // A node has a matrix or its components, never both.
    if let Some(matrix) = node.get("matrix").and_then(numbers::<16>) {
        let placed = DMat4::from_cols_array(&matrix) * transform(grid);
        node.insert("matrix".into(), placed.to_cols_array().to_vec().into());
        return;
    }
    let held = |node: &Map<String, Value>, name: &str| node.get(name).and_then(numbers::<3>);
    let (from, scale) = (held(node, "translation").unwrap_or_default(), held(node, "scale").unwrap_or([1.0; 3]));
    let turn = node.get("rotation").and_then(numbers::<4>).map(glam::DQuat::from_array);
    let turn = turn.filter(|turn| turn.length_squared() > 0.0).map_or(glam::DQuat::IDENTITY, glam::DQuat::normalize);
    let origin = DVec3::from(from) + turn * (DVec3::from(scale) * DVec3::from(grid.origin));
    let put = |node: &mut Map<String, Value>, name: &str, numbers: [f64; 3]| {
        node.insert(name.into(), numbers.to_vec().into());
    };
    put(node, "translation", origin.to_array());
    put(node, "scale", scale.map(|x| x * grid.step));
}

fn place_skin(asset: &Asset, draft: &mut Draft, skin: usize, grid: &PositionGrid) {
    let n = list(&draft.document["skins"][skin], "joints").len();
    let held = draft.document["skins"][skin].get("inverseBindMatrices").and_then(index);
    let read = held.and_then(|accessor| asset.container.data().floats(accessor, 16 * n.max(1)).ok());
    let values = read.filter(|(width, values)| *width == 16 && values.len() >= 16 * n).map(|(_, values)| values);
    // Skins without matrices have the identity for each joint.
    let identity = DMat4::IDENTITY.to_cols_array().map(|x| x as f32);
    let values = values.unwrap_or_else(|| identity.repeat(n));
    let placed = values.as_chunks::<16>().0.iter().flat_map(|matrix| {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from)) * transform(grid);
        matrix.to_cols_array().map(|x| (x as f32).to_le_bytes())
    });
    let bytes: Vec<u8> = placed.flatten().collect();
    let view = draft.push_view(json!({"buffer": 0, "byteLength": bytes.len()}), bytes);
    let accessor = json!({"bufferView": view, "componentType": 5126, "count": values.len() / 16, "type": "MAT4"});
    draft.document["skins"][skin]["inverseBindMatrices"] = draft.push("accessors", accessor);
}

fn transform(grid: &PositionGrid) -> DMat4 {
    DMat4::from_translation(grid.origin.into()) * DMat4::from_scale(DVec3::splat(grid.step))
}

fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let numbers: Vec<f64> = value.as_array()?.iter().filter_map(Value::as_f64).collect();
    numbers.try_into().ok()
}
