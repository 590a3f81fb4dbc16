//! Hierarchy of clusters as one self-contained HTML file; the page's `container.js` reads it.

use serde_json::json;

use crate::page::packed::pack_bytes;
use crate::page::{data_script, fill_page, json_script};

const PAGE: &str = include_str!("../../viewer/dist/clusters.html");

/// Returns the page, with the bytes `file` of an `.nmc` embedded.
pub fn create_page(name: &str, file: &[u8]) -> String {
    let words = json_script("hierarchy", &json!({ "name": name }));
    let data = data_script("clusters", &pack_bytes(file));
    fill_page(PAGE, name, &(words + &data))
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::ops::ControlFlow;

    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    use neural_mesh::clusters::{ClusterOptions, Clusters, build_clusters};
    use neural_mesh::mesh::shapes;
    use neural_mesh::simplify::Input;

    use super::*;
    use crate::page::check::check_page_loads_nothing;

    fn hierarchy() -> Clusters {
        let mesh = shapes::icosphere(3);
        build_clusters(&Input::bare(&mesh), &ClusterOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn names_are_escaped_and_nothing_is_loaded() {
        let page = create_page("</script><!-- data --><img src=x onerror=alert(1)>&amp;", &hierarchy().to_bytes());
        assert!(!page.contains("<img src=x") && page.contains("<title>&lt;/script&gt;"));
        assert_eq!(page.matches("</script>").count(), PAGE.matches("</script>").count() + 2);
        check_page_loads_nothing(&page);
    }

    #[test]
    fn the_page_holds_the_hierarchy() {
        let page = create_page("a.ply", &hierarchy().to_bytes());
        let (_, text) = page.split_once("data-of=\"clusters\">").unwrap();
        let packed = STANDARD.decode(text.split_once('<').unwrap().0).unwrap();
        let mut bytes = Vec::new();
        flate2::read::DeflateDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
        assert!(bytes == hierarchy().to_bytes());
    }
}
