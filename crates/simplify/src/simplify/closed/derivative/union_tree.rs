//! Vertices of the collapse as a tree: input vertices and their unions.

use glam::{DMat3, DVec3};
use neural_mesh_collapse::{MergePlace, PassMerge};

use super::algebra::{QuadraticForm, outer, solve, solve_backward, stiffen, stiffen_backward};
use super::kept_volume::KeptVolume;
use super::node_star::NodeStar;
use crate::simplify::closed::collapse::{CollapseEvent, PULL, Placement};

pub(super) struct UnionTree {
    steps: Vec<TreeStep>,
    /// Node of each output vertex: an input vertex, or n_input plus the number of a union.
    roots: Vec<u32>,
}

enum TreeStep {
    Union { nodes: [usize; 2], quadrics: [usize; 2], place: Placement, volume: Option<KeptVolume> },
    Star(NodeStar),
}

pub(super) struct EvaluatedTree {
    quadrics: Vec<QuadraticForm>,
    places: Vec<DVec3>,
}

impl TreeStep {
    /// Returns the merge of a pass of the kernel whose ends' quadrics are `first_quadric` and the next.
    fn of_pass(merge: &PassMerge, first_quadric: usize, node_of: &[usize]) -> Self {
        let nodes = [merge.kept, merge.removed].map(|v| node_of[v as usize]);
        let volume = match &merge.place {
            MergePlace::TowardVolume { border, n_of_kept } => Some(KeptVolume::new(border, *n_of_kept, node_of)),
            _ => None,
        };
        let place = match merge.place {
            MergePlace::Kept => Placement::KeptEnd,
            MergePlace::Removed => Placement::RemovedEnd,
            MergePlace::Middle => Placement::Middle,
            MergePlace::Least | MergePlace::TowardVolume { .. } => Placement::Minimum,
        };
        Self::Union { nodes, quadrics: [first_quadric, first_quadric + 1], place, volume }
    }
}

impl UnionTree {
    /// Builds the tree of a history; `output_of` maps input to output vertices.
    pub fn new(history: &[CollapseEvent], output_of: &[u32]) -> Self {
        let n_input = output_of.len();
        // Current node and quadric of every collapse vertex.
        let mut node_of: Vec<usize> = (0..n_input).collect();
        let mut quadric_of = node_of.clone();
        let (mut n_nodes, mut n_quadrics) = (n_input, n_input);
        let mut steps = Vec::with_capacity(history.len());
        for event in history {
            match event {
                CollapseEvent::Merge(merge) => {
                    // A merge uses the current quadrics of both vertices; a renewal replaces one quadric.
                    let both = [merge.kept, merge.removed].map(|r| r as usize);
                    let (nodes, quadrics) = (both.map(|r| node_of[r]), both.map(|r| quadric_of[r]));
                    steps.push(TreeStep::Union { nodes, quadrics, place: merge.place, volume: None });
                    node_of[both[0]] = n_nodes;
                    n_nodes += 1;
                }
                CollapseEvent::Renewal(renewal) => {
                    steps.push(TreeStep::Star(NodeStar::new(renewal, &node_of)));
                    quadric_of[renewal.vertex as usize] = n_quadrics;
                    n_quadrics += 1;
                }
                CollapseEvent::Pass(merges) => {
                    let ends =
                        merges.iter().flat_map(|merge| [merge.kept, merge.removed].into_iter().zip(&merge.rings));
                    steps.extend(ends.map(|(v, ring)| TreeStep::Star(NodeStar::of_pass(v, ring, &node_of))));
                    for merge in merges {
                        steps.push(TreeStep::of_pass(merge, n_quadrics, &node_of));
                        n_quadrics += 2;
                        node_of[merge.kept as usize] = n_nodes;
                        n_nodes += 1;
                    }
                }
            }
        }
        // Later unions have larger numbers, so the largest node of an output vertex is its root.
        let mut roots = vec![0; output_of.iter().max().map_or(0, |&last| last as usize + 1)];
        for (&node, &output) in node_of.iter().zip(output_of) {
            let root = &mut roots[output as usize];
            *root = (node as u32).max(*root);
        }
        Self { steps, roots }
    }

