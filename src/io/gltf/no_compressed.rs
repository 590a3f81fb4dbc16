//! What stands for decompression in a build without the feature `meshopt`: a refusal by name.

use serde::Deserialize;

use super::buffers::Buffers;
use crate::io::ReadError;

/// That a view is compressed; how does not matter here.
#[derive(Deserialize)]
pub(super) struct Compressed {}

/// Refuses assets with compressed buffer views that they need, by the extensions needed; gives nothing decompressed of others.
pub(super) fn decompress(
    views: &[Option<&Compressed>],
    _: &Buffers,
    extensions_required: &[String],
) -> Result<Vec<Option<Vec<u8>>>, ReadError> {
    let names = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
    if let Some(name) = extensions_required.iter().find(|name| names.contains(&name.as_str())) {
        let n_views = views.iter().flatten().count();
        let what = format!("needs the extension {name} (compressed buffer views: {n_views})");
        return Err(ReadError::file(what, "build with `--features meshopt` or export the asset without it"));
    }
    Ok(Vec::new())
}
