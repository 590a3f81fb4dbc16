//! As [`quick_distance`](super::quick_distance), where the original comes piece by piece and is never there as a whole.

use glam::DVec3;

use super::quick_distance::{OneSided, QuickDistance, along_curve, area, one_sided, point, tree};
use crate::mesh::TriMesh;
use crate::spatial::{Bounds, FaceTree};

/// Samples of a piece at least: with fewer, few of its vertices can be passed over as nearer than the farthest.
const LEAST: usize = 512;

/// The distance between a simplified mesh and pieces of its original, as far as they were shown.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::{DistanceInPieces, quick_distance}};
/// let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(2));
/// let mut distance = DistanceInPieces::new(&coarse, [2000, 1], 0).unwrap();
/// let piece = distance.look(&fine);
/// distance.add(piece);
/// let (whole, pieces) = (quick_distance(&fine, &coarse, 2000, 0).unwrap(), distance.finish());
/// assert!((pieces.mean / whole.mean - 1.0).abs() < 1e-3 && pieces.max <= 1.001 * whole.max);
/// ```
pub struct DistanceInPieces<'a> {
    simplified: &'a TriMesh,
    tree: FaceTree<'a>,
    /// Samples of the simplified mesh, and behind them its vertices.
    points: Vec<DVec3>,
    n_samples: usize,
    n_of_piece: usize,
    seed: u64,
    /// Squared distance of each of the points to the nearest face that was shown.
    nearest2: Vec<f64>,
    /// Points as near as this to the box of a piece are looked up in it at once, squared.
    near2: f64,
    bounds: Bounds,
    /// The area that was shown, and the mean distance from there times that area.
    area: f64,
    sum: f64,
    max: f64,
}

/// What a piece of the original says.
pub struct Look {
    bounds: Bounds,
    /// The area, and what was found from there; nothing of a piece that is shown again.
    forward: Option<(f64, OneSided)>,
    /// Points for which something nearer was found, and the square of how far.
    nearer: Vec<(usize, f64)>,
}

