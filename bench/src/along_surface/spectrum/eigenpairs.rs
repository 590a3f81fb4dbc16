//! The lowest eigenpairs of a Laplacian.

use nalgebra::{DMatrix, DMatrixView};

use super::components::{Component, components};
use super::factor::Factor;
use super::lanczos;
use super::symmetric::symmetric_eigenpairs;
use crate::along_surface::laplacian::Laplacian;
use neural_mesh::parallel;

// Components with at most this many vertices, or at most three per wanted pair, are solved as dense matrices.
const DENSE: usize = 400;

/// The lowest eigenpairs of `L u = lambda M u`.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    /// Eigenvalues, ascending and non-negative, n_pairs.
    pub values: Vec<f64>,
    // Eigenfunctions as columns, orthonormal under the masses, n x n_pairs.
    functions: DMatrix<f64>,
}

impl Eigenpairs {
    /// Computes the `n_pairs` lowest eigenpairs, at most n; `None` where the solver fails.
    ///
    /// Some pairs of an eigenvalue with a multiplicity above eight may be missed.
    pub fn compute_lowest(laplacian: &Laplacian, n_pairs: usize) -> Option<Self> {
        let n = laplacian.mass.len();
        let mut components = components(laplacian);
        // Each component has one constant function, so `n_pairs` components suffice.
        components.truncate(n_pairs);
        let solved = solve_components(&components, n_pairs.min(n))?;
        // A single component's functions need no merging.
        if let [whole] = &solved[..] {
            return Some(whole.clone());
        }
        let chosen = select_lowest(&solved, n_pairs.min(n));
        let mut functions = DMatrix::zeros(n, chosen.len());
        for (pair, &(component, index)) in chosen.iter().enumerate() {
            for (&at, &u) in components[component].vertices.iter().zip(solved[component].function(index)) {
                functions[(at as usize, pair)] = u;
            }
        }
        Some(Self {
            values: chosen.iter().map(|&(component, index)| solved[component].values[index]).collect(),
            functions,
        })
    }

    /// Returns an eigenfunction at the vertices, n.
    pub fn function(&self, pair: usize) -> &[f64] {
        self.functions.column(pair).data.into_slice()
    }

    pub(super) fn first_functions(&self, n_pairs: usize) -> DMatrixView<'_, f64> {
        self.functions.columns(0, n_pairs)
    }

    /// Returns the mean spacing of the eigenvalues.
    pub fn spacing(&self) -> f64 {
        self.values.last().map_or(0.0, |last| last / (self.values.len() - 1).max(1) as f64)
    }
}

fn solve_components(components: &[Component], n_pairs: usize) -> Option<Vec<Eigenpairs>> {
    let area: f64 = components.iter().map(Component::area).sum();
    // By Weyl's law a component's number of eigenvalues is proportional to its area.
    let first = |component: &Component| (1 + (n_pairs as f64 * component.area() / area).ceil() as usize).min(n_pairs);
    // With at least as many components as pairs, their constant functions suffice.
    let first = |component: &Component| if components.len() >= n_pairs { 1 } else { first(component) };
    let solved = parallel::each(components, |component| solve_component(component, first(component)));
    let mut solved: Vec<Eigenpairs> = solved.into_iter().collect::<Option<_>>()?;
    loop {
        // Components are solved for more pairs until the lowest of all are certainly among them.
        let chosen = select_lowest(&solved, n_pairs);
        let is_full = chosen.len() == n_pairs;
        let highest =
            chosen.last().filter(|_| is_full).map_or(f64::INFINITY, |&(component, i)| solved[component].values[i]);
        let more = |(component, pairs): (&Component, &mut Eigenpairs)| {
            let known = pairs.values.len();
            let is_short = known < component.vertices.len().min(n_pairs) && pairs.values[known - 1] < highest;
            // The component's highest known eigenvalue is among the lowest of all, so its next ones may be, too.
            if is_short {
                *pairs = solve_component(component, (2 * known).min(n_pairs))?;
            }
            Some(is_short)
        };
        let grown = parallel::each(components.iter().zip(&mut solved), more);
        if !grown.into_iter().collect::<Option<Vec<bool>>>()?.contains(&true) {
            return Some(solved);
        }
    }
}

