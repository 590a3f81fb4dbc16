//! Materials written to a new asset.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde_json::{Value, json};

use super::draft::Draft;
use super::extensions::name_extension;
use super::image_kinds::{media_type, texture_extension};
use super::images::texture_use;
use crate::io::distinct_images::DistinctImages;
use crate::io::material_writer::extension;
use crate::io::{ImageConverter, ImageUse, shorten_name};
use crate::mesh::{BaseTexture, Finish, Look, Wrap};

#[derive(Default)]
pub(super) struct MaterialWriter<'a> {
    converter: Option<&'a dyn ImageConverter>,
    // Textures by their image in `images` and by how they wrap, which a texture's sampler stores.
    textures: BTreeMap<(usize, [u32; 2]), Value>,
    // Index and media type of each image; none for formats that glTF does not store.
    images: Vec<Option<(Value, &'static str)>>,
    distinct: DistinctImages<'a>,
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
        let place = self.place_image(draft, &texture.image, used);
        let Some((image, kind)) = &self.images[place] else {
            self.notes.push(format!(
                "gltf stores textures as PNG, JPEG, WebP or KTX2: a texture of {material} in another format is left out"
            ));
            return None;
        };
        let wrap = texture.wrap.map(wrap_number);
        let push = || {
            let sampler = json!({"magFilter": LINEAR, "minFilter": MIPMAPPED, "wrapS": wrap[0], "wrapT": wrap[1]});
            let sampler = draft.push("samplers", sampler);
            if let Some(extension) = texture_extension(kind) {
                name_extension(&mut draft.document, extension);
                return draft
                    .push("textures", json!({"sampler": sampler, "extensions": {extension: {"source": image}}}));
            }
            draft.push("textures", json!({"source": image, "sampler": sampler}))
        };
        Some(self.textures.entry((place, wrap)).or_insert_with(push).clone())
    }

    fn place_image(&mut self, draft: &mut Draft, image: &'a Arc<[u8]>, used: ImageUse) -> usize {
        let place = self.distinct.number(image);
        if place == self.images.len() {
            let stored = self.store_image(draft, image, used);
            self.images.push(stored);
        }
        place
    }

    fn store_image(&self, draft: &mut Draft, image: &[u8], used: ImageUse) -> Option<(Value, &'static str)> {
        // Conversion precedes the determination of the type, as it may change the type.
        let made = self.converter.and_then(|converter| converter.convert(image, used));
        let bytes = made.unwrap_or_else(|| image.to_vec());
        let kind = media_type(extension(&bytes))?;
        let view = draft.push_view(json!({"buffer": 0, "byteLength": bytes.len()}), bytes);
        Some((draft.push("images", json!({"bufferView": view, "mimeType": kind})), kind))
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