impl Look {
    /// The box of the piece.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}

impl<'a> DistanceInPieces<'a> {
    /// Nothing is shown yet of an original of about so many pieces; `None` where there are no faces or no samples are asked for.
    pub fn new(simplified: &'a TriMesh, [n_samples, n_pieces]: [usize; 2], seed: u64) -> Option<Self> {
        if simplified.faces().is_empty() || n_samples == 0 {
            return None;
        }
        let tree = tree(simplified);
        let samples = along_curve(simplified, tree.order(), n_samples, seed).into_iter().map(|sample| sample.point);
        let vertices = (0..simplified.positions().len() as u32).map(|v| point(simplified, v));
        let points: Vec<DVec3> = samples.chain(vertices).collect();
        Some(Self {
            nearest2: vec![f64::INFINITY; points.len()],
            near2: area(simplified) / simplified.faces().len() as f64,
            n_of_piece: n_samples.div_ceil(n_pieces.max(1)).max(LEAST),
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

    /// Measures a piece that has faces: from it, and from the points that are near to it.
    pub fn look(&self, piece: &TriMesh) -> Look {
        let (own, bounds) = (tree(piece), Bounds::of(piece.positions()));
        let forward = one_sided([piece, self.simplified], [&own, &self.tree], self.n_of_piece, self.seed);
        let nearer = self.nearer(&own, |i| distance2(&bounds, self.points[i]) <= self.near2);
        Look { bounds, forward: Some((area(piece), forward)), nearer }
    }

    /// Whether a piece has to be shown again, once all were: points that are not near to it may have nothing nearer elsewhere.
    pub fn is_open(&self, bounds: &Bounds) -> bool {
        (0..self.points.len()).any(|i| self.may_be_nearer(bounds, i))
    }

    /// Measures from those points to a piece that is shown again.
    pub fn look_again(&self, piece: &TriMesh) -> Look {
        let bounds = Bounds::of(piece.positions());
        let nearer = self.nearer(&tree(piece), |i| self.may_be_nearer(&bounds, i));
        Look { bounds, forward: None, nearer }
    }

    /// Takes in what a piece says.
    pub fn add(&mut self, look: Look) {
        self.bounds = self.bounds.union(&look.bounds);
        if let Some((area, forward)) = look.forward {
            self.area += area;
            self.sum += area * forward.mean;
            self.max = self.max.max(forward.max);
        }
        for (i, distance2) in look.nearer {
            self.nearest2[i] = self.nearest2[i].min(distance2);
        }
    }

    /// The distance from and to all that was shown.
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

    /// Those of the points that are wanted for which the faces under a tree are the nearest so far.
    fn nearer(&self, tree: &FaceTree, is_wanted: impl Fn(usize) -> bool) -> Vec<(usize, f64)> {
        let mut last = None;
        let mut nearest = |i: usize| {
            let (face, distance2) = tree.nearest_from(self.points[i], last)?;
            last = Some(face);
            (distance2 < self.nearest2[i]).then_some((i, distance2))
        };
        (0..self.points.len()).filter(|&i| is_wanted(i)).filter_map(&mut nearest).collect()
    }
}

/// How far a point lies outside a box, squared.
fn distance2(bounds: &Bounds, p: DVec3) -> f64 {
    let [low, high] = [bounds.low, bounds.high].map(|corner| DVec3::from(corner.map(f64::from)));
    p.distance_squared(p.clamp(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{compact, shapes};
    use crate::metrics::quick_distance;

    /// The faces of a mesh in so many pieces, by where they lie along x.
    fn pieces(mesh: &TriMesh, n: usize) -> Vec<TriMesh> {
        let mut faces = mesh.faces().to_vec();
        faces.sort_by(|a, b| mesh.positions()[a[0] as usize][0].total_cmp(&mesh.positions()[b[0] as usize][0]));
        let parts = faces.chunks(faces.len().div_ceil(n));
        parts.map(|faces| compact(mesh.positions(), faces.to_vec()).unwrap().0).collect()
    }

    fn in_pieces(original: &[TriMesh], simplified: &TriMesh) -> QuickDistance {
        let mut distance = DistanceInPieces::new(simplified, [20_000, original.len()], 3).unwrap();
        let mut boxes = Vec::new();
        for piece in original {
            let look = distance.look(piece);
            boxes.push(look.bounds());
            distance.add(look);
        }
        for (piece, bounds) in original.iter().zip(boxes) {
            if distance.is_open(&bounds) {
                distance.add(distance.look_again(piece));
            }
        }
        distance.finish()
    }

    #[test]
    fn in_pieces_it_is_as_far_as_whole() {
        let (fine, coarse) = (shapes::torus(96, 48, 1.0, 0.3), shapes::torus(16, 8, 1.0, 0.3));
        let moved = |x: f32| {
            let moved = coarse.positions().iter().map(|p| [p[0] + x, p[1], p[2]]).collect();
            TriMesh::new(moved, coarse.faces().to_vec()).unwrap()
        };
        // The last is farther off than its edges are long, so that pieces have to be shown again.
        for simplified in [moved(0.0), moved(0.05), moved(3.0)] {
            let whole = quick_distance(&fine, &simplified, 20_000, 3).unwrap();
            for n in [1, 7, 40] {
                let found = in_pieces(&pieces(&fine, n), &simplified);
                assert!((found.mean / whole.mean - 1.0).abs() < 2e-3, "{n}: {found:?} {whole:?}");
                assert!((0.98..1.0 + 1e-9).contains(&(found.max / whole.max)), "{n}: {found:?} {whole:?}");
                assert!((found.diagonal - whole.diagonal).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn nothing_has_no_distance() {
        assert!(DistanceInPieces::new(&TriMesh::default(), [10, 1], 0).is_none());
        assert!(DistanceInPieces::new(&shapes::icosphere(0), [0, 1], 0).is_none());
    }
}
