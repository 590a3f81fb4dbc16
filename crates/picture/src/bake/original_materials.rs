//! Materials of an original.

use glam::{Vec2, Vec3, Vec4};

use super::BakeSource;
use super::frames::tangents;
use crate::mesh::{Finish, Look, Looks};
use crate::picture::{DecodedMaterials, SurfaceMaterials};

// Materials, each `None` if 1 everywhere.
pub(super) struct OriginalMaterials {
    colour: Option<DecodedMaterials>,
    emission: Option<DecodedMaterials>,
    roughness: Option<DecodedMaterials>,
    metal: Option<DecodedMaterials>,
    directions: Option<NormalMap>,
}

struct NormalMap {
    materials: DecodedMaterials,
    // Tangents that the map refers to, n_faces x 3.
    tangents: Vec<[Vec4; 3]>,
    // Scale of the map's first two components, per group.
    scales: Vec<f32>,
    groups: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SamplePlace {
    pub face: u32,
    // Barycentric weights of the point.
    pub weights: [f32; 3],
    // Changes of the weights from one texel to the next, across and down.
    pub steps: [[f32; 3]; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MaterialSample {
    // Base colour in linear light.
    pub colour: Vec3,
    // Emitted light, linear.
    pub emission: Vec3,
    pub roughness: f32,
    pub metal: f32,
}

impl OriginalMaterials {
    pub fn new(original: &BakeSource, normals: &[[Vec3; 3]]) -> (Self, Vec<String>) {
        let BakeSource { attributes, looks, .. } = original;
        let n_groups = attributes.groups.iter().max().map_or(1, |&group| group as usize + 1);
        let each = |of: &dyn Fn(&Look) -> Look| {
            let plain = Look::default();
            let look = |group: usize| of(looks.of_groups.get(group).unwrap_or(&plain));
            Looks { of_groups: (0..n_groups).map(look).collect(), ..Looks::clone(looks) }
        };
        let bare = |colour: [f32; 3], texture: &Option<_>| {
            // A texture with factor zero need not be decoded.
            let texture = texture.clone().filter(|_| colour != [0.0; 3]);
            Look { colour, texture, uses_corner_colours: false, finish: Finish::default() }
        };
        let emission = each(&|look| bare(look.finish.emission, &look.finish.emission_texture));
        let roughness = each(&|look| bare([look.finish.roughness; 3], &look.finish.roughness_texture));
        let metal = each(&|look| bare([look.finish.metal; 3], &look.finish.metal_texture));
        let directions = each(&|look| bare([1.0; 3], &look.finish.normal_texture));
        let mut notes = Vec::new();
        let mut noted = |(materials, more): (Option<DecodedMaterials>, Vec<String>)| {
            notes.extend(more.into_iter().map(|note| note.replace("drawn", "baked")));
            materials
        };
        let materials = Self {
            colour: noted(DecodedMaterials::new(attributes, &each(&Look::clone))),
            emission: noted(DecodedMaterials::new(attributes, &emission)),
            roughness: noted(DecodedMaterials::of_numbers(attributes, &roughness)),
            metal: noted(DecodedMaterials::of_numbers(attributes, &metal)),
            directions: NormalMap::new(original, &directions, normals, &mut noted),
        };
        // The result would look solid where the original does not.
        if looks.of_groups.iter().any(|look| !look.finish.is_opaque) {
            notes.push("opacity is not baked: the result is opaque".into());
        }
        notes.dedup();
        (materials, notes)
    }

    pub fn sample(&self, spot: &SamplePlace) -> MaterialSample {
        let value = |materials: &Option<DecodedMaterials>| {
            Vec3::from(
                materials.as_ref().map_or([1.0; 3], |materials| materials.value(spot.face, spot.weights, spot.steps)),
            )
        };
        // Roughness is in green, metal in blue.
        let (roughness, metal) = (value(&self.roughness).y, value(&self.metal).z);
        MaterialSample { colour: value(&self.colour), emission: value(&self.emission), roughness, metal }
    }

    pub fn apply_normal_map(&self, spot: &SamplePlace, normal: Vec3) -> Vec3 {
        self.directions.as_ref().and_then(|directions| directions.apply(spot, normal)).unwrap_or(normal)
    }
}

impl NormalMap {
    fn new(
        original: &BakeSource,
        looks: &Looks,
        normals: &[[Vec3; 3]],
        noted: &mut impl FnMut((Option<DecodedMaterials>, Vec<String>)) -> Option<DecodedMaterials>,
    ) -> Option<Self> {
        looks.of_groups.iter().find(|look| look.texture.is_some())?;
        let materials = noted(DecodedMaterials::of_numbers(original.attributes, looks))?;
        let cover = SurfaceMaterials::new(original.attributes, looks)?;
        let uv = |face: u32| cover.corners(face).map(|corner| Vec2::new(corner.uv[0], 1.0 - corner.uv[1]));
        let uvs: Vec<[Vec2; 3]> = (0..original.mesh.faces().len() as u32).map(uv).collect();
        let scales = original.looks.of_groups.iter().map(|look| look.finish.normal_scale).collect();
        let groups = original.attributes.groups.clone();
        Some(Self { materials, tangents: tangents(original.mesh, normals, &uvs), scales, groups })
    }

    fn apply(&self, spot: &SamplePlace, normal: Vec3) -> Option<Vec3> {
        if !self.materials.is_textured(spot.face) {
            return None;
        }
        let group = self.groups.get(spot.face as usize).map_or(0, |&group| group as usize);
        let scale = self.scales.get(group).copied().unwrap_or(1.0);
        let direction = Vec3::from(self.materials.value(spot.face, spot.weights, spot.steps)) * 2.0 - Vec3::ONE;
        let [a, b, c] = self.tangents.get(spot.face as usize)?;
        let tangent = *a * spot.weights[0] + *b * spot.weights[1] + *c * spot.weights[2];
        let across = a.w.signum() * normal.cross(tangent.truncate());
        let turned = tangent.truncate() * direction.x * scale + across * direction.y * scale + normal * direction.z;
        turned.try_normalize()
    }
}
