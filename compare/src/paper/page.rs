//! The paper's table as Markdown: means over the meshes and their ratios to QEM's, one section per share of vertices.

use std::collections::BTreeSet;

use super::PaperRow;
use crate::summary::markdown::{cells, number, table};

const INTRODUCTION: &str = "\
Means over the meshes; in brackets over QEM's, where it took part. Distances are in diagonals of the input's bounding box.

- *CD*: the paper's, between samples of both surfaces, mean squared distance to the nearest sample, both ways added up, x 1e6. \
The row *input* is the original against other samples of itself: so much of each CD is the spacing of the samples.
- *distance²*: the same from samples to the surface itself, x 1e6, which has no such floor.
- *Hausdorff*: the largest of these distances, percent.
- *NE*: mean of 1 - |n.n'|, n' the normal at the nearest point of the other surface, both ways, percent; *of result*: from the \
result to the original only; *angle*: the mean angle between the lines of these normals, radians.
- *WA*: edges without two faces, percent; *open*: those of them that do not lie on a border of the input.
- *network quotient* and so on: all triangles between the regions of the samples, without a classifier. The samples are the \
network's; *uniform* ones, each drawn by itself; *scattered* ones, drawn evenly in the way the network's are, apart from each \
other; *farthest* points along the edges.
- *seconds*: the simplification alone, one thread.
";

/// The page's part that the rows make.
pub fn page(rows: &[PaperRow], n_samples: usize) -> String {
    let meshes: BTreeSet<&str> = rows.iter().map(|row| row.mesh.as_str()).collect();
    let mut ratios: Vec<f64> = rows.iter().map(|row| row.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    let sections: String = ratios.iter().map(|&ratio| section(rows, ratio)).collect();
    format!("{INTRODUCTION}\n{} meshes, {n_samples} samples per surface.\n{sections}", meshes.len())
}

const METHODS: [&str; 8] = [
    "network",
    "network quotient",
    "uniform quotient",
    "scattered quotient",
    "farthest quotient",
    "qem",
    "meshoptimizer",
    "input",
];

fn section(rows: &[PaperRow], ratio: f64) -> String {
    let head = cells(&[
        "method",
        "results",
        "vertices / asked",
        "faces",
        "CD",
        "distance²",
        "Hausdorff",
        "NE",
        "NE of result",
        "angle",
        "WA",
        "open",
        "seconds",
    ]);
    let of = |method: &str| -> Vec<&PaperRow> {
        rows.iter().filter(|row| row.ratio == ratio && row.method == method).collect()
    };
    let qem = of("qem");
    let lines: Vec<Vec<String>> =
        METHODS.iter().filter(|method| !of(method).is_empty()).map(|method| line(method, &of(method), &qem)).collect();
    format!("\n### Ratio {ratio}\n\n{}", table(&head, &lines))
}

fn line<'a>(method: &str, all: &[&'a PaperRow], qem: &[&'a PaperRow]) -> Vec<String> {
    let with_faces = |rows: &[&'a PaperRow]| rows.iter().copied().filter(|row| row.faces > 0).collect::<Vec<_>>();
    let (rows, qem) = (with_faces(all), with_faces(qem));
    let plain = |figure: fn(&PaperRow) -> f64| number(mean(&rows, figure));
    let compared = |scale: f64, figure: fn(&PaperRow) -> f64| {
        let (ours, theirs) = (mean(&rows, figure), mean(&qem, figure));
        let over = ours.zip(theirs).filter(|(_, theirs)| *theirs > 0.0).map(|(ours, theirs)| ours / theirs);
        let over = over.map_or(String::new(), |over| format!(" ({})", number(Some(over))));
        format!("{}{over}", number(ours.map(|ours| scale * ours)))
    };
    vec![
        method.to_owned(),
        format!("{} of {}", rows.len(), all.len()),
        plain(|row| row.vertices as f64 / row.asked as f64),
        plain(|row| row.faces as f64),
        compared(1e6, |row| row.chamfer),
        compared(1e6, |row| row.mean_square),
        compared(1e2, |row| row.hausdorff),
        compared(1e2, |row| row.normal_error),
        compared(1e2, |row| row.normal_error_of_result),
        compared(1.0, |row| row.normal_angle),
        plain(|row| row.wa_percent),
        plain(|row| row.open_percent),
        plain(|row| row.seconds.unwrap_or(f64::NAN)),
    ]
}

fn mean(rows: &[&PaperRow], figure: fn(&PaperRow) -> f64) -> Option<f64> {
    (!rows.is_empty()).then(|| rows.iter().map(|row| figure(row)).sum::<f64>() / rows.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_stand_over_those_of_qem() {
        let row = |mesh: &str, method: &str, chamfer| PaperRow {
            mesh: mesh.into(),
            ratio: 0.1,
            method: method.into(),
            asked: 10,
            vertices: 10,
            faces: 20,
            chamfer,
            seconds: Some(1.0),
            ..PaperRow::default()
        };
        let failed = PaperRow { faces: 0, ..row("cat2", "network", 9.0) };
        let rows = [
            row("cat0", "network", 2e-6),
            row("cat1", "network", 4e-6),
            failed,
            row("cat0", "qem", 1e-6),
            row("cat1", "qem", 3e-6),
        ];
        let page = page(&rows, 50_000);
        assert!(page.contains("| network | 2 of 3 | 1.00 | 20.00 | 3.00 (1.50) |"), "{page}");
    }
}
