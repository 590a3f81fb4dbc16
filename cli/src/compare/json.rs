//! Comparison as JSON.

use neural_mesh::mesh::irregular_edges;
use neural_mesh::metrics::Figure;
use serde_json::{Map, Value, json};

use super::comparison::{Comparison, MeasuredResult};
use super::meshes::NamedMesh;

pub fn to_json(comparison: &Comparison) -> Value {
    let Comparison { original, results, options, .. } = comparison;
    let figures = results.first().map_or(&[][..], |result| &result.figures);
    json!({
        "program": concat!("neural-mesh ", env!("CARGO_PKG_VERSION")),
        "settings": {
            "samples": options.samples,
            "seed": options.seed,
        },
        "original": original_entry(original),
        "figures": figures.iter().map(figure_entry).collect::<Vec<_>>(),
        "results": results.iter().map(result_entry).collect::<Vec<_>>(),
    })
}

fn figure_entry(figure: &Figure) -> Value {
    json!({ "name": figure.name, "unit": figure.unit, "about": figure.about })
}

fn mesh_entry(named: &NamedMesh) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("name".into(), named.name.clone().into());
    map.insert("vertices".into(), named.mesh.positions().len().into());
    map.insert("faces".into(), named.mesh.faces().len().into());
    map.extend(named.bytes.map(|bytes| ("bytes".to_string(), bytes.into())));
    map
}

/// Describes the original with its irregular edges, by which a reader judges those of results.
fn original_entry(original: &NamedMesh) -> Map<String, Value> {
    let mut map = mesh_entry(original);
    let edges = irregular_edges(&original.mesh);
    map.insert("boundary_edges".into(), edges.open.len().into());
    map.insert("non_manifold_edges".into(), edges.non_manifold.len().into());
    map
}

fn result_entry(result: &MeasuredResult) -> Map<String, Value> {
    let mut map = mesh_entry(&result.mesh);
    let values: Map<_, _> = result.figures.iter().map(|figure| (figure.name.into(), figure.value.into())).collect();
    map.insert("values".into(), values.into());
    map
}
