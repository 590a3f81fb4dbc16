//! Progression as one self-contained HTML file; the page's `progression/container.js` reads it.

use crate::page::embed_file;
use crate::page::empty_pages::empty_page;

/// Returns the page, with the bytes `file` of an `.nmp` embedded.
pub fn create_page(name: &str, file: &[u8]) -> String {
    embed_file(empty_page("progression.html"), name, file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::check::check_page_loads_nothing;

    #[test]
    fn the_page_is_filled_and_loads_nothing() {
        let page = create_page("a.ply", b"bytes");
        assert!(page.contains("<title>a.ply - ") && page.contains("data-of=\"embedded\""));
        check_page_loads_nothing(&page);
    }
}
