//! A fast two-sided distance between two meshes.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::area_normal_f64;
use crate::linalg::{Isa, Work};
use crate::mesh::TriMesh;
use crate::parallel;
use crate::spatial::FaceTree;

use super::certified_distance::{largest_distance_from_faces, measured_faces};
use super::search_budget::affordable_count;

const CHUNK: usize = 256;
/// Searches that a thread takes at least.
const LEAST: usize = 64;
/// Share of the largest sample distance below which vertices and edge midpoints are ignored.
const PROBE_SHARE: f64 = 0.7;
/// Number of farthest points around which the largest distance is searched.
const N_FARTHEST: usize = 16;
/// Number of faces searched before and after a farthest point in curve order.
const NEIGHBOURHOOD: usize = 4;
/// Relative gap of the bounds at which the search for the largest distance ends.
const GAP: f64 = 0.02;
/// Largest number of triangle tests of that search, per direction.
pub(super) const MAX_TESTS: u64 = 40_000;
/// Samples of a surface that is measured to many others.
const FIXED_SAMPLES: usize = 2000;
/// Largest number of such tests where only a distance beyond another is asked for.
const TESTS_BEYOND: u64 = 10_000;
/// Largest number of triangles and boxes visited per direction, or `USUAL_VISITS` per point if that is more.
const MAX_VISITS: f64 = 1e7;
const USUAL_VISITS: f64 = 100.0;
const AREAS_CHUNK: usize = 4096;
/// Steps of a low-discrepancy sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
const R2_STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// A two-sided distance between two surfaces, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct QuickDistance {
    /// Mean of the mean distances in both directions.
    pub mean: f64,
    /// Largest distance found, a lower bound of the true one.
    pub max: f64,
    /// Diagonal of the original's bounding box.
    pub diagonal: f64,
    /// Samples used per surface; fewer than requested where large faces intersect heavily.
    pub n_samples: usize,
}

/// Measures the distance with `n_samples` per surface; `None` if a mesh has no faces or `n_samples` is 0.
///
/// Each surface is cut into strips of equal area, with one sample in each; `seed` moves the samples.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, metrics::quick_distance};
/// let triangle_at_height = |z: f32| TriMesh::new(vec![[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]], vec![[0, 1, 2]]).unwrap();
/// let distance = quick_distance(&triangle_at_height(0.0), &triangle_at_height(0.5), 100, 0).unwrap();
/// assert_eq!((distance.mean, distance.max), (0.5, 0.5));
/// ```
pub fn quick_distance(original: &TriMesh, simplified: &TriMesh, n_samples: usize, seed: u64) -> Option<QuickDistance> {
    let trees = parallel::join(|| face_tree(original), || face_tree(simplified));
    quick_distance_by_trees([original, simplified], [&trees.0, &trees.1], n_samples, seed)
}

/// Measures as [`quick_distance`] with the trees of both meshes.
pub(super) fn quick_distance_by_trees(
    [original, simplified]: [&TriMesh; 2],
    [original_tree, simplified_tree]: [&FaceTree; 2],
    n_samples: usize,
    seed: u64,
) -> Option<QuickDistance> {
    if original.faces().is_empty() || simplified.faces().is_empty() || n_samples == 0 {
        return None;
    }
    let (forward, backward) = parallel::join(
        || one_way_distance([original, simplified], [original_tree, simplified_tree], n_samples, seed),
        || one_way_distance([simplified, original], [simplified_tree, original_tree], n_samples, seed),
    );
    let mean = 0.5 * (forward.mean + backward.mean);
    let n_measured = forward.n_samples.min(backward.n_samples);
    let max = forward.max().max(backward.max());
    let max = forward.raise_max([original, simplified], [original_tree, simplified_tree], max, MAX_TESTS);
    let max = backward.raise_max([simplified, original], [simplified_tree, original_tree], max, MAX_TESTS);
    Some(QuickDistance { mean, max, diagonal: original_tree.diagonal(), n_samples: n_measured })
}

/// The points of a surface that are measured on their way to another: vertices in curve order, and samples.
pub(super) struct FixedPoints {
    vertices: Vec<ProbePoint>,
    samples: Vec<CurveSample>,
}

impl FixedPoints {
    pub fn new(mesh: &TriMesh, order: &[u32]) -> Self {
        Self { vertices: probe_points(mesh, order, false), samples: curve_samples(mesh, order, FIXED_SAMPLES, 0) }
    }
}

