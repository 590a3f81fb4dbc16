//! Material libraries (MTL) of an OBJ, copied with adapted names.

use std::path::{Path, PathBuf};

use super::ImageUse;
use super::companion_files::{FileFinder, to_reference};
use super::extra::{Extra, decode_text};

/// Options of texture statements, and the most words after each.
const OPTIONS: [(&[u8], usize); 14] = [
    (b"-blendu", 1),
    (b"-blendv", 1),
    (b"-cc", 1),
    (b"-clamp", 1),
    (b"-texres", 1),
    (b"-bm", 1),
    (b"-boost", 1),
    (b"-imfchan", 1),
    (b"-type", 1),
    (b"-mm", 2),
    (b"-colorspace", 1),
    (b"-o", 3),
    (b"-s", 3),
    (b"-t", 3),
];

#[derive(Debug, Default)]
pub(super) struct Libraries {
    // File names of the libraries as the output writes them.
    pub names: Vec<String>,
    // Materials and the output paths of their textures (`map_Kd`).
    pub textures: Vec<(String, String)>,
}

impl Libraries {
    /// Adds the mesh's libraries and their textures to the output.
    pub fn find(extra: &Extra, finder: &mut FileFinder) -> Self {
        let mut libraries = Self::default();
        for name in library_names(extra, finder) {
            let renamed = libraries.add(name, finder);
            libraries.names.push(renamed.unwrap_or_else(|| name.to_string()));
        }
        libraries
    }

    fn add(&mut self, name: &str, finder: &mut FileFinder) -> Option<String> {
        let found = finder.find(Path::new(""), name)?;
        let text = self.with_textures(&found.bytes, found.folder(), &found.output_path, finder);
        let place = finder.add_file(&found.output_path, &text);
        (found.is_renamed || place != found.output_path).then(|| to_reference(&place))
    }

    fn with_textures(&mut self, text: &[u8], base: &Path, place: &Path, finder: &mut FileFinder) -> Vec<u8> {
        let mut out = Vec::with_capacity(text.len());
        let mut material = String::new();
        for line in text.split_inclusive(|&byte| byte == b'\n' || byte == b'\r') {
            // Lines are copied unchanged, with their ends, unless a texture name in them changes.
            let (word, rest) = first_word(line);
            if word == b"newmtl" {
                material = decode_text(rest.trim_ascii());
            }
            let Some(name) = is_texture(word).then(|| file_name(rest)).filter(|name| !name.is_empty()) else {
                out.extend(line);
                continue;
            };
            // A missing texture keeps its name; the finder has noted it.
            let Some(found) = finder.find(base, &decode_text(name)) else {
                out.extend(line);
                continue;
            };
            let texture = finder.add_image(&found.output_path, &found.bytes, texture_use(word));
            // Other formats need to know the base textures.
            if word.eq_ignore_ascii_case(b"map_kd") {
                self.textures.push((material.clone(), to_reference(&texture)));
            }
            if found.is_renamed || texture != found.output_path {
                // The name is the end of the line; only the name changes, so that options and comments survive.
                let start = line.trim_ascii_end().len() - name.len();
                out.extend(&line[..start]);
                out.extend(from_folder_of(place, &texture).as_bytes());
                out.extend(&line[start + name.len()..]);
            } else {
                out.extend(line);
            }
        }
        out
    }
}

// A line may name several libraries, or one with blanks in its name.
pub(super) fn library_names<'a>(extra: &'a Extra, finder: &FileFinder) -> Vec<&'a str> {
    let of_line =
        |line: &'a String| if finder.has_file(line) { vec![line.as_str()] } else { line.split_whitespace().collect() };
    extra.material_libraries.iter().flat_map(of_line).collect()
}

fn from_folder_of(place: &Path, other: &Path) -> String {
    let up: PathBuf = place
        .parent()
        .map_or(0, |folder| folder.components().count())
        .checked_sub(1)
        .map_or_else(PathBuf::new, |n| std::iter::repeat_n("..", n + 1).collect());
    to_reference(&up.join(other))
}

pub(super) fn first_word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii_start();
    line.split_at(line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len()))
}

fn is_texture(word: &[u8]) -> bool {
    let others = [&b"bump"[..], b"disp", b"decal", b"refl", b"norm"];
    word.get(..4).is_some_and(|start| start.eq_ignore_ascii_case(b"map_")) && !word.eq_ignore_ascii_case(b"map_aat")
        || others.iter().any(|other| word.eq_ignore_ascii_case(other))
}

pub(super) fn texture_use(word: &[u8]) -> ImageUse {
    match word.to_ascii_lowercase().as_slice() {
        b"norm" => ImageUse::Normals,
        b"map_ka" | b"map_kd" | b"map_ke" | b"map_ks" | b"decal" | b"refl" => ImageUse::Colours,
        _ => ImageUse::Numbers,
    }
}

pub(super) fn file_name(mut rest: &[u8]) -> &[u8] {
    loop {
        rest = rest.trim_ascii();
        let (word, mut behind) = first_word(rest);
        let Some((_, most)) = OPTIONS.iter().find(|(option, _)| word.eq_ignore_ascii_case(option)) else {
            return rest;
        };
        for i in 0..*most {
            // The first value of an option may be any word (`on`), further ones only numbers.
            let (value, next) = first_word(behind);
            let is_number = std::str::from_utf8(value).is_ok_and(|value| value.parse::<f32>().is_ok());
            if i > 0 && !is_number || value.is_empty() {
                break;
            }
            behind = next;
        }
        rest = behind;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_behind_options() {
        for (rest, expected) in [
            (" skin.png\r\n", "skin.png"),
            ("  my skin.png ", "my skin.png"),
            (" -s 1 1 1 -o 0.5 a b.png", "a b.png"),
            (" -bm 0.2 -clamp on bump.tga", "bump.tga"),
            (" -mm 0 1 -o 1 2 3 x/y.png", "x/y.png"),
            (" -strange.png", "-strange.png"),
            (" -o 1", ""),
            ("", ""),
        ] {
            assert_eq!(file_name(rest.as_bytes()), expected.as_bytes(), "{rest:?}");
        }
    }

    #[test]
    fn statements_with_textures() {
        for word in ["map_Kd", "MAP_KS", "map_Bump", "bump", "disp", "refl", "norm", "map_Pr"] {
            assert!(is_texture(word.as_bytes()), "{word}");
        }
        for word in ["Kd", "newmtl", "map_aat", "illum", "map"] {
            assert!(!is_texture(word.as_bytes()), "{word}");
        }
    }

    #[test]
    fn a_library_in_a_folder_names_what_lies_outside_of_it() {
        assert_eq!(from_folder_of(Path::new("a.mtl"), Path::new("b.png")), "b.png");
        assert_eq!(from_folder_of(Path::new("x/y/a.mtl"), Path::new("b.png")), "../../b.png");
    }
}
