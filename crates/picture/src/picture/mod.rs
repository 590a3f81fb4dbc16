//! Pictures of meshes, drawn without a GPU: one view for all meshes, with visible edges.
//!
//! Light follows stored normals, else face normals. Of materials, base colours and textures are drawn.

mod camera;
mod caption;
mod corner_normals;
mod halving;
mod image;
mod image_file;
#[cfg(feature = "ktx2")]
mod ktx2;
#[cfg(not(feature = "ktx2"))]
#[path = "no_ktx2.rs"]
mod ktx2;
mod mark;
mod occlusion;
mod pixels;
mod png_file;
mod raster;
mod scaled_mesh;
mod shade;
mod shaded_mesh;
mod surface_materials;
mod texture;
mod value_paint;
mod views;

use glam::Vec3;

use crate::mesh::TriMesh;
use crate::parallel;
use camera::{Camera, SAMPLES};
use scaled_mesh::ScaledMesh;
use shade::Paint;
use value_paint::ValuePaint;

pub use corner_normals::CornerNormals;
pub use image::Image;
pub use image_file::{ImageFormat, decode_image, decode_numbers, encode_jpeg, encode_webp, image_problem, image_size};
pub use png_file::{encode_png, encode_png_opaque};
pub use shaded_mesh::ShadedMesh;
pub use surface_materials::{DecodedMaterials, PaintedCorner, SurfaceMaterials};
pub use texture::shrink;
pub use value_paint::Scale;
pub use views::{MeshView, view, view_shaded};

/// Options for the layout of a picture.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PictureOptions {
    /// Height of a panel in pixels, 64 to 4096; the width follows from the mesh.
    pub height: usize,
    /// Caption of each mesh, in ASCII.
    pub captions: Vec<String>,
    /// True if edges are drawn.
    pub edges: bool,
    /// Azimuth and elevation of the eye in degrees, from +z toward the right and up; chosen by the first mesh if
    /// `None`.
    pub view: Option<[f32; 2]>,
    /// Points in the meshes' unit that get a ring in each panel, even if hidden.
    pub marks: Vec<[f64; 3]>,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self { height: 720, captions: Vec::new(), edges: true, view: None, marks: Vec::new() }
    }
}

/// Draws meshes next to each other, seen from one viewpoint at one scale.
///
/// Up is +y; a flat mesh is seen from above. Back sides are tinted red, so that holes and inverted faces show.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, picture};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// let mut options = picture::PictureOptions::default();
/// options.height = 120;
/// let image = picture::render(&[&mesh, &mesh], &options);
/// assert_eq!(image.rgba.len(), image.height * image.width * 4);
/// assert!(picture::encode_png(&image).starts_with(b"\x89PNG"));
/// ```
pub fn render(meshes: &[&TriMesh], options: &PictureOptions) -> Image {
    render_shaded(&meshes.iter().map(|mesh| ShadedMesh::bare(mesh)).collect::<Vec<_>>(), options)
}

/// Draws meshes as [`render`] does, with their colours, textures and stored normals.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::{mesh::{Attributes, Look, Looks, shapes}, picture};
/// let ball = shapes::icosphere(2);
/// let mut red = Look::default();
/// red.colour = [0.8, 0.1, 0.1];
/// let materials = picture::DecodedMaterials::new(Attributes::NONE, &Looks::new(vec![red])).0.unwrap();
/// let mut options = picture::PictureOptions::default();
/// options.height = 120;
/// let plain = picture::ShadedMesh::bare(&ball);
/// let painted = picture::ShadedMesh { materials: Some(&materials), ..plain };
/// let image = picture::render_shaded(&[painted, plain], &options);
/// assert_eq!(image.height, 120);
/// ```
pub fn render_shaded(meshes: &[ShadedMesh], options: &PictureOptions) -> Image {
    draw(&meshes.iter().map(|&shaded| DrawnMesh { shaded, values: None }).collect::<Vec<_>>(), options)
}

