//! Type and content of a mesh file before parsing.

use std::path::Path;
use std::sync::{Mutex, OnceLock};

use neural_mesh::io;
use neural_mesh::simplify::Progression;

use crate::failure::Failure;
use crate::names::{is_progression_name, is_stream};

/// Content of one mesh file, read at most once.
#[derive(Debug, Default)]
pub struct Content {
    info: OnceLock<ContentInfo>,
}

#[derive(Debug)]
struct ContentInfo {
    is_gltf: bool,
    bytes: Mutex<Option<Result<Vec<u8>, Failure>>>,
}

impl Content {
    /// Returns whether the bytes are a glTF, or the progression of one; reads and keeps those of standard input and pipes.
    pub fn is_gltf(&self, path: &Path) -> bool {
        self.inspect(path).is_gltf
    }

    /// Returns the bytes of standard input or a pipe once; `None` for regular files.
    pub fn take(&self, path: &Path) -> Option<Result<Vec<u8>, Failure>> {
        match is_read_once(path) {
            true => self.inspect(path).bytes.lock().ok().and_then(|mut bytes| bytes.take()),
            false => None,
        }
    }

    fn inspect(&self, path: &Path) -> &ContentInfo {
        self.info.get_or_init(|| {
            if !is_read_once(path) {
                return ContentInfo {
                    is_gltf: io::is_gltf_path(path) || is_progression_of_gltf(path),
                    bytes: Mutex::default(),
                };
            }
            // A stream can be read only once, so its bytes are kept for the parser.
            let bytes = read(path);
            ContentInfo {
                is_gltf: bytes.as_ref().is_ok_and(|bytes| io::is_gltf(bytes)),
                bytes: Mutex::new(Some(bytes)),
            }
        })
    }
}

fn is_read_once(path: &Path) -> bool {
    is_stream(path) || std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// Returns whether a file is the progression of a glTF scene.
fn is_progression_of_gltf(path: &Path) -> bool {
    let bytes = is_progression_name(path).then(|| read(path).ok()).flatten();
    let progression = bytes.and_then(|bytes| Progression::from_bytes(&bytes).ok());
    progression.is_some_and(|it| it.files.first().is_some_and(|(_, bytes)| io::is_gltf(bytes)))
}

/// Reads all bytes of a file or of standard input.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let read = if is_stream(path) { io::read_stream(std::io::stdin().lock()) } else { io::read_file(path) };
    read.map_err(|error| Failure::in_file(path, error))
}
