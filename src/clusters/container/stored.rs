//! Pages on disk, for files that are larger than memory.

use std::io::{Result, Write};
use std::path::Path;

use crate::clusters::{Cluster, Clusters, LARGEST_CLUSTER};
use crate::io::Spool;

use super::write::{PageFiller, content_bytes, write_content, write_head};
use super::{PagePlace, cluster_bytes};

/// Bytes that are collected before they go to the disk.
const CHUNK: usize = 1 << 20;

/// Pages in a temporary file, for clusters without attributes.
#[derive(Debug)]
pub struct StoredPages {
    spool: Spool,
    pending: Vec<u8>,
    filler: PageFiller,
    places: Vec<PagePlace>,
    /// Bytes of the pages so far, with the pending ones.
    n_bytes: usize,
}

impl StoredPages {
    pub fn new(folder: &Path) -> Result<Self> {
        let filler = PageFiller::new(cluster_bytes(LARGEST_CLUSTER, LARGEST_CLUSTER, 0, false));
        let spool = Spool::new(folder, 1)?;
        Ok(Self { spool, pending: Vec::new(), filler, places: Vec::new(), n_bytes: 0 })
    }

    /// Appends some clusters of a hierarchy.
    pub fn append(&mut self, clusters: &Clusters, some: &[Cluster]) -> Result<()> {
        for cluster in some {
            let place = self.filler.place(content_bytes(clusters, cluster));
            self.fill_up_to(self.filler.byte(place));
            let n_before = self.pending.len();
            write_content(&mut self.pending, clusters, cluster);
            self.n_bytes += self.pending.len() - n_before;
            self.places.push(place);
            if self.pending.len() >= CHUNK {
                self.flush()?;
            }
        }
        Ok(())
    }

    /// Writes the bytes of an `.nmc` file, and returns their number.
    ///
    /// `rows` has all clusters in the order in which they were appended.
    pub fn write(&mut self, rows: &Clusters, out: &mut dyn Write) -> Result<usize> {
        self.fill_up_to(self.filler.n_bytes());
        self.flush()?;
        let head = write_head(rows, &self.places, &self.filler);
        out.write_all(&head)?;
        self.spool.pieces(0).try_for_each(|piece| out.write_all(&piece?))?;
        out.flush()?;
        Ok(head.len() + self.n_bytes)
    }

    fn fill_up_to(&mut self, n_bytes: usize) {
        self.pending.resize(self.pending.len() + n_bytes - self.n_bytes, 0);
        self.n_bytes = n_bytes;
    }

    fn flush(&mut self) -> Result<()> {
        self.spool.append(0, &self.pending)?;
        self.pending.clear();
        Ok(())
    }
}
