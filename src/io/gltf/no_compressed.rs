//! Stub of `meshopt` for builds without it.

use serde::Deserialize;

use super::buffers::AssetBuffers;
use crate::io::ReadError;

#[derive(Deserialize)]
pub(super) struct Compressed {}

/// Rejects assets that require the compression; other compressed views have fallbacks.
pub(super) fn decompress(
    views: &[Option<&Compressed>],
    _: &AssetBuffers,
    extensions_required: &[String],
) -> Result<Vec<Option<Vec<u8>>>, ReadError> {
    let names = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
    if let Some(name) = extensions_required.iter().find(|name| names.contains(&name.as_str())) {
        let n_views = views.iter().flatten().count();
        let what = format!("uses {name}, which this build cannot read (compressed buffer views: {n_views})");
        return Err(ReadError::file(what, "build with `--features meshopt` or export the asset without it"));
    }
    Ok(Vec::new())
}
