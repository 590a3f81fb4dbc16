//! Hierarchy of clusters as one self-contained HTML file; the page's `clusters/container.js` reads it.

use super::paints::ClusterPaints;
use crate::page::embed_file_with;
use crate::page::empty_pages::empty_page;

/// Returns the page, with the bytes `file` of an `.nmc` and the paints of its materials embedded.
pub fn create_page(name: &str, file: &[u8], paints: &ClusterPaints) -> String {
    embed_file_with(empty_page("clusters.html"), name, file, (&paints.facts, &paints.scripts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::check::check_page_loads_nothing;

    #[test]
    fn the_page_is_filled_and_loads_nothing() {
        let page = create_page("a.ply", b"bytes", &ClusterPaints::default());
        assert!(page.contains("<title>a.ply - ") && page.contains("data-of=\"embedded\""));
        check_page_loads_nothing(&page);
    }
}
