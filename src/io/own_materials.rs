//! Materials of a file that holds what they look like itself (glTF), as a library and textures beside an OBJ or a PLY.

use std::path::PathBuf;

use super::ImageUse;
use super::beside::{Finder, reference};
use super::extra::Extra;
use super::material::used_as;
use super::write::push_singles;
use crate::mesh::{BaseTexture, Finish, Look, Wrap, srgb};

/// A library of materials, and where their textures lie beside the output.
#[derive(Debug, Default)]
pub(super) struct OwnMaterials {
    /// The text of the library; empty where there are no materials.
    pub text: Vec<u8>,
    /// Material and the place of its texture.
    pub textures: Vec<(String, String)>,
}

impl OwnMaterials {
    /// The materials that groups use, as a library; lists their textures for the output, called after `name`.
    pub fn list(extra: &Extra, name: &str, finder: &mut Finder) -> Self {
        let mut own = Self::default();
        let used = extra.materials();
        let mut places = Places { name, finder, known: Vec::new() };
        for (material, look) in extra.looks.iter().filter(|(material, _)| used.contains(&material.as_str())) {
            own.add(material, look);
            if let Some(texture) = &look.texture {
                let place = own.map("map_Kd", texture, &mut places);
                own.textures.push((material.clone(), place));
            }
            own.add_finish(&look.finish, &mut places);
        }
        own
    }

    fn add(&mut self, material: &str, look: &Look) {
        self.text.extend(format!("newmtl {material}\n").into_bytes());
        self.numbers("Kd", &look.colour.map(srgb));
    }

    /// What the material does with light, as far as it is no default; numbers as Wavefront's readers with roughness take them.
    fn add_finish<'a>(&mut self, finish: &'a Finish, places: &mut Places<'a, '_, '_>) {
        let plain = Finish::default();
        if finish.emission != plain.emission {
            self.numbers("Ke", &finish.emission.map(srgb));
            finish.emission_texture.iter().for_each(|texture| drop(self.map("map_Ke", texture, places)));
        }
        if (finish.roughness, finish.metal) != (plain.roughness, plain.metal) {
            self.numbers("Pr", &[finish.roughness]);
            self.numbers("Pm", &[finish.metal]);
        }
        // One image for both is glTF's: there they are the green and the blue of it.
        if finish.roughness_texture != finish.metal_texture {
            finish.roughness_texture.iter().for_each(|texture| drop(self.map("map_Pr", texture, places)));
            finish.metal_texture.iter().for_each(|texture| drop(self.map("map_Pm", texture, places)));
        }
        finish.normal_texture.iter().for_each(|texture| drop(self.map("norm", texture, places)));
    }

    /// A statement with numbers.
    fn numbers(&mut self, word: &str, numbers: &[f32]) {
        self.text.extend(format!("{word} ").into_bytes());
        push_singles(&mut self.text, numbers);
        self.text.push(b'\n');
    }

    /// A statement with a texture, and the place where that will lie.
    fn map<'a>(&mut self, word: &str, texture: &'a BaseTexture, places: &mut Places<'a, '_, '_>) -> String {
        let place = places.of(texture, used_as(word.as_bytes()));
        let clamp = if texture.wrap == [Wrap::Clamp; 2] { "-clamp on " } else { "" };
        self.text.extend(format!("{word} {clamp}{place}\n").into_bytes());
        place
    }
}

/// Where textures will lie beside the output, each image once.
struct Places<'a, 'b, 'c> {
    name: &'b str,
    finder: &'b mut Finder<'c>,
    known: Vec<(&'a BaseTexture, String)>,
}

impl<'a> Places<'a, '_, '_> {
    fn of(&mut self, texture: &'a BaseTexture, used: ImageUse) -> String {
        let known = self.known.iter().find(|(other, _)| other.image == texture.image).map(|(_, place)| place.clone());
        known.unwrap_or_else(|| {
            let ending = match (extension(&texture.image), self.finder.maker) {
                // What is made of it is of another kind.
                ("ktx2", Some(maker)) => maker.made(&texture.image, used).map_or("ktx2", |made| extension(&made)),
                (ending, _) => ending,
            };
            let place = PathBuf::from(format!("{}_{}.{ending}", self.name, self.known.len()));
            self.finder.list_image(&place, &texture.image, used);
            self.known.push((texture, reference(&place)));
            reference(&place)
        })
    }
}

/// The extension of a picture by how it begins.
pub(super) fn extension(image: &[u8]) -> &'static str {
    match image {
        [0x89, b'P', b'N', b'G', ..] => "png",
        [0xff, 0xd8, ..] => "jpg",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "webp",
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, ..] => "ktx2",
        _ => "bin",
    }
}
