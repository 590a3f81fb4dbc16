//! Stub of `draco` for builds without it.

use super::buffers::AssetBuffers;
use super::schema::Root;
use crate::io::ReadError;

const NAME: &str = "KHR_draco_mesh_compression";

pub(super) fn decompress(root: &mut Root, _: &AssetBuffers) -> Result<(), ReadError> {
    let is_needed = root.extensions_required.iter().any(|needed| needed == NAME);
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let alone: Vec<_> = primitives.filter_map(|primitive| primitive.draco_alone(&root.accessors)).collect();
    if !is_needed && alone.is_empty() {
        return Ok(());
    }
    let n_views = alone.iter().filter(|draco| draco.buffer_view.is_some()).count();
    let remedy = "build with `--features draco`, or undo it: `npx @gltf-transform/cli copy IN.glb OUT.glb`";
    Err(ReadError::file(
        format!("uses {NAME}, which this build cannot read (compressed buffer views: {n_views})"),
        remedy,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_compressed_alone_is_refused_and_a_plain_copy_is_taken() {
        let document = |view: &str, required: &str| {
            let text = format!(
                r#"{{"accessors": [{{{view} "componentType": 5126, "count": 3, "type": "VEC3"}}], "extensionsRequired": [{required}],
                "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "extensions": {{"{NAME}": {{"bufferView": 1, "attributes": {{"POSITION": 0}}}}}}}}]}}]}}"#
            );
            let buffers = AssetBuffers::load(std::iter::empty(), None, &|_| unreachable!()).unwrap();
            decompress(&mut serde_json::from_str(&text).unwrap(), &buffers)
        };
        assert!(document(r#""bufferView": 0,"#, "").is_ok());
        for (view, required) in [("", ""), (r#""bufferView": 0,"#, "\"KHR_draco_mesh_compression\"")] {
            let error = document(view, required).unwrap_err().to_string();
            assert!(error.contains(NAME) && error.contains("`--features draco`") && !error.contains('\n'), "{error}");
        }
    }
}
