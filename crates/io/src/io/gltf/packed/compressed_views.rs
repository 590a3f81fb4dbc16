//! Compression of buffer views (`EXT_meshopt_compression`).

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::compress::compress_view;
use crate::io::WriteError;
use crate::io::gltf::accessor::element_size;
use crate::io::gltf::draft::{Draft, VERTICES};
use crate::io::gltf::extensions::{may_name_indices, name_extension};
use crate::io::gltf::references::{OTHER_VIEWS, VIEWS_OF_ACCESSORS, find_referenced, index, list, list_mut};
use crate::io::gltf::repack::{PackedBuffer, drop_unused, pack_views, place_view};

pub(in crate::io::gltf) const COMPRESSION: &str = "EXT_meshopt_compression";
pub(in crate::io::gltf) const OCTAHEDRAL: &str = "OCTAHEDRAL";

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Stream {
    is_triangles: bool,
    stride: usize,
    filter: Option<String>,
    // Members `target` and `byteStride` of the view, 0 if absent; the stride of vertex data is left out.
    says: [u64; 2],
}

/// Compresses the buffer views and packs them into the buffer.
pub(in crate::io::gltf) fn pack_compressed(
    draft: &mut Draft,
    buffer: &mut PackedBuffer,
    limit: usize,
) -> Result<(), WriteError> {
    // Merging renumbers views, which unknown extensions may refer to.
    if !may_name_indices(&draft.document) {
        merge_views(draft);
        drop_unused(draft);
    }
    let streams = streams(draft);
    let mut n_unpacked = 0usize;
    pack_views(draft, limit, |at, view, bytes| {
        let packed = streams[at]
            .as_ref()
            .and_then(|stream| Some((compress_view(bytes, stream.is_triangles, stream.stride)?, stream)));
        // Compression that gains nothing is left out, unless a filter needs it.
        let packed = packed.filter(|(packed, stream)| packed.len() < bytes.len() || stream.filter.is_some());
        match packed {
            Some((packed, stream)) => {
                place_view(view, 1, n_unpacked, bytes.len());
                view["extensions"][COMPRESSION] =
                    describe_stream(stream, buffer.place(&packed), packed.len(), bytes.len());
                n_unpacked = (n_unpacked + bytes.len()).next_multiple_of(4);
            }
            None => place_view(view, 0, buffer.place(bytes), bytes.len()),
        }
        buffer.bytes.len().max(n_unpacked)
    })?;
    name_buffers(&mut draft.document, buffer.bytes.len(), n_unpacked);
    Ok(())
}

fn describe_stream(stream: &Stream, offset: usize, length: usize, n_unpacked: usize) -> Value {
    let mode = if stream.is_triangles { "TRIANGLES" } else { "ATTRIBUTES" };
    let mut description = json!({"buffer": 0, "byteLength": length, "byteStride": stream.stride, "mode": mode,
        "count": n_unpacked / stream.stride});
    if offset > 0 {
        description["byteOffset"] = offset.into();
    }
    if let Some(filter) = &stream.filter {
        description["filter"] = filter.as_str().into();
    }
    description
}

fn name_buffers(document: &mut Value, n_bytes: usize, n_unpacked: usize) {
    if let Some(document) = document.as_object_mut() {
        document.shift_remove("buffers");
    }
    if n_bytes > 0 {
        document["buffers"] = json!([{"byteLength": n_bytes}]);
    }
    if n_unpacked > 0 {
        let stand_in = json!({"byteLength": n_unpacked, "extensions": {COMPRESSION: {"fallback": true}}});
        document["buffers"].as_array_mut().into_iter().for_each(|buffers| buffers.push(stand_in.clone()));
        name_extension(document, COMPRESSION);
    }
}

