//! Materials of a mesh's groups.

use std::path::Path;

use rustc_hash::FxHashMap;

use super::companion_files::{CompanionFile, FileFinder};
use super::extra::{Extra, Group, decode_text};
use super::material_libraries::{file_name, first_word, library_names};
use super::texture_comments::{comment_textures, texture_number};
use crate::mesh::{BaseTexture, Look, Looks, Wrap, linear_light};

/// Reads the materials of a mesh's groups: from the file, its libraries or its textures; white by default.
///
/// Only `allow_outside` permits files outside the mesh's folder. The second result lists missing files.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{read_looks, read_attributed_path};
/// let read = read_attributed_path("../../tests/meshes/tiny/tetrahedron.obj".as_ref(), None).unwrap();
/// assert!(read_looks(&read.extra, false).0.is_plain());
/// ```
pub fn read_looks(extra: &Extra, allow_outside: bool) -> (Looks, Vec<String>) {
    let mut finder = FileFinder::new(extra, allow_outside);
    let of_groups = if comment_textures(extra).next().is_some() {
        read_numbered_textures(extra, &mut finder)
    } else {
        read_libraries(extra, &mut finder)
    };
    (Looks { of_groups, v_is_up: true, linear_colours: false }, finder.notes)
}

fn read_numbered_textures(extra: &Extra, finder: &mut FileFinder) -> Vec<Look> {
    // Textures in comments use per-corner coordinates if the file has such.
    let channel = extra.layouts.iter().find(|layout| layout.per_corner).map(|layout| layout.channel.clone());
    let channel = channel.unwrap_or_default();
    let wrap = [Wrap::Repeat; 2];
    let look = |name: &str| {
        let image = finder.find(Path::new(""), name).map(|found| found.bytes);
        Look { texture: image.map(|image| BaseTexture { image, channel: channel.clone(), wrap }), ..Look::default() }
    };
    let looks: Vec<Look> = comment_textures(extra).map(look).collect();
    let of_group = |group: &Group| looks.get(texture_number(extra, group)?).cloned();
    // Faces without numbers all have the first texture.
    let groups = if extra.groups.is_empty() { &[Group::default()][..] } else { &extra.groups };
    groups.iter().map(|group| of_group(group).unwrap_or_default()).collect()
}

fn read_libraries(extra: &Extra, finder: &mut FileFinder) -> Vec<Look> {
    let mut materials: Vec<(String, Look)> = extra.looks.clone();
    for name in library_names(extra, finder) {
        if let Some(library) = finder.find(Path::new(""), name) {
            materials.append(&mut read_library(&library, finder));
        }
    }
    // The first of several materials with one name counts, so the order is reversed.
    let by_name: FxHashMap<&str, &Look> = materials.iter().rev().map(|(name, look)| (name.as_str(), look)).collect();
    let look = |name: &Option<String>| by_name.get(name.as_deref()?).map(|&look| look.clone());
    extra.groups.iter().map(|group| look(&group.material).unwrap_or_default()).collect()
}

fn read_library(library: &CompanionFile, finder: &mut FileFinder) -> Vec<(String, Look)> {
    let base = library.folder();
    let mut materials: Vec<(String, Look)> = Vec::new();
    for line in library.bytes.split(|&byte| byte == b'\n' || byte == b'\r') {
        // Statements are read leniently: an unknown or broken one changes nothing.
        let (word, rest) = first_word(line);
        if word == b"newmtl" {
            materials.push((decode_text(rest.trim_ascii()), Look::default()));
        }
        // Statements before the first material belong to none.
        let Some((_, look)) = materials.last_mut() else { continue };
        let word = word.to_ascii_lowercase();
        if !parse_numbers(look, &word, rest)
            && let Some(slot) = texture_slot(look, &word)
        {
            let bytes = finder.find(base, &decode_text(file_name(rest))).map(|found| found.bytes);
            *slot = bytes.map(|image| BaseTexture { image, channel: String::new(), wrap: parse_wrap(rest) });
        }
    }
    materials.iter_mut().for_each(|(_, look)| show_textures(look));
    materials
}

