//! Comparison as one self-contained HTML file with viewer, meshes and measures.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use neural_mesh::appearance::{FlipMap, USUAL_HEIGHT, VIEWS, flip_map};
use neural_mesh::metrics::closest_point_tree;
use neural_mesh::picture::toward_eye;
use serde_json::{Value, json};

use super::comparison::Comparison;
use super::cover_data::{CoverData, CoverLayout};
use super::images::{FittedImage, Gallery};
use super::json;
use super::meshes::NamedMesh;
use crate::page::empty_pages::empty_page;
use crate::page::packed::pack_bytes;
use crate::page::pairs::{Distances, common_colour_scale, pack_surface};
use crate::page::surface_data::SurfaceData;
use crate::page::{data_script, fill_page, json_script};

/// Views of the maps: from front and back on both sides.
const MAPPED_VIEWS: [usize; 4] = [0, 1, 2, 3];

/// Page, with notes on missing or reduced content.
pub struct Page {
    pub html: String,
    pub notes: Vec<String>,
}

pub fn create_page(comparison: &Comparison) -> Page {
    let (data, notes) = page_data(comparison);
    Page { html: fill_page(empty_page("viewer.html"), &comparison.original.name, &data), notes }
}

fn page_data(comparison: &Comparison) -> (String, Vec<String>) {
    let Comparison { original, results, .. } = comparison;
    let meshes: Vec<&NamedMesh> = std::iter::once(original).chain(results.iter().map(|result| &result.mesh)).collect();
    let surfaces: Vec<SurfaceData> = meshes.iter().map(|named| pack_surface(&named.mesh)).collect();
    let pairs = distances(comparison);
    let result_meshes = results.iter().map(|result| &result.mesh.mesh);
    let scale = common_colour_scale(&original.mesh, result_meshes.zip(&pairs));
    let mut scripts = vec![data_script("surface-0", &surfaces[0].text)];
    for (at, pair) in pairs.iter().enumerate() {
        let result = &surfaces[at + 1];
        scripts.push(data_script(&format!("surface-{}", at + 1), &result.text));
        scripts.push(data_script(&format!("distances-{}", at + 1), &pair.pack(&surfaces[0], result, scale.max)));
    }
    let flip_layouts = pack_flip_maps(comparison, &mut scripts);
    let PackedCovers { covers, images, scripts: cover_scripts, notes } = pack_covers(&meshes, &surfaces);
    scripts.extend(cover_scripts);
    let layouts: Vec<_> = surfaces.iter().map(|surface| &surface.layout).collect();
    let json = json!({
        "comparison": json::to_json(comparison),
        "surfaces": layouts,
        "covers": covers,
        "images": images,
        "flip": flip_layouts,
        "scale": { "p95": scale.p95, "p99": scale.p99, "max": scale.max },
        "eye": toward_eye(&original.mesh),
    });
    scripts.insert(0, json_script("comparison", &json));
    (scripts.concat(), notes)
}

/// Packs maps of the FLIP error of each result, a byte per pixel, from four of the directions in which it is measured.
fn pack_flip_maps(comparison: &Comparison, scripts: &mut Vec<String>) -> Vec<Vec<[usize; 2]>> {
    let original = comparison.original.to_shaded();
    let mut layouts = Vec::new();
    for (at, result) in comparison.results.iter().enumerate() {
        let map = |&at: &usize| flip_map(original, result.mesh.to_shaded(), VIEWS[at], USUAL_HEIGHT);
        let maps: Vec<FlipMap> = MAPPED_VIEWS.iter().filter_map(map).collect();
        let byte = |error: &f32| (255.0 * error).round() as u8;
        let bytes: Vec<u8> = maps.iter().flat_map(|map| &map.errors).map(byte).collect();
        scripts.push(data_script(&format!("flip-{}", at + 1), &pack_bytes(&bytes)));
        layouts.push(maps.iter().map(|map| [map.width, map.errors.len() / map.width]).collect());
    }
    layouts
}

struct PackedCovers {
    covers: Vec<Option<CoverLayout>>,
    images: Vec<Option<Value>>,
    scripts: Vec<String>,
    notes: Vec<String>,
}

fn pack_covers(meshes: &[&NamedMesh], surfaces: &[SurfaceData]) -> PackedCovers {
    let (mut covers, mut scripts, mut gallery) = (Vec::new(), Vec::new(), Gallery::default());
    for (at, (named, surface)) in meshes.iter().zip(surfaces).enumerate() {
        let data = CoverData::new(named, surface, &mut gallery);
        scripts.extend(data.as_ref().map(|data| data_script(&format!("cover-{at}"), &data.text)));
        covers.push(data.map(|data| data.layout));
    }
    let note =
        |named: &&NamedMesh| named.notes.iter().map(|note| format!("{}: {note}", named.name)).collect::<Vec<_>>();
    let mut notes: Vec<String> = meshes.iter().flat_map(note).collect();
    let (fitted, image_notes) = gallery.fit_images();
    notes.extend(image_notes);
    for (at, image) in fitted.iter().enumerate() {
        scripts.extend(image.as_ref().map(|image| data_script(&format!("image-{at}"), &STANDARD.encode(&image.bytes))));
    }
    let image_entry = |image: &FittedImage| json!({ "type": image.kind, "width": image.width, "height": image.height });
    let images = fitted.iter().map(|image| image.as_ref().map(image_entry)).collect();
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
    use crate::compare::comparison::MeasuredResult;
    use crate::page::check::check_page_loads_nothing;
    use neural_mesh::mesh::{TriMesh, shapes};
    use neural_mesh::metrics::CompareOptions;

    fn html(name: &str) -> String {
        let named = |mesh: TriMesh| NamedMesh {
            name: name.into(),
            bytes: None,
            mesh,
            cover: None,
            normals: None,
            notes: Vec::new(),
        };
        let result = MeasuredResult { mesh: named(shapes::icosphere(1)), figures: Vec::new() };
        create_page(&Comparison {
            original: named(shapes::icosphere(2)),
            results: vec![result],
            options: CompareOptions::default(),
        })
        .html
    }

    #[test]
    fn names_are_escaped() {
        let page = html("</script><!-- data --><img src=x onerror=alert(1)>&amp;");
        assert!(!page.contains("<img src=x"));
        assert_eq!(page.matches("</script>").count(), empty_page("viewer.html").matches("</script>").count() + 5);
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
    fn the_page_loads_nothing() {
        check_page_loads_nothing(&html("a.ply"));
    }
}
