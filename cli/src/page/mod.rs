//! Self-contained HTML pages from templates of `cli/viewer`.

#[cfg(test)]
#[path = "../../tests/common/page_check.rs"]
pub mod check;
pub mod empty_pages;
pub mod packed;
pub mod pairs;
pub mod surface_data;

use serde_json::{Value, json};

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

/// Fills a template with the bytes of a file and the name that readers see.
pub fn embed_file(page: &str, name: &str, bytes: &[u8]) -> String {
    embed_file_with(page, name, bytes, (&Value::Null, ""))
}

/// Fills a template as [`embed_file`] does, with further facts (a JSON object or null) and scripts.
pub fn embed_file_with(page: &str, name: &str, bytes: &[u8], (facts, scripts): (&Value, &str)) -> String {
    let mut words = json!({ "name": name });
    for (key, value) in facts.as_object().into_iter().flatten() {
        words[key] = value.clone();
    }
    let file = data_script("embedded", &packed::pack_bytes(bytes));
    fill_page(page, name, &[&json_script("embedded", &words), &file, scripts].concat())
}

fn escape_html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;

    use super::*;

    const PAGE: &str = "<title><!-- title --></title>\n<!-- data -->\n<script></script>";

    #[test]
    fn names_are_escaped() {
        let page = embed_file(PAGE, "</script><!-- data --><img src=x onerror=alert(1)>&amp;", b"bytes");
        assert!(!page.contains("<img src=x") && page.contains("<title>&lt;/script&gt;"));
        assert_eq!(page.matches("</script>").count(), PAGE.matches("</script>").count() + 2);
    }

    #[test]
    fn pages_are_filled_and_load_nothing() {
        for name in ["clusters.html", "progression.html"] {
            let page = embed_file(empty_pages::empty_page(name), "a.ply", b"bytes");
            assert!(page.contains("<title>a.ply - ") && page.contains("data-of=\"embedded\""), "{name}");
            check::check_page_loads_nothing(&page);
        }
    }

    #[test]
    fn the_page_holds_the_bytes() {
        let bytes: Vec<u8> = (0..400_000u32).map(|i| (i.wrapping_mul(i) >> 7) as u8).collect();
        let page = embed_file(PAGE, "a.ply", &bytes);
        let elements = page.split("data-of=\"embedded\">").skip(1).map(|text| text.split_once('<').unwrap().0);
        let packed: Vec<u8> = elements.flat_map(|text| STANDARD.decode(text).unwrap()).collect();
        let mut unpacked = Vec::new();
        flate2::read::DeflateDecoder::new(&packed[..]).read_to_end(&mut unpacked).unwrap();
        assert!(unpacked == bytes);
    }
}
