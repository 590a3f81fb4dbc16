//! Document and buffers of a glTF, from JSON or GLB.

use serde::Deserialize;
use serde_json::Value;

use super::accessor::Data;
use super::buffers::AssetBuffers;
use super::refusals::REMEDY;
use super::schema::Root;
use super::{compressed, draco};
use crate::io::memory::instance_limit;
use crate::io::{FileFetcher, ReadError};

pub(super) struct Container<'a> {
    pub root: Root,
    pub buffers: AssetBuffers<'a>,
    pub decompressed: Vec<Option<Vec<u8>>>,
}

impl<'a> Container<'a> {
    pub fn open(bytes: &'a [u8], fetch: &FileFetcher) -> Result<Self, ReadError> {
        let (json, embedded) = split_chunks(bytes)?;
        // The version is checked before parsing: glTF 1.0 has another structure and would fail with a misleading error.
        refuse_version_1(json)?;
        let mut root: Root = serde_json::from_slice(json).map_err(|error| {
            // The parser counts lines; the error needs a byte.
            let before: usize =
                json.split_inclusive(|&byte| byte == b'\n').take(error.line().saturating_sub(1)).map(<[u8]>::len).sum();
            ReadError::line(json, before, format!("the JSON is malformed or not glTF ({error})"), REMEDY)
        })?;
        // Some writers do not mark a buffer as a fallback although all its views are compressed elsewhere.
        let is_spare = |at: usize| embedded.is_none() && has_only_compressed_views(&root, at);
        let named = root.buffers.iter().enumerate();
        let named =
            named.map(|(at, it)| (it.uri.as_deref(), it.extensions.is_fallback() || it.uri.is_none() && is_spare(at)));
        let buffers = AssetBuffers::load(named, embedded, fetch)?;
        let views: Vec<_> = root.buffer_views.iter().map(|view| view.extensions.compression()).collect();
        // Views are decompressed before Draco: both add to the root, but only Draco changes accessors.
        let decompressed = compressed::decompress(&views, &buffers)?;
        draco::decompress(&mut root, &buffers)?;
        Ok(Self { root, buffers, decompressed })
    }

    pub fn into_owned(self) -> Container<'static> {
        Container { root: self.root, buffers: self.buffers.into_owned(), decompressed: self.decompressed }
    }

    pub fn data(&self) -> Data<'_> {
        Data { root: &self.root, buffers: &self.buffers, decompressed: &self.decompressed }
    }

    /// Returns the largest number of vertices and faces accepted from an asset of `n_bytes`.
    pub fn budget(&self, n_bytes: usize) -> usize {
        instance_limit(n_bytes + self.buffers.n_bytes() + self.n_decompressed())
    }

    pub fn n_decompressed(&self) -> usize {
        let decoded = self.root.accessors.iter().filter_map(|accessor| accessor.decoded.as_ref());
        self.decompressed.iter().flatten().chain(decoded).map(Vec::len).sum()
    }
}

fn has_only_compressed_views(root: &Root, buffer: usize) -> bool {
    // The bytes of a buffer are not needed if all its views are compressed in other buffers.
    let mut views = root.buffer_views.iter().filter(|view| view.buffer == buffer).peekable();
    views.peek().is_some() && views.all(|view| view.extensions.compression().is_some())
}

fn old_version_error(version: &str) -> ReadError {
    let remedy = "convert it to 2.0 first, as with `npx gltf-pipeline -i OLD -o NEW.glb`";
    ReadError::file(format!("glTF {version} cannot be read, only glTF 2.0"), remedy)
}

fn refuse_version_1(json: &[u8]) -> Result<(), ReadError> {
    // Only the version is parsed, as the rest may have any structure.
    let stated = serde_json::from_slice::<VersionStatement>(json).ok().and_then(|stated| stated.asset?.version);
    let version = stated.map(|version| version.as_str().map_or_else(|| version.to_string(), String::from));
    match version.filter(|version| ["0", "1"].contains(&version.split('.').next().unwrap_or_default())) {
        Some(version) => Err(old_version_error(&version)),
        None => Ok(()),
    }
}

#[derive(Deserialize)]
struct VersionStatement {
    asset: Option<StatedVersion>,
}

#[derive(Deserialize)]
struct StatedVersion {
    version: Option<Value>,
}

pub(super) fn split_chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), ReadError> {
    let (json, binary) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    // Some writers pad the JSON with zero bytes instead of blanks.
    let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    // A download that was cut, a page in its place, or the name of a file that is stored elsewhere.
    if json.trim_ascii_start().first() != Some(&b'{') {
        return Err(ReadError::byte(
            0,
            "neither glTF nor GLB begins like this",
            "get the file again, and check its format",
        ));
    }
    Ok((&json[..end], binary))
}

fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), ReadError> {
    match read_u32(bytes, 4) {
        Some(2) => {}
        Some(1) => return Err(old_version_error("1.0")),
        version => {
            let what = format!("version {} of glTF", version.unwrap_or(0));
            return Err(ReadError::byte(4, what, "export the asset as glTF 2.0"));
        }
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    // Unknown chunks are skipped, as the specification demands.
    while let (Some(length), Some(kind)) = (read_u32(bytes, at), bytes.get(at + 4..at + 8)) {
        let chunk = bytes.get(at + 8..).and_then(|rest| rest.get(..length as usize));
        let chunk = chunk.ok_or_else(|| {
            ReadError::byte(at, "a chunk is longer than the file", "the file is cut, export the asset again")
        })?;
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += 8 + length as usize;
    }
    Ok((json.ok_or_else(|| ReadError::byte(12, "no JSON in the container", REMEDY))?, binary))
}

fn read_u32(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}