    pub fn evaluate(&self, positions: &[DVec3], matrices: &[DMat3]) -> EvaluatedTree {
        let form = |(&p, matrix): (&DVec3, &DMat3)| {
            let a = stiffen(matrix, f64::from(PULL));
            QuadraticForm { a, b: a * p }
        };
        let mut quadrics: Vec<QuadraticForm> = positions.iter().zip(matrices).map(form).collect();
        let mut places = positions.to_vec();
        for step in &self.steps {
            match step {
                TreeStep::Star(star) => quadrics.push(star.quadric(&places)),
                TreeStep::Union { nodes: [kept, removed], quadrics: [of_kept, of_gone], place, volume } => {
                    places.push(match place {
                        Placement::Minimum => {
                            let form = quadrics[*of_kept] + quadrics[*of_gone];
                            let least = solve(&form.a, form.b);
                            let ends = [places[*kept], places[*removed]];
                            volume.as_ref().map_or(least, |volume| volume.forward(&places, ends, &form.a, least))
                        }
                        Placement::KeptEnd => places[*kept],
                        Placement::RemovedEnd => places[*removed],
                        Placement::Middle => (places[*kept] + places[*removed]) * 0.5,
                    })
                }
            }
        }
        EvaluatedTree { quadrics, places }
    }

    pub fn outputs(&self, at: &EvaluatedTree) -> Vec<DVec3> {
        self.roots.iter().map(|&node| at.places[node as usize]).collect()
    }

    pub fn backward(
        &self,
        at: &EvaluatedTree,
        positions: &[DVec3],
        gradient: &[DVec3],
        to_positions: &mut [DVec3],
    ) -> Vec<DMat3> {
        let mut to_places = vec![DVec3::ZERO; at.places.len()];
        self.roots.iter().zip(gradient).for_each(|(&node, g)| to_places[node as usize] += *g);
        let to_forms = self.steps_backward(at, &mut to_places, positions.len());
        // `b = A p` at the input, so gradients of `b` reach both matrix and position.
        let to_matrix = |v: usize| {
            let QuadraticForm { a, b } = to_forms[v];
            to_positions[v] += at.quadrics[v].a * b + to_places[v];
            let p = positions[v];
            stiffen_backward(&(a + (outer(b, p) + outer(p, b)) * 0.5), f64::from(PULL))
        };
        (0..positions.len()).map(to_matrix).collect()
    }

    fn steps_backward(&self, at: &EvaluatedTree, to_places: &mut [DVec3], n_input: usize) -> Vec<QuadraticForm> {
        let mut to_quadrics = vec![QuadraticForm::ZERO; at.quadrics.len()];
        let (mut node, mut quadric) = (at.places.len(), at.quadrics.len());
        for step in self.steps.iter().rev() {
            match step {
                TreeStep::Star(star) => {
                    quadric -= 1;
                    star.backward(&at.places, &to_quadrics[quadric], to_places);
                }
                TreeStep::Union { nodes: [kept, removed], quadrics, place, volume } => {
                    node -= 1;
                    let to_place = to_places[node];
                    match place {
                        Placement::Minimum => {
                            let form = at.quadrics[quadrics[0]] + at.quadrics[quadrics[1]];
                            let least = volume.as_ref().map_or(at.places[node], |_| solve(&form.a, form.b));
                            let (to_matrix, to_least) = volume.as_ref().map_or((DMat3::ZERO, to_place), |volume| {
                                volume.backward(&at.places, [*kept, *removed], &form.a, least, to_place, to_places)
                            });
                            let mut to_form = solve_backward(&form.a, least, to_least);
                            to_form.a += to_matrix;
                            quadrics.iter().for_each(|&quadric| to_quadrics[quadric] += to_form);
                        }
                        Placement::KeptEnd => to_places[*kept] += to_place,
                        Placement::RemovedEnd => to_places[*removed] += to_place,
                        Placement::Middle => {
                            [kept, removed].into_iter().for_each(|&child| to_places[child] += to_place * 0.5)
                        }
                    }
                }
            }
        }
        to_quadrics.truncate(n_input);
        to_quadrics
    }
}
