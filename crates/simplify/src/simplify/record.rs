//! Derivative of a result with respect to the input positions.

use crate::mesh::TriMesh;

use super::closed::Derivative;
use super::network_scores::edge_graph;
use super::paper::{NO_SAMPLE, assign_to_samples};

/// Dependence of a result on the input positions, at fixed connectivity.
///
/// Quadrics, placements and steps of the fit are differentiated. All choices, and displacements by rounding and
/// repairs, are constant. If a flat region fits its planes exactly, the gradient is one-sided.
pub struct Record {
    n_input: usize,
    n_output: usize,
    dependence: Dependence,
}

enum Dependence {
    /// Kept vertices of the input, and the one of these that is nearest to each input vertex along the edges.
    Selected {
        sources: Vec<u32>,
        regions: Vec<u32>,
    },
    Closed(Box<Derivative>),
}

impl Record {
    /// Records a result whose vertices are the `sources` among those of `mesh`.
    pub(super) fn from_selection(mesh: &TriMesh, sources: Vec<u32>) -> Self {
        let regions = assign_to_samples(mesh.positions(), &edge_graph(mesh), &sources);
        let (n_input, n_output) = (mesh.positions().len(), sources.len());
        Self { n_input, n_output, dependence: Dependence::Selected { sources, regions } }
    }

    pub(super) fn from_derivative(n_input: usize, n_output: usize, derivative: Derivative) -> Self {
        Self { n_input, n_output, dependence: Dependence::Closed(Box::new(derivative)) }
    }

    /// Returns the number of input vertices.
    pub fn n_input(&self) -> usize {
        self.n_input
    }

    /// Returns the number of output vertices.
    pub fn n_output(&self) -> usize {
        self.n_output
    }

    /// Returns the output vertex of each input vertex; `None` if it was dropped.
    ///
    /// With the paper's assembly, that is the nearest one along the edges of the mesh.
    pub fn output_vertices(&self) -> Vec<Option<u32>> {
        let mut outputs = vec![None; self.n_input];
        match &self.dependence {
            Dependence::Selected { regions, .. } => {
                outputs = regions.iter().map(|&x| Some(x).filter(|&x| x != NO_SAMPLE)).collect();
            }
            // Copies of split vertices come later and overwrite, since any of their output vertices will do.
            Dependence::Closed(derivative) => derivative.assignment().for_each(|(v, x)| outputs[v as usize] = Some(x)),
        }
        outputs
    }

    /// Computes the output vertices (n_output x 3) for given input vertices (n_input x 3), at fixed connectivity.
    ///
    /// # Panics
    /// If there is not one position per input vertex.
    ///
    /// See [`simplify_recorded`](super::simplify_recorded) for an example.
    pub fn positions(&self, input: &[[f32; 3]]) -> Vec<[f32; 3]> {
        to_singles(&self.positions_in_doubles(&to_doubles(input)))
    }

    /// Computes [`Record::positions`] in double precision.
    ///
    /// # Panics
    /// As [`Record::positions`].
    ///
    /// ```
    /// # use neural_mesh_simplify as neural_mesh;
    /// use std::ops::ControlFlow;
    /// use neural_mesh::{mesh::shapes, simplify::{Options, Size, simplify_recorded}};
    /// let mesh = shapes::icosphere(2);
    /// let options = Options::new(Size::Vertices(40));
    /// let (_, record) = simplify_recorded(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    /// let input: Vec<[f64; 3]> = mesh.positions().iter().map(|p| p.map(f64::from)).collect();
    /// // Slope of one output coordinate with respect to one input coordinate, by differences and by the gradient.
    /// let mut gradient = vec![[0.0; 3]; 40];
    /// gradient[0][0] = 1.0;
    /// let to_input = record.backward_in_doubles(&input, &gradient);
    /// let vertex = record.output_vertices().iter().position(|&x| x == Some(0)).unwrap();
    /// let move_input = |step: f64| {
    ///     let mut moved = input.clone();
    ///     moved[vertex][0] += step;
    ///     record.positions_in_doubles(&moved)[0][0]
    /// };
    /// assert!(((move_input(1e-6) - move_input(-1e-6)) / 2e-6 - to_input[vertex][0]).abs() < 1e-6);
    /// ```
    pub fn positions_in_doubles(&self, input: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert_eq!(input.len(), self.n_input, "one position per input vertex");
        match &self.dependence {
            Dependence::Selected { sources, .. } => sources.iter().map(|&v| input[v as usize]).collect(),
            Dependence::Closed(derivative) => derivative.positions(input),
        }
    }

    /// Converts a gradient with respect to output vertices (n_output x 3) to one with respect to input vertices
    /// (n_input x 3).
    ///
    /// # Panics
    /// If there is not one position per input vertex and one gradient per output vertex.
    ///
    /// See [`simplify_recorded`](super::simplify_recorded) for an example.
    pub fn backward(&self, input: &[[f32; 3]], gradient: &[[f32; 3]]) -> Vec<[f32; 3]> {
        to_singles(&self.backward_in_doubles(&to_doubles(input), &to_doubles(gradient)))
    }

    /// Computes [`Record::backward`] in double precision.
    ///
    /// # Panics
    /// As [`Record::backward`].
    ///
    /// See [`Record::positions_in_doubles`] for an example.
    pub fn backward_in_doubles(&self, input: &[[f64; 3]], gradient: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert_eq!(
            [input.len(), gradient.len()],
            [self.n_input, self.n_output],
            "one position, one gradient per vertex"
        );
        match &self.dependence {
            Dependence::Selected { sources, .. } => scatter_gradient(self.n_input, sources, gradient),
            Dependence::Closed(derivative) => derivative.backward(input, gradient),
        }
    }
}

fn scatter_gradient(n_input: usize, sources: &[u32], gradient: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut to_input = vec![[0.0; 3]; n_input];
    for (&v, g) in sources.iter().zip(gradient) {
        to_input[v as usize].iter_mut().zip(g).for_each(|(sum, g)| *sum += g);
    }
    to_input
}

fn to_doubles(points: &[[f32; 3]]) -> Vec<[f64; 3]> {
    points.iter().map(|p| p.map(f64::from)).collect()
}

fn to_singles(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|x| x as f32)).collect()
}
