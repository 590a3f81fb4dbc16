//! Base colours and textures of a mesh's materials, as the page's `clusters/paints.js` reads them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use neural_mesh::job::Document;
use neural_mesh::mesh::{Attributes, BaseTexture, Look, Role, Wrap};
use serde_json::{Value, json};

use crate::compare::images::Gallery;
use crate::page::data_script;

/// Paints of a hierarchy: their description in the page's JSON, and scripts with their images.
#[derive(Default)]
pub struct ClusterPaints {
    pub facts: Value,
    pub scripts: String,
    /// One line per texture left out or scaled down.
    pub notes: Vec<String>,
}

/// Packs the base colours of all materials; nothing if all are plain.
pub fn pack_paints(document: &Document, allow_outside: bool) -> ClusterPaints {
    let (looks, _) = document.looks(allow_outside);
    if looks.is_plain() {
        return ClusterPaints::default();
    }
    let mut gallery = Gallery::default();
    let first_uv = first_uv_channel(document.attributes());
    let all: Vec<Value> = looks.of_groups.iter().map(|look| describe_paint(look, first_uv, &mut gallery)).collect();
    let mut paints: Vec<Value> = Vec::new();
    let mut number = |paint: Value| {
        paints.iter().position(|known| *known == paint).unwrap_or_else(|| {
            paints.push(paint);
            paints.len() - 1
        })
    };
    let groups: Vec<usize> = all.into_iter().map(&mut number).collect();
    let (images, notes) = gallery.fit_images();
    let types: Vec<Option<&str>> = images.iter().map(|image| Some(image.as_ref()?.kind)).collect();
    let fitted = images.iter().enumerate().filter_map(|(i, image)| Some((i, image.as_ref()?)));
    let scripts = fitted.map(|(i, image)| data_script(&format!("image-{i}"), &STANDARD.encode(&image.bytes))).collect();
    ClusterPaints {
        facts: json!({ "paints": paints, "groups": groups, "images": types, "isVUp": looks.v_is_up }),
        scripts,
        notes,
    }
}

fn first_uv_channel(attributes: &Attributes) -> Option<&str> {
    let found = attributes.channels.iter().find(|channel| channel.role == Role::Uv && channel.width == 2);
    found.map(|channel| channel.name.as_str())
}

/// Describes a paint; the page has the first texture coordinates alone.
fn describe_paint(look: &Look, first_uv: Option<&str>, gallery: &mut Gallery) -> Value {
    let is_on_first = |texture: &&BaseTexture| texture.channel.is_empty() || Some(texture.channel.as_str()) == first_uv;
    let texture = look.texture.as_ref().filter(|_| first_uv.is_some()).filter(is_on_first);
    let image = texture.map(|texture| gallery.index_of(&texture.image));
    json!({ "image": image, "isCut": !look.finish.is_opaque, "wrap": texture.map(|texture| texture.wrap).unwrap_or_default().map(Wrap::name), "colour": look.colour })
}
