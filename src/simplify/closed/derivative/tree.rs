//! The vertices of regions and of their unions: minima of summed quadrics, or what took their place.
//!
//! Every merge of the collapse is a node over two older ones. Its vertex is the minimum of their quadrics together, or the vertex
//! of one of the two, or the middle between them, as it was when the edge went. A quadric is one of planes around a node, at the
//! places that its neighbours had when it was summed; where every vertex is a region, the first ones are those of the input.

use glam::{DMat3, DVec3};

use super::algebra::{Form, outer, solve, solve_backward, stiffened, stiffened_backward, trace};
use super::star::Star;
use crate::simplify::closed::cluster::placement::{Case, FIRM_PULL, PULL};
use crate::simplify::closed::collapse::{Event, Place};

/// Regions and their unions, constant.
pub(super) struct Tree {
    /// The region of each input vertex.
    region: Vec<u32>,
    /// How the vertex of each region was placed.
    cases: Vec<Case>,
    /// What happened to them, older steps first.
    steps: Vec<Step>,
    /// For each output vertex its node: a region, or n_regions + the number of a union.
    roots: Vec<u32>,
}

/// A step of the collapse.
enum Step {
    /// A new node: a union of two, by a quadric of each.
    Union {
        /// The older nodes.
        nodes: [usize; 2],
        /// Their quadrics.
        quadrics: [usize; 2],
        /// How its vertex was placed.
        place: Place,
    },
    /// A new quadric.
    Star(Star),
}

/// A tree at given positions.
pub(super) struct Grown {
    /// Sums over the regions.
    forms: Vec<Form>,
    /// The quadrics that the collapse had: those of the regions first, then one for each star.
    quadrics: Vec<Form>,
    /// Vertices of all nodes.
    places: Vec<DVec3>,
    /// Weight of each region's vertices, and the sum of their weighted positions.
    moments: Vec<(f64, DVec3)>,
}

impl Tree {
    /// The tree of what happened; `output_of` names the output vertex of each region.
    pub fn new(region: Vec<u32>, cases: Vec<Case>, history: &[Event], output_of: &[u32]) -> Self {
        let n_regions = cases.len();
        // Of every vertex of the collapse its node and its quadric.
        let mut node_of: Vec<usize> = (0..n_regions).collect();
        let mut quadric_of = node_of.clone();
        let (mut n_nodes, mut n_quadrics) = (n_regions, n_regions);
        let mut steps = Vec::with_capacity(history.len());
        for event in history {
            match event {
                Event::Merge(merge) => {
                    let both = [merge.kept, merge.gone].map(|r| r as usize);
                    let (nodes, quadrics) = (both.map(|r| node_of[r]), both.map(|r| quadric_of[r]));
                    steps.push(Step::Union { nodes, quadrics, place: merge.place });
                    node_of[both[0]] = n_nodes;
                    n_nodes += 1;
                }
                Event::Renewal(renewal) => {
                    steps.push(Step::Star(Star::new(renewal, &node_of)));
                    quadric_of[renewal.vertex as usize] = n_quadrics;
                    n_quadrics += 1;
                }
            }
        }
        // The last union of a family stands for it, and later unions have larger numbers.
        let mut roots = vec![0; output_of.iter().max().map_or(0, |&last| last as usize + 1)];
        for (&node, &output) in node_of.iter().zip(output_of) {
            let root = &mut roots[output as usize];
            *root = (node as u32).max(*root);
        }
        Self { region, cases, steps, roots }
    }

    /// Computes quadrics and vertices from those of the input.
    pub fn grow(&self, positions: &[DVec3], matrices: &[DMat3]) -> Grown {
        let n_regions = self.cases.len();
        let mut forms = vec![Form::ZERO; n_regions];
        let mut moments = vec![(0.0, DVec3::ZERO); n_regions];
        for ((&r, &p), matrix) in self.region.iter().zip(positions).zip(matrices) {
            let a = stiffened(matrix, f64::from(PULL));
            forms[r as usize] += Form { a, b: a * p };
            let (weight, sum) = &mut moments[r as usize];
            *weight += trace(matrix);
            *sum += p * trace(matrix);
        }
        let place = |r: usize| place(&self.cases[r], &forms[r], mean(moments[r]), positions);
        let mut places: Vec<DVec3> = (0..n_regions).map(place).collect();
        let mut quadrics = forms.clone();
        for step in &self.steps {
            match step {
                Step::Star(star) => quadrics.push(star.quadric(&places)),
                Step::Union { nodes: [kept, gone], quadrics: [of_kept, of_gone], place } => places.push(match place {
                    Place::Minimum => {
                        let form = quadrics[*of_kept] + quadrics[*of_gone];
                        solve(&form.a, form.b)
                    }
                    Place::Kept => places[*kept],
                    Place::Gone => places[*gone],
                    Place::Middle => (places[*kept] + places[*gone]) * 0.5,
                }),
            }
        }
        Grown { forms, quadrics, places, moments }
    }

