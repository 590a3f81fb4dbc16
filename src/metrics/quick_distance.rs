//! How far two meshes are apart, for a program that has just made one of the other: fewer figures than
//! [`surface_distance`](super::surface_distance) has, at a fraction of its time.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::triangle::area_normal_f64;
use crate::linalg::{Isa, Work};
use crate::mesh::TriMesh;
use crate::spatial::FaceTree;

use super::allowance::affordable;
use super::certified_distance::largest_from_faces;

/// Samples per rayon task; sums are taken task by task in order, so they do not depend on threads.
const CHUNK: usize = 256;
/// A point may lead to the farthest one where it is at least this share as far as the farthest so far.
const FAR: f64 = 0.7;
/// Points in whose surroundings the largest distance is looked for: those that are the farthest.
const FARTHEST: usize = 16;
/// Faces before and after that of a point, along the curve, that are its surroundings.
const AROUND: usize = 4;
/// The search there ends when nothing is farther by more than this share, or after so many triangles were looked at.
const GAP: f64 = 0.02;
const AROUND_TESTS: u64 = 40_000;
/// Triangles and boxes that are looked at for samples in one direction, for spots, and around the farthest, however few the points; and for
/// each of these. Points are left out where it takes more: large faces that lie across each other are looked at by thousands.
const MOST_LOOKS: f64 = 1e7;
const USUAL_LOOKS: f64 = 100.0;
/// Faces whose areas one task finds.
const AREAS_CHUNK: usize = 4096;
/// What a sample is farther than the one before in its strip and across its face, as a share of both: multiples of these two,
/// taken modulo one, fill a square evenly (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
const EVENLY: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// Two-sided distance between two surfaces, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct QuickDistance {
    /// Mean of the mean distances in both directions.
    pub mean: f64,
    /// Largest distance found in either direction, at most the true one: of the samples, all vertices, and all points around the
    /// farthest of them.
    pub max: f64,
    /// Diagonal of the original's bounding box.
    pub diagonal: f64,
    /// Samples behind the mean, on the surface that has fewer: as many as were asked for, but where large faces lie across each
    /// other so that the search for the nearest one takes long.
    pub n_samples: usize,
}

/// Measures the distance from so many samples on each surface; `None` where one of the two has no faces, or for no samples.
///
/// Each surface is cut into as many strips of equal area along a space-filling curve, with a sample in each. Other seeds have other
/// samples.
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
        || one_sided([original, simplified], [&original_tree, &simplified_tree], n_samples, seed),
        || one_sided([simplified, original], [&simplified_tree, &original_tree], n_samples, seed),
    );
    Some(QuickDistance {
        mean: 0.5 * (forward.mean + backward.mean),
        max: forward.max.max(backward.max),
        diagonal: original_tree.diagonal(),
        n_samples: forward.n_samples.min(backward.n_samples),
    })
}

/// The point of either surface that is farthest from the other, of all vertices and so many samples on each; `None` where one of the
/// two has no faces.
///
/// ```
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
    let (own, other) = rayon::join(|| tree(original), || tree(simplified));
    let forward = farthest(original, &own, &other, n_samples);
    let backward = farthest(simplified, &other, &own, n_samples);
    let farthest = if backward.1 > forward.1 { backward } else { forward };
    Some(farthest.0.to_array())
}

/// The point of a mesh that is farthest from another, and the square of how far; of as many as can be looked up in a while.
fn farthest(mesh: &TriMesh, own: &FaceTree, other: &FaceTree, n_samples: usize) -> (DVec3, f64) {
    let vertices = mesh.positions().iter().map(|p| DVec3::from(p.map(f64::from)));
    let points: Vec<DVec3> =
        along_curve(mesh, own.order(), n_samples, 0).iter().map(|sample| sample.point).chain(vertices).collect();
    let look = |point: DVec3| other.near_counted(point, None, f64::NEG_INFINITY);
    let most = MOST_LOOKS.max(USUAL_LOOKS * points.len() as f64);
    let n = affordable(points.len(), most, |i| look(points[i]).map_or(0, |found| found.2.all()));
    let far = |i: usize| {
        let point = points[i * points.len() / n];
        (point, look(point).map_or(0.0, |found| found.1))
    };
    let farther = |x: (DVec3, f64), y: (DVec3, f64)| if y.1 > x.1 { y } else { x };
    (0..n).into_par_iter().map(far).collect::<Vec<_>>().into_iter().fold((DVec3::ZERO, -1.0), farther)
}

