//! Materials of a file that holds what they look like itself (glTF), as a library and textures beside an OBJ or a PLY.

use std::path::PathBuf;

use super::beside::{Finder, reference};
use super::extra::Extra;
use super::write::push_singles;
use crate::mesh::{BaseTexture, Look, Wrap, srgb};

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
        let mut images: Vec<(&BaseTexture, String)> = Vec::new();
        for (material, look) in extra.looks.iter().filter(|(material, _)| used.contains(&material.as_str())) {
            own.add(material, look);
            let Some(texture) = &look.texture else { continue };
            let known = images.iter().find(|(other, _)| other.image == texture.image).map(|(_, place)| place.clone());
            let place = known.unwrap_or_else(|| {
                let place = PathBuf::from(format!("{name}_{}.{}", images.len(), extension(&texture.image)));
                finder.list(&place, &texture.image);
                images.push((texture, reference(&place)));
                reference(&place)
            });
            let clamp = if texture.wrap == [Wrap::Clamp; 2] { "-clamp on " } else { "" };
            own.text.extend(format!("map_Kd {clamp}{place}\n").into_bytes());
            own.textures.push((material.clone(), place));
        }
        own
    }

    fn add(&mut self, material: &str, look: &Look) {
        self.text.extend(format!("newmtl {material}\nKd ").into_bytes());
        push_singles(&mut self.text, &look.colour.map(srgb));
        self.text.push(b'\n');
    }
}

/// The extension of a picture by how it begins.
fn extension(image: &[u8]) -> &'static str {
    match image {
        [0x89, b'P', b'N', b'G', ..] => "png",
        [0xff, 0xd8, ..] => "jpg",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "webp",
        _ => "bin",
    }
}
