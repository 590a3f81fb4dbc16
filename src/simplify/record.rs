//! Derivative of a result with respect to the positions of the input, so that losses on the result reach the input.

use super::closed::Derivative;

/// Dependence of a result on the input positions, at fixed connectivity.
///
/// All choices are constant: merges, the branch of each clamp, which point of the original belongs to which output
/// face, which vertices the fit moved. Differentiated are the plane quadrics with their areas, normals and boundaries,
/// the placement of each merge, and each step of the fit. Displacements by rounding to `f32`, by foldover repair and by
/// separating vertices are constant.
///
/// Where a flat region fits its planes exactly, the length of the fit's step has a kink and the gradient is one-sided.
/// With the paper's assembly, or where the mesh is unchanged, output vertices are input vertices.
pub struct Record {
    n_input: usize,
    n_output: usize,
    dependence: Dependence,
}

enum Dependence {
    /// Input vertex of each output vertex.
    Selected(Vec<u32>),
    Closed(Box<Derivative>),
}

impl Record {
    pub(super) fn from_selection(n_input: usize, sources: Vec<u32>) -> Self {
        Self { n_input, n_output: sources.len(), dependence: Dependence::Selected(sources) }
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

    /// Returns the output vertex of each input vertex; `None` where it was dropped.
    pub fn output_vertices(&self) -> Vec<Option<u32>> {
        let mut outputs = vec![None; self.n_input];
        match &self.dependence {
            Dependence::Selected(sources) => (0..).zip(sources).for_each(|(x, &v)| outputs[v as usize] = Some(x)),
            // Copies of split vertices come later and overwrite: any of their output vertices will do.
            Dependence::Closed(derivative) => derivative.assignment().for_each(|(v, x)| outputs[v as usize] = Some(x)),
        }
        outputs
    }

    /// Computes the output vertices (n_output x 3) for given input vertices (n_input x 3), at fixed connectivity.
    ///
    /// At the simplified input this gives the result. Farther from it, it approximates a new simplification less and
    /// less.
    ///
    /// # Panics
    /// If there is not one position per input vertex.
    ///
    /// See [`simplify_recorded`](super::simplify_recorded) for an example.
    pub fn positions(&self, input: &[[f32; 3]]) -> Vec<[f32; 3]> {
        singles(&self.positions_in_doubles(&doubles(input)))
    }

    /// Computes [`Record::positions`] in double precision, smooth enough for second differences.
    ///
    /// # Panics
    /// As [`Record::positions`].
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// use neural_mesh::{mesh::shapes, simplify::{Options, Target, simplify_recorded}};
    /// let mesh = shapes::icosphere(2);
    /// let options = Options::new(Target::Vertices(40));
    /// let (_, record) = simplify_recorded(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    /// let input: Vec<[f64; 3]> = mesh.positions().iter().map(|p| p.map(f64::from)).collect();
    /// // Slope of one output coordinate with respect to one input coordinate, by differences and by the gradient.
    /// let mut gradient = vec![[0.0; 3]; 40];
    /// gradient[0][0] = 1.0;
    /// let to_input = record.backward_in_doubles(&input, &gradient);
    /// let vertex = record.output_vertices().iter().position(|&x| x == Some(0)).unwrap();
    /// let at = |step: f64| {
    ///     let mut moved = input.clone();
    ///     moved[vertex][0] += step;
    ///     record.positions_in_doubles(&moved)[0][0]
    /// };
    /// assert!(((at(1e-6) - at(-1e-6)) / 2e-6 - to_input[vertex][0]).abs() < 1e-6);
    /// ```
    pub fn positions_in_doubles(&self, input: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert_eq!(input.len(), self.n_input, "one position per input vertex");
        match &self.dependence {
            Dependence::Selected(sources) => sources.iter().map(|&v| input[v as usize]).collect(),
            Dependence::Closed(derivative) => derivative.positions(input),
        }
    }

    /// Returns the gradient with respect to the input vertices (n_input x 3).
    ///
    /// Multiplies that with respect to the output vertices (n_output x 3) by the Jacobian of
    /// [`Record::positions`] at `input`.
    ///
    /// # Panics
    /// If there is not one position per input vertex and one gradient per output vertex.
    ///
    /// See [`simplify_recorded`](super::simplify_recorded) for an example.
    pub fn backward(&self, input: &[[f32; 3]], gradient: &[[f32; 3]]) -> Vec<[f32; 3]> {
        singles(&self.backward_in_doubles(&doubles(input), &doubles(gradient)))
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
            Dependence::Selected(sources) => scatter_gradient(self.n_input, sources, gradient),
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

fn doubles(points: &[[f32; 3]]) -> Vec<[f64; 3]> {
    points.iter().map(|p| p.map(f64::from)).collect()
}

fn singles(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|x| x as f32)).collect()
}