fn select_lowest(solved: &[Eigenpairs], n_pairs: usize) -> Vec<(usize, usize)> {
    let of_piece = |component: usize| (0..solved[component].values.len()).map(move |index| (component, index));
    let mut all: Vec<(usize, usize)> = (0..solved.len()).flat_map(of_piece).collect();
    let value = |&(component, index): &(usize, usize)| solved[component].values[index];
    all.sort_by(|a, b| value(a).total_cmp(&value(b)));
    all.truncate(n_pairs);
    all
}

fn solve_component(component: &Component, n_pairs: usize) -> Option<Eigenpairs> {
    let n_pairs = n_pairs.min(component.vertices.len());
    if n_pairs == 1 {
        let height = 1.0 / component.area().sqrt();
        return Some(Eigenpairs {
            values: vec![0.0],
            functions: DMatrix::from_element(component.vertices.len(), 1, height),
        });
    }
    let roots: Vec<f64> = component.mass.iter().map(|mass| mass.sqrt()).collect();
    let solver = if roots.len() <= DENSE.max(3 * n_pairs) { solve_dense } else { solve_sparse };
    let (mut values, mut functions) = solver(component, &roots, n_pairs)?;
    scale_rows(&mut functions, &roots.iter().map(|root| 1.0 / root).collect::<Vec<_>>());
    values.iter_mut().for_each(|value| *value = value.max(0.0));
    Some(Eigenpairs { values, functions })
}

fn solve_dense(component: &Component, roots: &[f64], n_pairs: usize) -> Option<(Vec<f64>, DMatrix<f64>)> {
    // The matrix is `M^-1/2 L M^-1/2`.
    let mut matrix = DMatrix::zeros(roots.len(), roots.len());
    for &([i, j], weight) in &component.edges {
        let (i, j) = (i as usize, j as usize);
        matrix[(i, i)] += weight / (roots[i] * roots[i]);
        matrix[(j, j)] += weight / (roots[j] * roots[j]);
        matrix[(j, i)] -= weight / (roots[i] * roots[j]);
    }
    let (mut values, functions) = symmetric_eigenpairs(matrix)?;
    values.truncate(n_pairs);
    Some((values, functions.columns(0, n_pairs).into_owned()))
}

fn solve_sparse(component: &Component, roots: &[f64], n_pairs: usize) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let shift = 4.0 * std::f64::consts::PI / component.area();
    let factor = Factor::new(&component.mass, &component.edges, 1.0, shift)?;
    // The lowest pairs are the largest of `M^1/2 (L + s M)^-1 M^1/2`.
    let apply = |block: &mut DMatrix<f64>| {
        scale_rows(block, roots);
        factor.solve_in_place(block);
        scale_rows(block, roots);
    };
    let (inverse, functions) = lanczos::largest_eigenpairs(roots.len(), n_pairs, apply)?;
    Some((inverse.into_iter().map(|value| 1.0 / value - shift).collect(), functions))
}

