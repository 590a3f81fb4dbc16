//! Pages on disk, for files that are larger than memory.

use std::fs::File;
use std::io::{BufWriter, Read, Result, Seek, Write, copy, repeat};
use std::path::Path;

use crate::clusters::{Cluster, Clusters, LARGEST_CLUSTER};

use super::cluster_bytes;
use super::write::{PageFiller, PagePlace, content_bytes, write_content, write_head};

/// Pages in a temporary file without a name, for clusters without attributes.
#[derive(Debug)]
pub struct StoredPages {
    file: BufWriter<File>,
    filler: PageFiller,
    places: Vec<PagePlace>,
    n_bytes: usize,
}

impl StoredPages {
    pub fn new(folder: &Path) -> Result<Self> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let filler = PageFiller::new(cluster_bytes(LARGEST_CLUSTER, LARGEST_CLUSTER, 0, false));
        let file = BufWriter::new(tempfile::tempfile_in(folder)?);
        Ok(Self { file, filler, places: Vec::new(), n_bytes: 0 })
    }

    /// Appends some clusters of a hierarchy.
    pub fn append(&mut self, clusters: &Clusters, some: &[Cluster]) -> Result<()> {
        let mut bytes = Vec::new();
        for cluster in some {
            let place = self.filler.place(content_bytes(clusters, cluster));
            self.fill_up_to(self.filler.byte(place))?;
            write_content(&mut bytes, clusters, cluster);
            self.file.write_all(&bytes)?;
            self.n_bytes += bytes.len();
            self.places.push(place);
            bytes.clear();
        }
        Ok(())
    }

    /// Writes the bytes of an `.nmc` file and returns their number; `rows` has all clusters in the order in which they were appended.
    pub fn write(&mut self, rows: &Clusters, out: &mut dyn Write) -> Result<usize> {
        self.fill_up_to(self.filler.n_bytes())?;
        let head = write_head(rows, &self.places, &self.filler);
        out.write_all(&head)?;
        self.file.rewind()?;
        copy(self.file.get_mut(), out)?;
        out.flush()?;
        Ok(head.len() + self.n_bytes)
    }

    fn fill_up_to(&mut self, n_bytes: usize) -> Result<()> {
        copy(&mut repeat(0).take((n_bytes - self.n_bytes) as u64), &mut self.file)?;
        self.n_bytes = n_bytes;
        Ok(())
    }
}
