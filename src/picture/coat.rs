//! The colours of a surface: base colours of its materials, their textures, and colours at its corners.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::texture::{Texture, decode_image};
use crate::mesh::{Attributes, BaseTexture, Channel, Look, Looks, Role, Wrap, linear_light};

/// What covers a surface, ready to be drawn.
#[derive(Clone, Debug)]
pub struct Coat {
    /// The paint of each group; the last one, white, is that of all others.
    paints: Vec<Paint>,
    textures: Vec<Texture>,
    /// The group of each face; empty where all faces are of one.
    groups: Vec<u32>,
    /// Coordinates on the texture of the group, v downwards, n_faces x 3; empty where no group has a texture.
    uvs: Vec<[Vec2; 3]>,
    /// Colours in linear light, n_faces x 3; empty where the corners carry none.
    colours: Vec<[Vec3; 3]>,
}

/// What a group is painted with.
#[derive(Clone, Debug)]
struct Paint {
    colour: Vec3,
    /// The number of the texture and what it does beyond its edges.
    texture: Option<(usize, [Wrap; 2])>,
    with_corners: bool,
}

impl Coat {
    /// The coat of a mesh whose faces carry `attributes` and whose groups look like `looks`; `None` where all of it is white.
    /// Beside it what could not be drawn, in one line each.
    ///
    /// ```
    /// use neural_mesh::mesh::{Attributes, Channel, Looks, Role};
    /// use neural_mesh::picture::Coat;
    /// let values = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    /// let colour = Channel { name: "colour".into(), role: Role::Colour, width: 3, values };
    /// let attributes = Attributes { wedges: vec![[0, 1, 2]], channels: vec![colour], groups: Vec::new() };
    /// assert!(Coat::new(&attributes, &Looks::default()).0.is_some());
    /// assert!(Coat::new(&Attributes::default(), &Looks::default()).0.is_none());
    /// ```
    pub fn new(attributes: &Attributes, looks: &Looks) -> (Option<Self>, Vec<String>) {
        let mut shelf = Shelf::default();
        let paint = |look: &Look| Paint {
            colour: Vec3::from(look.colour),
            texture: look.texture.as_ref().and_then(|texture| Some((shelf.find(texture)?, texture.wrap))),
            with_corners: look.with_corners,
        };
        let mut paints: Vec<Paint> = looks.of_groups.iter().map(paint).collect();
        paints.push(Paint { colour: Vec3::ONE, texture: None, with_corners: true });
        let is_textured = paints.iter().any(|paint| paint.texture.is_some());
        let uvs = if is_textured { uvs(attributes, looks) } else { Vec::new() };
        let colours = corner_colours(attributes, looks.linear_colours);
        let is_white = paints.iter().all(|paint| paint.colour == Vec3::ONE) && uvs.is_empty() && colours.is_empty();
        let groups = attributes.groups.clone();
        let coat = Self { paints, textures: shelf.textures, groups, uvs, colours };
        ((!is_white).then_some(coat), shelf.notes)
    }

    /// The coat on a mesh of the picture; `None` where it is not that mesh's own.
    pub(super) fn on<'a>(&'a self, points: &'a [Vec3], faces: &'a [[u32; 3]]) -> Option<Worn<'a>> {
        let fits = [self.groups.len(), self.uvs.len(), self.colours.len()].iter().all(|&n| n == 0 || n == faces.len());
        fits.then_some(Worn { coat: self, points, faces })
    }

    fn paint(&self, face: u32) -> &Paint {
        let group = self.groups.get(face as usize).map_or(0, |&group| group as usize);
        &self.paints[group.min(self.paints.len() - 1)]
    }
}

/// The textures that were decoded, each once.
#[derive(Default)]
struct Shelf {
    known: Vec<(Arc<[u8]>, Option<usize>)>,
    textures: Vec<Texture>,
    notes: Vec<String>,
}

impl Shelf {
    /// The number of a texture; `None` where its bytes are no image that is read.
    fn find(&mut self, texture: &BaseTexture) -> Option<usize> {
        let is_same = |(image, _): &&(Arc<[u8]>, _)| Arc::ptr_eq(image, &texture.image);
        if let Some((_, number)) = self.known.iter().find(is_same) {
            return *number;
        }
        let number = decode_image(&texture.image).map(|image| {
            self.textures.push(Texture::new(&image));
            self.textures.len() - 1
        });
        if number.is_none() {
            self.notes.push("a texture is no PNG or JPEG that can be read: drawn without it".into());
        }
        self.known.push((texture.image.clone(), number));
        number
    }
}

/// The texture coordinates of the corners, v downwards, n_faces x 3; zeros where a group's texture has none, nothing where
/// no group's has.
fn uvs(attributes: &Attributes, looks: &Looks) -> Vec<[Vec2; 3]> {
    let channel = |name: &str| {
        let mut uvs = attributes.channels.iter().filter(|channel| channel.role == Role::Uv && channel.width == 2);
        if name.is_empty() { uvs.next() } else { uvs.find(|channel| channel.name == name) }
    };
    let of_look = |look: &Look| look.texture.as_ref().and_then(|texture| channel(&texture.channel));
    let of_groups: Vec<Option<&Channel>> = looks.of_groups.iter().map(of_look).collect();
    if of_groups.iter().all(Option::is_none) {
        return Vec::new();
    }
    let place = |values: &[f32]| {
        let v = if looks.v_is_up { 1.0 - values[1] } else { values[1] };
        Vec2::new(values[0], v)
    };
    let face = |(f, wedges): (usize, &[u32; 3])| match of_groups.get(attributes.group(f as u32) as usize) {
        Some(Some(channel)) => wedges.map(|wedge| place(channel.of(wedge))),
        _ => [Vec2::ZERO; 3],
    };
    attributes.wedges.iter().enumerate().map(face).collect()
}

