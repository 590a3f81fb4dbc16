//! What a file says beside positions, faces and attributes: names, libraries, comments, kinds of numbers. Kept so that a
//! writer can say it again.

use rustc_hash::FxHashSet;

use super::{Folder, Format, Scalar};
use crate::mesh::{Look, RawMesh};

/// A mesh as read, with all that its file holds.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ReadMesh {
    /// Positions, faces and attributes.
    pub mesh: RawMesh,
    /// What else the file says.
    pub extra: Extra,
    /// What could not be kept, in one line each.
    pub notes: Vec<String>,
    /// The format that it was read as.
    pub format: Option<Format>,
}

/// What a file says beside a mesh and its attributes.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Extra {
    /// What the group numbers of the faces stand for, by number; empty where the file has no groups.
    pub groups: Vec<Group>,
    /// What the numbers of [`Group::values`] are called and of which kind they are.
    pub face_columns: Vec<Column>,
    /// How channels stood in columns of the file; a channel that is not named here gets columns by its role.
    pub layouts: Vec<Layout>,
    /// Material libraries as the file names them, a line each.
    pub material_libraries: Vec<String>,
    /// What materials look like, by their names, where the file says that itself (glTF).
    pub looks: Vec<(String, Look)>,
    /// Comments of a PLY header, with the word that opens them.
    pub comments: Vec<String>,
    /// The folder of the file, in which lies what it names.
    pub folder: Option<Folder>,
    /// Whether the file's names are in Latin-1 instead of UTF-8.
    pub latin1: bool,
    /// What a length of 1 means, as 3MF calls it, where the file says so: `millimeter`, `inch`.
    pub unit: Option<String>,
    /// Whether a skin or morph targets, left behind in its scene, give the mesh more shapes than one.
    pub is_bent: bool,
}

/// What a group number stands for.
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
    /// Numbers that its faces share, one for each of [`Extra::face_columns`].
    pub values: Vec<f64>,
}

impl Group {
    /// What to call it where there is one name only: its material, else its group or object.
    pub(super) fn title(&self) -> String {
        [&self.material, &self.name, &self.object].into_iter().flatten().next().cloned().unwrap_or_default()
    }
}

/// A column of numbers in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name in the file.
    pub name: String,
    /// Kind of its numbers.
    pub scalar: Scalar,
}

/// How a channel stands in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Name of the channel.
    pub channel: String,
    /// Its columns, one for each number.
    pub columns: Vec<Column>,
    /// Whether the values stand with the corners of the faces (the list `texcoord` of a PLY), not with the vertices.
    pub per_corner: bool,
}

impl Extra {
    /// How the channel `name` stood in the file.
    pub fn layout(&self, name: &str) -> Option<&Layout> {
        self.layouts.iter().find(|layout| layout.channel == name)
    }

    /// What a group number stands for.
    pub fn group(&self, number: u32) -> Option<&Group> {
        self.groups.get(number as usize)
    }

    /// The materials of the groups, each once, in the order of the groups.
    pub fn materials(&self) -> Vec<&str> {
        let mut known = FxHashSet::default();
        let materials = self.groups.iter().filter_map(|group| group.material.as_deref());
        materials.filter(|&material| known.insert(material)).collect()
    }
}

/// Whether so many groups are none: nearly every face would be its own.
pub(super) fn sets_faces_apart(n_groups: usize, n_faces: usize) -> bool {
    n_groups > 256 && n_groups > n_faces / 4
}

/// Bytes as text: UTF-8, or else Latin-1, in which all bytes mean something.
pub(super) fn decoded(bytes: &[u8]) -> String {
    std::str::from_utf8(bytes).map_or_else(|_| latin1(bytes), String::from)
}

/// Bytes of Latin-1 as text.
pub(super) fn latin1(bytes: &[u8]) -> String {
    bytes.iter().map(|&byte| char::from(byte)).collect()
}

/// A text in the encoding of its file.
pub(super) fn encoded(text: &str, in_latin1: bool) -> Vec<u8> {
    let bytes = in_latin1.then(|| text.chars().map(|letter| u8::try_from(u32::from(letter))).collect::<Result<_, _>>());
    bytes.and_then(Result::ok).unwrap_or_else(|| text.as_bytes().to_vec())
}

/// Replaces what is not finite by zero; gives how often.
pub(super) fn without_nan(values: &mut [f32]) -> usize {
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
            let text = decoded(bytes);
            assert_eq!(encoded(&text, std::str::from_utf8(bytes).is_err()), bytes);
        }
        assert_eq!(encoded("\u{6f22}", true), "\u{6f22}".as_bytes());
    }

    #[test]
    fn materials_are_named_once_in_order() {
        let group = |name: &str| Group { material: Some(name.into()), ..Group::default() };
        let extra = Extra { groups: vec![group("b"), Group::default(), group("a"), group("b")], ..Extra::default() };
        assert_eq!(extra.materials(), ["b", "a"]);
        assert!(extra.group(3).is_some() && extra.group(4).is_none());
    }
}
