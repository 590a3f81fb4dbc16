//! Colours of a surface.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use rustc_hash::FxHashMap;

use super::image_file::{decode_image, decode_numbers, image_problem};
use super::raster::weights_at;
use super::texture::Texture;
use crate::mesh::{Attributes, Channel, Look, Looks, Role, Wrap, linear_light};

/// Images and colours of a surface, corner by corner; images are not decoded.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceMaterials {
    /// Encoded images, each once.
    pub images: Vec<Arc<[u8]>>,
    // Paint of each group; the last one, white, is for all other groups.
    paints: Vec<GroupPaint>,
    // Group of each face; empty if there is only one.
    groups: Vec<u32>,
    // Texture coordinates, v downwards, n_faces x 3; empty without textures.
    uvs: Vec<[Vec2; 3]>,
    // Colours in linear light, n_faces x 3; empty if corners have none.
    colours: Vec<[Vec3; 3]>,
}

#[derive(Clone, Debug, PartialEq)]
struct GroupPaint {
    colour: Vec3,
    // Index of the image, and its wrap modes.
    texture: Option<(usize, [Wrap; 2])>,
    uses_corner_colours: bool,
}

/// Image coordinates and colour at a corner of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PaintedCorner {
    /// Image coordinates, v downwards; 0 without an image.
    pub uv: [f32; 2],
    /// Colour that multiplies the image, in linear light from 0 to 1.
    pub colour: [f32; 3],
}

impl SurfaceMaterials {
    /// Makes the materials of a mesh from its attributes and materials; `None` if the mesh is all white and has no map.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, Channel, Looks, Role};
    /// use neural_mesh::picture::SurfaceMaterials;
    /// let values = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    /// let colour = Channel { name: "colour".into(), role: Role::Colour, width: 3, values };
    /// let attributes = Attributes { wedges: vec![[0, 1, 2]], channels: vec![colour], groups: Vec::new() };
    /// let materials = SurfaceMaterials::new(&attributes, &Looks::default()).unwrap();
    /// assert_eq!((materials.corners(0)[1].colour, materials.texture(0)), ([0.0, 1.0, 0.0], None));
    /// ```
    pub fn new(attributes: &Attributes, looks: &Looks) -> Option<Self> {
        let (mut images, mut known) = (Vec::new(), FxHashMap::default());
        let mut number = |image: &Arc<[u8]>| {
            *known.entry(Arc::as_ptr(image)).or_insert_with(|| {
                images.push(image.clone());
                images.len() - 1
            })
        };
        let paint = |look: &Look| GroupPaint {
            colour: Vec3::from(look.colour),
            texture: look.texture.as_ref().map(|texture| (number(&texture.image), texture.wrap)),
            uses_corner_colours: look.uses_corner_colours,
        };
        let mut paints: Vec<GroupPaint> = looks.of_groups.iter().map(paint).collect();
        paints.push(GroupPaint { colour: Vec3::ONE, texture: None, uses_corner_colours: true });
        let uvs = uvs(attributes, looks);
        let colours = corner_colours(attributes, looks.linear_colours);
        // White materials would draw the same picture at more cost.
        let is_white = paints.iter().all(|paint| paint.colour == Vec3::ONE) && uvs.is_empty() && colours.is_empty();
        let materials = Self { images, paints, groups: attributes.groups.clone(), uvs, colours };
        (!is_white).then_some(materials)
    }

    /// Returns the index of a face's image, with its wrap modes along u and v.
    pub fn texture(&self, face: u32) -> Option<(usize, [Wrap; 2])> {
        self.paint(face).texture.filter(|_| !self.uvs.is_empty())
    }

    /// Returns the covers of a face's corners.
    pub fn corners(&self, face: u32) -> [PaintedCorner; 3] {
        let paint = self.paint(face);
        let colours = self.colours_of(face).unwrap_or([Vec3::ONE; 3]);
        let uvs = self.uvs.get(face as usize).copied().unwrap_or_default();
        std::array::from_fn(|i| PaintedCorner { uv: uvs[i].into(), colour: (paint.colour * colours[i]).into() })
    }

    fn colours_of(&self, face: u32) -> Option<[Vec3; 3]> {
        self.colours.get(face as usize).filter(|_| self.paint(face).uses_corner_colours).copied()
    }

    fn paint(&self, face: u32) -> &GroupPaint {
        let group = self.groups.get(face as usize).map_or(0, |&group| group as usize);
        &self.paints[group.min(self.paints.len() - 1)]
    }
}

/// Materials with decoded textures.
#[derive(Clone, Debug)]
pub struct DecodedMaterials {
    materials: SurfaceMaterials,
    // Shared by meshes with the same images.
    textures: Vec<Option<Arc<Texture>>>,
}

