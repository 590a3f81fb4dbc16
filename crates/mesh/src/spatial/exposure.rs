//! Visual importance of components, from views in many directions.

use glam::Vec3;

use crate::geometry::triangle::unit_normal;
use crate::linalg::{Isa, Work};
use crate::parallel;

use super::parallel_views::{axis, project, rasterize, to_pixels};

/// Number of view axes, each viewed from both ends.
const AXES: usize = 13;
/// Pixels per triangle; `SIDE` is the range of a view's side in pixels.
const PIXELS: f64 = 2.0;
const SIDE: [f64; 2] = [256.0, 768.0];
/// Least cosine between normals that look alike: 30 degrees.
const ALIKE: f32 = 0.866;
const NONE: u32 = u32::MAX;

/// The component and material of each face.
#[derive(Clone, Copy, Debug)]
pub struct Labels<'a> {
    /// Component of each face, n_faces, below `n_components`.
    pub components: &'a [u32],
    /// Material of each face, n_faces.
    pub materials: &'a [u32],
    /// Number of components.
    pub n_components: usize,
}

/// The largest shares of a view's covered pixels that show a component, and that change if it is removed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exposure {
    /// Share that shows the component.
    pub shown: f32,
    /// Share that would show the background, a back side, or a surface of another depth, material or orientation.
    pub changed: f32,
    /// Share that would show a back side instead of a front.
    pub opened: f32,
    /// Share that would show another material.
    pub recoloured: f32,
    /// Components that would show in its place without a visible change, ascending.
    pub replacements: Vec<u32>,
}

/// Returns the visible change of removing each component.
///
/// Surfaces at most `tolerance` apart look the same; positions (n x 3) are finite.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::{Labels, exposures};
/// let square = |z: f32| [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
/// let positions = [square(0.0), square(0.01)].concat();
/// let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
/// let labels = Labels { components: &[0, 0, 1, 1], materials: &[0; 4], n_components: 2 };
/// let exposures = exposures(&positions, &faces, labels, 0.1);
/// assert_eq!(exposures[0].opened, 0.0);
/// assert_eq!(exposures[0].replacements, [1]);
/// ```
pub fn exposures(positions: &[[f32; 3]], faces: &[[u32; 3]], labels: Labels, tolerance: f64) -> Vec<Exposure> {
    let side = (PIXELS * faces.len() as f64).sqrt().clamp(SIDE[0], SIDE[1]) as usize;
    let (scaled, scale) = to_pixels(positions, side);
    let normals: Vec<Vec3> = faces.iter().map(|face| unit_normal(face.map(|v| scaled[v as usize]))).collect();
    let scene =
        PixelScene { positions: &scaled, faces, normals: &normals, labels, tolerance: (tolerance * scale) as f32 };
    let of_axis = |number: usize| scene.exposures_along(side, axis(number, AXES));
    let mut all = parallel::reduce(AXES, of_axis, merge).unwrap_or_default();
    for exposure in &mut all {
        exposure.replacements.sort_unstable();
        exposure.replacements.dedup();
    }
    all
}

fn merge(mut all: Vec<Exposure>, others: Vec<Exposure>) -> Vec<Exposure> {
    for (exposure, other) in all.iter_mut().zip(others) {
        exposure.shown = exposure.shown.max(other.shown);
        exposure.changed = exposure.changed.max(other.changed);
        exposure.opened = exposure.opened.max(other.opened);
        exposure.recoloured = exposure.recoloured.max(other.recoloured);
        exposure.replacements.extend(other.replacements);
    }
    all
}

#[derive(Clone, Copy)]
struct DepthLayers {
    depths: [f32; 2],
    faces: [u32; 2],
    /// Component of the first face.
    component: u32,
}

const EMPTY: DepthLayers = DepthLayers { depths: [f32::INFINITY; 2], faces: [NONE; 2], component: NONE };

impl DepthLayers {
    #[inline(always)]
    fn insert_surface(&mut self, face: u32, component: u32, depth: f32) {
        let is_of_first = component == self.component;
        if depth < self.depths[0] {
            if !is_of_first {
                (self.depths[1], self.faces[1]) = (self.depths[0], self.faces[0]);
            }
            (self.depths[0], self.faces[0], self.component) = (depth, face, component);
        } else if !is_of_first && depth < self.depths[1] {
            (self.depths[1], self.faces[1]) = (depth, face);
        }
    }
}

struct PixelScene<'a> {
    positions: &'a [Vec3],
    faces: &'a [[u32; 3]],
    normals: &'a [Vec3],
    labels: Labels<'a>,
    tolerance: f32,
}