/// Returns the largest distance between two meshes, or 0 if none is beyond `least`.
///
/// Leads from the points of the original, and from vertices, midpoints and samples of the simplified mesh.
pub(super) fn largest_beyond_by_trees(
    [original, simplified]: [&TriMesh; 2],
    [original_tree, simplified_tree]: [&FaceTree; 2],
    points: &FixedPoints,
    (n_samples, least): (usize, f64),
) -> f64 {
    let far = least * least;
    let order = original_tree.order();
    let sample = |sample: &CurveSample| (sample.place, sample.point);
    let vertex = |probe: &ProbePoint| (probe.place as usize, probe.point(original, order));
    let mut found = measure_beyond(&points.vertices, vertex, simplified_tree, far);
    found.extend(measure_beyond(&points.samples, sample, simplified_tree, far));
    let forward = OneWayDistance { mean: 0.0, n_samples, found };
    let (meshes, trees) = ([simplified, original], [simplified_tree, original_tree]);
    let samples = curve_samples(simplified, simplified_tree.order(), n_samples, 0);
    let mut found = measure_beyond(&samples, sample, original_tree, far);
    found.extend(probe_beyond(meshes, trees, far));
    let backward = OneWayDistance { mean: 0.0, n_samples, found };
    let max = forward.max().max(backward.max());
    if max == 0.0 {
        return 0.0;
    }
    let max = forward.raise_max([original, simplified], [original_tree, simplified_tree], max, TESTS_BEYOND);
    backward.raise_max(meshes, trees, max, TESTS_BEYOND)
}

/// Returns the point of either surface farthest from the other; `None` if a mesh has no faces.
///
/// Vertices and `n_samples` samples of each surface are compared.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::{TriMesh, shapes}, metrics::farthest_point};
/// let sphere = shapes::icosphere(2);
/// let mut pulled = sphere.positions().to_vec();
/// pulled[7] = pulled[7].map(|x| 1.5 * x);
/// let place = pulled[7].map(f64::from);
/// let pulled = TriMesh::new(pulled, sphere.faces().to_vec()).unwrap();
/// assert_eq!(farthest_point(&sphere, &pulled, 1000), Some(place));
/// ```
pub fn farthest_point(original: &TriMesh, simplified: &TriMesh, n_samples: usize) -> Option<[f64; 3]> {
    if original.faces().is_empty() || simplified.faces().is_empty() {
        return None;
    }
    let (own, other) = parallel::join(|| face_tree(original), || face_tree(simplified));
    let forward = find_farthest(original, &own, &other, n_samples);
    let backward = find_farthest(simplified, &other, &own, n_samples);
    let farthest = if backward.1 > forward.1 { backward } else { forward };
    Some(farthest.0.to_array())
}

fn find_farthest(mesh: &TriMesh, own: &FaceTree, other: &FaceTree, n_samples: usize) -> (DVec3, f64) {
    let vertices = mesh.positions().iter().map(|p| Vec3::from(*p).as_dvec3());
    let points: Vec<DVec3> =
        curve_samples(mesh, own.order(), n_samples, 0).iter().map(|sample| sample.point).chain(vertices).collect();
    let look = |point: DVec3| other.find_near_with_cost(point, None, f64::NEG_INFINITY);
    let most = MAX_VISITS.max(USUAL_VISITS * points.len() as f64);
    let n = affordable_count(points.len(), most, |i| look(points[i]).map_or(0, |found| found.2.total()));
    let far = |i: usize| {
        let point = points[i * points.len() / n];
        (point, look(point).map_or(0.0, |found| found.1))
    };
    let farther = |x: (DVec3, f64), y: (DVec3, f64)| if y.1 > x.1 { y } else { x };
    parallel::map(n, LEAST, far).into_iter().fold((DVec3::ZERO, -1.0), farther)
}

pub(super) fn surface_area(mesh: &TriMesh) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.positions()[v as usize].map(f64::from));
    mesh.faces().iter().map(|face| 0.5 * area_normal_f64(face.map(corner)).length()).sum()
}

pub(super) fn face_tree(mesh: &TriMesh) -> FaceTree<'_> {
    FaceTree::new(mesh.positions(), mesh.faces())
}

pub(super) struct OneWayDistance {
    pub mean: f64,
    n_samples: usize,
    /// Distances of samples, vertices and midpoints.
    found: Vec<FaceDistance>,
}

impl OneWayDistance {
    pub fn max(&self) -> f64 {
        largest_distance2(&self.found).sqrt()
    }

