//! The worst cases of each method, with their meshes, so that a reader can see what went wrong.
//!
//! Meshes are kept while the evaluation runs and not made again for the report: programs of others need not be there any
//! more, methods may take hours, and what was measured is what should be seen. A case counts by its distance divided by the
//! least of the other methods' in the same case, which no later case changes: so what is kept at any time follows from the
//! rows alone, and a run that was killed keeps the same files. Meshes are written before their rows and others removed
//! after, so every row that is kept has its mesh. Where a corrected tool raises quotients later, cases whose meshes are gone
//! stay out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::job::{read_mesh, write_mesh};
use super::meshes::sha256;
use super::summary::distinct;
use super::{EvaluateError, Row, Table};
use neural_mesh::mesh::TriMesh;

/// Cases of each method.
const CASES: usize = 3;
/// Faces of an original at most; a page of 30 MB holds no more.
const MOST_FACES: usize = 1_000_000;
/// Percent of the diagonal: a step of the positions in the page. What is nearer cannot be told apart there.
const LEAST: f64 = 100.0 / 65_535.0;

/// The folder of the meshes.
pub(super) const WORST: &str = "worst";

/// A case that went badly for a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// Name of the mesh file.
    pub mesh: String,
    /// Share of the vertices asked for.
    pub ratio: f64,
    /// Seed of the sampling.
    pub seed: u64,
    /// Name of the method.
    pub method: String,
    /// Mean distance, in percent of the diagonal.
    pub distance: f64,
    /// The distance divided by the least of the other methods' in this case; `None` where no other has a result.
    pub quotient: Option<f64>,
}

impl Worst {
    /// The result, as it was measured; `None` where it cannot be read.
    pub fn result(&self, folder: &Path) -> Option<TriMesh> {
        read_mesh(&self.path(folder)).ok()
    }

    /// The mesh that it was made from, as cleaned; `None` where it cannot be read.
    pub fn original(&self, folder: &Path) -> Option<TriMesh> {
        read_mesh(&original_path(folder, &self.mesh)).ok()
    }

    fn path(&self, folder: &Path) -> PathBuf {
        let Self { mesh, ratio, seed, method, .. } = self;
        path_of(folder, &format!("result {method} {ratio} {seed} {mesh}"))
    }

    /// The worse, the greater; equal ones by what they are called.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let badness = |worst: &Self| (worst.quotient.unwrap_or(-1.0), worst.distance);
        let ((a, b), (c, d)) = (badness(self), badness(other));
        let by_name = || (&other.mesh, other.seed).cmp(&(&self.mesh, self.seed));
        a.total_cmp(&c).then(b.total_cmp(&d)).then_with(by_name).then(other.ratio.total_cmp(&self.ratio))
    }
}

fn original_path(folder: &Path, mesh: &str) -> PathBuf {
    path_of(folder, &format!("original {mesh}"))
}

/// Names of meshes may be as long as a file system allows, so a file is called by a checksum.
fn path_of(folder: &Path, what: &str) -> PathBuf {
    folder.join(WORST).join(format!("{}.ply.gz", &sha256(what.as_bytes())[..16]))
}

/// The worst cases of an evaluation, finished or not, whose meshes are there: those of each method, the worst first.
///
/// ```
/// use neural_mesh_bench::evaluate::{Table, worst};
/// assert!(worst("run".as_ref(), &Table::default()).is_empty());
/// ```
pub fn worst(folder: &Path, table: &Table) -> Vec<Worst> {
    Keeper::new(folder, table).ranks.into_values().flatten().collect()
}

/// What is kept of an evaluation that runs.
pub(super) struct Keeper {
    folder: PathBuf,
    /// For each method its worst cases, the worst first.
    ranks: BTreeMap<String, Vec<Worst>>,
}

impl Keeper {
    /// Takes up what is there.
    pub fn new(folder: &Path, table: &Table) -> Self {
        let mut keeper = Self { folder: folder.into(), ranks: BTreeMap::new() };
        let mut cases: BTreeMap<(&str, u64, u64), Vec<&Row>> = BTreeMap::new();
        for row in &table.rows {
            cases.entry((&row.mesh, row.ratio.to_bits(), row.seed)).or_default().push(row);
        }
        for rows in cases.values() {
            let there = |case: &Worst| case.path(folder).exists() && original_path(folder, &case.mesh).exists();
            for case in scored(table, rows).into_iter().filter(there) {
                keeper.rank(case);
            }
        }
        keeper
    }

