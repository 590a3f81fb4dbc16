//! Removal of unreferenced accessors and views, and the buffer that the others go into.

use std::borrow::Cow;
use std::hash::Hasher;

use rustc_hash::{FxHashMap, FxHasher};
use serde_json::{Map, Value};

use super::accessor::element_size;
use super::draft::Draft;
use super::extensions::may_name_indices;
use super::references::{ACCESSORS, OTHER_VIEWS, VIEWS_OF_ACCESSORS, find_referenced, index, list, visit};
use crate::io::WriteError;

const ALIGNMENT: usize = 4;

/// Drops accessors and buffer views without references.
pub(super) fn drop_unused(draft: &mut Draft) {
    // An unknown extension might refer to anything by index.
    if may_name_indices(&draft.document) {
        return;
    }
    // This precedes the removal: a view goes only if none of its accessors is used.
    cut_shared_views(draft);
    let n_accessors = list(&draft.document, "accessors").len();
    let used = find_referenced(&mut draft.document, &ACCESSORS, n_accessors);
    keep_marked(&mut draft.document, "accessors", &used, &ACCESSORS);
    let paths = [&VIEWS_OF_ACCESSORS[..], &OTHER_VIEWS].concat();
    let used = find_referenced(&mut draft.document, &paths, draft.views.len());
    keep_marked(&mut draft.document, "bufferViews", &used, &paths);
    let mut used = used.into_iter();
    draft.views.retain(|_| used.next().unwrap_or(false));
}

/// Buffer of a document, or of several that share it.
#[derive(Default)]
pub(super) struct PackedBuffer {
    pub bytes: Vec<u8>,
    // First byte of views by the hash of their bytes.
    known: FxHashMap<u64, usize>,
}

impl PackedBuffer {
    /// Returns the first byte of a view in the buffer; views of equal bytes share them.
    pub fn place(&mut self, bytes: &[u8]) -> usize {
        let mut hasher = FxHasher::default();
        hasher.write(bytes);
        let known = self.known.get(&hasher.finish()).copied();
        let is_there = |at: &usize| self.bytes.get(*at..*at + bytes.len()) == Some(bytes);
        known.filter(is_there).unwrap_or_else(|| {
            self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
            let offset = self.bytes.len();
            self.bytes.extend_from_slice(bytes);
            self.known.entry(hasher.finish()).or_insert(offset);
            offset
        })
    }
}

/// Moves all buffer views into the buffer.
pub(super) fn pack(draft: &mut Draft, buffer: &mut PackedBuffer, limit: usize) -> Result<(), WriteError> {
    pack_views(draft, limit, |_, view, bytes| {
        place_view(view, 0, buffer.place(bytes), bytes.len());
        buffer.bytes.len()
    })?;
    name_buffer(&mut draft.document, buffer.bytes.len());
    Ok(())
}

/// Moves all buffer views by `place`, which returns the length of the longest buffer after each.
pub(super) fn pack_views(
    draft: &mut Draft,
    limit: usize,
    mut place: impl FnMut(usize, &mut Value, &[u8]) -> usize,
) -> Result<(), WriteError> {
    let views = draft.document.get_mut("bufferViews").and_then(Value::as_array_mut);
    for (at, (view, bytes)) in views.into_iter().flatten().zip(&draft.views).enumerate() {
        let bytes = bytes.as_deref().ok_or_else(|| {
            WriteError::new(format!("buffer view {at} ends beyond its buffer: export the asset again"))
        })?;
        // Views may overlap in the file and repeat its bytes many times.
        if place(at, view, bytes) > limit {
            return Err(WriteError::new("the result is too large for glTF: simplify further"));
        }
    }
    Ok(())
}

pub(super) fn place_view(view: &mut Value, buffer: usize, offset: usize, length: usize) {
    let Value::Object(view) = view else { return };
    view.insert("buffer".into(), buffer.into());
    view.shift_remove("byteOffset");
    if offset > 0 {
        view.insert("byteOffset".into(), offset.into());
    }
    view.insert("byteLength".into(), length.into());
}

fn name_buffer(document: &mut Value, length: usize) {
    let Value::Object(document) = document else { return };
    // If the document had one buffer, its other JSON members stay.
    let mut buffer = match document.get_mut("buffers").and_then(Value::as_array_mut) {
        Some(buffers) if buffers.len() == 1 => buffers[0].as_object_mut().map(std::mem::take).unwrap_or_default(),
        _ => Map::new(),
    };
    buffer.shift_remove("uri");
    buffer.insert("byteLength".into(), length.into());
    if length == 0 {
        document.shift_remove("buffers");
        return;
    }
    document.insert("buffers".into(), Value::Array(vec![buffer.into()]));
}

fn keep_marked(document: &mut Value, array: &str, marks: &[bool], paths: &[&str]) {
    let count = |n: &mut usize, &mark: &bool| {
        *n += usize::from(mark);
        Some(n.saturating_sub(1))
    };
    let places: Vec<usize> = marks.iter().scan(0, count).collect();
    if let Some(Value::Array(elements)) = document.get_mut(array) {
        let mut marks = marks.iter();
        elements.retain(|_| marks.next() == Some(&true));
        if elements.is_empty() {
            document.as_object_mut().map(|document| document.shift_remove(array));
        }
    }
    visit(document, paths, &mut |value| {
        if let Some(place) = index(value).and_then(|index| places.get(index)) {
            *value = (*place).into();
        }
    });
}