/// Stores the colour or number of an MTL statement in `look`; returns false for other statements.
fn parse_numbers(look: &mut Look, word: &[u8], rest: &[u8]) -> bool {
    let share =
        |known: f32| parse_leading_numbers(rest).next().filter(|x| x.is_finite()).map_or(known, |x| x.clamp(0.0, 1.0));
    match word {
        b"kd" => look.colour = parse_colour(rest).unwrap_or(look.colour),
        b"ke" => look.finish.emission = parse_colour(rest).unwrap_or(look.finish.emission),
        b"pr" => look.finish.roughness = share(look.finish.roughness),
        b"pm" => look.finish.metal = share(look.finish.metal),
        b"d" => look.finish.is_opaque = share(1.0) == 1.0,
        _ => return false,
    }
    true
}

fn texture_slot<'a>(look: &'a mut Look, word: &[u8]) -> Option<&'a mut Option<BaseTexture>> {
    let Look { texture, finish, .. } = look;
    match word {
        b"map_kd" => Some(texture),
        b"map_ke" => Some(&mut finish.emission_texture),
        b"map_pr" => Some(&mut finish.roughness_texture),
        b"map_pm" => Some(&mut finish.metal_texture),
        b"norm" => Some(&mut finish.normal_texture),
        _ => None,
    }
}

// A black colour or zero metal would hide its texture, which no file means.
fn show_textures(look: &mut Look) {
    if look.texture.is_some() && look.colour == [0.0; 3] {
        look.colour = [1.0; 3];
    }
    if look.finish.emission_texture.is_some() && look.finish.emission == [0.0; 3] {
        look.finish.emission = [1.0; 3];
    }
    if look.finish.metal_texture.is_some() && look.finish.metal == 0.0 {
        look.finish.metal = 1.0;
    }
}

/// Parses one or three sRGB numbers into linear light.
fn parse_colour(text: &[u8]) -> Option<[f32; 3]> {
    let mut numbers = parse_leading_numbers(text);
    let first = numbers.next()?;
    let colour = [first, numbers.next().unwrap_or(first), numbers.next().unwrap_or(first)];
    colour.iter().all(|x| x.is_finite()).then(|| colour.map(|x| linear_light(x.clamp(0.0, 1.0))))
}

fn parse_leading_numbers(text: &[u8]) -> impl Iterator<Item = f32> {
    let text = std::str::from_utf8(text).unwrap_or_default();
    text.split_whitespace().map_while(|word| word.parse::<f32>().ok())
}

