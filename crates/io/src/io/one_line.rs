//! Texts and names for messages of one line.

use std::borrow::Cow;

/// Most letters of a name in a message.
const MOST_LETTERS: usize = 80;

/// Cuts a name out of a file to 80 letters, for messages.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::shorten_name;
/// assert_eq!(shorten_name("wheel"), "wheel");
/// assert_eq!(shorten_name(&"x".repeat(1000)), "x".repeat(77) + "...");
/// ```
pub fn shorten_name(name: &str) -> Cow<'_, str> {
    match name.char_indices().nth(MOST_LETTERS) {
        None => Cow::Borrowed(name),
        Some(_) => Cow::Owned(name.chars().take(MOST_LETTERS - 3).chain("...".chars()).collect()),
    }
}

/// Joins the words of a text with single blanks.
#[doc(hidden)]
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
