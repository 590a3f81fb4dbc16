//! File formats.

use std::borrow::Cow;
use std::path::Path;

/// Mesh file format; readers distinguish text from binary by content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY; written as binary.
    Ply,
    /// Stanford PLY as text.
    PlyAscii,
    /// STL; written as binary.
    Stl,
    /// STL as text.
    StlAscii,
    /// Geomview OFF.
    Off,
    /// glTF 2.0; written as JSON.
    Gltf,
    /// glTF 2.0; written as GLB.
    Glb,
    /// 3MF, the 3D Manufacturing Format.
    ThreeMf,
    /// FBX, binary or text; only read.
    Fbx,
}

/// Attributes that a format stores.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum StoredAttributes {
    None,
    Colours,
    All,
}

impl Format {
    /// Returns the format of a path's extension, ignoring a final `.gz`.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Format;
    /// assert_eq!(Format::from_path("a/b.STL".as_ref()), Some(Format::Stl));
    /// assert_eq!(Format::from_path("a/b.ply.gz".as_ref()), Some(Format::Ply));
    /// ```
    pub fn from_path(path: &Path) -> Option<Self> {
        Self::from_name(Self::without_gz(path).extension()?.to_str()?)
    }

    /// Returns the path without a final `.gz`.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use std::path::Path;
    /// use neural_mesh::io::Format;
    /// assert_eq!(Format::without_gz(Path::new("a/b.ply.gz")), Path::new("a/b.ply"));
    /// assert_eq!(Format::without_gz(Path::new("a/b.ply")), Path::new("a/b.ply"));
    /// ```
    pub fn without_gz(path: &Path) -> Cow<'_, Path> {
        match path.extension() {
            Some(ending) if ending.eq_ignore_ascii_case("gz") => Cow::Owned(path.with_extension("")),
            _ => Cow::Borrowed(path),
        }
    }

    /// Returns the format of the content, by its signature or its first lines.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Format;
    /// assert_eq!(Format::from_content(b"# a mesh\nv 0 0 0\n"), Some(Format::Obj));
    /// assert_eq!(Format::from_content(b"hello"), None);
    /// ```
    pub fn from_content(bytes: &[u8]) -> Option<Self> {
        // A byte order mark and blanks may come before a signature.
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        let word = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        match word {
            _ if bytes.starts_with(b"glTF") => Some(Self::Glb),
            _ if is_package(bytes) => Some(Self::ThreeMf),
            _ if bytes.starts_with(b"Kaydara FBX Binary") || text.starts_with(b"; FBX ") => Some(Self::Fbx),
            b"ply" => Some(Self::Ply),
            // This precedes the test for a brace, since the count of a binary STL may begin with one; it follows PLY,
            // whose signature is certain.
            _ if is_binary_stl(bytes) || word.eq_ignore_ascii_case(b"solid") => Some(Self::Stl),
            _ if text.starts_with(b"{") => Some(Self::Gltf),
            // Comments may come first; the search ends after ten thousand lines.
            _ => text.split(|&byte| byte == b'\n' || byte == b'\r').take(10_000).find_map(from_line),
        }
    }
}

/// Returns the face count in the header of a binary STL.
pub(super) fn announced_stl_faces(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes)
}

/// Returns whether the length agrees with a binary STL's face count.
pub(super) fn is_binary_stl(bytes: &[u8]) -> bool {
    announced_stl_faces(bytes).is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count))
}

fn is_package(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") && memchr::memmem::rfind(bytes, b".model").is_some()
}

fn from_line(line: &[u8]) -> Option<Format> {
    let line = line.trim_ascii_start();
    let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    let off = [&b"OFF"[..], b"COFF", b"NOFF", b"CNOFF", b"STOFF", b"STCOFF", b"STNOFF", b"STCNOFF"];
    match word {
        b"v" | b"f" | b"vn" | b"vt" | b"o" | b"g" | b"s" | b"l" | b"p" | b"mtllib" | b"usemtl" => Some(Format::Obj),
        b"FBXHeaderExtension:" => Some(Format::Fbx),
        _ if off
            .iter()
            .any(|header| word.strip_prefix(*header).is_some_and(|rest| rest.iter().all(u8::is_ascii_digit))) =>
        {
            Some(Format::Off)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::Format;

    #[test]
    fn content_shows_the_format() {
        let cases: [(&[u8], Option<Format>); 18] = [
            (b"ply\nformat ascii 1.0\n", Some(Format::Ply)),
            (b"\xef\xbb\xbfply\r\n", Some(Format::Ply)),
            (b"solid name\nfacet", Some(Format::Stl)),
            (b"SOLID\n", Some(Format::Stl)),
            (b"# words\n\nCOFF\n", Some(Format::Off)),
            (b"OFF8 6 12\n", Some(Format::Off)),
            (b"OFFICE\n", None),
            (b"glTF\x02\0\0\0", Some(Format::Glb)),
            (b"  {\"asset\": {}}", Some(Format::Gltf)),
            (b"# words\r\rmtllib a.mtl\rv 0 0 0", Some(Format::Obj)),
            (b"f 1 2 3", Some(Format::Obj)),
            (b"PK\x03\x04 3D/a.model", Some(Format::ThreeMf)),
            (b"PK\x03\x04 a.txt", None),
            (b"Kaydara FBX Binary  \0\x1a\0", Some(Format::Fbx)),
            (b"; a comment\nFBXHeaderExtension:  {\n", Some(Format::Fbx)),
            (b"", None),
            (b"\xff\xd8\xff\xe0 JFIF", None),
            (&[0; 84], Some(Format::Stl)),
        ];
        for (bytes, format) in cases {
            assert_eq!(Format::from_content(bytes), format, "{}", bytes.escape_ascii());
        }
    }

    #[test]
    fn a_binary_stl_of_123_faces_under_a_blank_header_is_no_gltf() {
        let mut bytes = vec![b' '; 80];
        bytes.extend(123u32.to_le_bytes());
        bytes.resize(84 + 50 * 123, 0);
        assert_eq!(Format::from_content(&bytes), Some(Format::Stl));
    }
}
