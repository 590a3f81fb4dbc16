//! Document to be written, with the bytes of its buffer views.

use std::borrow::Cow;

use serde_json::{Value, json};

use super::accessor::{FLOAT, UNSIGNED_INT, UNSIGNED_SHORT, component, element_size};
use crate::io::Scalar;

pub(super) struct Draft<'a> {
    pub document: Value,
    // `None` for views whose bytes the file lacks.
    pub views: Vec<Option<Cow<'a, [u8]>>>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct NumberStorage {
    // OpenGL number of the component type, 5120 to 5126.
    pub component: u32,
    // True if integers mean fractions of their range.
    pub normalized: bool,
    pub shape: String,
    // True if the accessor may be sparse: only nonzero rows are stored if that takes fewer bytes.
    pub sparse: bool,
}

impl NumberStorage {
    pub fn floats(shape: &str) -> Self {
        Self { component: FLOAT, normalized: false, shape: shape.into(), sparse: false }
    }
}

pub(super) fn vector_shape(width: usize) -> &'static str {
    ["SCALAR", "VEC2", "VEC3", "VEC4"][width.clamp(1, 4) - 1]
}

pub(super) const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

impl Draft<'_> {
    /// Appends vertex values, n x width, and returns their accessor; `bounded` adds their range.
    pub fn push_values(&mut self, values: &[f32], width: usize, stored: &NumberStorage, bounded: bool) -> Value {
        let count = values.len() / width;
        let mut accessor = json!({"componentType": stored.component, "count": count, "type": stored.shape});
        if stored.normalized {
            accessor["normalized"] = true.into();
        }
        if bounded {
            let [low, high] = bounds(values, width, stored.component == FLOAT);
            (accessor["min"], accessor["max"]) = (low, high);
        }
        // A sparse row costs an index besides its values.
        match Some(nonzero_rows(values, width)).filter(|rows| stored.sparse && 3 * rows.len() < count) {
            Some(rows) if rows.is_empty() => {}
            Some(rows) => accessor["sparse"] = self.push_sparse(values, width, stored, &rows),
            None => accessor["bufferView"] = self.push_rows(values, width, stored),
        }
        self.push("accessors", accessor)
    }

    fn push_rows(&mut self, values: &[f32], width: usize, stored: &NumberStorage) -> Value {
        let size = element_size(&stored.shape, stored.component);
        // The specification aligns vertex attributes to four bytes.
        let stride = size.next_multiple_of(4);
        let mut bytes = Vec::with_capacity(values.len() / width * stride);
        for row in values.chunks_exact(width) {
            row.iter().for_each(|&value| push(&mut bytes, value, stored));
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let mut view = json!({"buffer": 0, "byteLength": bytes.len(), "target": VERTICES});
        if stride != size {
            view["byteStride"] = stride.into();
        }
        self.push_view(view, bytes)
    }

    fn push_sparse(&mut self, values: &[f32], width: usize, stored: &NumberStorage, rows: &[u32]) -> Value {
        let held = rows.iter().flat_map(|&row| &values[row as usize * width..][..width]);
        let mut bytes = Vec::new();
        held.for_each(|&value| push(&mut bytes, value, stored));
        let values = self.push_view(json!({"buffer": 0, "byteLength": bytes.len()}), bytes);
        let bytes: Vec<u8> = rows.iter().flat_map(|row| row.to_le_bytes()).collect();
        let indices = self.push_view(json!({"buffer": 0, "byteLength": bytes.len()}), bytes);
        json!({
            "count": rows.len(),
            "indices": {"bufferView": indices, "componentType": UNSIGNED_INT},
            "values": {"bufferView": values},
        })
    }

    /// Appends vertex indices and returns their accessor.
    pub fn push_indices(&mut self, faces: &[[u32; 3]], n_vertices: usize) -> Value {
        // Indices of 16 bits halve the size. The largest is avoided, as it restarts primitives in graphics APIs.
        let short = n_vertices <= usize::from(u16::MAX);
        let indices = faces.as_flattened();
        let bytes: Vec<u8> = match short {
            true => indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect(),
            false => indices.iter().flat_map(|&index| index.to_le_bytes()).collect(),
        };
        let view = self.push_view(json!({"buffer": 0, "byteLength": bytes.len(), "target": INDICES}), bytes);
        let component = if short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        let accessor =
            json!({"bufferView": view, "componentType": component, "count": indices.len(), "type": "SCALAR"});
        self.push("accessors", accessor)
    }

    pub fn push_view(&mut self, view: Value, bytes: Vec<u8>) -> Value {
        self.views.push(Some(Cow::Owned(bytes)));
        self.push("bufferViews", view)
    }

    pub fn push(&mut self, array: &str, value: Value) -> Value {
        let Value::Object(document) = &mut self.document else { return Value::Null };
        let held = document.entry(array).or_insert_with(|| Value::Array(Vec::new()));
        let Value::Array(held) = held else { return Value::Null };
        held.push(value);
        (held.len() - 1).into()
    }
}

