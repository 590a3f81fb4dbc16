//! The worst cases and their meshes, packed for the page.

use std::collections::BTreeMap;
use std::path::Path;

use crate::evaluate::{Table, WorstCase, worst_cases};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::closest_point_tree;
use neural_mesh::picture::toward_eye;
use neural_mesh::spatial::NearestOnTriangles;
use serde_json::{Value, json};

use neural_mesh_cli::shared::page::{
    Distances, SurfaceData, SurfaceLayout, common_colour_scale, data_script, pack_surface,
};

#[derive(Default)]
pub struct WorstCases {
    pub cases: Vec<Value>,
    pub surfaces: Vec<SurfaceLayout>,
    // Direction from which each surface is first viewed; `None` for results.
    pub eyes: Vec<Option<[f32; 3]>>,
    pub scripts: Vec<String>,
}

struct Original {
    mesh: TriMesh,
    near: NearestOnTriangles,
    data: SurfaceData,
    number: Option<usize>,
}

pub fn pack_worst_cases(folder: &Path, table: &Table, most_bytes: usize) -> WorstCases {
    let (mut cases, mut left) = (WorstCases::default(), most_bytes);
    let mut originals: BTreeMap<String, Option<Original>> = BTreeMap::new();
    for case in sort_by_rank(worst_cases(folder, table)) {
        let original = originals.entry(case.mesh.clone()).or_insert_with(|| case.original(folder).map(open_original));
        let shown = original.as_mut().and_then(|original| cases.add(original, &case.result(folder)?, &mut left));
        let WorstCase { mesh, ratio, seed, method, distance, quotient } = case;
        let mut entry = json!({
            "mesh": mesh, "ratio": ratio, "seed": seed, "method": method, "distance": distance, "quotient": quotient,
        });
        entry["shown"] = json!(shown);
        cases.cases.push(entry);
    }
    cases
}

fn sort_by_rank(worst: Vec<WorstCase>) -> Vec<WorstCase> {
    let mut ranks: BTreeMap<String, usize> = BTreeMap::new();
    let mut rank = |case: &WorstCase| {
        let next = ranks.entry(case.method.clone()).or_default();
        *next += 1;
        *next
    };
    let mut ranked: Vec<(usize, WorstCase)> = worst.into_iter().map(|case| (rank(&case), case)).collect();
    ranked.sort_by_key(|(rank, _)| *rank);
    ranked.into_iter().map(|(_, case)| case).collect()
}

fn open_original(mesh: TriMesh) -> Original {
    Original { near: closest_point_tree(&mesh), data: pack_surface(&mesh), mesh, number: None }
}

impl WorstCases {
    fn add(&mut self, original: &mut Original, result: &TriMesh, left: &mut usize) -> Option<Value> {
        let data = pack_surface(result);
        let n_mesh_bytes = data.text.len() + if original.number.is_none() { original.data.text.len() } else { 0 };
        // A case whose mesh cannot fit into the page is not measured.
        left.checked_sub(n_mesh_bytes)?;
        let distances = Distances::new((&original.mesh, &original.near), (result, &closest_point_tree(result)));
        let scale = common_colour_scale(&original.mesh, [(result, &distances)]);
        let (at, original_number) = (self.cases.len(), original.number.unwrap_or(self.surfaces.len()));
        let result_number = self.surfaces.len() + usize::from(original.number.is_none());
        let mut scripts = vec![
            data_script(&format!("surface-{result_number}"), &data.text),
            data_script(&format!("distances-{at}"), &distances.pack(&original.data, &data, scale.max)),
        ];
        if original.number.is_none() {
            scripts.push(data_script(&format!("surface-{original_number}"), &original.data.text));
        }
        // The description of two surfaces and a case takes fewer than 2000 bytes.
        *left = left.checked_sub(scripts.iter().map(String::len).sum::<usize>() + 2000)?;
        self.scripts.extend(scripts);
        if original.number.is_none() {
            self.surfaces.push(original.data.layout.clone());
            self.eyes.push(Some(toward_eye(&original.mesh)));
            original.number = Some(original_number);
        }
        self.surfaces.push(data.layout);
        self.eyes.push(None);
        let scale = json!({ "p95": scale.p95, "p99": scale.p99, "max": scale.max });
        Some(
            json!({ "original": original_number, "result": result_number, "distances": format!("distances-{at}"), "scale": scale }),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn originals_are_packed_once_and_cases_over_the_limit_are_left_out() {
        let mut cases = WorstCases::default();
        let mut sphere = open_original(shapes::icosphere(3));
        let mut torus = open_original(shapes::torus(24, 12, 2.0, 0.5));
        let mut left = 1 << 20;
        let result = shapes::icosphere(1);
        let mut add = |original: &mut Original| {
            cases.add(original, &result, &mut left).map(|words| [words["original"].clone(), words["result"].clone()])
        };
        assert_eq!(
            [add(&mut sphere), add(&mut torus), add(&mut sphere)]
                .map(|found| found.map(|[a, b]| (a.as_u64(), b.as_u64()))),
            [Some((Some(0), Some(1))), Some((Some(2), Some(3))), Some((Some(0), Some(4)))]
        );
        let names =
            |cases: &WorstCases| cases.scripts.iter().filter(|text| text.contains("data-of=\"surface-")).count();
        assert_eq!((cases.surfaces.len(), names(&cases)), (5, 5));
        assert!(cases.add(&mut torus, &result, &mut 100).is_none() && cases.surfaces.len() == 5);
        let used: usize = cases.scripts.iter().map(String::len).sum();
        assert!(left + used <= 1 << 20);
    }

    #[test]
    fn the_worst_of_every_method_comes_first() {
        let case = |method: &str, mesh: &str| WorstCase {
            mesh: mesh.into(),
            ratio: 0.1,
            seed: 0,
            method: method.into(),
            distance: 1.0,
            quotient: None,
        };
        let ranked = sort_by_rank(vec![case("a", "1"), case("a", "2"), case("b", "3"), case("b", "4")]);
        assert_eq!(ranked.iter().map(|case| case.mesh.as_str()).collect::<Vec<_>>(), ["1", "3", "2", "4"]);
    }
}
