//! Several meshes each drawn alone from one fixed place, so that their pictures can be compared pixel by pixel.

use glam::Vec3;

use super::camera::Camera;
use super::raster::{self, Buffer, NOTHING};
use super::shade::{self, Face};
use super::{Image, SAMPLES, occlusion, shape};
use crate::mesh::TriMesh;

/// What is seen of one mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    /// The mesh shaded, without edges.
    pub shaded: Image,
    /// Normals turned to the eye, as colours: x right, y up, z toward the eye, each from -1..1 to 0..=255.
    pub normals: Image,
    /// Whether the middle of a pixel shows the mesh: height x width.
    pub covered: Vec<bool>,
}

/// Draws each mesh from the same place, given by azimuth and elevation in degrees; the first one decides what fits in.
///
/// ```
/// use neural_mesh::{mesh::shapes, picture::view};
/// let views = view(&[&shapes::icosphere(3), &shapes::icosphere(1)], [30.0, 15.0], 64);
/// assert_eq!((views.len(), views[0].shaded.height, views[1].shaded.width), (2, 64, views[0].shaded.width));
/// ```
pub fn view(meshes: &[&TriMesh], direction: [f32; 2], height: usize) -> Vec<View> {
    let shapes = shape::shapes(meshes);
    let camera = Camera::from(direction, &shapes, height.clamp(64, 4096));
    shapes.iter().map(|shape| seen(shape, &camera)).collect()
}

fn seen(shape: &shape::Shape, camera: &Camera) -> View {
    let points = camera.project(&shape.points);
    let buffer = raster::draw(&points, shape.faces, camera.width * SAMPLES, camera.height * SAMPLES);
    let faces = shade::faces(shape, camera, false, false);
    let open = occlusion::openness(&buffer, &faces, camera);
    let middles = middles(&buffer, camera);
    View {
        shaded: shade::resolve(&buffer, &faces, &open, camera, None),
        normals: normals(&middles, &faces, camera),
        covered: middles.iter().map(|&face| face != NOTHING).collect(),
    }
}

/// The face seen in the middle of each pixel.
fn middles(buffer: &Buffer, camera: &Camera) -> Vec<u32> {
    let sample =
        |row: usize, column: usize| (row * SAMPLES + SAMPLES / 2) * buffer.width + column * SAMPLES + SAMPLES / 2;
    let row = |row: usize| (0..camera.width).map(move |column| buffer.face[sample(row, column)]);
    (0..camera.height).flat_map(row).collect()
}

fn normals(middles: &[u32], faces: &[Face], camera: &Camera) -> Image {
    let colour = |&face: &u32| {
        let normal = faces.get(face as usize).map_or(Vec3::ZERO, |face| face.normal);
        let [x, y, z] = normal.to_array().map(|x| (127.5 * (x + 1.0)).round() as u8);
        [x, y, z, 255]
    };
    Image { width: camera.width, height: camera.height, rgba: middles.iter().flat_map(colour).collect() }
}