// Only views with elements of one kind, read by accessors alone, are compressed.
fn streams(draft: &mut Draft) -> Vec<Option<Stream>> {
    let n = draft.views.len();
    let others = find_referenced(&mut draft.document, &[&VIEWS_OF_ACCESSORS[1..], &OTHER_VIEWS].concat(), n);
    let triangles = indices_of_triangles(&draft.document);
    let mut found: Vec<Option<Option<Stream>>> = vec![None; n];
    for (at, accessor) in list(&draft.document, "accessors").iter().enumerate() {
        let Some(view) = accessor.get("bufferView").and_then(index).filter(|&view| view < n) else { continue };
        let is_triangles = triangles.get(&at).copied();
        let stream = stream(&draft.document["bufferViews"][view], accessor, is_triangles);
        let bytes = draft.views[view].as_deref().map_or(0, <[u8]>::len);
        let stream = stream.filter(|stream| bytes.is_multiple_of(stream.stride) && !others[view]);
        match &mut found[view] {
            // A view that accessors read in different ways cannot be one stream.
            Some(known) if *known != stream => *known = None,
            Some(_) => {}
            slot => *slot = Some(stream),
        }
    }
    found.into_iter().map(Option::flatten).collect()
}

fn stream(view: &Value, accessor: &Value, is_triangles: Option<bool>) -> Option<Stream> {
    let component = u32::try_from(accessor.get("componentType")?.as_u64()?).ok()?;
    let size = element_size(accessor.get("type")?.as_str()?, component);
    let says = ["target", "byteStride"].map(|name| view.get(name).and_then(Value::as_u64).unwrap_or(0));
    // The stride of vertices follows from the elements.
    let says = if says[0] == u64::from(VERTICES) { [says[0], 0] } else { says };
    let stride = view.get("byteStride").map_or(Some(size), index).filter(|stride| *stride >= size && size > 0)?;
    let filter = view["extensions"][COMPRESSION]["filter"].as_str().map(String::from);
    let count = accessor.get("count").and_then(index)?;
    match is_triangles {
        Some(true) if count % 3 == 0 && matches!(stride, 2 | 4) => Some(()),
        None if stride % 4 == 0 => Some(()),
        _ => None,
    }?;
    Some(Stream { is_triangles: is_triangles == Some(true), stride, filter, says })
}

fn indices_of_triangles(document: &Value) -> BTreeMap<usize, bool> {
    let meshes = list(document, "meshes").iter();
    let primitives = meshes.flat_map(|mesh| list(mesh, "primitives").iter());
    let mut found = BTreeMap::new();
    for primitive in primitives {
        if let Some(accessor) = primitive.get("indices").and_then(index) {
            let is_list = primitive.get("mode").is_none_or(|mode| mode == 4);
            found.entry(accessor).and_modify(|all| *all &= is_list).or_insert(is_list);
        }
    }
    found
}

fn merge_views(draft: &mut Draft) {
    let streams = streams(draft);
    let mut places: BTreeMap<&Stream, usize> = BTreeMap::new();
    let mut moved = vec![None; streams.len()];
    let mut bytes: Vec<Option<Vec<u8>>> = vec![None; streams.len()];
    for (view, stream) in streams.iter().enumerate() {
        let (Some(stream), Some(own)) = (stream, &draft.views[view]) else { continue };
        let place = *places.entry(stream).or_insert(view);
        // Views with several vertex arrays must state their stride.
        if stream.says[0] == u64::from(VERTICES) {
            draft.document["bufferViews"][place]["byteStride"] = stream.stride.into();
        }
        let all = bytes[place].get_or_insert_default();
        moved[view] = Some((place, all.len()));
        all.extend_from_slice(own);
    }
    for (view, all) in bytes.into_iter().enumerate() {
        if let Some(all) = all {
            draft.views[view] = Some(all.into());
        }
    }
    let accessors = list_mut(&mut draft.document, "accessors").iter_mut();
    for accessor in accessors {
        let view = accessor.get("bufferView").and_then(index).and_then(|view| moved.get(view).copied().flatten());
        if let Some((place, offset)) = view {
            let offset = offset + accessor.get("byteOffset").and_then(index).unwrap_or(0);
            accessor["bufferView"] = place.into();
            if offset > 0 {
                accessor["byteOffset"] = offset.into();
            }
        }
    }
}
