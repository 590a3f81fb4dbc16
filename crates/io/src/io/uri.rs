//! Files that a glTF names by URI.

use std::path::{Path, PathBuf};

use super::folder::{FileProblem, Folder, inner_path};
use super::{ReadError, shorten_name};

pub(super) fn fetch(folder: &Folder, uri: &str) -> Result<Vec<u8>, ReadError> {
    // URLs and absolute paths are rejected before anything is read.
    let found = path_inside(uri).ok_or(FileProblem::Outside);
    let found = found.and_then(|path| folder.read(&folder.resolve(&path, false)?));
    let refusal = |problem| {
        let uri = shorten_name(uri);
        ReadError::file(format!("the buffer {uri:?} {problem}"), "put the file next to the asset or export it as GLB")
    };
    found.map(|bytes| bytes.to_vec()).map_err(refusal)
}

/// Returns the path that a URI names in the asset's folder; `None` for others.
pub(super) fn path_inside(uri: &str) -> Option<PathBuf> {
    inner_path(Path::new(""), &decode_percent(uri)?)
}

fn decode_percent(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        let digits = tail.first_chunk::<2>().filter(|_| *first == b'%');
        // A percent sign without two digits is literal.
        match digits.and_then(|&[high, low]| Some(16 * digit(high)? + digit(low)?)) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => bytes.push(*first),
        }
    }
    String::from_utf8(bytes).ok()
}

fn digit(letter: u8) -> Option<u8> {
    char::from(letter).to_digit(16).map(|digit| digit as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_mean_paths_within_the_folder() {
        for (uri, expected) in [
            ("a%20b.bin", Some("a b.bin")),
            ("./a.bin", Some("a.bin")),
            ("x/./../maps/a.png", Some("maps/a.png")),
            ("maps\\a.png", Some("maps/a.png")),
            ("100%.bin", Some("100%.bin")),
            ("a%+1.bin", Some("a%+1.bin")),
            ("%2e%2e/a.bin", None),
            ("%00", None),
            ("%ff", None),
        ] {
            assert_eq!(path_inside(uri), expected.map(PathBuf::from), "{uri}");
        }
    }

    #[test]
    fn buffers_are_fetched_from_the_folder_of_the_asset_only() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(folder.path().join("secret"), b"no").unwrap();
        std::fs::write(inner.join("a b.bin"), b"yes").unwrap();
        let within = Folder::from_file(&inner.join("mesh"));
        assert_eq!(fetch(&within, "a%20b.bin").unwrap(), b"yes");
        let absolute = folder.path().join("secret");
        for uri in [
            "../secret",
            "%2e%2e/secret",
            "..\\secret",
            absolute.to_str().unwrap(),
            "file:///secret",
            "http://host/a",
            "",
            "x.bin",
            ".",
        ] {
            assert!(fetch(&within, uri).is_err(), "{uri}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(folder.path().join("secret"), inner.join("link")).unwrap();
            assert!(fetch(&within, "link").is_err());
        }
    }
}