    /// Returns `max`, or a larger distance inside the faces around the farthest points, accurate within `GAP`.
    // The maximum is rarely at a sample.
    pub fn raise_max(self, meshes: [&TriMesh; 2], [own, other]: [&FaceTree; 2], max: f64, most_tests: u64) -> f64 {
        let faces = faces_near_farthest(self.found, own.order());
        largest_distance_from_faces(meshes, &measured_faces(meshes[0], &faces), other, [max, GAP], most_tests)
    }
}

pub(super) fn one_way_distance(
    meshes: [&TriMesh; 2],
    [own, other]: [&FaceTree; 2],
    n_samples: usize,
    seed: u64,
) -> OneWayDistance {
    let mesh = meshes[0];
    let draw = |n| curve_samples(mesh, own.order(), n, seed);
    let samples = draw(n_samples);
    let looks =
        |point: DVec3, enough| other.find_near_with_cost(point, None, enough).map_or(0, |found| found.2.total());
    let most = |n: usize| MAX_VISITS.max(USUAL_VISITS * n as f64);
    let n_affordable = affordable_count(n_samples, most(n_samples), |i| looks(samples[i].point, f64::NEG_INFINITY));
    let samples = if n_affordable < n_samples { draw(n_affordable) } else { samples };
    let measure_chunk = |_, samples: &[CurveSample]| Isa::best().run(SampleDistances { samples, tree: other });
    let mut found = parallel::chunks(&samples, CHUNK, measure_chunk).concat();
    let mean = found.iter().map(|found| found.distance2.sqrt()).sum::<f64>() / samples.len() as f64;
    // Points well below the farthest sample cannot raise the maximum much: skip them.
    let far = PROBE_SHARE * PROBE_SHARE * largest_distance2(&found);
    found.extend(probe_beyond(meshes, [own, other], far));
    OneWayDistance { mean, n_samples: samples.len(), found }
}

/// Measures the vertices and midpoints of a mesh that are beyond the squared distance `far` from the other.
fn probe_beyond(meshes: [&TriMesh; 2], [own, other]: [&FaceTree; 2], far: f64) -> Vec<FaceDistance> {
    // Midpoints of the finer mesh's edges would cost more than they find.
    let with_middles = meshes[0].faces().len() <= meshes[1].faces().len();
    let probe_points = probe_points(meshes[0], own.order(), with_middles);
    let point = |probe: &ProbePoint| (probe.place as usize, probe.point(meshes[0], own.order()));
    measure_beyond(&probe_points, point, other, far)
}

/// Measures those of `items` that are beyond the squared distance `far`, or as many as the budget allows.
fn measure_beyond<T: Sync>(
    items: &[T],
    place_and_point: impl Fn(&T) -> (usize, DVec3) + Sync,
    tree: &FaceTree,
    far: f64,
) -> Vec<FaceDistance> {
    let looks =
        |i: usize| tree.find_near_with_cost(place_and_point(&items[i]).1, None, far).map_or(0, |found| found.2.total());
    let n = affordable_count(items.len(), MAX_VISITS.max(USUAL_VISITS * items.len() as f64), looks);
    let measure_chunk = |start: usize| {
        let (places, points): (Vec<usize>, Vec<DVec3>) =
            (start..n.min(start + CHUNK)).map(|i| place_and_point(&items[i * items.len() / n])).unzip();
        let found = places.into_iter().zip(tree.find_near_in_row(&points, far).0);
        let found = found.map(|(place, (_, distance2))| FaceDistance { place, distance2 });
        found.filter(|found| found.distance2 > far).collect::<Vec<_>>()
    };
    parallel::each((0..n).step_by(CHUNK), measure_chunk).concat()
}

fn largest_distance2(found: &[FaceDistance]) -> f64 {
    found.iter().map(|found| found.distance2).fold(0.0, f64::max)
}

fn faces_near_farthest(mut found: Vec<FaceDistance>, order: &[u32]) -> Vec<u32> {
    let by_distance =
        |a: &FaceDistance, b: &FaceDistance| b.distance2.total_cmp(&a.distance2).then(a.place.cmp(&b.place));
    if found.len() > N_FARTHEST {
        found.select_nth_unstable_by(N_FARTHEST - 1, by_distance);
        found.truncate(N_FARTHEST);
    }
    let around = |place: usize| place.saturating_sub(NEIGHBOURHOOD)..order.len().min(place + NEIGHBOURHOOD + 1);
    let mut places: Vec<usize> = found.iter().flat_map(|found| around(found.place)).collect();
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|place| order[place]).collect()
}

