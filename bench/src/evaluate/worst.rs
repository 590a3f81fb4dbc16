//! The worst cases of each method with their meshes, ranked by distance over the least of the other methods.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::job::{read_mesh, write_mesh};
use super::meshes::sha256;
use super::summary::distinct;
use super::{EvaluateError, ResultRow, Table};
use neural_mesh::mesh::TriMesh;

const CASES: usize = 3;
// Largest number of faces of a saved mesh: a page of 30 MB holds no more.
const MOST_FACES: usize = 1_000_000;
// Lower limit of distances in quotients, in percent of the diagonal: one step of the positions on the page.
const LEAST: f64 = 100.0 / 65_535.0;

pub(super) const WORST: &str = "worst";

/// A case among the worst of its method.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstCase {
    /// Mesh file.
    pub mesh: String,
    /// Target ratio of vertices.
    pub ratio: f64,
    /// Random seed.
    pub seed: u64,
    /// Method.
    pub method: String,
    /// Mean distance in percent of the diagonal.
    pub distance: f64,
    /// Distance divided by the smallest distance of another method in this case; `None` if no other has a result.
    pub quotient: Option<f64>,
}

impl WorstCase {
    /// Reads the saved result, if there is one.
    pub fn result(&self, folder: &Path) -> Option<TriMesh> {
        read_mesh(&self.path(folder)).ok()
    }

    /// Reads the saved original, if there is one.
    pub fn original(&self, folder: &Path) -> Option<TriMesh> {
        read_mesh(&original_path(folder, &self.mesh)).ok()
    }

    fn path(&self, folder: &Path) -> PathBuf {
        let Self { mesh, ratio, seed, method, .. } = self;
        mesh_path(folder, &format!("result {method} {ratio} {seed} {mesh}"))
    }

    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let badness = |worst: &Self| (worst.quotient.unwrap_or(-1.0), worst.distance);
        let ((a, b), (c, d)) = (badness(self), badness(other));
        let by_name = || (&other.mesh, other.seed).cmp(&(&self.mesh, self.seed));
        a.total_cmp(&c).then(b.total_cmp(&d)).then_with(by_name).then(other.ratio.total_cmp(&self.ratio))
    }
}

fn original_path(folder: &Path, mesh: &str) -> PathBuf {
    mesh_path(folder, &format!("original {mesh}"))
}

fn mesh_path(folder: &Path, what: &str) -> PathBuf {
    // A checksum names the file, because mesh names may be too long.
    folder.join(WORST).join(format!("{}.ply.gz", &sha256(what.as_bytes())[..16]))
}

/// Returns the worst cases with saved meshes, grouped by method, the worst first.
///
/// ```
/// use neural_mesh_bench::evaluate::{Table, worst_cases};
/// assert!(worst_cases("run".as_ref(), &Table::default()).is_empty());
/// ```
pub fn worst_cases(folder: &Path, table: &Table) -> Vec<WorstCase> {
    WorstCaseStore::new(folder, table).ranks.into_values().flatten().collect()
}

pub(super) struct WorstCaseStore {
    folder: PathBuf,
    ranks: BTreeMap<String, Vec<WorstCase>>,
}

impl WorstCaseStore {
    pub fn new(folder: &Path, table: &Table) -> Self {
        let mut store = Self { folder: folder.into(), ranks: BTreeMap::new() };
        let mut cases: BTreeMap<(&str, u64, u64), Vec<&ResultRow>> = BTreeMap::new();
        for row in &table.rows {
            cases.entry((&row.mesh, row.ratio.to_bits(), row.seed)).or_default().push(row);
        }
        for rows in cases.values() {
            let there = |case: &WorstCase| case.path(folder).exists() && original_path(folder, &case.mesh).exists();
            for case in score_cases(table, rows).into_iter().filter(there) {
                store.insert(case);
            }
        }
        store
    }

    pub fn save(
        &mut self,
        table: &Table,
        rows: &[&ResultRow],
        original: &TriMesh,
        results: &[(&str, &TriMesh)],
    ) -> Result<(), EvaluateError> {
        if original.faces().len() > MOST_FACES {
            return Ok(());
        }
        for case in score_cases(table, rows) {
            let result = results.iter().find(|(method, _)| *method == case.method);
            // A row of an earlier run takes part only if its mesh is still saved.
            if result.is_none() && !case.path(&self.folder).exists() {
                continue;
            }
            if let (true, Some((_, result))) = (self.insert(case.clone()), result) {
                self.write(&case, original, result)?;
            }
        }
        Ok(())
    }

    fn write(&self, case: &WorstCase, original: &TriMesh, result: &TriMesh) -> Result<(), EvaluateError> {
        let worst = self.folder.join(WORST);
        let problem = |what: String| EvaluateError::file(&worst, format!("{what}: check the folder and the disk"));
        std::fs::create_dir_all(&worst).map_err(|error| problem(format!("cannot be created: {error}")))?;
        let of_original = original_path(&self.folder, &case.mesh);
        if !of_original.exists() {
            write_mesh(&of_original, original).map_err(problem)?;
        }
        write_mesh(&case.path(&self.folder), result).map_err(problem)
    }

