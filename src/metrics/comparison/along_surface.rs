//! Figures of the surface as seen from within: eigenpairs of the Laplacian, and distances along it.

use super::original::Intrinsic;
use super::{Figure, Original, figure};
use crate::mesh::TriMesh;
use crate::metrics::spectrum::{Carried, spectrum_error};
use crate::metrics::{Laplacian, Surface};

/// The original, the simplified mesh, and how values of the second come to the vertices of the first.
struct Pair<'a> {
    original: &'a Intrinsic,
    simplified: Intrinsic,
    carried: Carried,
    /// Eigenpairs to compare.
    n_pairs: usize,
    /// Places of the vertices from which distances are measured.
    sources: [u32; 2],
}

/// Errors of the eigenpairs (the paper's LE), of geodesic and of biharmonic distances.
pub fn figures(original: &Original, simplified: &TriMesh, surface: &Surface, n_asked: usize) -> [Figure; 5] {
    let pair = pair(original, simplified, surface, n_asked);
    let spectrum = pair.as_ref().and_then(|pair| {
        let (pairs, others) = (pair.original.pairs.as_ref()?, pair.simplified.pairs.as_ref()?);
        let area = pair.simplified.laplacian.mass.iter().sum();
        let mass = &pair.original.laplacian.mass;
        (pair.n_pairs > 0).then(|| spectrum_error(mass, pairs, others, &pair.carried, area, pair.n_pairs))
    });
    let functions = "mean squared error of the Laplacian's eigenfunctions, each of mean square 1 (the paper's LE)";
    let span = "share of the carried eigenfunctions outside of the span of the original's";
    let unit = "% of the largest";
    let geodesic = "mean error of the distances along the surface from one point";
    let biharmonic = "mean error of the biharmonic distances from one point";
    [
        figure("laplacian_functions", "", functions, spectrum.map(|error| error.functions)),
        figure("laplacian_span", "%", span, spectrum.map(|error| 100.0 * error.span)),
        figure("laplacian_values", "%", "mean error of the eigenvalues", spectrum.map(|error| 100.0 * error.values)),
        figure("geodesic_error", unit, geodesic, pair.as_ref().and_then(geodesic_error)),
        figure("biharmonic_error", unit, biharmonic, pair.as_ref().and_then(biharmonic_error)),
    ]
}

fn pair<'a>(original: &'a Original, simplified: &TriMesh, surface: &Surface, n_asked: usize) -> Option<Pair<'a>> {
    let first = original.intrinsic.as_ref()?;
    let n_pairs = original.eigenpairs(n_asked);
    let second = Intrinsic::new(simplified, &original.judging, 4 * n_pairs)?;
    let carried = Carried::new(&first.points, simplified, &second.laplacian, surface)?;
    // Both begin at about the same place: the vertex of the simplified mesh decides, as there are fewer.
    let source = second.nearest(original.source(&first.points));
    let sources = [first.nearest(second.points[source as usize]), source];
    Some(Pair { original: first, simplified: second, carried, n_pairs, sources })
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
    error_percent(pair, &distances, &within_piece(others, &pair.simplified.laplacian, pair.sources[1]))
}

/// Distances from a source, infinite on other pieces, where eigenfunctions say nothing of it.
fn within_piece(distances: Vec<f64>, laplacian: &Laplacian, source: u32) -> Vec<f64> {
    let here = laplacian.piece[source as usize];
    let reached = |(distance, &piece): (f64, &u32)| if piece == here { distance } else { f64::INFINITY };
    distances.into_iter().zip(&laplacian.piece).map(reached).collect()
}

/// Mean over the area of the piece that the source is in, in percent of the largest distance there; what cannot be
/// reached on the simplified mesh is as wrong as can be.
fn error_percent(pair: &Pair, distances: &[f64], on_simplified: &[f64]) -> Option<f64> {
    let Laplacian { mass, piece, .. } = &pair.original.laplacian;
    let carried = pair.carried.values(on_simplified);
    let here: Vec<usize> = (0..mass.len()).filter(|&i| piece[i] == piece[pair.sources[0] as usize]).collect();
    let largest = here.iter().map(|&i| distances[i]).fold(0.0, f64::max);
    let error = |&i: &usize| mass[i] * (carried[i] - distances[i]).abs().min(largest);
    let area: f64 = here.iter().map(|&i| mass[i]).sum();
    (largest > 0.0).then(|| 100.0 * here.iter().map(error).sum::<f64>() / area / largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn what_is_broken_off_is_infinitely_far() {
        let sphere = shapes::icosphere(1);
        let n = sphere.positions().len();
        let far = sphere.positions().iter().map(|p| [p[0] + 5.0, p[1], p[2]]);
        let positions = sphere.positions().iter().copied().chain(far).collect();
        let faces = sphere.faces().iter().copied();
        let faces = faces.clone().chain(faces.map(|face| face.map(|v| v + n as u32))).collect();
        let laplacian = Laplacian::new(&TriMesh::new(positions, faces).unwrap()).unwrap();
        let distances = within_piece(vec![1.0; 2 * n], &laplacian, 0);
        assert_eq!(distances.iter().filter(|distance| distance.is_infinite()).count(), n);
    }
}