    /// Keeps the meshes of a case that is among the worst of a method: all its rows, and the results that are new.
    pub fn keep(
        &mut self,
        table: &Table,
        rows: &[&Row],
        original: &TriMesh,
        results: &[(&str, &TriMesh)],
    ) -> Result<(), EvaluateError> {
        if original.faces().len() > MOST_FACES {
            return Ok(());
        }
        for case in scored(table, rows) {
            let result = results.iter().find(|(method, _)| *method == case.method);
            // Of one that was measured before, the mesh is there or gone.
            if result.is_none() && !case.path(&self.folder).exists() {
                continue;
            }
            if let (true, Some((_, result))) = (self.rank(case.clone()), result) {
                self.write(&case, original, result)?;
            }
        }
        Ok(())
    }

    fn write(&self, case: &Worst, original: &TriMesh, result: &TriMesh) -> Result<(), EvaluateError> {
        let worst = self.folder.join(WORST);
        let problem = |what: String| EvaluateError::file(&worst, format!("{what}: check the folder and the disk"));
        std::fs::create_dir_all(&worst).map_err(|error| problem(format!("cannot be created: {error}")))?;
        let of_original = original_path(&self.folder, &case.mesh);
        if !of_original.exists() {
            write_mesh(&of_original, original).map_err(problem)?;
        }
        write_mesh(&case.path(&self.folder), result).map_err(problem)
    }

    /// Puts a case in its place, instead of what was known of it before; says whether it is among the worst.
    fn rank(&mut self, case: Worst) -> bool {
        let ranks = self.ranks.entry(case.method.clone()).or_default();
        ranks.retain(|known| known.path(&self.folder) != case.path(&self.folder));
        let at = ranks.partition_point(|known| known.cmp(&case).is_gt());
        ranks.insert(at, case);
        ranks.truncate(CASES);
        at < CASES
    }

    /// Removes the meshes that belong to none of the worst cases.
    pub fn tidy(&self) {
        let cases = || self.ranks.values().flatten();
        let originals = cases().map(|case| original_path(&self.folder, &case.mesh));
        let wanted: BTreeSet<PathBuf> = cases().map(|case| case.path(&self.folder)).chain(originals).collect();
        let entries = std::fs::read_dir(self.folder.join(WORST));
        for path in entries.into_iter().flatten().flatten().map(|entry| entry.path()) {
            if !wanted.contains(&path) {
                // What cannot be removed takes room, nothing else.
                let _ = std::fs::remove_file(path);
            }
        }
    }
}

/// The results of a case, scored.
fn scored(table: &Table, rows: &[&Row]) -> Vec<Worst> {
    let distances: Vec<(&Row, f64)> =
        rows.iter().filter_map(|row| Some((*row, table.figure(row, "distance_mean")?))).collect();
    let least_of_others = |method: &str| {
        let others = distances.iter().filter(|(row, _)| row.method != method).map(|(_, distance)| *distance);
        others.reduce(f64::min)
    };
    let case = |(row, distance): &(&Row, f64)| Worst {
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

    fn row(mesh: usize, method: &str, distance: Option<f64>) -> Row {
        Row {
            mesh: format!("{mesh}.ply"),
            ratio: 0.5,
            method: method.into(),
            figures: vec![distance],
            ..Row::default()
        }
    }

    /// Names of the meshes of a method's worst cases.
    fn names(worst: &[Worst], method: &str) -> Vec<String> {
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
            // Each case as if the evaluation had been killed before it.
            let mut keeper = Keeper::new(folder.path(), &table);
            let rows = [row(mesh, "a", Some(distance)), row(mesh, "b", Some(1.0)), row(mesh, "c", None)];
            let results = [("a", &result), ("b", &result)];
            keeper.keep(&table, &rows.each_ref(), &original, &results).unwrap();
            table.rows.extend(rows);
            keeper.tidy();
        }
        let worst = worst(folder.path(), &table);
        assert_eq!(names(&worst, "a"), ["4.ply", "1.ply", "2.ply"]);
        // Below a step of the page all distances are alike.
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
        let mut keeper = Keeper::new(folder.path(), &table);
        for (name, distance) in [2.0, 1.0, 3.0].into_iter().enumerate() {
            let row = row(name, "a", Some(distance));
            keeper.keep(&table, &[&row], &mesh, &[("a", &mesh)]).unwrap();
            table.rows.push(row);
        }
        let found = worst(folder.path(), &table);
        assert_eq!(names(&found, "a"), ["2.ply", "0.ply", "1.ply"]);
        std::fs::remove_file(found[0].path(folder.path())).unwrap();
        assert_eq!(names(&worst(folder.path(), &table), "a"), ["0.ply", "1.ply"]);
    }
}
