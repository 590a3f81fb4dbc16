//! Content of a file besides its mesh and attributes.

use rustc_hash::FxHashSet;

use super::{Folder, Format, Scalar};
use crate::mesh::{Look, RawMesh};

/// Mesh with the whole content of its file.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ReadMesh {
    /// Positions, faces and attributes.
    pub mesh: RawMesh,
    /// Further content of the file.
    pub extra: Extra,
    /// Content that the reader dropped or repaired, one line each.
    pub notes: Vec<String>,
    /// Format of the reader.
    pub format: Option<Format>,
}

/// Content of a file besides its mesh and attributes.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Extra {
    /// Groups of faces; faces refer to these by index.
    pub groups: Vec<Group>,
    /// Name and type of each number in [`Group::values`].
    pub face_columns: Vec<Column>,
    /// Columns that stored a channel in the file; channels without an entry get their role's usual columns.
    pub layouts: Vec<ColumnLayout>,
    /// Names of material libraries; one entry has the names of one `mtllib` line.
    pub material_libraries: Vec<String>,
    /// Materials of the file by name (glTF, 3MF, FBX).
    pub looks: Vec<(String, Look)>,
    /// Lines of a PLY header that begin with `comment` or `obj_info`, this word included.
    pub comments: Vec<String>,
    /// Folder in which the file's companion files are looked for.
    pub folder: Option<Folder>,
    /// True if names in the file are Latin-1 instead of UTF-8.
    pub latin1: bool,
    /// Unit of length by its 3MF name: `millimeter`, `inch`.
    pub unit: Option<String>,
    /// True if a skin or morph targets deform the mesh.
    pub is_bent: bool,
}

/// Group of faces.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Group {
    /// Name of the object (`o`).
    pub object: Option<String>,
    /// Names of the groups (`g`).
    pub name: Option<String>,
    /// Name of the material (`usemtl`).
    pub material: Option<String>,
    /// Smoothing group (`s`).
    pub smoothing: Option<String>,
    /// Numbers common to all faces of the group, one per column of [`Extra::face_columns`].
    pub values: Vec<f64>,
}

#[cfg(any(feature = "gltf", feature = "3mf"))]
impl Group {
    pub(super) fn title(&self) -> String {
        [&self.material, &self.name, &self.object].into_iter().flatten().next().cloned().unwrap_or_default()
    }
}

/// Column of numbers in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name in the file.
    pub name: String,
    /// Type of the numbers.
    pub scalar: Scalar,
}

/// Columns of a channel in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnLayout {
    /// Name of the channel.
    pub channel: String,
    /// One column per component.
    pub columns: Vec<Column>,
    /// True if values are stored per face corner (the list `texcoord` of a PLY).
    pub per_corner: bool,
}

impl Extra {
    /// Returns the layout of the channel `name`.
    pub fn layout(&self, name: &str) -> Option<&ColumnLayout> {
        self.layouts.iter().find(|layout| layout.channel == name)
    }

    /// Returns the group `number`.
    pub fn group(&self, number: u32) -> Option<&Group> {
        self.groups.get(number as usize)
    }

    /// Lists the materials of the groups, each once.
    pub fn materials(&self) -> Vec<&str> {
        let mut known = FxHashSet::default();
        let materials = self.groups.iter().filter_map(|group| group.material.as_deref());
        materials.filter(|&material| known.insert(material)).collect()
    }
}

// Groups with fewer than four faces on average identify faces and are not meant as groups.
pub(super) fn has_too_many_groups(n_groups: usize, n_faces: usize) -> bool {
    n_groups > 256 && n_groups > n_faces / 4
}

/// Decodes UTF-8 or else Latin-1.
pub(super) fn decode_text(bytes: &[u8]) -> String {
    std::str::from_utf8(bytes).map_or_else(|_| decode_latin1(bytes), String::from)
}

pub(super) fn decode_latin1(bytes: &[u8]) -> String {
    bytes.iter().map(|&byte| char::from(byte)).collect()
}

/// Encodes a text in Latin-1 if possible, else in UTF-8.
pub(super) fn encode_text(text: &str, in_latin1: bool) -> Vec<u8> {
    let bytes = in_latin1.then(|| text.chars().map(|letter| u8::try_from(u32::from(letter))).collect::<Result<_, _>>());
    bytes.and_then(Result::ok).unwrap_or_else(|| text.as_bytes().to_vec())
}

pub(super) fn replace_non_finite(values: &mut [f32]) -> usize {
    let mut n_replaced = 0;
    for value in values.iter_mut().filter(|value| !value.is_finite()) {
        *value = 0.0;
        n_replaced += 1;
    }
    n_replaced
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_any_encoding_lead_back() {
        for bytes in [&b"caf\xe9"[..], b"\xff\x00\x80", "caf\u{e9} \u{6f22}".as_bytes(), b"plain"] {
            let text = decode_text(bytes);
            assert_eq!(encode_text(&text, std::str::from_utf8(bytes).is_err()), bytes);
        }
        assert_eq!(encode_text("\u{6f22}", true), "\u{6f22}".as_bytes());
    }

    #[test]
    fn materials_are_named_once_in_order() {
        let group = |name: &str| Group { material: Some(name.into()), ..Group::default() };
        let extra = Extra { groups: vec![group("b"), Group::default(), group("a"), group("b")], ..Extra::default() };
        assert_eq!(extra.materials(), ["b", "a"]);
        assert!(extra.group(3).is_some() && extra.group(4).is_none());
    }
}
