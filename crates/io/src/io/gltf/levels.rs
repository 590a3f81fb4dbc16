//! Levels of detail: nodes `NAME_LOD0`, `NAME_LOD1` and so on under one node, or the extension `MSFT_lod`.
//! By the extension a node lists coarser nodes to draw in its place.

use serde_json::{Value, json};

use super::draft::Draft;
use super::empty_nodes::{INSTANCING, take_mesh};
use super::extensions::name_in;
use super::references::{index, list, list_mut};
use super::vrm;

const NAME: &str = "MSFT_lod";

/// Adds coarser meshes to every node whose mesh has all `levels`; without `coverage`, as siblings of the finest.
pub(super) fn add_levels(draft: &mut Draft, levels: &[Vec<(usize, Value)>], coverage: Option<&[f64]>) {
    if levels.is_empty() {
        return;
    }
    let n_nodes = list(&draft.document, "nodes").len();
    // Nodes that already have levels of detail keep them.
    let taken = nodes_of_levels(&draft.document);
    let mut offered = false;
    for node in (0..n_nodes).filter(|node| !taken.contains(node)) {
        let mesh = draft.document["nodes"][node].get("mesh").and_then(index);
        let meshes: Vec<Value> = levels.iter().filter_map(|level| replacement(level, mesh?)).collect();
        // Each level must have a replacement, or the order of levels would shift.
        if meshes.len() == levels.len() {
            // A coarser level would hide the children of its node.
            let has_children = draft.document["nodes"][node].get("children").is_some();
            let moves = coverage.is_none() || has_children;
            let finest = if moves { move_mesh_to_child(draft, node) } else { node };
            let ids: Vec<Value> =
                meshes.into_iter().enumerate().map(|(at, mesh)| push_node(draft, finest, at + 1, mesh)).collect();
            match coverage {
                Some(coverage) => list_levels(&mut draft.document["nodes"][finest], ids, coverage),
                None => name_siblings(draft, node, &[vec![finest.into()], ids].concat()),
            }
            offered = true;
        }
    }
    if offered {
        levels.iter().flatten().for_each(|(mesh, coarser)| vrm::repeat_mesh(&mut draft.document, *mesh, coarser));
        if coverage.is_some() {
            name_in(&mut draft.document, "extensionsUsed", NAME);
        }
    }
}

/// Puts levels under a node, named after it.
fn name_siblings(draft: &mut Draft, node: usize, levels: &[Value]) {
    let nodes = &mut draft.document["nodes"];
    let name = nodes[node].get("name").and_then(Value::as_str).map_or_else(|| format!("node{node}"), String::from);
    nodes[node]["name"] = name.clone().into();
    for (number, level) in levels.iter().filter_map(index).enumerate() {
        nodes[level]["name"] = format!("{name}_LOD{number}").into();
    }
    // The finest level is a child already.
    if let Some(children) = nodes[node]["children"].as_array_mut() {
        children.extend(levels.iter().skip(1).cloned());
    }
}

fn replacement(level: &[(usize, Value)], mesh: usize) -> Option<Value> {
    level.iter().find(|(replaced, _)| *replaced == mesh).map(|(_, by)| by.clone())
}

fn nodes_of_levels(document: &Value) -> Vec<usize> {
    let nodes = list(document, "nodes").iter().enumerate();
    let ids = |(at, node): (usize, &Value)| {
        let ids = node.get("extensions")?.get(NAME)?.get("ids")?.as_array()?;
        Some(ids.iter().filter_map(index).chain([at]).collect::<Vec<_>>())
    };
    nodes.filter_map(ids).flatten().collect()
}

pub(super) fn move_mesh_to_child(draft: &mut Draft, node: usize) -> usize {
    if !draft.document["nodes"][node].is_object() {
        return node;
    }
    let moved = take_mesh(&mut draft.document["nodes"][node]);
    let child = draft.push("nodes", moved.into());
    if let Some(members) = draft.document["nodes"][node].as_object_mut() {
        let children = members.entry("children").or_insert_with(|| json!([])).as_array_mut();
        children.into_iter().for_each(|children| children.push(child.clone()));
    }
    let at = index(&child).unwrap_or(node);
    // References and weight animations follow the mesh to its new node.
    vrm::move_mesh(&mut draft.document, node, at);
    update_channels(&mut draft.document, |channel| {
        if channel["target"]["path"] == "weights" && channel["target"]["node"] == node {
            channel["target"]["node"] = at.into();
        }
        None
    });
    at
}

/// Copies a node with its animations for another mesh.
fn push_node(draft: &mut Draft, node: usize, level: usize, mesh: Value) -> Value {
    let mut copy = draft.document["nodes"][node].clone();
    let Some(members) = copy.as_object_mut() else { return Value::Null };
    // A camera or light would otherwise be doubled.
    ["camera", "extras"].iter().for_each(|name| drop(members.shift_remove(*name)));
    let instances = members.shift_remove("extensions").and_then(|mut it| it.as_object_mut()?.shift_remove(INSTANCING));
    members.extend(instances.map(|instances| ("extensions".into(), json!({ INSTANCING: instances }))));
    if let Some(Value::String(name)) = members.get_mut("name") {
        name.push_str(&format!(" level {level}"));
    }
    members.insert("mesh".into(), mesh);
    let added = draft.push("nodes", copy);
    vrm::repeat_node(&mut draft.document, node, &added);
    update_channels(&mut draft.document, |channel| {
        (channel["target"]["node"] == node).then(|| {
            let mut twin = channel.clone();
            twin["target"]["node"] = added.clone();
            twin
        })
    });
    added
}

