//! The rows in order: inputs, and what both methods made of them.

use crate::row::Row;
use crate::summary::statistics::{Figure, median};

/// Both results of one mesh at one ratio with one seed.
pub struct Pair<'a> {
    pub ours: &'a Row,
    pub theirs: &'a Row,
}

/// The table, with what can be asked of it.
pub struct Cases<'a> {
    rows: &'a [Row],
    /// Meshes in the order of their first rows.
    pub meshes: Vec<&'a str>,
    /// Ratios from the smallest to the largest.
    pub ratios: Vec<f64>,
}

impl<'a> Cases<'a> {
    pub fn new(rows: &'a [Row]) -> Self {
        let mut meshes: Vec<&str> = Vec::new();
        let mut ratios: Vec<f64> = Vec::new();
        for row in rows {
            if !meshes.contains(&row.mesh.as_str()) {
                meshes.push(&row.mesh);
            }
            if row.method != "input" && !ratios.contains(&row.ratio) {
                ratios.push(row.ratio);
            }
        }
        ratios.sort_by(f64::total_cmp);
        Self { rows, meshes, ratios }
    }

    pub fn input(&self, mesh: &str) -> Option<&'a Row> {
        self.rows.iter().find(|row| row.mesh == mesh && row.method == "input")
    }

    /// Rows of a method, failed ones too.
    pub fn of(&self, method: &str) -> impl Iterator<Item = &'a Row> {
        self.rows.iter().filter(move |row| row.method == method)
    }

    /// Seeds for which both methods have a result.
    pub fn pairs(&self, mesh: &str, ratio: f64) -> Vec<Pair<'a>> {
        let mine = self.of("ours").filter(|row| row.mesh == mesh && row.ratio == ratio && !row.failed());
        let with_theirs = |ours: &'a Row| {
            let theirs = self.rows.iter().find(|row| row.is_case(mesh, ratio, ours.seed, "meshoptimizer"))?;
            (!theirs.failed()).then_some(Pair { ours, theirs })
        };
        mine.filter_map(with_theirs).collect()
    }

    /// Median over the seeds of our figure over theirs.
    pub fn ratio_of(&self, figure: Figure, mesh: &str, ratio: f64) -> Option<f64> {
        median(self.pairs(mesh, ratio).iter().map(|pair| figure.ratio(pair.ours, pair.theirs)).collect())
    }

    /// One value per mesh (that `counts`) and ratio.
    pub fn ratios_of(&self, figure: Figure, ratios: &[f64], counts: impl Fn(&Row) -> bool) -> Vec<f64> {
        let counted = self.meshes.iter().filter(|mesh| self.input(mesh).is_some_and(&counts));
        counted.flat_map(|mesh| ratios.iter().filter_map(|&ratio| self.ratio_of(figure, mesh, ratio))).collect()
    }
}