/// The area of all faces.
pub(super) fn area(mesh: &TriMesh) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.positions()[v as usize].map(f64::from));
    mesh.faces().iter().map(|face| 0.5 * area_normal_f64(face.map(corner)).length()).sum()
}

pub(super) fn tree(mesh: &TriMesh) -> FaceTree<'_> {
    FaceTree::new(mesh.positions(), mesh.faces())
}

/// What was found from one mesh to another.
pub(super) struct OneSided {
    pub mean: f64,
    pub max: f64,
    n_samples: usize,
}

/// From one mesh to another; the trees are those of the mesh and of the other.
pub(super) fn one_sided(meshes: [&TriMesh; 2], [own, other]: [&FaceTree; 2], n_samples: usize, seed: u64) -> OneSided {
    let mesh = meshes[0];
    let draw = |n| along_curve(mesh, own.order(), n, seed);
    let samples = draw(n_samples);
    let looks = |point: DVec3, enough| other.near_counted(point, None, enough).map_or(0, |found| found.2.all());
    let most = |n: usize| MOST_LOOKS.max(USUAL_LOOKS * n as f64);
    let n_affordable = affordable(n_samples, most(n_samples), |i| looks(samples[i].point, f64::NEG_INFINITY));
    let samples = if n_affordable < n_samples { draw(n_affordable) } else { samples };
    let in_a_row = |samples: &[Sample]| Isa::best().run(InARow { samples, tree: other });
    let mut found: Vec<Found> = samples.par_chunks(CHUNK).flat_map_iter(in_a_row).collect();
    let mean = found.iter().map(|found| found.distance2.sqrt()).sum::<f64>() / samples.len() as f64;
    let far = FAR * FAR * largest(&found);
    let mut spots = spots(meshes, own.order());
    let n_affordable = affordable(spots.len(), most(spots.len()), |i| looks(spots[i].point(mesh, own.order()), far));
    if n_affordable < spots.len() {
        spots = (0..n_affordable).map(|i| spots[i * spots.len() / n_affordable]).collect();
    }
    let sweep = |spots: &[Spot]| Isa::best().run(Sweep { mesh, order: own.order(), spots, tree: other, far });
    found.par_extend(spots.par_chunks(CHUNK).flat_map_iter(sweep));
    let largest = largest(&found).sqrt();
    let faces = around_the_farthest(found, own.order());
    let max = largest_from_faces(meshes, &faces, other, [largest, GAP], AROUND_TESTS);
    OneSided { mean, max, n_samples: samples.len() }
}

/// The largest squared distance.
fn largest(found: &[Found]) -> f64 {
    found.iter().map(|found| found.distance2).fold(0.0, f64::max)
}

/// The faces around the points that are the farthest, each once.
fn around_the_farthest(mut found: Vec<Found>, order: &[u32]) -> Vec<u32> {
    let by_distance = |a: &Found, b: &Found| b.distance2.total_cmp(&a.distance2).then(a.place.cmp(&b.place));
    if found.len() > FARTHEST {
        found.select_nth_unstable_by(FARTHEST - 1, by_distance);
        found.truncate(FARTHEST);
    }
    let around = |place: usize| place.saturating_sub(AROUND)..order.len().min(place + AROUND + 1);
    let mut places: Vec<usize> = found.iter().flat_map(|found| around(found.place)).collect();
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|place| order[place]).collect()
}

/// Where a distance is looked at besides the samples: the place of a face along the curve, and which corner of it, or, from three
/// on, the middle of which side.
#[derive(Clone, Copy)]
struct Spot {
    place: u32,
    at: u32,
}

