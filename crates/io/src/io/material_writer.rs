//! Materials written as a material library.

use std::path::PathBuf;

use rustc_hash::FxHashSet;

use super::ImageUse;
use super::companion_files::{FileFinder, to_reference};
use super::distinct_images::DistinctImages;
use super::extra::Extra;
use super::material_libraries::texture_use;
use super::write::push_singles;
use crate::mesh::{BaseTexture, Finish, Wrap, srgb};

#[derive(Debug, Default)]
pub(super) struct MaterialLibrary {
    pub text: Vec<u8>,
    pub textures: Vec<(String, String)>,
}

impl MaterialLibrary {
    /// Writes the used materials; adds their textures, named after `name`.
    pub fn from_looks(extra: &Extra, name: &str, finder: &mut FileFinder) -> Self {
        let mut library = Self::default();
        // Materials that no group uses are left out.
        let used: FxHashSet<&str> = extra.materials().into_iter().collect();
        let mut paths = TexturePaths { name, finder, distinct: DistinctImages::default(), paths: Vec::new() };
        for (material, look) in extra.looks.iter().filter(|(material, _)| used.contains(&material.as_str())) {
            library.text.extend(format!("newmtl {material}\n").into_bytes());
            library.push_numbers("Kd", &look.colour.map(srgb));
            if let Some(texture) = &look.texture {
                let path = library.push_texture("map_Kd", texture, &mut paths);
                library.textures.push((material.clone(), path));
            }
            library.push_finish(&look.finish, &mut paths);
        }
        library
    }

    fn push_finish<'a>(&mut self, finish: &'a Finish, paths: &mut TexturePaths<'a, '_, '_>) {
        let plain = Finish::default();
        // Defaults are not written, so that plain materials stay short.
        if finish.emission != plain.emission {
            self.push_numbers("Ke", &finish.emission.map(srgb));
            finish.emission_texture.iter().for_each(|texture| drop(self.push_texture("map_Ke", texture, paths)));
        }
        if (finish.roughness, finish.metal) != (plain.roughness, plain.metal) {
            self.push_numbers("Pr", &[finish.roughness]);
            self.push_numbers("Pm", &[finish.metal]);
        }
        // glTF stores both in green and blue of one image, which MTL cannot express.
        if finish.roughness_texture != finish.metal_texture {
            finish.roughness_texture.iter().for_each(|texture| drop(self.push_texture("map_Pr", texture, paths)));
            finish.metal_texture.iter().for_each(|texture| drop(self.push_texture("map_Pm", texture, paths)));
        }
        finish.normal_texture.iter().for_each(|texture| drop(self.push_texture("norm", texture, paths)));
    }

    fn push_numbers(&mut self, word: &str, numbers: &[f32]) {
        self.text.extend(format!("{word} ").into_bytes());
        push_singles(&mut self.text, numbers);
        self.text.push(b'\n');
    }

    fn push_texture<'a>(
        &mut self,
        word: &str,
        texture: &'a BaseTexture,
        paths: &mut TexturePaths<'a, '_, '_>,
    ) -> String {
        let path = paths.add(texture, texture_use(word.as_bytes()));
        let clamp = if texture.wrap == [Wrap::Clamp; 2] { "-clamp on " } else { "" };
        self.text.extend(format!("{word} {clamp}{path}\n").into_bytes());
        path
    }
}

struct TexturePaths<'a, 'b, 'c> {
    name: &'b str,
    finder: &'b mut FileFinder<'c>,
    distinct: DistinctImages<'a>,
    // Paths of the distinct images.
    paths: Vec<String>,
}

impl<'a> TexturePaths<'a, '_, '_> {
    fn add(&mut self, texture: &'a BaseTexture, used: ImageUse) -> String {
        // Textures with one image share a file, whatever their wrap modes.
        let number = self.distinct.number(&texture.image);
        if number == self.paths.len() {
            let ending = match (extension(&texture.image), self.finder.converter) {
                // A converter turns KTX2 into another type, which decides the extension.
                ("ktx2", Some(converter)) => {
                    converter.convert(&texture.image, used).map_or("ktx2", |image| extension(&image))
                }
                (ending, _) => ending,
            };
            let path = PathBuf::from(format!("{}_{number}.{ending}", self.name));
            self.paths.push(to_reference(&self.finder.add_image(&path, &texture.image, used)));
        }
        self.paths[number].clone()
    }
}

pub(super) fn extension(image: &[u8]) -> &'static str {
    match image {
        [0x89, b'P', b'N', b'G', ..] => "png",
        [0xff, 0xd8, ..] => "jpg",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "webp",
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, ..] => "ktx2",
        _ => "bin",
    }
}
