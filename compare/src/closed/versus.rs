//! One contestant's figures over another's: medians over meshes and ratios.

use crate::row::Row;
use crate::summary::markdown::{cells, number, table};
use crate::summary::statistics::{Figure, median, quantile};

/// The figures that count together.
const THREE: [Figure; 3] = [Figure::Mean, Figure::NormalError, Figure::Hausdorff];

/// Two contestants in one table.
#[derive(Clone, Copy)]
pub struct Versus<'a> {
    rows: &'a [Row],
    of: &'a str,
    over: &'a str,
}

impl<'a> Versus<'a> {
    pub fn new(rows: &'a [Row], of: &'a str, over: &'a str) -> Self {
        Self { rows, of, over }
    }

    /// Median over the seeds of one figure over the other.
    pub fn ratio(&self, figure: Figure, mesh: &str, ratio: f64) -> Option<f64> {
        let mine = self.rows.iter().filter(|row| row.method == self.of && row.mesh == mesh && row.ratio == ratio);
        let with_other = |mine: &'a Row| {
            let other = self.rows.iter().find(|row| row.is_case(mesh, ratio, mine.seed, self.over))?;
            (!mine.failed() && !other.failed()).then(|| figure.ratio(mine, other))
        };
        median(mine.filter_map(with_other).collect())
    }

    /// One value per mesh and ratio.
    fn values(&self, figure: Figure, ratios: &[f64]) -> Vec<f64> {
        let meshes = meshes(self.rows);
        meshes.iter().flat_map(|mesh| ratios.iter().filter_map(|&ratio| self.ratio(figure, mesh, ratio))).collect()
    }

    fn median_and_worst(&self, figure: Figure, ratios: &[f64]) -> String {
        let values = self.values(figure, ratios);
        format!("{} ({})", number(median(values.clone())), number(quantile(values, 0.9)))
    }

    /// Geometric mean of the medians of distance, normal error and Hausdorff.
    fn three(&self, ratios: &[f64]) -> Option<f64> {
        geometric_mean(THREE.iter().filter_map(|&figure| median(self.values(figure, ratios))).collect())
    }

    /// A row per figure; a column per ratio, then all of them.
    pub fn by_ratio(&self) -> String {
        let ratios = ratios(self.rows);
        let mut groups: Vec<Vec<f64>> = ratios.iter().map(|&ratio| vec![ratio]).collect();
        groups.push(ratios.clone());
        let mut head = vec![format!("{} / {}: median (90th percentile)", self.of, self.over)];
        head.extend(ratios.iter().map(f64::to_string));
        head.extend(cells(&["all", "geometric mean, all"]));
        let mean = |figure: Figure| geometric_mean(self.values(figure, &ratios));
        let row = |&figure: &Figure| {
            let figures = groups.iter().map(|group| self.median_and_worst(figure, group));
            [figure.title().to_owned()].into_iter().chain(figures).chain([number(mean(figure))]).collect()
        };
        let mut rows: Vec<Vec<String>> = THREE.iter().map(row).collect();
        let of_means = geometric_mean(THREE.iter().filter_map(|&figure| mean(figure)).collect());
        let three = groups.iter().map(|group| number(self.three(group))).chain([number(of_means)]);
        rows.push(["geometric mean of the three".to_owned()].into_iter().chain(three).collect());
        rows.push(row(&Figure::Time));
        table(&head, &rows)
    }

    /// One row: every figure over all `ratios`.
    fn row(&self, ratios: &[f64]) -> Vec<String> {
        let three = THREE.iter().map(|&figure| self.median_and_worst(figure, ratios));
        let rest = [number(self.three(ratios)), self.median_and_worst(Figure::Time, ratios)];
        [self.of.to_owned()].into_iter().chain(three).chain(rest).collect()
    }
}

/// A row per contestant, over `over`, at `ratios`.
pub fn all_over(rows: &[Row], contestants: &[&str], over: &str, ratios: &[f64]) -> String {
    let mut head = vec![format!("over {over}: median (90th percentile)")];
    head.extend(THREE.iter().map(|figure| figure.title().to_owned()));
    head.extend(cells(&["geometric mean of the three", "time"]));
    let lines: Vec<Vec<String>> = contestants.iter().map(|of| Versus::new(rows, of, over).row(ratios)).collect();
    table(&head, &lines)
}

/// The meshes in the order of their first rows.
pub fn meshes(rows: &[Row]) -> Vec<&str> {
    let mut meshes: Vec<&str> = Vec::new();
    rows.iter().for_each(|row| meshes.extend((!meshes.contains(&row.mesh.as_str())).then_some(&*row.mesh)));
    meshes
}

/// The ratios from the smallest to the largest.
pub fn ratios(rows: &[Row]) -> Vec<f64> {
    let mut ratios: Vec<f64> = rows.iter().filter(|row| row.method != "input").map(|row| row.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    ratios
}

fn geometric_mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| (values.iter().map(|x| x.ln()).sum::<f64>() / values.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, seed: u64, mean: f64) -> Row {
        let [mesh, method] = ["ball", method].map(str::to_owned);
        Row { mesh, ratio: 0.5, seed, method, mean, normal_error: 0.1, hausdorff: 0.1, seconds: 1.0, ..Row::default() }
    }

    #[test]
    fn seeds_have_their_median_and_figures_their_geometric_mean() {
        let mut rows = vec![];
        for (seed, mean) in [(0, 2e-4), (1, 8e-4), (2, 9e-4)] {
            rows.extend([row("network", seed, mean), row("geometry", seed, 1e-4)]);
        }
        rows.push(Row { outcome: "failed: panicked".into(), ..row("network", 3, 0.0) });
        let text = Versus::new(&rows, "network", "geometry").by_ratio();
        assert!(text.contains("| distance, mean | 8.00 (8.00) | 8.00 (8.00) | 8.00 |"), "{text}");
        assert!(text.contains("| geometric mean of the three | 2.00 | 2.00 | 2.00 |"), "{text}");
        let text = all_over(&rows, &["network"], "geometry", &[0.5]);
        assert!(text.contains("| network | 8.00 (8.00) | 1.00 (1.00) | 1.00 (1.00) | 2.00 | 1.00 (1.00) |"), "{text}");
    }
}