/// A vertex or edge midpoint that is measured in addition to the samples.
///
/// `place` is the face's index in curve order; `at` is the corner, or 3 plus the side.
#[derive(Clone, Copy)]
pub(super) struct ProbePoint {
    place: u32,
    at: u32,
}

impl ProbePoint {
    #[inline(always)]
    fn point(self, mesh: &TriMesh, order: &[u32]) -> DVec3 {
        let face = mesh.faces()[order[self.place as usize] as usize];
        let k = self.at as usize % 3;
        let corner = vertex_point(mesh, face[k]);
        if self.at < 3 { corner } else { 0.5 * (corner + vertex_point(mesh, face[(k + 1) % 3])) }
    }
}

/// Returns the vertices of a mesh's measured faces in curve order, and their edge midpoints on request.
pub(super) fn probe_points(mesh: &TriMesh, order: &[u32], with_middles: bool) -> Vec<ProbePoint> {
    let mut is_seen = vec![false; mesh.positions().len()];
    let mut probe_points = Vec::with_capacity(is_seen.len());
    let mut measured = measured_faces(mesh, order).into_iter().peekable();
    for (place, &face) in (0..).zip(order).filter(|&(_, face)| measured.next_if_eq(face).is_some()) {
        let corners = mesh.faces()[face as usize];
        for at in 0..3 {
            let [v, next] = [corners[at], corners[(at + 1) % 3]];
            if !std::mem::replace(&mut is_seen[v as usize], true) {
                probe_points.push(ProbePoint { place, at: at as u32 });
            }
            if with_middles && v < next {
                probe_points.push(ProbePoint { place, at: at as u32 + 3 });
            }
        }
    }
    probe_points
}

pub(super) struct CurveSample {
    pub point: DVec3,
    place: usize,
}

/// Draws samples in curve order, evenly by area, or by face if no face has area.
pub(super) fn curve_samples(mesh: &TriMesh, order: &[u32], n_samples: usize, seed: u64) -> Vec<CurveSample> {
    let mut areas: Vec<f64> = vec![0.0; order.len()];
    let tasks = areas.chunks_mut(AREAS_CHUNK).zip(order.chunks(AREAS_CHUNK));
    parallel::each(tasks, |(areas, faces)| Isa::best().run(FaceAreas { mesh, faces, areas }));
    let mut total: f64 = areas.iter().sum();
    if total <= 0.0 {
        areas.fill(1.0);
        total = areas.len() as f64;
    }
    let (mut place, mut before) = (0, 0.0);
    let draw = |i: usize| {
        let [along, across] = R2_STEPS.map(|step| ((seed as f64 + 0.5) * 0.618 + i as f64 * step).fract());
        let reach = (i as f64 + along) / n_samples as f64 * total;
        while place + 1 < areas.len() && before + areas[place] <= reach {
            before += areas[place];
            place += 1;
        }
        let within = ((reach - before) / areas[place]).clamp(0.0, 1.0);
        CurveSample { point: point_in_triangle(corners(mesh, order[place]), [within, across]), place }
    };
    (0..n_samples).map(draw).collect()
}

fn point_in_triangle([a, b, c]: [DVec3; 3], [x, y]: [f64; 2]) -> DVec3 {
    let root = if x > 0.0 { x.sqrt() } else { 0.0 };
    a * (1.0 - root) + b * (root * (1.0 - y)) + c * (root * y)
}

#[inline(always)]
fn corners(mesh: &TriMesh, face: u32) -> [DVec3; 3] {
    let [a, b, c] = mesh.faces()[face as usize];
    [vertex_point(mesh, a), vertex_point(mesh, b), vertex_point(mesh, c)]
}

#[inline(always)]
pub(super) fn vertex_point(mesh: &TriMesh, vertex: u32) -> DVec3 {
    let [x, y, z] = mesh.positions()[vertex as usize];
    DVec3::new(x.into(), y.into(), z.into())
}

struct FaceAreas<'a> {
    mesh: &'a TriMesh,
    faces: &'a [u32],
    areas: &'a mut [f64],
}

impl Work for FaceAreas<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (area, &face) in self.areas.iter_mut().zip(self.faces) {
            *area = area_normal_f64(corners(self.mesh, face)).length();
        }
    }
}

#[derive(Clone, Copy)]
struct FaceDistance {
    place: usize,
    distance2: f64,
}