impl PixelScene<'_> {
    fn exposures_along(&self, side: usize, along: Vec3) -> Vec<Exposure> {
        let (right, up) = along.any_orthonormal_pair();
        let projected = project(self.positions, side, [right, up, along]);
        let pixels = Isa::best().run(LayerDrawing { scene: self, side, projected: &projected });
        let [near, far] = [0, 1].map(|end| pixels.iter().map(move |pixel| &pixel[end]));
        merge(self.exposures_of(near, along), self.exposures_of(far, -along))
    }

    fn exposures_of<'b>(&self, pixels: impl Iterator<Item = &'b DepthLayers> + Clone, along: Vec3) -> Vec<Exposure> {
        let mut counts = vec![[0u32; 4]; self.labels.n_components];
        let mut all = vec![Exposure::default(); self.labels.n_components];
        let covered = pixels.filter(|pixel| pixel.faces[0] != NONE);
        let n_covered = covered.clone().count() as f32;
        for pixel in covered {
            let component = pixel.component as usize;
            let is_front = |face: u32| self.normals[face as usize].dot(along) < 0.0;
            let [first, second] = pixel.faces;
            let opens = second != NONE && is_front(first) && !is_front(second);
            let changes = opens || !self.looks_alike(pixel, along);
            counts[component][0] += u32::from(changes);
            counts[component][1] += u32::from(opens);
            counts[component][3] += 1;
            let material = |face: u32| self.labels.materials[face as usize];
            counts[component][2] += u32::from(second != NONE && material(first) != material(second));
            if !changes {
                let (replacements, replacement) =
                    (&mut all[component].replacements, self.labels.components[second as usize]);
                replacements.extend((replacements.last() != Some(&replacement)).then_some(replacement));
            }
        }
        for (exposure, counts) in all.iter_mut().zip(counts) {
            [exposure.changed, exposure.opened, exposure.recoloured, exposure.shown] =
                counts.map(|n| n as f32 / n_covered);
            exposure.replacements.sort_unstable();
            exposure.replacements.dedup();
        }
        all
    }

    fn looks_alike(&self, DepthLayers { depths, faces: [first, second], .. }: &DepthLayers, along: Vec3) -> bool {
        if *second == NONE {
            return false;
        }
        let [first, second] = [*first as usize, *second as usize];
        let [normal, other] = [self.normals[first], self.normals[second]];
        // Depth overstates the distance of surfaces seen at an angle.
        let distance = (depths[1] - depths[0]) * normal.dot(along).abs().max(other.dot(along).abs());
        self.labels.materials[first] == self.labels.materials[second]
            && normal.dot(other).abs() >= ALIKE
            && distance <= self.tolerance
    }
}

/// The two nearest surfaces in each pixel, from both ends of an axis.
struct LayerDrawing<'a> {
    scene: &'a PixelScene<'a>,
    side: usize,
    projected: &'a [Vec3],
}

impl Work for LayerDrawing<'_> {
    type Output = Vec<[DepthLayers; 2]>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let LayerDrawing { scene, side, projected } = self;
        let mut pixels = vec![[EMPTY; 2]; side * side];
        for ((face, corners), &component) in (0..).zip(scene.faces).zip(scene.labels.components) {
            rasterize(side, corners.map(|v| projected[v as usize]), |at, depth| {
                let [near, far] = &mut pixels[at];
                near.insert_surface(face, component, depth);
                far.insert_surface(face, component, -depth);
            });
        }
        pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};

    fn merge_meshes(meshes: &[TriMesh]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<u32>) {
        let (positions, faces) = shapes::unite(meshes).into_parts();
        (positions, faces, (0..).zip(meshes).flat_map(|(number, mesh)| vec![number; mesh.faces().len()]).collect())
    }

    fn exposures_of(meshes: &[TriMesh], tolerance: f64) -> Vec<Exposure> {
        let (positions, faces, components) = merge_meshes(meshes);
        let materials = vec![0; faces.len()];
        let labels = Labels { components: &components, materials: &materials, n_components: meshes.len() };
        exposures(&positions, &faces, labels, tolerance)
    }

    fn scale_mesh(mesh: &TriMesh, by: f32) -> TriMesh {
        TriMesh::new(mesh.positions().iter().map(|p| p.map(|x| by * x)).collect(), mesh.faces().to_vec()).unwrap()
    }

    #[test]
    fn the_lid_of_a_sphere_opens_it_and_what_is_within_changes_nothing() {
        let sphere = shapes::icosphere(3);
        let is_lid = |face: &[u32; 3]| face.iter().all(|&v| sphere.positions()[v as usize][2] > 0.9);
        let keep_faces = |is_wanted: &dyn Fn(&[u32; 3]) -> bool| {
            let faces = sphere.faces().iter().copied().filter(|face| is_wanted(face)).collect();
            TriMesh::new(sphere.positions().to_vec(), faces).unwrap()
        };
        let meshes = [keep_faces(&|face| !is_lid(face)), keep_faces(&is_lid), scale_mesh(&sphere, 0.5)];
        let found = exposures_of(&meshes, 0.01);
        assert!(found[0].changed > 0.5 && found[1].opened > 0.005, "{found:?}");
        assert!(found[2].changed == 0.0 && found[2].opened == 0.0 && found[2].shown == 0.0);
        assert!(found[0].shown >= found[0].changed && (0.01..0.2).contains(&found[1].shown), "{found:?}");
    }

    #[test]
    fn two_shells_within_the_tolerance_replace_each_other() {
        let sphere = shapes::icosphere(3);
        let meshes = [scale_mesh(&sphere, 1.001), sphere.clone()];
        let found = exposures_of(&meshes, 0.02);
        assert!(found[0].changed < 0.05 && found[0].replacements == [1] && found[1].changed == 0.0, "{found:?}");
        assert_eq!(found[0].recoloured, 0.0);
        assert!(exposures_of(&meshes, 1e-5)[0].changed > 0.5);
    }
}
