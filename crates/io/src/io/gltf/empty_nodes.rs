//! Removal of meshes without faces from their nodes.

use std::collections::BTreeSet;

use serde_json::Value;

use super::references::index;

const OF_MESH: [&str; 3] = ["mesh", "skin", "weights"];
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

pub(super) fn remove_meshes(document: &mut Value, meshes: &[usize]) {
    let nodes = document.get_mut("nodes").and_then(Value::as_array_mut).into_iter().flatten().enumerate();
    let meshes: BTreeSet<usize> = meshes.iter().copied().collect();
    let mut emptied = BTreeSet::new();
    for (at, node) in nodes {
        // Only the mesh goes: children, cameras and names may be needed.
        let is_emptied = node.get("mesh").and_then(index).is_some_and(|mesh| meshes.contains(&mesh));
        let Some(members) = node.as_object_mut().filter(|_| is_emptied) else { continue };
        OF_MESH.iter().for_each(|name| drop(members.shift_remove(*name)));
        if let Some(Value::Object(extensions)) = members.get_mut("extensions") {
            extensions.shift_remove(INSTANCING);
            if extensions.is_empty() {
                members.shift_remove("extensions");
            }
        }
        emptied.insert(at);
    }
    drop_weight_channels(document, &emptied);
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
    use serde_json::json;

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
