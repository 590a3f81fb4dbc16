//! Views of several meshes from one fixed camera, for comparison pixel by pixel.

use glam::Vec3;

use super::camera::Camera;
use super::raster::{self, Buffer, NOTHING};
use super::shade::{self, Face, Shading};
use super::shaded_mesh::ShadedMesh;
use super::{Image, SAMPLES, occlusion, scaled_mesh};
use crate::mesh::TriMesh;

/// View of one mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshView {
    /// Shaded mesh, without edges.
    pub shaded: Image,
    /// Normals turned to the eye, as colours: x right, y up, z toward the eye, -1..1 as 0..=255.
    pub normals: Image,
    /// Face in the middle of each pixel, height x width.
    pub faces: Vec<Option<u32>>,
    /// Number of the pixel's 9 samples that show the mesh, height x width.
    pub covered: Vec<u8>,
}

/// Draws each mesh from an azimuth and elevation in degrees; the first mesh fits the panel.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::{mesh::shapes, picture::view};
/// let views = view(&[&shapes::icosphere(3), &shapes::icosphere(1)], [30.0, 15.0], 64);
/// assert_eq!((views.len(), views[0].shaded.height, views[1].shaded.width), (2, 64, views[0].shaded.width));
/// ```
pub fn view(meshes: &[&TriMesh], direction: [f32; 2], height: usize) -> Vec<MeshView> {
    view_shaded(&meshes.iter().map(|mesh| ShadedMesh::bare(mesh)).collect::<Vec<_>>(), direction, height)
}

/// Draws each mesh as [`view`] does, with its colours, textures and stored normals.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::mesh::{Attributes, Look, Looks, shapes};
/// use neural_mesh::picture::{DecodedMaterials, ShadedMesh, view, view_shaded};
/// let ball = shapes::icosphere(2);
/// let mut red = Look::default();
/// red.colour = [0.8, 0.1, 0.1];
/// let materials = DecodedMaterials::new(Attributes::NONE, &Looks::new(vec![red])).0;
/// let plain = ShadedMesh::bare(&ball);
/// let views = view_shaded(&[ShadedMesh { materials: materials.as_ref(), ..plain }, plain], [30.0, 15.0], 64);
/// assert_eq!(views[1], view(&[&ball], [30.0, 15.0], 64)[0]);
/// assert_ne!(views[0].shaded, views[1].shaded);
/// ```
pub fn view_shaded(meshes: &[ShadedMesh], direction: [f32; 2], height: usize) -> Vec<MeshView> {
    let surfaces: Vec<&TriMesh> = meshes.iter().map(|shaded| shaded.mesh).collect();
    let shapes = scaled_mesh::scale_meshes(&surfaces);
    let camera = Camera::with_view(direction, shapes.get(..1).unwrap_or_default(), height.clamp(64, 4096));
    shapes.iter().map(|shape| draw_view(shape, &camera, &meshes[shape.number])).collect()
}

fn draw_view(shape: &scaled_mesh::ScaledMesh, camera: &Camera, mesh: &ShadedMesh) -> MeshView {
    let points = camera.project(&shape.points);
    let buffer = raster::draw(&points, shape.faces, camera.width * SAMPLES, camera.height * SAMPLES);
    let middles = middles(&buffer, camera);
    let shading = mesh.shading(shape, &points, camera);
    let faces = shade::faces(shape, camera, false, shading.paint.is_some());
    let open = occlusion::openness(&buffer, &faces, camera);
    MeshView {
        shaded: shade::resolve(&buffer, &faces, &open, camera, &shading),
        normals: normals(&middles, &faces, camera, &shading),
        faces: middles.iter().map(|&face| (face != NOTHING).then_some(face)).collect(),
        covered: covered_samples(&buffer, camera),
    }
}

fn middles(buffer: &Buffer, camera: &Camera) -> Vec<u32> {
    let sample =
        |row: usize, column: usize| (row * SAMPLES + SAMPLES / 2) * buffer.width + column * SAMPLES + SAMPLES / 2;
    let row = |row: usize| (0..camera.width).map(move |column| buffer.face[sample(row, column)]);
    (0..camera.height).flat_map(row).collect()
}

fn covered_samples(buffer: &Buffer, camera: &Camera) -> Vec<u8> {
    let mut counts = vec![0; camera.width * camera.height];
    for (at, _) in buffer.face.iter().enumerate().filter(|(_, face)| **face != NOTHING) {
        let [row, column] = [at / buffer.width, at % buffer.width].map(|sample| sample / SAMPLES);
        counts[row * camera.width + column] += 1;
    }
    counts
}

fn normals(middles: &[u32], faces: &[Face], camera: &Camera, shading: &Shading) -> Image {
    let normal = |pixel: usize, face: u32| {
        let middle =
            [pixel % camera.width, pixel / camera.width].map(|at| (at * SAMPLES) as f32 + 0.5 * SAMPLES as f32);
        faces[face as usize].shading_normal(shading.normal(face, middle.into()))
    };
    let colour = |(pixel, &face): (usize, &u32)| {
        let normal = if face == NOTHING { Vec3::ZERO } else { normal(pixel, face) };
        let [x, y, z] = normal.to_array().map(|x| (127.5 * (x + 1.0)).round() as u8);
        [x, y, z, 255]
    };
    Image { width: camera.width, height: camera.height, rgba: middles.iter().enumerate().flat_map(colour).collect() }
}
