//! The table of rows as a CSV file.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::row::{columns, figure_names};
use super::{EvaluateError, ResultRow};
use neural_mesh::io::write_path;

/// Rows and the names of their figures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the figures.
    pub figures: Vec<String>,
    /// Rows in the order of measurement.
    pub rows: Vec<ResultRow>,
}

impl Table {
    /// Returns a figure of a row by name; `None` if the row has no value or the table no such figure.
    ///
    /// ```
    /// use neural_mesh_bench::evaluate::{ResultRow, Table};
    /// let row = ResultRow { figures: vec![Some(0.5)], ..ResultRow::default() };
    /// let table = Table { figures: vec!["chamfer".into()], rows: vec![row] };
    /// assert_eq!(table.figure(&table.rows[0], "chamfer"), Some(0.5));
    /// ```
    pub fn figure(&self, row: &ResultRow, name: &str) -> Option<f64> {
        let at = self.figures.iter().position(|figure| figure == name)?;
        row.figures.get(at).copied().flatten()
    }
}

pub(super) struct RowsFile {
    file: File,
    path: PathBuf,
    // Earlier versions of the file, kept open because that holds their locks.
    replaced: Vec<File>,
    pub table: Table,
}

impl RowsFile {
    pub fn open(path: &Path, figures: &[String]) -> Result<Self, EvaluateError> {
        let problem = |error: std::io::Error| {
            EvaluateError::file(path, format!("cannot be written: {error}: check the folder and the disk"))
        };
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(problem)?;
        file.try_lock().map_err(|error| EvaluateError::file(path, lock_problem(&error)))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(problem)?;
        // A killed run may have left the beginning of a row, which is cut off.
        let n_whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        file.set_len(n_whole as u64).map_err(problem)?;
        file.seek(SeekFrom::Start(n_whole as u64)).map_err(problem)?;
        let table = match n_whole {
            0 => Table { figures: figures.to_vec(), rows: Vec::new() },
            _ => parse(path, &bytes[..n_whole])?,
        };
        if table.figures != figures {
            return Err(EvaluateError::Differs(format!(
                "{} has other columns than this version writes",
                path.display()
            )));
        }
        let mut rows = Self { file, path: path.into(), replaced: Vec::new(), table };
        if n_whole == 0 {
            rows.write(&[columns(figures)])?;
        }
        Ok(rows)
    }

    pub fn push(&mut self, rows: Vec<ResultRow>) -> Result<(), EvaluateError> {
        self.write(&rows.iter().map(ResultRow::fields).collect::<Vec<_>>())?;
        self.table.rows.extend(rows);
        Ok(())
    }

    pub fn remove(&mut self, goes: impl Fn(&ResultRow) -> bool) -> Result<(), EvaluateError> {
        let mut table = std::mem::take(&mut self.table);
        table.rows.retain(|row| !goes(row));
        let records: Vec<_> =
            std::iter::once(columns(&table.figures)).chain(table.rows.iter().map(ResultRow::fields)).collect();
        let bytes = self.bytes(&records)?;
        write_path(&self.path, &bytes, true).map_err(|error| EvaluateError::file(&self.path, error))?;
        // The new file is locked while the old lock still holds.
        let Self { file, table, .. } = Self::open(&self.path, &table.figures)?;
        self.replaced.push(std::mem::replace(&mut self.file, file));
        self.table = table;
        Ok(())
    }

    fn write(&mut self, records: &[Vec<String>]) -> Result<(), EvaluateError> {
        let bytes = self.bytes(records)?;
        self.file.write_all(&bytes).and_then(|()| self.file.sync_data()).map_err(|error| self.problem(error))
    }

    fn bytes(&self, records: &[Vec<String>]) -> Result<Vec<u8>, EvaluateError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for record in records {
            writer.write_record(record).map_err(|error| self.problem(error.into()))?;
        }
        writer.into_inner().map_err(|error| self.problem(error.into_error()))
    }

    fn problem(&self, error: std::io::Error) -> EvaluateError {
        EvaluateError::file(&self.path, format!("cannot be written: {error}: check the folder and the disk"))
    }
}

