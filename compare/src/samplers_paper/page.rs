//! The table of samplers as Markdown: means over the meshes, over those of uniform sampling with replacement.

use super::PointRow;
use crate::summary::markdown::{cells, number, table};

const INTRODUCTION: &str = "\
The drawn vertices as a set of points against all vertices of the input without noise. Means over meshes and seeds; in \
brackets over those of uniform sampling with replacement, of which vertices that were drawn twice count once.

- *CD*: mean squared distance to the nearest point of the other set, both ways added up, x 1e6, in diagonals of the bounding box.
- *curvature*: mean squared difference of the smoothed surface variation at nearest points, both ways added up, x 1e4.
- *ms*: scores and drawing, one thread.
";

/// Whose figures the others stand over.
const REFERENCE: &str = "uniform, with replacement";

/// The page's part that the rows make.
pub fn page(rows: &[PointRow]) -> String {
    let mut noises: Vec<f64> = rows.iter().map(|row| row.noise).collect();
    noises.sort_by(f64::total_cmp);
    noises.dedup();
    let sections: String = noises.iter().map(|&noise| section(rows, noise)).collect();
    format!("{INTRODUCTION}{sections}")
}

fn section(rows: &[PointRow], noise: f64) -> String {
    let of_noise: Vec<&PointRow> = rows.iter().filter(|row| row.noise == noise).collect();
    let mut ratios: Vec<f64> = of_noise.iter().map(|row| row.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    let mut head = cells(&["sampler"]);
    for ratio in &ratios {
        head.extend([format!("CD at {ratio}"), "curvature".to_owned(), "ms".to_owned()]);
    }
    let mut samplers: Vec<&str> = Vec::new();
    of_noise
        .iter()
        .for_each(|row| samplers.extend((!samplers.contains(&row.sampler.as_str())).then_some(&*row.sampler)));
    let line = |sampler: &&str| {
        let figures = ratios.iter().flat_map(|&ratio| figures(&of_noise, ratio, sampler));
        std::iter::once((*sampler).to_owned()).chain(figures).collect()
    };
    let lines: Vec<Vec<String>> = samplers.iter().map(line).collect();
    format!("\n### Noise {noise} %\n\n{}", table(&head, &lines))
}

fn figures(rows: &[&PointRow], ratio: f64, sampler: &str) -> [String; 3] {
    let mean = |sampler: &str, figure: fn(&PointRow) -> f64| {
        let values: Vec<f64> =
            rows.iter().filter(|row| row.ratio == ratio && row.sampler == sampler).map(|row| figure(row)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let compared = |scale: f64, figure: fn(&PointRow) -> f64| {
        let own = mean(sampler, figure);
        let over = own.zip(mean(REFERENCE, figure)).map(|(own, reference)| own / reference);
        format!("{} ({})", number(own.map(|own| scale * own)), number(over))
    };
    [
        compared(1e6, |row| row.chamfer),
        compared(1e4, |row| row.curvature_error),
        number(mean(sampler, |row| 1e3 * row.seconds)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_stand_over_those_of_uniform_sampling() {
        let row = |sampler: &str, chamfer| PointRow {
            mesh: "cat0".into(),
            ratio: 0.2,
            sampler: sampler.into(),
            chamfer,
            curvature_error: 1e-4,
            seconds: 0.002,
            ..PointRow::default()
        };
        let page = page(&[row(REFERENCE, 4e-6), row("network", 2e-6)]);
        assert!(page.contains("| network | 2.00 (0.50) | 1.00 (1.00) | 2.00 |"), "{page}");
    }
}
