//! The buffers of a glTF asset: each file that they name is read and held once, however many of them name it.

use std::borrow::Cow;
use std::path::PathBuf;

use rustc_hash::FxHashMap;

use super::REMEDY;
use super::container::load_uri;
use super::schema::Buffer;
use crate::io::ReadError;
use crate::io::uri::path_inside;

/// The bytes of buffers.
pub(super) struct Buffers<'a> {
    /// What was read.
    files: Vec<Cow<'a, [u8]>>,
    /// Of each buffer which of these holds its bytes.
    of_buffers: Vec<usize>,
}

impl<'a> Buffers<'a> {
    /// Gathers the bytes of `buffers`: those of the container (`embedded`), of `data:` URIs, and of files by `fetch`.
    pub fn load(
        buffers: &[Buffer],
        embedded: Option<&'a [u8]>,
        fetch: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>,
    ) -> Result<Self, ReadError> {
        let mut held =
            Self { files: vec![Cow::Borrowed(&[]), Cow::Borrowed(embedded.unwrap_or(&[]))], of_buffers: Vec::new() };
        let mut known: FxHashMap<PathBuf, usize> = FxHashMap::default();
        for buffer in buffers {
            let file = match (&buffer.uri, embedded) {
                _ if buffer.extensions.is_fallback() => 0,
                (None, Some(_)) => 1,
                (None, None) => return Err(ReadError::file("a buffer without bytes", REMEDY)),
                (Some(uri), _) => {
                    let path = path_inside(uri).filter(|_| !uri.starts_with("data:"));
                    match path.as_ref().and_then(|path| known.get(path)) {
                        Some(&file) => file,
                        None => {
                            held.files.push(Cow::Owned(load_uri(uri, fetch)?));
                            known.extend(path.map(|path| (path, held.files.len() - 1)));
                            held.files.len() - 1
                        }
                    }
                }
            };
            held.of_buffers.push(file);
        }
        Ok(held)
    }

    /// The same with bytes of its own.
    pub fn into_owned(self) -> Buffers<'static> {
        let files = self.files.into_iter().map(|bytes| Cow::Owned(bytes.into_owned())).collect();
        Buffers { files, of_buffers: self.of_buffers }
    }

    /// The bytes of a buffer.
    pub fn get(&self, index: usize) -> Option<&[u8]> {
        self.of_buffers.get(index).map(|&file| &*self.files[file])
    }

    /// How many bytes were read, those of a file once.
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
        let text = names.map(|uri| format!(r#"{{"uri": "{uri}"}}"#)).join(",");
        let buffers: Vec<Buffer> = serde_json::from_str(&format!("[{text}]")).unwrap();
        let n_read = Cell::new(0);
        let fetch = |uri: &str| {
            n_read.set(n_read.get() + 1);
            Ok(uri.as_bytes().to_vec())
        };
        let held = Buffers::load(&buffers, None, &fetch).unwrap();
        assert_eq!((n_read.get(), held.n_bytes()), (2, 10));
        assert_eq!(
            [0, 3, 4, 5].map(|i| held.get(i)),
            [Some(&b"a.bin"[..]), Some(b"a.bin"), Some(b"b.bin"), Some(b"a.bin")]
        );
        assert_eq!(held.get(6), None);
    }
}
