//! HTML pages that ask for nothing outside themselves: a page of `cli/viewer`, filled with words as JSON and packed numbers.

#[cfg(test)]
#[path = "../../tests/common/page_check.rs"]
pub mod check;
pub mod packed;
pub mod pairs;
pub mod surface_data;

use serde_json::Value;

/// The places in a page that are filled here.
const TITLE: &str = "<!-- title -->";
const DATA: &str = "<!-- data -->";

/// Letters of a part of packed numbers; a multiple of four, so that each part is base64 of its own.
const LETTERS: usize = 1 << 18;

/// A page with its title and its data.
pub fn filled(page: &str, title: &str, data: &str) -> String {
    let (before, rest) = page.split_once(TITLE).unwrap_or((page, ""));
    let (between, after) = rest.split_once(DATA).unwrap_or((rest, ""));
    [before, &escaped(title), between, data, after].concat()
}

/// Packed numbers in parts, between which a browser can do other things while it reads the page.
pub fn island(name: &str, text: &str) -> String {
    let part = |letters: &[u8]| {
        let letters = String::from_utf8_lossy(letters);
        format!("<script type=\"text/plain\" data-of=\"{name}\">{letters}</script>\n")
    };
    text.as_bytes().chunks(LETTERS).map(part).collect()
}

/// JSON inside HTML: without `<` no tag begins or ends in it.
pub fn json_island(id: &str, value: &Value) -> String {
    let text = value.to_string().replace('<', "\\u003c");
    format!("<script type=\"application/json\" id=\"{id}\">{text}</script>\n")
}

/// Text inside an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
