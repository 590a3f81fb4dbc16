//! Texture names in PLY comments, and the face numbers (`texnumber`) that refer to them.

use super::ImageUse;
use super::companion_files::{FileFinder, to_reference};
use super::extra::{Extra, Group};

pub(super) fn texture_name(comment: &str) -> Option<&str> {
    comment.strip_prefix("comment TextureFile ").map(str::trim)
}

pub(super) fn comment_textures(extra: &Extra) -> impl Iterator<Item = &str> {
    extra.comments.iter().filter_map(|comment| texture_name(comment))
}

/// Returns a group's texture number: 0 without `texnumber`, `None` if negative.
pub(super) fn texture_number(extra: &Extra, group: &Group) -> Option<usize> {
    let column = extra.face_columns.iter().position(|column| column.name == "texnumber");
    let number = column.and_then(|column| group.values.get(column)).copied().unwrap_or(0.0);
    (number >= 0.0).then_some(number as usize)
}

/// Adds the textures of the comments to the output; returns their names there.
pub(super) fn copy_comment_textures(extra: &Extra, finder: &mut FileFinder) -> Vec<String> {
    let place = |name: &str| match finder.find("".as_ref(), name) {
        Some(found) => to_reference(&finder.add_image(&found.output_path, &found.bytes, ImageUse::Colours)),
        None => name.to_string(),
    };
    comment_textures(extra).map(place).collect()
}