fn cut_shared_views(draft: &mut Draft) {
    let n_accessors = list(&draft.document, "accessors").len();
    let used = find_referenced(&mut draft.document, &ACCESSORS, n_accessors);
    // Views with other readers than accessors must keep their place.
    let indivisible =
        find_referenced(&mut draft.document, &[&VIEWS_OF_ACCESSORS[1..], &OTHER_VIEWS].concat(), draft.views.len());
    let mut ranges: Vec<Vec<ByteRange>> = vec![Vec::new(); draft.views.len()];
    let mut has_unused = vec![false; draft.views.len()];
    let accessors = list(&draft.document, "accessors").iter();
    for (accessor, (value, used)) in accessors.zip(used).enumerate() {
        let Some(view) = value.get("bufferView").and_then(index).filter(|&view| view < draft.views.len()) else {
            continue;
        };
        has_unused[view] |= !used;
        if used {
            ranges[view].extend(byte_range(&draft.document, accessor, value, view));
        }
    }
    for (view, mut ranges) in ranges.into_iter().enumerate() {
        if has_unused[view] && !indivisible[view] && !ranges.is_empty() {
            ranges.sort_by_key(|range| (range.start, range.accessor));
            cut_view(draft, view, &ranges);
        }
    }
}

#[derive(Clone, Copy)]
struct ByteRange {
    accessor: usize,
    start: usize,
    end: usize,
}

fn byte_range(document: &Value, accessor: usize, value: &Value, view: usize) -> Option<ByteRange> {
    let size = element_size(value.get("type")?.as_str()?, u32::try_from(value.get("componentType")?.as_u64()?).ok()?);
    let stride = document["bufferViews"][view].get("byteStride").and_then(index).unwrap_or(size);
    let start = value.get("byteOffset").map_or(Some(0), index)?;
    let last = index(value.get("count")?)?.checked_sub(1)?.checked_mul(stride)?;
    Some(ByteRange { accessor, start, end: start.checked_add(last)?.checked_add(size)? })
}

fn cut_view(draft: &mut Draft, view: usize, ranges: &[ByteRange]) {
    let Some(bytes) = draft.views[view].clone() else { return };
    // A broken accessor leaves its view unchanged.
    if ranges.iter().any(|range| range.end > bytes.len()) {
        return;
    }
    // Interleaved ranges stay together.
    for run in ranges.chunk_by(|a, b| b.start < a.end) {
        let start = run[0].start / ALIGNMENT * ALIGNMENT;
        let end = run.iter().map(|range| range.end).fold(start, usize::max);
        let part = match &bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[start..end]),
            Cow::Owned(bytes) => Cow::Owned(bytes[start..end].to_vec()),
        };
        let described = draft.document["bufferViews"][view].clone();
        draft.views.push(Some(part));
        let place = draft.push("bufferViews", described);
        for range in run {
            let accessor = &mut draft.document["accessors"][range.accessor];
            accessor["bufferView"] = place.clone();
            accessor["byteOffset"] = (range.start - start).into();
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn draft() -> Draft<'static> {
        let bytes: &'static [u8] = &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        let document = json!({
            "accessors": [
                {"bufferView": 1, "componentType": 5126, "count": 1, "type": "SCALAR"},
                {"bufferView": 1, "byteOffset": 4, "componentType": 5126, "count": 1, "type": "SCALAR"},
                {"bufferView": 1, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "SCALAR"},
            ],
            "animations": [{"samplers": [{"input": 1, "output": 2}]}],
            "bufferViews": [{"buffer": 0, "byteLength": 3}, {"buffer": 1, "byteLength": 16}],
            "buffers": [{"byteLength": 3}, {"byteLength": 16}],
            "images": [{"bufferView": 0}],
        });
        Draft { document, views: vec![Some(Cow::Borrowed(&bytes[..3])), Some(Cow::Borrowed(bytes))] }
    }

    #[test]
    fn what_is_not_named_goes_with_its_bytes() {
        let mut draft = draft();
        drop_unused(&mut draft);
        let mut buffer = PackedBuffer::default();
        pack(&mut draft, &mut buffer, 1000).unwrap();
        assert_eq!(buffer.bytes, [0, 1, 2, 0, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);
        let document = &draft.document;
        assert_eq!(document["animations"][0]["samplers"][0], json!({"input": 0, "output": 1}));
        assert_eq!(document["accessors"].as_array().unwrap().len(), 2);
        assert_eq!(document["accessors"][1]["bufferView"], 2);
        assert_eq!(document["bufferViews"][1], json!({"buffer": 0, "byteOffset": 4, "byteLength": 4}));
        assert_eq!(document["buffers"], json!([{"byteLength": 16}]));
    }

    #[test]
    fn numbers_that_strangers_may_name_stay() {
        let mut draft = draft();
        draft.document["extensions"] = json!({"ACME_thing": {"accessor": 0}});
        let before = draft.document.clone();
        drop_unused(&mut draft);
        assert_eq!(draft.document, before);
        let mut buffer = PackedBuffer::default();
        pack(&mut draft, &mut buffer, 1000).unwrap();
        assert_eq!(buffer.bytes.len(), 20);
        // A second document with the same bytes needs no more.
        let mut other = self::draft();
        pack(&mut other, &mut buffer, 1000).unwrap();
        assert_eq!((buffer.bytes.len(), &other.document["bufferViews"]), (20, &draft.document["bufferViews"]));
    }

    #[test]
    fn views_without_bytes_and_extreme_sizes_are_refused() {
        assert!(pack(&mut draft(), &mut PackedBuffer::default(), 10).is_err());
        let mut broken = draft();
        broken.views[1] = None;
        assert!(
            pack(&mut broken, &mut PackedBuffer::default(), 1000)
                .unwrap_err()
                .what
                .starts_with("buffer view 1 ends beyond")
        );
    }
}
