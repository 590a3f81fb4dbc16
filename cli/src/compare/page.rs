//! A comparison as one HTML file that asks for nothing else: the viewer with the meshes and figures inside.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use neural_mesh::mesh::{TriMesh, irregular_edges};
use neural_mesh::metrics::{Painted, PaintedScale, nearest_on, painted_scale};
use neural_mesh::picture::toward_eye;
use serde_json::{Value, json};

use super::cover_data::{CoverData, CoverLayout};
use super::images::{FittedImage, Gallery};
use super::meshes::Named;
use super::packed::Packed;
use super::surface_data::SurfaceData;
use super::{Comparison, json};

/// The page without data; `scripts/viewer` makes it from `cli/viewer`.
const VIEWER: &str = include_str!("../../viewer/dist/viewer.html");

/// The places in the page that are filled here.
const TITLE: &str = "<!-- title -->";
const DATA: &str = "<!-- data -->";

/// Letters of a part of packed numbers; a multiple of four, so that each part is base64 of its own.
const LETTERS: usize = 1 << 18;

/// A page and what it cannot show, in one line each.
pub struct Page {
    /// The file.
    pub html: String,
    /// What is missing in it or smaller than in the files.
    pub notes: Vec<String>,
}

/// The page of a comparison.
pub fn page(comparison: &Comparison) -> Page {
    let (before, rest) = VIEWER.split_once(TITLE).unwrap_or((VIEWER, ""));
    let (between, after) = rest.split_once(DATA).unwrap_or((rest, ""));
    let title = escaped(&comparison.original.name);
    let (data, notes) = data(comparison);
    Page { html: [before, &title, between, &data, after].concat(), notes }
}

/// The scripts that hold the data: words as JSON, numbers packed. Beside them what could not be had.
fn data(comparison: &Comparison) -> (String, Vec<String>) {
    let Comparison { original, results, .. } = comparison;
    let meshes: Vec<&Named> = std::iter::once(original).chain(results.iter().map(|result| &result.mesh)).collect();
    let surfaces: Vec<SurfaceData> = meshes.iter().map(|named| packed(&named.mesh)).collect();
    let pairs = distances(comparison);
    let scale = scale(comparison, &pairs);
    let mut scripts = vec![island("surface-0", &surfaces[0].text)];
    for (at, pair) in pairs.iter().enumerate() {
        let mut values = Packed::default();
        surfaces[at + 1].pack_values(&mut values, &pair.of_result, scale.max);
        surfaces[0].pack_values(&mut values, &pair.of_original, scale.max);
        scripts.push(island(&format!("surface-{}", at + 1), &surfaces[at + 1].text));
        scripts.push(island(&format!("distances-{}", at + 1), &values.text()));
    }
    let Covered { covers, images, scripts: of_covers, notes } = covered(&meshes, &surfaces);
    scripts.extend(of_covers);
    let layouts: Vec<_> = surfaces.iter().map(|surface| &surface.layout).collect();
    let words = json!({
        "comparison": json::value(comparison),
        "surfaces": layouts,
        "covers": covers,
        "images": images,
        "scale": { "p95": scale.p95, "p99": scale.p99, "max": scale.max },
        "eye": toward_eye(&original.mesh),
    });
    scripts.insert(0, json_island(&words));
    (scripts.concat(), notes)
}

/// What covers the meshes, ready for the page.
struct Covered {
    /// For each mesh what the page needs to know of its cover; nothing where it has none.
    covers: Vec<Option<CoverLayout>>,
    /// The type of each image and its pixels; nothing where it could not be read.
    images: Vec<Option<Value>>,
    scripts: Vec<String>,
    notes: Vec<String>,
}

