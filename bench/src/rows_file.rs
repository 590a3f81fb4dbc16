//! The table of rows as a CSV file.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use neural_mesh_cli::shared::Failure;

use crate::rows::{ResultRow, Table};

pub(crate) struct RowsFile {
    file: File,
    path: PathBuf,
    pub table: Table,
}

impl RowsFile {
    pub fn open(path: &Path, figures: &[String]) -> Result<Self, Failure> {
        let problem = |error: std::io::Error| write_problem(path, &error);
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(problem)?;
        file.try_lock().map_err(|error| Failure::in_file(path, lock_problem(&error)))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(problem)?;
        // A killed run may have left the beginning of a row, which is cut off.
        let n_whole = whole_lines(&bytes).len();
        file.set_len(n_whole as u64).map_err(problem)?;
        file.seek(SeekFrom::Start(n_whole as u64)).map_err(problem)?;
        let table = match n_whole {
            0 => Table { figures: figures.to_vec(), rows: Vec::new() },
            _ => parse(path, whole_lines(&bytes))?,
        };
        if table.figures != figures {
            return Err(differs(&format!("{} has other columns than this version writes", path.display())));
        }
        let mut rows = Self { file, path: path.into(), table };
        if n_whole == 0 {
            rows.write(&[Table::columns(figures)])?;
        }
        Ok(rows)
    }

    pub fn push(&mut self, rows: Vec<ResultRow>) -> Result<(), Failure> {
        self.write(&rows.iter().map(ResultRow::fields).collect::<Vec<_>>())?;
        self.table.rows.extend(rows);
        Ok(())
    }

    // All records go to the file at once.
    fn write(&mut self, records: &[Vec<String>]) -> Result<(), Failure> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let formatted = records.iter().try_for_each(|record| writer.write_record(record));
        let bytes =
            formatted.map_err(Into::into).and_then(|()| writer.into_inner().map_err(|error| error.into_error()));
        let written = bytes.and_then(|bytes| self.file.write_all(&bytes)).and_then(|()| self.file.sync_data());
        written.map_err(|error| write_problem(&self.path, &error))
    }
}

fn write_problem(path: &Path, error: &std::io::Error) -> Failure {
    Failure::in_file(path, format!("cannot be written: {error}: check the folder and the disk"))
}

/// Makes the error for rows that were measured otherwise.
pub(crate) fn differs(what: &str) -> Failure {
    Failure::Failed(format!("the rows do not match: {what}: undo this change, or evaluate into another folder"))
}

fn lock_problem(error: &TryLockError) -> String {
    match error {
        TryLockError::WouldBlock => "is in use by another evaluation: wait for its end".into(),
        TryLockError::Error(error) => {
            format!("cannot be locked: {error}: choose a folder on a file system with locks, such as a local disk")
        }
    }
}

pub(crate) fn read_rows(path: &Path) -> Result<Table, Failure> {
    let bytes = std::fs::read(path).map_err(|error| {
        Failure::in_file(path, format!("cannot be read: {error}: give the folder of an evaluation"))
    })?;
    parse(path, whole_lines(&bytes))
}

fn whole_lines(bytes: &[u8]) -> &[u8] {
    &bytes[..bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1)]
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Table, Failure> {
    let broken = |what: String| {
        Failure::in_file(path, format!("{what}: put a good copy of the file back, or choose another folder"))
    };
    let mut records = csv::ReaderBuilder::new().has_headers(false).from_reader(bytes).into_records();
    let header = records.next().transpose().map_err(|error| broken(error.to_string()))?.unwrap_or_default();
    let header: Vec<String> = header.iter().map(String::from).collect();
    let figures = Table::figures_of(&header).ok_or_else(|| broken("is not a table of this program".into()))?;
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
        ResultRow { error: "a, \"b\"".into(), ..ResultRow::new(mesh, 0.1, "x", &[0.25]) }
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
        let other = RowsFile::open(&path, &["y".into()]);
        assert!(other.is_err_and(|error| error.to_string().contains("the rows do not match")));
        std::fs::write(&path, "mesh,words\n").unwrap();
        assert!(read_rows(&path).is_err());
    }
}
