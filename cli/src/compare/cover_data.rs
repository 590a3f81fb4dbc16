//! Colours and texture coordinates of a mesh as small integers for the page's `cover.js`.
//!
//! Corners of a vertex with equal coordinates and colour form a wedge.

use std::collections::HashMap;

use neural_mesh::mesh::{TriMesh, Wrap};
use neural_mesh::picture::PaintedCorner;
use serde::Serialize;

use super::images::Gallery;
use super::mesh_cover::MeshCover;
use crate::page::packed::Packed;
use crate::page::surface_data::SurfaceData;

const COLOUR_STEPS: f32 = 4095.0;
/// Largest number of steps of texture coordinates across an image.
const UV_STEPS: f64 = 32_768.0;
/// Largest number of steps over the mesh's whole range of texture coordinates.
const MOST_UV_STEPS: f64 = (1 << 30) as f64;

#[derive(Debug, Serialize)]
pub struct CoverLayout {
    wedges: usize,
    /// Lowest texture coordinates and step length, along u and v.
    low: [f64; 2],
    step: [f64; 2],
    coloured: bool,
    paints: Vec<Paint>,
    borrowed: bool,
}

#[derive(Debug, PartialEq, Serialize)]
struct Paint {
    image: Option<usize>,
    wrap: [&'static str; 2],
}

pub struct CoverData {
    pub layout: CoverLayout,
    /// Packed numbers: vertex, u, v and colour of each wedge, the paint of each face, the wedge of each corner.
    pub text: String,
}

/// Wedge as integers: vertex, u, v, red, green, blue.
type Wedge = [u32; 6];

impl CoverData {
    pub fn new(mesh: &TriMesh, mesh_cover_data: &MeshCover, surface: &SurfaceData, gallery: &mut Gallery) -> Self {
        let cover = mesh_cover_data.materials.surface();
        let n_faces = mesh.faces().len() as u32;
        let corners: Vec<[PaintedCorner; 3]> = (0..n_faces).map(|face| cover.corners(face)).collect();
        let ([low_u, step_u], [low_v, step_v]) = (uv_steps(&corners, 0), uv_steps(&corners, 1));
        let (low, step) = ([low_u, low_v], [step_u, step_v]);
        let coloured = corners.iter().flatten().any(|corner| corner.colour != [1.0; 3]);
        let images: Vec<usize> = cover.images.iter().map(|image| gallery.index_of(image)).collect();
        let (paints, face_paints) = number_paints((0..n_faces).map(|face| face_paint(cover.texture(face), &images)));
        let numbers = surface.numbers(mesh.positions().len());
        let wedge = |vertex: u32, corner: &PaintedCorner| {
            let uv = [0, 1].map(|axis| quantise(corner.uv[axis], low[axis], step[axis]));
            let colour = corner.colour.map(|x| (x.clamp(0.0, 1.0) * COLOUR_STEPS).round() as u32);
            [numbers[vertex as usize], uv[0], uv[1], colour[0], colour[1], colour[2]]
        };
        let all = mesh.faces().iter().flatten().zip(corners.as_flattened());
        let (wedges, corner_wedges) = number_wedges(all.map(|(&vertex, corner)| wedge(vertex, corner)));
        let text = pack(&wedges, coloured, &face_paints, &corner_wedges);
        let layout =
            CoverLayout { wedges: wedges.len(), low, step, coloured, paints, borrowed: mesh_cover_data.borrowed };
        Self { layout, text }
    }
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

fn face_paint(texture: Option<(usize, [Wrap; 2])>, images: &[usize]) -> Paint {
    let name = |wrap: Wrap| match wrap {
        Wrap::Repeat => "repeat",
        Wrap::Clamp => "clamp",
        Wrap::Mirror => "mirror",
    };
    let (image, wrap) = texture.unzip();
    Paint { image: image.map(|image| images[image]), wrap: wrap.unwrap_or_default().map(name) }
}

fn number_paints(face_paints: impl Iterator<Item = Paint>) -> (Vec<Paint>, Vec<u32>) {
    let mut paints = Vec::new();
    let mut number = |paint: Paint| {
        paints.iter().position(|known| *known == paint).unwrap_or_else(|| {
            paints.push(paint);
            paints.len() - 1
        }) as u32
    };
    let face_paints = face_paints.map(&mut number).collect();
    (paints, face_paints)
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
fn pack(wedges: &[Wedge], coloured: bool, face_paints: &[u32], corner_wedges: &[u32]) -> String {
    let mut packed = Packed::default();
    // Numbers of one kind in a row compress better.
    for column in 0..if coloured { 6 } else { 3 } {
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
    use neural_mesh::mesh::{Attributes, Channel, Looks, Role, irregular_edges, shapes};

    fn data(mesh: &TriMesh, attributes: Attributes, looks: Looks) -> CoverData {
        let surface = SurfaceData::new(mesh, &irregular_edges(mesh), 1);
        CoverData::new(mesh, &mesh_cover(attributes, looks, None).unwrap(), &surface, &mut Gallery::default())
    }

    #[test]
    fn a_textured_face_survives_packing() {
        let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let found = data(&mesh, tests::triangle(), tests::textured_looks(b"image"));
        let CoverLayout { wedges, low, step, coloured, paints, borrowed } = &found.layout;
        assert_eq!((*wedges, *coloured, *borrowed, *low, *step), (3, false, false, [0.0; 2], [1.0 / UV_STEPS; 2]));
        assert_eq!(paints[..], [Paint { image: Some(0), wrap: ["clamp", "repeat"] }]);
        let one = UV_STEPS as u32;
        // The numbers are: vertices 0 1 2; u 0 1 0; v 0 0 1; paint 0; three corners with new wedges. Differences are
        // doubled, and odd if negative.
        assert_eq!(unpack_numbers(&found.text), [0, 2, 2, 0, 2 * one, 2 * one - 1, 0, 0, 2 * one, 0, 0, 0, 0]);
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
