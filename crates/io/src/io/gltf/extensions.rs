//! Extensions that refer to geometry or renumbered items.

use serde_json::{Value, json};

use super::references::{index, list, visit};

// Extensions of a primitive or mesh that describe its original faces.
const OF_FACES: [&str; 5] = [
    "CESIUM_primitive_outline",
    "EXT_mesh_manifold",
    "EXT_mesh_primitive_edge_visibility",
    "FB_ngon_encoding",
    "KHR_draco_mesh_compression",
];

pub(super) const KTX2_TEXTURE: &str = "KHR_texture_basisu";

const COMPRESSION: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

// Prefixes of extensions without references, or with references known to `references`.
const HARMLESS: [&str; 37] = [
    "ADOBE_materials_",
    "AGI_",
    "CESIUM_primitive_outline",
    "EXT_lights_image_based",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_manifold",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_",
    "FB_geometry_metadata",
    "FB_ngon_encoding",
    "GOOGLE_texture_basis",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_lights_punctual",
    "KHR_materials_",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_",
    "KHR_physics_rigid_bodies",
    "KHR_texture_",
    "KHR_xmp",
    "MOZ_",
    "MSFT_collision_primitives",
    "MSFT_lod",
    "MSFT_packing_",
    "MSFT_physics_rigid_bodies",
    "MSFT_texture_dds",
    "OMI_",
    "VRMC_",
    "VRM",
    "WEB3D_quantized_attributes",
    "EXT_primitive_voxels",
];

/// Names an extension as used and required.
pub(super) fn name_extension(document: &mut Value, name: &str) {
    ["extensionsUsed", "extensionsRequired"].into_iter().for_each(|list| name_in(document, list, name));
}

/// Names an extension in a list of the document.
pub(super) fn name_in(document: &mut Value, list: &str, name: &str) {
    let Some(document) = document.as_object_mut() else { return };
    let names = document.entry(list).or_insert_with(|| json!([])).as_array_mut();
    if let Some(names) = names.filter(|names| !names.iter().any(|known| known == name)) {
        names.push(name.into());
    }
}

pub(super) fn drop_face_extensions(object: &mut Value) {
    drop_extensions(object, &OF_FACES);
}

pub(super) fn drop_compression_extensions(document: &mut Value) {
    visit(document, &["bufferViews/*", "buffers/*"], &mut |value| drop_extensions(value, &COMPRESSION));
}

fn drop_extensions(object: &mut Value, names: &[&str]) {
    names.iter().for_each(|name| drop(take_extension(object, name)));
}

/// Removes an extension of an object, and the list of extensions with the last one; returns the extension.
pub(super) fn take_extension(object: &mut Value, name: &str) -> Option<Value> {
    let Some(Value::Object(extensions)) = object.get_mut("extensions") else { return None };
    let taken = extensions.shift_remove(name);
    if extensions.is_empty() {
        object.as_object_mut()?.shift_remove("extensions");
    }
    taken
}

/// Returns whether an unknown extension may refer to an accessor or view.
pub(super) fn may_name_indices(value: &Value) -> bool {
    let is_strange =
        |(name, held): (&String, &Value)| !HARMLESS.iter().any(|known| name.starts_with(known)) && holds_index(held);
    match value {
        Value::Array(values) => values.iter().any(may_name_indices),
        Value::Object(members) => members.iter().any(|(name, held)| match (name.as_str(), held) {
            // Applications define extras freely, so extras are not searched.
            ("extras", _) => false,
            ("extensions", Value::Object(extensions)) => {
                extensions.iter().any(is_strange) || extensions.values().any(may_name_indices)
            }
            _ => may_name_indices(held),
        }),
        _ => false,
    }
}

fn holds_index(value: &Value) -> bool {
    match value {
        Value::Array(values) => values.iter().any(holds_index),
        Value::Object(members) => members.values().any(holds_index),
        value => index(value).is_some(),
    }
}

