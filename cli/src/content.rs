//! What a mesh file turns out to be before it is read: its bytes say whether it is a glTF, whatever its name.

use std::path::Path;
use std::sync::{Mutex, OnceLock};

use neural_mesh::io;

use crate::failure::Failure;
use crate::names::is_stream;

/// What was seen of the bytes of one mesh file.
#[derive(Debug, Default)]
pub struct Content {
    seen: OnceLock<Seen>,
}

/// The answer, and the bytes where they come only once.
#[derive(Debug)]
struct Seen {
    is_gltf: bool,
    bytes: Mutex<Option<Result<Vec<u8>, Failure>>>,
}

impl Content {
    /// Whether the bytes of the file are a glTF. Standard input and pipes are read for that, and kept.
    pub fn is_gltf(&self, path: &Path) -> bool {
        self.seen(path).is_gltf
    }

    /// The bytes of standard input or of a pipe, once; `None` for a file, which its path leads to.
    pub fn take(&self, path: &Path) -> Option<Result<Vec<u8>, Failure>> {
        match comes_once(path) {
            true => self.seen(path).bytes.lock().ok().and_then(|mut bytes| bytes.take()),
            false => None,
        }
    }

    fn seen(&self, path: &Path) -> &Seen {
        self.seen.get_or_init(|| {
            if !comes_once(path) {
                return Seen { is_gltf: io::is_gltf_path(path), bytes: Mutex::default() };
            }
            let bytes = read(path);
            Seen { is_gltf: bytes.as_ref().is_ok_and(|bytes| io::is_gltf(bytes)), bytes: Mutex::new(Some(bytes)) }
        })
    }
}

/// Whether bytes can be read once alone.
fn comes_once(path: &Path) -> bool {
    is_stream(path) || std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// All bytes of a file, or of standard input.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let read = if is_stream(path) { io::read_stream(std::io::stdin().lock()) } else { io::read_file(path) };
    read.map_err(|error| Failure::of(path, error))
}
