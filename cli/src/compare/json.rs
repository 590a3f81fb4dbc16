//! Comparison as JSON.

use neural_mesh::metrics::Figure;
use serde_json::{Map, Value, json};

use super::{Comparison, MeasuredResult, Named};

pub fn value(comparison: &Comparison) -> Value {
    let Comparison { original, results, judging, .. } = comparison;
    let figures = results.first().map_or(&[][..], |result| &result.figures);
    json!({
        "program": concat!("neural-mesh ", env!("CARGO_PKG_VERSION")),
        "settings": {
            "samples": judging.samples,
            "seed": judging.seed,
        },
        "original": size(original),
        "figures": figures.iter().map(describe).collect::<Vec<_>>(),
        "results": results.iter().map(result).collect::<Vec<_>>(),
    })
}

fn describe(figure: &Figure) -> Value {
    json!({ "name": figure.name, "unit": figure.unit, "about": figure.about })
}

fn size(named: &Named) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("name".into(), named.name.clone().into());
    map.insert("vertices".into(), named.mesh.positions().len().into());
    map.insert("faces".into(), named.mesh.faces().len().into());
    map
}

fn result(judged: &MeasuredResult) -> Map<String, Value> {
    let mut map = size(&judged.mesh);
    let values: Map<_, _> = judged.figures.iter().map(|figure| (figure.name.into(), figure.value.into())).collect();
    map.insert("values".into(), values.into());
    map
}
