//! How far two meshes are apart, for a program that has just made one of the other: fewer figures than
//! [`surface_distance`](super::surface_distance) has, at a fraction of its time.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::triangle::area_normal_f64;
use crate::linalg::{Isa, Work};
use crate::mesh::TriMesh;
use crate::mesh::surface_samples::surface_samples;
use crate::spatial::FaceTree;

/// Samples per rayon task; sums are taken task by task in order, so they do not depend on threads.
const CHUNK: usize = 256;
/// Samples in whose surroundings the largest distance is looked for: those that are the farthest.
const FARTHEST: usize = 64;

/// Two-sided distance between two surfaces, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuickDistance {
    /// Mean of the mean distances in both directions.
    pub mean: f64,
    /// Largest distance found in either direction: of the samples, and of corners and middles of the faces around the
    /// farthest of them.
    pub max: f64,
    /// Diagonal of the original's bounding box.
    pub diagonal: f64,
}

/// Measures the distance from so many samples on each surface; `None` where one of the two has no faces, or for no samples.
///
/// The mean is that of [`surface_distance`](super::surface_distance) at the same samples and seed.
///
/// ```
/// use neural_mesh::{mesh::TriMesh, metrics::quick_distance};
/// let at = |z: f32| TriMesh::new(vec![[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]], vec![[0, 1, 2]]).unwrap();
/// let distance = quick_distance(&at(0.0), &at(0.5), 100, 0).unwrap();
/// assert_eq!((distance.mean, distance.max), (0.5, 0.5));
/// ```
pub fn quick_distance(original: &TriMesh, simplified: &TriMesh, n_samples: usize, seed: u64) -> Option<QuickDistance> {
    if original.faces().is_empty() || simplified.faces().is_empty() || n_samples == 0 {
        return None;
    }
    let (original_tree, simplified_tree) = rayon::join(|| tree(original), || tree(simplified));
    let (forward, backward) = rayon::join(
        || one_sided(original, [&original_tree, &simplified_tree], n_samples, seed),
        || one_sided(simplified, [&simplified_tree, &original_tree], n_samples, seed),
    );
    Some(QuickDistance {
        mean: 0.5 * (forward.0 + backward.0),
        max: forward.1.max(backward.1),
        diagonal: original.diagonal(),
    })
}

/// The distance between the meshes of a scene and what became of them, each pair with the scale at which it counts: the mean
/// over the areas of all, the largest of all, and the diagonal of the largest; in the unit of the scene.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::{quick_distance, quick_distance_of_pairs}};
/// let (fine, coarse) = (shapes::icosphere(3), shapes::icosphere(1));
/// let one = quick_distance(&fine, &coarse, 1000, 0).unwrap();
/// let two = quick_distance_of_pairs(&[(&fine, &coarse, 2.0), (&fine, &coarse, 2.0)], 2000, 0).unwrap();
/// assert!((two.mean - 2.0 * one.mean).abs() < 1e-9 && two.diagonal == 2.0 * one.diagonal);
/// ```
pub fn quick_distance_of_pairs(
    pairs: &[(&TriMesh, &TriMesh, f64)],
    n_samples: usize,
    seed: u64,
) -> Option<QuickDistance> {
    let (mut all, mut whole) = (QuickDistance::default(), 0.0);
    let n_each = n_samples / pairs.len().clamp(1, 10);
    for &(before, after, scale) in pairs {
        let Some(found) = quick_distance(before, after, n_each, seed) else { continue };
        let area = area(before) * scale * scale;
        all.mean += area * scale * found.mean;
        whole += area;
        all.max = all.max.max(scale * found.max);
        all.diagonal = all.diagonal.max(scale * found.diagonal);
    }
    all.mean /= if whole > 0.0 { whole } else { 1.0 };
    (all.diagonal > 0.0).then_some(all)
}

/// The area of all faces.
fn area(mesh: &TriMesh) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.positions()[v as usize].map(f64::from));
    mesh.faces().iter().map(|face| 0.5 * area_normal_f64(face.map(corner)).length()).sum()
}

fn tree(mesh: &TriMesh) -> FaceTree<'_> {
    FaceTree::new(mesh.positions(), mesh.faces())
}

