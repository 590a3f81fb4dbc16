//! Quotients of figures over a reference method's.

use crate::evaluate::{ResultRow, Table, median};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    Distance,
    Largest,
    Normals,
    Time,
}

impl Figure {
    pub const ALL: [Self; 4] = [Self::Distance, Self::Largest, Self::Normals, Self::Time];

    pub fn title(self) -> &'static str {
        match self {
            Self::Distance => "mean distance",
            Self::Largest => "largest distance",
            Self::Normals => "normal error",
            Self::Time => "time",
        }
    }

    fn value(self, table: &Table, row: &ResultRow) -> Option<f64> {
        // Smaller values are noise of single precision or of the clock.
        let (value, noise) = match self {
            Self::Distance => (table.figure(row, "distance_mean"), 1e-5),
            Self::Largest => (table.figure(row, "distance_max"), 1e-5),
            Self::Normals => (table.figure(row, "normal_error_signed"), 1e-6),
            Self::Time => (row.seconds, 1e-6),
        };
        Some(value?.max(noise))
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct MeshQuotient {
    pub mesh: String,
    pub quotient: f64,
}

#[derive(Clone, Copy)]
pub struct Quotients<'a> {
    pub table: &'a Table,
    pub over: &'a str,
}

impl Quotients<'_> {
    pub fn mesh_quotients(&self, method: &str, figure: Figure, ratio: f64) -> Vec<MeshQuotient> {
        let of_mesh =
            |mesh: String| Some(MeshQuotient { quotient: self.mesh_quotient(&mesh, method, figure, ratio)?, mesh });
        self.meshes().into_iter().filter_map(of_mesh).collect()
    }

    fn mesh_quotient(&self, mesh: &str, method: &str, figure: Figure, ratio: f64) -> Option<f64> {
        let is_case = |row: &&ResultRow| row.mesh == mesh && row.ratio == ratio && row.error.is_empty();
        let rows = self.table.rows.iter().filter(|row| is_case(row) && row.method == method);
        let quotient = |row: &ResultRow| {
            let mut others = self.table.rows.iter().filter(|other| is_case(other) && other.method == self.over);
            let other = others.find(|other| other.seed == row.seed)?;
            Some(figure.value(self.table, row)? / figure.value(self.table, other)?)
        };
        median(rows.filter_map(quotient).collect())
    }

    pub fn median(&self, method: &str, figure: Figure, ratios: &[f64]) -> Option<f64> {
        let all = ratios.iter().flat_map(|&ratio| self.mesh_quotients(method, figure, ratio));
        median(all.map(|of_mesh| of_mesh.quotient).collect())
    }

    pub fn median_of_mesh(&self, mesh: &str, method: &str, figure: Figure, ratios: &[f64]) -> Option<f64> {
        median(ratios.iter().filter_map(|&ratio| self.mesh_quotient(mesh, method, figure, ratio)).collect())
    }

    pub fn worst(&self, method: &str, figure: Figure, ratios: &[f64]) -> Option<MeshQuotient> {
        let all = ratios.iter().flat_map(|&ratio| self.mesh_quotients(method, figure, ratio));
        all.max_by(|a, b| a.quotient.total_cmp(&b.quotient))
    }

    pub fn meshes(&self) -> Vec<String> {
        let mut meshes: Vec<String> = Vec::new();
        for row in &self.table.rows {
            if !meshes.contains(&row.mesh) {
                meshes.push(row.mesh.clone());
            }
        }
        meshes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str, method: &str, seed: u64, distance: f64) -> ResultRow {
        let [mesh, method] = [mesh, method].map(String::from);
        ResultRow { mesh, ratio: 0.1, seed, method, figures: vec![Some(distance)], ..ResultRow::default() }
    }

    #[test]
    fn seeds_have_their_median_and_meshes_theirs() {
        let mut rows = Vec::new();
        for (seed, distance) in [(0, 2.0), (1, 8.0), (2, 9.0)] {
            rows.extend([row("a", "ours", seed, distance), row("a", "theirs", seed, 1.0)]);
        }
        rows.extend([row("b", "ours", 0, 1.0), row("b", "theirs", 0, 2.0), row("c", "ours", 0, 1.0)]);
        rows.push(ResultRow { error: "failed".into(), ..row("b", "ours", 1, 100.0) });
        let table = Table { figures: vec!["distance_mean".into()], rows };
        let quotients = Quotients { table: &table, over: "theirs" };
        assert_eq!(quotients.median("ours", Figure::Distance, &[0.1]), Some(4.25));
        assert_eq!(quotients.median_of_mesh("b", "ours", Figure::Distance, &[0.1]), Some(0.5));
        let worst = quotients.worst("ours", Figure::Distance, &[0.1]).unwrap();
        assert_eq!((worst.mesh.as_str(), worst.quotient), ("a", 8.0));
        assert_eq!(quotients.median("ours", Figure::Time, &[0.1]), None);
    }
}
