//! Overall objective, Eq. (10), and its terms over candidate faces.

use super::conflicts::near_in_space;
use super::{
    NearTriangles, OverlapSettings, ReverseDistances, Term, closure, collisions, conflicts_by_count, conflicts_by_pair,
    coverage, edge_crossings, forward_distance, forward_distances, near_triangles, overlaps, quotient_agreement,
    reverse_distance, reverse_distances,
};

/// A term of the objective with its name and weight.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTerm {
    /// Name in logs.
    pub name: &'static str,
    /// Factor lambda of the term.
    pub weight: f64,
    /// Value and gradient without the weight.
    pub term: Term,
}

/// Computes Eq. (10): the weighted sum of the terms, over the same `n` probabilities or scores.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{NamedTerm, Term, total};
/// let term = |value: f64, slope: f32| Term { value, gradient: vec![slope] };
/// let forward = NamedTerm { name: "forward", weight: 1.0, term: term(2.0, 1.0) };
/// let collision = NamedTerm { name: "collision", weight: 0.5, term: term(4.0, -1.0) };
/// assert_eq!(total(&[forward, collision], 1), term(4.0, 0.5));
/// ```
pub fn total(terms: &[NamedTerm], n: usize) -> Term {
    let mut gradient = vec![0.0f64; n];
    for NamedTerm { weight, term, .. } in terms {
        gradient.iter_mut().zip(&term.gradient).for_each(|(sum, &g)| *sum += weight * f64::from(g));
    }
    let value = terms.iter().map(|named| named.weight * named.term.value).sum();
    Term { value, gradient: gradient.into_iter().map(|g| g as f32).collect() }
}

/// Weights and settings of the terms over candidate faces; terms of weight 0 are not computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceObjective {
    /// Weight of the forward distance, Eq. (7).
    pub forward: f64,
    /// Weight of the reverse distance as printed, Eq. (8).
    pub reverse: f64,
    /// Weight of [`coverage`].
    pub coverage: f64,
    /// Weight of [`closure`].
    pub closure: f64,
    /// Weight of the collisions, Eq. (9).
    pub collision: f64,
    /// Weight of the edge crossings.
    pub crossing: f64,
    /// Weight of the overlaps.
    pub overlap: f64,
    /// Weight of [`quotient_agreement`].
    pub agreement: f64,
    /// True if conflicts are counted as printed in Eq. (9); otherwise pair by pair.
    pub by_count: bool,
    /// Number of test points per candidate, for Eq. (8) and the overlaps.
    pub per_triangle: usize,
    /// Number of nearest candidates per point, for Eq. (8) and the coverage, and per candidate, for the conflicts.
    pub n_near: usize,
    /// Largest distance at which edges cross or points overlap, relative to the edge or the root of the area.
    pub flatness: f64,
    /// Cost of a surface point without a kept face, in mean squared edge lengths.
    pub penalty: f64,
    /// Balance of the agreement: 0 weighs candidates equally, 1 the true and the false ones.
    pub balance: f64,
}

impl FaceObjective {
    /// Eq. (10) as printed, with all lambdas 1; its minimum is the empty mesh.
    pub const PRINTED: Self = Self {
        forward: 1.0,
        reverse: 1.0,
        coverage: 0.0,
        closure: 0.0,
        collision: 1.0,
        crossing: 1.0,
        overlap: 1.0,
        agreement: 0.0,
        by_count: true,
        per_triangle: 10,
        n_near: 20,
        flatness: 0.1,
        penalty: 1.0,
        balance: 0.5,
    };

    /// Terms and weights used in training.
    pub const TRAINED: Self =
        Self { reverse: 0.0, coverage: 1.0, closure: 1.0, agreement: 1.0, by_count: false, ..Self::PRINTED };
}

/// The candidate faces and the data of their terms.
#[derive(Clone, Copy, Debug)]
pub struct Candidates<'a> {
    /// Positions of the samples, n x 3.
    pub points: &'a [[f32; 3]],
    /// Corners of the candidates, n_triangles x 3.
    pub triangles: &'a [[u32; 3]],
    /// Edges of each triangle, n_triangles x 3.
    pub edges: &'a [[u32; 3]],
    /// True for edges that should have one face, n_edges.
    pub at_boundary: &'a [bool],
    /// True for triangles that the mesh spans between three regions, n_triangles.
    pub labels: &'a [bool],
    /// Barycenters of the original faces.
    pub original_barycenters: &'a [[f32; 3]],
    /// Points of the original surface.
    pub surface: &'a [[f32; 3]],
}