    fn insert(&mut self, case: WorstCase) -> bool {
        let ranks = self.ranks.entry(case.method.clone()).or_default();
        ranks.retain(|known| known.path(&self.folder) != case.path(&self.folder));
        let at = ranks.partition_point(|known| known.cmp(&case).is_gt());
        ranks.insert(at, case);
        // No later case changes a quotient, so the rows alone determine the saved meshes, also after a killed run.
        ranks.truncate(CASES);
        at < CASES
    }

    pub fn remove_others(&self) {
        let cases = || self.ranks.values().flatten();
        let originals = cases().map(|case| original_path(&self.folder, &case.mesh));
        let wanted: BTreeSet<PathBuf> = cases().map(|case| case.path(&self.folder)).chain(originals).collect();
        let entries = std::fs::read_dir(self.folder.join(WORST));
        for path in entries.into_iter().flatten().flatten().map(|entry| entry.path()) {
            if !wanted.contains(&path) {
                // A file that cannot be removed does no harm.
                let _ = std::fs::remove_file(path);
            }
        }
    }
}

fn score_cases(table: &Table, rows: &[&ResultRow]) -> Vec<WorstCase> {
    let distances: Vec<(&ResultRow, f64)> =
        rows.iter().filter_map(|row| Some((*row, table.figure(row, "distance_mean")?))).collect();
    let least_of_others = |method: &str| {
        let others = distances.iter().filter(|(row, _)| row.method != method).map(|(_, distance)| *distance);
        others.reduce(f64::min)
    };
    let case = |(row, distance): &(&ResultRow, f64)| WorstCase {
        mesh: row.mesh.clone(),
        ratio: row.ratio,
        seed: row.seed,
        method: row.method.clone(),
        distance: *distance,
        quotient: least_of_others(&row.method).map(|least| distance.max(LEAST) / least.max(LEAST)),
    };
    let cases = distances.iter().filter(|(row, _)| row.faces_in <= MOST_FACES).map(case);
    distinct(cases)
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    fn table() -> Table {
        Table { figures: vec!["distance_mean".into()], rows: Vec::new() }
    }

    fn row(mesh: usize, method: &str, distance: Option<f64>) -> ResultRow {
        ResultRow {
            mesh: format!("{mesh}.ply"),
            ratio: 0.5,
            method: method.into(),
            figures: vec![distance],
            ..ResultRow::default()
        }
    }

    fn names(worst: &[WorstCase], method: &str) -> Vec<String> {
        worst.iter().filter(|case| case.method == method).map(|case| case.mesh.clone()).collect()
    }

    fn n_files(folder: &Path) -> usize {
        std::fs::read_dir(folder.join(WORST)).unwrap().count()
    }

    #[test]
    fn the_worst_are_kept_and_the_others_go() {
        let folder = tempfile::tempdir().unwrap();
        let (mut table, original, result) = (table(), shapes::icosphere(2), shapes::icosphere(1));
        for (mesh, distance) in [1.0, 8.0, 3.0, 1e-9, 9.0, 2.0].into_iter().enumerate() {
            // A new store for each case behaves as after a killed run.
            let mut store = WorstCaseStore::new(folder.path(), &table);
            let rows = [row(mesh, "a", Some(distance)), row(mesh, "b", Some(1.0)), row(mesh, "c", None)];
            let results = [("a", &result), ("b", &result)];
            store.save(&table, &rows.each_ref(), &original, &results).unwrap();
            table.rows.extend(rows);
            store.remove_others();
        }
        let worst = worst_cases(folder.path(), &table);
        assert_eq!(names(&worst, "a"), ["4.ply", "1.ply", "2.ply"]);
        // Below a step of the page all distances are equal.
        assert_eq!(names(&worst, "b"), ["3.ply", "0.ply", "5.ply"]);
        assert_eq!(worst.iter().find(|case| case.method == "b").unwrap().quotient, Some(1.0 / LEAST));
        assert_eq!(n_files(folder.path()), 6 + 6);
        assert!(worst.iter().all(|case| case.result(folder.path()).as_ref() == Some(&result)));
        assert!(worst.iter().all(|case| case.original(folder.path()).as_ref() == Some(&original)));
    }

    #[test]
    fn without_others_the_distance_counts_and_what_is_lost_stays_out() {
        let folder = tempfile::tempdir().unwrap();
        let (mut table, mesh) = (table(), shapes::icosphere(1));
        let mut store = WorstCaseStore::new(folder.path(), &table);
        for (name, distance) in [2.0, 1.0, 3.0].into_iter().enumerate() {
            let row = row(name, "a", Some(distance));
            store.save(&table, &[&row], &mesh, &[("a", &mesh)]).unwrap();
            table.rows.push(row);
        }
        let found = worst_cases(folder.path(), &table);
        assert_eq!(names(&found, "a"), ["2.ply", "0.ply", "1.ply"]);
        std::fs::remove_file(found[0].path(folder.path())).unwrap();
        assert_eq!(names(&worst_cases(folder.path(), &table), "a"), ["0.ply", "1.ply"]);
    }
}