fn nonzero_rows(values: &[f32], width: usize) -> Vec<u32> {
    let rows = values.chunks_exact(width).zip(0..);
    rows.filter(|(row, _)| row.iter().any(|&value| value != 0.0)).map(|(_, number)| number).collect()
}

fn bounds(values: &[f32], width: usize, has_fractions: bool) -> [Value; 2] {
    let number = |x: f32| if has_fractions { f64::from(x).into() } else { Value::from(x as i64) };
    let column = |fold: fn(f32, f32) -> f32, from: f32| {
        let extreme = |at: usize| values.iter().skip(at).step_by(width).copied().fold(from, fold);
        Value::Array((0..width).map(|at| number(extreme(at))).collect())
    };
    [column(f32::min, f32::INFINITY), column(f32::max, f32::NEG_INFINITY)]
}

fn push(bytes: &mut Vec<u8>, value: f32, stored: &NumberStorage) {
    let scalar = component(stored.component).unwrap_or(Scalar::F32);
    let (value, largest) = (f64::from(value), scalar.largest());
    let value = if stored.normalized { value * largest } else { value };
    // The lowest signed integer has no opposite.
    scalar.push_bytes(bytes, if scalar.is_whole() { value.max(-largest) } else { value });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::gltf::accessor::UNSIGNED_BYTE;

    fn empty() -> Draft<'static> {
        Draft { document: json!({}), views: Vec::new() }
    }

    #[test]
    fn rows_of_small_numbers_are_padded() {
        let stored = NumberStorage { component: UNSIGNED_BYTE, normalized: true, ..NumberStorage::floats("VEC3") };
        let mut draft = empty();
        assert_eq!(draft.push_values(&[0.0, 0.5, 1.0, 2.0, -1.0, 0.2], 3, &stored, false), 0);
        assert_eq!(draft.views[0].as_deref(), Some(&[0, 128, 255, 0, 255, 0, 51, 0][..]));
        assert_eq!(draft.document["bufferViews"][0]["byteStride"], 4);
        assert_eq!(draft.document["accessors"][0]["normalized"], true);
    }

    #[test]
    fn rows_of_zeros_are_not_stored_where_that_is_shorter() {
        let stored = NumberStorage { sparse: true, ..NumberStorage::floats("SCALAR") };
        for (values, sparse, n_views) in
            [([0.0, 0.0, 0.0, 7.0], true, 2), ([1.0, 0.0, 0.0, 7.0], false, 1), ([0.0; 4], false, 0)]
        {
            let mut draft = empty();
            draft.push_values(&values, 1, &stored, true);
            let accessor = &draft.document["accessors"][0];
            assert_eq!((accessor.get("sparse").is_some(), draft.views.len()), (sparse, n_views), "{values:?}");
            assert_eq!(accessor["min"], json!([0.0]));
        }
    }

    #[test]
    fn ranges_are_exact() {
        let mut draft = empty();
        draft.push_values(&[0.1, 5.0, -2.0, 7.5], 2, &NumberStorage::floats("VEC2"), true);
        let accessor = &draft.document["accessors"][0];
        assert_eq!((&accessor["min"], &accessor["max"]), (&json!([-2.0, 5.0]), &json!([f64::from(0.1f32), 7.5])));
    }

    #[test]
    fn the_largest_short_index_is_never_used() {
        for (n_vertices, component) in [(65_535, UNSIGNED_SHORT), (65_536, UNSIGNED_INT)] {
            let mut draft = empty();
            draft.push_indices(&[[0, 1, n_vertices as u32 - 1]], n_vertices);
            assert_eq!(draft.document["accessors"][0]["componentType"], component);
        }
    }
}
