//! Materials of a new asset: base colours, and textures within the file.

use serde_json::{Value, json};

use super::draft::Draft;
use crate::mesh::{BaseTexture, Look, Wrap};

/// The materials that were written, and their textures.
#[derive(Default)]
pub(super) struct Materials<'a> {
    /// Textures and what they have become.
    textures: Vec<(&'a BaseTexture, Value)>,
    /// Images and what they have become.
    images: Vec<(&'a [u8], Value)>,
    /// What could not be held, in one line each.
    pub notes: Vec<String>,
}

impl<'a> Materials<'a> {
    /// Appends a material with this look and gives its index; what is white and without a texture has a name alone.
    pub fn push(&mut self, draft: &mut Draft, name: &str, look: Option<&'a Look>) -> Value {
        let mut material = json!({"name": name});
        if let Some(look) = look.filter(|look| look.texture.is_some() || look.colour != [1.0; 3]) {
            let [r, g, b] = look.colour;
            let mut base = json!({"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0});
            if let Some(texture) = look.texture.as_ref().and_then(|texture| self.texture(draft, texture, name)) {
                base["baseColorTexture"] = json!({"index": texture});
            }
            material["pbrMetallicRoughness"] = base;
        }
        draft.push("materials", material)
    }

    fn texture(&mut self, draft: &mut Draft, texture: &'a BaseTexture, material: &str) -> Option<Value> {
        if let Some((_, index)) = self.textures.iter().find(|(known, _)| *known == texture) {
            return Some(index.clone());
        }
        let Some(kind) = mime_type(&texture.image) else {
            self.notes.push(format!("gltf holds textures as PNG or JPEG: that of {material} is left out"));
            return None;
        };
        let known = self.images.iter().find(|(image, _)| *image == &*texture.image).map(|(_, index)| index.clone());
        let image = known.unwrap_or_else(|| {
            let view = json!({"buffer": 0, "byteLength": texture.image.len()});
            let view = draft.push_view(view, texture.image.to_vec());
            let index = draft.push("images", json!({"bufferView": view, "mimeType": kind}));
            self.images.push((&texture.image, index.clone()));
            index
        });
        let [s, t] = texture.wrap.map(number);
        let sampler = json!({"magFilter": LINEAR, "minFilter": MIPMAPPED, "wrapS": s, "wrapT": t});
        let sampler = draft.push("samplers", sampler);
        let index = draft.push("textures", json!({"source": image, "sampler": sampler}));
        self.textures.push((texture, index.clone()));
        Some(index)
    }
}

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
        _ => None,
    }
}
