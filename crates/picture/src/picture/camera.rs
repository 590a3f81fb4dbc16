//! Camera of a picture: a three-quarter view with mild perspective.

use glam::Vec3;

use super::scaled_mesh::ScaledMesh;

/// Samples per pixel along each axis; odd, so that one is in the middle.
pub const SAMPLES: usize = 3;
/// Distance of the eye from the centre of the unit ball.
const EYE: f32 = 4.5;
/// Empty margin around the meshes, as a share of the panel's height.
const MARGIN: f32 = 0.06;
/// Preferred views, as azimuth and elevation in degrees: front and back.
const NATURAL: [[f32; 2]; 4] = [[-32.0, 16.0], [32.0, 16.0], [148.0, 16.0], [-148.0, 16.0]];
const OTHERS: [[f32; 2]; 4] = [[-62.0, 18.0], [62.0, 18.0], [-32.0, 48.0], [0.0, 80.0]];
// A view must show this share of the largest area of any view.
const GOOD_ENOUGH: f32 = 0.72;
// A later view replaces an earlier one if its detail is this many times larger.
const CLEARLY: f32 = 1.03;

/// View of the scene, and its panel.
#[derive(Clone, Debug)]
pub struct Camera {
    // Width of the panel in pixels.
    pub width: usize,
    // Height of the panel in pixels.
    pub height: usize,
    // Pixels per unit of length at the depth of the centre.
    pub scale: f32,
    axes: [Vec3; 3],
    // Middle of the panel, in units on the picture plane.
    middle: [f32; 2],
}

impl Camera {
    /// Chooses a view that shows the first shape well; fits all shapes into the panel.
    pub fn with_best_view(shapes: &[ScaledMesh], height: usize) -> Self {
        Self::with_axes(shapes.first().map_or(axes(NATURAL[0]), best_view), shapes, height)
    }

    /// Looks from an azimuth and elevation in degrees; fits the shapes into the panel.
    pub fn with_view(direction: [f32; 2], shapes: &[ScaledMesh], height: usize) -> Self {
        Self::with_axes(axes(direction), shapes, height)
    }

    fn with_axes(axes: [Vec3; 3], shapes: &[ScaledMesh], height: usize) -> Self {
        let mut camera = Self { width: height, height, scale: 1.0, axes, middle: [0.0; 2] };
        camera.fit(shapes);
        camera
    }

    /// Projects a point to pixels from the top left, with the inverse depth as z.
    pub fn pixel(&self, point: Vec3) -> Vec3 {
        let samples = SAMPLES as f32;
        self.project(&[point])
            .first()
            .map_or(Vec3::ZERO, |place| Vec3::new(place.x / samples, place.y / samples, place.z))
    }

    fn fit(&mut self, shapes: &[ScaledMesh]) {
        let flat = || shapes.iter().flat_map(|shape| &shape.points).map(|&p| on_plane(self.view(p)));
        let low = flat().reduce(Vec3::min).unwrap_or_default();
        let high = flat().reduce(Vec3::max).unwrap_or_default();
        // A flat or empty shape would give an infinite scale.
        let size = (high - low).max(Vec3::splat(1e-6));
        let height = self.height as f32;
        let inner = height * (1.0 - 2.0 * MARGIN);
        self.scale = (inner / size.y).min(height * (1.5 - 2.0 * MARGIN) / size.x);
        self.width = (size.x * self.scale + 2.0 * MARGIN * height).clamp(0.5 * height, 1.5 * height) as usize;
        self.middle = [0.5 * (low.x + high.x), 0.5 * (low.y + high.y)];
    }