pub(super) fn drop_unused_names(document: &mut Value) {
    // Quantisation is needed as long as any attribute uses it.
    let quantized = is_quantized(document);
    let unused: Vec<&str> = OF_FACES
        .into_iter()
        .chain(COMPRESSION)
        .chain([KTX2_TEXTURE])
        .filter(|name| !is_used(document, name))
        .chain((!quantized).then_some("KHR_mesh_quantization"))
        .collect();
    for list in ["extensionsUsed", "extensionsRequired"] {
        let Some(Value::Array(names)) = document.get_mut(list) else { continue };
        names.retain(|name| !name.as_str().is_some_and(|name| unused.contains(&name)));
        if names.is_empty() {
            document.as_object_mut().map(|document| document.shift_remove(list));
        }
    }
}

fn is_used(value: &Value, name: &str) -> bool {
    match value {
        Value::Array(values) => values.iter().any(|value| is_used(value, name)),
        Value::Object(members) => {
            members.get("extensions").is_some_and(|extensions| extensions.get(name).is_some())
                || members.values().any(|value| is_used(value, name))
        }
        _ => false,
    }
}

fn is_quantized(document: &mut Value) -> bool {
    let of_accessors = |accessor: &Value| (accessor["componentType"].as_u64(), accessor["normalized"] == true);
    let kinds: Vec<(Option<u64>, bool)> = list(document, "accessors").iter().map(of_accessors).collect();
    let mut found = false;
    let paths = ["meshes/*/primitives/*/attributes", "meshes/*/primitives/*/targets/*"];
    visit(document, &paths, &mut |attributes| {
        for (name, accessor) in attributes.as_object().into_iter().flatten() {
            let kind = index(accessor).and_then(|accessor| kinds.get(accessor)).copied();
            let (component, normalized) = kind.unwrap_or((Some(5126), false));
            found |= match name.as_str() {
                "POSITION" | "NORMAL" | "TANGENT" => component != Some(5126),
                _ if name.starts_with("TEXCOORD_") => {
                    component != Some(5126) && !(normalized && matches!(component, Some(5121 | 5123)))
                }
                _ => false,
            };
        }
    });
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_strange_extensions_with_indices_are_feared() {
        for (document, expected) in [
            (json!({"nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}]}), false),
            (json!({"nodes": [{"extensions": {"ACME_thing": {"light": 0}}}]}), true),
            (json!({"nodes": [{"extensions": {"ACME_thing": {"colour": [0.5, -1], "on": true}}}]}), false),
            (json!({"materials": [{"extensions": {"KHR_materials_x": {"extensions": {"ACME_y": [[3]]}}}}]}), true),
            (json!({"extras": {"extensions": {"ACME_thing": {"accessor": 0}}}}), false),
        ] {
            assert_eq!(may_name_indices(&document), expected, "{document}");
        }
    }

    #[test]
    fn names_go_with_what_they_stand_for() {
        let mut document = json!({
            "extensionsUsed": ["KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_lights_punctual"],
            "extensionsRequired": ["KHR_mesh_quantization", "EXT_meshopt_compression"],
            "accessors": [{"componentType": 5126}, {"componentType": 5123, "normalized": true}],
            "bufferViews": [{"extensions": {"EXT_meshopt_compression": {"buffer": 0}, "OTHER": {}}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        });
        let mut quantized = document.clone();
        quantized["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 1.into();
        drop_compression_extensions(&mut document);
        drop_unused_names(&mut document);
        assert_eq!(document["extensionsUsed"], json!(["KHR_lights_punctual"]));
        assert_eq!(document.get("extensionsRequired"), None);
        assert_eq!(document["bufferViews"], json!([{"extensions": {"OTHER": {}}}]));
        drop_unused_names(&mut quantized);
        assert_eq!(quantized["extensionsRequired"], json!(["KHR_mesh_quantization", "EXT_meshopt_compression"]));
    }
}
