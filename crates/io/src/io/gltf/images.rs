//! Images of an asset on output.

use base64::Engine;
use rustc_hash::FxHashMap;
use serde_json::{Value, json};

use super::asset::Asset;
use super::draft::Draft;
use super::image_kinds::{change_kind, free_path, rename_images};
use super::load_uri::{encode_percent, load_uri};
use super::references::{index, list};
use super::scene_writer::SceneOptions;
use super::vrm;
use crate::io::material_writer::extension;
use crate::io::uri::path_inside;
use crate::io::{Format, ImageConverter, ImageUse, OutputFile, ReadError};
use crate::parallel;

impl Asset {
    pub(super) fn put_images(&self, draft: &mut Draft, options: &SceneOptions) -> Vec<OutputFile> {
        let mut files = self.images.clone();
        if let Some(converter) = options.images {
            // The use of an image decides how it is converted.
            let uses = image_uses(&self.document);
            let made = |(at, &used): (usize, &ImageUse)| {
                let bytes = self.bytes_of_image(at)?;
                let made = converter.convert(&bytes, used)?;
                Some((at, extension(&bytes) != extension(&made), made))
            };
            for (at, is_other_kind, bytes) in parallel::each(uses.iter().enumerate(), made).into_iter().flatten() {
                replace(draft, at, &bytes, &mut files);
                if is_other_kind {
                    change_kind(&mut draft.document, at, &bytes, &mut files);
                }
            }
        }
        // Views are shared after conversion, which may make different images equal.
        share_views(draft);
        if let Some(name) = options.shared.filter(|_| options.format != Format::Glb) {
            files.extend(move_to_files(draft, name, &files));
        }
        let suffix = options.images.and_then(ImageConverter::suffix);
        rename_images(&mut draft.document, &mut files, options.folder, suffix.as_deref());
        files
    }

    pub(super) fn bytes_of_image(&self, at: usize) -> Option<Vec<u8>> {
        let image = self.document.get("images")?.get(at)?;
        if let Some(view) = image.get("bufferView").and_then(index) {
            return self.container.data().bytes(view).map(<[u8]>::to_vec);
        }
        let uri = image.get("uri")?.as_str()?;
        let of_file = |uri: &str| {
            let path = path_inside(uri);
            let file = self.images.iter().find(|file| Some(&file.path) == path.as_ref());
            file.map(|file| file.bytes.clone()).ok_or_else(|| ReadError::file("no image", ""))
        };
        load_uri(uri, &of_file).ok()
    }
}

fn replace(draft: &mut Draft, at: usize, bytes: &[u8], files: &mut [OutputFile]) {
    let image = &mut draft.document["images"][at];
    if let Some(view) = image.get("bufferView").and_then(index) {
        if let Some(held) = draft.views.get_mut(view) {
            *held = Some(bytes.to_vec().into());
        }
        return;
    }
    let uri = image.get("uri").and_then(Value::as_str).unwrap_or_default();
    match uri.strip_prefix("data:").and_then(|data| data.split_once(',')) {
        Some((kind, _)) => {
            let data = base64::engine::general_purpose::STANDARD.encode(bytes);
            image["uri"] = format!("data:{kind},{data}").into();
        }
        None => {
            let path = path_inside(uri);
            files
                .iter_mut()
                .filter(|file| Some(&file.path) == path.as_ref())
                .for_each(|file| file.bytes = bytes.to_vec());
        }
    }
}

/// Moves embedded images to files `NAME_0.png`, avoiding the names in `taken`.
pub(super) fn move_to_files(draft: &mut Draft, name: &str, taken: &[OutputFile]) -> Vec<OutputFile> {
    let mut moved: Vec<OutputFile> = Vec::new();
    let n_images = list(&draft.document, "images").len();
    for at in 0..n_images {
        let Some(bytes) = embedded_bytes(draft, at) else { continue };
        // Equal images share a file.
        let known = moved.iter().find(|file| file.bytes == bytes).map(|file| file.path.clone());
        let path = known.unwrap_or_else(|| {
            let path = free_path(format!("{name}_{at}.{}", extension(&bytes)).into(), taken);
            moved.push(OutputFile { path: path.clone(), bytes });
            path
        });
        if let Value::Object(image) = &mut draft.document["images"][at] {
            image.shift_remove("bufferView");
            image.insert("uri".into(), encode_percent(&path.to_string_lossy()).into());
        }
    }
    moved
}