fn update_channels(document: &mut Value, mut show: impl FnMut(&mut Value) -> Option<Value>) {
    let animations = list_mut(document, "animations").iter_mut();
    for channels in animations.filter_map(|animation| animation.get_mut("channels")?.as_array_mut()) {
        let whole = channels.iter_mut().filter(|channel| channel["target"].is_object());
        let added: Vec<Value> = whole.filter_map(&mut show).collect();
        channels.extend(added);
    }
}

fn list_levels(node: &mut Value, ids: Vec<Value>, coverage: &[f64]) {
    if !node.get("extensions").is_some_and(Value::is_object) {
        node["extensions"] = json!({});
    }
    node["extensions"][NAME] = json!({"ids": ids});
    if !coverage.is_empty() && node.get("extras").is_none_or(Value::is_object) {
        node["extras"]["MSFT_screencoverage"] = coverage.to_vec().into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draft(nodes: Value) -> Draft<'static> {
        let channel = |node: usize, path: &str| json!({"sampler": 0, "target": {"node": node, "path": path}});
        let channels = json!([channel(0, "translation"), channel(0, "weights"), channel(1, "scale")]);
        Draft { document: json!({"nodes": nodes, "animations": [{"channels": channels}]}), views: Vec::new() }
    }

    fn targets(draft: &Draft) -> Vec<(u64, String)> {
        let channels = draft.document["animations"][0]["channels"].as_array().unwrap();
        let target = |channel: &Value| {
            (channel["target"]["node"].as_u64().unwrap(), channel["target"]["path"].as_str().unwrap().into())
        };
        channels.iter().map(target).collect()
    }

    #[test]
    fn coarser_nodes_stand_and_move_as_the_node_does() {
        let mut draft = draft(json!([{"name": "a", "mesh": 3, "scale": [2, 2, 2], "extras": {"x": 1}}, {"mesh": 4}]));
        add_levels(&mut draft, &[vec![(3, 7.into())], vec![(3, 8.into())]], Some(&[0.5, 0.2, 0.01]));
        let nodes = &draft.document["nodes"];
        assert_eq!(nodes[0]["extensions"], json!({"MSFT_lod": {"ids": [2, 3]}}));
        assert_eq!(nodes[0]["extras"], json!({"x": 1, "MSFT_screencoverage": [0.5, 0.2, 0.01]}));
        assert_eq!(nodes[2], json!({"name": "a level 1", "mesh": 7, "scale": [2, 2, 2]}));
        assert_eq!(nodes[1], json!({"mesh": 4}));
        let moved: Vec<u64> = targets(&draft).into_iter().map(|(node, _)| node).collect();
        assert_eq!(moved, [0, 0, 1, 2, 2, 3, 3]);
        assert_eq!(draft.document["extensionsUsed"], json!(["MSFT_lod"]));
    }

    #[test]
    fn children_are_not_replaced_with_their_parent() {
        let mut draft = draft(json!([{"mesh": 0, "skin": 1, "children": [1], "rotation": [0, 0, 0, 1]}, {}]));
        add_levels(&mut draft, &[vec![(0, 5.into())]], Some(&[]));
        let nodes = &draft.document["nodes"];
        assert_eq!(nodes[0], json!({"children": [1, 2], "rotation": [0, 0, 0, 1]}));
        assert_eq!(nodes[2], json!({"mesh": 0, "skin": 1, "extensions": {"MSFT_lod": {"ids": [3]}}}));
        assert_eq!(nodes[3], json!({"mesh": 5, "skin": 1}));
        let expected = [(0, "translation"), (2, "weights"), (1, "scale"), (3, "weights")];
        assert_eq!(targets(&draft), expected.map(|(node, path)| (node, path.to_string())));
    }

    #[test]
    fn sibling_levels_are_named_after_their_parent() {
        let instances = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 3}}});
        let mut draft = draft(json!([
            {"name": "a", "mesh": 3, "skin": 1, "scale": [2, 2, 2], "extensions": instances, "extras": {"x": 1}}, {"mesh": 4}
        ]));
        add_levels(&mut draft, &[vec![(3, 7.into())], vec![(3, 8.into())]], None);
        let nodes = &draft.document["nodes"];
        assert_eq!(nodes[0], json!({"name": "a", "scale": [2, 2, 2], "extras": {"x": 1}, "children": [2, 3, 4]}));
        for (level, mesh) in [3, 7, 8].into_iter().enumerate() {
            let name = format!("a_LOD{level}");
            assert_eq!(nodes[2 + level], json!({"name": name, "mesh": mesh, "skin": 1, "extensions": instances}));
        }
        // Only the weights of morph targets move with the meshes.
        let moved = [(0, "translation"), (2, "weights"), (1, "scale"), (3, "weights"), (4, "weights")];
        assert_eq!(targets(&draft), moved.map(|(node, path)| (node, path.to_string())));
        assert_eq!(draft.document.get("extensionsUsed"), None);
    }

    #[test]
    fn instances_are_those_of_all_levels() {
        let instances = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 3}}});
        let mut draft = draft(json!([{"mesh": 3, "extensions": instances}, {}]));
        add_levels(&mut draft, &[vec![(3, 7.into())]], Some(&[]));
        assert_eq!(draft.document["nodes"][2], json!({"mesh": 7, "extensions": instances}));
    }

    #[test]
    fn nodes_with_levels_keep_those() {
        let nodes = json!([{"mesh": 0, "extensions": {"MSFT_lod": {"ids": [1]}}}, {"mesh": 1}]);
        let mut draft = draft(nodes.clone());
        add_levels(&mut draft, &[vec![(0, 5.into()), (1, 6.into())]], Some(&[]));
        assert_eq!(draft.document["nodes"], nodes);
    }
}
