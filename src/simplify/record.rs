//! The result as a smooth function of the input's vertices, so that losses on the result reach the input.

use super::closed::Derivative;

/// How a result depends on the positions of the input, for the connectivity that was chosen.
///
/// Constant are all choices: which vertices became one, how each was placed (which branch of a clamp was taken), which
/// point of the original belongs where in which output face, which vertices the fit moved. Differentiated are the plane
/// quadrics with their areas, normals and boundaries, the placement of every region and of every union that the collapse
/// made, and each step of the fit. What rounding to `f32`, opening folds and keeping vertices apart added is kept as
/// it was.
///
/// Where a flat part fits its planes exactly, the length of a fit's step has a kink; the gradient is then of one side.
/// With the paper's assembly, or where nothing was to be done, output vertices are input vertices.
pub struct Record {
    n_input: usize,
    n_output: usize,
    way: Way,
}

enum Way {
    /// The input vertex whose position each output vertex has.
    Selected(Vec<u32>),
    Closed(Box<Derivative>),
}

impl Record {
    pub(super) fn selected(n_input: usize, sources: Vec<u32>) -> Self {
        Self { n_input, n_output: sources.len(), way: Way::Selected(sources) }
    }

    pub(super) fn closed(n_input: usize, n_output: usize, derivative: Derivative) -> Self {
        Self { n_input, n_output, way: Way::Closed(Box::new(derivative)) }
    }

    /// Vertices of the input, of which [`Record::positions`] takes one position each.
    pub fn n_input(&self) -> usize {
        self.n_input
    }

    /// Vertices of the result.
    pub fn n_output(&self) -> usize {
        self.n_output
    }

    /// For each input vertex the output vertex that it went to; `None` where it went nowhere.
    pub fn output_vertices(&self) -> Vec<Option<u32>> {
        let mut outputs = vec![None; self.n_input];
        match &self.way {
            Way::Selected(sources) => (0..).zip(sources).for_each(|(x, &v)| outputs[v as usize] = Some(x)),
            Way::Closed(derivative) => derivative.assignment().for_each(|(v, x)| outputs[v as usize] = Some(x)),
        }
        outputs
    }

    /// The output vertices (n_output x 3) for these input vertices (n_input x 3), the connectivity as it was.
    ///
    /// For the vertices that were simplified these are the vertices of the result; the nearer the others are to those,
    /// the better they stand for what simplifying them would give.
    ///
    /// # Panics
    /// When there is not one position per input vertex.
    ///
    /// See [`simplify_recorded`](super::simplify_recorded) for an example.
    pub fn positions(&self, input: &[[f32; 3]]) -> Vec<[f32; 3]> {
        singles(&self.positions_in_doubles(&doubles(input)))
    }

    /// As [`Record::positions`], in double precision: a function that is smooth enough for second differences.
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
    /// // The slope of the first coordinate of the result when a coordinate of the input moves, by differences and by the gradient.
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
        match &self.way {
            Way::Selected(sources) => sources.iter().map(|&v| input[v as usize]).collect(),
            Way::Closed(derivative) => derivative.positions(input),
        }
    }

    /// The gradient of a loss to the input vertices (n_input x 3) from its gradient to the output vertices
    /// (n_output x 3): the product of the latter with the Jacobian of [`Record::positions`] at `input`.
    ///
    /// # Panics
    /// When there is not one position per input vertex and one gradient per output vertex.
    ///
    /// See [`simplify_recorded`](super::simplify_recorded) for an example.
    pub fn backward(&self, input: &[[f32; 3]], gradient: &[[f32; 3]]) -> Vec<[f32; 3]> {
        singles(&self.backward_in_doubles(&doubles(input), &doubles(gradient)))
    }

    /// As [`Record::backward`], in double precision.
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
        match &self.way {
            Way::Selected(sources) => scattered(self.n_input, sources, gradient),
            Way::Closed(derivative) => derivative.backward(input, gradient),
        }
    }
}

fn scattered(n_input: usize, sources: &[u32], gradient: &[[f64; 3]]) -> Vec<[f64; 3]> {
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
