//! What covers the meshes of a comparison: their own materials, or the texture of the original where only that is missing.

use neural_mesh::mesh::{Attributes, Look, Looks, Role};
use neural_mesh::picture::Cover;

/// The cover of a mesh.
pub struct Worn {
    /// What each corner is covered with.
    pub cover: Cover,
    /// Whether the texture is the original's: the mesh has coordinates on one, its file names none.
    pub borrowed: bool,
}

/// The look with the texture that gives all textured groups their colours, where there is just one such.
pub fn only_texture(looks: &Looks) -> Option<Look> {
    let mut textured = looks.of_groups.iter().filter(|look| look.texture.is_some());
    let first = textured.next()?;
    let image = |look: &Look| look.texture.as_ref().map(|texture| texture.image.clone());
    let mut look = textured.all(|look| image(look) == image(first)).then(|| first.clone())?;
    // The first coordinates that there are.
    look.texture.iter_mut().for_each(|texture| texture.channel.clear());
    Some(look)
}

/// What a mesh wears; nothing where all of it is white.
pub fn worn(mut attributes: Attributes, mut looks: Looks, of_original: Option<&Look>) -> Option<Worn> {
    let has_uvs = attributes.channels.iter().any(|channel| channel.role == Role::Uv && channel.width == 2);
    let has_texture = looks.of_groups.iter().any(|look| look.texture.is_some());
    let borrowed = of_original.filter(|_| has_uvs && !has_texture);
    if let Some(look) = borrowed {
        attributes.groups.clear();
        looks.of_groups = vec![look.clone()];
    }
    Some(Worn { cover: Cover::new(&attributes, &looks)?, borrowed: borrowed.is_some() })
}

#[cfg(test)]
pub mod tests {
    use std::sync::Arc;

    use super::*;
    use neural_mesh::mesh::{BaseTexture, Channel, Wrap};

    /// A triangle with coordinates on a texture.
    pub fn triangle() -> Attributes {
        let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values: vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0] };
        Attributes { wedges: vec![[0, 1, 2]], channels: vec![uv], groups: vec![0] }
    }

    /// The looks of a group with a texture of these bytes.
    pub fn textured(image: &[u8]) -> Looks {
        let mut texture = BaseTexture::new(Arc::from(image));
        (texture.channel, texture.wrap) = ("uv".into(), [Wrap::Clamp, Wrap::Repeat]);
        let mut look = Look::default();
        look.texture = Some(texture);
        Looks::new(vec![look])
    }

    #[test]
    fn a_mesh_with_coordinates_and_no_texture_wears_the_originals() {
        let look = only_texture(&textured(b"image")).unwrap();
        let borrowed = worn(triangle(), Looks::default(), Some(&look)).unwrap();
        assert!(borrowed.borrowed && borrowed.cover.texture(0).is_some());
        let own = worn(triangle(), textured(b"other"), Some(&look)).unwrap();
        assert!(!own.borrowed && *own.cover.images[0] == *b"other");
        assert!(worn(Attributes::default(), Looks::default(), Some(&look)).is_none());
        assert!(worn(triangle(), Looks::default(), None).is_none());
    }

    #[test]
    fn of_several_textures_none_is_borrowed() {
        let two = [textured(b"one").of_groups, textured(b"two").of_groups].concat();
        assert_eq!(only_texture(&Looks::new(two)), None);
        let same = [textured(b"one").of_groups, textured(b"one").of_groups].concat();
        assert!(only_texture(&Looks::new(same)).is_some());
    }
}