impl DecodedMaterials {
    /// Makes the materials of a mesh, `None` if the mesh is all white; also returns notes on undecodable textures.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, Channel, Looks, Role};
    /// use neural_mesh::picture::DecodedMaterials;
    /// let values = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    /// let colour = Channel { name: "colour".into(), role: Role::Colour, width: 3, values };
    /// let attributes = Attributes { wedges: vec![[0, 1, 2]], channels: vec![colour], groups: Vec::new() };
    /// assert!(DecodedMaterials::new(&attributes, &Looks::default()).0.is_some());
    /// assert!(DecodedMaterials::new(&Attributes::default(), &Looks::default()).0.is_none());
    /// ```
    pub fn new(attributes: &Attributes, looks: &Looks) -> (Option<Self>, Vec<String>) {
        Self::with_textures_of(None, attributes, looks)
    }

    /// Makes the materials of another mesh as [`new`](Self::new) does; images of `other` are not decoded again.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, Look, Looks};
    /// use neural_mesh::picture::DecodedMaterials;
    /// let mut grey = Look::default();
    /// grey.colour = [0.5; 3];
    /// let looks = Looks::new(vec![grey]);
    /// let (before, _) = DecodedMaterials::new(Attributes::NONE, &looks);
    /// let (after, _) = DecodedMaterials::with_textures_of(before.as_ref(), Attributes::NONE, &looks);
    /// assert_eq!(after.unwrap().surface(), before.unwrap().surface());
    /// ```
    pub fn with_textures_of(
        other: Option<&Self>,
        attributes: &Attributes,
        looks: &Looks,
    ) -> (Option<Self>, Vec<String>) {
        let known = other.into_iter().flat_map(|other| other.materials.images.iter().zip(&other.textures));
        let known: FxHashMap<*const [u8], _> = known.map(|(image, texture)| (Arc::as_ptr(image), texture)).collect();
        let decode = |image: &Arc<[u8]>| Some(Arc::new(Texture::new(decode_image(image)?)));
        Self::decode(attributes, looks, |image| match known.get(&Arc::as_ptr(image)) {
            Some(texture) => (*texture).clone(),
            None => decode(image),
        })
    }

    /// Makes materials whose textures are numbers from 0 to 1, such as directions or roughness.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, Look, Looks};
    /// use neural_mesh::picture::DecodedMaterials;
    /// let mut rough = Look::default();
    /// rough.colour = [0.5; 3];
    /// let decoded = DecodedMaterials::of_numbers(Attributes::NONE, &Looks::new(vec![rough])).0.unwrap();
    /// assert_eq!(decoded.value(0, [1.0, 0.0, 0.0], [[0.0; 3]; 2]), [0.5; 3]);
    /// ```
    pub fn of_numbers(attributes: &Attributes, looks: &Looks) -> (Option<Self>, Vec<String>) {
        Self::decode(attributes, looks, |image| Some(Arc::new(Texture::of_numbers(decode_numbers(image)?))))
    }

    fn decode(
        attributes: &Attributes,
        looks: &Looks,
        decode: impl Fn(&Arc<[u8]>) -> Option<Arc<Texture>>,
    ) -> (Option<Self>, Vec<String>) {
        let Some(materials) = SurfaceMaterials::new(attributes, looks) else { return (None, Vec::new()) };
        let textures: Vec<Option<Arc<Texture>>> = materials.images.iter().map(decode).collect();
        // One note is enough for any number of broken textures.
        let missing = materials.images.iter().zip(&textures).find(|(_, texture)| texture.is_none());
        let notes = missing.map(|(image, _)| format!("a texture is left out: it {}", image_problem(image)));
        let notes = notes.into_iter().collect();
        (Some(Self { materials, textures }), notes)
    }

    /// Returns colours, texture coordinates and images of the faces.
    pub fn surface(&self) -> &SurfaceMaterials {
        &self.materials
    }

    /// Returns the colour (linear light) or numbers of a face at barycentric weights.
    ///
    /// `steps` are the changes of the weights across the sampled area and down it, each of sum 0.
    pub fn value(&self, face: u32, weights: [f32; 3], steps: [[f32; 3]; 2]) -> [f32; 3] {
        self.colour_at(face, Vec3::from(weights), || steps.map(Vec3::from)).to_array()
    }

    /// Returns whether a face has a decoded texture.
    pub fn is_textured(&self, face: u32) -> bool {
        self.materials.texture(face).is_some_and(|(image, _)| self.textures[image].is_some())
    }

    fn colour_at(&self, face: u32, here: Vec3, steps: impl FnOnce() -> [Vec3; 2]) -> Vec3 {
        let DecodedMaterials { materials, textures } = self;
        let blend = |[a, b, c]: [Vec3; 3]| a * here.x + b * here.y + c * here.z;
        let colour = materials.paint(face).colour * materials.colours_of(face).map_or(Vec3::ONE, blend);
        let texture = materials.texture(face).and_then(|(image, wrap)| Some((textures[image].as_ref()?, wrap)));
        // Without a decoded texture, the factor alone is the colour.
        let Some(((texture, wrap), uvs)) = texture.zip(materials.uvs.get(face as usize)) else { return colour };
        let uv = |weights: Vec3| uvs[0] * weights.x + uvs[1] * weights.y + uvs[2] * weights.z;
        colour * texture.colour(uv(here), steps().map(uv), wrap)
    }