impl Spot {
    #[inline(always)]
    fn point(self, mesh: &TriMesh, order: &[u32]) -> DVec3 {
        let corners = corners(mesh, order[self.place as usize]);
        let k = self.at as usize % 3;
        if self.at < 3 { corners[k] } else { 0.5 * (corners[k] + corners[(k + 1) % 3]) }
    }
}

/// All vertices in the order of the faces along the curve, and the middles of the edges of the mesh with fewer faces: those cut
/// across what bulges and bends.
fn spots([mesh, other]: [&TriMesh; 2], order: &[u32]) -> Vec<Spot> {
    let with_middles = mesh.faces().len() <= other.faces().len();
    let mut is_seen = vec![false; mesh.positions().len()];
    let mut spots = Vec::with_capacity(is_seen.len());
    for (place, &face) in (0..).zip(order) {
        let corners = mesh.faces()[face as usize];
        for at in 0..3 {
            let [v, next] = [corners[at], corners[(at + 1) % 3]];
            if !std::mem::replace(&mut is_seen[v as usize], true) {
                spots.push(Spot { place, at: at as u32 });
            }
            if with_middles && v < next {
                spots.push(Spot { place, at: at as u32 + 3 });
            }
        }
    }
    spots
}

/// A point of a surface and the place of its face along the curve.
pub(super) struct Sample {
    pub point: DVec3,
    place: usize,
}

/// Samples by area, in the order of the faces along the curve: what is nearest to one is near the next one. Where no face has an
/// area, by face.
pub(super) fn along_curve(mesh: &TriMesh, order: &[u32], n_samples: usize, seed: u64) -> Vec<Sample> {
    let mut areas: Vec<f64> = vec![0.0; order.len()];
    let tasks = areas.par_chunks_mut(AREAS_CHUNK).zip(order.par_chunks(AREAS_CHUNK));
    tasks.for_each(|(areas, faces)| Isa::best().run(Areas { mesh, faces, areas }));
    let mut total: f64 = areas.iter().sum();
    if total <= 0.0 {
        areas.fill(1.0);
        total = areas.len() as f64;
    }
    let (mut place, mut before) = (0, 0.0);
    let draw = |i: usize| {
        let [along, across] = EVENLY.map(|step| ((seed as f64 + 0.5) * 0.618 + i as f64 * step).fract());
        let reach = (i as f64 + along) / n_samples as f64 * total;
        while place + 1 < areas.len() && before + areas[place] <= reach {
            before += areas[place];
            place += 1;
        }
        let within = ((reach - before) / areas[place]).clamp(0.0, 1.0);
        Sample { point: point_within(corners(mesh, order[place]), [within, across]), place }
    };
    (0..n_samples).map(draw).collect()
}

/// Where two numbers in 0..=1 lie in a triangle; evenly spread ones are evenly spread there.
fn point_within([a, b, c]: [DVec3; 3], [x, y]: [f64; 2]) -> DVec3 {
    let root = if x > 0.0 { x.sqrt() } else { 0.0 };
    a * (1.0 - root) + b * (root * (1.0 - y)) + c * (root * y)
}

#[inline(always)]
fn corners(mesh: &TriMesh, face: u32) -> [DVec3; 3] {
    let [a, b, c] = mesh.faces()[face as usize];
    [point(mesh, a), point(mesh, b), point(mesh, c)]
}

#[inline(always)]
pub(super) fn point(mesh: &TriMesh, vertex: u32) -> DVec3 {
    let [x, y, z] = mesh.positions()[vertex as usize];
    DVec3::new(x.into(), y.into(), z.into())
}

/// The doubled areas of faces.
struct Areas<'a> {
    mesh: &'a TriMesh,
    faces: &'a [u32],
    areas: &'a mut [f64],
}

impl Work for Areas<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (area, &face) in self.areas.iter_mut().zip(self.faces) {
            *area = area_normal_f64(corners(self.mesh, face)).length();
        }
    }
}

/// How far a point is (squared), and the place of its face along the curve.
struct Found {
    place: usize,
    distance2: f64,
}

/// What lies nearest to samples in a row, as work that is compiled for the instructions at hand.
struct InARow<'a> {
    samples: &'a [Sample],
    tree: &'a FaceTree<'a>,
}

