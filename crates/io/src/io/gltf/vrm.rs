//! References of VRM avatars (extensions `VRM`, `VRMC_vrm`) to meshes and nodes.
//!
//! Expressions and first-person annotations refer to a mesh (0.x) or its node (1.0).

use serde_json::Value;

use super::references::{list, visit};
use crate::io::ImageUse;

const OF_NODES: [&str; 2] =
    ["extensions/VRMC_vrm/expressions/*/*/morphTargetBinds", "extensions/VRMC_vrm/firstPerson/meshAnnotations"];

const OF_MESHES: [&str; 2] =
    ["extensions/VRM/blendShapeMaster/blendShapeGroups/*/binds", "extensions/VRM/firstPerson/meshAnnotations"];

pub(super) fn is_vrm(document: &Value) -> bool {
    document.get("extensions").is_some_and(|all| all.get("VRM").is_some() || all.get("VRMC_vrm").is_some())
}

pub(super) fn move_mesh(document: &mut Value, from: usize, to: usize) {
    visit(document, &OF_NODES, &mut |list| {
        let elements = list.as_array_mut().into_iter().flatten();
        elements.filter(|element| element["node"] == from).for_each(|element| element["node"] = to.into());
    });
}

pub(super) fn repeat_node(document: &mut Value, node: usize, added: &Value) {
    visit(document, &OF_NODES, &mut |list| repeat(list, "node", &node.into(), added));
}

pub(super) fn repeat_mesh(document: &mut Value, mesh: usize, added: &Value) {
    visit(document, &OF_MESHES, &mut |list| repeat(list, "mesh", &mesh.into(), added));
}

fn repeat(list: &mut Value, name: &str, of: &Value, added: &Value) {
    let Some(list) = list.as_array_mut() else { return };
    let twin = |element: &Value| {
        let mut twin = element.clone();
        twin[name] = added.clone();
        twin
    };
    let twins: Vec<Value> = list.iter().filter(|element| element[name] == *of).map(twin).collect();
    list.extend(twins);
}

pub(super) fn textures(document: &Value) -> impl Iterator<Item = (&Value, ImageUse)> {
    let materials = list(&document["extensions"]["VRM"], "materialProperties").iter();
    let named = materials.filter_map(|material| material["textureProperties"].as_object()).flatten();
    named.map(|(name, texture)| (texture, texture_use(name)))
}

fn texture_use(name: &str) -> ImageUse {
    match name {
        "_BumpMap" => ImageUse::Normals,
        "_ReceiveShadowTexture" | "_ShadingGradeTexture" | "_OutlineWidthTexture" | "_UvAnimMaskTexture" => {
            ImageUse::Numbers
        }
        _ => ImageUse::Colours,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn expressions_follow_the_mesh_to_another_node() {
        let binds = json!([{"node": 1, "index": 0, "weight": 1.0}, {"node": 2, "index": 0, "weight": 1.0}]);
        let expressions = json!({"preset": {"happy": {"morphTargetBinds": binds}}});
        let annotations = json!([{"node": 1, "type": "both"}]);
        let vrm = json!({"expressions": expressions, "firstPerson": {"meshAnnotations": annotations}});
        let mut document = json!({"extensions": {"VRMC_vrm": vrm}});
        move_mesh(&mut document, 1, 7);
        repeat_node(&mut document, 7, &9.into());
        let vrm = &document["extensions"]["VRMC_vrm"];
        let nodes = |list: &Value| list.as_array().unwrap().iter().map(|it| it["node"].clone()).collect::<Vec<_>>();
        assert_eq!(nodes(&vrm["expressions"]["preset"]["happy"]["morphTargetBinds"]), [7, 2, 9]);
        assert_eq!(nodes(&vrm["firstPerson"]["meshAnnotations"]), [7, 9]);
    }

    #[test]
    fn blend_shapes_move_coarser_meshes_too() {
        let groups = json!([{"binds": [{"mesh": 3, "index": 1, "weight": 100}]}]);
        let mut document = json!({"extensions": {"VRM": {"blendShapeMaster": {"blendShapeGroups": groups}}}});
        repeat_mesh(&mut document, 3, &5.into());
        let binds = &document["extensions"]["VRM"]["blendShapeMaster"]["blendShapeGroups"][0]["binds"];
        assert_eq!(binds[1], json!({"mesh": 5, "index": 1, "weight": 100}));
    }
}
