//! [`quick_distance`](super::quick_distance) for an original that is read block by block.

use glam::{DVec3, Vec3};

use super::quick_distance::{
    MAX_TESTS, QuickDistance, curve_samples, face_tree, one_way_distance, surface_area, vertex_point,
};
use crate::mesh::TriMesh;
use crate::spatial::{Bounds, FaceTree};

const MIN_SAMPLES: usize = 512;

/// The distance between a simplified mesh and an original with one block in memory at a time.
///
/// Call `measure` and `add` for every block, then `measure_again` and `add` for those that [`Self::may_hold_nearer`]
/// accepts.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::{StreamedDistance, quick_distance}};
/// let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(2));
/// let mut distance = StreamedDistance::new(&coarse, [2000, 1], 0).unwrap();
/// let piece = distance.measure(&fine);
/// distance.add(piece);
/// let (whole, pieces) = (quick_distance(&fine, &coarse, 2000, 0).unwrap(), distance.finish());
/// assert!((pieces.mean / whole.mean - 1.0).abs() < 1e-3 && pieces.max <= 1.001 * whole.max);
/// ```
pub struct StreamedDistance<'a> {
    simplified: &'a TriMesh,
    tree: FaceTree<'a>,
    points: Vec<DVec3>,
    n_samples: usize,
    samples_per_block: usize,
    seed: u64,
    /// Squared distance of each point of the simplified mesh to the blocks so far.
    nearest2: Vec<f64>,
    /// Squared distance to a block's box within which points are measured in the first round.
    near2: f64,
    bounds: Bounds,
    /// Area of the blocks so far; `sum` is the area-weighted sum of their mean distances.
    area: f64,
    sum: f64,
    max: f64,
}

/// The distances from and to one block of the original.
pub struct BlockDistances {
    bounds: Bounds,
    /// Area, mean and largest distance.
    forward: Option<[f64; 3]>,
    /// Points of the simplified mesh that are closer to this block than to earlier ones, and their squared distances.
    nearer: Vec<(usize, f64)>,
}

impl BlockDistances {
    /// Returns the block's bounding box.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}

impl<'a> StreamedDistance<'a> {
    /// Prepares to measure about `n_pieces` blocks, with `n_samples` per surface; `None` without faces or samples.
    pub fn new(simplified: &'a TriMesh, [n_samples, n_pieces]: [usize; 2], seed: u64) -> Option<Self> {
        if simplified.faces().is_empty() || n_samples == 0 {
            return None;
        }
        let tree = face_tree(simplified);
        let samples = curve_samples(simplified, tree.order(), n_samples, seed).into_iter().map(|sample| sample.point);
        let vertices = (0..simplified.positions().len() as u32).map(|v| vertex_point(simplified, v));
        let points: Vec<DVec3> = samples.chain(vertices).collect();
        Some(Self {
            nearest2: vec![f64::INFINITY; points.len()],
            near2: surface_area(simplified) / simplified.faces().len() as f64,
            samples_per_block: n_samples.div_ceil(n_pieces.max(1)).max(MIN_SAMPLES),
            bounds: Bounds::EMPTY,
            area: 0.0,
            sum: 0.0,
            max: 0.0,
            simplified,
            tree,
            points,
            n_samples,
            seed,
        })
    }

    /// Measures the distances from and to a block with faces.
    pub fn measure(&self, piece: &TriMesh) -> BlockDistances {
        let (own, bounds) = (face_tree(piece), Bounds::from_points(piece.positions()));
        let (meshes, trees) = ([piece, self.simplified], [&own, &self.tree]);
        let forward = one_way_distance(meshes, trees, self.samples_per_block, self.seed);
        let (mean, max) = (forward.mean, forward.max());
        let max = forward.raise_max(meshes, trees, max, MAX_TESTS);
        let nearer = self.find_nearer(&own, |i| distance2(&bounds, self.points[i]) <= self.near2);
        BlockDistances { bounds, forward: Some([surface_area(piece), mean, max]), nearer }
    }

    /// Returns whether a block must be measured again; call this after adding all blocks once.
    pub fn may_hold_nearer(&self, bounds: &Bounds) -> bool {
        (0..self.points.len()).any(|i| self.may_be_nearer(bounds, i))
    }

    /// Measures a block again, from the points that may be closest to it.
    pub fn measure_again(&self, piece: &TriMesh) -> BlockDistances {
        let bounds = Bounds::from_points(piece.positions());
        let nearer = self.find_nearer(&face_tree(piece), |i| self.may_be_nearer(&bounds, i));
        BlockDistances { bounds, forward: None, nearer }
    }

