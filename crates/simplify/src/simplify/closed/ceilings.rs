//! Ceilings: largest deformations of an asset's components, so that panes and boxes stay recognisable.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::area_normal;

use super::collapse::{Ceiling, Ceilings};
use super::dropping::vertex_components;
use super::original::Original;
use super::request::Task;

/// Largest deformation, over the diagonals of the component and of the whole scene; the smaller counts.
// Merging away a corner deforms a cube by 0.2 of its diagonal; merging away one of forty vertices, a sphere by 0.02.
const MOST_DISTANCE: [f64; 2] = [0.03, 0.01];
/// Largest deformation over the component's width, but at least a share of the whole scene's diagonal.
// Without it, beams become boards: at 0.1, FLIP errors of a windmill and a keyboard are 1.8 and 1.5 times as large.
const MOST_OF_WIDTH: f64 = 0.25;
const LEAST_OF_WHOLE: f64 = 0.0025;
/// Diagonal, over the whole scene's, below which a component may deform freely.
// Such a component covers a thousandth of the pixels.
const LEAST_SIZE: f64 = 0.03;

/// Finds the deformation that each component of an asset may have and still look like itself.
pub fn find_ceilings(original: &Original, task: &Task) -> Ceilings {
    let surface = &original.surface;
    let Task { input, options, .. } = task;
    if !task.is_asset() {
        return Ceilings::default();
    }
    let (of_vertex, n) = vertex_components(surface.n_vertices(), &surface.faces);
    if n < 2 {
        return Ceilings::default();
    }
    let mut sums = vec![Extent::default(); n];
    // One pass over the faces finds the bounding box of every component.
    for (face, f) in surface.faces.iter().zip(0..) {
        let corners = face.map(|v| surface.positions[v as usize]);
        sums[of_vertex[face[0] as usize] as usize].add(corners, f);
    }
    // Sizes are those in the scene, where a component may occur several times at several scales.
    let stretch = |extent: &Extent| input.scene.map_or(1.0, |scene| scene.stretch(task.piece_of_face(extent.face)));
    // The diagonal of all that a viewer sees.
    let whole = match input.scene {
        Some(scene) => scene.diagonal() * f64::from(surface.length(1.0)),
        None => f64::from(surface.length(original.mesh.diagonal() as f32)),
    };
    // An infinite limit allows components to be dropped, but deformed only within the usual limits.
    let within = if options.prune_within.is_finite() { options.prune_within } else { 0.0 };
    let allowed = within * f64::from(surface.length(1.0));
    let most = options.hold_shape.unwrap_or(MOST_DISTANCE[1]);
    let ceiling = |extent: &Extent| {
        let (size, stretch) = (extent.size(), stretch(extent).max(f64::MIN_POSITIVE));
        // Components that are too small to see may lose their shape.
        if size * stretch < LEAST_SIZE * whole {
            return Ceiling { allowed: f64::INFINITY, stretch };
        }
        // Limits of the scene are divided by the largest scale at which the component is placed.
        let of_whole = most * whole / stretch;
        // Beams and wires are much thinner than their diagonal says.
        let of_width = (MOST_OF_WIDTH * extent.width()).max(LEAST_OF_WHOLE * whole / stretch);
        Ceiling { allowed: (MOST_DISTANCE[0] * size).min(of_whole).min(of_width).max(allowed / stretch), stretch }
    };
    Ceilings::new(of_vertex, sums.iter().map(ceiling).collect(), whole)
}

#[derive(Clone, Copy)]
struct Extent {
    low: Vec3,
    high: Vec3,
    area: f64,
    face: u32,
}

impl Default for Extent {
    fn default() -> Self {
        Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, area: 0.0, face: 0 }
    }
}

impl Extent {
    fn add(&mut self, corners: [Vec3; 3], face: u32) {
        self.low = corners.into_iter().fold(self.low, Vec3::min);
        self.high = corners.into_iter().fold(self.high, Vec3::max);
        self.area += 0.5 * f64::from(area_normal(corners).length());
        self.face = face;
    }

    fn size(&self) -> f64 {
        DVec3::from(self.high - self.low).length()
    }

    /// Returns about the side of a square beam or of a cube.
    fn width(&self) -> f64 {
        self.area / (4.0 * self.size()).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes};
    use crate::simplify::input::Input;
    use crate::simplify::options::ClosedOptions;

    fn ceilings(mesh: &TriMesh) -> Vec<f32> {
        let attributes = Attributes { groups: vec![0; mesh.faces().len()], ..Attributes::default() };
        let (input, options) = (Input { attributes: &attributes, ..Input::bare(mesh) }, ClosedOptions::default());
        find_ceilings(&Original::bare(mesh), &Task::new(input, &options)).left
    }

    #[test]
    fn a_single_surface_and_dust_have_no_ceiling() {
        assert!(ceilings(&shapes::icosphere(2)).is_empty());
        let (large, n) = (shapes::icosphere(2), shapes::icosphere(2).positions().len());
        for (side, has_ceiling) in [(0.2, true), (0.01, false)] {
            let found = ceilings(&shapes::unite([&large, &shapes::cuboid([side; 3], 1)]));
            assert!(found[..n].iter().all(|ceiling| ceiling.is_finite()));
            assert!(found[n..].iter().all(|ceiling| ceiling.is_finite() == has_ceiling), "{side}");
        }
    }

    #[test]
    fn a_beam_may_deform_by_a_quarter_of_its_width_and_a_ball_as_before() {
        let beam = shapes::cuboid([0.08, 0.08, 2.0], 1);
        let ball = shapes::icosphere(3);
        let n = beam.positions().len();
        let mesh = shapes::unite([&beam, &shapes::place(&ball, |[x, y, z]| [x + 3.0, y, z])]);
        let unit = Original::bare(&mesh).surface.length(1.0);
        let found = ceilings(&mesh);
        let of_beam = found[0] / unit;
        assert!((0.2 * 0.08..0.3 * 0.08).contains(&of_beam), "{of_beam}");
        let of_ball = f64::from(found[n] / unit) / mesh.diagonal();
        assert!((of_ball - MOST_DISTANCE[1]).abs() < 1e-6, "{of_ball}");
    }
}
