//! Materials of a new asset: colours and what they do with light, and textures within the file.

use serde_json::{Value, json};

use super::draft::Draft;
use super::extensions::name_extension;
use super::images::used_as;
use crate::io::{ImageMaker, ImageUse};
use crate::mesh::{BaseTexture, Finish, Look, Wrap};

/// The materials that were written, and their textures.
#[derive(Default)]
pub(super) struct Materials<'a> {
    /// Who makes other images of these, where someone does.
    maker: Option<&'a dyn ImageMaker>,
    /// Textures and what they have become.
    textures: Vec<(&'a BaseTexture, Value)>,
    /// Images and what they have become.
    images: Vec<(&'a [u8], Value)>,
    /// What could not be held, in one line each.
    pub notes: Vec<String>,
}

impl<'a> Materials<'a> {
    /// None yet, with images as this maker makes them.
    pub fn of(maker: Option<&'a dyn ImageMaker>) -> Self {
        Self { maker, ..Self::default() }
    }

    /// Appends a material with this look and gives its index; what is white and without a texture has a name alone.
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

    /// Takes what a material does with light into it and into the part of it that has the base colour.
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
        if rough == metal {
            self.put(draft, base, "metallicRoughnessTexture", rough.as_ref(), name);
        } else {
            self.notes.push(format!("gltf holds roughness and metal in one texture: those of {name} are left out"));
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

    /// Names a texture within a part of a material, where there is one.
    fn put(&mut self, draft: &mut Draft, part: &mut Value, key: &str, texture: Option<&'a BaseTexture>, name: &str) {
        if let Some(texture) = texture.and_then(|texture| self.texture(draft, texture, used_as(key), name)) {
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
        if let Some((_, index)) = self.textures.iter().find(|(known, _)| *known == texture) {
            return Some(index.clone());
        }
        let Some(kind) = mime_type(&texture.image) else {
            self.notes.push(format!("gltf holds textures as PNG, JPEG or WebP: that of {material} is left out"));
            return None;
        };
        let known = self.images.iter().find(|(image, _)| *image == &*texture.image).map(|(_, index)| index.clone());
        let image = known.unwrap_or_else(|| {
            let made = self.maker.and_then(|maker| maker.made(&texture.image, used));
            let bytes = made.unwrap_or_else(|| texture.image.to_vec());
            let view = draft.push_view(json!({"buffer": 0, "byteLength": bytes.len()}), bytes);
            let index = draft.push("images", json!({"bufferView": view, "mimeType": kind}));
            self.images.push((&texture.image, index.clone()));
            index
        });
        let [s, t] = texture.wrap.map(number);
        let sampler = json!({"magFilter": LINEAR, "minFilter": MIPMAPPED, "wrapS": s, "wrapT": t});
        let sampler = draft.push("samplers", sampler);
        let held = json!({"source": image});
        let index = if kind == WEBP {
            name_extension(&mut draft.document, WEBP_TEXTURE);
            draft.push("textures", json!({"sampler": sampler, "extensions": {WEBP_TEXTURE: held}}))
        } else {
            draft.push("textures", json!({"source": image, "sampler": sampler}))
        };
        self.textures.push((texture, index.clone()));
        Some(index)
    }
}

const WEBP: &str = "image/webp";
/// The extension by which a texture is a WebP.
const WEBP_TEXTURE: &str = "EXT_texture_webp";

const LINEAR: u32 = 9729;
const MIPMAPPED: u32 = 9987;

/// How a sampler says what a texture does beyond its edges.
fn number(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10_497,
        Wrap::Clamp => 33_071,
        Wrap::Mirror => 33_648,
    }
}

/// The kind of a picture that glTF holds, by how it begins.
fn mime_type(image: &[u8]) -> Option<&'static str> {
    match image {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(WEBP),
        _ => None,
    }
}