struct SampleDistances<'a> {
    samples: &'a [CurveSample],
    tree: &'a FaceTree<'a>,
}

impl Work for SampleDistances<'_> {
    type Output = Vec<FaceDistance>;

    #[inline(always)]
    fn run(self) -> Vec<FaceDistance> {
        let mut row = Vec::with_capacity(self.samples.len());
        let mut last = None;
        for sample in self.samples {
            let (face, distance2) = self.tree.nearest_from(sample.point, last).unwrap_or_default();
            last = Some(face);
            row.push(FaceDistance { place: sample.place, distance2 });
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::nearest_on_triangle::nearest_weights_f64;
    use crate::mesh::shapes;
    use crate::metrics::tests::faces_across;
    use crate::metrics::{Surface, surface_distance};

    #[test]
    fn says_what_the_full_measurement_says() {
        for (a, b) in
            [(shapes::bolt(32), shapes::bolt(9)), (shapes::torus(64, 32, 1.0, 0.25), shapes::torus(20, 9, 1.0, 0.25))]
        {
            let full = surface_distance(&Surface::new(&a, 100_000, 0), &Surface::new(&b, 100_000, 0)).unwrap();
            let quick = quick_distance(&a, &b, 6000, 0).unwrap();
            assert!((quick.mean / full.both.mean - 1.0).abs() < 0.01, "{quick:?} {full:?}");
            assert!(quick.max >= 0.98 * full.both.max, "{quick:?} {full:?}");
            assert!((quick.diagonal - full.diagonal).abs() < 1e-6);
        }
    }

    #[test]
    fn agrees_with_a_search_of_all_faces() {
        let (a, b) = (shapes::bolt(12), shapes::bolt(5));
        let naive = |p: DVec3, mesh: &TriMesh| {
            let distance = |face: u32| {
                let [a, b, c] = corners(mesh, face);
                let [u, v, w] = nearest_weights_f64(p, [a, b, c]);
                p.distance(a * u + b * v + c * w)
            };
            (0..mesh.faces().len() as u32).map(distance).fold(f64::INFINITY, f64::min)
        };
        let mean = |from: &TriMesh, to: &TriMesh| {
            let samples = curve_samples(from, face_tree(from).order(), 500, 3);
            samples.iter().map(|sample| naive(sample.point, to)).sum::<f64>() / 500.0
        };
        let quick = quick_distance(&a, &b, 500, 3).unwrap();
        assert!((quick.mean - 0.5 * (mean(&a, &b) + mean(&b, &a))).abs() < 1e-12, "{quick:?}");
    }

    #[test]
    fn faces_get_samples_by_area_and_all_of_them_evenly() {
        let positions = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [10.0, 0.0], [13.0, 0.0], [10.0, 3.0], [5.0, 0.0]];
        let positions = positions.map(|[x, y]| [x, y, 0.0]).to_vec();
        let mesh = TriMesh::new(positions, vec![[0, 1, 2], [0, 1, 6], [3, 4, 5]]).unwrap();
        for seed in 0..4 {
            let samples = curve_samples(&mesh, &[0, 1, 2], 1000, seed);
            let on = |place| samples.iter().filter(|sample| sample.place == place).count();
            assert_eq!([on(0), on(1), on(2)], [100, 0, 900]);
            let mean = samples.iter().filter(|sample| sample.place == 2).map(|s| s.point).sum::<DVec3>() / 900.0;
            assert!(mean.distance(DVec3::new(11.0, 1.0, 0.0)) < 0.02, "{mean}");
        }
        let flat = TriMesh::new(vec![[1.0; 3]; 4], vec![[0, 1, 2], [1, 2, 3]]).unwrap();
        assert_eq!(curve_samples(&flat, &[0, 1], 10, 0).iter().filter(|sample| sample.place == 1).count(), 5);
    }

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
    fn large_faces_across_each_other_get_fewer_samples() {
        let sphere = shapes::icosphere(5);
        let [across, moved] = faces_across(&sphere, 4000, [2711, 5000, 5279, 2000]);
        let quick = quick_distance(&across, &moved, 100_000, 0).unwrap();
        assert!((64..50_000).contains(&quick.n_samples), "{quick:?}");
        assert!(quick.mean > 0.0 && quick.max <= 0.0101, "{quick:?}");
        assert_eq!(quick_distance(&sphere, &shapes::icosphere(2), 100_000, 0).unwrap().n_samples, 100_000);
    }
}