    /// The output vertices.
    pub fn outputs(&self, at: &Grown) -> Vec<DVec3> {
        self.roots.iter().map(|&node| at.places[node as usize]).collect()
    }

    /// Adds to `to_positions` what gradients to the output vertices come to, and returns those to the matrices.
    pub fn backward(
        &self,
        at: &Grown,
        positions: &[DVec3],
        matrices: &[DMat3],
        gradient: &[DVec3],
        to_positions: &mut [DVec3],
    ) -> Vec<DMat3> {
        let mut to_places = vec![DVec3::ZERO; at.places.len()];
        self.roots.iter().zip(gradient).for_each(|(&node, g)| to_places[node as usize] += *g);
        let mut to_forms = self.steps_backward(at, &mut to_places);
        let mut to_moments = vec![(0.0, DVec3::ZERO); self.cases.len()];
        for (r, case) in self.cases.iter().enumerate() {
            let (to_form, to_mean) = match *case {
                Case::Vertex(v) => {
                    to_positions[v as usize] += to_places[r];
                    (Form::ZERO, DVec3::ZERO)
                }
                Case::Minimum => (solve_backward(&at.forms[r].a, at.places[r], to_places[r]), DVec3::ZERO),
                Case::Firm => firm_backward(&at.forms[r], mean(at.moments[r]), at.places[r], to_places[r]),
                Case::Offset(_) => (Form::ZERO, to_places[r]),
            };
            to_forms[r] += to_form;
            let (weight, _) = at.moments[r];
            let weight = weight.max(f64::MIN_POSITIVE);
            to_moments[r] = (-to_mean.dot(mean(at.moments[r])) / weight, to_mean / weight);
        }
        let vertices = self.region.iter().zip(positions).zip(matrices).zip(to_positions);
        let to_matrix = |(((&r, &p), matrix), to_position): (((&u32, &DVec3), &DMat3), &mut DVec3)| {
            let (Form { a, b }, (to_weight, to_sum)) = (to_forms[r as usize], to_moments[r as usize]);
            *to_position += stiffened(matrix, f64::from(PULL)) * b + to_sum * trace(matrix);
            let to_stiffened = a + (outer(b, p) + outer(p, b)) * 0.5;
            stiffened_backward(&to_stiffened, f64::from(PULL)) + DMat3::IDENTITY * (to_weight + to_sum.dot(p))
        };
        vertices.map(to_matrix).collect()
    }

    /// Hands gradients down from unions and stars to what they are made of, newest first; returns those to the sums over the
    /// regions.
    fn steps_backward(&self, at: &Grown, to_places: &mut [DVec3]) -> Vec<Form> {
        let mut to_quadrics = vec![Form::ZERO; at.quadrics.len()];
        let (mut node, mut quadric) = (at.places.len(), at.quadrics.len());
        for step in self.steps.iter().rev() {
            match step {
                Step::Star(star) => {
                    quadric -= 1;
                    star.backward(&at.places, &to_quadrics[quadric], to_places);
                }
                Step::Union { nodes: [kept, gone], quadrics, place } => {
                    node -= 1;
                    let to_place = to_places[node];
                    match place {
                        Place::Minimum => {
                            let form = at.quadrics[quadrics[0]] + at.quadrics[quadrics[1]];
                            let to_form = solve_backward(&form.a, at.places[node], to_place);
                            quadrics.iter().for_each(|&quadric| to_quadrics[quadric] += to_form);
                        }
                        Place::Kept => to_places[*kept] += to_place,
                        Place::Gone => to_places[*gone] += to_place,
                        Place::Middle => [kept, gone].into_iter().for_each(|&child| to_places[child] += to_place * 0.5),
                    }
                }
            }
        }
        to_quadrics.truncate(at.forms.len());
        to_quadrics
    }
}

fn mean((weight, sum): (f64, DVec3)) -> DVec3 {
    sum / weight.max(f64::MIN_POSITIVE)
}

fn place(case: &Case, form: &Form, mean: DVec3, positions: &[DVec3]) -> DVec3 {
    match *case {
        Case::Vertex(v) => positions[v as usize],
        Case::Minimum => solve(&form.a, form.b),
        Case::Firm => {
            let pull = FIRM_PULL * trace(&form.a);
            solve(&stiffened(&form.a, FIRM_PULL), form.b + mean * pull)
        }
        Case::Offset(offset) => mean + offset,
    }
}

/// Gradients to the quadric and to the mean of a region whose vertex is pulled to that mean.
fn firm_backward(form: &Form, mean: DVec3, place: DVec3, gradient: DVec3) -> (Form, DVec3) {
    let Form { a, b } = solve_backward(&stiffened(&form.a, FIRM_PULL), place, gradient);
    let to_matrix = stiffened_backward(&a, FIRM_PULL) + DMat3::IDENTITY * (FIRM_PULL * b.dot(mean));
    (Form { a: to_matrix, b }, b * (FIRM_PULL * trace(&form.a)))
}