fn parse_wrap(options: &[u8]) -> [Wrap; 2] {
    let mut words = options.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    // The value must follow its option directly.
    let is_clamped = words.any(|word| word == b"-clamp") && words.next() == Some(b"on");
    [if is_clamped { Wrap::Clamp } else { Wrap::Repeat }; 2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::Folder;
    use crate::io::{Column, Scalar};
    use crate::mesh::Finish;

    fn looks_from_library(text: &str) -> (Vec<Look>, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("maps")).unwrap();
        std::fs::write(folder.path().join("maps/a b.png"), b"png").unwrap();
        std::fs::write(folder.path().join("m.mtl"), text).unwrap();
        let group = |name: Option<&str>| Group { material: name.map(String::from), ..Group::default() };
        let extra = Extra {
            groups: vec![group(Some("skin")), group(None), group(Some("horn"))],
            material_libraries: vec!["m.mtl".into()],
            folder: Some(Folder::from_file(&folder.path().join("mesh"))),
            ..Extra::default()
        };
        let (looks, notes) = read_looks(&extra, false);
        assert!(looks.v_is_up);
        (looks.of_groups, notes)
    }

    #[test]
    fn colours_and_textures_are_read() {
        let (looks, notes) =
            looks_from_library("newmtl horn\r\nKd 0 1 0.5\r\nnewmtl skin\nKd 1 1 1\nmap_Kd -clamp on maps/a b.png\n");
        let texture = looks[0].texture.as_ref().unwrap();
        assert_eq!((&texture.image[..], texture.wrap, looks[0].colour), (&b"png"[..], [Wrap::Clamp; 2], [1.0; 3]));
        assert_eq!(looks[1], Look::default());
        assert_eq!(looks[2], Look { colour: [0.0, 1.0, linear_light(0.5)], ..Look::default() });
        assert!(notes.is_empty(), "{notes:?}");
    }

    #[test]
    fn what_materials_do_with_light_is_read() {
        let (looks, notes) = looks_from_library(
            "newmtl horn\nKe 0 1 0\nPr 0.6\nPm x\nd 0.5\nnorm -bm 1 maps/a b.png\nnewmtl skin\nmap_Ke maps/a b.png\nmap_Pm maps/a b.png\n",
        );
        let Finish { emission, roughness, metal, is_opaque, normal_texture, .. } = &looks[2].finish;
        assert_eq!((*emission, *roughness, *metal, *is_opaque), ([0.0, 1.0, 0.0], 0.6, 0.0, false));
        assert!(normal_texture.is_some() && looks[1].finish == Finish::default() && notes.is_empty());
        // Black and no metal under a texture mean the texture.
        let Finish { emission, emission_texture, metal, metal_texture, .. } = &looks[0].finish;
        assert!(emission_texture.is_some() && metal_texture.is_some());
        assert_eq!((*emission, *metal), ([1.0; 3], 1.0));
    }

    #[test]
    fn what_stands_before_the_first_material_belongs_to_none() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.mtl"), "newmtl skin\nKd 0 1 0\n").unwrap();
        std::fs::write(folder.path().join("b.mtl"), "Kd 1 0 0\nnewmtl horn\n").unwrap();
        let extra = Extra {
            groups: vec![Group { material: Some("skin".into()), ..Group::default() }],
            material_libraries: vec!["a.mtl b.mtl".into()],
            folder: Some(Folder::from_file(&folder.path().join("mesh"))),
            ..Extra::default()
        };
        assert_eq!(read_looks(&extra, false).0.of_groups[0].colour, [0.0, 1.0, 0.0]);
    }

    #[test]
    fn what_is_missing_or_outside_is_said_and_left_out() {
        for name in ["gone.png", "../secret.png", "/etc/passwd"] {
            let (looks, notes) = looks_from_library(&format!("newmtl skin\nKd x y\nmap_Kd {name}\n"));
            assert!(looks[0] == Look::default() && notes.len() == 1, "{name}: {notes:?}");
        }
    }

    #[test]
    fn numbers_of_faces_choose_among_the_textures_that_comments_name() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", "b c.png"] {
            std::fs::write(folder.path().join(name), name).unwrap();
        }
        let group = |number: f64| Group { values: vec![number], ..Group::default() };
        let comments = ["comment made by hand", "comment TextureFile a.png", "comment TextureFile b c.png"];
        let extra = Extra {
            groups: [1.0, 0.0, -1.0, 2.0].map(group).to_vec(),
            face_columns: vec![Column { name: "texnumber".into(), scalar: Scalar::I32 }],
            comments: comments.map(String::from).to_vec(),
            folder: Some(Folder::from_file(&folder.path().join("mesh"))),
            ..Extra::default()
        };
        let image = |look: &Look| look.texture.as_ref().map(|texture| texture.image.to_vec());
        let (found, notes) = read_looks(&extra, false);
        let images: Vec<_> = found.of_groups.iter().map(image).collect();
        assert_eq!(images, [Some(b"b c.png".to_vec()), Some(b"a.png".to_vec()), None, None]);
        assert!(found.v_is_up && notes.is_empty());
        let bare = Extra { groups: Vec::new(), face_columns: Vec::new(), ..extra };
        assert_eq!(image(&read_looks(&bare, false).0.of_groups[0]), Some(b"a.png".to_vec()));
    }

    #[test]
    fn black_under_a_texture_means_the_texture() {
        let (looks, _) = looks_from_library("newmtl skin\nKd 0 0 0\nmap_Kd maps/a b.png\nnewmtl horn\nKd 0 0 0\n");
        assert_eq!((looks[0].colour, looks[2].colour), ([1.0; 3], [0.0; 3]));
    }
}
