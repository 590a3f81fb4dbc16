//! Files of a document and its buffer.

use std::path::Path;

use base64::Engine;
use serde_json::Value;

use super::image_kinds::free_path;
use super::load_uri::encode_percent;
use crate::io::{Format, OutputFile, OutputFolder, WriteError};

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum BufferPlace {
    Glb,
    Embedded,
    Beside,
}

/// Makes an asset's files; the first is the glTF itself, called `name`.
///
/// The file of a separate buffer is named after `shared`, if other documents have it, too, else after `name`.
pub(super) fn files(
    mut document: Value,
    buffer: &[u8],
    layout: BufferPlace,
    (name, shared, folder): (&str, Option<&str>, Option<&OutputFolder>),
    images: &[OutputFile],
) -> Result<Vec<OutputFile>, WriteError> {
    let path = Path::new(name);
    // The name comes from the caller and must not place files elsewhere.
    if path.file_name().is_none_or(|only| only != path.as_os_str()) {
        return Err(WriteError::new(format!("{name:?} is not a file name: give one without folders")));
    }
    let mut beside = Vec::new();
    // An empty buffer needs no file.
    if layout == BufferPlace::Beside && document.get("buffers").is_some() {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut name = free_path(format!("{}.bin", shared.unwrap_or(&stem)).into(), images);
        if let Some(folder) = folder {
            name = folder.free_path(&name, buffer, None, images);
        }
        let described = &mut document["buffers"][0];
        (described["uri"], described["byteLength"]) =
            (encode_percent(&name.to_string_lossy()).into(), buffer.len().into());
        beside.push(OutputFile { path: name, bytes: buffer.to_vec() });
    }
    let bytes = match layout {
        BufferPlace::Glb => write_glb(&document, buffer)?,
        BufferPlace::Embedded => write_embedded(document, buffer)?,
        BufferPlace::Beside => write_json(&document)?,
    };
    Ok(std::iter::once(OutputFile { path: path.into(), bytes }).chain(beside).chain(images.iter().cloned()).collect())
}

pub(super) fn one_file(document: Value, buffer: &[u8], format: Format) -> Result<Vec<u8>, WriteError> {
    if format == Format::Glb { write_glb(&document, buffer) } else { write_embedded(document, buffer) }
}

fn write_embedded(mut document: Value, buffer: &[u8]) -> Result<Vec<u8>, WriteError> {
    if !buffer.is_empty() {
        let data = base64::engine::general_purpose::STANDARD.encode(buffer);
        document["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{data}").into();
    }
    write_json(&document)
}

fn write_json(document: &Value) -> Result<Vec<u8>, WriteError> {
    serde_json::to_vec(document).map_err(|error| WriteError::new(format!("the JSON cannot be written: {error}")))
}

fn write_glb(document: &Value, buffer: &[u8]) -> Result<Vec<u8>, WriteError> {
    let json = write_json(document)?;
    let too_large = || WriteError::new("more than 4 GiB do not fit into GLB: write .gltf");
    // A GLB is a header of 12 bytes, then chunks aligned to four bytes.
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    let chunks = [(b"JSON", &json[..], b' '), (b"BIN\0", buffer, 0)];
    for (kind, chunk, padding) in chunks.into_iter().filter(|(_, chunk, _)| !chunk.is_empty()) {
        let length = chunk.len().next_multiple_of(4);
        bytes.extend(u32::try_from(length).map_err(|_| too_large())?.to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
        bytes.resize(bytes.len().next_multiple_of(4), padding);
    }
    let length = u32::try_from(bytes.len()).map_err(|_| too_large())?;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn chunks_begin_at_multiples_of_four() {
        let bytes = write_glb(&json!({"a": 1}), &[1, 2, 3, 4, 5]).unwrap();
        assert_eq!(bytes.len() % 4, 0);
        assert_eq!(&bytes[..12], [&b"glTF\x02\0\0\0"[..], &(bytes.len() as u32).to_le_bytes()].concat());
        assert_eq!(&bytes[20..28], b"{\"a\":1} ");
        assert_eq!(&bytes[28..], b"\x08\0\0\0BIN\0\x01\x02\x03\x04\x05\0\0\0");
    }

    #[test]
    fn names_are_no_paths_and_do_not_clash() {
        let images = [OutputFile { path: "A b.BIN".into(), bytes: vec![] }];
        let document = json!({"buffers": [{"byteLength": 1}]});
        let written = files(document.clone(), &[7], BufferPlace::Beside, ("a b.gltf", None, None), &images).unwrap();
        let names: Vec<&Path> = written.iter().map(|file| file.path.as_path()).collect();
        assert_eq!(names, [Path::new("a b.gltf"), Path::new("_a b.bin"), Path::new("A b.BIN")]);
        assert!(String::from_utf8_lossy(&written[0].bytes).contains("_a%20b.bin"));
        for name in ["", "..", "a/b.glb", "/b.glb"] {
            assert!(files(document.clone(), &[7], BufferPlace::Glb, (name, None, None), &images).is_err(), "{name}");
        }
    }
}