/// Mean and largest distance from samples of one mesh to another; the trees are those of the mesh and of the other.
fn one_sided(mesh: &TriMesh, [own, other]: [&FaceTree; 2], n_samples: usize, seed: u64) -> (f64, f64) {
    let samples = along_curve(mesh, own, n_samples, seed);
    let in_a_row = |samples: &[DVec3]| Isa::best().run(InARow { samples, tree: other });
    let found: Vec<Found> = samples.par_chunks(CHUNK).flat_map_iter(in_a_row).collect();
    let distance2 = |i: &usize| found[*i].distance2;
    let mut farthest: Vec<usize> = (0..samples.len()).collect();
    let by_distance = |i: &usize, j: &usize| distance2(j).total_cmp(&distance2(i)).then(i.cmp(j));
    if farthest.len() > FARTHEST {
        farthest.select_nth_unstable_by(FARTHEST - 1, by_distance);
        farthest.truncate(FARTHEST);
    }
    let largest = farthest.iter().map(distance2).fold(0.0, f64::max);
    let around = |i: &usize| {
        let points = points_on(mesh, own.around(samples[*i]));
        let above = |largest, p| other.distance_above(largest, p, Some(found[*i].face)).unwrap_or(largest);
        points.into_iter().fold(largest, above)
    };
    let largest = farthest.par_iter().map(around).reduce(|| largest, f64::max);
    (found.iter().map(|found| found.distance2.sqrt()).sum::<f64>() / samples.len() as f64, largest.sqrt())
}

/// Samples of a mesh in the order of its faces along the curve of its tree: what is nearest to one is near the next one.
fn along_curve(mesh: &TriMesh, own: &FaceTree, n_samples: usize, seed: u64) -> Vec<DVec3> {
    let mut rank = vec![0; mesh.faces().len()];
    (0u32..).zip(own.order()).for_each(|(i, &face)| rank[face as usize] = i);
    let mut samples = surface_samples(mesh, n_samples, seed);
    samples.sort_by_key(|sample| rank[sample.face as usize]);
    samples.iter().map(|sample| sample.point(mesh)).collect()
}

/// What lies nearest to a sample.
struct Found {
    face: u32,
    distance2: f64,
}

/// What lies nearest to samples in a row, as work that is compiled for the instructions at hand.
struct InARow<'a> {
    samples: &'a [DVec3],
    tree: &'a FaceTree<'a>,
}

impl Work for InARow<'_> {
    type Output = Vec<Found>;

    #[inline(always)]
    fn run(self) -> Vec<Found> {
        let mut row = Vec::with_capacity(self.samples.len());
        let mut last = None;
        for &p in self.samples {
            let (face, distance2) = self.tree.nearest_from(p, last).unwrap_or_default();
            last = Some(face);
            row.push(Found { face, distance2 });
        }
        row
    }
}

/// Corners and middles of some faces.
fn points_on(mesh: &TriMesh, faces: &[u32]) -> Vec<DVec3> {
    let point = |v: u32| DVec3::from(mesh.positions()[v as usize].map(f64::from));
    let faces = || faces.iter().map(|&face| mesh.faces()[face as usize]);
    let mut corners: Vec<u32> = faces().flatten().collect();
    corners.sort_unstable();
    corners.dedup();
    let middles = faces().map(|face| face.map(point).into_iter().sum::<DVec3>() / 3.0);
    middles.chain(corners.into_iter().map(point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::metrics::{Surface, surface_distance};

    #[test]
    fn says_what_the_full_measurement_says() {
        for (a, b) in
            [(shapes::bolt(32), shapes::bolt(9)), (shapes::torus(64, 32, 1.0, 0.25), shapes::torus(20, 9, 1.0, 0.25))]
        {
            let full = surface_distance(&Surface::new(&a, 3000, 0), &Surface::new(&b, 3000, 0)).unwrap();
            let quick = quick_distance(&a, &b, 3000, 0).unwrap();
            assert!((quick.mean - full.both.mean).abs() < 1e-12 && quick.max >= full.both.max - 1e-12);
            assert!((quick.diagonal - full.diagonal).abs() < 1e-6);
        }
    }

    /// One vertex of many is pulled out: samples lie on its faces, but not at their tip.
    #[test]
    fn the_largest_distance_is_found_between_samples() {
        let (mut positions, faces) = shapes::icosphere(5).into_parts();
        let pulled = positions[4000].map(|x| 1.5 * x);
        positions[4000] = pulled;
        let spiked = TriMesh::new(positions, faces).unwrap();
        let quick = quick_distance(&spiked, &shapes::icosphere(5), 5000, 0).unwrap();
        assert!((quick.max - 0.5).abs() < 2e-3, "{quick:?}");
    }

    #[test]
    fn nothing_has_no_distance() {
        let sphere = shapes::icosphere(0);
        assert!(quick_distance(&TriMesh::default(), &sphere, 10, 0).is_none());
        assert!(quick_distance(&sphere, &TriMesh::default(), 10, 0).is_none());
        assert!(quick_distance(&sphere, &sphere, 0, 0).is_none());
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let (a, b) = (shapes::bolt(32), shapes::bolt(9));
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| quick_distance(&a, &b, 4000, 0).unwrap())
        };
        assert_eq!(on(1), on(3));
    }
}