    /// Joins the materials with their mesh in the picture; `None` if the numbers of faces differ.
    pub(super) fn place_on<'a>(&'a self, points: &'a [Vec3], faces: &'a [[u32; 3]]) -> Option<PlacedMaterials<'a>> {
        let SurfaceMaterials { groups, uvs, colours, .. } = &self.materials;
        // Attributes of another mesh would index out of range.
        let fits = [groups.len(), uvs.len(), colours.len()].iter().all(|&n| n == 0 || n == faces.len());
        fits.then_some(PlacedMaterials { decoded: self, points, faces })
    }
}

fn uvs(attributes: &Attributes, looks: &Looks) -> Vec<[Vec2; 3]> {
    let channel = |name: &str| {
        let mut uvs = attributes.channels.iter().filter(|channel| channel.role == Role::Uv && channel.width == 2);
        if name.is_empty() { uvs.next() } else { uvs.find(|channel| channel.name == name) }
    };
    let of_look = |look: &Look| look.main_texture().and_then(|texture| channel(&texture.channel));
    let of_groups: Vec<Option<&Channel>> = looks.of_groups.iter().map(of_look).collect();
    if of_groups.iter().all(Option::is_none) {
        return Vec::new();
    }
    let place = |values: &[f32]| {
        let v = if looks.v_is_up { 1.0 - values[1] } else { values[1] };
        Vec2::new(values[0], v)
    };
    let face = |(f, wedges): (usize, &[u32; 3])| match of_groups.get(attributes.group(f as u32) as usize) {
        Some(Some(channel)) => wedges.map(|wedge| place(channel.value(wedge))),
        _ => [Vec2::ZERO; 3],
    };
    attributes.wedges.iter().enumerate().map(face).collect()
}

fn corner_colours(attributes: &Attributes, linear: bool) -> Vec<[Vec3; 3]> {
    let is_colour = |channel: &&Channel| channel.role == Role::Colour && channel.width >= 3;
    let Some(channel) = attributes.channels.iter().find(is_colour) else { return Vec::new() };
    let light = |x: f32| if linear { x.clamp(0.0, 1.0) } else { linear_light(x.clamp(0.0, 1.0)) };
    let colour = |wedge: u32| {
        let values = channel.value(wedge);
        Vec3::from([values[0], values[1], values[2]].map(light))
    };
    attributes.wedges.iter().map(|wedges| wedges.map(colour)).collect()
}

pub(super) struct PlacedMaterials<'a> {
    decoded: &'a DecodedMaterials,
    // Projected vertices in samples, with the inverse depth as z, n_vertices.
    points: &'a [Vec3],
    faces: &'a [[u32; 3]],
}

impl PlacedMaterials<'_> {
    /// Returns the colour of a face at a point in sample coordinates, in linear light.
    pub fn colour(&self, face: u32, at: Vec2) -> Vec3 {
        let here = self.weights(face, at);
        self.decoded.colour_at(face, here, || [Vec2::X, Vec2::Y].map(|along| self.weights(face, at + along) - here))
    }

    fn weights(&self, face: u32, at: Vec2) -> Vec3 {
        weights_at(self.points, self.faces[face as usize], at)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Image, encode_png};
    use super::*;
    use crate::mesh::BaseTexture;

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
        let (decoded, notes) = DecodedMaterials::new(&attributes, &looks);
        assert!(notes.is_empty());
        let points = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(9000.0, 0.0, 0.5), Vec3::new(0.0, 9000.0, 0.25)];
        let decoded = decoded.unwrap();
        let placed = decoded.place_on(&points, &[[0, 1, 2]; 2]).unwrap();
        placed.colour(face, points[corner].truncate()).to_array()
    }

    fn is_colour(colour: [f32; 3], wanted: [f32; 3]) -> bool {
        (0..3).all(|k| (colour[k] - wanted[k]).abs() < 1e-3)
    }

    #[test]
    fn v_runs_up_in_one_format_and_down_in_another() {
        let [red, green] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(is_colour(colour_at(false, 0, 0), red) && is_colour(colour_at(false, 0, 2), green));
        assert!(is_colour(colour_at(true, 0, 0), green) && is_colour(colour_at(true, 0, 2), red));
    }

    #[test]
    fn groups_have_their_own_paint() {
        assert!(is_colour(colour_at(true, 1, 0), [0.0, 0.0, 1.0]));
    }

    #[test]
    fn materials_of_another_mesh_are_refused() {
        let (attributes, looks) = looks(true);
        let decoded = DecodedMaterials::new(&attributes, &looks).0.unwrap();
        assert!(decoded.place_on(&[], &[[0, 1, 2]; 3]).is_none());
    }

    #[test]
    fn textures_that_are_no_images_are_noted_once() {
        let (attributes, mut looks) = looks(true);
        let image: Arc<[u8]> = Arc::from(&b"no image"[..]);
        looks.of_groups[0].texture.iter_mut().for_each(|texture| texture.image = image.clone());
        looks.of_groups.push(looks.of_groups[0].clone());
        let (decoded, notes) = DecodedMaterials::new(&attributes, &looks);
        assert_eq!((decoded.is_some(), notes.len()), (true, 1));
    }
}
