//! Companion files by their URI.

use super::{ReadError, shorten_name};

/// Returns the bytes of a companion file by its URI.
pub type FileFetcher<'a> = dyn Fn(&str) -> Result<Vec<u8>, ReadError> + 'a;

/// Rejects every companion file, for meshes without a path.
pub fn refuse_external_file(uri: &str) -> Result<Vec<u8>, ReadError> {
    let what = format!("the buffer {:?} is a separate file", shorten_name(uri));
    Err(ReadError::file(what, "read the asset by its path or export it as GLB"))
}
