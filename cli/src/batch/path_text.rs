//! Reversible text of paths, with `/` as separator.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Formats a path with `/` between names; invalid UTF-8 bytes become `\xff`, backslashes double.
pub fn spell_path(path: &Path) -> String {
    let names: Vec<String> = path.iter().map(spell_name).collect();
    names.join("/")
}

fn spell_name(name: &OsStr) -> String {
    let mut text = String::new();
    for chunk in name.as_encoded_bytes().utf8_chunks() {
        text += &chunk.valid().replace('\\', r"\\");
        text.extend(chunk.invalid().iter().map(|byte| format!(r"\x{byte:02x}")));
    }
    text
}

#[cfg(unix)]
pub fn parse_path(text: &str) -> PathBuf {
    use std::os::unix::ffi::OsStrExt;
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('\\') {
        bytes.extend(before.bytes());
        let byte = after.strip_prefix('x').and_then(|after| u8::from_str_radix(after.get(..2)?, 16).ok());
        bytes.push(byte.unwrap_or(b'\\'));
        rest = after.get(if byte.is_some() { 3 } else { usize::from(after.starts_with('\\')) }..).unwrap_or_default();
    }
    bytes.extend(rest.bytes());
    OsStr::from_bytes(&bytes).into()
}

#[cfg(not(unix))]
pub fn parse_path(text: &str) -> PathBuf {
    text.into()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use std::os::unix::ffi::OsStrExt;

    #[test]
    fn paths_are_restored_and_no_two_have_one_text() {
        let names: [&[u8]; 9] = [
            b"a.ply",
            b"deep/er/b.ply",
            b"a\xff.ply",
            b"a\xfe.ply",
            b"a\\xff.ply",
            b"a\\.ply",
            b"\\\xff\\",
            b"k\xc3\xa4se\xc3",
            b"\xef\xbf\xbd.ply",
        ];
        let paths = names.map(|name| PathBuf::from(OsStr::from_bytes(name)));
        for path in &paths {
            assert_eq!(parse_path(&spell_path(path)), *path, "{}", spell_path(path));
        }
        assert_eq!(paths.iter().map(|path| spell_path(path)).collect::<HashSet<_>>().len(), paths.len());
        assert_eq!(spell_path(&paths[2]), r"a\xff.ply");
    }

    #[test]
    fn any_text_parses_without_a_panic() {
        for text in ["\\", "a\\", "\\x", "\\x4", "\\xgg", "\\xä", "\\\\\\"] {
            parse_path(text);
        }
    }
}
