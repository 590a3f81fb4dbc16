//! Comparison as JSON.

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
        "original": mesh_entry(original),
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
    map
}

fn result_entry(result: &MeasuredResult) -> Map<String, Value> {
    let mut map = mesh_entry(&result.mesh);
    let values: Map<_, _> = result.figures.iter().map(|figure| (figure.name.into(), figure.value.into())).collect();
    map.insert("values".into(), values.into());
    map
}