fn embedded_bytes(draft: &Draft, at: usize) -> Option<Vec<u8>> {
    let image = draft.document.get("images")?.get(at)?;
    if let Some(view) = image.get("bufferView").and_then(index) {
        return draft.views.get(view)?.as_deref().map(<[u8]>::to_vec);
    }
    let uri = image.get("uri")?.as_str().filter(|uri| uri.starts_with("data:"))?;
    load_uri(uri, &|_: &str| Err(ReadError::file("no image", ""))).ok()
}

fn share_views(draft: &mut Draft) {
    let mut first: FxHashMap<&[u8], usize> = FxHashMap::default();
    let images = draft.document.get_mut("images").and_then(Value::as_array_mut);
    for image in images.into_iter().flatten() {
        let view = image.get("bufferView").and_then(index);
        let bytes = view.and_then(|view| draft.views.get(view)?.as_deref());
        if let (Some(view), Some(bytes)) = (view, bytes) {
            image["bufferView"] = json!(*first.entry(bytes).or_insert(view));
        }
    }
}

fn image_uses(document: &Value) -> Vec<ImageUse> {
    let mut uses = vec![None; list(document, "images").len()];
    let mut named = Vec::new();
    list(document, "materials").iter().for_each(|material| collect_textures(material, &mut named));
    named.extend(vrm::textures(document).filter_map(|(texture, used)| Some((index(texture)?, used))));
    for (texture, used) in named {
        for image in list(document, "textures").get(texture).into_iter().flat_map(sources) {
            if let Some(known) = uses.get_mut(image) {
                known.get_or_insert(used);
            }
        }
    }
    // The first material that names an image decides.
    uses.into_iter().map(|used| used.unwrap_or(ImageUse::Colours)).collect()
}

fn collect_textures(part: &Value, found: &mut Vec<(usize, ImageUse)>) {
    for (key, value) in part.as_object().into_iter().flatten() {
        match value.get("index").and_then(index) {
            // An object with an index is a texture reference; others are searched deeper.
            Some(texture) => found.push((texture, texture_use(key))),
            None => collect_textures(value, found),
        }
    }
}

fn sources(texture: &Value) -> impl Iterator<Item = usize> {
    let others = texture.get("extensions").and_then(Value::as_object).into_iter().flat_map(|them| them.values());
    std::iter::once(texture).chain(others).filter_map(|holder| index(holder.get("source")?))
}

