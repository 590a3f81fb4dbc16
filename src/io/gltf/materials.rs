//! Materials written to a new asset.

use serde_json::{Value, json};

use super::draft::Draft;
use super::extensions::name_extension;
use super::image_kinds::{media_type, texture_extension};
use super::images::texture_use;
use crate::io::material_writer::extension;
use crate::io::{ImageConverter, ImageUse, shorten_name};
use crate::mesh::{BaseTexture, Finish, Look, Wrap};

#[derive(Default)]
pub(super) struct MaterialWriter<'a> {
    converter: Option<&'a dyn ImageConverter>,
    textures: Vec<(&'a BaseTexture, Value)>,
    images: Vec<(&'a [u8], Value, &'static str)>,
    pub notes: Vec<String>,
}

impl<'a> MaterialWriter<'a> {
    pub fn new(converter: Option<&'a dyn ImageConverter>) -> Self {
        Self { converter, ..Self::default() }
    }

    /// Appends a material and returns its index.
    pub fn push(&mut self, draft: &mut Draft, name: &str, look: Option<&'a Look>) -> Value {
        let mut material = json!({"name": name});
        let is_plain =
            |look: &&Look| look.texture.is_none() && look.colour == [1.0; 3] && look.finish == Finish::default();
        if let Some(look) = look.filter(|look| !is_plain(look)) {
            let [r, g, b] = look.colour;
            let mut base = json!({"baseColorFactor": [r, g, b, 1.0], "metallicFactor": look.finish.metal});
            self.put(draft, &mut base, "baseColorTexture", look.texture.as_ref(), name);
            self.put_finish(draft, &mut material, &mut base, &look.finish, name);
            material["pbrMetallicRoughness"] = base;
        }
        draft.push("materials", material)
    }

    fn put_finish(
        &mut self,
        draft: &mut Draft,
        material: &mut Value,
        base: &mut Value,
        finish: &'a Finish,
        name: &str,
    ) {
        let Finish { emission, roughness, roughness_texture: rough, metal_texture: metal, .. } = finish;
        if *roughness != 1.0 {
            base["roughnessFactor"] = (*roughness).into();
        }
        // glTF has one texture for roughness and metal together.
        if rough == metal {
            self.put(draft, base, "metallicRoughnessTexture", rough.as_ref(), name);
        } else {
            self.notes.push(format!(
                "gltf stores roughness and metal in one texture: the two textures of {} are left out",
                shorten_name(name)
            ));
        }
        if *emission != [0.0; 3] {
            material["emissiveFactor"] = emission.to_vec().into();
            self.put(draft, material, "emissiveTexture", finish.emission_texture.as_ref(), name);
        }
        self.put(draft, material, "normalTexture", finish.normal_texture.as_ref(), name);
        if finish.normal_scale != 1.0 && material.get("normalTexture").is_some() {
            material["normalTexture"]["scale"] = finish.normal_scale.into();
        }
    }

    fn put(&mut self, draft: &mut Draft, part: &mut Value, key: &str, texture: Option<&'a BaseTexture>, name: &str) {
        if let Some(texture) = texture.and_then(|texture| self.texture(draft, texture, texture_use(key), name)) {
            part[key] = json!({"index": texture});
        }
    }

    fn texture(
        &mut self,
        draft: &mut Draft,
        texture: &'a BaseTexture,
        used: ImageUse,
        material: &str,
    ) -> Option<Value> {
        // Textures are equal only if their wrap modes are, since these are stored in the texture's sampler.
        if let Some((_, index)) = self.textures.iter().find(|(known, _)| *known == texture) {
            return Some(index.clone());
        }
        let Some((image, kind)) = self.image(draft, &texture.image, used) else {
            self.notes.push(format!(
                "gltf stores textures as PNG, JPEG, WebP or KTX2: a texture of {material} in another format is left out"
            ));
            return None;
        };
        let [s, t] = texture.wrap.map(wrap_number);
        let sampler = json!({"magFilter": LINEAR, "minFilter": MIPMAPPED, "wrapS": s, "wrapT": t});
        let sampler = draft.push("samplers", sampler);
        let index = if let Some(extension) = texture_extension(kind) {
            name_extension(&mut draft.document, extension);
            draft.push("textures", json!({"sampler": sampler, "extensions": {extension: {"source": image}}}))
        } else {
            draft.push("textures", json!({"source": image, "sampler": sampler}))
        };
        self.textures.push((texture, index.clone()));
        Some(index)
    }

    fn image(&mut self, draft: &mut Draft, image: &'a [u8], used: ImageUse) -> Option<(Value, &'static str)> {
        if let Some((_, index, kind)) = self.images.iter().find(|(known, ..)| *known == image) {
            return Some((index.clone(), kind));
        }
        // Conversion precedes the determination of the type, as it may change the type.
        let made = self.converter.and_then(|converter| converter.convert(image, used));
        let bytes = made.unwrap_or_else(|| image.to_vec());
        let kind = media_type(extension(&bytes))?;
        let view = draft.push_view(json!({"buffer": 0, "byteLength": bytes.len()}), bytes);
        let index = draft.push("images", json!({"bufferView": view, "mimeType": kind}));
        self.images.push((image, index.clone(), kind));
        Some((index, kind))
    }
}

const LINEAR: u32 = 9729;
const MIPMAPPED: u32 = 9987;

fn wrap_number(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10_497,
        Wrap::Clamp => 33_071,
        Wrap::Mirror => 33_648,
    }
}