/// Draws meshes as [`render`] does, coloured by values at their vertices, with contour lines.
///
/// Red is 0; blue is the end of the scale and beyond. Values that are missing or not finite are grey.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::{mesh::shapes, picture};
/// let ball = shapes::icosphere(3);
/// let heights: Vec<f64> = ball.positions().iter().map(|p| f64::from(p[1]) + 1.0).collect();
/// let mut options = picture::PictureOptions::default();
/// (options.height, options.edges) = (120, false);
/// let scale = picture::Scale { end: 2.0, lines: 10 };
/// let image = picture::render_painted(&[(&ball, &heights)], &scale, &options);
/// assert_eq!(image.height, 120);
/// ```
pub fn render_painted(meshes: &[(&TriMesh, &[f64])], scale: &Scale, options: &PictureOptions) -> Image {
    // A mesh without values is drawn grey, not left out.
    let nothing = vec![f64::NAN; meshes.iter().map(|(mesh, _)| mesh.positions().len()).max().unwrap_or(0)];
    let drawn = meshes.iter().map(|&(mesh, values)| {
        let n = mesh.positions().len();
        let values = if values.len() == n { values } else { &nothing[..n] };
        DrawnMesh { shaded: ShadedMesh::bare(mesh), values: Some((values, *scale)) }
    });
    draw(&drawn.collect::<Vec<_>>(), options)
}

struct DrawnMesh<'a> {
    shaded: ShadedMesh<'a>,
    // Values at the vertices, n_vertices, which take the place of colours.
    values: Option<(&'a [f64], Scale)>,
}

fn draw(meshes: &[DrawnMesh], options: &PictureOptions) -> Image {
    let surfaces: Vec<&TriMesh> = meshes.iter().map(|drawn| drawn.shaded.mesh).collect();
    let height = options.height.clamp(64, 4096);
    let world = scaled_mesh::PictureFrame::from_meshes(&surfaces);
    let shapes = world.shapes(&surfaces);
    let camera = match options.view {
        Some(direction) => Camera::with_view(direction, &shapes, height),
        None => Camera::with_best_view(&shapes, height),
    };
    // Marks are drawn last, on top of surfaces that hide their points.
    let marks: Vec<Vec3> = options.marks.iter().map(|&mark| camera.pixel(world.place(mark.into()))).collect();
    let panel = |shape: &ScaledMesh| {
        let points = camera.project(&shape.points);
        let DrawnMesh { shaded, values } = &meshes[shape.number];
        let mut shading = shaded.shading(shape, &points, &camera);
        if let Some((values, scale)) = *values {
            shading.paint = Some(Paint::Values(ValuePaint { points: &points, faces: shape.faces, values, scale }));
        }
        let buffer = raster::draw(&points, shape.faces, camera.width * SAMPLES, camera.height * SAMPLES);
        let faces = shade::faces(shape, &camera, options.edges, shading.paint.is_some());
        let open = occlusion::openness(&buffer, &faces, &camera);
        shade::resolve(&buffer, &faces, &open, &camera, &shading)
    };
    let mut panels = parallel::each(&shapes, panel);
    for panel in &mut panels {
        marks.iter().for_each(|&mark| mark::ring(panel, mark));
    }
    let captions = caption::wrap(&options.captions, camera.width);
    let mut image = side_by_side(&panels, &camera, caption::height(&captions));
    for (column, text) in captions.iter().take(panels.len()).enumerate() {
        let middle = column * camera.width + camera.width / 2;
        caption::write(&mut image, text, middle, camera.height);
    }
    image
}

/// Returns the unit direction from a mesh to the eye of [`render`].
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::{mesh::shapes, picture::toward_eye};
/// let length2: f32 = toward_eye(&shapes::icosphere(1)).iter().map(|x| x * x).sum();
/// assert!((length2 - 1.0).abs() < 1e-6);
/// ```
pub fn toward_eye(mesh: &TriMesh) -> [f32; 3] {
    let shapes = scaled_mesh::scale_meshes(&[mesh]);
    shapes.first().map_or([0.0, 0.0, 1.0], |shape| camera::best_view(shape)[2].to_array())
}

fn side_by_side(panels: &[Image], camera: &Camera, strip: usize) -> Image {
    let (width, height) = (camera.width * panels.len(), camera.height + strip);
    let mut rgba = Vec::with_capacity(width * height * 4);
    for row in 0..height {
        for panel in panels {
            let line = row * camera.width * 4..(row + 1) * camera.width * 4;
            match panel.rgba.get(line) {
                Some(pixels) => rgba.extend_from_slice(pixels),
                None => rgba.extend(shade::background(1.0).repeat(camera.width)),
            }
        }
    }
    Image { width, height, rgba }
}
