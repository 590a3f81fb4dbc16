//! Several byte streams that share one temporary file without a name.

use std::fs::File;
use std::io::{Read, Result, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Mutex;

#[derive(Debug)]
#[doc(hidden)]
pub struct Spool {
    file: Mutex<File>,
    streams: Vec<Vec<(u64, usize)>>,
    n_bytes: u64,
}

impl Spool {
    pub fn new(folder: &Path, n_streams: usize) -> Result<Self> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        Ok(Self { file: Mutex::new(tempfile::tempfile_in(folder)?), streams: vec![Vec::new(); n_streams], n_bytes: 0 })
    }

    pub fn append(&mut self, stream: usize, bytes: &[u8]) -> Result<()> {
        let file = self.file.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner());
        file.write_all(bytes)?;
        self.streams[stream].push((self.n_bytes, bytes.len()));
        self.n_bytes += bytes.len() as u64;
        Ok(())
    }

    pub fn pieces(&self, stream: usize) -> impl Iterator<Item = Result<Vec<u8>>> {
        self.streams[stream].iter().map(|&(at, length)| {
            let mut bytes = vec![0; length];
            let mut file = self.file.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(&mut bytes)?;
            Ok(bytes)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_come_back_in_pieces_and_leave_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut spool = Spool::new(folder.path(), 2).unwrap();
        for (stream, bytes) in [(0, &b"ab"[..]), (1, b"x"), (0, b""), (0, b"cde")] {
            spool.append(stream, bytes).unwrap();
        }
        let all = |stream| spool.pieces(stream).collect::<Result<Vec<_>>>().unwrap();
        assert_eq!(all(0), [&b"ab"[..], b"", b"cde"]);
        assert_eq!(all(1), [b"x"]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(Spool::new(&folder.path().join("none"), 1).is_err());
    }
}