/// Measurements of the candidates that do not depend on probabilities.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceGeometry {
    /// Squared distances of Eq. (7), n_triangles.
    pub forward: Vec<f64>,
    /// Squared distances of Eq. (8).
    pub reverse: ReverseDistances,
    /// Triangles near each surface point, for the coverage.
    pub near: NearTriangles,
    /// Ordered pairs of colliding triangles.
    pub collisions: Vec<[u32; 2]>,
    /// Ordered pairs of triangles with crossing edges.
    pub crossings: Vec<[u32; 2]>,
    /// Ordered pairs of overlapping triangles.
    pub overlaps: Vec<[u32; 2]>,
    /// Mean squared edge of the candidates, the unit of squared distances.
    pub length2: f64,
}

/// Measures the candidates for all terms of non-zero weight.
pub fn face_geometry(candidates: &Candidates, objective: &FaceObjective) -> FaceGeometry {
    let Candidates { points, triangles, surface, original_barycenters, .. } = *candidates;
    let FaceObjective { per_triangle, n_near, flatness, .. } = *objective;
    // A term of weight 0 gets no triangles, so nothing is measured for it.
    let triangles_if = |weight: f64| if weight == 0.0 { &[] } else { triangles };
    let pairs_if = |weight: f64, find: &dyn Fn() -> Vec<[u32; 2]>| if weight == 0.0 { Vec::new() } else { find() };
    let settings = OverlapSettings { per_triangle, flatness };
    // Triangles with a common edge never collide, so conflicts are looked for among those near in space.
    let near =
        &near_in_space(points, triangles_if(objective.collision + objective.crossing + objective.overlap), n_near);
    FaceGeometry {
        forward: forward_distances(points, triangles_if(objective.forward), original_barycenters),
        reverse: reverse_distances(points, triangles_if(objective.reverse), surface, per_triangle, n_near),
        near: near_triangles(points, triangles_if(objective.coverage), surface, n_near),
        collisions: pairs_if(objective.collision, &|| collisions(points, triangles, near)),
        crossings: pairs_if(objective.crossing, &|| edge_crossings(points, triangles, near, flatness)),
        overlaps: pairs_if(objective.overlap, &|| overlaps(points, triangles, near, settings)),
        length2: mean_squared_edge(points, triangles),
    }
}

fn mean_squared_edge(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let edges = triangles.iter().flat_map(|&[i, j, k]| [[i, j], [j, k], [k, i]]);
    let squares = edges.map(|[i, j]| super::triangles::distance2(points[i as usize], points[j as usize]));
    let mean = squares.sum::<f64>() / (3 * triangles.len()).max(1) as f64;
    if mean > 0.0 { mean } else { 1.0 }
}

/// Computes the terms of non-zero weight, with squared lengths in units of the candidates' mean squared edge.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{Candidates, FaceObjective, face_geometry, face_terms, total};
/// let tetrahedron = Candidates {
///     points: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     triangles: &[[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]],
///     edges: &[[0, 1, 3], [0, 2, 4], [1, 2, 5], [3, 4, 5]],
///     at_boundary: &[false; 6],
///     labels: &[true; 4],
///     original_barycenters: &[[1.0 / 3.0; 3]],
///     surface: &[[1.0 / 3.0; 3]],
/// };
/// let geometry = face_geometry(&tetrahedron, &FaceObjective::TRAINED);
/// let loss = |p: f32| total(&face_terms(&tetrahedron, &geometry, &FaceObjective::TRAINED, &[p; 4]), 4);
/// assert!(loss(1.0).value < loss(0.0).value);
/// ```
pub fn face_terms(
    candidates: &Candidates,
    geometry: &FaceGeometry,
    objective: &FaceObjective,
    probabilities: &[f32],
) -> Vec<NamedTerm> {
    let p = probabilities;
    let area = 1.0 / geometry.length2;
    let conflicts = if objective.by_count { conflicts_by_count } else { conflicts_by_pair };
    let penalty = objective.penalty * geometry.length2;
    let mut terms = Vec::new();
    let mut add = |name, weight: f64, term: &dyn Fn() -> Term| {
        if weight != 0.0 {
            terms.push(NamedTerm { name, weight, term: term() });
        }
    };
    add("forward", objective.forward, &|| scale_term(forward_distance(&geometry.forward, p), area));
    add("reverse", objective.reverse, &|| scale_term(reverse_distance(&geometry.reverse, p), area));
    add("coverage", objective.coverage, &|| scale_term(coverage(&geometry.near, penalty, p), area));
    add("closure", objective.closure, &|| closure(candidates.edges, candidates.at_boundary, p));
    add("collision", objective.collision, &|| conflicts(&geometry.collisions, p));
    add("crossing", objective.crossing, &|| conflicts(&geometry.crossings, p));
    add("overlap", objective.overlap, &|| conflicts(&geometry.overlaps, p));
    add("agreement", objective.agreement, &|| quotient_agreement(candidates.labels, objective.balance, p));
    terms
}