/// The colours of the corners in linear light, n_faces x 3; nothing where they carry none.
fn corner_colours(attributes: &Attributes, linear: bool) -> Vec<[Vec3; 3]> {
    let is_colour = |channel: &&Channel| channel.role == Role::Colour && channel.width >= 3;
    let Some(channel) = attributes.channels.iter().find(is_colour) else { return Vec::new() };
    let light = |x: f32| if linear { x.clamp(0.0, 1.0) } else { linear_light(x.clamp(0.0, 1.0)) };
    let colour = |wedge: u32| {
        let values = channel.of(wedge);
        Vec3::from([values[0], values[1], values[2]].map(light))
    };
    attributes.wedges.iter().map(|wedges| wedges.map(colour)).collect()
}

/// A coat on a mesh of the picture.
pub(super) struct Worn<'a> {
    coat: &'a Coat,
    /// Where the vertices lie on the picture, in samples, with the inverse of the depth as z: n_vertices.
    points: &'a [Vec3],
    faces: &'a [[u32; 3]],
}

impl Worn<'_> {
    /// The colour, in linear light, of a face at a place in samples.
    pub fn colour(&self, face: u32, at: Vec2) -> Vec3 {
        let (coat, paint) = (self.coat, self.coat.paint(face));
        let here = self.weights(face, at);
        let mut colour = paint.colour;
        if let Some(colours) = coat.colours.get(face as usize).filter(|_| paint.with_corners) {
            colour *= colours[0] * here.x + colours[1] * here.y + colours[2] * here.z;
        }
        let Some(((texture, wrap), uvs)) = paint.texture.zip(coat.uvs.get(face as usize)) else { return colour };
        let uv = |weights: Vec3| uvs[0] * weights.x + uvs[1] * weights.y + uvs[2] * weights.z;
        let uv_here = uv(here);
        let step = |along: Vec2| uv(self.weights(face, at + along)) - uv_here;
        colour * coat.textures[texture].colour(uv_here, [step(Vec2::X), step(Vec2::Y)], wrap)
    }

    /// The weights of a face's corners at a place: linear on the face in space, so weights on the picture count by the inverse
    /// depth of their corner.
    fn weights(&self, face: u32, at: Vec2) -> Vec3 {
        let [a, b, c] = self.faces[face as usize].map(|v| self.points[v as usize]);
        let [pa, pb, pc] = [a, b, c].map(|corner| corner.truncate() - at);
        let weights = Vec3::new(pb.perp_dot(pc) * a.z, pc.perp_dot(pa) * b.z, pa.perp_dot(pb) * c.z);
        weights / weights.element_sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Image, encode_png};
    use super::*;

    /// Two faces of two groups over a texture whose upper half is red and whose lower half is green.
    fn looks(v_is_up: bool) -> (Attributes, Looks) {
        let rgba = [[255, 0, 0, 255], [255, 0, 0, 255], [0, 255, 0, 255], [0, 255, 0, 255]].concat();
        let image = Arc::from(encode_png(&Image { width: 1, height: 4, rgba }));
        let texture = BaseTexture { image, channel: "uv".into(), wrap: [Wrap::Clamp; 2] };
        let textured = Look { texture: Some(texture), ..Look::default() };
        let blue = Look { colour: [0.0, 0.0, 1.0], ..Look::default() };
        let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values: vec![0.5, 0.1, 0.5, 0.1, 0.5, 0.9] };
        let attributes = Attributes { wedges: vec![[0, 1, 2]; 2], channels: vec![uv], groups: vec![0, 1] };
        (attributes, Looks { of_groups: vec![textured, blue], v_is_up, linear_colours: false })
    }

    fn colour_at(v_is_up: bool, face: u32, corner: usize) -> [f32; 3] {
        let (attributes, looks) = looks(v_is_up);
        let (coat, notes) = Coat::new(&attributes, &looks);
        assert!(notes.is_empty());
        let points = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(9000.0, 0.0, 0.5), Vec3::new(0.0, 9000.0, 0.25)];
        let coat = coat.unwrap();
        let worn = coat.on(&points, &[[0, 1, 2]; 2]).unwrap();
        worn.colour(face, points[corner].truncate()).to_array()
    }

    fn is(colour: [f32; 3], wanted: [f32; 3]) -> bool {
        (0..3).all(|k| (colour[k] - wanted[k]).abs() < 1e-3)
    }

    #[test]
    fn v_runs_up_in_one_format_and_down_in_another() {
        let [red, green] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(is(colour_at(false, 0, 0), red) && is(colour_at(false, 0, 2), green));
        assert!(is(colour_at(true, 0, 0), green) && is(colour_at(true, 0, 2), red));
    }

    #[test]
    fn groups_have_their_own_paint() {
        assert!(is(colour_at(true, 1, 0), [0.0, 0.0, 1.0]));
    }

    #[test]
    fn what_does_not_belong_to_the_mesh_is_not_worn() {
        let (attributes, looks) = looks(true);
        let coat = Coat::new(&attributes, &looks).0.unwrap();
        assert!(coat.on(&[], &[[0, 1, 2]; 3]).is_none());
    }

    #[test]
    fn textures_that_are_no_images_are_noted_once() {
        let (attributes, mut looks) = looks(true);
        let image: Arc<[u8]> = Arc::from(&b"no image"[..]);
        looks.of_groups[0].texture.iter_mut().for_each(|texture| texture.image = image.clone());
        looks.of_groups.push(looks.of_groups[0].clone());
        let (coat, notes) = Coat::new(&attributes, &looks);
        assert_eq!((coat.is_some(), notes.len()), (true, 1));
    }
}
