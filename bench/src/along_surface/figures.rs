//! Errors of eigenpairs and of distances along the surface.

use glam::DVec3;

use super::laplacian::Laplacian;
use super::spectrum::{Eigenpairs, HeatMethod, ValueTransfer, spectrum_error};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Figure, closest_point_tree};

pub struct IntrinsicFigures {
    original: Option<IntrinsicSurface>,
    // Point where distances start: the one farthest from the centre of the original's box.
    source: DVec3,
}

/// A surface with its Laplacian, eigenpairs and geodesic solver.
struct IntrinsicSurface {
    laplacian: Laplacian,
    points: Vec<DVec3>,
    heat: Option<HeatMethod>,
    pairs: Option<Eigenpairs>,
}

struct Pair<'a> {
    original: &'a IntrinsicSurface,
    simplified: IntrinsicSurface,
    transfer: ValueTransfer,
    n_pairs: usize,
    sources: [u32; 2],
}

impl IntrinsicFigures {
    /// Prepares an original with at most `n_pairs` eigenpairs; without a number, no figure is measured.
    pub fn new(mesh: &TriMesh, n_pairs: Option<usize>, n_vertices: usize) -> Self {
        let original = n_pairs.and_then(|n_pairs| IntrinsicSurface::new(mesh, n_pairs.min(n_vertices / 4)));
        let source = original.as_ref().map(|original| farthest_from_centre(&original.points)).unwrap_or_default();
        Self { original, source }
    }

    /// Returns the number of eigenpairs compared at a target: at most a quarter of its vertices and of the original's.
    pub fn n_pairs(&self, n_target: usize) -> usize {
        let known = self.original.as_ref().and_then(|intrinsic| intrinsic.pairs.as_ref());
        known.map_or(0, |pairs| pairs.values.len().min(n_target / 4))
    }

    pub fn figures(&self, simplified: &TriMesh, n_target: usize) -> [Figure; 3] {
        let pair = self.make_pair(simplified, n_target);
        let spectrum = pair.as_ref().and_then(|pair| {
            let (pairs, others) = (pair.original.pairs.as_ref()?, pair.simplified.pairs.as_ref()?);
            let area = pair.simplified.laplacian.mass.iter().sum();
            let mass = &pair.original.laplacian.mass;
            (pair.n_pairs > 0).then(|| spectrum_error(mass, pairs, others, &pair.transfer, area, pair.n_pairs))
        });
        let functions = "mean squared error of the Laplacian's eigenfunctions, each of mean square 1 (the paper's LE)";
        let unit = "% of the largest";
        let geodesic = "mean error of the distances along the surface from one point";
        let biharmonic = "mean error of the biharmonic distances from one point";
        [
            Figure::new("laplacian_functions", "", functions, spectrum),
            Figure::new("geodesic_error", unit, geodesic, pair.as_ref().and_then(geodesic_error)),
            Figure::new("biharmonic_error", unit, biharmonic, pair.as_ref().and_then(biharmonic_error)),
        ]
    }

    fn make_pair(&self, simplified: &TriMesh, n_target: usize) -> Option<Pair<'_>> {
        let first = self.original.as_ref()?;
        let n_pairs = self.n_pairs(n_target);
        let second = IntrinsicSurface::new(simplified, n_pairs)?;
        let transfer =
            ValueTransfer::new(&first.points, simplified, &second.laplacian, &closest_point_tree(simplified))?;
        // Distances start at the simplified mesh's vertex nearest to the source, because its vertices are sparser.
        let source = second.nearest(self.source);
        let sources = [first.nearest(second.points[source as usize]), source];
        Some(Pair { original: first, simplified: second, transfer, n_pairs, sources })
    }
}

impl IntrinsicSurface {
    fn new(mesh: &TriMesh, n_pairs: usize) -> Option<Self> {
        let laplacian = Laplacian::new(mesh)?;
        let point = |&v: &u32| DVec3::from_array(mesh.positions()[v as usize].map(f64::from));
        Some(Self {
            points: laplacian.vertices.iter().map(point).collect(),
            heat: HeatMethod::new(&laplacian),
            pairs: if n_pairs > 0 { Eigenpairs::compute_lowest(&laplacian, n_pairs) } else { None },
            laplacian,
        })
    }

    fn nearest(&self, p: DVec3) -> u32 {
        let distance = |&i: &u32| self.points[i as usize].distance_squared(p);
        (0..self.points.len() as u32).min_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(0)
    }
}

fn farthest_from_centre(points: &[DVec3]) -> DVec3 {
    let [low, high] = [DVec3::min, DVec3::max].map(|end| points.iter().copied().reduce(end).unwrap_or_default());
    let distance = |p: &DVec3| p.distance(low.midpoint(high));
    points.iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or_default()
}

fn geodesic_error(pair: &Pair) -> Option<f64> {
    let (heat, other) = (pair.original.heat.as_ref()?, pair.simplified.heat.as_ref()?);
    let distances = heat.distances(&pair.original.laplacian, pair.sources[0]);
    let others = other.distances(&pair.simplified.laplacian, pair.sources[1]);
    error_percent(pair, &distances, &others)
}

fn biharmonic_error(pair: &Pair) -> Option<f64> {
    let (pairs, others) = (pair.original.pairs.as_ref()?, pair.simplified.pairs.as_ref()?);
    let n_pairs = pair.n_pairs.min(others.values.len());
    let distances = pairs.biharmonic_distances(pair.sources[0], n_pairs);
    let others = others.biharmonic_distances(pair.sources[1], n_pairs);
    error_percent(pair, &distances, &mask_other_components(others, &pair.simplified.laplacian, pair.sources[1]))
}

fn mask_other_components(distances: Vec<f64>, laplacian: &Laplacian, source: u32) -> Vec<f64> {
    let here = laplacian.component[source as usize];
    let reached = |(distance, &component): (f64, &u32)| if component == here { distance } else { f64::INFINITY };
    distances.into_iter().zip(&laplacian.component).map(reached).collect()
}

fn error_percent(pair: &Pair, distances: &[f64], on_simplified: &[f64]) -> Option<f64> {
    let Laplacian { mass, component, .. } = &pair.original.laplacian;
    let transferred = pair.transfer.values(on_simplified);
    let here: Vec<usize> = (0..mass.len()).filter(|&i| component[i] == component[pair.sources[0] as usize]).collect();
    let largest = here.iter().map(|&i| distances[i]).fold(0.0, f64::max);
    // An unreachable point has an infinite distance; its error counts as the largest distance.
    let error = |&i: &usize| mass[i] * (transferred[i] - distances[i]).abs().min(largest);
    let area: f64 = here.iter().map(|&i| mass[i]).sum();
    (largest > 0.0).then(|| 100.0 * here.iter().map(error).sum::<f64>() / area / largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn other_components_are_infinitely_far() {
        let sphere = shapes::icosphere(1);
        let n = sphere.positions().len();
        let both = shapes::unite([&sphere, &shapes::place(&sphere, |[x, y, z]| [x + 5.0, y, z])]);
        let laplacian = Laplacian::new(&both).unwrap();
        let distances = mask_other_components(vec![1.0; 2 * n], &laplacian, 0);
        assert_eq!(distances.iter().filter(|distance| distance.is_infinite()).count(), n);
    }
}
