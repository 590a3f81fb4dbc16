//! Removal of meshes without faces, from their nodes and from the file.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

use super::extensions::take_extension;
use super::references::{index, list, list_mut};

const OF_MESH: [&str; 3] = ["mesh", "skin", "weights"];
/// Extension that draws a node's mesh several times.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

pub(super) fn remove_meshes(document: &mut Value, meshes: &[usize]) {
    let nodes = list_mut(document, "nodes").iter_mut().enumerate();
    let meshes: BTreeSet<usize> = meshes.iter().copied().collect();
    let mut emptied = BTreeSet::new();
    for (at, node) in nodes {
        // Only the mesh goes: children, cameras and names may be needed.
        let is_emptied = node.get("mesh").and_then(index).is_some_and(|mesh| meshes.contains(&mesh));
        if is_emptied {
            take_mesh(node);
            emptied.insert(at);
        }
    }
    drop_weight_channels(document, &emptied);
}

/// Takes the mesh out of a node with its skin, weights and instances, which are drawn where the mesh is.
pub(super) fn take_mesh(node: &mut Value) -> Map<String, Value> {
    let instances = take_extension(node, INSTANCING).map(|held| ("extensions".into(), json!({ INSTANCING: held })));
    let members = node.as_object_mut().into_iter();
    let of_mesh = members.flat_map(|members| OF_MESH.map(|name| Some((name.to_string(), members.shift_remove(name)?))));
    of_mesh.flatten().chain(instances).collect()
}

/// Extensions of a whole file that name no mesh by its number.
const WITHOUT_MESHES: [&str; 3] = ["KHR_lights_punctual", "KHR_materials_variants", "KHR_xmp_json_ld"];

/// Drops those of these meshes that no node has, and renumbers the others.
///
/// Keeps all where something else may name one, or where none would be left.
pub(super) fn drop_meshes(document: &mut Value, meshes: &[usize]) {
    let mut used = list(document, "extensionsUsed").iter();
    let points = used.any(|name| name == "KHR_animation_pointer");
    let mut of_file = document.get("extensions").and_then(Value::as_object).into_iter().flat_map(|it| it.keys());
    if points || of_file.any(|name| !WITHOUT_MESHES.contains(&name.as_str())) {
        return;
    }
    let n_meshes = list(document, "meshes").len();
    let nodes = list_mut(document, "nodes").iter_mut();
    let mut nodes: Vec<&mut Value> = nodes.filter_map(|node| node.get_mut("mesh")).collect();
    let used: BTreeSet<usize> = nodes.iter().filter_map(|mesh| index(mesh)).collect();
    let gone: BTreeSet<usize> = meshes.iter().copied().filter(|mesh| !used.contains(mesh)).collect();
    if gone.len() >= n_meshes {
        return;
    }
    for mesh in &mut nodes {
        if let Some(number) = index(mesh) {
            **mesh = (number - gone.range(..number).count()).into();
        }
    }
    let mut number = 0..;
    let Some(all) = document.get_mut("meshes").and_then(Value::as_array_mut) else { return };
    all.retain(|_| number.next().is_none_or(|mesh| !gone.contains(&mesh)));
}

fn drop_weight_channels(document: &mut Value, nodes: &BTreeSet<usize>) {
    let is_of_emptied = |channel: &Value| {
        let target = &channel["target"];
        target["path"] == "weights" && index(&target["node"]).is_some_and(|node| nodes.contains(&node))
    };
    let Some(animations) = document.get_mut("animations").and_then(Value::as_array_mut) else { return };
    animations.retain_mut(|animation| {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { return true };
        // An animation that had no channels before is kept.
        let n_before = channels.len();
        channels.retain(|channel| !is_of_emptied(channel));
        !channels.is_empty() || n_before == 0
    });
    if animations.is_empty() {
        document.as_object_mut().into_iter().for_each(|members| drop(members.shift_remove("animations")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_of_no_node_go_and_the_others_are_found_under_new_numbers() {
        let named = |name: &str| json!({"name": name, "primitives": []});
        let document = json!({
            "nodes": [{"mesh": 3}, {"name": "emptied"}, {"mesh": 1}, {"mesh": 3}],
            "meshes": [named("gone"), named("shared"), named("never used"), named("last")],
        });
        let mut dropped = document.clone();
        drop_meshes(&mut dropped, &[0, 1]);
        assert_eq!(dropped["meshes"], json!([named("shared"), named("never used"), named("last")]));
        assert_eq!(dropped["nodes"], json!([{"mesh": 2}, {"name": "emptied"}, {"mesh": 0}, {"mesh": 2}]));
        // An avatar names meshes in an extension of its own.
        let mut avatar = document.clone();
        avatar["extensions"] = json!({"VRM": {"firstPerson": {"meshAnnotations": [{"mesh": 3}]}}});
        let whole = avatar.clone();
        drop_meshes(&mut avatar, &[0]);
        assert_eq!(avatar, whole);
        let mut all = json!({"nodes": [{}], "meshes": [named("gone")]});
        drop_meshes(&mut all, &[0]);
        assert_eq!(all["meshes"], json!([named("gone")]));
    }

    #[test]
    fn what_hangs_on_an_emptied_node_stays() {
        let channel = |node: usize, path: &str| json!({"sampler": 0, "target": {"node": node, "path": path}});
        let mut document = json!({
            "nodes": [
                {"mesh": 1, "skin": 0, "weights": [1], "children": [1], "extensions": {INSTANCING: {}}},
                {"mesh": 0},
            ],
            "animations": [{"channels": [channel(0, "weights"), channel(0, "rotation")]}, {"channels": [channel(0, "weights")]}],
        });
        remove_meshes(&mut document, &[1]);
        assert_eq!(document["nodes"], json!([{"children": [1]}, {"mesh": 0}]));
        assert_eq!(document["animations"], json!([{"channels": [channel(0, "rotation")]}]));
        remove_meshes(&mut document, &[]);
        assert_eq!(document["animations"].as_array().map(Vec::len), Some(1));
    }
}
