//! Writes materials that came with a mesh (from glTF, say) as a material library with textures, for an OBJ or PLY.

use std::path::PathBuf;

use super::ImageUse;
use super::beside::{Finder, reference};
use super::extra::Extra;
use super::material::used_as;
use super::write::push_singles;
use crate::mesh::{BaseTexture, Finish, Look, Wrap, srgb};

/// A material library made from looks, with the output paths of its textures.
#[derive(Debug, Default)]
pub(super) struct OwnMaterials {
    /// Text of the library; empty without materials.
    pub text: Vec<u8>,
    /// Materials and the output paths of their textures.
    pub textures: Vec<(String, String)>,
}

impl OwnMaterials {
    /// Writes the materials that groups use; adds their textures, named after `name`, to the output.
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

    /// Appends the statements of a finish that differ from its defaults, in the usual extensions for roughness.
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
        // // A single image for both is glTF's, with values in green and blue; MTL cannot say that.
        if finish.roughness_texture != finish.metal_texture {
            finish.roughness_texture.iter().for_each(|texture| drop(self.map("map_Pr", texture, places)));
            finish.metal_texture.iter().for_each(|texture| drop(self.map("map_Pm", texture, places)));
        }
        finish.normal_texture.iter().for_each(|texture| drop(self.map("norm", texture, places)));
    }

    /// Appends a statement with numbers.
    fn numbers(&mut self, word: &str, numbers: &[f32]) {
        self.text.extend(format!("{word} ").into_bytes());
        push_singles(&mut self.text, numbers);
        self.text.push(b'\n');
    }

    /// Appends a statement with a texture and returns the texture's output path.
    fn map<'a>(&mut self, word: &str, texture: &'a BaseTexture, places: &mut Places<'a, '_, '_>) -> String {
        let place = places.of(texture, used_as(word.as_bytes()));
        let clamp = if texture.wrap == [Wrap::Clamp; 2] { "-clamp on " } else { "" };
        self.text.extend(format!("{word} {clamp}{place}\n").into_bytes());
        place
    }
}

/// Output paths of textures, each image once.
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
                // // A converter turns KTX2 into another type, which decides the extension.
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

/// Returns the file extension of an image by its signature.
pub(super) fn extension(image: &[u8]) -> &'static str {
    match image {
        [0x89, b'P', b'N', b'G', ..] => "png",
        [0xff, 0xd8, ..] => "jpg",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "webp",
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, ..] => "ktx2",
        _ => "bin",
    }
}