    /// Turns a point or direction into the view's frame: x right, y up, z toward the eye.
    pub fn view(&self, point: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(point)))
    }

    pub fn eye(&self) -> Vec3 {
        Vec3::new(0.0, 0.0, EYE)
    }

    /// Projects points to sample coordinates from the top left, with the inverse depth as z, n_points.
    pub fn project(&self, points: &[Vec3]) -> Vec<Vec3> {
        let scale = self.scale * SAMPLES as f32;
        let centre = [0.5 * (self.width * SAMPLES) as f32, 0.5 * (self.height * SAMPLES) as f32];
        let place = |&point: &Vec3| {
            let flat = on_plane(self.view(point));
            let [x, y] = [(flat.x - self.middle[0]) * scale, (flat.y - self.middle[1]) * scale];
            Vec3::new(centre[0] + x, centre[1] - y, flat.z)
        };
        points.iter().map(place).collect()
    }

    /// Returns the point in the view's frame at a pixel with this inverse depth.
    pub fn unproject(&self, x: f32, y: f32, inverse_depth: f32) -> Vec3 {
        let depth = 1.0 / inverse_depth;
        let flat_x = self.middle[0] + (x - 0.5 * self.width as f32) / self.scale;
        let flat_y = self.middle[1] - (y - 0.5 * self.height as f32) / self.scale;
        Vec3::new(flat_x * depth / EYE, flat_y * depth / EYE, EYE - depth)
    }
}

// The picture plane passes through the centre; z is the inverse depth.
fn on_plane(view: Vec3) -> Vec3 {
    let depth = EYE - view.z;
    Vec3::new(view.x * EYE / depth, view.y * EYE / depth, 1.0 / depth)
}

// The axes are right, up and toward the eye.
fn axes([azimuth, elevation]: [f32; 2]) -> [Vec3; 3] {
    let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation.to_radians().sin_cos();
    let right = Vec3::new(cos_a, 0.0, -sin_a);
    let back = Vec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
    [right, back.cross(right), back]
}

/// Chooses, among views that show enough area, the one with most detail; returns right, up and toward the eye.
pub fn best_view(shape: &ScaledMesh) -> [Vec3; 3] {
    let normals = shape.area_normals();
    let bumps = bumps(shape, &normals);
    let [natural, others] = [NATURAL, OTHERS]
        .map(|views| views.map(|view| (view, visible_area_and_detail(axes(view)[2], &normals, &bumps))));
    // The area is compared with the best view of all, so that thin meshes have candidates too.
    let most_area = natural.iter().chain(&others).map(|(_, [area, _])| *area).fold(0.0, f32::max);
    let good = |(_, [area, _]): &&([f32; 2], [f32; 2])| *area >= GOOD_ENOUGH * most_area;
    // Preferred views come first; others count only if none of these shows enough.
    let best =
        natural.iter().filter(good).reduce(|best, next| if next.1[1] > CLEARLY * best.1[1] { next } else { best });
    axes(best.or(others.iter().find(good)).map_or(NATURAL[0], |&(view, _)| view))
}

// Detail of a face: the turn of the vertex normals at its corners from its own normal, times its area.
fn bumps(shape: &ScaledMesh, normals: &[Vec3]) -> Vec<f32> {
    let mut at_vertices = vec![Vec3::ZERO; shape.points.len()];
    for (face, &normal) in shape.faces.iter().zip(normals) {
        for &v in face {
            at_vertices[v as usize] += normal;
        }
    }
    let turned = |normal: Vec3, v: u32| normal.length() - normal.dot(at_vertices[v as usize].normalize_or_zero());
    let bump = |(face, &normal): (&[u32; 3], &Vec3)| face.iter().map(|&v| turned(normal, v)).sum();
    shape.faces.iter().zip(normals).map(bump).collect()
}

// Twice the area, and the detail, that face the direction, hidden parts included.
fn visible_area_and_detail(direction: Vec3, normals: &[Vec3], bumps: &[f32]) -> [f32; 2] {
    let seen = normals.iter().zip(bumps).map(|(normal, bump)| {
        let toward = normal.normalize_or_zero().dot(direction);
        // Detail counts on front sides alone, so that the view shows faces rather than backs.
        [normal.length() * toward.abs(), bump * toward.max(0.0)]
    });
    seen.fold([0.0; 2], |sum, seen| [sum[0] + seen[0], sum[1] + seen[1]])
}
