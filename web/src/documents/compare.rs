//! Comparison of simplified meshes with an original.

use std::ops::ControlFlow;

use neural_mesh::io::Folder;
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{TriMesh, irregular_edges, move_to_common_frame};
use neural_mesh::metrics::{CompareOptions, Figure, PaintedMesh, ReferenceMesh, closest_point_tree, compare};
use neural_mesh::spatial::NearestOnTriangles;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::file::File;
use super::look::read_scene;
use crate::message::{Answer, Message, ProgressListener};
use crate::refusal::Refusal;

#[derive(Deserialize)]
struct CompareRequest {
    original: File,
    results: Vec<File>,
    samples: Option<usize>,
}

/// Compares each result with the original: all measures, and distances at sample points in both directions.
pub fn compare_files(
    message: &Message,
    json: Value,
    answer: &mut Answer,
    mut listener: ProgressListener,
) -> Result<Value, Refusal> {
    let request_json: CompareRequest = serde_json::from_value(json)?;
    let files: Vec<&File> = std::iter::once(&request_json.original).chain(&request_json.results).collect();
    let mut cleaned = Vec::new();
    for file in &files {
        let (bytes, folder) = file.open(message)?;
        let Cleaned { mesh, frame, .. } = read_mesh(file, bytes, &folder)?;
        cleaned.push((mesh, frame));
    }
    let meshes = move_to_common_frame(cleaned).map_err(Refusal::new)?;
    let mut options = CompareOptions::default();
    options.samples = request_json.samples.unwrap_or(options.samples);
    let Some((original, results)) = meshes.split_first() else { return Err(Refusal::new("there is no original")) };
    let (prepared, near) = (ReferenceMesh::new(original, &options), closest_point_tree(original));
    let (mut figures_of_results, mut distances) = (Vec::new(), Vec::new());
    for (number, result) in results.iter().enumerate() {
        if listener(number as f64 / results.len() as f64, 3).is_break() {
            return Err(Refusal { what: "interrupted".into(), is_interrupted: true });
        }
        figures_of_results.push(compare(&prepared, result));
        distances.push(add_distances([original, result], &near, answer));
    }
    let _: ControlFlow<()> = listener(1.0, 3);
    let surfaces: Vec<Value> = meshes.iter().map(|mesh| add_surface(mesh, answer)).collect();
    let figures = figures_of_results.first().map_or(&[][..], |figures| figures);
    let named = request_json.results.iter().zip(results).zip(&figures_of_results);
    let comparison = json!({
        "program": concat!("neural-mesh ", env!("CARGO_PKG_VERSION")),
        "settings": { "samples": options.samples, "seed": options.seed },
        "original": original_entry(&request_json.original.name, original),
        "figures": figures.iter().map(|it| json!({ "name": it.name, "unit": it.unit, "about": it.about })).collect::<Vec<_>>(),
        "results": named.map(|((file, mesh), figures)| with_values(size_of(&file.name, mesh), figures)).collect::<Vec<_>>(),
    });
    Ok(json!({ "comparison": comparison, "surfaces": surfaces, "distances": distances }))
}

/// Adds the distances at sample points of both meshes to the other mesh; returns where they are in the answer.
fn add_distances([original, result]: [&TriMesh; 2], near: &NearestOnTriangles, answer: &mut Answer) -> Value {
    let painted = [
        PaintedMesh::new(result).distances_to(near),
        PaintedMesh::new(original).distances_to(&closest_point_tree(result)),
    ];
    let [of_result, of_original] = painted.map(|values| answer.add_numbers(values, f32::to_le_bytes));
    json!({ "of_result": of_result, "of_original": of_original })
}

fn read_mesh(file: &File, bytes: &[u8], folder: &Folder) -> Result<Cleaned, Refusal> {
    let (raw, ..) = read_scene(bytes, &file.name, folder).map_err(|error| file.refusal(error))?;
    clean(raw, &CleanOptions::default()).map_err(|error| file.refusal(error))
}

/// Adds a surface to the answer; returns its arrays' numbers, and the samples along a face's side.
fn add_surface(mesh: &TriMesh, answer: &mut Answer) -> Value {
    let positions = answer.add_numbers(mesh.positions().iter().copied().flatten(), f32::to_le_bytes);
    let faces = answer.add_numbers(mesh.faces().iter().copied().flatten(), u32::to_le_bytes);
    json!({ "positions": positions, "faces": faces, "steps": PaintedMesh::new(mesh).steps })
}

fn size_of(name: &str, mesh: &TriMesh) -> Map<String, Value> {
    let counts = [("vertices", mesh.positions().len()), ("faces", mesh.faces().len())];
    let named = std::iter::once(("name".to_string(), json!(name)));
    named.chain(counts.map(|(of, n)| (of.to_string(), json!(n)))).collect()
}

fn original_entry(name: &str, mesh: &TriMesh) -> Map<String, Value> {
    let mut entry = size_of(name, mesh);
    let edges = irregular_edges(mesh);
    entry.insert("boundary_edges".into(), json!(edges.open.len()));
    entry.insert("non_manifold_edges".into(), json!(edges.non_manifold.len()));
    entry
}

fn with_values(mut size: Map<String, Value>, figures: &[Figure]) -> Value {
    let values: Map<String, Value> =
        figures.iter().map(|figure| (figure.name.to_string(), json!(figure.value))).collect();
    size.insert("values".into(), values.into());
    size.into()
}