fn covered(meshes: &[&Named], surfaces: &[SurfaceData]) -> Covered {
    let (mut covers, mut scripts, mut gallery) = (Vec::new(), Vec::new(), Gallery::default());
    for (at, (named, surface)) in meshes.iter().zip(surfaces).enumerate() {
        let data = named.cover.as_ref().map(|worn| CoverData::new(&named.mesh, worn, surface, &mut gallery));
        scripts.extend(data.as_ref().map(|data| island(&format!("cover-{at}"), &data.text)));
        covers.push(data.map(|data| data.layout));
    }
    let note = |named: &&Named| named.notes.iter().map(|note| format!("{}: {note}", named.name)).collect::<Vec<_>>();
    let mut notes: Vec<String> = meshes.iter().flat_map(note).collect();
    let (fitted, of_images) = gallery.fitted();
    notes.extend(of_images);
    for (at, image) in fitted.iter().enumerate() {
        scripts.extend(image.as_ref().map(|image| island(&format!("image-{at}"), &STANDARD.encode(&image.bytes))));
    }
    let described = |image: &FittedImage| json!({ "type": image.kind, "width": image.width, "height": image.height });
    let images = fitted.iter().map(|image| image.as_ref().map(described)).collect();
    Covered { covers, images, scripts, notes }
}

fn packed(mesh: &TriMesh) -> SurfaceData {
    SurfaceData::new(mesh, &irregular_edges(mesh), Painted::new(mesh).steps)
}

/// Distances between the original and a result, at the painted points of each.
struct Distances {
    /// From the result to the original.
    of_result: Vec<f32>,
    /// From the original to the result.
    of_original: Vec<f32>,
}

fn distances(comparison: &Comparison) -> Vec<Distances> {
    let original = Painted::new(&comparison.original.mesh);
    let surface = nearest_on(&comparison.original.mesh);
    let pair = |result: &TriMesh| Distances {
        of_result: Painted::new(result).distances_to(&surface),
        of_original: original.distances_to(&nearest_on(result)),
    };
    comparison.results.iter().map(|result| pair(&result.mesh.mesh)).collect()
}

/// One scale over the surfaces of all pairs, each of the same weight.
fn scale(comparison: &Comparison, pairs: &[Distances]) -> PaintedScale {
    let shares_of_original = Painted::new(&comparison.original.mesh).shares();
    let mut weighed = Vec::new();
    for (result, pair) in comparison.results.iter().zip(pairs) {
        weighed.extend(pair.of_result.iter().copied().zip(Painted::new(&result.mesh.mesh).shares()));
        weighed.extend(pair.of_original.iter().copied().zip(shares_of_original.iter().copied()));
    }
    painted_scale(weighed)
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
    use crate::compare::Judged;
    use neural_mesh::mesh::shapes;
    use neural_mesh::metrics::Judging;

    fn html(name: &str) -> String {
        let named = |mesh: TriMesh| Named { name: name.into(), mesh, cover: None, notes: Vec::new() };
        let result = Judged { mesh: named(shapes::icosphere(1)), figures: Vec::new() };
        page(&Comparison {
            original: named(shapes::icosphere(2)),
            results: vec![result],
            judging: Judging::default(),
            n_eigenpairs: 0,
        })
        .html
    }

    #[test]
    fn names_cannot_leave_their_place() {
        let page = html("</script><!-- data --><img src=x onerror=alert(1)>&amp;");
        assert!(!page.contains("<img src=x"));
        assert_eq!(page.matches("</script>").count(), VIEWER.matches("</script>").count() + 4);
        assert!(page.contains("<title>&lt;/script&gt;"));
        assert!(page.contains("&amp;amp;"));
    }

    #[test]
    fn the_data_is_valid_json() {
        let page = html("a <b> & \"c\".ply");
        let start = page.find("id=\"comparison\">").unwrap() + "id=\"comparison\">".len();
        let length = page[start..].find("</script>").unwrap();
        let words: Value = serde_json::from_str(&page[start..start + length]).unwrap();
        assert_eq!(words["comparison"]["original"]["name"], "a <b> & \"c\".ply");
        assert_eq!(words["surfaces"][1]["faces"], 80);
    }

    #[test]
    fn nothing_in_the_page_points_elsewhere() {
        let page = html("a.ply");
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