impl Work for InARow<'_> {
    type Output = Vec<Found>;

    #[inline(always)]
    fn run(self) -> Vec<Found> {
        let mut row = Vec::with_capacity(self.samples.len());
        let mut last = None;
        for sample in self.samples {
            let (face, distance2) = self.tree.nearest_from(sample.point, last).unwrap_or_default();
            last = Some(face);
            row.push(Found { place: sample.place, distance2 });
        }
        row
    }
}

/// The spots that are farther than `far` (squared).
struct Sweep<'a> {
    mesh: &'a TriMesh,
    order: &'a [u32],
    spots: &'a [Spot],
    tree: &'a FaceTree<'a>,
    far: f64,
}

impl Work for Sweep<'_> {
    type Output = Vec<Found>;

    #[inline(always)]
    fn run(self) -> Vec<Found> {
        let (mut farther, mut last) = (Vec::new(), None);
        for spot in self.spots {
            let (p, place) = (spot.point(self.mesh, self.order), spot.place as usize);
            let (face, distance2) = self.tree.near_from(p, last, self.far).unwrap_or_default();
            last = Some(face);
            if distance2 > self.far {
                farther.push(Found { place, distance2 });
            }
        }
        farther
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::nearest_on_triangle::nearest_weights_f64;
    use crate::mesh::shapes;
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

    /// Distances by searching all faces, from the same samples.
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
            let samples = along_curve(from, tree(from).order(), 500, 3);
            samples.iter().map(|sample| naive(sample.point, to)).sum::<f64>() / 500.0
        };
        let quick = quick_distance(&a, &b, 500, 3).unwrap();
        assert!((quick.mean - 0.5 * (mean(&a, &b) + mean(&b, &a))).abs() < 1e-12, "{quick:?}");
    }

    /// Two triangles, the second nine times as large, and one without area between them.
    #[test]
    fn faces_get_samples_by_area_and_all_of_them_evenly() {
        let positions = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [10.0, 0.0], [13.0, 0.0], [10.0, 3.0], [5.0, 0.0]];
        let positions = positions.map(|[x, y]| [x, y, 0.0]).to_vec();
        let mesh = TriMesh::new(positions, vec![[0, 1, 2], [0, 1, 6], [3, 4, 5]]).unwrap();
        for seed in 0..4 {
            let samples = along_curve(&mesh, &[0, 1, 2], 1000, seed);
            let on = |place| samples.iter().filter(|sample| sample.place == place).count();
            assert_eq!([on(0), on(1), on(2)], [100, 0, 900]);
            let mean = samples.iter().filter(|sample| sample.place == 2).map(|s| s.point).sum::<DVec3>() / 900.0;
            assert!(mean.distance(DVec3::new(11.0, 1.0, 0.0)) < 0.02, "{mean}");
        }
        let flat = TriMesh::new(vec![[1.0; 3]; 4], vec![[0, 1, 2], [1, 2, 3]]).unwrap();
        assert_eq!(along_curve(&flat, &[0, 1], 10, 0).iter().filter(|sample| sample.place == 1).count(), 5);
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

    /// Each search looks at a good part of all faces: there are fewer, and what they say holds.
    #[test]
    fn large_faces_across_each_other_get_fewer_samples() {
        let (sphere, n) = (shapes::icosphere(5), 10_242);
        let faces = (0..4000).map(|i| [i, (i * 2711 + 5000) % n, (i * 5279 + 2000) % n]);
        let faces: Vec<[u32; 3]> = faces.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
        let across = TriMesh::new(sphere.positions().to_vec(), faces).unwrap();
        let moved = across.positions().iter().map(|p| [p[0] + 0.01, p[1], p[2]]).collect();
        let moved = TriMesh::new(moved, across.faces().to_vec()).unwrap();
        let quick = quick_distance(&across, &moved, 100_000, 0).unwrap();
        assert!((64..50_000).contains(&quick.n_samples), "{quick:?}");
        assert!(quick.mean > 0.0 && quick.max <= 0.0101, "{quick:?}");
        assert_eq!(quick_distance(&sphere, &shapes::icosphere(2), 100_000, 0).unwrap().n_samples, 100_000);
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
