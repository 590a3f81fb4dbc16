//! CSV tables (RFC 4180) that grow row by row.

use super::TrainError;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

#[derive(Debug)]
pub(super) struct CsvTable {
    file: File,
    path: PathBuf,
    pub n_bytes: u64,
}

impl CsvTable {
    /// Opens or creates a table and cuts it to its first `n_bytes` bytes.
    pub fn open(path: &Path, n_bytes: u64) -> Result<Self, TrainError> {
        let file = OpenOptions::new().create(true).read(true).write(true).truncate(false).open(path);
        let mut file = file.map_err(|error| problem(path, &error))?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(TrainError::file(path, "another training writes to it: wait for its end"));
            }
            // File systems without locks are accepted.
            Err(TryLockError::Error(_)) | Ok(()) => {}
        }
        let found = file.metadata().map_err(|error| problem(path, &error))?.len();
        if found < n_bytes {
            let what = format!(
                "has {found} bytes, fewer than the {n_bytes} of the checkpoint: put the file back or train in another folder"
            );
            return Err(TrainError::file(path, what));
        }
        file.set_len(n_bytes).map_err(|error| problem(path, &error))?;
        file.seek(SeekFrom::Start(n_bytes)).map_err(|error| problem(path, &error))?;
        Ok(Self { file, path: path.into(), n_bytes })
    }

    /// Appends a row; the caller quotes fields.
    pub fn push(&mut self, fields: &[String]) -> Result<(), TrainError> {
        let row = fields.join(",") + "\n";
        self.file.write_all(row.as_bytes()).map_err(|error| problem(&self.path, &error))?;
        self.n_bytes += row.len() as u64;
        Ok(())
    }

    /// Flushes the rows to disk.
    pub fn sync(&self) -> Result<(), TrainError> {
        self.file.sync_data().map_err(|error| problem(&self.path, &error))
    }
}

pub(super) fn quote_field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

fn problem(path: &Path, error: &std::io::Error) -> TrainError {
    TrainError::file(path, format!("cannot be written: {error}: check the folder and the disk"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_after_the_checkpoint_go() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut rows = CsvTable::open(&path, 0).unwrap();
        rows.push(&["1".into(), quote_field("a,\"b\"")]).unwrap();
        let n_bytes = rows.n_bytes;
        rows.push(&["2".into()]).unwrap();
        assert!(CsvTable::open(&path, 0).unwrap_err().to_string().contains("another training"));
        drop(rows);
        let mut rows = CsvTable::open(&path, n_bytes).unwrap();
        rows.push(&["3".into()]).unwrap();
        drop(rows);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "1,\"a,\"\"b\"\"\"\n3\n");
        assert!(CsvTable::open(&path, 1000).unwrap_err().to_string().contains("fewer than"));
    }
}
