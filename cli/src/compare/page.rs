//! Comparison as one self-contained HTML file with viewer, meshes and measures.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use neural_mesh::metrics::closest_point_tree;
use neural_mesh::picture::toward_eye;
use serde_json::{Value, json};

use super::cover_data::{CoverData, CoverLayout};
use super::images::{FittedImage, Gallery};
use super::meshes::Named;
use super::{Comparison, json};
use crate::page::pairs::{Distances, scale, surface};
use crate::page::surface_data::SurfaceData;
use crate::page::{fill_page, island, json_island};

const VIEWER: &str = include_str!("../../viewer/dist/viewer.html");

/// Page, with notes on missing or reduced content.
pub struct Page {
    pub html: String,
    pub notes: Vec<String>,
}

pub fn page(comparison: &Comparison) -> Page {
    let (data, notes) = data(comparison);
    Page { html: fill_page(VIEWER, &comparison.original.name, &data), notes }
}

fn data(comparison: &Comparison) -> (String, Vec<String>) {
    let Comparison { original, results, .. } = comparison;
    let meshes: Vec<&Named> = std::iter::once(original).chain(results.iter().map(|result| &result.mesh)).collect();
    let surfaces: Vec<SurfaceData> = meshes.iter().map(|named| surface(&named.mesh)).collect();
    let pairs = distances(comparison);
    let of_results = results.iter().map(|result| &result.mesh.mesh);
    let scale = scale(&original.mesh, of_results.zip(&pairs));
    let mut scripts = vec![island("surface-0", &surfaces[0].text)];
    for (at, pair) in pairs.iter().enumerate() {
        let result = &surfaces[at + 1];
        scripts.push(island(&format!("surface-{}", at + 1), &result.text));
        scripts.push(island(&format!("distances-{}", at + 1), &pair.pack(&surfaces[0], result, scale.max)));
    }
    let PackedCovers { covers, images, scripts: of_covers, notes } = pack_covers(&meshes, &surfaces);
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
    scripts.insert(0, json_island("comparison", &words));
    (scripts.concat(), notes)
}

struct PackedCovers {
    covers: Vec<Option<CoverLayout>>,
    images: Vec<Option<Value>>,
    scripts: Vec<String>,
    notes: Vec<String>,
}

fn pack_covers(meshes: &[&Named], surfaces: &[SurfaceData]) -> PackedCovers {
    let (mut covers, mut scripts, mut gallery) = (Vec::new(), Vec::new(), Gallery::default());
    for (at, (named, surface)) in meshes.iter().zip(surfaces).enumerate() {
        let data = named.cover.as_ref().map(|worn| CoverData::new(&named.mesh, worn, surface, &mut gallery));
        scripts.extend(data.as_ref().map(|data| island(&format!("cover-{at}"), &data.text)));
        covers.push(data.map(|data| data.layout));
    }
    let note = |named: &&Named| named.notes.iter().map(|note| format!("{}: {note}", named.name)).collect::<Vec<_>>();
    let mut notes: Vec<String> = meshes.iter().flat_map(note).collect();
    let (fitted, of_images) = gallery.fit_images();
    notes.extend(of_images);
    for (at, image) in fitted.iter().enumerate() {
        scripts.extend(image.as_ref().map(|image| island(&format!("image-{at}"), &STANDARD.encode(&image.bytes))));
    }
    let described = |image: &FittedImage| json!({ "type": image.kind, "width": image.width, "height": image.height });
    let images = fitted.iter().map(|image| image.as_ref().map(described)).collect();
    PackedCovers { covers, images, scripts, notes }
}

fn distances(comparison: &Comparison) -> Vec<Distances> {
    let original = &comparison.original.mesh;
    let near = closest_point_tree(original);
    let meshes = comparison.results.iter().map(|result| &result.mesh.mesh);
    meshes.map(|mesh| Distances::new((original, &near), (mesh, &closest_point_tree(mesh)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::MeasuredResult;
    use crate::page::check::check_points_nowhere;
    use neural_mesh::mesh::{TriMesh, shapes};
    use neural_mesh::metrics::CompareOptions;

    fn html(name: &str) -> String {
        let named = |mesh: TriMesh| Named { name: name.into(), mesh, cover: None, normals: None, notes: Vec::new() };
        let result = MeasuredResult { mesh: named(shapes::icosphere(1)), figures: Vec::new() };
        page(&Comparison {
            original: named(shapes::icosphere(2)),
            results: vec![result],
            judging: CompareOptions::default(),
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
        check_points_nowhere(&html("a.ply"));
    }
}
