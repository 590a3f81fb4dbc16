//! Description of a glTF scene for `info`.

use neural_mesh::io::{Asset, AssetContents, AssetPart, shorten_name};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::topology;
use neural_mesh::picture::{ImageFormat, image_size};
use serde::Serialize;

use crate::messages::group_digits;

const MAX_ENTRIES: usize = 8;

#[derive(Debug, Serialize)]
pub struct SceneInfo {
    #[serde(skip_serializing_if = "Option::is_none")]
    generator: Option<String>,
    scenes: usize,
    nodes: usize,
    meshes: Vec<MeshInfo>,
    materials: Vec<String>,
    images: Vec<ImageInfo>,
    skins: Vec<SkinInfo>,
    animations: Vec<AnimationInfo>,
    extensions_used: Vec<String>,
    extensions_required: Vec<String>,
}

/// Mesh in its own coordinates, listed once for all its nodes.
#[derive(Debug, Serialize)]
struct MeshInfo {
    name: String,
    vertices: usize,
    faces: usize,
    components: usize,
    materials: Vec<String>,
    nodes: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ImageInfo {
    name: String,
    /// Format of the image: `PNG`, `JPEG`, `WebP` or `KTX2`; `null` for others.
    format: Option<&'static str>,
    width: Option<usize>,
    height: Option<usize>,
    /// Bytes of the image file; `null` if it is missing.
    bytes: Option<usize>,
}

#[derive(Debug, Serialize)]
struct SkinInfo {
    name: String,
    joints: usize,
}

#[derive(Debug, Serialize)]
struct AnimationInfo {
    name: String,
    seconds: f64,
}

impl SceneInfo {
    /// Describes a scene; `weld` merges vertices at equal positions.
    pub fn new(asset: &Asset, weld: bool) -> Self {
        let contents = asset.contents();
        let parts = asset.parts().iter().zip(&contents.nodes_of_parts);
        let meshes = parts.map(|(part, nodes)| describe_mesh(part, nodes, weld)).collect();
        let AssetContents { generator, materials, extensions_used, extensions_required, .. } = contents;
        Self {
            generator,
            scenes: contents.n_scenes,
            nodes: contents.n_nodes,
            meshes,
            materials,
            images: contents.images.into_iter().enumerate().map(|(at, name)| describe_image(asset, at, name)).collect(),
            skins: contents.skins.into_iter().map(|(name, joints)| SkinInfo { name, joints }).collect(),
            animations: contents
                .animations
                .into_iter()
                .map(|(name, seconds)| AnimationInfo { name, seconds })
                .collect(),
            extensions_used,
            extensions_required,
        }
    }

    pub fn lines(&self) -> Vec<String> {
        let mut meshes: Vec<&MeshInfo> = self.meshes.iter().collect();
        meshes.sort_by_key(|mesh| std::cmp::Reverse(mesh.faces));
        let mut images: Vec<&ImageInfo> = self.images.iter().collect();
        images.sort_by_key(|image| std::cmp::Reverse(image.bytes));
        let skins = self.skins.iter().map(|skin| format!("{} ({} joints)", shorten_name(&skin.name), skin.joints));
        let animations = self.animations.iter().map(|it| format!("{} ({:.1} s)", shorten_name(&it.name), it.seconds));
        let extensions = self.extensions_used.iter().map(|name| match self.extensions_required.contains(name) {
            true => format!("{} (required)", shorten_name(name)),
            false => shorten_name(name).into_owned(),
        });
        let mut lines = vec![format!("scene       {}", self.counts())];
        lines.extend(self.describe_stored());
        lines.extend(entry_lines("mesh", meshes.into_iter().map(MeshInfo::to_words)));
        lines.extend(names_line("materials", self.materials.iter().map(|name| shorten_name(name).into_owned())));
        lines.extend(entry_lines("image", images.into_iter().map(ImageInfo::to_words)));
        lines.extend(names_line("skins", skins));
        lines.extend(names_line("animations", animations));
        lines.extend(names_line("extensions", extensions));
        lines
    }