fn lock_problem(error: &TryLockError) -> String {
    match error {
        TryLockError::WouldBlock => "is in use by another evaluation: wait for its end".into(),
        TryLockError::Error(error) => {
            format!("cannot be locked: {error}: choose a folder on a file system with locks, such as a local disk")
        }
    }
}

pub(super) fn read_rows(path: &Path) -> Result<Table, EvaluateError> {
    let bytes = std::fs::read(path).map_err(|error| {
        EvaluateError::file(path, format!("cannot be read: {error}: give the folder of an evaluation"))
    })?;
    let n_whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    parse(path, &bytes[..n_whole])
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Table, EvaluateError> {
    let broken = |what: String| {
        EvaluateError::file(path, format!("{what}: put a good copy of the file back, or choose another folder"))
    };
    let mut records = csv::ReaderBuilder::new().has_headers(false).from_reader(bytes).into_records();
    let header = records.next().transpose().map_err(|error| broken(error.to_string()))?.unwrap_or_default();
    let header: Vec<String> = header.iter().map(String::from).collect();
    let figures = figure_names(&header).ok_or_else(|| broken("is not a table of this program".into()))?;
    let mut rows = Vec::new();
    for (index, record) in records.enumerate() {
        let record = record.map_err(|error| broken(error.to_string()))?;
        let fields: Vec<String> = record.iter().map(String::from).collect();
        rows.push(ResultRow::from_fields(&fields).ok_or_else(|| broken(format!("line {} is not a row", index + 2)))?);
    }
    Ok(Table { figures, rows })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str) -> ResultRow {
        ResultRow { mesh: mesh.into(), error: "a, \"b\"".into(), figures: vec![Some(0.25)], ..ResultRow::default() }
    }

    #[test]
    fn a_row_left_by_half_goes_wherever_it_was_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let figures = ["x".to_string()];
        let mut rows = RowsFile::open(&path, &figures).unwrap();
        rows.push(vec![row("a"), row("b")]).unwrap();
        assert!(RowsFile::open(&path, &figures).is_err_and(|error| error.to_string().contains("in use")));
        drop(rows);
        let whole = std::fs::read(&path).unwrap();
        for n_bytes in 0..whole.len() {
            std::fs::write(&path, &whole[..n_bytes]).unwrap();
            let mut rows = RowsFile::open(&path, &figures).unwrap();
            let missing = ["a", "b"].into_iter().skip(rows.table.rows.len()).map(row).collect();
            rows.push(missing).unwrap();
            drop(rows);
            assert_eq!(std::fs::read(&path).unwrap(), whole);
        }
        assert_eq!(read_rows(&path).unwrap().rows, [row("a"), row("b")]);
    }

    #[test]
    fn rows_are_taken_out_and_the_table_stays_locked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let figures = ["x".to_string()];
        let mut rows = RowsFile::open(&path, &figures).unwrap();
        rows.push(vec![row("a"), row("b"), row("c")]).unwrap();
        rows.remove(|row| row.mesh == "b").unwrap();
        assert!(RowsFile::open(&path, &figures).is_err_and(|error| error.to_string().contains("in use")));
        rows.push(vec![row("d")]).unwrap();
        assert_eq!(rows.table.rows, [row("a"), row("c"), row("d")]);
        assert_eq!(read_rows(&path).unwrap(), rows.table);
    }

    #[test]
    fn a_disk_without_locks_is_not_taken_for_another_evaluation() {
        let unsupported = TryLockError::Error(std::io::ErrorKind::Unsupported.into());
        assert!(lock_problem(&unsupported).contains("unsupported"));
        assert!(!lock_problem(&unsupported).contains("in use"));
    }

    #[test]
    fn other_tables_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        drop(RowsFile::open(&path, &["x".into()]).unwrap());
        assert!(matches!(RowsFile::open(&path, &["y".into()]), Err(EvaluateError::Differs(_))));
        std::fs::write(&path, "mesh,words\n").unwrap();
        assert!(read_rows(&path).is_err());
    }
}