    /// Adds the distances of a block.
    pub fn add(&mut self, block: BlockDistances) {
        self.bounds = self.bounds.union(&block.bounds);
        if let Some([area, mean, max]) = block.forward {
            self.area += area;
            self.sum += area * mean;
            self.max = self.max.max(max);
        }
        for (i, distance2) in block.nearer {
            self.nearest2[i] = self.nearest2[i].min(distance2);
        }
    }

    /// Returns the distance between the simplified mesh and all added blocks.
    pub fn finish(self) -> QuickDistance {
        let samples = self.nearest2[..self.n_samples].iter();
        let backward = samples.map(|d2| d2.sqrt()).sum::<f64>() / self.n_samples as f64;
        let forward = if self.area > 0.0 { self.sum / self.area } else { 0.0 };
        let farthest = self.nearest2.iter().fold(0.0, |a: f64, b| a.max(*b)).sqrt();
        QuickDistance {
            mean: 0.5 * (forward + backward),
            max: self.max.max(farthest),
            diagonal: self.bounds.diagonal(),
            n_samples: self.n_samples,
        }
    }

    fn may_be_nearer(&self, bounds: &Bounds, i: usize) -> bool {
        let from_box = distance2(bounds, self.points[i]);
        self.near2 < from_box && from_box < self.nearest2[i]
    }

    fn find_nearer(&self, tree: &FaceTree, is_wanted: impl Fn(usize) -> bool) -> Vec<(usize, f64)> {
        let mut last = None;
        let mut nearest = |i: usize| {
            let (face, distance2) = tree.nearest_from(self.points[i], last)?;
            last = Some(face);
            (distance2 < self.nearest2[i]).then_some((i, distance2))
        };
        (0..self.points.len()).filter(|&i| is_wanted(i)).filter_map(&mut nearest).collect()
    }
}

fn distance2(bounds: &Bounds, p: DVec3) -> f64 {
    let [low, high] = [bounds.low, bounds.high].map(|corner| Vec3::from(corner).as_dvec3());
    p.distance_squared(p.clamp(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{compact, shapes};
    use crate::metrics::quick_distance;

    fn cut_along_x(mesh: &TriMesh, n: usize) -> Vec<TriMesh> {
        let mut faces = mesh.faces().to_vec();
        faces.sort_by(|a, b| mesh.positions()[a[0] as usize][0].total_cmp(&mesh.positions()[b[0] as usize][0]));
        let parts = faces.chunks(faces.len().div_ceil(n));
        parts.map(|faces| compact(mesh.positions(), faces.to_vec()).unwrap().0).collect()
    }

    fn stream_distance(original: &[TriMesh], simplified: &TriMesh) -> QuickDistance {
        let mut distance = StreamedDistance::new(simplified, [20_000, original.len()], 3).unwrap();
        let mut boxes = Vec::new();
        for piece in original {
            let block = distance.measure(piece);
            boxes.push(block.bounds());
            distance.add(block);
        }
        for (piece, bounds) in original.iter().zip(boxes) {
            if distance.may_hold_nearer(&bounds) {
                distance.add(distance.measure_again(piece));
            }
        }
        distance.finish()
    }

    #[test]
    fn in_blocks_it_is_as_far_as_whole() {
        let (fine, coarse) = (shapes::torus(96, 48, 1.0, 0.3), shapes::torus(16, 8, 1.0, 0.3));
        let moved = |x: f32| {
            let moved = coarse.positions().iter().map(|p| [p[0] + x, p[1], p[2]]).collect();
            TriMesh::new(moved, coarse.faces().to_vec()).unwrap()
        };
        // The last one is farther away than its edges are long, so it needs the second round.
        for simplified in [moved(0.0), moved(0.05), moved(3.0)] {
            let whole = quick_distance(&fine, &simplified, 20_000, 3).unwrap();
            for n in [1, 7, 40] {
                let found = stream_distance(&cut_along_x(&fine, n), &simplified);
                assert!((found.mean / whole.mean - 1.0).abs() < 2e-3, "{n}: {found:?} {whole:?}");
                assert!((0.98..1.0 + 1e-9).contains(&(found.max / whole.max)), "{n}: {found:?} {whole:?}");
                assert!((found.diagonal - whole.diagonal).abs() < 1e-6);
            }
        }
    }
}
