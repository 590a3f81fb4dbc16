//! Self-contained HTML pages from templates of `cli/viewer`.

#[cfg(test)]
#[path = "../../tests/common/page_check.rs"]
pub mod check;
pub mod packed;
pub mod pairs;
pub mod surface_data;

use serde_json::Value;

const TITLE: &str = "<!-- title -->";
const DATA: &str = "<!-- data -->";

/// Number of letters per script element; a multiple of four, so that each element is valid base64.
const LETTERS_PER_SCRIPT: usize = 1 << 18;

/// Fills title and data into a template.
pub fn fill_page(page: &str, title: &str, data: &str) -> String {
    let (before, rest) = page.split_once(TITLE).unwrap_or((page, ""));
    let (between, after) = rest.split_once(DATA).unwrap_or((rest, ""));
    [before, &escape_html(title), between, data, after].concat()
}

/// Splits packed numbers into several script elements, so that browsers stay responsive.
pub fn data_script(name: &str, text: &str) -> String {
    let script = |letters: &[u8]| {
        let letters = String::from_utf8_lossy(letters);
        format!("<script type=\"text/plain\" data-of=\"{name}\">{letters}</script>\n")
    };
    text.as_bytes().chunks(LETTERS_PER_SCRIPT).map(script).collect()
}

/// Embeds JSON in HTML; `<` is escaped so that no tag can start.
pub fn json_script(id: &str, value: &Value) -> String {
    let text = value.to_string().replace('<', "\\u003c");
    format!("<script type=\"application/json\" id=\"{id}\">{text}</script>\n")
}

fn escape_html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
