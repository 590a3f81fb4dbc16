//! glTF files as bytes with their buffers.

use std::cell::RefCell;
use std::collections::HashMap;

use bevy_asset::io::Reader;
use bevy_asset::{Asset, AssetLoader, LoadContext};
use bevy_ecs::error::BevyError;
use bevy_reflect::TypePath;
use neural_mesh::io::{self, ReadError};

/// glTF file with the buffers that it refers to.
#[derive(Asset, TypePath)]
pub struct GltfSource {
    /// The file as the library reads it; images stay where they are.
    pub asset: io::Asset,
}

/// Loader of glTF files for processors; Bevy's own turns them into meshes and materials that nothing can save.
#[derive(Default, TypePath)]
pub struct GltfSourceLoader;

impl AssetLoader for GltfSourceLoader {
    type Asset = GltfSource;
    type Settings = ();
    type Error = BevyError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<GltfSource, BevyError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let mut files: HashMap<String, Vec<u8>> = HashMap::new();
        // The library asks for one buffer after the other, and cannot wait: each that is missing is read, and the file
        // is opened again.
        loop {
            let (opened, missing) = open(&bytes, &files);
            match (opened, missing) {
                (Err(_), Some(uri)) => {
                    let path = context.path().resolve_embed_str(&decode_percent(&uri)?)?;
                    let buffer = context.read_asset_bytes(path).await?;
                    files.insert(uri, buffer);
                }
                (opened, _) => return Ok(GltfSource { asset: opened? }),
            }
        }
    }

    fn extensions(&self) -> &[&str] {
        // Processors name this loader; no file is loaded with it otherwise.
        &[]
    }
}

/// Opens a file; also returns the first companion file that was asked for and is not in `files`.
///
/// A missing image is no error, so images are never read.
fn open(bytes: &[u8], files: &HashMap<String, Vec<u8>>) -> (Result<io::Asset, ReadError>, Option<String>) {
    let missing = RefCell::new(None);
    let fetch = |uri: &str| {
        files.get(uri).cloned().ok_or_else(|| {
            missing.borrow_mut().get_or_insert_with(|| uri.to_string());
            ReadError::file(format!("{uri} is missing"), "add it to the assets")
        })
    };
    let opened = io::Asset::from_bytes(bytes, &fetch);
    (opened, missing.into_inner())
}

/// Decodes `%20` and its like, which URIs have in place of some letters.
fn decode_percent(uri: &str) -> Result<String, std::string::FromUtf8Error> {
    let mut decoded = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let digits = after.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        let byte = digits.filter(|_| first == b'%').and_then(|digits| u8::from_str_radix(digits, 16).ok());
        decoded.push(byte.unwrap_or(first));
        rest = if byte.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(decoded)
}

#[cfg(test)]
mod tests {
    use super::decode_percent;

    #[test]
    fn escaped_letters_are_decoded_and_others_stay() {
        for (uri, path) in [("a%20b.bin", "a b.bin"), ("%C3%A4/%", "\u{e4}/%"), ("100%zz", "100%zz"), ("", "")] {
            assert_eq!(decode_percent(uri).as_deref(), Ok(path));
        }
        assert!(decode_percent("%ff").is_err());
    }
}
