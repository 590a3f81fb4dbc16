//! Buffers of a glTF.

use std::borrow::Cow;
use std::path::PathBuf;

use rustc_hash::FxHashMap;

use super::load_uri::load_uri;
use super::refusals::REMEDY;
use crate::io::uri::path_inside;
use crate::io::{FileFetcher, ReadError};

pub(super) struct AssetBuffers<'a> {
    files: Vec<Cow<'a, [u8]>>,
    of_buffers: Vec<usize>,
}

impl<'a> AssetBuffers<'a> {
    // `buffers` has each buffer's URI, and true for a fallback, whose bytes are not needed.
    pub fn load<'b>(
        buffers: impl Iterator<Item = (Option<&'b str>, bool)>,
        embedded: Option<&'a [u8]>,
        fetch: &FileFetcher,
    ) -> Result<Self, ReadError> {
        let files = vec![Cow::Borrowed(&[][..]), Cow::Borrowed(embedded.unwrap_or(&[]))];
        let mut held = Self { files, of_buffers: Vec::new() };
        let mut known = FxHashMap::default();
        for (uri, is_fallback) in buffers {
            // A buffer without a URI has its bytes in the binary chunk of the GLB.
            let file = match (uri, embedded) {
                _ if is_fallback => 0,
                (None, Some(_)) => 1,
                (None, None) => return Err(ReadError::file("a buffer without bytes", REMEDY)),
                (Some(uri), _) => held.file(uri, &mut known, fetch)?,
            };
            held.of_buffers.push(file);
        }
        Ok(held)
    }

    fn file(
        &mut self,
        uri: &str,
        known: &mut FxHashMap<PathBuf, usize>,
        fetch: &FileFetcher,
    ) -> Result<usize, ReadError> {
        // Files are compared by path, since several URIs may name one file.
        let path = path_inside(uri).filter(|_| !uri.starts_with("data:"));
        if let Some(&file) = path.as_ref().and_then(|path| known.get(path)) {
            return Ok(file);
        }
        self.files.push(Cow::Owned(load_uri(uri, fetch)?));
        known.extend(path.map(|path| (path, self.files.len() - 1)));
        Ok(self.files.len() - 1)
    }

    pub fn into_owned(self) -> AssetBuffers<'static> {
        let files = self.files.into_iter().map(|bytes| Cow::Owned(bytes.into_owned())).collect();
        AssetBuffers { files, of_buffers: self.of_buffers }
    }

    pub fn part(&self, buffer: usize, offset: usize, length: usize) -> Option<&[u8]> {
        self.files[*self.of_buffers.get(buffer)?].get(offset..)?.get(..length)
    }

    pub fn n_bytes(&self) -> usize {
        self.files.iter().map(|bytes| bytes.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_file_is_read_once_however_many_buffers_name_it() {
        let names = ["a.bin", "./a.bin", "x/../a.bin", "%61.bin", "b.bin", "a.bin"];
        let n_read = Cell::new(0);
        let fetch = |uri: &str| {
            n_read.set(n_read.get() + 1);
            Ok(uri.as_bytes().to_vec())
        };
        let held = AssetBuffers::load(names.into_iter().map(|uri| (Some(uri), false)), None, &fetch).unwrap();
        assert_eq!((n_read.get(), held.n_bytes()), (2, 10));
        assert_eq!(
            [0, 3, 4, 5].map(|i| held.part(i, 0, 5)),
            [Some(&b"a.bin"[..]), Some(b"a.bin"), Some(b"b.bin"), Some(b"a.bin")]
        );
        assert_eq!((held.part(6, 0, 0), held.part(0, 0, 6), held.part(0, 3, 2)), (None, None, Some(&b"in"[..])));
    }
}
