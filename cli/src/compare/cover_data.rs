//! Texture coordinates, colours and stored normals of a mesh as small integers for the page's `cover.js`.
//!
//! Corners of a vertex with equal values form a wedge.

use std::collections::HashMap;

use neural_mesh::mesh::{Finish, Look, Wrap};
use neural_mesh::picture::PaintedCorner;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::images::Gallery;
use super::mesh_cover::MeshCover;
use super::meshes::NamedMesh;
use crate::page::packed::Packed;
use crate::page::surface_data::SurfaceData;

const COLOUR_STEPS: f32 = 4095.0;
/// Largest number of steps of texture coordinates across an image.
const UV_STEPS: f64 = 32_768.0;
/// Largest number of steps over the mesh's whole range of texture coordinates.
const MOST_UV_STEPS: f64 = (1 << 30) as f64;
/// Steps of a normal along each side of the square onto which the octahedron unfolds: a fifteenth of a degree.
const NORMAL_STEPS: f32 = 2047.0;

#[derive(Debug, Serialize)]
pub struct CoverLayout {
    wedges: usize,
    /// Lowest texture coordinates and step length, along u and v.
    low: [f64; 2],
    step: [f64; 2],
    coloured: bool,
    /// True if the file has normals.
    shaded: bool,
    /// Empty if the file has only normals.
    paints: Vec<Paint>,
    borrowed: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Paint {
    image: Option<usize>,
    wrap: [&'static str; 2],
    /// Factors and maps of a material that is more than a colour.
    #[serde(skip_serializing_if = "Option::is_none")]
    finish: Option<Value>,
}

pub struct CoverData {
    pub layout: CoverLayout,
    /// Packed numbers: vertex, u, v, normal and colour of each wedge, the paint of each face, the wedge of each corner.
    pub text: String,
}

/// Wedge as integers: vertex, u, v, two of the normal, red, green, blue.
type Wedge = [u32; 8];

impl CoverData {
    /// Packs what covers a mesh; `None` if its file has neither materials nor normals.
    pub fn new(named: &NamedMesh, surface: &SurfaceData, gallery: &mut Gallery) -> Option<Self> {
        let NamedMesh { mesh, cover, normals, .. } = named;
        if cover.is_none() && normals.is_none() {
            return None;
        }
        let painted = cover.as_ref().map(|cover| cover.materials.surface());
        let n_faces = mesh.faces().len() as u32;
        let bare = PaintedCorner { uv: [0.0; 2], colour: [1.0; 3] };
        let face_corners = |face| painted.map_or([bare; 3], |painted| painted.corners(face));
        let corners: Vec<[PaintedCorner; 3]> = (0..n_faces).map(face_corners).collect();
        let ([low_u, step_u], [low_v, step_v]) = (uv_steps(&corners, 0), uv_steps(&corners, 1));
        let (low, step) = ([low_u, low_v], [step_u, step_v]);
        let coloured = corners.iter().flatten().any(|corner| corner.colour != [1.0; 3]);
        let (paints, face_paints) = cover
            .as_ref()
            .map_or_else(|| (Vec::new(), vec![0; n_faces as usize]), |cover| number_paints(cover, n_faces, gallery));
        let numbers = surface.numbers(mesh.positions().len());
        let wedge = |vertex: u32, corner: &PaintedCorner, normal: [f32; 3]| {
            let [u, v] = [0, 1].map(|axis| quantise(corner.uv[axis], low[axis], step[axis]));
            let [a, b] = unfold(normal);
            let [red, green, blue] = corner.colour.map(|x| (x.clamp(0.0, 1.0) * COLOUR_STEPS).round() as u32);
            [numbers[vertex as usize], u, v, a, b, red, green, blue]
        };
        let stored = |face| normals.as_ref().map_or([[0.0; 3]; 3], |normals| normals.corners(face));
        let all = mesh.faces().iter().zip(&corners).zip(0..).flat_map(|((vertices, corners), face)| {
            let normals = stored(face);
            [0, 1, 2].map(|k| wedge(vertices[k], &corners[k], normals[k]))
        });
        let (wedges, corner_wedges) = number_wedges(all);
        let shaded = normals.is_some();
        let text = pack(&wedges, [shaded, coloured], &face_paints, &corner_wedges);
        let borrowed = cover.as_ref().is_some_and(|cover| cover.borrowed);
        Some(Self { layout: CoverLayout { wedges: wedges.len(), low, step, coloured, shaded, paints, borrowed }, text })
    }
}

/// Returns a unit normal as steps on the square onto which the octahedron unfolds; zero is outside of it.
fn unfold([x, y, z]: [f32; 3]) -> [u32; 2] {
    let length = x.abs() + y.abs() + z.abs();
    if length == 0.0 {
        return [NORMAL_STEPS as u32 + 1; 2];
    }
    let (x, y) = (x / length, y / length);
    // The lower half folds outwards over the corners.
    let (a, b) = if z >= 0.0 { (x, y) } else { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) };
    [a, b].map(|at| ((0.5 * at + 0.5) * NORMAL_STEPS).round() as u32)
}

/// Returns the lowest texture coordinate along an axis, and the length of a step.
fn uv_steps(corners: &[[PaintedCorner; 3]], axis: usize) -> [f64; 2] {
    let all = || corners.iter().flatten().map(|corner| f64::from(corner.uv[axis])).filter(|x| x.is_finite());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    if low > high { [0.0, 1.0] } else { [low, ((high - low) / MOST_UV_STEPS).max(1.0 / UV_STEPS)] }
}

/// Quantises a coordinate; NaN becomes the lowest.
fn quantise(x: f32, low: f64, step: f64) -> u32 {
    ((f64::from(x) - low) / step).round() as u32
}

fn number_paints(cover: &MeshCover, n_faces: u32, gallery: &mut Gallery) -> (Vec<Paint>, Vec<u32>) {
    let of_looks: Vec<Paint> = cover.looks.iter().map(|look| look_paint(look, cover.has_uvs, gallery)).collect();
    let white = Paint { image: None, wrap: [Wrap::default().name(); 2], finish: None };
    let mut paints: Vec<Paint> = Vec::new();
    let mut number = |face| {
        let paint = of_looks.get(cover.group(face)).unwrap_or(&white);
        paints.iter().position(|known| known == paint).unwrap_or_else(|| {
            paints.push(paint.clone());
            paints.len() - 1
        }) as u32
    };
    let face_paints = (0..n_faces).map(&mut number).collect();
    (paints, face_paints)
}

fn look_paint(look: &Look, has_uvs: bool, gallery: &mut Gallery) -> Paint {
    let image = look.texture.as_ref().filter(|_| has_uvs).map(|texture| gallery.index_of(&texture.image));
    let wrap = look.main_texture().map(|texture| texture.wrap).unwrap_or_default().map(Wrap::name);
    let maps = look.drawn_maps().filter(|_| has_uvs);
    let maps: Map<String, Value> = maps.map(|(name, map)| (name.into(), gallery.index_of(&map.image).into())).collect();
    let Finish { emission, roughness, metal, normal_scale, occlusion, .. } = &look.finish;
    let finish = json!({ "emission": emission, "roughness": roughness, "metal": metal, "normalScale": normal_scale,
        "occlusion": occlusion, "maps": maps });
    Paint { image, wrap, finish: (!look.finish.is_matte()).then_some(finish) }
}

/// Returns the distinct wedges in order of first use, and the wedge of each corner.
fn number_wedges(corner_wedges: impl Iterator<Item = Wedge>) -> (Vec<Wedge>, Vec<u32>) {
    let (mut known, mut wedges) = (HashMap::new(), Vec::new());
    let mut number = |wedge: Wedge| {
        *known.entry(wedge).or_insert_with(|| {
            wedges.push(wedge);
            wedges.len() as u32 - 1
        })
    };
    let corner_wedges = corner_wedges.map(&mut number).collect();
    (wedges, corner_wedges)
}

/// Packs wedges column by column, and corners as the distance of their wedge below the next unused one.
fn pack(wedges: &[Wedge], [shaded, coloured]: [bool; 2], face_paints: &[u32], corner_wedges: &[u32]) -> String {
    let mut packed = Packed::default();
    let columns = (0..3).chain((3..5).filter(|_| shaded)).chain((5..8).filter(|_| coloured));
    // Numbers of one kind in a row compress better.
    for column in columns {
        push_differences(&mut packed, wedges.iter().map(|wedge| wedge[column]));
    }
    push_differences(&mut packed, face_paints.iter().copied());
    let mut next = 0;
    for &wedge in corner_wedges {
        packed.push(next - wedge);
        next = next.max(wedge + 1);
    }
    packed.text()
}

fn push_differences(packed: &mut Packed, numbers: impl Iterator<Item = u32>) {
    let mut before = 0;
    for number in numbers {
        packed.push_difference(number, before);
        before = number;
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh_cover::{mesh_cover, tests};
    use super::*;
    use crate::page::check::unpack_numbers;
    use neural_mesh::mesh::{Attributes, BaseTexture, Channel, Looks, Role, TriMesh, irregular_edges, shapes};
    use neural_mesh::picture::CornerNormals;

    fn data(mesh: &TriMesh, attributes: Attributes, looks: Looks) -> CoverData {
        let surface = SurfaceData::new(mesh, &irregular_edges(mesh), 1);
        let normals = CornerNormals::new(&attributes);
        let (name, mesh, cover) = (String::new(), mesh.clone(), mesh_cover(attributes, looks, None));
        let named = NamedMesh { name, bytes: None, mesh, cover, normals, notes: Vec::new() };
        CoverData::new(&named, &surface, &mut Gallery::default()).unwrap()
    }

    #[test]
    fn a_textured_face_survives_packing() {
        let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let found = data(&mesh, tests::triangle(), tests::textured_looks(b"image"));
        let CoverLayout { wedges, low, step, coloured, shaded, paints, borrowed } = &found.layout;
        assert_eq!((*wedges, *low, *step), (3, [0.0; 2], [1.0 / UV_STEPS; 2]));
        assert_eq!([*coloured, *shaded, *borrowed], [false; 3]);
        assert_eq!(paints[..], [Paint { image: Some(0), wrap: ["clamp", "repeat"], finish: None }]);
        let one = UV_STEPS as u32;
        // The numbers are: vertices 0 1 2; u 0 1 0; v 0 0 1; paint 0; three corners with new wedges. Differences are
        // doubled, and odd if negative.
        assert_eq!(unpack_numbers(&found.text), [0, 2, 2, 0, 2 * one, 2 * one - 1, 0, 0, 2 * one, 0, 0, 0, 0]);
    }

    #[test]
    fn maps_and_factors_of_a_material_are_packed_and_need_texture_coordinates() {
        let mut looks = tests::textured_looks(b"image");
        let finish = &mut looks.of_groups[0].finish;
        finish.metal = 0.5;
        finish.normal_texture = Some(BaseTexture { channel: "uv".into(), ..BaseTexture::new(b"bumps"[..].into()) });
        finish.emission_texture = Some(BaseTexture { channel: "other".into(), ..BaseTexture::new(b"glow"[..].into()) });
        let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let paint = |attributes| data(&mesh, attributes, looks.clone()).layout.paints[0].clone();
        let found = paint(tests::triangle());
        let finish = found.finish.unwrap();
        assert_eq!((found.image, &finish["metal"], &finish["maps"]), (Some(0), &json!(0.5), &json!({ "normal": 1 })));
        let mut bare = tests::triangle();
        bare.channels.clear();
        looks.of_groups[0].colour = [0.5; 3];
        let found = data(&mesh, bare, looks.clone()).layout.paints[0].clone();
        assert_eq!((found.image, &found.finish.unwrap()["maps"]), (None, &json!({})));
    }

    #[test]
    fn stored_normals_survive_packing_and_missing_ones_lie_outside() {
        let step = 1.0 / NORMAL_STEPS;
        for normal in [[0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [-0.48, 0.64, 0.6], [0.0, -0.6, -0.8]] {
            let [a, b] = unfold(normal).map(|at| 2.0 * at as f32 * step - 1.0);
            let z = 1.0 - a.abs() - b.abs();
            let fold = (-z).max(0.0);
            let back = [a - fold.copysign(a), b - fold.copysign(b), z];
            let length = back.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((0..3).all(|k| (back[k] / length - normal[k]).abs() < 3.0 * step), "{normal:?} {back:?}");
        }
        assert_eq!(unfold([0.0; 3]), [NORMAL_STEPS as u32 + 1; 2]);
        let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let values = [[0.0, 0.0, 1.0]; 3].concat();
        let normal = Channel { name: "NORMAL".into(), role: Role::Normal, width: 3, values };
        let attributes = Attributes { wedges: vec![[0, 1, 2]], channels: vec![normal], groups: Vec::new() };
        let found = data(&mesh, attributes, Looks::default());
        assert!(found.layout.shaded && found.layout.paints.is_empty());
        assert_eq!(unpack_numbers(&found.text)[9..15], [2 * 1024, 0, 0, 2 * 1024, 0, 0]);
    }

    #[test]
    fn equal_corners_share_a_wedge_and_non_finite_coordinates_are_packed() {
        let mesh = shapes::icosphere(1);
        let n = mesh.positions().len();
        let values = (0..n).flat_map(|v| [0.25 * (v % 5) as f32, 0.5, 1.0]).collect();
        let colour = Channel { name: "colour".into(), role: Role::Colour, width: 3, values };
        let attributes = Attributes { wedges: mesh.faces().to_vec(), channels: vec![colour], groups: Vec::new() };
        let found = data(&mesh, attributes, Looks::default());
        assert_eq!((found.layout.wedges, found.layout.coloured), (n, true));
        assert_eq!(unpack_numbers(&found.text).len(), 6 * n + 4 * mesh.faces().len());
        let mut strange = tests::triangle();
        strange.channels[0].values = vec![f32::NAN, 1e30, -1e30, f32::INFINITY, 0.0, 7.0];
        let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        assert_eq!(data(&mesh, strange, tests::textured_looks(b"image")).layout.wedges, 3);
    }
}
