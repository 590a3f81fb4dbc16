//! Materials of an asset.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::asset::Asset;
use super::references::{index, list};
use super::schema::Primitive;
use super::texture_transforms::material_transforms;
use crate::mesh::{BaseTexture, Finish, Look, Wrap};

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct MaterialData {
    pbr_metallic_roughness: MetallicRoughness,
    emissive_factor: Vec<f32>,
    emissive_texture: Option<TextureUse>,
    normal_texture: Option<TextureUse>,
    occlusion_texture: Option<TextureUse>,
    alpha_mode: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct MetallicRoughness {
    base_color_factor: Option<Vec<f32>>,
    base_color_texture: Option<TextureUse>,
    metallic_factor: Option<f32>,
    roughness_factor: Option<f32>,
    metallic_roughness_texture: Option<TextureUse>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureUse {
    index: usize,
    #[serde(default)]
    tex_coord: usize,
    scale: Option<f32>,
    strength: Option<f32>,
    #[serde(default)]
    extensions: TextureUseExtensions,
}

impl TextureUse {
    fn coordinates(&self) -> usize {
        self.extensions.transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord)
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct TextureUseExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TransformSet>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TransformSet {
    tex_coord: Option<usize>,
}

#[derive(Deserialize)]
struct TextureData {
    source: Option<usize>,
    sampler: Option<usize>,
    #[serde(default)]
    extensions: BTreeMap<String, Value>,
}

impl TextureData {
    fn image(&self) -> Option<usize> {
        let of_extension = |extension: &Value| extension.get("source").and_then(index);
        // Extensions such as `EXT_texture_webp` name an image of their own.
        self.source.or_else(|| self.extensions.values().find_map(of_extension))
    }
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct TextureSampler {
    wrap_s: u32,
    wrap_t: u32,
}

impl Asset {
    /// Reads the materials of each part's primitives, in the order of [`Asset::parts`], and one line per problem.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let (looks, notes) = asset.looks();
    /// assert_eq!((looks[0].len(), notes.len()), (1, 0));
    /// ```
    pub fn looks(&self) -> (Vec<Vec<Look>>, Vec<String>) {
        let mut reader = LookReader::new(self);
        let materials: Vec<MaterialData> = self.read_list("materials");
        // Transforms are checked on the raw document, where every use of a texture is found.
        let described = list(&self.document, "materials").iter();
        if described.map(material_transforms).any(|known| known.is_none()) {
            reader.note("texture transforms (KHR_texture_transform) that rotate, or differ within a material, are ignored when drawing");
        }
        let looks: Vec<Look> = materials.iter().map(|material| reader.look(material)).collect();
        let of_part = |&mesh: &usize| {
            let primitives = self.container.root.meshes.get(mesh).map_or(&[][..], |mesh| &mesh.primitives);
            let of_material = |material: Option<usize>| looks.get(material?).cloned();
            let look = |primitive: &Primitive| Look {
                // By the specification, only `COLOR_0` multiplies the material's colour.
                uses_corner_colours: primitive.attributes.contains_key("COLOR_0"),
                ..of_material(primitive.material).unwrap_or_default()
            };
            primitives.iter().map(look).collect()
        };
        (self.meshes.iter().map(of_part).collect(), reader.notes)
    }

    pub(super) fn read_list<T: DeserializeOwned + Default>(&self, name: &str) -> Vec<T> {
        let entries = list(&self.document, name).iter();
        entries.map(|entry| T::deserialize(entry).unwrap_or_default()).collect()
    }
}

struct LookReader<'a> {
    asset: &'a Asset,
    textures: Vec<Option<TextureData>>,
    samplers: Vec<TextureSampler>,
    bytes: Vec<Option<Option<Arc<[u8]>>>>,
    notes: Vec<String>,
}

impl<'a> LookReader<'a> {
    fn new(asset: &'a Asset) -> Self {
        let n_images = list(&asset.document, "images").len();
        let (textures, samplers) = (asset.read_list("textures"), asset.read_list("samplers"));
        Self { asset, textures, samplers, bytes: vec![None; n_images], notes: Vec::new() }
    }

    fn look(&mut self, material: &MaterialData) -> Look {
        let MetallicRoughness { base_color_factor, base_color_texture, .. } = &material.pbr_metallic_roughness;
        let factor = base_color_factor.as_deref().and_then(|factor| factor.first_chunk::<3>()).copied();
        let texture = base_color_texture.as_ref().and_then(|used| self.texture(used));
        let finish = self.finish(material);
        Look { colour: factor.unwrap_or([1.0; 3]), texture, finish, ..Look::default() }
    }

    fn finish(&mut self, material: &MaterialData) -> Finish {
        let MetallicRoughness { metallic_factor, roughness_factor, metallic_roughness_texture, .. } =
            &material.pbr_metallic_roughness;
        // Factors out of range are clamped, as renderers do.
        let share = |factor: Option<f32>| factor.filter(|x| x.is_finite()).map_or(1.0, |x| x.clamp(0.0, 1.0));
        let rough = metallic_roughness_texture.as_ref().and_then(|used| self.texture(used));
        let emission = material.emissive_factor.first_chunk::<3>().copied().unwrap_or_default();
        Finish {
            emission: emission.map(|x| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 }),
            emission_texture: material.emissive_texture.as_ref().and_then(|used| self.texture(used)),
            roughness: share(*roughness_factor),
            roughness_texture: rough.clone(),
            metal: share(*metallic_factor),
            metal_texture: rough,
            normal_texture: material.normal_texture.as_ref().and_then(|used| self.texture(used)),
            normal_scale: material.normal_texture.as_ref().and_then(|used| used.scale).unwrap_or(1.0),
            occlusion_texture: material.occlusion_texture.as_ref().and_then(|used| self.texture(used)),
            occlusion: share(material.occlusion_texture.as_ref().and_then(|used| used.strength)),
            is_opaque: material.alpha_mode.as_deref().is_none_or(|mode| mode == "OPAQUE"),
        }
    }

    fn texture(&mut self, used: &TextureUse) -> Option<BaseTexture> {
        let texture = self.textures.get(used.index)?.as_ref();
        let Some(source) = texture.and_then(TextureData::image) else {
            self.note("a texture names no image: it is not drawn");
            return None;
        };
        let sampler = texture.and_then(|texture| self.samplers.get(texture.sampler?));
        let wrap = sampler.map_or([Wrap::Repeat; 2], |sampler| [sampler.wrap_s, sampler.wrap_t].map(wrap));
        let image = self.image(source)?;
        Some(BaseTexture { image, channel: format!("TEXCOORD_{}", used.coordinates()), wrap })
    }

    fn image(&mut self, index: usize) -> Option<Arc<[u8]>> {
        // A missing image is remembered as well, so that it is noted once.
        if let Some(Some(known)) = self.bytes.get(index) {
            return known.clone();
        }
        let bytes = self.asset.bytes_of_image(index).map(Arc::from);
        if bytes.is_none() {
            self.note("the bytes of a texture are missing: it is not drawn");
        }
        if let Some(slot) = self.bytes.get_mut(index) {
            *slot = Some(bytes.clone());
        }
        bytes
    }

    fn note(&mut self, note: &str) {
        if self.notes.iter().all(|known| known != note) {
            self.notes.push(note.into());
        }
    }
}

fn wrap(number: u32) -> Wrap {
    match number {
        33_071 => Wrap::Clamp,
        33_648 => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::ReadError;

    fn asset(image: &str, use_of_texture: &str) -> Asset {
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}},
            "buffers": [{{"byteLength": 40, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAQIDBA=="}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 4}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
            "images": [{image}], "samplers": [{{"wrapS": 33071, "wrapT": 33648}}],
            "textures": [{{"source": 0, "sampler": 0}}, {{"source": 0}}],
            "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [0.5, 0.25, 1, 1], "baseColorTexture": {use_of_texture}}}}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}, {{"attributes": {{"POSITION": 0}}}}]}}]}}"#
        );
        Asset::from_bytes(text.as_bytes(), &|_| Err(ReadError::file("no file", ""))).unwrap()
    }

    #[test]
    fn textures_come_from_views_and_uris() {
        for image in [r#"{"bufferView": 1}"#, r#"{"uri": "data:image/png;base64,AQIDBA=="}"#] {
            let (looks, notes) = asset(image, r#"{"index": 0, "texCoord": 1}"#).looks();
            let texture = looks[0][0].texture.as_ref().unwrap();
            assert_eq!((&texture.image[..], texture.channel.as_str()), (&[1, 2, 3, 4][..], "TEXCOORD_1"));
            assert_eq!((texture.wrap, looks[0][0].colour), ([Wrap::Clamp, Wrap::Mirror], [0.5, 0.25, 1.0]));
            assert_eq!((&looks[0][1], notes.len()), (&Look { uses_corner_colours: false, ..Look::default() }, 0));
        }
    }

    #[test]
    fn what_materials_do_with_light_is_read() {
        let used = r#"{"index": 0}}, "emissiveFactor": [0, 0.5, 2], "emissiveTexture": {"index": 1}, "alphaMode": "MASK",
            "normalTexture": {"index": 0, "scale": 0.5}, "occlusionTexture": {"index": 1, "strength": 0.25}, "extras": {"nothing": {}"#;
        let (looks, notes) = asset(r#"{"bufferView": 1}"#, used).looks();
        let finish = &looks[0][0].finish;
        assert_eq!((finish.emission, finish.roughness, finish.metal), ([0.0, 0.5, 1.0], 1.0, 1.0));
        assert_eq!((finish.normal_scale, finish.is_opaque, notes.len()), (0.5, false, 0));
        assert!(finish.emission_texture.is_some() && finish.normal_texture.is_some());
        assert_eq!((finish.occlusion_texture.is_some(), finish.occlusion), (true, 0.25));
        assert_eq!(finish.metal_texture, None);
        assert_eq!(looks[0][1].finish, Finish::default());
    }

    #[test]
    fn what_cannot_be_had_is_said_and_left_out() {
        for (image, used) in [
            (r#"{"uri": "gone.png"}"#, r#"{"index": 0}"#),
            (r#"{"uri": "../secret.png"}"#, r#"{"index": 1}"#),
            (r#"{"bufferView": 7}"#, r#"{"index": 1}"#),
            (r#"{"bufferView": "x"}"#, r#"{"index": 0}"#),
        ] {
            let (looks, notes) = asset(image, used).looks();
            assert!(looks[0][0].texture.is_none() && notes.len() == 1, "{image}: {notes:?}");
        }
        let transformed = r#"{"index": 1, "extensions": {"KHR_texture_transform": {"rotation": 2}}}"#;
        let (looks, notes) = asset(r#"{"bufferView": 1}"#, transformed).looks();
        assert!(looks[0][0].texture.is_some() && notes[0].contains("KHR_texture_transform"));
        assert!(asset(r#"{"bufferView": 1}"#, r#"{"index": 9}"#).looks().0[0][0].texture.is_none());
    }
}