    /// Describes what sizes count if some mesh is at several nodes: each mesh once.
    fn describe_stored(&self) -> Option<String> {
        let sum = |of: fn(&MeshInfo) -> usize| group_digits(self.meshes.iter().map(of).sum());
        let [vertices, faces] = [sum(|mesh| mesh.vertices), sum(|mesh| mesh.faces)];
        let is_repeated = self.meshes.iter().any(|mesh| mesh.nodes.len() > 1);
        is_repeated.then(|| format!("stored      {vertices} vertices, {faces} faces: sizes count each mesh once"))
    }

    /// Formats the counts that are not 0, such as `3 nodes, 2 meshes, 1 skin`.
    fn counts(&self) -> String {
        let named = [
            (self.nodes, "node"),
            (self.meshes.len(), "mesh"),
            (self.materials.len(), "material"),
            (self.images.len(), "image"),
            (self.skins.len(), "skin"),
            (self.animations.len(), "animation"),
        ];
        let words: Vec<String> =
            named.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| format_count(n, what)).collect();
        words.join(", ")
    }
}

fn format_count(n: usize, what: &str) -> String {
    let ending = match n {
        1 => "",
        _ if what.ends_with("sh") => "es",
        _ => "s",
    };
    format!("{} {what}{ending}", group_digits(n))
}

impl MeshInfo {
    fn to_words(&self) -> String {
        let [vertices, faces] = [self.vertices, self.faces].map(group_digits);
        let (components, nodes) = (format_count(self.components, "component"), format_count(self.nodes.len(), "node"));
        format!("{}: {vertices} vertices, {faces} faces, {components}, at {nodes}", shorten_name(&self.name))
    }
}

impl ImageInfo {
    fn to_words(&self) -> String {
        let Self { name, format, width, height, bytes } = self;
        let name = shorten_name(name);
        let Some(bytes) = bytes else { return format!("{name}: missing") };
        let size = width.zip(*height).map(|(width, height)| format!("{width} x {height}, ")).unwrap_or_default();
        format!("{name}: {size}{} bytes, {}", group_digits(*bytes), format.unwrap_or("unknown format"))
    }
}

fn describe_mesh(part: &AssetPart, nodes: &[String], weld: bool) -> MeshInfo {
    let mut options = CleanOptions::default();
    options.weld = weld;
    let figures = clean(part.mesh.clone(), &options).ok().map(|cleaned| topology(&cleaned.mesh));
    let [vertices, faces, components] =
        figures.map_or([0; 3], |figures| [figures.vertices, figures.faces, figures.components]);
    let (name, materials) = (part.name.clone(), part.materials.clone());
    MeshInfo { name, vertices, faces, components, materials, nodes: nodes.to_vec() }
}

fn describe_image(asset: &Asset, at: usize, name: String) -> ImageInfo {
    let bytes = asset.image(at);
    let size = bytes.as_deref().and_then(image_size);
    let format = bytes.as_deref().and_then(ImageFormat::from_signature).map(ImageFormat::name);
    let [width, height] = [0, 1].map(|side| size.map(|size| size[side]));
    ImageInfo { name, format, width, height, bytes: bytes.map(|bytes| bytes.len()) }
}

fn entry_lines(label: &str, words: impl ExactSizeIterator<Item = String>) -> Vec<String> {
    let more = words.len().saturating_sub(MAX_ENTRIES);
    let first = words.take(MAX_ENTRIES).map(|words| format!("{label:<12}{words}"));
    first.chain((more > 0).then(|| format!("{:12}and {} more: --json lists them", "", group_digits(more)))).collect()
}

fn names_line(label: &str, names: impl ExactSizeIterator<Item = String>) -> Option<String> {
    let more = names.len().saturating_sub(MAX_ENTRIES);
    let first: Vec<String> = names.take(MAX_ENTRIES).collect();
    let rest = if more > 0 { format!(" and {} more: --json lists them", group_digits(more)) } else { String::new() };
    (!first.is_empty()).then(|| format!("{label:<12}{}{rest}", first.join(", ")))
}
