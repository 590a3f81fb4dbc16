//! Pages without data, made by `scripts/viewer` and embedded as one compressed file.

use std::collections::HashMap;
use std::io::Read;
use std::sync::LazyLock;

use flate2::read::GzDecoder;

/// JSON object of names and texts, compressed by gzip.
const FILE: &[u8] = include_bytes!("../../viewer/dist/pages.gz");

static PAGES: LazyLock<HashMap<String, String>> = LazyLock::new(|| {
    let mut json = String::new();
    let unpacked = GzDecoder::new(FILE).read_to_string(&mut json);
    unpacked.ok().and_then(|_| serde_json::from_str(&json).ok()).unwrap_or_default()
});

/// Returns the page of this name: `viewer.html`, `clusters.html` or `progression.html`.
pub fn empty_page(name: &str) -> &'static str {
    PAGES.get(name).map_or("", String::as_str)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pages_are_there_with_their_licence() {
        for name in ["viewer.html", "clusters.html", "progression.html"] {
            assert!(empty_page(name).contains(include_str!("../../viewer/dist/LICENSE-three").trim()), "{name}");
        }
        assert_eq!(PAGES.len(), 3);
    }
}
