//! Covers of compared meshes: their materials, or the original's texture if only a texture is missing.

use neural_mesh::mesh::{Attributes, BaseTexture, Look, Looks, Role};
use neural_mesh::picture::DecodedMaterials;

pub struct MeshCover {
    pub materials: DecodedMaterials,
    pub looks: Vec<Look>,
    /// Group of each face; empty if there is only one.
    pub groups: Vec<u32>,
    pub has_uvs: bool,
    /// True if the texture is borrowed from the original.
    pub borrowed: bool,
}

/// Returns the look with the colour texture if all textured groups share it.
pub fn only_texture(looks: &Looks) -> Option<Look> {
    let mut textured = looks.of_groups.iter().filter(|look| look.texture.is_some());
    let first = textured.next()?;
    let image = |look: &Look| look.texture.as_ref().map(|texture| texture.image.clone());
    let mut look = textured.all(|look| image(look) == image(first)).then(|| first.clone())?;
    let channel = look.texture.as_ref().map(|texture| texture.channel.clone());
    // An empty channel name means the mesh's first texture coordinates.
    let clear = |texture: &mut BaseTexture| texture.channel.clear();
    let finish = &mut look.finish;
    let normal_and_emission = [&mut finish.normal_texture, &mut finish.emission_texture];
    let rest = [&mut finish.roughness_texture, &mut finish.metal_texture, &mut finish.occlusion_texture];
    for map in normal_and_emission.into_iter().chain(rest) {
        *map = map.take().filter(|map| Some(&map.channel) == channel.as_ref());
        map.iter_mut().for_each(clear);
    }
    look.texture.iter_mut().for_each(clear);
    Some(look)
}

impl MeshCover {
    pub fn group(&self, face: u32) -> usize {
        self.groups.get(face as usize).map_or(0, |&group| group as usize)
    }
}

/// Returns the cover (colours and textures) of a mesh; `None` for a plain white one.
pub fn mesh_cover(mut attributes: Attributes, mut looks: Looks, original_look: Option<&Look>) -> Option<MeshCover> {
    let has_uvs = attributes.channels.iter().any(|channel| channel.role == Role::Uv && channel.width == 2);
    let has_texture = looks.of_groups.iter().any(|look| look.texture.is_some());
    let borrowed = original_look.filter(|_| has_uvs && !has_texture);
    if let Some(look) = borrowed {
        attributes.groups.clear();
        looks.of_groups = vec![look.clone()];
    }
    // The page tells of textures that cannot be decoded.
    let (materials, _) = DecodedMaterials::new(&attributes, &looks);
    let borrowed = borrowed.is_some();
    Some(MeshCover { materials: materials?, looks: looks.of_groups, groups: attributes.groups, has_uvs, borrowed })
}

#[cfg(test)]
pub mod tests {
    use std::sync::Arc;

    use super::*;
    use neural_mesh::mesh::{BaseTexture, Channel, Wrap};

    pub fn triangle() -> Attributes {
        let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values: vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0] };
        Attributes { wedges: vec![[0, 1, 2]], channels: vec![uv], groups: vec![0] }
    }

    pub fn textured_looks(image: &[u8]) -> Looks {
        let mut texture = BaseTexture::new(Arc::from(image));
        (texture.channel, texture.wrap) = ("uv".into(), [Wrap::Clamp, Wrap::Repeat]);
        Looks::new(vec![Look { texture: Some(texture), ..Look::default() }])
    }

    #[test]
    fn a_mesh_with_coordinates_and_no_texture_borrows_the_originals() {
        let look = only_texture(&textured_looks(b"image")).unwrap();
        let borrowed = mesh_cover(triangle(), Looks::default(), Some(&look)).unwrap();
        assert!(borrowed.borrowed && borrowed.materials.surface().texture(0).is_some());
        let own = mesh_cover(triangle(), textured_looks(b"other"), Some(&look)).unwrap();
        assert!(!own.borrowed && *own.materials.surface().images[0] == *b"other");
        assert!(mesh_cover(Attributes::default(), Looks::default(), Some(&look)).is_none());
        assert!(mesh_cover(triangle(), Looks::default(), None).is_none());
    }

    #[test]
    fn no_texture_is_borrowed_if_the_original_has_several() {
        let two = [textured_looks(b"one").of_groups, textured_looks(b"two").of_groups].concat();
        assert_eq!(only_texture(&Looks::new(two)), None);
        let same = [textured_looks(b"one").of_groups, textured_looks(b"one").of_groups].concat();
        assert!(only_texture(&Looks::new(same)).is_some());
    }
}