fn scale_term(term: Term, by: f64) -> Term {
    let gradient = term.gradient.iter().map(|&g| (f64::from(g) * by) as f32).collect();
    Term { value: term.value * by, gradient }
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::*;
    use crate::linalg::test_values::run_on_threads;
    use std::collections::BTreeMap;

    struct Cube {
        points: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        edges: Vec<[u32; 3]>,
        labels: Vec<bool>,
        centers: Vec<[f32; 3]>,
    }

    const SURFACE: [[u32; 3]; 12] = [
        [0, 1, 2],
        [1, 2, 3],
        [4, 5, 6],
        [5, 6, 7],
        [0, 1, 4],
        [1, 4, 5],
        [2, 3, 6],
        [3, 6, 7],
        [0, 2, 4],
        [2, 4, 6],
        [1, 3, 5],
        [3, 5, 7],
    ];

    fn cube() -> Cube {
        let points: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| x as f32)).collect();
        let all = (0..8).flat_map(|i| (i + 1..8).flat_map(move |j| (j + 1..8).map(move |k| [i, j, k])));
        let triangles: Vec<[u32; 3]> = all.collect();
        let mut ids = BTreeMap::new();
        let mut id = |a: u32, b: u32| {
            let next = ids.len() as u32;
            *ids.entry([a, b]).or_insert(next)
        };
        let edges = triangles.iter().map(|&[i, j, k]| [id(i, j), id(i, k), id(j, k)]).collect();
        let labels = triangles.iter().map(|t| SURFACE.contains(t)).collect();
        let centers = super::super::triangles::barycenters(&points, &SURFACE);
        Cube { points, triangles, edges, labels, centers }
    }

    impl Cube {
        fn candidates(&self) -> Candidates<'_> {
            Candidates {
                points: &self.points,
                triangles: &self.triangles,
                edges: &self.edges,
                at_boundary: &[false; 28],
                labels: &self.labels,
                original_barycenters: &self.centers,
                surface: &self.centers,
            }
        }

        fn loss(&self, objective: FaceObjective) -> impl Fn(&[f32]) -> Term {
            let geometry = face_geometry(&self.candidates(), &objective);
            move |p| total(&face_terms(&self.candidates(), &geometry, &objective, p), p.len())
        }

        fn surface(&self) -> Vec<f32> {
            self.labels.iter().map(|&label| if label { 1.0 } else { 0.0 }).collect()
        }
    }

    #[test]
    fn the_print_is_smallest_for_the_empty_mesh_and_what_trains_for_the_surface() {
        let cube = cube();
        let (empty, surface) = (vec![0.0; 56], cube.surface());
        let [printed, trained] = [FaceObjective::PRINTED, FaceObjective::TRAINED].map(|o| cube.loss(o));
        assert_eq!(printed(&empty).value, 0.0);
        assert!(printed(&surface).value > 0.0);
        assert!(trained(&surface).value < 0.01, "{}", trained(&surface).value);
        assert!(trained(&empty).value > 0.5 && trained(&[1.0; 56]).value > 0.5);
    }

    #[test]
    fn descent_finds_nothing_with_the_print_and_the_surface_with_what_trains() {
        let cube = cube();
        let descend = |objective: FaceObjective| {
            let loss = cube.loss(objective);
            let mut p = vec![0.5f32; 56];
            for _ in 0..400 {
                let gradient = loss(&p).gradient;
                p.iter_mut().zip(gradient).for_each(|(p, g)| *p = (*p - 0.5 * g).clamp(0.0, 1.0));
            }
            p.into_iter().map(|p| p > 0.5).collect::<Vec<_>>()
        };
        assert_eq!(descend(FaceObjective::PRINTED), [false; 56]);
        assert_eq!(descend(FaceObjective::TRAINED), cube.labels);
    }

    #[test]
    fn conflicts_are_found_where_faces_share_no_edge() {
        let cube = cube();
        let found = face_geometry(&cube.candidates(), &FaceObjective::PRINTED);
        let n_common = |[t, u]: [u32; 2]| {
            let [t, u] = [t, u].map(|t| cube.triangles[t as usize]);
            t.iter().filter(|corner| u.contains(corner)).count()
        };
        assert!(!found.collisions.is_empty() && !found.crossings.is_empty() && !found.overlaps.is_empty());
        assert!(found.collisions.iter().all(|&pair| n_common(pair) < 2));
    }

    #[test]
    fn gradients_agree_with_differences() {
        let cube = cube();
        let p: Vec<f32> = uniform(56, 1).iter().map(|p| 0.1 + 0.8 * p).collect();
        for objective in [FaceObjective::PRINTED, FaceObjective::TRAINED] {
            assert_gradient(&p, 1e-3, cube.loss(objective));
        }
    }

    #[test]
    fn threads_change_no_bit() {
        let cube = cube();
        let run = |n| {
            run_on_threads(n, || cube.loss(FaceObjective { reverse: 1.0, ..FaceObjective::TRAINED })(&uniform(56, 2)))
        };
        assert_eq!(run(1), run(3));
    }
}
