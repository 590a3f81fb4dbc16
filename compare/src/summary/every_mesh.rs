//! Every mesh at every ratio, one line each.

use super::cases::Cases;
use super::markdown::{cells, number, table};
use super::statistics::{Figure, median};
use crate::row::Row;

/// One table per ratio; values are medians over the seeds.
pub fn every_mesh(cases: &Cases) -> String {
    let tables = cases.ratios.iter().map(|&ratio| {
        let head = cells(&[
            "mesh",
            "faces",
            "faces left",
            "distance, ours (1e-4 of the diagonal)",
            "theirs",
            "ratio",
            "rms",
            "Hausdorff",
            "normals",
            "time, ours (ms)",
            "time ratio",
            "crossing, ours (theirs; input)",
            "turned, ours (theirs)",
        ]);
        let rows: Vec<_> = cases.meshes.iter().map(|mesh| line(cases, mesh, ratio)).collect();
        format!("#### Ratio {ratio}\n\n{}\n", table(&head, &rows))
    });
    tables.collect()
}

fn line(cases: &Cases, mesh: &str, ratio: f64) -> Vec<String> {
    let input = cases.input(mesh);
    let pairs = cases.pairs(mesh, ratio);
    let over_seeds = |figure: &dyn Fn(&Row) -> f64, ours: bool| {
        median(pairs.iter().map(|pair| figure(if ours { pair.ours } else { pair.theirs })).collect())
    };
    let count =
        |figure: &dyn Fn(&Row) -> f64, ours| over_seeds(figure, ours).map_or("-".to_owned(), |n| format!("{n:.0}"));
    let crossing = |row: &Row| row.self_intersecting_faces as f64;
    let turned = |row: &Row| row.turned_faces as f64;
    let mut cells = vec![mesh.to_owned(), input.map_or("-".to_owned(), |input| input.faces.to_string())];
    cells.push(count(&|row| row.faces as f64, true));
    cells.push(number(over_seeds(&|row| 1e4 * row.mean, true)));
    cells.push(number(over_seeds(&|row| 1e4 * row.mean, false)));
    for figure in [Figure::Mean, Figure::Rms, Figure::Hausdorff, Figure::NormalError] {
        cells.push(number(cases.ratio_of(figure, mesh, ratio)));
    }
    cells.push(number(over_seeds(&|row| 1e3 * row.seconds, true)));
    cells.push(number(cases.ratio_of(Figure::Time, mesh, ratio)));
    let before = input.map_or(0, |input| input.self_intersecting_faces);
    cells.push(format!("{} ({}; {before})", count(&crossing, true), count(&crossing, false)));
    cells.push(format!("{} ({})", count(&turned, true), count(&turned, false)));
    cells
}
