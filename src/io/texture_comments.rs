//! Textures that comments of a PLY name, as MeshLab writes them, and the numbers of faces (`texnumber`) that choose among them.

use super::extra::{Extra, Group};

/// The texture that a comment names.
pub(super) fn texture_of(comment: &str) -> Option<&str> {
    comment.strip_prefix("comment TextureFile ").map(str::trim)
}

/// The textures that the comments name, in their order.
pub(super) fn textures(extra: &Extra) -> impl Iterator<Item = &str> {
    extra.comments.iter().filter_map(|comment| texture_of(comment))
}

/// The number of the texture of a group: the first one where faces have no such numbers, none where the number is no count.
pub(super) fn texture_number(extra: &Extra, group: &Group) -> Option<usize> {
    let column = extra.face_columns.iter().position(|column| column.name == "texnumber");
    let number = column.and_then(|column| group.values.get(column)).copied().unwrap_or(0.0);
    (number >= 0.0).then_some(number as usize)
}
