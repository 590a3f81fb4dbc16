//! References to accessors and buffer views.

use serde_json::Value;

// Paths to indices of accessors; `*` means every element of an array or member of an object.
pub(super) const ACCESSORS: [&str; 7] = [
    "meshes/*/primitives/*/attributes/*",
    "meshes/*/primitives/*/indices",
    "meshes/*/primitives/*/targets/*/*",
    "animations/*/samplers/*/input",
    "animations/*/samplers/*/output",
    "skins/*/inverseBindMatrices",
    "nodes/*/extensions/EXT_mesh_gpu_instancing/attributes/*",
];

pub(super) const VIEWS_OF_ACCESSORS: [&str; 3] =
    ["accessors/*/bufferView", "accessors/*/sparse/indices/bufferView", "accessors/*/sparse/values/bufferView"];

pub(super) const OTHER_VIEWS: [&str; 5] = [
    "images/*/bufferView",
    "meshes/*/primitives/*/extensions/KHR_draco_mesh_compression/bufferView",
    "extensions/EXT_structural_metadata/propertyTables/*/properties/*/values",
    "extensions/EXT_structural_metadata/propertyTables/*/properties/*/arrayOffsets",
    "extensions/EXT_structural_metadata/propertyTables/*/properties/*/stringOffsets",
];

pub(super) fn visit(document: &mut Value, paths: &[&str], show: &mut dyn FnMut(&mut Value)) {
    paths.iter().for_each(|path| follow(document, path, show));
}

fn follow(value: &mut Value, path: &str, show: &mut dyn FnMut(&mut Value)) {
    if path.is_empty() {
        return show(value);
    }
    let (name, rest) = path.split_once('/').unwrap_or((path, ""));
    match value {
        Value::Array(values) if name == "*" => values.iter_mut().for_each(|value| follow(value, rest, show)),
        Value::Object(values) if name == "*" => values.values_mut().for_each(|value| follow(value, rest, show)),
        Value::Object(values) => {
            if let Some(value) = values.get_mut(name) {
                follow(value, rest, show);
            }
        }
        _ => {}
    }
}

pub(super) fn find_referenced(document: &mut Value, paths: &[&str], n: usize) -> Vec<bool> {
    let mut named = vec![false; n];
    visit(document, paths, &mut |value| {
        if let Some(mark) = index(value).and_then(|index| named.get_mut(index)) {
            *mark = true;
        }
    });
    named
}

/// Returns the elements of the member `name`; none without such a list.
pub(super) fn list<'a>(object: &'a Value, name: &str) -> &'a [Value] {
    object.get(name).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

pub(super) fn list_mut<'a>(object: &'a mut Value, name: &str) -> &'a mut [Value] {
    object.get_mut(name).and_then(Value::as_array_mut).map_or(&mut [], Vec::as_mut_slice)
}

pub(super) fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_place_is_found() {
        let mut document = json!({
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "targets": [{"POSITION": 3}, {"NORMAL": 4}]},
                {"attributes": {"POSITION": 0}},
            ]}],
            "animations": [{"samplers": [{"input": 5, "output": 6}]}],
            "skins": [{"inverseBindMatrices": 7}],
            "nodes": [{"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"SCALE": 8}}}}, {"mesh": 9}],
            "extras": {"meshes": 9},
        });
        let named = find_referenced(&mut document, &ACCESSORS, 10);
        assert_eq!(named, [true, true, true, true, true, true, true, true, true, false]);
    }
}