fn scale_rows(matrix: &mut DMatrix<f64>, by: &[f64]) {
    for mut column in matrix.column_iter_mut() {
        column.iter_mut().zip(by).for_each(|(value, factor)| *value *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::{TriMesh, shapes};

    fn lowest(mesh: &TriMesh, n_pairs: usize) -> Eigenpairs {
        Eigenpairs::compute_lowest(&Laplacian::new(mesh).unwrap(), n_pairs).unwrap()
    }

    // Eigenvalues are l (l + 1), each 2 l + 1 times.
    #[test]
    fn eigenvalues_of_the_sphere() {
        let values = lowest(&shapes::icosphere(4), 49).values;
        let wanted = (0..7).flat_map(|l| std::iter::repeat_n(f64::from(l * (l + 1)), 2 * l as usize + 1));
        for (value, wanted) in values.iter().zip(wanted) {
            assert!((value - wanted).abs() <= 0.02 * wanted + 1e-9, "{value} {wanted}");
        }
    }

    // With Neumann conditions the eigenvalues are pi^2 (i^2 + j^2).
    #[test]
    fn eigenvalues_of_the_square() {
        let values = lowest(&shapes::grid(40, 40), 20).values;
        let mut wanted: Vec<f64> = (0..40).map(|i| f64::from(i / 6 * (i / 6) + i % 6 * (i % 6))).collect();
        wanted.sort_by(f64::total_cmp);
        for (value, wanted) in values.iter().zip(wanted.iter().map(|w| w * std::f64::consts::PI.powi(2))) {
            assert!((value - wanted).abs() <= 0.01 * wanted + 1e-9, "{value} {wanted}");
        }
    }

    #[test]
    fn functions_are_eigenfunctions_and_orthonormal() {
        let laplacian = Laplacian::new(&shapes::wavy_sphere(3, 20.0)).unwrap();
        assert!(laplacian.mass.len() > DENSE);
        let pairs = Eigenpairs::compute_lowest(&laplacian, 60).unwrap();
        for k in [0, 1, 30, 59] {
            let u = pairs.function(k);
            let mut left: Vec<f64> = u.iter().zip(&laplacian.mass).map(|(u, m)| -pairs.values[k] * m * u).collect();
            for &([i, j], weight) in &laplacian.edges {
                let flow = weight * (u[i as usize] - u[j as usize]);
                left[i as usize] += flow;
                left[j as usize] -= flow;
            }
            let error = left.iter().zip(&laplacian.mass).map(|(r, m)| r * r / m).sum::<f64>().sqrt();
            assert!(error < 1e-5 * (pairs.values[k] + 1.0), "{k} {error}");
            let inner = |l: usize| u.iter().zip(pairs.function(l)).zip(&laplacian.mass).map(|((a, b), m)| a * b * m);
            for l in 0..60 {
                assert!((inner(l).sum::<f64>() - f64::from(u8::from(k == l))).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn dense_and_sparse_agree() {
        let laplacian = Laplacian::new(&shapes::wavy_sphere(3, 20.0)).unwrap();
        let roots: Vec<f64> = laplacian.mass.iter().map(|mass| mass.sqrt()).collect();
        let component = &components(&laplacian)[0];
        let (dense, _) = solve_dense(component, &roots, 60).unwrap();
        let (sparse, _) = solve_sparse(component, &roots, 60).unwrap();
        assert!(dense.iter().zip(&sparse).all(|(a, b)| (a - b).abs() < 1e-7 * (a + 1.0)), "{dense:?} {sparse:?}");
    }

    // Twenty equal spheres have each eigenvalue of one sphere twenty times.
    #[test]
    fn equal_components_have_equal_eigenvalues() {
        let sphere = shapes::icosphere(3);
        let spheres = shapes::unite((0..20).map(|i| shapes::place(&sphere, |[x, y, z]| [x + 4.0 * i as f32, y, z])));
        let one = lowest(&sphere, 12).values;
        let laplacian = Laplacian::new(&spheres).unwrap();
        let all = Eigenpairs::compute_lowest(&laplacian, 200).unwrap();
        for (pair, value) in all.values.iter().enumerate() {
            let wanted = one[pair / 20];
            assert!((value - wanted).abs() < 1e-4 * (wanted + 1e-2), "{pair} {value} {wanted}");
        }
        for k in [0, 19, 20, 79, 150, 199] {
            for l in [0, 20, 42, 150, 199] {
                let (u, v) = (all.function(k), all.function(l));
                let inner: f64 = u.iter().zip(v).zip(&laplacian.mass).map(|((a, b), m)| a * b * m).sum();
                assert!((inner - f64::from(u8::from(k == l))).abs() < 1e-9, "{k} {l} {inner}");
            }
        }
    }

    #[test]
    fn largest_components_have_the_first_constant_functions() {
        let boxes = Laplacian::new(&shapes::many_boxes(6)).unwrap();
        let pairs = Eigenpairs::compute_lowest(&boxes, 4).unwrap();
        assert_eq!(pairs.values, [0.0; 4]);
        assert_eq!(Eigenpairs::compute_lowest(&boxes, usize::MAX).unwrap().values.len(), boxes.mass.len());
        assert!(Eigenpairs::compute_lowest(&boxes, 0).unwrap().values.is_empty());
    }
}
