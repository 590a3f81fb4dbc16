//! A comparison as one HTML file that asks for nothing else: the viewer with the meshes and figures inside.

use neural_mesh::mesh::TriMesh;
use neural_mesh::picture::toward_eye;
use serde_json::{Value, json};

use super::marked::marked;
use super::packed::Packed;
use super::painted::{
    Distances, Scale, distances, points_of_faces, scale, shares_of_points, shares_of_vertices, steps, surface, vertices,
};
use super::surface_data::SurfaceData;
use super::{Comparison, json};

/// The page without data; `scripts/viewer` makes it from `cli/viewer`.
const VIEWER: &str = include_str!("../../viewer/dist/viewer.html");

/// The places in the page that are filled here.
const TITLE: &str = "<!-- title -->";
const DATA: &str = "<!-- data -->";

/// Letters of a part of packed numbers; a multiple of four, so that each part is base64 of its own.
const LETTERS: usize = 1 << 18;

/// The page.
pub fn html(comparison: &Comparison) -> String {
    let (before, rest) = VIEWER.split_once(TITLE).unwrap_or((VIEWER, ""));
    let (between, after) = rest.split_once(DATA).unwrap_or((rest, ""));
    let title = escaped(&comparison.original.name);
    [before, &title, between, &data(comparison), after].concat()
}

/// The scripts that hold the data: words as JSON, numbers packed.
fn data(comparison: &Comparison) -> String {
    let Comparison { original, results, .. } = comparison;
    let meshes = std::iter::once(original).chain(results.iter().map(|result| &result.mesh));
    let surfaces: Vec<SurfaceData> = meshes.map(|named| packed(&named.mesh)).collect();
    let pairs = painted(comparison);
    let scale = scale_of(comparison, &pairs);
    let mut scripts = vec![island("surface-0", &surfaces[0].text)];
    for (at, pair) in pairs.iter().enumerate() {
        let mut values = Packed::default();
        surfaces[at + 1].pack_values(&mut values, &pair.of_result, scale.max);
        surfaces[0].pack_values(&mut values, &pair.of_original, scale.max);
        scripts.push(island(&format!("surface-{}", at + 1), &surfaces[at + 1].text));
        scripts.push(island(&format!("distances-{}", at + 1), &values.text()));
    }
    let layouts: Vec<_> = surfaces.iter().map(|surface| &surface.layout).collect();
    let words = json!({
        "comparison": json::value(comparison),
        "surfaces": layouts,
        "scale": scale,
        "eye": toward_eye(&original.mesh),
    });
    scripts.insert(0, json_island(&words));
    scripts.concat()
}

fn packed(mesh: &TriMesh) -> SurfaceData {
    SurfaceData::new(mesh, &marked(mesh), steps(mesh))
}

fn painted(comparison: &Comparison) -> Vec<Distances> {
    let original = &comparison.original.mesh;
    let (surface_of_original, points_of_original) = (surface(original), painted_points(original));
    let pair = |result: &TriMesh| Distances {
        of_result: distances(&painted_points(result), &surface_of_original),
        of_original: distances(&points_of_original, &surface(result)),
    };
    comparison.results.iter().map(|result| pair(&result.mesh.mesh)).collect()
}

/// Where a mesh has distances.
fn painted_points(mesh: &TriMesh) -> Vec<[f64; 3]> {
    match steps(mesh) {
        1 => vertices(mesh),
        steps => points_of_faces(mesh, steps),
    }
}

fn scale_of(comparison: &Comparison, pairs: &[Distances]) -> Scale {
    let shares_of_original = painted_shares(&comparison.original.mesh);
    let mut weighed = Vec::new();
    for (result, pair) in comparison.results.iter().zip(pairs) {
        weighed.extend(pair.of_result.iter().copied().zip(painted_shares(&result.mesh.mesh)));
        weighed.extend(pair.of_original.iter().copied().zip(shares_of_original.iter().copied()));
    }
    scale(weighed)
}

/// What each of these points stands for.
fn painted_shares(mesh: &TriMesh) -> Vec<f64> {
    match steps(mesh) {
        1 => shares_of_vertices(mesh),
        steps => shares_of_points(mesh, steps),
    }
}

/// Packed numbers in parts, between which a browser can do other things while it reads the page.
fn island(name: &str, text: &str) -> String {
    let part = |letters: &[u8]| {
        let letters = String::from_utf8_lossy(letters);
        format!("<script type=\"text/plain\" data-of=\"{name}\">{letters}</script>\n")
    };
    text.as_bytes().chunks(LETTERS).map(part).collect()
}

/// JSON inside HTML: without `<` no tag begins or ends in it.
fn json_island(value: &Value) -> String {
    let text = value.to_string().replace('<', "\\u003c");
    format!("<script type=\"application/json\" id=\"comparison\">{text}</script>\n")
}

/// Text inside an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{Judged, Named};
    use neural_mesh::mesh::shapes;
    use neural_mesh::metrics::Judging;

    fn page(name: &str) -> String {
        let named = |mesh: TriMesh| Named { name: name.into(), mesh };
        let result = Judged { mesh: named(shapes::icosphere(1)), figures: Vec::new() };
        html(&Comparison { original: named(shapes::icosphere(2)), results: vec![result], judging: Judging::default() })
    }

    #[test]
    fn names_cannot_leave_their_place() {
        let page = page("</script><!-- data --><img src=x onerror=alert(1)>&amp;");
        assert!(!page.contains("<img src=x"));
        assert_eq!(page.matches("</script>").count(), VIEWER.matches("</script>").count() + 4);
        assert!(page.contains("<title>&lt;/script&gt;"));
        assert!(page.contains("&amp;amp;"));
    }

    #[test]
    fn the_data_is_valid_json() {
        let page = page("a <b> & \"c\".ply");
        let start = page.find("id=\"comparison\">").unwrap() + "id=\"comparison\">".len();
        let length = page[start..].find("</script>").unwrap();
        let words: Value = serde_json::from_str(&page[start..start + length]).unwrap();
        assert_eq!(words["comparison"]["original"]["name"], "a <b> & \"c\".ply");
        assert_eq!(words["surfaces"][1]["faces"], 80);
    }

    #[test]
    fn nothing_in_the_page_points_elsewhere() {
        let page = page("a.ply");
        for (at, scheme) in page.match_indices("http:").chain(page.match_indices("https:")) {
            let address = &page[at..page.len().min(at + 60)];
            // Names of XML languages, which nobody opens.
            assert!(address.starts_with("http://www.w3.org/"), "{scheme} in {address}");
        }
        // The icon is an empty one inside the page, so that browsers look for none.
        assert_eq!(page.matches("<link").count(), page.matches("<link rel=\"icon\" href=\"data:,\">").count());
        assert!(!page.contains(" src=\"") && !page.contains("@import"));
        assert!(page.contains("default-src 'none'"));
        assert!(page.contains("Permission is hereby granted"), "the licence of three.js is missing");
    }
}