pub(super) fn texture_use(key: &str) -> ImageUse {
    let key = key.to_ascii_lowercase();
    let of_colours = ["color", "emissive", "diffuse", "specularglossiness", "multiply", "matcap"];
    match key {
        _ if key.contains("width") => ImageUse::Numbers,
        _ if key.contains("normal") => ImageUse::Normals,
        _ if of_colours.iter().any(|name| key.contains(name)) => ImageUse::Colours,
        _ => ImageUse::Numbers,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{ImageConverter, SimplifiedPart};

    #[derive(Debug)]
    struct UseWriter;

    impl ImageConverter for UseWriter {
        fn convert(&self, image: &[u8], used: ImageUse) -> Option<Vec<u8>> {
            (image != b"kept").then(|| format!("{used:?} {}", String::from_utf8_lossy(image)).into_bytes())
        }
    }

    const TEXT: &str = r#"{
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": 12, "uri": "data:application/octet-stream;base64,b25lMnR3bzJvbmUy"}],
        "bufferViews": [{"buffer": 0, "byteLength": 4}, {"buffer": 0, "byteOffset": 4, "byteLength": 4}, {"buffer": 0, "byteOffset": 8, "byteLength": 4}],
        "images": [{"bufferView": 0}, {"bufferView": 1}, {"bufferView": 2}, {"uri": "data:image/png;base64,dXJp"}, {"uri": "a%20b.png"}, {"uri": "kept.png"}],
        "textures": [{"source": 0}, {"source": 1}, {"source": 3}, {"extensions": {"EXT_texture_webp": {"source": 4}}}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 3}},
            "normalTexture": {"index": 1}, "extensions": {"KHR_materials_clearcoat": {"clearcoatTexture": {"index": 2}}}}]
    }"#;

    fn write_with(converter: Option<&dyn ImageConverter>) -> (Value, Vec<u8>, Vec<OutputFile>) {
        let fetch = |uri: &str| Ok(if uri.contains("kept") { b"kept".to_vec() } else { b"file".to_vec() });
        let asset = Asset::from_bytes(TEXT.as_bytes(), &fetch).unwrap();
        let parts: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
        let mut options = SceneOptions::new(Format::Glb, "a.glb");
        options.images = converter;
        let mut files = asset.write_scene(&[&parts], &options).unwrap();
        let glb = files.remove(0).bytes;
        let length = u32::from_le_bytes(*glb[12..].first_chunk().unwrap()) as usize;
        (serde_json::from_slice(&glb[20..20 + length]).unwrap(), glb[28 + length..].to_vec(), files)
    }

    #[test]
    fn each_image_is_made_for_its_use_wherever_it_lies() {
        let (document, buffer, files) = write_with(Some(&UseWriter));
        let buffer = String::from_utf8_lossy(&buffer);
        assert!(buffer.contains("Colours one2") && buffer.contains("Normals two2"), "{buffer}");
        let data = base64::engine::general_purpose::STANDARD.encode("Numbers uri");
        assert_eq!(document["images"][3]["uri"], format!("data:image/png;base64,{data}"));
        let bytes: Vec<(&str, &[u8])> = files.iter().map(|it| (it.path.to_str().unwrap(), &it.bytes[..])).collect();
        assert_eq!(bytes, [("a b.png", &b"Numbers file"[..]), ("kept.png", b"kept")]);
    }

    #[test]
    fn images_of_the_same_bytes_are_written_once() {
        let (document, buffer, _) = write_with(None);
        assert_eq!(buffer, b"one2two2");
        let views = [0, 1, 2].map(|at| document["images"][at]["bufferView"].clone());
        assert_eq!(views, [json!(0), json!(1), json!(0)]);
        assert_eq!(document["bufferViews"].as_array().unwrap().len(), 2);
    }

    #[test]
    fn images_move_into_files_beside_by_their_numbers() {
        let fetch = |_: &str| Ok(b"file".to_vec());
        let asset = Asset::from_bytes(TEXT.as_bytes(), &fetch).unwrap();
        let mut options = SceneOptions::new(Format::Gltf, "a-lod0.gltf");
        options.shared = Some("a b");
        let files = asset.write_scene(&[&[]], &options).unwrap();
        let document: Value = serde_json::from_slice(&files[0].bytes).unwrap();
        let uris = |at: usize| document["images"][at]["uri"].as_str().unwrap();
        // The first and the third have the same bytes; the last two were files.
        assert_eq!([0, 1, 2, 3].map(uris), ["a%20b_0.bin", "a%20b_1.bin", "a%20b_0.bin", "a%20b_3.bin"]);
        assert_eq!([4, 5].map(uris), ["a%20b.png", "kept.png"]);
        assert!(document.get("bufferViews").is_none() && document["images"][0].get("bufferView").is_none());
        let bytes = |name: &str| &files.iter().find(|file| file.path.to_str() == Some(name)).unwrap().bytes[..];
        assert_eq!(["a b_0.bin", "a b_1.bin", "a b_3.bin"].map(bytes), [&b"one2"[..], b"two2", b"uri"]);
        assert_eq!(
            free_path("A_0.png".into(), &[OutputFile { path: "a_0.PNG".into(), bytes: Vec::new() }]),
            std::path::Path::new("_A_0.png")
        );
    }

    #[test]
    fn keys_of_materials_say_what_is_meant() {
        for (key, used) in [
            ("baseColorTexture", ImageUse::Colours),
            ("emissiveTexture", ImageUse::Colours),
            ("sheenColorTexture", ImageUse::Colours),
            ("clearcoatNormalTexture", ImageUse::Normals),
            ("occlusionTexture", ImageUse::Numbers),
            ("shadeMultiplyTexture", ImageUse::Colours),
            ("outlineWidthMultiplyTexture", ImageUse::Numbers),
            ("thicknessTexture", ImageUse::Numbers),
        ] {
            assert_eq!(texture_use(key), used, "{key}");
        }
    }
}
