//! Image types in a document.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::extensions::{KTX2_TEXTURE, take_extension};
use super::load_uri::encode_percent;
use super::references::{index, list_mut};
use crate::io::material_writer::extension;
use crate::io::uri::path_inside;
use crate::io::{OutputFile, OutputFolder};

/// Image types by the ending of a file: media type, and the extension that textures need.
const KINDS: [(&str, &str, Option<&str>); 4] = [
    ("png", "image/png", None),
    ("jpg", "image/jpeg", None),
    ("webp", "image/webp", Some("EXT_texture_webp")),
    ("ktx2", "image/ktx2", Some(KTX2_TEXTURE)),
];

pub(super) fn media_type(ending: &str) -> Option<&'static str> {
    KINDS.iter().find(|kind| kind.0 == ending).map(|kind| kind.1)
}

pub(super) fn texture_extension(media_type: &str) -> Option<&'static str> {
    KINDS.iter().find(|kind| kind.1 == media_type)?.2
}

/// Updates the document for a KTX2 image converted to another type.
pub(super) fn change_kind(document: &mut Value, at: usize, bytes: &[u8], files: &mut [OutputFile]) {
    let ending = extension(bytes);
    let Some(kind) = media_type(ending) else { return };
    let image = &mut document["images"][at];
    // Images in buffer views must state a media type; images in files may.
    if image.get("mimeType").is_some() || image.get("bufferView").is_some() {
        image["mimeType"] = kind.into();
    }
    let uri = image.get("uri").and_then(Value::as_str).unwrap_or_default().to_string();
    if let Some((_, data)) = uri.strip_prefix("data:").and_then(|data| data.split_once(";base64,")) {
        image["uri"] = format!("data:{kind};base64,{data}").into();
    } else if let Some(path) = path_inside(&uri) {
        let is_named_so = |other: &std::ffi::OsStr| other.eq_ignore_ascii_case(ending);
        // A second image of this file finds it renamed already.
        let at = files.iter().position(|file| file.path == path);
        if let Some(at) = at.filter(|_| !path.extension().is_some_and(is_named_so)) {
            let new = free_path(path.with_extension(ending), files);
            rename(document, at, new, files);
        }
    }
    for texture in list_mut(document, "textures").iter_mut() {
        let source = texture["extensions"][KTX2_TEXTURE].get("source").and_then(index);
        if source == Some(at) {
            take_extension(texture, KTX2_TEXTURE);
            // A fallback for programs without the extension stays the plain source of the texture.
            texture.as_object_mut().map(|texture| texture.entry("source").or_insert(json!(at)));
        }
    }
}

/// Gives new names to images that would change files of the output folder that may not change.
pub(super) fn rename_images(
    document: &mut Value,
    files: &mut [OutputFile],
    output: Option<&OutputFolder>,
    suffix: Option<&str>,
) {
    for at in 0..files.len() {
        let OutputFile { path, bytes } = &files[at];
        let new = output.map(|output| output.free_path(path, bytes, suffix, files)).filter(|new| new != path);
        new.into_iter().for_each(|new| rename(document, at, new, files));
    }
}

fn rename(document: &mut Value, at: usize, new: PathBuf, files: &mut [OutputFile]) {
    let path = &files[at].path;
    let names = new.components().map(|name| encode_percent(&name.as_os_str().to_string_lossy()));
    let new_uri = names.collect::<Vec<_>>().join("/");
    let images = list_mut(document, "images").iter_mut();
    for image in images {
        let uri = image.get("uri").and_then(Value::as_str).filter(|uri| !uri.starts_with("data:"));
        if uri.and_then(path_inside).is_some_and(|named| named == *path) {
            image["uri"] = new_uri.as_str().into();
        }
    }
    files[at].path = new;
}

pub(super) fn free_path(mut path: PathBuf, taken: &[OutputFile]) -> PathBuf {
    while taken.iter().any(|file| file.path.as_os_str().eq_ignore_ascii_case(&path)) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        path.set_file_name(format!("_{name}"));
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const PNG: &[u8] = b"\x89PNG\r\n";

    fn file(path: &str) -> OutputFile {
        OutputFile { path: path.into(), bytes: Vec::new() }
    }

    #[test]
    fn images_say_what_they_have_become_and_textures_need_no_extension() {
        let mut document = json!({
            "images": [{"uri": "a/b%20c.ktx2"}, {"uri": "a/b%20c.ktx2", "mimeType": "image/ktx2"}, {"bufferView": 0},
                {"uri": "data:image/ktx2;base64,AAAA"}, {"uri": "b.png"}],
            "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}},
                {"extensions": {"KHR_texture_basisu": {"source": 1}, "OTHER": {}}},
                {"source": 4, "extensions": {"KHR_texture_basisu": {"source": 2}}},
                {"extensions": {"KHR_texture_basisu": {"source": 9}}}],
        });
        let mut files = [file("a/B C.png"), file("a/b c.ktx2")];
        (0..4).for_each(|at| change_kind(&mut document, at, PNG, &mut files));
        assert_eq!(files[1].path, Path::new("a/_b c.png"));
        let expected = json!({
            "images": [{"uri": "a/_b%20c.png"}, {"uri": "a/_b%20c.png", "mimeType": "image/png"},
                {"bufferView": 0, "mimeType": "image/png"}, {"uri": "data:image/png;base64,AAAA"}, {"uri": "b.png"}],
            "textures": [{"source": 0}, {"extensions": {"OTHER": {}}, "source": 1}, {"source": 4},
                {"extensions": {"KHR_texture_basisu": {"source": 9}}}],
        });
        assert_eq!(document, expected);
    }
}
